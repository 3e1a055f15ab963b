"""Model of the constrained plate, from a mesh and properties.

It has everything that does not change during a run. Runs have only the plate with a Young's modulus of 1 Pa
(`UnitPlate`) in common, because the stiffness is in proportion to the modulus.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.cache import cached
from fem.explicit import elastic_damping, internal_force, time_loop
from fem.laws import constraints, materials
from fem.laws.constraints import CornerConstraint
from fem.plate import kinds
from fem.plate.discretisation import (
    Discretisation,
    Hourglass,
    corner_weights,
    discretise,
    hourglass_control,
    hourglass_matrix,
    stiffness_matrix,
)
from fem.plate.elastic import ElasticSolver, Inverse
from fem.plate.free_modes import lowest_frequency
from fem.plate.nodal_masses import prescribed_inertia_masses
from fem.plate.properties import CornerProperties, PlateProperties, StepProperties
from fem.plate.spectrum import LARGE, ScaledSpectrum, spectrum_of
from fem.plate.support import Support, corner_support

if TYPE_CHECKING:
    import meshio
    from scipy.sparse import csr_matrix

    from fem.laws.hinges import Hinges
    from fem.plate.windows import WindowBound

WINDOWS_FROM = 100_000
"""Number of nodes from which on windows bound a uniform plate's highest frequency."""


@dataclass(frozen=True, eq=False)
class UnitPlate:
    """The plate of unit modulus.

    Attributes
    ----------
    discretisation : Discretisation
        Nodes and elements.
    masses : ndarray, shape (nodes,)
        Nodal masses [kg].
    hourglass : Hourglass or None
        Hourglass control, its stiffness over the modulus.
    inverse : Inverse
        Inverse of the stiffness over the modulus [m], which it contains.
    """

    discretisation: Discretisation
    masses: np.ndarray
    hourglass: Hourglass | None
    inverse: Inverse


def unit_plate(mesh: meshio.Mesh, plate: PlateProperties) -> UnitPlate:
    """Return the plate of unit modulus with these properties.

    Modulus and material are ignored. Raises ModelError where the mesh cannot carry the inertia.
    """
    assemble = _assembled if len(mesh.points) < LARGE else _assembled.__wrapped__
    return assemble(mesh, replace(plate, youngs_modulus=1.0, material=""))


@cached
def _assembled(mesh: meshio.Mesh, plate: PlateProperties) -> UnitPlate:
    """Discretise and assemble a plate of unit modulus."""
    d = discretise(mesh, plate.thickness, plate.element)
    return assembled(d, nodal_masses(d, plate), plate)


def nodal_masses(d: Discretisation, plate: PlateProperties) -> np.ndarray:
    """Return the masses of the nodes [kg] with the prescribed inertia.

    Raises ModelError.
    """
    masses = kinds.LUMPINGS[plate.lumping].masses(d.scalar, plate.density, plate.thickness)
    if plate.inertia is not None:
        masses = prescribed_inertia_masses(d.positions, masses, plate.inertia)
    return masses


def assembled(
    d: Discretisation, masses: np.ndarray, plate: PlateProperties, hinges: Hinges | None = None
) -> UnitPlate:
    """Assemble the plate of unit modulus with these nodal masses [kg].

    hinges: of a train.
    """
    moduli = materials.st_venant_kirchhoff(1.0, plate.poissons_ratio)
    stiffness = stiffness_matrix(d.table, moduli)
    hourglass = None
    if kinds.ELEMENT_KINDS[plate.element].hourglass:
        hourglass = hourglass_control(d, plate.thickness, moduli)
        stiffness = stiffness + hourglass_matrix(d.table, hourglass, masses.size)
    return UnitPlate(d, masses, hourglass, Inverse(stiffness, masses, d.positions, hinges))


