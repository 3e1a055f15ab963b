"""Elements, constraint, threads and damping of a constrained corner where the scene leaves them open."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fem.plate import kinds
from tailslap.case import resources
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.case.corner.static_models import centre_travel, friction_lost, oscillation_lost, static_models
from tailslap.case.plate_input import (
    Decision,
    comparable_plate,
    fe_mesh,
    refined,
    resolved_plate,
    same_mesh,
    threads_decision,
)
from tailslap.errors import InputError
from tailslap.scene.schema import Plate, Scene

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.stability.flutter import Flutter

STRETCH = 1.23
"""Length over height of an element of the first mesh that is tried: the paper's 20 x 6."""

MESH_FRACTION, MESH_FLOOR = 0.1, 2e-5
"""Fraction of the plate's flexibility that may be the mesh's doing before higher-order elements are tried, and what is
always let pass: the difference from the rigid motion is of that size itself."""

MAX_CHOSEN = 2000
"""Elements up to which the program refines by itself."""

SOFTEST = 0.01
"""Least multiple of the program's spring."""

UNSEEN = 1e-5
"""Fraction of the centre's travel to the wall that the spring may give under the reaction at the start: no reported
digit changes."""

ELEMENTS_A_THREAD = 10_000
"""Elements that a thread needs to be worth it: in a step the threads meet three times, and to wake one takes some 20 us
where a core is busy, in which another computes a thousand elements."""

REQUIRED_DAMPING = 4.0
"""Rate of the damping over that of the fastest growing mode: above 2 it decays."""

HARMLESS_UNSTRESSED = 2.0
"""Exponent of growth that an unstressed start stands, whose oscillation is there from the beginning."""

STAND_IN, STAND_INS = 2.0, 2
"""For a mesh too large for all its modes, coarser ones stand in: factor on their rates, and how many are looked at."""

OVERDAMPS = 0.5
"""Rate of damping over the lowest frequency above which that mode no longer follows its loads."""

SEEN, MISSED = 1e-3, 5e-4
"""Deflection ratio from which on it is seen that an overdamped plate does not follow its loads, and part of the result
that an unstressed plate's oscillation may lose: below, damping stays within the numerical error that is allowed."""

MAX_RATE = 1e12
"""Highest rate of damping that a scene may have [1/s]. The program wants more only of plates with a time step that no
run ends with, which is refused."""

HEARD = 0.005
"""Ripple of the reaction by rounding, over the reaction at the start, from which on it is damped: to this."""


@dataclass(frozen=True)
class Mesh:
    """A plate with all its elements chosen and its modulus resolved, its static model and mass [kg].

    Over the centre's travel to the wall: static deflection of this model and of the comparable one, and deflection of
    the corner's constraint.
    """

    plate: Plate
    model: PlateModel
    mass: float
    deflection_ratio: float
    other_deflection_ratio: float
    spring_ratio: float

    @property
    def fine_enough(self) -> bool:
        """True where what the mesh does to the plate's flexibility is of no account."""
        allowed = max(MESH_FLOOR, MESH_FRACTION * max(self.deflection_ratio, self.other_deflection_ratio))
        return abs(self.deflection_ratio - self.other_deflection_ratio) <= allowed


def decide_mesh(case: RigidStages, plate: Plate) -> tuple[Mesh, tuple[Decision, ...]]:
    """The plate with its elements; what was left open is chosen by statics, without a run. Raises InputError."""
    open_keys = [key for key in ("elements", "element") if key not in plate.model_fields_set]
    chosen: Mesh | None = None
    for candidate in _candidates(case, plate):
        try:
            made = make_mesh(case, candidate)
        except InputError:
            if chosen is None and candidate.element == "quad9":
                raise
            continue
        if chosen is None or plate.elements is None or made.fine_enough:
            chosen = made
        if made.fine_enough or not open_keys:
            break
    chosen = chosen or make_mesh(case, next(_candidates(case, plate)))
    values = {key: getattr(chosen.plate, key) for key in open_keys}
    changed = {key: value for key, value in values.items() if value != getattr(plate, key)}
    return chosen, tuple(Decision(f"plate.{k}", v, _why_mesh(plate, k)) for k, v in changed.items())


def make_mesh(case: RigidStages, plate: Plate) -> Mesh:
    """The plate's static model, its deflection and its gap, and the comparable plate's deflection. Raises InputError.

    Both models have one mesh where only their elements differ.
    """
    from fem.start import inertia_relief

    scene, travel, start = case.scene, centre_travel(case), case.start
    mesh = fe_mesh(scene, plate)
    plate = resolved_plate(scene, plate, mesh)
    other = comparable_plate(plate)
    meshes = (mesh, mesh if same_mesh(plate, other) else fe_mesh(scene, other))
    model, comparable = static_models(case, (plate, other), meshes)
    mine, its = inertia_relief.statics(model, start), inertia_relief.statics(comparable, start)
    ratios = (abs(mine.deflection) / travel, abs(its.deflection) / travel)
    return Mesh(plate, model, model.mass, *ratios, abs(mine.gap) / travel)


