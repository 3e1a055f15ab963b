"""The modal model of the plate: a floating frame, its lowest elastic modes, and the flexibility of the others. Its run
is from inertia relief, as the finite-element run starts, to the tail-slap.

The equations are derived in docs/modal.md. The frame moves with the plate's mass centre and turns so that elastic
motion has no moment about it (Tisserand's condition): the modes of the free plate fulfil it by themselves. The modes
left out follow their loads at once. There are three loads: the reaction along x and along y, and the squared spin,
which pulls every mass outwards.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fem.modal import motion
from fem.modal.steps import REACHED, run_to_strike
from fem.model.plate_model import PlateModel
from fem.plate import elastic
from fem.start import rigid_state
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
    loop, modes = plate.loop, elastic.free_modes(plate, count)
    if loop.corner.dashpot:
        raise ValueError("the modal model has no dashpot at the corner")
    if loop.viscosity is not None:
        raise ValueError("the modal model has no damping of the plate")
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
    "the side did not reach the wall in time",
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
    plate: PlateModel, modal: ModalPlate, start: rigid_state.RigidStart, fields: ElasticFields
) -> tuple[np.ndarray, np.ndarray]:
    """Place and speed at t = 0, shape (3 + modes,): the start by inertia relief, projected on the modes."""
    turn = rigid_state.to_global(start.angle)
    (q, shift), (q_rate, shift_rate) = (
        _split(plate, modal, field) for field in (fields.elastic, fields.rate)
    )
    shift, shift_rate = turn @ shift, turn @ shift_rate
    sweep = start.omega * np.array([-shift[1], shift[0]])
    corner = np.array([0.0, fields.gap]) - shift
    corner_speed = np.array([start.corner_speed, fields.gap_rate]) - shift_rate - sweep
    return np.concatenate([corner, [-start.angle], q]), np.concatenate([corner_speed, [start.omega], q_rate])


def integrate(
    modal: ModalPlate, start: tuple[np.ndarray, np.ndarray], duration: float, steps: int
) -> ModalMotion:
    """Run to the tail-slap, in so many steps of the expected duration [s] and one shorter."""
    size = start[0].size
    table = np.empty((int(OVERTIME * steps) + 2, 1 + 2 * size))
    table[0] = np.concatenate([[0.0], *start])
    workspace = np.empty((14, size)), np.empty(size, dtype=complex)
    run_to_strike(1.0, modal.model, table[:1], *workspace)  # a table of one row has no step: this compiles
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