@dataclass(frozen=True)
class PlateModel:
    """The plate with its corner and its time step.

    Attributes
    ----------
    discretisation : Discretisation
        Nodes and elements.
    highest_frequency : float
        Highest frequency with the corner's constraint [rad/s].
    undamped_time_step, stable_time_step : float
        Largest stable step without damping of elastic velocities, and with it [s].
    parameters : LoopParameters or ImpactLoopParameters
        Parameters of the time loop.
    tangent_moduli : StVenantKirchhoff
        Moduli at small strain [Pa].
    thickness : float
        Thickness [m].
    elastic : ElasticSolver
        Inverse of the stiffness without rigid motion, computed on first use;
        plates that differ in modulus have it in common.
    highest_mode : ndarray or None, shape (2, nodes)
        Mode of the highest frequency, times the square roots of the masses, of unit length, body frame [-]; None
        where there is none.
    contact_groups : ndarray or None, shape (contact points,)
        Number of the group of each contact point of a whole impact [-].
    """

    discretisation: Discretisation
    highest_frequency: float
    undamped_time_step: float
    stable_time_step: float
    parameters: Any
    tangent_moduli: materials.StVenantKirchhoff
    thickness: float
    elastic: ElasticSolver
    highest_mode: np.ndarray | None = None
    contact_groups: np.ndarray | None = None

    @property
    def stiffness(self) -> csr_matrix:
        """Stiffness in the body frame at rest, with hourglass control [N/m].

        It is a sparse matrix, computed at each call.
        """
        return self.elastic.modulus * self.elastic.inverse.stiffness

    @property
    def mass(self) -> float:
        """Mass of the plate [kg]."""
        return float(self.parameters.mass.sum())


def build_model(
    mesh: meshio.Mesh, plate: PlateProperties, corner: CornerProperties, step: StepProperties
) -> PlateModel:
    """Assemble the model of a constrained plate.

    Parameters
    ----------
    mesh : meshio.Mesh
        Mesh with the groups "corner_p" and "side_pe".
    plate : PlateProperties
        Properties of the plate.
    corner : CornerProperties
        Constraint of the corner.
    step : StepProperties
        Time step and damping.

    Returns
    -------
    PlateModel
        Everything that does not change during a run.

    Raises
    ------
    ModelError
        Where the mesh cannot carry the exact inertia, or has too few nodes for the support patch.
    """
    return finished_model(static_model(mesh, plate, corner), plate, corner, step)


def finished_model(
    model: PlateModel, plate: PlateProperties, corner: CornerProperties, step: StepProperties
) -> PlateModel:
    """Complete a static model of the same properties.

    The result has highest frequency, damping and time step.
    """
    support = corner_support(model.parameters.corner, corner.angles, plate.youngs_modulus)
    return with_time_step(model, support, plate, step)


def with_time_step(
    model: PlateModel, support: Support, plate: PlateProperties, step: StepProperties
) -> PlateModel:
    """Return the model with frequency, viscosity and time step for this support."""
    d, spectrum = model.discretisation, _spectrum(model, support, step)
    viscosity = plate_viscosity(d, plate, step, spectrum.frequency)
    damping = None if viscosity is None else stiffness_matrix(d.table, viscosity)
    model = replace(
        model,
        highest_frequency=spectrum.frequency,
        highest_mode=spectrum.mode,
        undamped_time_step=spectrum.stable_time_step(damping),
        parameters=model.parameters._replace(viscosity=viscosity),
    )
    return with_elastic_damping(model, step)


def _spectrum(model: PlateModel, support: Support, step: StepProperties) -> ScaledSpectrum | WindowBound:
    """Return the spectrum of the model, or its upper bound.

    The bound serves large uniform plates that have no damping except of elastic velocities.
    """
    damped = support.dashpot or step.damping_ratio or step.bulk_viscosity
    if (
        model.parameters.mass.size >= WINDOWS_FROM
        and model.discretisation.table.weights.shape[1] == 1
        and not damped
    ):
        from fem.plate.windows import Windows

        mass, hourglass = model.parameters.mass, model.parameters.hourglass
        windows = Windows(model.discretisation, mass, model.tangent_moduli, hourglass)
        if windows.are_representative:
            return windows.bound(support._replace(spring=model.elastic.modulus * support.spring))
    return spectrum_of(model.elastic, support)


def with_constraint(model: PlateModel, plate: PlateProperties, corner: CornerProperties) -> PlateModel:
    """Return the static model with another constraint of its corner."""
    constrained = _corner(model.discretisation, model.parameters.mass, plate, corner)
    return replace(model, parameters=model.parameters._replace(corner=constrained))


