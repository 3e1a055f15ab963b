"""Elements of the plate where the scene leaves them open: for this vehicle's proportions, and fine enough."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fem.plate.kinds import LUMPINGS
from tailslap.case.corner.rigid import RigidStages
from tailslap.case.cost import ELEMENTS
from tailslap.errors import InputError
from tailslap.planning.decisions import Decision
from tailslap.planning.fe_model import fe_input, fe_mesh, refusal, resolved_plate, same_mesh
from tailslap.planning.flexibility import centre_travel, comparable_plate, rigid_start
from tailslap.scene.schema import Plate

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel

STRETCH = 1.23
"""Length over height of an element of the first mesh that is tried: the paper's 20 x 6."""

MESH_SHARE, MESH_FLOOR = 0.1, 2e-5
"""Share of the plate's flexibility that may be the mesh's doing before richer elements are tried, and what is always
let pass: the difference from the rigid motion is of that size itself."""

MAX_CHOSEN = 2000
"""Elements up to which the program refines by itself."""


@dataclass(frozen=True)
class Mesh:
    """A plate with all its elements chosen and its modulus resolved, its static model and mass [kg].

    Over the centre's way to the wall: static deflection of this model and of the comparable one, and deflection of the
    corner's constraint.
    """

    plate: Plate
    model: PlateModel
    mass: float
    deflection_ratio: float
    other_deflection_ratio: float
    spring_share: float

    @property
    def fine_enough(self) -> bool:
        """Whether what the mesh does to the plate's flexibility is of no account."""
        allowed = max(MESH_FLOOR, MESH_SHARE * max(self.deflection_ratio, self.other_deflection_ratio))
        return abs(self.deflection_ratio - self.other_deflection_ratio) <= allowed


def decide_mesh(plan: RigidStages, plate: Plate) -> tuple[Mesh, tuple[Decision, ...]]:
    """The plate with its elements; what was left open is chosen by statics, without a run. Raises InputError."""
    open_keys = [key for key in ("elements", "element") if key not in plate.model_fields_set]
    chosen: Mesh | None = None
    for candidate in _candidates(plan, plate):
        try:
            made = make_mesh(plan, candidate)
        except InputError:
            if chosen is None and candidate.element == "quad9":
                raise
            continue
        if chosen is None or plate.elements is None or made.fine_enough:
            chosen = made
        if made.fine_enough or not open_keys:
            break
    chosen = chosen or make_mesh(plan, next(_candidates(plan, plate)))
    return chosen, tuple(
        Decision(f"plate.{key}", getattr(chosen.plate, key), _why(plate, key))
        for key in open_keys
        if getattr(chosen.plate, key) != getattr(plate, key)
    )


def make_mesh(plan: RigidStages, plate: Plate) -> Mesh:
    """The plate's static model, its deflection and its gap, and the comparable plate's deflection. Raises InputError.

    The two models share a mesh where only their elements differ.
    """
    from fem.model.plate_model import static_model
    from fem.plate.kinds import ModelError
    from fem.start.inertia_relief import statics

    travel, start, mesh = centre_travel(plan), rigid_start(plan), fe_mesh(plan.scene, plate)
    plate = resolved_plate(plan.scene, plate, mesh)
    other = comparable_plate(plate)
    meshes = (mesh, mesh if same_mesh(plate, other) else fe_mesh(plan.scene, other))
    inputs, models = (fe_input(plan, plate), fe_input(plan, other)), []
    for each, its_mesh, its_plate in zip(inputs, meshes, (plate, other), strict=True):
        try:
            models.append(static_model(its_mesh, each.plate, each.corner))
        except ModelError as error:
            raise refusal(plan.scene, its_plate, error) from None
    model, mine, its = models[0], statics(models[0], start), statics(models[1], start)
    deflection_ratio, other_deflection_ratio, gap = (
        abs(mine.deflection) / travel,
        abs(its.deflection) / travel,
        abs(mine.gap) / travel,
    )
    return Mesh(plate, model, model.mass, deflection_ratio, other_deflection_ratio, gap)


def _candidates(plan: RigidStages, plate: Plate) -> Iterator[Plate]:
    """From cheap to dear: the element as it is, quadratic ones, and where the counts are open, more of them."""
    counts = plate.elements or _first_counts(plan)
    chosen = "element" in plate.model_fields_set or LUMPINGS[plate.lumping].row_sums
    elements = (plate.element,) if chosen else ("quad4", "quad9")
    while True:
        for element in elements:
            yield plate.model_copy(update={"elements": counts, "element": element})
        counts = (2 * counts[0], 2 * counts[1])
        if plate.elements is not None or math.prod(counts) > MAX_CHOSEN:
            return


def _first_counts(plan: RigidStages) -> tuple[int, int]:
    length, width = plan.body.length, plan.body.width
    height = math.sqrt(length * width / (ELEMENTS * STRETCH))
    patch = plan.scene.corner.patch_length or length
    along = max(round(length / (STRETCH * height)), 2, math.ceil(length / patch))
    return min(along, 1000), max(2, round(width / height))


def _why(plate: Plate, key: str) -> str:
    if key == "element" and plate.elements is not None:
        return "on this mesh linear elements are too stiff for the plate's flexibility"
    if key == "element":
        return "linear elements are too stiff in bending"
    return "left open; elements of about this proportion, fine enough for the plate's flexibility"
