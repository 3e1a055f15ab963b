"""The model of the constrained plate, from a mesh and properties: everything a run needs that does not change during
it.

Runs share the plate alone with a Young's modulus of 1 Pa (`UnitPlate`): their stiffness is in proportion to its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem import lazy
from fem.explicit import elastic_damping, internal_force, time_loop
from fem.laws import constraints, materials
from fem.laws.constraints import CornerConstraint
from fem.plate import kinds
from fem.plate.discretisation import (
    Discretisation,
    Hourglass,
    discretise,
    hourglass_control,
    hourglass_matrix,
    stiffness_matrix,
)
from fem.plate.elastic import ElasticSolver, Inverse
from fem.plate.free_modes import lowest_frequency
from fem.plate.nodal_masses import prescribed_inertia_masses
from fem.plate.properties import CornerProperties, ModelError, PlateProperties, StepProperties
from fem.plate.spectrum import ScaledSpectrum, Support, corner_support, spectrum_of

if TYPE_CHECKING:
    import meshio

    from fem.laws.hinges import Hinges
    from fem.plate.windows import WindowBound


LARGE = 10_000
"""Nodes from which on a plate is not cached."""


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


@lazy.cached("assembly")
def _assembled(mesh: meshio.Mesh, plate: PlateProperties) -> UnitPlate:
    d = discretise(mesh, plate.thickness, plate.element)
    return assembled(d, nodal_masses(d, plate), plate)


def nodal_masses(d: Discretisation, plate: PlateProperties) -> np.ndarray:
    """Masses of the nodes [kg], with the inertia that the plate is given. Raises ModelError."""
    masses = kinds.LUMPINGS[plate.lumping].masses(d.scalar, plate.density, plate.thickness)
    if plate.inertia is not None:
        masses = prescribed_inertia_masses(d.positions, masses, plate.inertia)
    return masses


def assembled(
    d: Discretisation, masses: np.ndarray, plate: PlateProperties, hinges: Hinges | None = None
) -> UnitPlate:
    """The plate of unit modulus with these nodal masses [kg]; hinges: of a train."""
    moduli = materials.st_venant_kirchhoff(1.0, plate.poissons_ratio)
    stiffness: Any = stiffness_matrix(d.scalar, plate.thickness, moduli)
    hourglass = None
    if kinds.ELEMENT_KINDS[plate.element].hourglass:
        hourglass = hourglass_control(d, plate.thickness, moduli)
        stiffness = stiffness + hourglass_matrix(d.table, hourglass, masses.size)
    return UnitPlate(d, masses, hourglass, Inverse(stiffness, masses, d.positions, hinges))


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
    loop : LoopParameters or ImpactLoopParameters
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
    loop: Any  # LoopParameters, or the ImpactLoopParameters of a whole impact
    tangent_moduli: materials.StVenantKirchhoff  # [Pa], at small strain
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
    mesh: meshio.Mesh,
    plate: PlateProperties,
    corner: CornerProperties,
    step: StepProperties,
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
    model: PlateModel,
    plate: PlateProperties,
    corner: CornerProperties,
    step: StepProperties,
) -> PlateModel:
    """The static model of the same properties with its highest frequency, damping and time step."""
    held = corner_support(model.loop.corner, corner.angles, plate.youngs_modulus)
    return with_time_step(model, held, plate, step)


def with_time_step(
    model: PlateModel, held: Support, plate: PlateProperties, step: StepProperties
) -> PlateModel:
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


def _spectrum(model: PlateModel, held: Support, step: StepProperties) -> ScaledSpectrum | WindowBound:
    """The spectrum, or of large uniform plates without other damping than of elastic velocities its bound."""
    damped = held.dashpot or step.damping_ratio or step.bulk_viscosity
    if (
        model.loop.mass.size >= WINDOWS_FROM
        and model.discretisation.table.weights.shape[1] == 1
        and not damped
    ):
        from fem.plate.windows import Windows

        windows = Windows(model.discretisation, model.loop.mass, model.tangent_moduli, model.loop.hourglass)
        if windows.are_representative:
            return windows.bound(held.of_modulus(model.elastic.modulus))
    return spectrum_of(model.elastic, held)


def with_constraint(model: PlateModel, plate: PlateProperties, corner: CornerProperties) -> PlateModel:
    """The static model with another constraint of its corner."""
    constrained = _corner(model.discretisation, model.loop.mass, plate, corner)
    return replace(model, loop=model.loop._replace(corner=constrained))


def with_elastic_damping(model: PlateModel, step: StepProperties) -> PlateModel:
    """The model with the step's rate of damping of elastic velocities, and the time step for it."""
    # The step that is stable without it belongs to a mode of this frequency; with it, that mode bounds the step.
    stable = elastic_damping.damped_time_step(2.0 / model.undamped_time_step, step.elastic_rate)
    damping = elastic_damping.elastic_damping(step.elastic_rate, model.loop.mass)
    time_step = min(step.safety_factor * stable, step.longest)
    loop = model.loop._replace(elastic_damping=damping, time_step=time_step)
    return replace(model, stable_time_step=stable, loop=loop)


def static_model(mesh: meshio.Mesh, plate: PlateProperties, corner: CornerProperties) -> PlateModel:
    """The model for statics alone: without damping, its frequency and time steps are NaN. Raises as `build_model`."""
    unit = unit_plate(mesh, plate)
    held = _corner(unit.discretisation, unit.masses, plate, corner)
    return unfinished_model(unit, plate, time_loop.LoopParameters, corner=held, friction=corner.friction)