def with_elastic_damping(model: PlateModel, step: StepProperties) -> PlateModel:
    """Return the model with damping of elastic velocities.

    Its time step is that of the damped plate.
    """
    # The mode of this frequency bounds the step, both without damping and with it.
    stable = elastic_damping.damped_time_step(2.0 / model.undamped_time_step, step.elastic_rate)
    damping = elastic_damping.elastic_damping(step.elastic_rate, model.parameters.mass)
    time_step = min(step.safety_factor * stable, step.longest)
    parameters = model.parameters._replace(elastic_damping=damping, time_step=time_step)
    return replace(model, stable_time_step=stable, parameters=parameters)


def static_model(mesh: meshio.Mesh, plate: PlateProperties, corner: CornerProperties) -> PlateModel:
    """Return the model for statics alone.

    It has no damping, and its frequency and time steps are NaN. Raises as `build_model`.
    """
    unit = unit_plate(mesh, plate)
    constrained = _corner(unit.discretisation, unit.masses, plate, corner)
    return unfinished_model(
        unit, plate, time_loop.LoopParameters, corner=constrained, friction=corner.friction
    )


def unfinished_model(
    unit: UnitPlate, plate: PlateProperties, kind: Callable[..., object], **fields: object
) -> PlateModel:
    """Return a model without frequency, time step and damping.

    kind: type of the parameters of the time loop. fields: its fields for corner or contact.
    """
    d, modulus, hourglass = unit.discretisation, plate.youngs_modulus, unit.hourglass
    if hourglass is not None:
        hourglass = hourglass._replace(stiffness=modulus * hourglass.stiffness)
    parameters = kind(
        table=d.table,
        material=materials.MATERIALS[plate.material].make(modulus, plate.poissons_ratio),
        mass=unit.masses,
        viscosity=None,
        hourglass=hourglass,
        elastic_damping=None,
        time_step=math.nan,
        span=2.0
        ** math.floor(math.log2(np.ptp(d.positions[0]) / 8.0)),  # a power of two near an eighth of the length
        **fields,
    )
    return PlateModel(
        discretisation=d,
        highest_frequency=math.nan,
        undamped_time_step=math.nan,
        stable_time_step=math.nan,
        parameters=parameters,
        tangent_moduli=materials.st_venant_kirchhoff(modulus, plate.poissons_ratio),
        thickness=plate.thickness,
        elastic=ElasticSolver(unit.inverse, modulus),
    )


def modulus_for(mesh: meshio.Mesh, plate: PlateProperties, first_frequency: float) -> float:
    """Return Young's modulus [Pa] for a first frequency of the free plate.

    first_frequency: the lowest elastic frequency in its plane [Hz]. The frequency with the modulus of `plate`
    determines the other one, because the stiffness is in proportion to the modulus. Raises ModelError where the mesh
    cannot carry the exact inertia.
    """
    frequency = lowest_frequency(ElasticSolver(unit_plate(mesh, plate).inverse, plate.youngs_modulus))
    return plate.youngs_modulus * (first_frequency / frequency) ** 2


def _corner(
    d: Discretisation, masses: np.ndarray, plate: PlateProperties, corner: CornerProperties
) -> CornerConstraint:
    """Return the constraint of the corner."""
    nodes, weights = corner_weights(d, corner.patch_length)
    mobility = float((weights**2 / masses[nodes]).sum())
    inputs = constraints.ConstraintInput(
        plate.youngs_modulus, plate.thickness, mobility, corner.penalty_scale, corner.damping_ratio
    )
    return CornerConstraint(nodes, weights, mobility, constraints.CONSTRAINTS[corner.constraint].make(inputs))


def plate_viscosity(
    d: Discretisation, plate: PlateProperties, step: StepProperties, frequency: float
) -> internal_force.Viscosity | None:
    """Return the viscosity of the plate, or None."""
    if not (step.damping_ratio or step.bulk_viscosity):
        return None
    moduli = materials.st_venant_kirchhoff(plate.youngs_modulus, plate.poissons_ratio)
    time = 2.0 * step.damping_ratio / frequency
    size = math.sqrt(float(d.scalar.dx.sum(axis=1).min()))
    bulk = step.bulk_viscosity * math.sqrt(plate.density * moduli.c_11) * size
    return internal_force.Viscosity(time * moduli.c_11 + bulk, time * moduli.c_12 + bulk, time * moduli.c_33)
