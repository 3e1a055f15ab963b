"""The modal model of the plate: a floating frame, its lowest elastic modes, and the flexibility of the others. Its run
is from inertia relief, as the finite-element run starts, to the tail-slap.

The equations are derived in docs/modal.md. The frame moves with the plate's mass centre and turns so that elastic
motion has no moment about it (Tisserand's condition): the modes of the free plate fulfil it by themselves. The modes
left out follow their loads at once. There are three loads: the reaction along x and along y, and the squared spin,
which pulls every mass outwards.

Kinds of the plate's modes, by a criterion that needs no eye; and natural frequencies of beams beside them.

symmetric about the long middle line (along it u_x even, u_y odd), by more than half of its kinetic energy:
    longitudinal    more than half of the kinetic energy is along the length
    transverse      else: the plate grows wider and narrower
else antisymmetric, as a beam bends:
    shear           more than half of the strain energy is that of shear strain
    bending         else

Beams bend, with shear and without, or stretch. The beam is the plate seen from its side: length L, depth B in the
plane, thickness t out of it. It bends in the plane.
"""

import math
import time
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fem.machine_code.compiled import OnCompile, compile_once, ignore_compiling
from fem.modal import motion
from fem.modal.motion import REACHED, run_to_strike
from fem.model.plate_model import PlateModel
from fem.plate.discretisation import stiffness_matrix
from fem.plate.free_modes import FreeModes, free_modes
from fem.start import inertia_relief
from fem.start.inertia_relief import ElasticFields


class ModalModel(NamedTuple):
    """Everything that stays as it is during a run; SI, body frame.

    arm: from the mass centre to the corner [m], shape (2,). squares: squared frequencies [1/s^2], shape (modes,).
    corner: shapes at the corner [1/sqrt(kg)], shape (2, modes). growth: half the change of the rotary inertia by a
    coordinate of one [sqrt(kg) m], shape (modes,). turning: angular momentum of coordinate k against the rate of l,
    shape (modes, modes), antisymmetric. flexibility: work of load i on what load j does to the modes left out,
    shape (3, 3): along x and y at the corner [m/N], and by the squared spin [m s^2], [kg m^2 s^2].
    compliance: of the corner's constraint [m/N], 0 where it is exact. friction: constants of a law of
    `fem.laws.friction`, or None.
    """

    mass: float
    inertia: float
    arm: np.ndarray
    squares: np.ndarray
    corner: np.ndarray
    growth: np.ndarray
    turning: np.ndarray
    flexibility: np.ndarray
    compliance: float
    friction: Any


@dataclass(frozen=True)
class ModalPlate:
    """A modal model, and what its coordinates are read with.

    Attributes
    ----------
    model : ModalModel
        What stays as it is during a run.
    weighted : ndarray, shape (modes, 2, nodes)
        Shapes of its modes, weighted with the masses [sqrt(kg)].
    """

    model: ModalModel
    weighted: np.ndarray

    @property
    def frequencies(self) -> np.ndarray:
        """Circular frequencies of the modes [rad/s], shape (modes,)."""
        return np.asarray(np.sqrt(self.model.squares))


