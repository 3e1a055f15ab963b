"""Numerical error of a run, estimated as in ASME V&V 20.

Companions are runs of the same plate on other meshes.

Two meshes bound the distance to the limit of fine meshes by a safety factor and the order of the support, three meshes
by the observed order. Companions have the damping and the constraint of the run, whose errors are added: both are
proportional to the effect of the plate's flexibility. Two oscillations may agree at one instant by chance, so that
runs are compared over the motion as well.
"""

import itertools
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison.quantities import largest
from tailslap.case.corner import corner_plan, static_models

RINGING, CORRUPTED = 2e-3, 0.1
"""Relative effect of friction by an oscillating reaction that is allowed, and that ends a run."""

FLOOR, FRACTION = 5e-4, 0.25
"""Numerical error that is allowed for any plate, and as a fraction of the effect of its flexibility."""

SAFETY = 1.5
"""Safety factor on the distance to the limit: the order is a lower one, so between 1.25 and 3 of ASME V&V 20."""

ORDERS = 0.5, 1.0, 2.0
"""Orders of convergence: at a point support or unresolved patch, at a resolved patch, of smooth solutions."""

RESOLVED = 2.0
"""Number of elements along a patch from which on a mesh resolves it."""

PART, LAST_PART = 0.1, 9
"""Fraction of the motion over which two runs are compared, and number of the last such part."""

VELOCITIES = ("v_gx", "v_gy", "omega")

Columns = Mapping[str, NDArray[np.float64]]
Histories = tuple[Columns, Columns]
"""Histories of the plate and of the rigid body at the same instants."""


@dataclass(frozen=True)
class Companion:
    """Run of the same plate on another mesh.

    Attributes
    ----------
    mesh : str
        The mesh in words.
    refinement : float
        Elements along a side over those of the run [-]; elements of higher order count twice.
    difference : dict of str to float
        Relative differences of its five quantities from the rigid motion; empty without a result.
    apart : float
        Distance between the velocities of both runs, see `distance_in_motion`.
    """

    mesh: str
    refinement: float
    difference: Mapping[str, float]
    apart: float = 0.0


@dataclass(frozen=True)
class NumericalError:
    """Bounds of the largest relative error of the five quantities by cause.

    Attributes
    ----------
    mesh, contact_spring, damping : float
        Errors by these; mesh is NaN without companions.
    rounding : float
        Error of the time step and of the sums over all steps.
    flexibility : float
        Effect of the plate's flexibility, which is no error.
    """

    mesh: float
    contact_spring: float
    damping: float
    rounding: float
    flexibility: float

    @property
    def total(self) -> float:
        """Sum of all errors."""
        return self.mesh + self.contact_spring + self.damping + self.rounding

    @property
    def allowed(self) -> float:
        """Limit of the total."""
        return FLOOR + FRACTION * self.flexibility


def numerical_error(
    fe_plan: corner_plan.CornerPlan, difference: Mapping[str, float], companions: Sequence[Companion]
) -> NumericalError:
    """Estimate the error of a run.

    difference: its five quantities from the rigid motion, empty without a result.
    """
    deflection, steps = fe_plan.deflection_ratio, fe_plan.expected_steps
    changes = (largest(companion.difference) for companion in companions if companion.difference)
    flexibility = max(deflection, *changes, 0.0)
    along, corner = fe_plan.plate.counts[0], fe_plan.case.scene.corner
    patch = (corner.patch_length or 0.0) * along / fe_plan.case.scene.vehicle.length
    order = ORDERS[any(patch * companion.refinement >= RESOLVED for companion in companions)]
    return NumericalError(
        mesh=mesh_error(difference, companions, order) if companions else math.nan,
        contact_spring=SAFETY * flexibility * fe_plan.spring_ratio / deflection,
        damping=_lag_error(fe_plan, flexibility) if fe_plan.plate.relieved else _oscillation_lost(fe_plan),
        rounding=steps**-2.0 + steps * sys.float_info.epsilon,
        flexibility=flexibility,
    )


def mesh_error(difference: Mapping[str, float], companions: Sequence[Companion], order: float) -> float:
    """Bound the distance of a run to the limit of fine meshes.

    It is infinite where a companion has no result. Neighbouring meshes differ by a factor of two. difference: relative,
    of the run from the rigid motion; companions: one or two; order: of convergence, assumed of two meshes.
    """
    if not difference or not all(companion.difference for companion in companions):
        return math.inf
    run = Companion("", 1.0, difference)
    runs = sorted((run, *companions), key=lambda companion: companion.refinement)
    steps = [_distance(*pair) for pair in itertools.pairwise(runs)]
    to_finest = _distance(run, runs[-1])
    if len(steps) == 1:
        return SAFETY * (to_finest + steps[0] / (2.0**order - 1.0))
    observed = math.log2(steps[-2] / steps[-1]) if min(steps[-2:]) > 0.0 else order
    order = min(max(observed, ORDERS[0]), ORDERS[-1])
    return to_finest + SAFETY * steps[-1] / (2.0**order - 1.0)


