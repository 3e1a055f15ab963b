"""Modal model of the plate in a floating frame.

It has the lowest elastic modes, and the flexibility of the omitted ones. The run begins by inertia relief, as the
finite-element run does, and ends at the tail-slap. The equations are derived in docs/modal.md. The frame follows the
plate's mass centre and rotates so that elastic motion has no moment about it (Tisserand's condition), which the modes
of the free plate satisfy. The omitted modes follow their loads without delay. There are three loads: the reaction
along x and along y, and the squared spin, which pulls every mass outwards.
"""

import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fem.laws.constraints import CornerConstraint
from fem.modal import motion
from fem.modal.collocation import REACHED, run_to_strike
from fem.model.plate_model import PlateModel
from fem.plate.free_modes import free_modes
from fem.plate.properties import RigidStart
from fem.start.inertia_relief import ElasticFields, at_corner, to_global
from machine_code.compiled import OnCompile, compile_once, ignore_compiling

OVERTIME = 1.5
"""Multiple of the expected duration after which a run without tail-slap ends."""

ENDS = (
    "the side reached the wall",
    "the corner stopped before the side reached the wall",
    "a step did not converge",
    "the side did not reach the wall within the time limit",
)
"""Ends of a run in words."""


class ModalModel(NamedTuple):
    """Constants of a run, in SI units and the body frame.

    arm: from the mass centre to the corner [m], shape (2,). squares: squared frequencies [1/s^2], shape (modes,).
    corner: shapes at the corner [1/sqrt(kg)], shape (2, modes). growth: half the change of the rotary inertia by a
    coordinate of one [sqrt(kg) m], shape (modes,). turning: angular momentum of coordinate k against the rate of l,
    shape (modes, modes), antisymmetric. flexibility: work of load i on the displacement of the omitted modes by load
    j, shape (3, 3): along x and y at the corner [m/N], and by the squared spin [m s^2], [kg m^2 s^2]. compliance: of
    the corner's constraint [m/N], 0 where it is exact. friction: constants of a law of `fem.laws.friction`, or None.
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
    friction: tuple[float, ...] | None


@dataclass(frozen=True)
class ModalPlate:
    """A modal model with the shapes that determine its coordinates.

    Attributes
    ----------
    model : ModalModel
        Constants of a run.
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
    """Return the modal model with the lowest elastic modes.

    Parameters
    ----------
    plate : PlateModel
        The finite-element plate.
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
    parameters, modes = plate.parameters, free_modes(plate, count)
    if parameters.corner.dashpot:
        raise ValueError("the modal model does not support a dashpot at the corner")
    if parameters.viscosity is not None:
        raise ValueError("the modal model does not support damping of the plate")
    masses, positions = parameters.mass, plate.discretisation.positions
    body = positions - (positions @ masses / masses.sum())[:, None]
    arm = at_corner(plate, body)[:, 0]
    loads = _loads(masses, body, arm, parameters.corner)
    fields = np.array([plate.elastic(load.ravel()).reshape(2, -1) for load in loads])
    fractions = np.tensordot(modes.shapes, loads, ((1, 2), (1, 2)))  # of the loads in the modes, (modes, 3)
    squares, weighted = modes.frequencies**2, modes.shapes * masses
    turning = weighted[:, 0] @ modes.shapes[:, 1].T
    model = ModalModel(
        mass=float(masses.sum()),
        inertia=float(masses @ (body**2).sum(axis=0)),
        arm=arm,
        squares=squares,
        corner=np.ascontiguousarray(fractions[:, :2].T),
        growth=np.ascontiguousarray(fractions[:, 2]),
        turning=np.ascontiguousarray(turning - turning.T),
        flexibility=np.tensordot(loads, fields, ((1, 2), (1, 2)))
        - fractions.T @ (fractions / squares[:, None]),
        compliance=1.0 / parameters.corner.stiffness,
        friction=parameters.friction,
    )
    return ModalPlate(model, weighted)


def with_fewer_modes(modal: ModalPlate, count: int) -> ModalPlate:
    """Return the model with the first `count` modes.

    The flexibility of the others is added to that of the omitted modes.
    """
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


def _loads(masses: np.ndarray, body: np.ndarray, arm: np.ndarray, corner: CornerConstraint) -> np.ndarray:
    """Return the nodal forces of the three loads, shape (3, 2, nodes).

    Each is in equilibrium: the reaction with the inertia of the rigid motion that it causes, and the centrifugal
    forces without further forces. arm: from the mass centre to the corner [m], shape (2,).
    """
    total, inertia, loads = masses.sum(), masses @ (body**2).sum(axis=0), []
    for direction, moment in ((np.array([1.0, 0.0]), -arm[1]), (np.array([0.0, 1.0]), arm[0])):
        turning = np.array([-body[1], body[0]]) * (moment / inertia)
        load = -masses * (direction[:, None] / total + turning)
        load[:, corner.nodes] += np.outer(direction, corner.weights)
        loads.append(load)
    return np.array([*loads, masses * body])


@dataclass(frozen=True)
class ModalMotion:
    """A run of the modal model.

    strike: measures and t at the tail-slap; None if it was not reached. history: t and measures, SI, shape
    (instants,). iterations: of Newton's method, in all steps.
    """

    history: dict[str, np.ndarray]
    strike: dict[str, float] | None
    end: str
    steps: int
    iterations: int
    integration_s: float


def modal_start(
    plate: PlateModel, modal: ModalPlate, start: RigidStart, fields: ElasticFields
) -> tuple[np.ndarray, np.ndarray]:
    """Return place and speed at t = 0.

    They have the shape (3 + modes,) each. They are the start by inertia relief, projected on the modes.
    """
    turn = to_global(start.angle)
    (q, shift), (q_rate, shift_rate) = (
        _split(plate, modal, field) for field in (fields.elastic, fields.rate)
    )
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
    """Run the modal model to the tail-slap.

    steps: number of steps in the expected duration [s]; the last step of the run is shorter. on_compile: see
    `machine_code.compiled.compile_once`.
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
    measured = np.empty((rows, len(motion.ModalMeasures._fields)))
    motion.measure_rows(table[:rows], modal.model, measured)
    history = {"t": table[:rows, 0], **dict(zip(motion.ModalMeasures._fields, measured.T, strict=True))}
    strike = {name: float(column[-1]) for name, column in history.items()} if end == REACHED else None
    return ModalMotion(history, strike, ENDS[end], rows - 1, iterations, elapsed)


def _split(plate: PlateModel, modal: ModalPlate, field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the modes' coordinates in a field, and the corner's displacement.

    The field vanishes at the corner. The displacement is that by the omitted modes, relative to the mass centre.
    """
    masses = plate.parameters.mass
    coordinates = np.tensordot(modal.weighted, field, 2)
    return coordinates, -field @ masses / masses.sum() - modal.model.corner @ coordinates
