"""Decisions on elements, constraint, threads and damping that a scene leaves open.

Each `Decision` has its reason. Elements are chosen by statics, damping by the growth of the linearised model.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from fem.plate import kinds
from tailslap.case import resources
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.case.corner.static_models import (
    centre_travel,
    deflection_ratio,
    friction_lost,
    oscillation_lost,
    static_model,
)
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
from tailslap.scene.model_tables import Plate
from tailslap.scene.schema import Scene

if TYPE_CHECKING:
    import meshio

    from fem.model.plate_model import PlateModel
    from fem.stability.flutter import Flutter

ASPECT_RATIO = 1.23
"""Length over height of an element of the first mesh, as for the paper's 20 x 6."""

MESH_FRACTION, MESH_FLOOR = 0.1, 2e-5
"""Allowed effect of the mesh, as a fraction of the static deflection, and over the centre's travel to the wall."""

MAX_CHOSEN = 2000
"""Largest number of elements that the program chooses."""

LEAST_PENALTY_SCALE = 0.01
"""Least multiple of the program's spring."""

NEGLIGIBLE_DEFLECTION = 1e-5
"""Deflection of the spring at the start over the centre's travel to the wall that changes no printed digit."""

ELEMENTS_A_THREAD = 10_000
"""Least number of elements per thread: to wake one, three times a step, takes the time of a thousand elements."""

REQUIRED_DAMPING = 4.0
"""Rate of the damping over that of the fastest growing mode, which decays above a ratio of 2."""

HARMLESS_UNSTRESSED = 2.0
"""Harmless exponent of growth after an unstressed start, which oscillates from the beginning."""

COARSER_FACTOR, COARSER_MESHES = 2.0, 2
"""Factor on growth rates of coarser meshes, and number of those that replace a mesh too large for all modes."""

OVERDAMPING = 0.5
"""Rate of damping over the lowest frequency above which that mode no longer follows its loads."""

NOTICEABLE_RATIO, NEGLIGIBLE_LOSS = 1e-3, 5e-4
"""Deflection ratio from which on overdamping changes the result, and loss of oscillation that does not change it."""

MAX_RATE = 1e12
"""Highest rate of damping of a scene [1/s]; only plates with too many time steps, which are refused, need more."""

RIPPLE_LIMIT = 0.005
"""Ripple of the reaction by rounding, over the reaction at the start, above which it is damped to this value."""


@dataclass(frozen=True)
class Mesh:
    """A plate with its mesh, judged by static deflections.

    Attributes
    ----------
    case : RigidStages
        The rigid vehicle.
    plate : Plate
        With its number of elements and Young's modulus.
    cells : meshio.Mesh
        Its elements.
    model : PlateModel
        Its static model.
    mass : float
        Mass of the model [kg].
    deflection_ratio : float
        Static deflection over the centre's travel to the wall [-].
    spring_ratio : float
        Deflection of the corner's constraint, likewise [-].
    """

    case: RigidStages
    plate: Plate
    cells: meshio.Mesh
    model: PlateModel
    mass: float
    deflection_ratio: float
    spring_ratio: float

    @cached_property
    def comparable_ratio(self) -> float:
        """Deflection ratio of a comparable plate [-].

        Both models have one mesh where only their elements differ. Raises InputError.
        """
        plate = comparable_plate(self.plate)
        cells = self.cells if same_mesh(self.plate, plate) else fe_mesh(self.case.scene, plate)
        return deflection_ratio(self.case, static_model(self.case, plate, cells))

    @property
    def fine_enough(self) -> bool:
        """True if the effect of the mesh on the deflection is negligible.

        Raises InputError.
        """
        allowed = max(MESH_FLOOR, MESH_FRACTION * max(self.deflection_ratio, self.comparable_ratio))
        return abs(self.deflection_ratio - self.comparable_ratio) <= allowed


@dataclass(frozen=True)
class Growth:
    """Growth of oscillations that the linearised model predicts.

    Attributes
    ----------
    rate : float
        Fastest rate by friction [1/s]; 0 where it is harmless, NaN where no mesh could be analysed.
    exponent : float
        Its exponent over the run.
    harmless : float
        Largest harmless exponent; 0 without friction.
    by_coarser : bool
        Whether coarser meshes were analysed in place of this one.
    ripple : float
        Ripple by rounding at the end of the run, over the reaction at the start.
    ripple_rate : float
        Rate of damping that limits it [1/s]; 0 where none is needed.
    lowest : float
        Lowest elastic frequency [rad/s].
    """

    rate: float
    exponent: float
    harmless: float
    by_coarser: bool = False
    ripple: float = 0.0
    ripple_rate: float = 0.0
    lowest: float = 0.0

    @property
    def overdamps(self) -> bool:
        """True if sufficient damping would keep the plate from following its loads."""
        return REQUIRED_DAMPING * self.rate > OVERDAMPING * self.lowest