def _distance(coarse: Companion, fine: Companion) -> float:
    """Return the largest difference between two runs.

    Where one is the run itself, with refinement 1, velocities over the motion count as well.
    """
    apart = max(coarse.apart, fine.apart) if 1.0 in (coarse.refinement, fine.refinement) else 0.0
    distances = [abs(value - fine.difference[name]) for name, value in coarse.difference.items()]
    return float(np.max([apart, *distances]))  # propagates NaN, unlike max()


def _lag_error(fe_plan: corner_plan.CornerPlan, flexibility: float) -> float:
    """Bound the error by the lag of damping, proportional to its deflection."""
    lag = fe_plan.damping_lag
    return SAFETY * flexibility * lag / (fe_plan.deflection_ratio + lag)


def _oscillation_lost(fe_plan: corner_plan.CornerPlan) -> float:
    """Estimate how much damping reduces the oscillation of an unstressed plate.

    Where the plate rang with less damping, friction by an oscillation that does not grow is unknown. With a
    dashpot no such friction remains: the reaction oscillates with high modes, whose damping is highest.
    """
    damping, mass = fe_plan.model.parameters.elastic_damping, fe_plan.model.mass
    by_dashpot = rate_by_dashpot(fe_plan)
    rate = by_dashpot + (damping.rate if damping else 0.0)
    if not rate:
        return 0.0
    lost = static_models.oscillation_lost(fe_plan.case, fe_plan.elastic_energy, mass, rate)
    rate = math.inf if by_dashpot else rate
    return lost if fe_plan.rang else lost + static_models.friction_lost(fe_plan.case, rate)


def rate_by_dashpot(fe_plan: corner_plan.CornerPlan) -> float:
    """Estimate the rate at which the corner's dashpot takes energy [1/s].

    It is that at the free plate's first frequency, at which the spring has the part of the elastic energy that it has
    in statics. A run, whose frequency is lower, loses less.
    """
    corner = fe_plan.model.parameters.corner
    if not corner.dashpot:
        return 0.0
    normal = fe_plan.case.motion_of_mass(fe_plan.model.mass).first.reaction_normal
    part = 0.5 * normal**2 / corner.spring / fe_plan.elastic_energy
    return float(part * corner.dashpot / corner.spring * (2.0 * math.pi * fe_plan.first_frequency) ** 2)


def distance_in_motion(
    run: Histories, companion: Histories, rigid: Mapping[str, float], oscillates: bool
) -> float:
    """Return the distance between two runs' velocities.

    It is taken over a tenth of the motion, and is a root mean square over the velocity of the rigid body, the largest
    of all velocities, and infinite where a number is not finite.

    Parameters
    ----------
    run, companion : Histories
        Histories of both runs; NaN where the rigid motion has ended.
    rigid : dict of str to float
        Velocities of the rigid body at the tail-slap.
    oscillates : bool
        False: the tenth is the last one. True: any, as far as the oscillation lasts, since two oscillations that drift
        out of phase may be in phase again at the end.
    """
    end = min(float(fe["t"][_rigid_rows(body)][-1]) for fe, body in (run, companion))
    rows = run[0]["t"]
    t = np.append(rows[rows < end], end)
    tenths = np.minimum((t / (PART * end)).astype(int), LAST_PART)
    compared = np.unique(tenths) if oscillates else np.array([LAST_PART])
    distances = []
    for name in (name for name in VELOCITIES if rigid[name]):
        first, second = _deviation(run, name, t), _deviation(companion, name, t)
        apart = np.array([np.sqrt(np.mean((first - second)[tenths == tenth] ** 2)) for tenth in compared])
        amplitude = np.array([np.std(first[tenths == tenth]) for tenth in compared])
        ratio = np.divide(amplitude[-1], amplitude, out=np.ones_like(amplitude), where=amplitude > 0.0)
        distances.append(float((apart * np.minimum(1.0, ratio)).max()) / abs(rigid[name]))
    return max(distances, default=0.0) if np.isfinite(distances).all() else math.inf


def _deviation(histories: Histories, name: str, t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the deviation from the rigid motion at instants [s]."""
    fe, rigid = histories
    rows = _rigid_rows(rigid)
    return np.interp(t, fe["t"][rows], (fe[name] - rigid[name])[rows])


def _rigid_rows(rigid: Columns) -> NDArray[np.bool_]:
    """Return which rows are before the end of the rigid motion."""
    return np.isfinite(rigid["v_gx"])


def friction_by_ringing(fe_plan: corner_plan.CornerPlan, row: Mapping[str, float]) -> float:
    """Return the relative loss of velocity by oscillations of the reaction N.

    Friction follows |N|: where N oscillates through zero it brakes more than the mean reaction would. row: of the
    history.
    """
    rectified = row["normal_impulse_magnitude"] - abs(row["normal_impulse"])
    return change_by_friction(fe_plan, fe_plan.case.scene.corner_friction * rectified)


def change_by_friction(fe_plan: corner_plan.CornerPlan, impulse: float) -> float:
    """Return the relative change of v_GX or omega by an impulse.

    It is the larger one. impulse: along the wall [N s].
    """
    speed, strike = impulse / fe_plan.model.mass, fe_plan.case.motion.strike
    turning = fe_plan.case.body.corner_radius * strike.omega
    return max(abs(speed / (strike.v_gx or math.inf)), 0.75 * abs(speed) / turning)