def modal_plate(plate: PlateModel, count: int) -> ModalPlate:
    """The modal model with the lowest elastic modes.

    Parameters
    ----------
    plate : PlateModel
        The whole plate.
    count : int
        Number of modes.

    Returns
    -------
    ModalPlate
        The model.

    Raises
    ------
    ValueError
        For a count that the mesh does not have, a dashpot at the corner, and damping of the plate.
    """
    loop, modes = plate.loop, free_modes(plate, count)
    if loop.corner.dashpot:
        raise ValueError("the modal model does not support a dashpot at the corner")
    if loop.viscosity is not None:
        raise ValueError("the modal model does not support damping of the plate")
    masses, positions = loop.mass, plate.discretisation.positions
    body = positions - (positions @ masses / masses.sum())[:, None]
    loads = _loads(masses, body, loop.corner)
    fields = np.array([plate.elastic(load.ravel()).reshape(2, -1) for load in loads])
    fractions = np.tensordot(modes.shapes, loads, ((1, 2), (1, 2)))  # of the loads in the modes, (modes, 3)
    squares, weighted = modes.frequencies**2, modes.shapes * masses
    turning = weighted[:, 0] @ modes.shapes[:, 1].T
    model = ModalModel(
        mass=float(masses.sum()),
        inertia=float(masses @ (body**2).sum(axis=0)),
        arm=_at(body, loop.corner),
        squares=squares,
        corner=np.ascontiguousarray(fractions[:, :2].T),
        growth=np.ascontiguousarray(fractions[:, 2]),
        turning=np.ascontiguousarray(turning - turning.T),
        flexibility=np.tensordot(loads, fields, ((1, 2), (1, 2)))
        - fractions.T @ (fractions / squares[:, None]),
        compliance=1.0 / loop.corner.stiffness,
        friction=loop.friction,
    )
    return ModalPlate(model, weighted)


def with_fewer_modes(modal: ModalPlate, count: int) -> ModalPlate:
    """The model with only its first `count` modes: the others' flexibility joins that of the modes left out."""
    model = modal.model
    fractions = np.column_stack([model.corner[:, count:].T, model.growth[count:]])
    fewer = model._replace(
        squares=model.squares[:count].copy(),
        corner=model.corner[:, :count].copy(),
        growth=model.growth[:count].copy(),
        turning=model.turning[:count, :count].copy(),
        flexibility=model.flexibility + fractions.T @ (fractions / model.squares[count:, None]),
    )
    return ModalPlate(fewer, modal.weighted[:count])


def _loads(masses: np.ndarray, body: np.ndarray, corner: Any) -> np.ndarray:
    """Forces of the three loads on the nodes, shape (3, 2, nodes), each in equilibrium.

    The reaction's with the inertia of the rigid motion that it causes; centrifugal forces balance as they are.
    """
    total, inertia = masses.sum(), masses @ (body**2).sum(axis=0)
    arm, loads = _at(body, corner), []
    for direction, moment in ((np.array([1.0, 0.0]), -arm[1]), (np.array([0.0, 1.0]), arm[0])):
        turning = np.array([-body[1], body[0]]) * (moment / inertia)
        load = -masses * (direction[:, None] / total + turning)
        load[:, corner.nodes] += np.outer(direction, corner.weights)
        loads.append(load)
    return np.array([*loads, masses * body])


def _at(field: np.ndarray, corner: Any) -> np.ndarray:
    """A nodal field's value at the corner, shape (2,)."""
    return np.asarray(field[:, corner.nodes] @ corner.weights)


OVERTIME = 1.5
"""Multiples of the expected duration after which a run that has not struck is given up."""

ENDS = (
    "the side reached the wall",
    "the corner stopped before the side reached the wall",
    "a step did not converge",
    "the side did not reach the wall within the time limit",
)
"""How a run ended, in words."""


@dataclass(frozen=True)
class ModalMotion:
    """A run of the modal model. `strike`: MEASURED and t at the tail-slap; None if it was not reached.

    history: t and MEASURED, SI, shape (instants,). iterations: of Newton's method, in all steps.
    """

    history: dict[str, np.ndarray]
    strike: dict[str, float] | None
    end: str
    steps: int
    iterations: int
    integration_s: float


def modal_start(
    plate: PlateModel, modal: ModalPlate, start: inertia_relief.RigidStart, fields: ElasticFields
) -> tuple[np.ndarray, np.ndarray]:
    """Place and speed at t = 0, shape (3 + modes,): the start by inertia relief, projected on the modes."""
    turn = inertia_relief.to_global(start.angle)
    (q, shift), (q_rate, shift_rate) = (_split(plate, modal, each) for each in (fields.elastic, fields.rate))
    shift, shift_rate = turn @ shift, turn @ shift_rate
    sweep = start.omega * np.array([-shift[1], shift[0]])
    corner = np.array([0.0, fields.gap]) - shift
    corner_speed = np.array([start.corner_speed, fields.gap_rate]) - shift_rate - sweep
    return np.concatenate([corner, [-start.angle], q]), np.concatenate([corner_speed, [start.omega], q_rate])


