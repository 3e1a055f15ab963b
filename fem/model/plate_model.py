"""The model of the constrained plate, from a mesh and properties: everything a run needs that does not change during
it.

Runs share the plate alone with a Young's modulus of 1 Pa (`UnitPlate`): their stiffness is in proportion to its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.explicit.elastic_damping import damped_time_step, elastic_damping
from fem.explicit.internal_force import Viscosity
from fem.explicit.time_loop import LoopParameters
from fem.laws.constraints import CONSTRAINTS, ConstraintInput
from fem.laws.corner import Corner
from fem.laws.materials import MATERIALS, StVenantKirchhoff, st_venant_kirchhoff
from fem.lazy import cached
from fem.model.contact_points import corner_weights
from fem.plate.elastic import ElasticSolver, Inverse, lowest_frequency
from fem.plate.elements import (
    Discretisation,
    Hourglass,
    discretise,
    hourglass_control,
    hourglass_matrix,
    stiffness_matrix,
)
from fem.plate.kinds import (
    ELEMENT_KINDS,
    LUMPINGS,
    CornerProperties,
    PlateProperties,
    StepProperties,
    given_inertia_masses,
)
from fem.plate.spectrum import Hold, ScaledSpectrum, hold_of, spectrum_of

if TYPE_CHECKING:
    import meshio

    from fem.plate.windows import WindowBound


LARGE = 10_000
"""Nodes from which on a plate is not kept."""


@dataclass(frozen=True, eq=False)
class UnitPlate:
    """The plate of unit modulus.

    Attributes
    ----------
    discretisation : Discretisation
        Nodes and elements.
    masses : ndarray, shape (nodes,)
        [kg].
    hourglass : Hourglass or None
        Control of what one point does not see, its stiffness over the modulus.
    inverse : Inverse
        Of the stiffness, which it holds, over the modulus [m].
    """

    discretisation: Discretisation
    masses: np.ndarray
    hourglass: Hourglass | None
    inverse: Inverse


def unit_plate(mesh: meshio.Mesh, plate: PlateProperties) -> UnitPlate:
    """The plate of these properties but for modulus and material, which it has none of.

    Raises ModelError where the mesh cannot carry the inertia.
    """
    assemble = _assembled if len(mesh.points) < LARGE else _assembled.__wrapped__
    made: UnitPlate = assemble(mesh, replace(plate, youngs_modulus=1.0, material=""))
    return made


@cached("assembly")
def _assembled(mesh: meshio.Mesh, plate: PlateProperties) -> UnitPlate:
    d = discretise(mesh, plate.thickness, plate.element)
    moduli = st_venant_kirchhoff(1.0, plate.poissons_ratio)
    masses = LUMPINGS[plate.lumping].masses(d.scalar, plate.density, plate.thickness)
    if plate.inertia is not None:
        masses = given_inertia_masses(d.positions, masses, plate.inertia)
    stiffness: Any = stiffness_matrix(d.scalar, plate.thickness, moduli)
    hourglass = _hourglass(d, plate, moduli)
    if hourglass is not None:
        stiffness = stiffness + hourglass_matrix(d.table, hourglass, masses.size)
    return UnitPlate(d, masses, hourglass, Inverse(stiffness, masses, d.positions))


def _hourglass(d: Discretisation, plate: PlateProperties, moduli: StVenantKirchhoff) -> Hourglass | None:
    if not ELEMENT_KINDS[plate.element].hourglass:
        return None
    return hourglass_control(d, plate.thickness, moduli)


WINDOWS_FROM = 100_000
"""Nodes from which on the highest frequency of a uniform plate is bounded by windows of it."""


@dataclass(frozen=True)
class PlateModel:
    """The plate, its corner and its time step.

    Attributes
    ----------
    discretisation : Discretisation
        Nodes and elements.
    highest_frequency : float
        The corner's constraint included [rad/s].
    undamped_time_step, stable_time_step : float
        Largest stable step without damping of elastic velocities, and with it [s].
    loop : LoopParameters or ImpactLoop
        What the time loop takes.
    tangent_moduli : StVenantKirchhoff
        At small strain [Pa].
    thickness : float
        [m].
    elastic : ElasticSolver
        The stiffness inverted beside rigid motion, when it is first asked for; plates that differ in modulus share it.
    highest_mode : ndarray or None, shape (2, nodes)
        Mode of the highest frequency, times the roots of the masses, of unit length, body frame [-]; None where that is
        not known.
    """

    discretisation: Discretisation
    highest_frequency: float  # [rad/s], the corner's constraint included
    undamped_time_step: float  # [s], stable without damping of elastic velocities
    stable_time_step: float  # [s]
    loop: Any  # LoopParameters, or the ImpactLoop of a whole impact
    tangent_moduli: StVenantKirchhoff  # [Pa], at small strain
    thickness: float  # [m]
    elastic: ElasticSolver
    highest_mode: np.ndarray | None = None

    @property
    def stiffness(self) -> Any:
        """In the body frame, at rest, hourglass control included [N/m]: a sparse matrix, made anew at each call."""
        return self.elastic.modulus * self.elastic.inverse.stiffness

    @property
    def mass(self) -> float:
        """Mass of the plate [kg]."""
        return float(self.loop.mass.sum())


def build_model(
    mesh: meshio.Mesh, plate: PlateProperties, corner: CornerProperties, step: StepProperties
) -> PlateModel:
    """Assemble the model on a plate mesh in its body frame.

    Parameters
    ----------
    mesh : meshio.Mesh
        With the groups "corner_p" and "side_pe".
    plate : PlateProperties
        What the plate is made of.
    corner : CornerProperties
        How the corner is held.
    step : StepProperties
        Time step and damping.

    Returns
    -------
    PlateModel
        What a run needs that does not change during it.

    Raises
    ------
    ModelError
        Where the mesh cannot carry the exact inertia, or has too few nodes for the support patch.
    """
    return finished_model(static_model(mesh, plate, corner), plate, corner, step)


def finished_model(
    model: PlateModel, plate: PlateProperties, corner: CornerProperties, step: StepProperties
) -> PlateModel:
    """The static model of the same properties with its highest frequency, damping and time step."""
    held = hold_of(model.loop.corner, corner.angles, plate.youngs_modulus)
    return with_time_step(model, held, plate, step)


def with_time_step(model: PlateModel, held: Hold, plate: PlateProperties, step: StepProperties) -> PlateModel:
    """The model with what its spectrum tells, its corner held like that, and damping."""
    d, spectrum = model.discretisation, _spectrum(model, held, step)
    viscosity = plate_viscosity(d, plate, step, spectrum.frequency)
    damping = None if viscosity is None else stiffness_matrix(d.scalar, plate.thickness, viscosity)
    model = replace(
        model,
        highest_frequency=spectrum.frequency,
        highest_mode=spectrum.mode,
        undamped_time_step=spectrum.stable_time_step(damping),
        loop=model.loop._replace(viscosity=viscosity),
    )
    return with_elastic_damping(model, step)


def _spectrum(model: PlateModel, held: Hold, step: StepProperties) -> ScaledSpectrum | WindowBound:
    """The spectrum, or of large uniform plates without other damping than of elastic velocities its bound."""
    damped = held.dashpot or step.damping_ratio or step.bulk_viscosity
    if (
        model.loop.mass.size >= WINDOWS_FROM
        and model.discretisation.table.weights.shape[1] == 1
        and not damped
    ):
        from fem.plate.windows import Windows

        windows = Windows(model.discretisation, model.loop.mass, model.tangent_moduli, model.loop.hourglass)
        if windows.even:
            return windows.bound(held.of_modulus(model.elastic.modulus))
    return spectrum_of(model.elastic, held)


def with_constraint(model: PlateModel, plate: PlateProperties, corner: CornerProperties) -> PlateModel:
    """The static model with another constraint of its corner."""
    constrained = _corner(model.discretisation, model.loop.mass, plate, corner)
    return replace(model, loop=model.loop._replace(corner=constrained))


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
    unit, moduli = unit_plate(mesh, plate), st_venant_kirchhoff(plate.youngs_modulus, plate.poissons_ratio)
    loop = LoopParameters(
        table=unit.discretisation.table,
        material=MATERIALS[plate.material].make(plate.youngs_modulus, plate.poissons_ratio),
        mass=unit.masses,
        corner=_corner(unit.discretisation, unit.masses, plate, corner),
        friction=corner.friction,
        viscosity=None,
        hourglass=hourglass_of(unit, plate),
        elastic_damping=None,
        time_step=math.nan,
        span=carried_span(unit.discretisation),
    )
    return unfinished_model(unit, plate, moduli, loop)


def unfinished_model(
    unit: UnitPlate, plate: PlateProperties, moduli: StVenantKirchhoff, loop: Any
) -> PlateModel:
    """A model of this plate and this loop without frequency and time step."""
    modulus = plate.youngs_modulus
    return PlateModel(
        discretisation=unit.discretisation,
        highest_frequency=math.nan,
        undamped_time_step=math.nan,
        stable_time_step=math.nan,
        loop=loop,
        tangent_moduli=moduli,
        thickness=plate.thickness,
        elastic=ElasticSolver(unit.inverse, modulus),
    )


def hourglass_of(unit: UnitPlate, plate: PlateProperties) -> Hourglass | None:
    """Its control with the plate's modulus."""
    if unit.hourglass is None:
        return None
    return unit.hourglass._replace(stiffness=plate.youngs_modulus * unit.hourglass.stiffness)