def unfinished_model(unit: UnitPlate, plate: PlateProperties, loop: Any, **others: Any) -> PlateModel:
    """A model of this plate without frequency, time step and damping; others: fields of its loop for the contact."""
    d, modulus, hourglass = unit.discretisation, plate.youngs_modulus, unit.hourglass
    if hourglass is not None:
        hourglass = hourglass._replace(stiffness=modulus * hourglass.stiffness)
    parameters = loop(
        table=d.table,
        material=materials.MATERIALS[plate.material].make(modulus, plate.poissons_ratio),
        mass=unit.masses,
        viscosity=None,
        hourglass=hourglass,
        elastic_damping=None,
        time_step=math.nan,
        span=2.0 ** math.floor(math.log2(np.ptp(d.positions[0]) / 8.0)),  # near an eighth of its length
        **others,
    )
    return PlateModel(
        discretisation=d,
        highest_frequency=math.nan,
        undamped_time_step=math.nan,
        stable_time_step=math.nan,
        loop=parameters,
        tangent_moduli=materials.st_venant_kirchhoff(modulus, plate.poissons_ratio),
        thickness=plate.thickness,
        elastic=ElasticSolver(unit.inverse, modulus),
    )


def modulus_for(mesh: meshio.Mesh, plate: PlateProperties, first_frequency: float) -> float:
    """Young's modulus [Pa] that gives the free plate this first elastic frequency in its plane [Hz].

    The stiffness is in proportion to the modulus: the frequency with the modulus of `plate` tells the other.
    Raises ModelError where the mesh cannot carry the exact inertia.
    """
    frequency = lowest_frequency(ElasticSolver(unit_plate(mesh, plate).inverse, plate.youngs_modulus))
    return plate.youngs_modulus * (first_frequency / frequency) ** 2


def _corner(
    d: Discretisation, masses: np.ndarray, plate: PlateProperties, corner: CornerProperties
) -> CornerConstraint:
    nodes, weights = corner_weights(d, corner.patch_length)
    mobility = float((weights**2 / masses[nodes]).sum())
    given = constraints.ConstraintInput(
        plate.youngs_modulus, plate.thickness, mobility, corner.penalty_scale, corner.damping_ratio
    )
    return CornerConstraint(nodes, weights, mobility, constraints.CONSTRAINTS[corner.constraint].make(given))


def corner_weights(discretisation: Discretisation, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights by which the corner P is held; length [m] of side PE, 0 for the node alone.

    The weights are the nodes' parts of w(s) = (4 - 6 s / a) / a over 0 <= s <= a: its integral is 1 and its
    first moment about P is 0, so that for every rigid motion the weighted mean is P itself. Raises ModelError
    if the length is not between two nodes and the side.
    """
    if length == 0.0:
        return np.array([discretisation.corner]), np.array([1.0])
    side = discretisation.side[np.argsort(-discretisation.positions[0, discretisation.side])]
    return patch_weights(side, -discretisation.positions[0, side], length)


def patch_weights(side: np.ndarray, s: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of a patch of this length [m]; side: nodes of a side from its corner on, s: their distances
    from it [m]. Raises ModelError if the length is not between two nodes and the side."""
    if not s[1] * (1.0 - 1e-9) <= length <= s[-1] * (1.0 + 1e-9):
        raise ModelError(
            "patch_length",
            f"a corner patch of {length:g} m does not lie between {s[1]:g} m, an element, and {s[-1]:g} m",
        )
    weights = hat_integrals(s, 0.0, length)
    used = np.abs(weights) > 0.0
    return side[used].astype(np.int64), weights[used]


def hat_integrals(s: np.ndarray, place: float, length: float) -> np.ndarray:
    """Parts of the nodes of a line, s [m], in a load over a length of it [m], about the place as far as there is line:
    integrals of the linear w that has the integral 1 and its first moment at the place, times each node's hat function.

    Two Gauss points are exact for this cubic's pieces.
    """
    begin = max(s[0], min(place - 0.5 * length, s[-1] - length))
    s, off = s - begin, (place - begin) / length
    parts = np.zeros_like(s)
    for i in range(s.size - 1):
        start, end = max(s[i], 0.0), min(s[i + 1], length)
        if end <= start:
            continue
        half = 0.5 * (end - start)
        for point in (-1.0, 1.0):
            at = 0.5 * (start + end) + point * half / np.sqrt(3.0)
            load = half * (4.0 - 6.0 * off - (6.0 - 12.0 * off) * at / length) / length
            hat = (at - s[i]) / (s[i + 1] - s[i])
            parts[i] += load * (1.0 - hat)
            parts[i + 1] += load * hat
    return parts


def plate_viscosity(
    d: Discretisation, plate: PlateProperties, step: StepProperties, frequency: float
) -> internal_force.Viscosity | None:
    if not (step.damping_ratio or step.bulk_viscosity):
        return None
    moduli = materials.st_venant_kirchhoff(plate.youngs_modulus, plate.poissons_ratio)
    time = 2.0 * step.damping_ratio / frequency
    size = math.sqrt(float(d.scalar.dx.sum(axis=1).min()))
    bulk = step.bulk_viscosity * math.sqrt(plate.density * moduli.c_11) * size
    return internal_force.Viscosity(time * moduli.c_11 + bulk, time * moduli.c_12 + bulk, time * moduli.c_33)