def integrate(
    modal: ModalPlate,
    start: tuple[np.ndarray, np.ndarray],
    duration: float,
    steps: int,
    on_compile: OnCompile = ignore_compiling,
) -> ModalMotion:
    """Run to the tail-slap, in so many steps of the expected duration [s] and one shorter.

    on_compile: see `fem.machine_code.compiled.compile_once`.
    """
    size = start[0].size
    table = np.empty((int(OVERTIME * steps) + 2, 1 + 2 * size))
    table[0] = np.concatenate([[0.0], *start])
    workspace = np.empty((14, size)), np.empty(size, dtype=complex)
    unstepped = 1.0, modal.model, table[:1], *workspace  # a table of one row has no step
    compile_once(lambda: run_to_strike(*unstepped), run_to_strike, *unstepped, on_compile=on_compile)
    began = time.perf_counter()
    end, rows, iterations = run_to_strike(duration / steps, modal.model, table, *workspace)
    elapsed = time.perf_counter() - began
    measured = np.empty((rows, len(motion.MEASURED)))
    motion.measure_rows(table[:rows], modal.model, measured)
    history = {"t": table[:rows, 0], **dict(zip(motion.MEASURED, measured.T, strict=True))}
    strike = {name: float(column[-1]) for name, column in history.items()} if end == REACHED else None
    return ModalMotion(history, strike, ENDS[end], rows - 1, iterations, elapsed)