def modulus_for(mesh: meshio.Mesh, plate: PlateProperties, first_frequency: float) -> float:
    """Young's modulus [Pa] that gives the free plate this first elastic frequency in its plane [Hz].

    The stiffness is in proportion to the modulus: the frequency with the modulus of `plate` tells the other.
    Raises ModelError where the mesh cannot carry the exact inertia.
    """
    frequency = lowest_frequency(ElasticSolver(unit_plate(mesh, plate).inverse, plate.youngs_modulus))
    return plate.youngs_modulus * (first_frequency / frequency) ** 2


def _corner(
    d: Discretisation, masses: np.ndarray, plate: PlateProperties, corner: CornerProperties
) -> Corner:
    nodes, weights = corner_weights(d, corner.patch_length)
    mobility = float((weights**2 / masses[nodes]).sum())
    given = ConstraintInput(
        plate.youngs_modulus, plate.thickness, mobility, corner.penalty_scale, corner.damping_ratio
    )
    return Corner(nodes, weights, mobility, CONSTRAINTS[corner.constraint].make(given))


def carried_span(discretisation: Discretisation) -> float:
    """By how much [m] the origin follows the plate: a power of two near an eighth of its length."""
    return 2.0 ** math.floor(math.log2(np.ptp(discretisation.positions[0]) / 8.0))


def plate_viscosity(
    d: Discretisation, plate: PlateProperties, step: StepProperties, frequency: float
) -> Viscosity | None:
    if not (step.damping_ratio or step.bulk_viscosity):
        return None
    moduli = st_venant_kirchhoff(plate.youngs_modulus, plate.poissons_ratio)
    time = 2.0 * step.damping_ratio / frequency
    size = math.sqrt(float(d.scalar.dx.sum(axis=1).min()))
    bulk = step.bulk_viscosity * math.sqrt(plate.density * moduli.c_11) * size
    return Viscosity(time * moduli.c_11 + bulk, time * moduli.c_12 + bulk, time * moduli.c_33)
