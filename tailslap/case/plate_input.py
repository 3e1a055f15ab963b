"""Input of the plate's model from the tables of a scene.

Decisions, mesh, Young's modulus and properties.

Also plates on other meshes, or of higher-order elements, by which the error of a run is estimated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.cache import cached
from fem.plate import kinds
from fem.plate.properties import Inertia, ModelError, PlateProperties, StepProperties
from meshes import distorted, plate_mesh
from postprocess.units import measure
from tailslap.case import resources
from tailslap.errors import InputError
from tailslap.scene.model_tables import Plate
from tailslap.scene.schema import Scene, value_at
from tailslap.scene.write import unit_at

if TYPE_CHECKING:
    import meshio

    from fem.model.plate_model import PlateModel


MAX_STEPS = 2_000_000_000
"""Most time steps of a run: more would take days, and its instants could not be distinguished."""

LARGE = 10_000
"""Number of elements from which on a mesh is not cached."""

REFERENCE_MODULUS = 1e9
"""Young's modulus [Pa] of the model by which a first frequency is converted; its value is arbitrary."""

HIGHER_ORDER_UP_TO = 20_000
"""Most elements of a mesh that statics compares with higher-order elements; a larger one with a coarser mesh."""

MIN_HALVED = (4, 2)
"""Fewest elements along and across a halved mesh. Otherwise the scene's own mesh is the coarsest."""


@dataclass(frozen=True)
class Decision:
    """Value that the program chose, and reason.

    value None: the key is removed.
    """

    key: str
    value: object
    why: str

    @property
    def text(self) -> str:
        """The decision as a line of text."""
        value = self.value
        if isinstance(value, float):
            unit = unit_at(self.key)
            value = measure(value, unit, ".3g") if unit else f"{value:.3g}"
        elif isinstance(value, tuple):
            value = f"[{', '.join(map(str, value))}]"
        return f"{self.key} = {'none' if value is None else value}: {self.why}"


def threads_decision(requested: int, most: int, why: str) -> tuple[Decision, ...]:
    """Return the decision to use fewer threads than requested, if any."""
    text = f"{requested} were requested; {why}"
    return (Decision("time.threads", most, text),) if requested > most else ()


def resolved_plate(
    scene: Scene, plate: Plate, mesh: meshio.Mesh | None = None, inertia: Inertia | None = None
) -> Plate:
    """Return the plate with its Young's modulus.

    It is computed where the scene specifies a first frequency. Raises InputError.
    """
    if plate.youngs_modulus is not None or plate.first_frequency is None:
        return plate
    from fem.model import plate_model

    stiff = plate.model_copy(update={"youngs_modulus": REFERENCE_MODULUS})
    reference = plate_properties(scene, stiff, inertia)
    try:
        modulus = plate_model.modulus_for(mesh or fe_mesh(scene, plate), reference, plate.first_frequency)
    except ModelError as error:
        raise refusal(scene, plate, error) from None
    return plate.model_copy(update={"youngs_modulus": modulus})


def fe_mesh(scene: Scene, plate: Plate, number: int = 0) -> meshio.Mesh:
    """Return the mesh of a unit's plate in its body frame.

    number: of the unit, 0 for the vehicle.
    """
    unit, counts = scene.units[number], unit_counts(scene, plate, number)
    hinges = [*(trailer.kingpin for trailer in scene.trailer[number - 1 : number] if number)]
    hinges += [trailer.hitch for trailer in scene.trailer[number : number + 1]]
    make = _mesh if math.prod(counts) < LARGE else _mesh.__wrapped__
    cells = kinds.ELEMENT_KINDS[plate.element].cells
    mesh: meshio.Mesh = make(unit.length, unit.width, counts, cells, plate.distortion, tuple(hinges))
    return mesh


def unit_counts(scene: Scene, plate: Plate, number: int) -> tuple[int, int]:
    """Return the numbers of elements along and across a unit.

    Elements of a trailer have the size of the vehicle's. Their number across is even where the vehicle's is.
    """
    if number == 0:
        return plate.counts
    (along, across), unit, vehicle = plate.counts, scene.units[number], scene.vehicle
    step = 1 if across % 2 else 2  # even: a row of nodes on the middle line, on which the hinges are
    across = step * max(1, round(across * unit.width / vehicle.width / step))
    return max(1, round(along * unit.length / vehicle.length)), across


@cached
def _mesh(
    length: float,
    width: float,
    counts: tuple[int, int],
    cells: str,
    distortion: float,
    hinges: tuple[float, ...],
) -> meshio.Mesh:
    mesh = plate_mesh(length, width, counts, cells, hinges)
    return distorted(mesh, distortion, counts, bool(hinges)) if distortion else mesh