def decide_mesh(case: RigidStages, plate: Plate) -> tuple[Mesh, tuple[Decision, ...]]:
    """Choose open numbers and kinds of elements by statics, without a run.

    Raises InputError.
    """
    open_keys = [key for key in ("elements", "element") if key not in plate.model_fields_set]
    chosen: Mesh | None = None
    for candidate in _candidates(case, plate):
        try:
            mesh = make_mesh(case, candidate)
            suffices = not open_keys or mesh.fine_enough
        except InputError:
            if chosen is None and candidate.element == "quad9":
                raise
            continue
        if chosen is None or plate.elements is None or suffices:
            chosen = mesh
        if suffices:
            break
    chosen = chosen or make_mesh(case, next(_candidates(case, plate)))
    values = {key: getattr(chosen.plate, key) for key in open_keys}
    changed = {key: value for key, value in values.items() if value != getattr(plate, key)}
    return chosen, tuple(Decision(f"plate.{k}", v, _why_mesh(plate, k)) for k, v in changed.items())


def make_mesh(case: RigidStages, plate: Plate) -> Mesh:
    """Make the static model of a plate.

    Raises InputError.
    """
    from fem.start import inertia_relief

    travel, start, cells = centre_travel(case), case.start, fe_mesh(case.scene, plate)
    plate = resolved_plate(case.scene, plate, cells)
    model = static_model(case, plate, cells)
    statics = inertia_relief.statics(model, start)
    ratios = abs(statics.deflection) / travel, abs(statics.gap) / travel
    return Mesh(case, plate, cells, model, model.mass, *ratios)


def _candidates(case: RigidStages, plate: Plate) -> Iterator[Plate]:
    """Yield plates with increasing cost.

    The element of the scene, quadratic ones, and where their number is open, more of them.
    """
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
    """Return the numbers of elements along and across of the first mesh."""
    length, width = case.body.length, case.body.width
    height = math.sqrt(length * width / (resources.ELEMENTS * ASPECT_RATIO))
    patch = case.scene.corner.patch_length or length
    along = max(round(length / (ASPECT_RATIO * height)), 2, math.ceil(length / patch))
    return min(along, 1000), max(2, round(width / height))


def _why_mesh(plate: Plate, key: str) -> str:
    if key == "element" and plate.elements is not None:
        return "on this mesh linear elements are too stiff for the plate's flexibility"
    if key == "element":
        return "linear elements are too stiff in bending"
    return "not specified in the scene; fine enough for the plate's flexibility"