def _candidates(case: RigidStages, plate: Plate) -> Iterator[Plate]:
    """Candidates from cheap to dear: the element as it is, quadratic ones, and where the counts are open, more of
    them."""
    counts = plate.elements or _first_counts(case)
    chosen = "element" in plate.model_fields_set or kinds.LUMPINGS[plate.lumping].row_sums
    elements = (plate.element,) if chosen else ("quad4", "quad9")
    sized = plate.model_copy(update={"elements": counts})
    while True:
        yield from (refined(sized, 1.0, element) for element in elements)
        sized = refined(sized)
        if plate.elements is not None or math.prod(sized.counts) > MAX_CHOSEN:
            return


def _first_counts(case: RigidStages) -> tuple[int, int]:
    length, width = case.body.length, case.body.width
    height = math.sqrt(length * width / (resources.ELEMENTS * STRETCH))
    patch = case.scene.corner.patch_length or length
    along = max(round(length / (STRETCH * height)), 2, math.ceil(length / patch))
    return min(along, 1000), max(2, round(width / height))


def _why_mesh(plate: Plate, key: str) -> str:
    if key == "element" and plate.elements is not None:
        return "on this mesh linear elements are too stiff for the plate's flexibility"
    if key == "element":
        return "linear elements are too stiff in bending"
    return "not specified in the scene; fine enough for the plate's flexibility"


