"""Distance of a run from the plate that the scene describes: mesh, time step, contact spring, damping, ringing.

After a start by inertia relief the plate follows its loads, and statics tells what each of these can do: the answer
moves by `sensitivity` times what it moves the centre of mass at the start. An unstressed plate oscillates, and the
phase of its oscillation counts; there, and where statics explains less than the difference from the rigid motion, or
tells of an error that is not small beside it, a second run tells: on another mesh. Two oscillations may agree at one
instant by chance, so that they are compared over the whole motion as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fem.plate import kinds
from postprocess.comparison.quantities import largest
from tailslap.case.corner import model
from tailslap.case.corner.plan import CornerPlan

RINGING, CORRUPTED = 2e-3, 0.1
"""Friction by ringing that is allowed, and at which a run is given up."""

FLOOR, FRACTION = 5e-4, 0.25
"""Numerical error that is allowed whatever the plate, and as a fraction of what its flexibility changes."""

SHARP = 0.1
"""Part of the difference from the rigid motion that its numerical error may be and still be told by statics."""

EXPLAINED = 2.0
"""Multiples of the deflection ratio that a difference from the rigid motion may have: it is 0.3 to 2.0 of it."""

LAG_EFFECT = 0.9
"""Change of the result over the lag that damping leaves the plate with, see `benchmarks/damping.py`."""

LATE, LAST = 0.1, 9
"""Part of the motion over which two runs are compared, and number of the last such part."""

VELOCITIES = ("v_gx", "v_gy", "omega")

Histories = tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]]

FACTOR = 4.0 / 3.0
"""Error over the distance to the second run, of second order between linear elements and half as large ones."""


@dataclass(frozen=True)
class SecondRun:
    """A run of the same plate on another mesh with the exact constraint.

    Attributes
    ----------
    mesh : str
        In words.
    difference : dict of str to float
        Its five quantities' from the rigid motion; empty where it came to no result.
    late, apart : float
        What lies between the velocities of the two runs over the last tenth of the motion, and if the plate oscillates
        over any, as a fraction of the rigid ones at the tail-slap, see `distance_in_motion`.
    """

    mesh: str
    difference: Mapping[str, float]
    late: float = 0.0
    apart: float = 0.0


@dataclass(frozen=True)
class NumericalError:
    """Relative errors of the five quantities, the largest of them, at most; `second_run` takes in the first three, NaN
    where there was none. flexibility: what the plate's own flexibility changes."""

    time_step: float
    mesh: float
    contact_spring: float
    damping: float
    ringing: float
    second_run: float
    flexibility: float

    @property
    def total(self) -> float:
        """All of them together."""
        by_statics = self.time_step + self.mesh + self.contact_spring
        return self.damping + self.ringing + (by_statics if math.isnan(self.second_run) else self.second_run)

    @property
    def allowed(self) -> float:
        """The limit of the total."""
        return FLOOR + FRACTION * self.flexibility


def needs_second_run(fe_plan: CornerPlan, differences: Mapping[str, float], error: NumericalError) -> bool:
    """True where statics does not tell, or not sharply, how far the run may be off."""
    explained = largest(differences) <= FLOOR + EXPLAINED * fe_plan.deflection_ratio
    sharp = error.total <= max(FLOOR, SHARP * largest(differences))
    by_statics = fe_plan.plate.relieved and not kinds.LUMPINGS[fe_plan.plate.lumping].fault
    return not (by_statics and explained and sharp)


def numerical_error(
    fe_plan: CornerPlan, differences: Mapping[str, float], ringing: float, second: SecondRun | None
) -> NumericalError:
    """The estimate; differences: from the rigid motion, empty if there is no result; ringing: friction by ringing."""
    factor, relieved = model.sensitivity(fe_plan.case.start.angle), fe_plan.plate.relieved
    by_statics = factor * max(fe_plan.deflection_ratio, fe_plan.other_deflection_ratio)
    return NumericalError(
        time_step=(1.0 / fe_plan.expected_steps) ** 2,
        mesh=factor * abs(fe_plan.deflection_ratio - fe_plan.other_deflection_ratio),
        contact_spring=factor * fe_plan.spring_ratio,
        damping=factor * _lag_error(fe_plan) if relieved else _oscillation_lost(fe_plan),
        ringing=ringing
        if relieved
        else 0.0,  # an unstressed plate rings by itself, and the second run tells how
        second_run=_distance(differences, second) if second else math.nan,
        flexibility=largest(second.difference) if second else by_statics,
    )


def _lag_error(fe_plan: CornerPlan) -> float:
    """The error by the lag of damping, over the centre's travel: no more than the whole deflection."""
    lag = fe_plan.damping_lag
    return LAG_EFFECT * lag / (1.0 + 2.0 * lag / fe_plan.deflection_ratio) if lag else 0.0


def _oscillation_lost(fe_plan: CornerPlan) -> float:
    """Part that the damping takes off an unstressed plate's oscillation. Where the plate rang with less of it, the
    friction that goes with an oscillation that does not grow is not known."""
    damping, mass = fe_plan.model.loop.elastic_damping, fe_plan.model.mass
    if damping is None:
        return 0.0
    lost = model.oscillation_lost(fe_plan.case, fe_plan.elastic_energy, mass, damping.rate)
    return lost if fe_plan.rang else lost + model.friction_lost(fe_plan.case, damping.rate)


def _distance(differences: Mapping[str, float], second: SecondRun) -> float:
    """Error by the second run; infinite where one of the two has no result. Oscillations that have drifted apart tell
    no order of convergence: what is between them is as large as it is."""
    if not (differences and second.difference):
        return math.inf
    at_strike = max(abs(value - second.difference[name]) for name, value in differences.items())
    return max(FACTOR * at_strike, FACTOR * second.late, second.apart)


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


def friction_by_ringing(fe_plan: CornerPlan, row: Mapping[str, float]) -> float:
    """Friction follows |N|: where N rings through zero it brakes more than the motion's own reaction would.

    row: of the history. Returns the fraction of v_GX or omega, whichever is more, that this has taken off by then.
    """
    rectified = row["normal_impulse_magnitude"] - abs(row["normal_impulse"])
    speed = fe_plan.case.scene.corner_friction * rectified / fe_plan.model.mass
    radius, strike = fe_plan.case.body.corner_radius, fe_plan.case.motion.strike
    return max(abs(speed / (strike.v_gx or math.inf)), 0.75 * abs(speed) / (radius * strike.omega))