def same_mesh(plate: Plate, other: Plate) -> bool:
    """Return whether two plates of a vehicle have the same cells.

    Their elements may have different nodes.
    """
    cells = {kinds.ELEMENT_KINDS[element].cells for element in (plate.element, other.element)}
    return plate.counts == other.counts and plate.distortion == other.distortion and len(cells) == 1


def refusal(scene: Scene, plate: Plate, error: ModelError) -> InputError:
    """Return the error that names the scene's key."""
    contact, wall = scene.contact, scene.meshed_wall
    patch = contact.patch_length if contact else scene.corner.patch_length
    causes: dict[str, tuple[str, object]] = {
        "elements": ("plate.elements", list(plate.counts)),
        "patch_length": (f"{'contact' if contact else 'corner'}.patch_length", patch),
        "inertia": ("vehicle.yaw_inertia", scene.vehicle.yaw_inertia),
        "wall.elements": ("wall.elements", wall and list(wall.mesh[2])),
        "wall.length": ("wall.length", wall and wall.length),
    }
    if error.wrong.startswith("trailer."):
        return InputError(error.wrong, value_at(scene, error.wrong), str(error))
    return InputError(*causes[error.wrong], str(error))


def demand_steps(scene: Scene, duration: float, model: PlateModel) -> None:
    """Raise InputError for too many steps.

    duration: of the run [s].
    """
    step = model.parameters.time_step
    if step * MAX_STEPS > duration:
        return
    key, value = resources.costly_key(scene, duration)
    allowed = f"the time step would be {step:.1e} s; allowed are at most {MAX_STEPS:g} steps"
    raise InputError(key, value, allowed)


def plate_density(scene: Scene, plate: Plate, number: int = 0) -> float:
    """Return the density of a unit's plate [kg/m^3].

    Where the scene does not specify it, and for trailers, the plate has the mass of its unit.
    """
    unit, density = scene.units[number], plate.density if number == 0 else None
    return density or unit.mass / (unit.length * unit.width * plate.thickness)


def plate_properties(
    scene: Scene, plate: Plate, inertia: Inertia | None = None, number: int = 0
) -> PlateProperties:
    """Return the properties of a unit's plate.

    inertia: of its masses; by default that of the plate.
    """
    constants = plate.thickness, plate_density(scene, plate, number), plate.modulus, plate.poissons_ratio
    law = scene.material.law if scene.material else "st-venant-kirchhoff"
    return PlateProperties(*constants, plate.lumping, plate.element, law, inertia)


def step_properties(scene: Scene, longest: float) -> StepProperties:
    """Return damping and time step, which is at most `longest` [s]."""
    damping = scene.damping
    return StepProperties(
        scene.time.safety_factor,
        longest,
        damping_ratio=(damping.ratio or 0.0) if damping else 0.0,
        bulk_viscosity=(damping.bulk_viscosity or 0.0) if damping else 0.0,
        elastic_rate=(damping.rate or 0.0) if damping else 0.0,
    )


def three_meshes(scene: Scene) -> tuple[tuple[int, int], ...]:
    """Return three meshes of a scene, each twice as fine.

    The second is the scene's own mesh, or the first where it cannot be halved. The numbers of elements must be decided.
    """
    along, across = scene.needed_plate.counts
    patch, length = scene.corner.patch_length, scene.vehicle.length
    halves = along % 2 == 0 and across % 2 == 0 and along // 2 >= MIN_HALVED[0]
    halves = halves and across // 2 >= MIN_HALVED[1] and (patch is None or patch * (along // 2) >= length)
    coarse = (along // 2, across // 2) if halves else (along, across)
    return tuple((n * coarse[0], n * coarse[1]) for n in (1, 2, 4))


def refined(
    plate: Plate,
    factor: float = 2.0,
    element: str | None = None,
    least: int = 1,
    whole: Callable[[float], int] = math.floor,
) -> Plate:
    """Return the plate with `factor` times the elements along both sides.

    element: their kind, by default that of the plate; least: smallest number along a side; whole: rounds it.
    """
    along, across = (max(least, whole(factor * count)) for count in plate.counts)
    changed = {} if element is None else {"element": element}
    return plate.model_copy(update={"elements": (along, across), **changed})


def comparable_plate(plate: Plate) -> Plate:
    """Return the plate for static mesh tests.

    It has higher-order elements, or a coarser mesh than a large one.
    """
    if math.prod(plate.counts) > HIGHER_ORDER_UP_TO:
        while math.prod(plate.counts) > HIGHER_ORDER_UP_TO:
            plate = refined(plate, 0.5)
        return plate
    if higher := kinds.ELEMENT_KINDS[plate.element].higher_order:
        # With row sums the corners of quadratic triangles have no mass.
        return plate.model_copy(update={"element": higher, "lumping": "exact"})
    return refined(plate)
