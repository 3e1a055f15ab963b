"""The model of a whole impact: the plate, and its boundary in unilateral contact with the wall."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fem.constitutive.materials import MATERIALS, st_venant_kirchhoff
from fem.contact.boundary import wall_contact
from fem.discretisation.model import PlateModel, carried_span, hourglass_of, unfinished_model, with_time_step
from fem.discretisation.properties import ContactProperties, PlateProperties, StepProperties, WallProperties
from fem.discretisation.spectrum import FREE
from fem.discretisation.unit_plate import unit_plate
from fem.explicit.impact_loop import ImpactLoop

if TYPE_CHECKING:
    import meshio


def build_impact_model(
    mesh: meshio.Mesh,
    plate: PlateProperties,
    contact: ContactProperties,
    step: StepProperties,
    wall: WallProperties | None = None,
) -> PlateModel:
    """Assemble the model on a plate mesh in its body frame.

    Parameters
    ----------
    mesh : meshio.Mesh
        With the groups "corner_p" and "side_pe".
    plate : PlateProperties
        What the plate is made of.
    contact : ContactProperties
        How its boundary touches the wall.
    step : StepProperties
        Time step and damping.
    wall : WallProperties or None
        One that gives; None for a rigid one.

    Returns
    -------
    PlateModel
        Its `loop` is an `ImpactLoop`.

    Raises
    ------
    ModelError
        Where the mesh cannot carry the inertia, or has too few nodes for the patch of a corner; where the wall has no
        foundation or too many elements.
    """
    unit, moduli = unit_plate(mesh, plate), st_venant_kirchhoff(plate.youngs_modulus, plate.poissons_ratio)
    loop = ImpactLoop(
        table=unit.discretisation.table,
        material=MATERIALS[plate.material].make(plate.youngs_modulus, plate.poissons_ratio),
        mass=unit.masses,
        contact=wall_contact(unit.discretisation, unit.masses, plate, contact),
        viscosity=None,
        hourglass=hourglass_of(unit, plate),
        elastic_damping=None,
        time_step=math.nan,
        span=carried_span(unit.discretisation),
        wall=None,
    )
    model = unfinished_model(unit, plate, moduli, loop)
    # Contact does not bound the step: fem.contact.unilateral.
    model = with_time_step(model, FREE, plate, step)
    if wall is None:
        return model
    from fem.discretisation.wall_model import with_wall

    return with_wall(model, wall, step)