def open_threads(case: RigidStages, plate: Plate) -> tuple[Decision, ...]:
    """Limit the threads to as many as the mesh has work for."""
    elements = math.prod(plate.counts)
    why = f"a thread pays off from {ELEMENTS_A_THREAD} elements on; the mesh has {elements}"
    return threads_decision(case.scene.time.threads, max(1, elements // ELEMENTS_A_THREAD), why)


def open_constraint(case: RigidStages, plate: Plate, spring_ratio: float) -> tuple[Decision, ...]:
    """The exact constraint where a spring would ring, or be seen beside the plate's flexibility."""
    if not case.scene.corner.constraint_is_open:
        return ()
    if not plate.relieved:
        why = "a spring would oscillate with a plate that starts unstressed"
    elif spring_ratio > UNSEEN:
        why = f"a spring would deflect by {spring_ratio:.1e} of the travel to the wall, which would change the result"
    else:
        return ()
    return (Decision("corner.constraint", "exact", why),)


def softer_constraint(case: RigidStages, spring_ratio: float) -> tuple[Decision, ...]:
    """The softest spring that is not seen: friction then feeds high modes less. None where the scene gives the
    constraint, or there is none much softer."""
    scale = max(SOFTEST, spring_ratio / UNSEEN)
    if not case.scene.corner.constraint_is_open or scale > 0.5:
        return ()
    why = "damping of the flutter by friction would change the result; a softer spring reduces its growth"
    return (Decision("corner.penalty_scale", scale, why),)


@dataclass(frozen=True)
class Growth:
    """Growth that the linearised model predicts.

    By friction: the fastest rate [1/s], 0 where none counts, NaN where no mesh could be analysed; its exponent over the
    run; the exponent that counts, 0 without friction; whether coarser meshes stood in; the lowest elastic frequency
    [rad/s]. By rounding: the ripple at the end of the run over the reaction at the start, and the rate of damping that
    keeps it unheard, 0 where it is.
    """

    rate: float
    exponent: float
    harmless: float
    stand_in: bool = False
    ripple: float = 0.0
    ripple_rate: float = 0.0
    lowest: float = 0.0

    @property
    def overdamps(self) -> bool:
        """True where the damping that suppresses it would keep the plate from following its loads."""
        return REQUIRED_DAMPING * self.rate > OVERDAMPS * self.lowest


def predict_growth(case: RigidStages, plate: Plate, model: PlateModel, normal: float) -> Growth:
    """Growth of the fastest mode by friction, the scene's stiffness-proportional damping included, and of rounding.

    normal: the rigid body's reaction at the start [N].
    """
    from fem.stability import flutter, rounding

    harmless = flutter.HARMLESS if plate.relieved else HARMLESS_UNSTRESSED
    duration, start = case.duration, case.start
    noise, viscous = rounding.rounding_noise(model), flutter.viscous_rate(model)
    ripple = noise.ripple(duration) / abs(normal)
    ripple_rate = noise.rate_for(HEARD * abs(normal)) if ripple > HEARD else 0.0
    if model.loop.friction is None:
        growth = Growth(0.0, 0.0, 0.0)
    elif 2 * model.loop.mass.size <= flutter.MAX_UNKNOWNS:
        growth = _growth(flutter.predict_flutter(model, start, duration, viscous, harmless), harmless)
    else:
        coarser = _coarser_models(case, plate, flutter.MAX_UNKNOWNS)
        part = harmless / STAND_IN
        found = [flutter.predict_flutter(each, start, duration, viscous, part) for each in coarser]
        growth = _by_stand_ins(found, harmless)
    return replace(growth, ripple=ripple, ripple_rate=ripple_rate)


def _by_stand_ins(found: list[Flutter], harmless: float) -> Growth:
    """Growth of a large mesh from that of coarser ones."""
    fastest: Flutter | None = max(found, key=lambda each: each.rate, default=None)
    if fastest is None:
        return Growth(math.nan, math.nan, harmless, stand_in=True)
    more = replace(fastest, rate=STAND_IN * fastest.rate, growth=STAND_IN * fastest.growth)
    return replace(_growth(more, harmless), stand_in=True)


def _growth(found: Flutter, harmless: float) -> Growth:
    """Growth as it was found; no more than half the exponent that counts is harmless whatever the rate may be."""
    rate = found.rate if found.growth > 0.5 * harmless else 0.0
    return Growth(rate, found.growth, harmless, lowest=found.lowest)


def _coarser_models(case: RigidStages, plate: Plate, most_unknowns: int) -> Iterator[PlateModel]:
    """The finest coarser meshes of the same element that make a model and can be analysed."""
    found = 0
    while found < STAND_INS and max(plate.counts) > 2:
        plate = refined(plate, 1.0 / 1.5, least=2, whole=round)
        along, across = plate.counts
        if 2 * (along + 1) * (across + 1) > most_unknowns:  # without other nodes than the elements' corners
            continue
        try:
            (model,) = static_models(case, [plate], [fe_mesh(case.scene, plate)])
        except InputError:
            continue
        if 2 * model.loop.mass.size <= most_unknowns:
            found += 1
            yield model


def suppressing_rate(growth: Growth) -> float:
    """Rate [1/s] of the damping of elastic velocities that suppresses what is foreseen."""
    # In this order a rate that is not known, NaN, asks for none.
    return max(growth.ripple_rate, REQUIRED_DAMPING * growth.rate)


def damping_is_open(scene: Scene) -> bool:
    """True where the program may choose the damping."""
    return scene.damping is None or scene.damping.kind is None


def harms(
    case: RigidStages, plate: Plate, model: PlateModel, growth: Growth, deflection_ratio: float
) -> bool:
    """Tell whether damping against this growth would be seen in the result: it keeps a soft plate from following its
    loads, and takes an unstressed one's oscillation off."""
    from fem.start import inertia_relief

    if not growth.rate > 0.0:
        return False
    if plate.relieved:
        return growth.overdamps and deflection_ratio > SEEN
    energy, rate = inertia_relief.elastic_energy(model, case.start), suppressing_rate(growth)
    return oscillation_lost(case, energy, model.mass, rate) + friction_lost(case, rate) > MISSED


def open_damping(
    case: RigidStages, growth: Growth, factor: float = 1.0, harmful: bool = False
) -> tuple[Decision, ...]:
    """Damping for this growth, times `factor`; none where the scene says what it wants.

    A plate that this would harm is run without it at first (factor 1): what is predicted is the worst that may come,
    and the checks watch for it.
    """
    if not damping_is_open(case.scene):
        return ()
    if factor == 1.0 and harmful:
        if growth.ripple_rate or case.scene.damping:  # against rounding it stays, and what the scene gives
            return _damped(growth.ripple_rate, _why_rounding(growth))
        why = f"{_why(growth)}, but sufficient damping would change the result"
        return (Decision("damping.kind", "none", why),)
    least = (growth.harmless or HARMLESS_UNSTRESSED) / case.duration if factor > 1.0 else 0.0
    rate = min(factor * max(suppressing_rate(growth), REQUIRED_DAMPING * least), MAX_RATE)
    again = f"; {factor:g} times the predicted rate, since the first run oscillated" if factor > 1.0 else ""
    return _damped(rate, _why(growth) + again)


def _damped(rate: float, why: str) -> tuple[Decision, ...]:
    kind = Decision("damping.kind", "elastic-velocity", why)
    return (kind, Decision("damping.rate", rate, "1/s, the required rate")) if rate > 0.0 else ()


def _why(growth: Growth) -> str:
    if growth.ripple_rate > REQUIRED_DAMPING * growth.rate:
        return _why_rounding(growth)
    if growth.rate > 0.0:
        return f"flutter by friction would grow by exp({growth.exponent:.0f}) during the run"
    return "the plate would oscillate"


def _why_rounding(growth: Growth) -> str:
    return f"rounding errors would make the reaction oscillate by {100.0 * growth.ripple:.2g} %"