def open_threads(case: RigidStages, plate: Plate) -> tuple[Decision, ...]:
    """Limit the number of threads by the size of the mesh."""
    elements = math.prod(plate.counts)
    why = f"a thread pays off from {ELEMENTS_A_THREAD} elements on; the mesh has {elements}"
    return threads_decision(case.scene.time.threads, max(1, elements // ELEMENTS_A_THREAD), why)


def open_constraint(case: RigidStages, plate: Plate, spring_ratio: float) -> tuple[Decision, ...]:
    """Choose the exact constraint where a spring would change the result."""
    if not case.scene.corner.constraint_is_open:
        return ()
    if not plate.relieved:
        why = "a spring would oscillate with a plate that starts unstressed"
    elif spring_ratio > NEGLIGIBLE_DEFLECTION:
        why = f"a spring would deflect by {spring_ratio:.1e} of the travel to the wall, which would change the result"
    else:
        return ()
    return (Decision("corner.constraint", "exact", why),)


def softer_constraint(case: RigidStages, spring_ratio: float) -> tuple[Decision, ...]:
    """Choose the softest spring that does not change the result.

    It reduces the growth of high modes by friction. Nothing is chosen where the scene specifies the constraint, or the
    spring would hardly be softer.
    """
    scale = max(LEAST_PENALTY_SCALE, spring_ratio / NEGLIGIBLE_DEFLECTION)
    if not case.scene.corner.constraint_is_open or scale > 0.5:
        return ()
    why = "damping of the flutter by friction would change the result; a softer spring reduces its growth"
    return (Decision("corner.penalty_scale", scale, why),)


def predict_growth(case: RigidStages, plate: Plate, model: PlateModel, normal: float) -> Growth:
    """Predict the growth by friction and that of rounding errors.

    Stiffness-proportional damping of the scene is included. normal: reaction of the rigid body at the start [N].
    """
    from fem.stability import flutter, rounding

    harmless = flutter.HARMLESS if plate.relieved else HARMLESS_UNSTRESSED
    duration, start = case.duration, case.start
    noise, viscous = rounding.rounding_noise(model), flutter.viscous_rate(model)
    ripple = noise.ripple(duration) / abs(normal)
    ripple_rate = noise.rate_for(RIPPLE_LIMIT * abs(normal)) if ripple > RIPPLE_LIMIT else 0.0
    if model.parameters.friction is None:
        growth = Growth(0.0, 0.0, 0.0)
    elif 2 * model.parameters.mass.size <= flutter.MAX_UNKNOWNS:
        growth = _growth(flutter.predict_flutter(model, start, duration, viscous, harmless), harmless)
    else:
        coarser = _coarser_models(case, plate, flutter.MAX_UNKNOWNS)
        exponent = harmless / COARSER_FACTOR
        modes = [flutter.predict_flutter(coarse, start, duration, viscous, exponent) for coarse in coarser]
        growth = _growth_by_coarser(modes, harmless)
    return replace(growth, ripple=ripple, ripple_rate=ripple_rate)


def _growth_by_coarser(modes: list[Flutter], harmless: float) -> Growth:
    """Estimate the growth of a large mesh by coarser ones."""
    fastest: Flutter | None = max(modes, key=lambda mode: mode.rate, default=None)
    if fastest is None:
        return Growth(math.nan, math.nan, harmless, by_coarser=True)
    finer = replace(fastest, rate=COARSER_FACTOR * fastest.rate, growth=COARSER_FACTOR * fastest.growth)
    return replace(_growth(finer, harmless), by_coarser=True)


def _growth(mode: Flutter, harmless: float) -> Growth:
    """Return the growth of a mode.

    Its rate counts where the exponent is above half the harmless one.
    """
    rate = mode.rate if mode.growth > 0.5 * harmless else 0.0
    return Growth(rate, mode.growth, harmless, lowest=mode.lowest)


def _coarser_models(case: RigidStages, plate: Plate, most_unknowns: int) -> Iterator[PlateModel]:
    """Yield models of the finest coarser meshes that can be analysed."""
    count = 0
    while count < COARSER_MESHES and max(plate.counts) > 2:
        plate = refined(plate, 1.0 / 1.5, least=2, whole=round)
        along, across = plate.counts
        if 2 * (along + 1) * (across + 1) > most_unknowns:  # counts corner nodes only
            continue
        try:
            model = static_model(case, plate, fe_mesh(case.scene, plate))
        except InputError:
            continue
        if 2 * model.parameters.mass.size <= most_unknowns:
            count += 1
            yield model


def suppressing_rate(growth: Growth) -> float:
    """Return the rate of damping that suppresses the predicted growth [1/s]."""
    # In this order an unknown rate, NaN, requires no damping.
    return max(growth.ripple_rate, REQUIRED_DAMPING * growth.rate)


def damping_is_open(scene: Scene) -> bool:
    """Return whether the program may choose the damping."""
    return scene.damping is None or scene.damping.kind is None


def harms(
    case: RigidStages, plate: Plate, model: PlateModel, growth: Growth, deflection_ratio: float
) -> bool:
    """Return whether damping against this growth would change the result.

    It keeps a soft plate from following its loads, and reduces the oscillation of an unstressed one.
    """
    from fem.start import inertia_relief

    if not growth.rate > 0.0:
        return False
    if plate.relieved:
        return growth.overdamps and deflection_ratio > NOTICEABLE_RATIO
    energy, rate = inertia_relief.elastic_energy(model, case.start), suppressing_rate(growth)
    return oscillation_lost(case, energy, model.mass, rate) + friction_lost(case, rate) > NEGLIGIBLE_LOSS


def open_damping(
    case: RigidStages, growth: Growth, factor: float = 1.0, harmful: bool = False
) -> tuple[Decision, ...]:
    """Choose the damping against a growth where the scene leaves it open.

    The prediction is an upper bound. A plate whose result damping would change is first run without, and its checks
    detect oscillations. growth: predicted; factor: on the predicted rate of damping, above 1 after a run that
    oscillated; harmful: whether damping would change the result, see `harms`.
    """
    if not damping_is_open(case.scene):
        return ()
    if factor == 1.0 and harmful:
        if growth.ripple_rate or case.scene.damping:  # damping against rounding and that of the scene remain
            return _damped(growth.ripple_rate, _why_rounding(growth))
        why = f"{_why(growth)}, but sufficient damping would change the result"
        return (Decision("damping.kind", "none", why),)
    least = (growth.harmless or HARMLESS_UNSTRESSED) / case.duration if factor > 1.0 else 0.0
    rate = min(factor * max(suppressing_rate(growth), REQUIRED_DAMPING * least), MAX_RATE)
    again = f"; {factor:g} times the predicted rate, since the first run oscillated" if factor > 1.0 else ""
    return _damped(rate, _why(growth) + again)


def _damped(rate: float, why: str) -> tuple[Decision, ...]:
    """Return the decisions for damping at a rate [1/s], none for 0."""
    kind = Decision("damping.kind", "elastic-velocity", why)
    return (kind, Decision("damping.rate", rate, "the required rate")) if rate > 0.0 else ()


def _why(growth: Growth) -> str:
    """Return the reason for damping."""
    if growth.ripple_rate > REQUIRED_DAMPING * growth.rate:
        return _why_rounding(growth)
    if growth.rate > 0.0:
        return f"flutter by friction would grow by exp({growth.exponent:.0f}) during the run"
    return "the plate would oscillate"


def _why_rounding(growth: Growth) -> str:
    return f"rounding errors would make the reaction oscillate by {100.0 * growth.ripple:.2g} %"
