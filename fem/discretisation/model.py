"""From a mesh and properties to a model: everything a run needs that does not change during it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.constitutive.materials import MATERIALS, StVenantKirchhoff, st_venant_kirchhoff
from fem.contact.corner import Corner, DampedPenalty, Exact, Penalty
from fem.contact.support_patch import corner_weights
from fem.discretisation.elements import (
    ELEMENT_KINDS,
    Discretisation,
    Hourglass,
    discretise,
    hourglass_control,
)
from fem.discretisation.mass import exact_inertia_masses, row_sum_masses
from fem.discretisation.stiffness import Spectrum, hourglass_matrix, stiffness_matrix
from fem.explicit.elastic_damping import damped_time_step, elastic_damping
from fem.explicit.internal_force import Viscosity
from fem.explicit.time_loop import LoopParameters
from fem.modal.modes import lowest_frequency

if TYPE_CHECKING:
    import meshio

MASSES = {"exact": exact_inertia_masses, "row-sum": row_sum_masses}
"""Ways to lump the mass, by name."""


@dataclass(frozen=True)
class PlateProperties:
    """Thickness [m], density [kg/m^3], Young's modulus [Pa], Poisson's ratio, and choices by name.

    hourglass: share of the stiffness that controls one-point elements; others have none.
    """

    thickness: float
    density: float
    youngs_modulus: float
    poissons_ratio: float
    lumping: str = "exact"
    element: str = "quad4"
    material: str = "st-venant-kirchhoff"
    hourglass: float = 0.1


@dataclass(frozen=True)
class CornerProperties:
    """How the corner is held: `penalty` with this multiple of the program's stiffness, or `exact`.

    patch_length [m]: 0 for the corner node alone. damping_ratio: of the penalty's dashpot, to critical.
    friction: a law of `fem.contact.corner`, or None. angles [rad]: of the plate during the run, for the time step.
    """

    friction: Any = None
    constraint: str = "penalty"
    penalty_scale: float = 1.0
    patch_length: float = 0.0
    damping_ratio: float = 0.0
    angles: tuple[float, ...] = (0.26, 0.13, 0.0)


@dataclass(frozen=True)
class StepProperties:
    """Share of the stable time step that is taken, an upper bound on it [s], and damping.

    damping_ratio: stiffness-proportional, to critical at the highest frequency. bulk_viscosity: linear, the
    dimensionless coefficient of density x wave speed x element size. elastic_rate [1/s]: of the elastic velocities.
    """

    safety_factor: float = 0.9
    longest: float = np.inf
    damping_ratio: float = 0.0
    bulk_viscosity: float = 0.0
    elastic_rate: float = 0.0


@dataclass(frozen=True)
class PlateModel:
    """The plate, its corner and its time step."""

    discretisation: Discretisation
    stiffness: Any  # scipy.sparse, body frame, at rest, hourglass control included [N/m]
    highest_frequency: float  # [rad/s], the corner's hold included
    undamped_time_step: float  # [s], stable without damping of elastic velocities
    stable_time_step: float  # [s]
    loop: LoopParameters
    tangent_moduli: StVenantKirchhoff  # [Pa], at small strain
    thickness: float  # [m]

    @property
    def mass(self) -> float:
        """Mass of the plate [kg]."""
        return float(self.loop.mass.sum())


def penalty_stiffness(plate: PlateProperties, scale: float) -> float:
    """The program's choice of corner stiffness [N/m], 0.3 times Young's modulus times thickness, times `scale`.

    A spring as stiff as the elements brings the corner's frequency among the plate's: with friction the two flutter
    sooner, and the time step falls by 14 %. A much softer one shows in the results, and flutters with the plate's
    lowest modes, which stiffness-proportional damping hardly reaches.
    """
    return scale * 0.3 * plate.youngs_modulus * plate.thickness


def build_model(
    mesh: meshio.Mesh, plate: PlateProperties, corner: CornerProperties, step: StepProperties
) -> PlateModel:
    """Assemble the model on a plate mesh in its body frame.

    Raises ValueError where the mesh cannot carry the exact inertia, or has too few nodes for the patch.
    """
    return finished_model(static_model(mesh, plate, corner), plate, corner, step)


def finished_model(
    model: PlateModel, plate: PlateProperties, corner: CornerProperties, step: StepProperties
) -> PlateModel:
    """The static model of the same properties with its highest frequency, damping and time step."""
    d, loop = model.discretisation, model.loop
    spectrum = Spectrum(model.stiffness, loop.mass, loop.corner, corner.angles)
    frequency = spectrum.highest_frequency()
    viscosity = _viscosity(d, plate, step, frequency)
    damping = None if viscosity is None else stiffness_matrix(d.scalar, plate.thickness, viscosity)
    model = replace(
        model,
        highest_frequency=frequency,
        undamped_time_step=spectrum.stable_time_step(frequency, damping),
        loop=loop._replace(viscosity=viscosity),
    )
    return with_elastic_damping(model, step)


def held_model(model: PlateModel, plate: PlateProperties, corner: CornerProperties) -> PlateModel:
    """The static model with its corner held in another way."""
    held = _corner(model.discretisation, model.loop.mass, plate, corner)
    return replace(model, loop=model.loop._replace(corner=held))


def with_elastic_damping(model: PlateModel, step: StepProperties) -> PlateModel:
    """The model with the step's rate of damping of elastic velocities, and the time step for it."""
    # The step that is stable without it belongs to a mode of this frequency; with it, that mode bounds the step.
    stable = damped_time_step(2.0 / model.undamped_time_step, step.elastic_rate)
    damping = elastic_damping(step.elastic_rate, model.loop.mass)
    time_step = min(step.safety_factor * stable, step.longest)
    loop = model.loop._replace(elastic_damping=damping, time_step=time_step)
    return replace(model, stable_time_step=stable, loop=loop)


