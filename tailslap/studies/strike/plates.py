"""The plate instead of the rigid vehicle, from 2 Hz to rigid: both strikes against the first frequency."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from solver.impact import CORNERS as WALL_CORNERS
from solver.impact import Strike
from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError
from tailslap.impact.answers import ImpactAnswer, nearest_corner
from tailslap.impact.rigid_text import rigid_impact
from tailslap.studies.strike.quantities import QUANTITIES, STRIKES, Array, column, filtered, peaks_within

if TYPE_CHECKING:
    from fem.run.impact import ImpactRun

FREQUENCIES = (2.0, 4.0, 8.0, 16.0, 32.0)
"""First frequencies of the free plate in its plane [Hz]."""

PATCH = 0.1
"""Length of side that a corner's crush is spread over, over the vehicle's length: a point has no finite compliance."""

SAME_STRIKE = 0.05
"""Contacts of a corner that are closer than this [s] are one strike: a mean over 50 ms does not tell them apart."""

LONGER = 2.0
"""Time of the plate's run over that of the rigid vehicle's impact."""

WORST = 0.05
"""Difference between both meshes above which a plate is not to be relied on."""

CORNERS = {1: "front", 2: "rear"}
"""The strikes, by the corner that brings them."""


@dataclass(frozen=True)
class PlatePoint:
    """A plate of one first frequency.

    Attributes
    ----------
    frequency : float
        [Hz]; infinite for the rigid vehicle.
    values : dict of float
        By `QUANTITIES` and strike, as of `quantities.column`, SI; NaN without the strike.
    errors : dict of float
        Finer mesh over the coarser one, less one.
    failed : tuple of str
        Checks that failed; what refused the run.
    """

    frequency: float
    values: dict[str, float]
    errors: dict[str, float]
    failed: tuple[str, ...]

    @property
    def error(self) -> float:
        """The largest difference between both meshes; NaN where something is not known."""
        sizes = [abs(value) for value in self.errors.values()]
        return max(sizes) if sizes and all(map(math.isfinite, sizes)) else math.nan

    @property
    def passed(self) -> bool:
        """Whether every check passed, and both meshes agree."""
        return not self.failed and (math.isinf(self.frequency) or self.error <= WORST)


def find_plates(plan: ImpactCase, progress: Callable[[float], None]) -> tuple[PlatePoint, ...]:
    """All plates, softest first, the rigid vehicle last; none where the scene has no plate."""
    if plan.scene.plate is None:
        return ()
    points = []
    for number, frequency in enumerate(FREQUENCIES):
        progress(number / len(FREQUENCIES))
        points.append(_point(plan, frequency))
    return (*points, PlatePoint(math.inf, both_strikes(rigid_impact(plan)), {}, ()))


def _point(plan: ImpactCase, frequency: float) -> PlatePoint:
    """On two meshes, the scene's and one twice as fine."""
    try:
        coarse, fine = (_run(plan, frequency, refined) for refined in (1, 2))
    except InputError as error:
        return PlatePoint(frequency, {}, {}, (str(error),))
    names = [column(strike, quantity.name) for strike in STRIKES for quantity in QUANTITIES]
    errors = {name: fine[0][name] / coarse[0][name] - 1.0 for name in names}
    return PlatePoint(frequency, fine[0], errors, fine[1])


def _run(plan: ImpactCase, frequency: float, refined: int) -> tuple[dict[str, float], tuple[str, ...]]:
    """Values and failed checks of a single run."""
    from tailslap.impact.checks import failed_but_mesh
    from tailslap.impact.run import make_fe_plan_timed, plain_run

    outcome = plain_run(make_fe_plan_timed(plan.varied(_changes(plan, frequency, refined))))
    strikes = both_strikes(outcome.fe, corner_forces(outcome.run, plan.vehicle.length))
    return strikes, failed_but_mesh(outcome)


def _changes(plan: ImpactCase, frequency: float, refined: int) -> dict[str, Any]:
    from tailslap.impact.fe_plan import chosen_plate

    along, across = chosen_plate(plan.scene)[0].counts
    own = plan.scene.contact.patch_length if plan.scene.contact else None
    return {
        "plate.youngs_modulus": None,
        "plate.first_frequency": frequency,
        "plate.elements": (refined * along, refined * across),
        "contact.patch_length": own or PATCH * plan.vehicle.length,
        "time.end": LONGER * plan.motion.t_end,
    }


def both_strikes(answer: ImpactAnswer, forces: Mapping[str, Array] | None = None) -> dict[str, float]:
    """What `QUANTITIES` names of the first strike of the front and of the rear corner [SI]; NaN without one.

    forces: of each corner, shape (rows,) [N], where several touch at once; else the filters take the total force.
    """
    total = answer.history["force_normal"]
    values: dict[str, float] = {}
    for strike, corner in CORNERS.items():
        contacts = first_strike([each for each in answer.strikes if each.corner == corner])
        curves = filtered((forces or {}).get(corner, total)[1:], answer.interval)
        measures = _measures(contacts) | peaks_within(curves, answer.interval, *_ends(contacts))
        values |= {column(strike, quantity.name): measures[quantity.name] for quantity in QUANTITIES}
    return values


def corner_forces(run: ImpactRun, length: float) -> dict[str, Array]:
    """The force of the points nearest to each corner of a vehicle of this length, shape (rows,) [N]."""
    corner = nearest_corner(run.points, length)
    return {name: run.normal[:, corner == number].sum(axis=1) for number, name in enumerate(WALL_CORNERS)}


def first_strike(contacts: list[Strike]) -> list[Strike]:
    """The contacts of one corner, in order of time, that make up its first strike."""
    found = contacts[:1]
    for contact in contacts[1:]:
        if contact.start - found[-1].end > SAME_STRIKE:
            break
        found.append(contact)
    return found


def _ends(contacts: list[Strike]) -> tuple[float, float]:
    return (contacts[0].start, contacts[-1].end) if contacts else (math.nan, math.nan)


def _measures(contacts: list[Strike]) -> dict[str, float]:
    start, end = _ends(contacts)
    return {
        "raw": max((each.peak_force for each in contacts), default=math.nan),
        "impulse": math.fsum(each.impulse for each in contacts) if contacts else math.nan,
        "duration": end - start,
    }
