"""From a mesh and properties to a model: everything a run needs that does not change during it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.corner import Corner
from fem.elements import Discretisation, discretise
from fem.mass import exact_inertia_masses, row_sum_masses
from fem.materials import st_venant_kirchhoff
from fem.stiffness import Spectrum, stiffness_matrix
from fem.time_loop import LoopParameters

if TYPE_CHECKING:
    import meshio

MASSES = {"exact": exact_inertia_masses, "row-sum": row_sum_masses}
"""Ways to lump the mass, by name."""


@dataclass(frozen=True)
class PlateProperties:
    """Thickness [m], density [kg/m^3], Young's modulus [Pa], Poisson's ratio; how the mass is lumped."""

    thickness: float
    density: float
    youngs_modulus: float
    poissons_ratio: float
    lumping: str = "exact"


@dataclass(frozen=True)
class StepProperties:
    """Share of the stable time step that is taken; an upper bound [s] on it; damping ratio at the highest frequency."""

    safety_factor: float = 0.9
    longest: float = np.inf
    damping_ratio: float = 0.0


@dataclass(frozen=True)
class PlateModel:
    """The plate, its corner and its time step."""

    discretisation: Discretisation
    stiffness: Any  # scipy.sparse, body frame [N/m]
    highest_frequency: float  # [rad/s], corner's spring included
    stable_time_step: float  # [s]
    loop: LoopParameters

    @property
    def mass(self) -> float:
        """Mass of the plate [kg]."""
        return float(self.loop.mass.sum())


def penalty_stiffness(plate: PlateProperties, scale: float) -> float:
    """The program's choice of corner stiffness [N/m], Young's modulus times thickness, times `scale`.

    It is of the size of an element's own stiffness, so that it costs little time step, and the corner gives way
    under the reaction by no more than the plate beside it.
    """
    return scale * plate.youngs_modulus * plate.thickness


def build_model(
    mesh: meshio.Mesh, plate: PlateProperties, penalty_scale: float, friction: Any, step: StepProperties
) -> PlateModel:
    """Assemble the model on a plate mesh in its body frame.

    friction: a law of `fem.corner`, or None. Raises ValueError where the mesh cannot carry the exact inertia.
    """
    discretisation = discretise(mesh, plate.thickness)
    material = st_venant_kirchhoff(plate.youngs_modulus, plate.poissons_ratio)
    masses = MASSES[plate.lumping](discretisation.scalar, plate.density, plate.thickness)
    stiffness = stiffness_matrix(discretisation.scalar, plate.thickness, material)
    corner = Corner(discretisation.corner, penalty_stiffness(plate, penalty_scale))
    spectrum = Spectrum(stiffness, masses, corner.node, corner.penalty_stiffness)
    frequency = spectrum.highest_frequency()
    viscosity = 2.0 * step.damping_ratio / frequency if step.damping_ratio else None
    stable = spectrum.stable_time_step(frequency, viscosity)
    loop = LoopParameters(
        table=discretisation.table,
        material=material,
        mass=masses,
        corner=corner,
        friction=friction,
        viscosity=viscosity,
        time_step=min(step.safety_factor * stable, step.longest),
    )
    return PlateModel(discretisation, stiffness, frequency, stable, loop)
