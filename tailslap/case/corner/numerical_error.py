"""Numerical error of a run by companions, the same vehicle on other meshes, judged in the manner of ASME V&V 20.

Two meshes bound the distance to the limit of fine meshes by a safety factor and the order of the support, three by the
order that they show. Companions have the damping and the constraint of the run, whose errors are added: both are in
proportion to what the plate's flexibility changes. Two oscillations may agree at one instant by chance, so that runs
are compared over the motion as well.
"""

import itertools
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from postprocess.comparison.quantities import largest
from tailslap.case.corner import corner_plan, static_models

RINGING, CORRUPTED = 2e-3, 0.1
"""Friction by ringing that is allowed, and at which a run is given up."""

FLOOR, FRACTION = 5e-4, 0.25
"""Numerical error that is allowed whatever the plate, and as a fraction of what its flexibility changes."""

SAFETY = 1.5
"""Safety factor on the distance to the limit: between the 1.25 and 3 of ASME V&V 20, since the order is a lower one."""

ORDERS = 0.5, 1.0, 2.0
"""Order of convergence at a point support, which has no limit in theory, or a patch that no companion resolves; at a
patch; and of smooth solutions."""

RESOLVED = 2.0
"""Elements along a patch from which on a mesh resolves it."""

LATE, LAST = 0.1, 9
"""Part of the motion over which two runs are compared, and number of the last such part."""

VELOCITIES = ("v_gx", "v_gy", "omega")

Histories = tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]]


@dataclass(frozen=True)
class Companion:
    """A run of the same plate on another mesh.

    Attributes
    ----------
    mesh : str
        In words.
    refinement : float
        Elements along a side over those of the run [-], twice as many for elements of higher order.
    difference : dict of str to float
        Of its five quantities from the rigid motion; empty where it came to no result.
    apart : float
        Distance between the velocities of both runs, see `distance_in_motion`.
    """

    mesh: str
    refinement: float
    difference: Mapping[str, float]
    apart: float = 0.0


@dataclass(frozen=True)
class NumericalError:
    """Relative errors of the five quantities, the largest of them, at most; mesh is NaN without companions.

    rounding: of the time step and of the sums over all steps. flexibility: what the plate's own flexibility changes.
    """

    mesh: float
    contact_spring: float
    damping: float
    rounding: float
    flexibility: float

    @property
    def total(self) -> float:
        """All of them together."""
        return self.mesh + self.contact_spring + self.damping + self.rounding

    @property
    def allowed(self) -> float:
        """The limit of the total."""
        return FLOOR + FRACTION * self.flexibility


def numerical_error(
    fe_plan: corner_plan.CornerPlan, difference: Mapping[str, float], companions: Sequence[Companion]
) -> NumericalError:
    """The error of a run with these five differences from the rigid motion, empty if it came to no result."""
    deflection, steps = fe_plan.deflection_ratio, fe_plan.expected_steps
    flexibility = max(deflection, *(largest(each.difference) for each in companions if each.difference), 0.0)
    along, corner = fe_plan.plate.counts[0], fe_plan.case.scene.corner
    patch = (corner.patch_length or 0.0) * along / fe_plan.case.scene.vehicle.length
    order = ORDERS[any(patch * each.refinement >= RESOLVED for each in companions)]
    return NumericalError(
        mesh=mesh_error(difference, companions, order) if companions else math.nan,
        contact_spring=SAFETY * flexibility * fe_plan.spring_ratio / deflection,
        damping=_lag_error(fe_plan, flexibility) if fe_plan.plate.relieved else _oscillation_lost(fe_plan),
        rounding=steps**-2.0 + steps * sys.float_info.epsilon,
        flexibility=flexibility,
    )


def mesh_error(difference: Mapping[str, float], companions: Sequence[Companion], order: float) -> float:
    """Distance of a run to the limit of fine meshes, at most; infinite where a companion has no result.

    difference: of the run. order: of convergence, between two meshes. Meshes of neighbours differ by a factor of two.
    """
    if not difference or not all(each.difference for each in companions):
        return math.inf
    own = Companion("", 1.0, difference)
    runs = sorted((own, *companions), key=lambda each: each.refinement)
    steps = [_distance(*pair) for pair in itertools.pairwise(runs)]
    to_finest = _distance(own, runs[-1])
    if len(steps) == 1:
        return SAFETY * (to_finest + steps[0] / (2.0**order - 1.0))
    observed = math.log2(steps[-2] / steps[-1]) if min(steps[-2:]) > 0.0 else order
    order = min(max(observed, ORDERS[0]), ORDERS[-1])
    return to_finest + SAFETY * steps[-1] / (2.0**order - 1.0)