def static_model(mesh: meshio.Mesh, plate: PlateProperties, corner: CornerProperties) -> PlateModel:
    """The model for statics alone: without damping, its frequency and time steps are NaN. Raises as `build_model`."""
    discretisation, moduli, masses, stiffness, hourglass = _assemble(mesh, plate)
    loop = LoopParameters(
        table=discretisation.table,
        material=MATERIALS[plate.material](plate.youngs_modulus, plate.poissons_ratio),
        mass=masses,
        corner=_corner(discretisation, masses, plate, corner),
        friction=corner.friction,
        viscosity=None,
        hourglass=hourglass,
        elastic_damping=None,
        time_step=math.nan,
        span=2.0 ** math.floor(math.log2(np.ptp(discretisation.positions[0]) / 8.0)),
    )
    return PlateModel(discretisation, stiffness, math.nan, math.nan, math.nan, loop, moduli, plate.thickness)


def modulus_for(mesh: meshio.Mesh, plate: PlateProperties, first_frequency: float) -> float:
    """Young's modulus [Pa] that gives the free plate this first elastic frequency in its plane [Hz].

    The stiffness is in proportion to the modulus: the frequency with the modulus of `plate` tells the other.
    Raises ValueError where the mesh cannot carry the exact inertia.
    """
    discretisation, _, masses, stiffness, _ = _assemble(mesh, plate)
    frequency = lowest_frequency(stiffness, masses, discretisation.positions)
    return plate.youngs_modulus * (first_frequency / frequency) ** 2


def _assemble(
    mesh: meshio.Mesh, plate: PlateProperties
) -> tuple[Discretisation, StVenantKirchhoff, np.ndarray, Any, Hourglass | None]:
    """Discretisation, moduli, masses [kg], stiffness [N/m] and hourglass control of the plate alone."""
    discretisation = discretise(mesh, plate.thickness, plate.element)
    moduli = st_venant_kirchhoff(plate.youngs_modulus, plate.poissons_ratio)
    masses = MASSES[plate.lumping](discretisation.scalar, plate.density, plate.thickness)
    stiffness: Any = stiffness_matrix(discretisation.scalar, plate.thickness, moduli)
    hourglass = _hourglass(discretisation, plate, moduli)
    if hourglass is not None:
        stiffness = stiffness + hourglass_matrix(discretisation.table, hourglass, masses.size)
    return discretisation, moduli, masses, stiffness, hourglass


def _hourglass(d: Discretisation, plate: PlateProperties, moduli: StVenantKirchhoff) -> Hourglass | None:
    if not ELEMENT_KINDS[plate.element].hourglass:
        return None
    return hourglass_control(d, plate.thickness, moduli.c_11, plate.hourglass)


def _corner(
    d: Discretisation, masses: np.ndarray, plate: PlateProperties, corner: CornerProperties
) -> Corner:
    nodes, weights = corner_weights(d, corner.patch_length)
    mobility = float((weights**2 / masses[nodes]).sum())
    if corner.constraint == "exact":
        return Corner(nodes, weights, mobility, Exact(0.0))
    stiffness = penalty_stiffness(plate, corner.penalty_scale)
    if not corner.damping_ratio:
        return Corner(nodes, weights, mobility, Penalty(stiffness))
    damping = corner.damping_ratio * 2.0 * math.sqrt(stiffness / mobility)
    return Corner(nodes, weights, mobility, DampedPenalty(stiffness, damping))


def _viscosity(
    d: Discretisation, plate: PlateProperties, step: StepProperties, frequency: float
) -> Viscosity | None:
    if not (step.damping_ratio or step.bulk_viscosity):
        return None
    moduli = st_venant_kirchhoff(plate.youngs_modulus, plate.poissons_ratio)
    time = 2.0 * step.damping_ratio / frequency
    size = math.sqrt(float(d.scalar.dx.sum(axis=1).min()))
    bulk = step.bulk_viscosity * math.sqrt(plate.density * moduli.c_11) * size
    return Viscosity(time * moduli.c_11 + bulk, time * moduli.c_12 + bulk, time * moduli.c_33)
