"""The plate's model by a scene's tables: what the program chose, mesh, modulus, properties for `fem`.

A plate on another mesh, or of higher-order elements, by which the error of a run is estimated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fem import cache
from fem.plate import kinds
from fem.plate.properties import Inertia, ModelError, PlateProperties, StepProperties
from meshes import distorted, plate_mesh
from tailslap.case import resources
from tailslap.errors import InputError
from tailslap.scene.schema import Plate, Scene
from tailslap.scene.vary import value_at

if TYPE_CHECKING:
    import meshio

    from fem.model.plate_model import PlateModel


MAX_STEPS = 2_000_000_000
"""A run above this is refused: it would take days, and its instants could not be distinguished."""

LARGE = 10_000
"""Elements from which on a mesh is not cached."""

REFERENCE_MODULUS = 1e9
"""Young's modulus [Pa] with which a first frequency is looked for; any would do."""


@dataclass(frozen=True)
class Decision:
    """A key of the scene, the value that the program gave it, and why. value None: it stays out."""

    key: str
    value: Any
    why: str

    @property
    def shown(self) -> str:
        """The decision as a line."""
        value = "none" if self.value is None else _shown(self.value)
        return f"{self.key} = {value}: {self.why}"


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return f"[{', '.join(map(str, value))}]" if isinstance(value, tuple) else str(value)


def threads_decision(asked: int, most: int, why: str) -> tuple[Decision, ...]:
    """The threads of a time loop that has use for fewer than were asked for."""
    return (Decision("time.threads", most, f"{asked} were requested; {why}"),) if asked > most else ()


def resolved_plate(
    scene: Scene, plate: Plate, mesh: meshio.Mesh | None = None, inertia: Inertia | None = None
) -> Plate:
    """The plate with its modulus: its own, or the one that its first frequency asks for. Raises InputError."""
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
    """The mesh of a unit's plate in its body frame; number: of the unit, 0 for the vehicle."""
    unit, counts = scene.units[number], unit_counts(scene, plate, number)
    hinges = [*(own.kingpin for own in scene.trailer[number - 1 : number] if number)]
    hinges += [behind.hitch for behind in scene.trailer[number : number + 1]]
    make = _mesh if math.prod(counts) < LARGE else _mesh.__wrapped__
    cells = kinds.ELEMENT_KINDS[plate.element].cells
    mesh: meshio.Mesh = make(unit.length, unit.width, counts, cells, plate.distortion, tuple(hinges))
    return mesh


def unit_counts(scene: Scene, plate: Plate, number: int) -> tuple[int, int]:
    """Elements along and across a unit: a trailer's are as large as the vehicle's, and even across where those are."""
    if number == 0:
        return plate.counts
    (along, across), unit, vehicle = plate.counts, scene.units[number], scene.vehicle
    step = 1 if across % 2 else 2  # even: a row of nodes on the middle line, on which the hinges are
    across = step * max(1, round(across * unit.width / vehicle.width / step))
    return max(1, round(along * unit.length / vehicle.length)), across


@cache.cached("mesh")
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
    """Tell whether two plates of a vehicle have one mesh, whatever nodes their elements add to it."""
    cells = (kinds.ELEMENT_KINDS[each.element].cells for each in (plate, other))
    return plate.counts == other.counts and plate.distortion == other.distortion and len(set(cells)) == 1


def refusal(scene: Scene, plate: Plate, error: ModelError) -> InputError:
    """The message that names the scene's key where no model can be made."""
    contact, wall = scene.contact, scene.wall
    patch = contact.patch_length if contact else scene.corner.patch_length
    given = {
        "elements": ("plate.elements", list(plate.counts)),
        "patch_length": (f"{'contact' if contact else 'corner'}.patch_length", patch),
        "inertia": ("vehicle.yaw_inertia", scene.vehicle.yaw_inertia),
        "wall.elements": ("wall.elements", wall and list(wall.elements)),
        "wall.length": ("wall.length", wall and wall.length),
    }
    if error.wrong.startswith("trailer."):
        return InputError(error.wrong, value_at(scene, error.wrong), str(error))
    return InputError(*given[error.wrong], str(error))


def demand_steps(scene: Scene, duration: float, model: PlateModel) -> None:
    """Raise InputError where a run of the model over this time [s] would never end."""
    if model.loop.time_step * MAX_STEPS > duration:
        return
    key, given = resources.costly_key(scene, duration)
    allowed = f"the time step would be {model.loop.time_step:.1e} s; allowed are at most {MAX_STEPS:g} steps"
    raise InputError(key, given, allowed)


def plate_density(scene: Scene, plate: Plate, number: int = 0) -> float:
    """The density of a unit's plate [kg/m^3]; the vehicle's left out, and of trailers, the mass spread over it."""
    unit, own = scene.units[number], plate.density if number == 0 else None
    return own or unit.mass / (unit.length * unit.width * plate.thickness)


def plate_properties(
    scene: Scene, plate: Plate, inertia: Inertia | None = None, number: int = 0
) -> PlateProperties:
    """Make the properties of a unit's plate; inertia: that its masses carry, where it is not the plate's own."""
    given = plate.thickness, plate_density(scene, plate, number), plate.modulus, plate.poissons_ratio
    law = scene.material.law if scene.material else "st-venant-kirchhoff"
    return PlateProperties(*given, plate.lumping, plate.element, law, inertia)


def step_properties(scene: Scene, longest: float) -> StepProperties:
    """Time step, no longer than this [s], and damping."""
    damping = scene.damping
    return StepProperties(
        scene.time.safety_factor,
        longest,
        damping_ratio=(damping.ratio or 0.0) if damping else 0.0,
        bulk_viscosity=(damping.bulk_viscosity or 0.0) if damping else 0.0,
        elastic_rate=(damping.rate or 0.0) if damping else 0.0,
    )


HIGHER_ORDER_UP_TO = 20_000
"""Elements above which statics judges the mesh by a coarser one, of at most so many."""


def refined(
    plate: Plate,
    factor: float = 2.0,
    element: str | None = None,
    least: int = 1,
    whole: Callable[[float], int] = math.floor,
) -> Plate:
    """The plate with `factor` times the elements each way, at least `least`, of another kind where one is given.

    whole: how their number is rounded.
    """
    along, across = (max(least, whole(factor * count)) for count in plate.counts)
    other = {} if element is None else {"element": element}
    return plate.model_copy(update={"elements": (along, across), **other})


def comparable_plate(plate: Plate) -> Plate:
    """The plate by which statics judges the mesh: higher-order elements, of a large mesh a coarser one."""
    if math.prod(plate.counts) > HIGHER_ORDER_UP_TO:
        while math.prod(plate.counts) > HIGHER_ORDER_UP_TO:
            plate = refined(plate, 0.5)
        return plate
    if higher := kinds.ELEMENT_KINDS[plate.element].higher_order:
        # Row sums give the corners of quadratic triangles no mass.
        return plate.model_copy(update={"element": higher, "lumping": "exact"})
    return refined(plate)