def _distance(coarse: Companion, fine: Companion) -> float:
    """Distance between two runs, by their velocities over the motion as well where one is the run itself, with 1."""
    apart = max(coarse.apart, fine.apart) if 1.0 in (coarse.refinement, fine.refinement) else 0.0
    distances = [abs(value - fine.difference[name]) for name, value in coarse.difference.items()]
    return float(np.max([apart, *distances]))  # NaN if one is


def _lag_error(fe_plan: corner_plan.CornerPlan, flexibility: float) -> float:
    """The error by the lag of damping, in proportion to its deflection: no more than all that flexibility changes."""
    lag = fe_plan.damping_lag
    return SAFETY * flexibility * lag / (fe_plan.deflection_ratio + lag)


def _oscillation_lost(fe_plan: corner_plan.CornerPlan) -> float:
    """Part that the damping takes off an unstressed plate's oscillation. Where the plate rang with less of it, the
    friction that goes with an oscillation that does not grow is not known."""
    damping, mass = fe_plan.model.loop.elastic_damping, fe_plan.model.mass
    if damping is None:
        return 0.0
    lost = static_models.oscillation_lost(fe_plan.case, fe_plan.elastic_energy, mass, damping.rate)
    return lost if fe_plan.rang else lost + static_models.friction_lost(fe_plan.case, damping.rate)


def distance_in_motion(
    ours: Histories, its: Histories, rigid: Mapping[str, float], oscillates: bool
) -> float:
    """Root mean square of the distance between two runs' velocities over a tenth of the motion, the largest velocity's.

    ours, its: histories of the plate and of the rigid body, at the same instants, NaN where the rigid motion has ended;
    rigid: values at the tail-slap. The tenth is the last one; where the plate oscillates any, as far as the oscillation
    lasts, since two that drift out of phase may be in phase again at the end. Infinite where a number is not finite.
    """
    end = min(float(fe["t"][_known(body)][-1]) for fe, body in (ours, its))
    rows = ours[0]["t"]
    t = np.append(rows[rows < end], end)
    tenths = np.minimum((t / (LATE * end)).astype(int), LAST)
    wanted = np.unique(tenths) if oscillates else np.array([LAST])
    found = []
    for name in (name for name in VELOCITIES if rigid[name]):
        mine, other = _deviation(ours, name, t), _deviation(its, name, t)
        apart = np.array([np.sqrt(np.mean((mine - other)[tenths == tenth] ** 2)) for tenth in wanted])
        swing = np.array([np.std(mine[tenths == tenth]) for tenth in wanted])
        lasts = np.minimum(1.0, np.divide(swing[-1], swing, out=np.ones_like(swing), where=swing > 0.0))
        found.append(float((apart * lasts).max()) / abs(rigid[name]))
    return max(found, default=0.0) if np.isfinite(found).all() else math.inf


def _deviation(histories: Histories, name: str, t: np.ndarray) -> np.ndarray:
    """Deviation from the rigid motion at these instants."""
    fe, rigid = histories
    known = _known(rigid)
    return np.interp(t, fe["t"][known], (fe[name] - rigid[name])[known])


def _known(rigid: Mapping[str, np.ndarray]) -> np.ndarray:
    """True at instants before the end of the rigid motion."""
    return np.isfinite(rigid["v_gx"])


def friction_by_ringing(fe_plan: corner_plan.CornerPlan, row: Mapping[str, float]) -> float:
    """Friction follows |N|: where N rings through zero it brakes more than the motion's own reaction would.

    row: of the history. Returns the fraction of v_GX or omega, whichever is more, that this has taken off by then.
    """
    rectified = row["normal_impulse_magnitude"] - abs(row["normal_impulse"])
    speed = fe_plan.case.scene.corner_friction * rectified / fe_plan.model.mass
    radius, strike = fe_plan.case.body.corner_radius, fe_plan.case.motion.strike
    return max(abs(speed / (strike.v_gx or math.inf)), 0.75 * abs(speed) / (radius * strike.omega))
