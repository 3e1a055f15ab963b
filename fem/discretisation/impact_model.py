"""The model of a whole impact: the plate, and its boundary in unilateral contact with the wall."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fem.constitutive.materials import MATERIALS
from fem.contact.boundary import wall_contact
from fem.discretisation.model import PlateModel, assemble, carried_span, plate_viscosity, with_elastic_damping
from fem.discretisation.properties import ContactProperties, PlateProperties, StepProperties, WallProperties
from fem.discretisation.spectrum import Spectrum
from fem.discretisation.stiffness import stiffness_matrix
from fem.explicit.impact_loop import ImpactLoop
from fem.start.elastic import ElasticSolver

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
    d, moduli, masses, stiffness, hourglass = assemble(mesh, plate)
    spectrum = Spectrum(stiffness, masses)  # contact does not bound the step: fem.contact.unilateral
    viscosity = plate_viscosity(d, plate, step, spectrum.frequency)
    damping = None if viscosity is None else stiffness_matrix(d.scalar, plate.thickness, viscosity)
    loop = ImpactLoop(
        table=d.table,
        material=MATERIALS[plate.material].make(plate.youngs_modulus, plate.poissons_ratio),
        mass=masses,
        contact=wall_contact(d, masses, plate, contact),
        viscosity=viscosity,
        hourglass=hourglass,
        elastic_damping=None,
        time_step=math.nan,
        span=carried_span(d),
        wall=None,
    )
    undamped = spectrum.stable_time_step(damping)
    elastic = ElasticSolver(stiffness, masses, d.positions)
    model = PlateModel(
        d, stiffness, spectrum.frequency, undamped, math.nan, loop, moduli, plate.thickness, elastic
    )
    model = with_elastic_damping(model, step)
    if wall is None:
        return model
    from fem.discretisation.wall_model import with_wall

    return with_wall(model, wall, step)