def _split(plate: PlateModel, modal: ModalPlate, field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of the modes in a field that vanishes at the corner, and the corner's displacement, against the
    mass centre, that belongs to the modes left out."""
    masses = plate.loop.mass
    coordinates = np.tensordot(modal.weighted, field, 2)
    return coordinates, -field @ masses / masses.sum() - modal.model.corner @ coordinates


@dataclass(frozen=True)
class ModeKinds:
    """Names of the kinds, and the fractions they follow from, shape (modes,): kinetic energy of the symmetric part and
    along the length, strain energy of shear."""

    names: tuple[str, ...]
    symmetric: np.ndarray
    along: np.ndarray
    shear: np.ndarray


def mode_kinds(model: PlateModel, modes: FreeModes, thickness: float) -> ModeKinds:
    """Kinds of the modes of this model; thickness [m]."""
    masses, shapes, hinges = model.loop.mass, modes.shapes, getattr(model.loop, "hinges", None)
    unit = np.zeros(masses.size) if hinges is None else hinges.unit
    mirrored = shapes[:, :, _mirror_nodes(model.discretisation.positions, unit)]
    symmetric = 0.5 * (1.0 + (shapes[:, 0] * mirrored[:, 0] - shapes[:, 1] * mirrored[:, 1]) @ masses)
    along = shapes[:, 0] ** 2 @ masses
    moduli = model.tangent_moduli._replace(c_11=0.0, c_12=0.0)  # shear alone
    stiffness = stiffness_matrix(model.discretisation.scalar, thickness, moduli)
    flat = shapes.reshape(len(shapes), -1)
    shear = ((stiffness @ flat.T).T * flat).sum(axis=1) / modes.frequencies**2
    fractions = zip(symmetric, along, shear, strict=True)
    return ModeKinds(tuple(_name(*fraction) for fraction in fractions), symmetric, along, shear)


def _name(symmetric: float, along: float, shear: float) -> str:
    if symmetric > 0.5:
        return "longitudinal" if along > 0.5 else "transverse"
    return "shear" if shear > 0.5 else "bending"


def _mirror_nodes(positions: np.ndarray, unit: np.ndarray) -> np.ndarray:
    """The node of the same unit nearest to each node's mirror image in the long middle line, shape (nodes,)."""
    from scipy.spatial import cKDTree

    x, y = positions
    apart = unit * np.ptp(positions)  # plates lie over one another
    images = np.array([x, y.min() + y.max() - y, apart])
    return np.asarray(cKDTree(np.array([x, y, apart]).T).query(images.T)[1])


POLYNOMIALS = 24
"""Terms of the Ritz solution in each unknown: the lowest ten frequencies are then exact to ten digits."""


@dataclass(frozen=True)
class Beam:
    """Length and depth [m], Young's modulus [Pa], Poisson's ratio, density [kg/m^3]; its thickness does not matter."""

    length: float
    depth: float
    youngs_modulus: float
    poissons_ratio: float
    density: float

    @property
    def wave_speed(self) -> float:
        """Speed of longitudinal waves in a thin strip, sqrt(E / rho) [m/s]."""
        return math.sqrt(self.youngs_modulus / self.density)

    @property
    def shear_coefficient(self) -> float:
        """Shear coefficient of a rectangle: 5 (1 + nu) / (6 + 5 nu) (Kaneko 1975, J. Phys. D 8, 1927)."""
        return 5.0 * (1.0 + self.poissons_ratio) / (6.0 + 5.0 * self.poissons_ratio)


def longitudinal_frequencies(beam: Beam, count: int) -> np.ndarray:
    """n c / (2 L) [Hz], n = 1, 2, ..., shape (count,)."""
    return np.arange(1, count + 1) * beam.wave_speed / (2.0 * beam.length)


def euler_bernoulli_frequencies(beam: Beam, count: int) -> np.ndarray:
    """Bending of a slender beam [Hz], shape (count,): x^2 sqrt(E I / rho A) / (2 pi L^2) with cosh x cos x = 1."""
    from scipy.optimize import brentq

    roots = []
    for n in range(1, count + 1):
        middle = (n + 0.5) * math.pi
        roots.append(
            brentq(lambda x: math.cos(x) - 1.0 / math.cosh(x), middle - 0.1, middle + 0.1, xtol=1e-14)
        )
    radius = beam.depth / math.sqrt(12.0)
    return np.square(roots) * beam.wave_speed * radius / (2.0 * math.pi * beam.length**2)


def timoshenko_frequencies(beam: Beam, count: int) -> np.ndarray:
    """Bending with shear and rotary inertia [Hz], shape (count,): deflection w and turn psi of the sections.

    Energies E I psi'^2 / 2 + k G A (w' - psi)^2 / 2 and rho A w_t^2 / 2 + rho I psi_t^2 / 2, by Ritz's method with
    Legendre polynomials; free ends ask for nothing of them.
    """
    from numpy.polynomial import legendre
    from scipy.linalg import eigh

    terms = max(POLYNOMIALS, 2 * count + 12)
    points, weights = legendre.leggauss(terms + 1)
    values = legendre.legvander(points, terms - 1)
    slopes = np.array([legendre.legval(points, legendre.legder(row)) for row in np.eye(terms)]).T
    scale, square = 2.0 / beam.length, beam.depth**2 / 12.0
    shear = beam.shear_coefficient * 0.5 / (1.0 + beam.poissons_ratio)  # k G / E
    plain, steep = values.T @ (weights[:, None] * values), scale**2 * slopes.T @ (weights[:, None] * slopes)
    mixed = scale * slopes.T @ (weights[:, None] * values)
    stiffness = np.block(
        [[shear * steep, -shear * mixed], [-shear * mixed.T, square * steep + shear * plain]]
    )
    inertia = np.block([[plain, 0.0 * plain], [0.0 * plain, square * plain]])
    squares = eigh(stiffness, inertia, eigvals_only=True)
    return np.asarray(beam.wave_speed * np.sqrt(squares[2 : 2 + count]) / (2.0 * math.pi))
