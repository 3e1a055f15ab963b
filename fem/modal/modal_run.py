"""A run of the modal model: from inertia relief, as the finite-element run starts to the tail-slap."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from fem.discretisation.model import PlateModel
from fem.modal.modal_model import ModalPlate
from fem.modal.modal_motion import MEASURED, measure_rows
from fem.modal.modal_steps import REACHED, run_to_strike
from fem.start.inertia_relief import ElasticFields
from fem.start.rigid_state import RigidStart, to_global

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
    plate: PlateModel, modal: ModalPlate, start: RigidStart, fields: ElasticFields
) -> tuple[np.ndarray, np.ndarray]:
    """Place and speed at t = 0, shape (3 + modes,): the start by inertia relief, projected on the modes."""
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
    modal: ModalPlate, start: tuple[np.ndarray, np.ndarray], duration: float, steps: int
) -> ModalMotion:
    """Run to the tail-slap, in so many steps of the expected duration [s] and one shorter."""
    _compile(modal, start)
    table = np.empty((int(OVERTIME * steps) + 2, 1 + 2 * start[0].size))
    table[0] = np.concatenate([[0.0], *start])
    began = time.perf_counter()
    end, rows, iterations = run_to_strike(duration / steps, modal.model, table, *_workspace(table))
    elapsed = time.perf_counter() - began
    measured = np.empty((rows, len(MEASURED)))
    measure_rows(table[:rows], modal.model, measured)
    history = {"t": table[:rows, 0], **dict(zip(MEASURED, measured.T, strict=True))}
    strike = {name: float(column[-1]) for name, column in history.items()} if end == REACHED else None
    return ModalMotion(history, strike, ENDS[end], rows - 1, iterations, elapsed)


def _compile(modal: ModalPlate, start: tuple[np.ndarray, np.ndarray]) -> None:
    """Compile what a run needs, or load it from disk: a table of one row has no step."""
    table = np.concatenate([[0.0], *start])[None]
    run_to_strike(1.0, modal.model, table, *_workspace(table))


def _workspace(table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    size = table.shape[1] // 2
    return np.empty((14, size)), np.empty(size, dtype=complex)


def _split(plate: PlateModel, modal: ModalPlate, field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of the modes in a field that vanishes at the corner, and the corner's displacement, against the
    mass centre, that belongs to the modes left out."""
    masses = plate.loop.mass
    coordinates = np.tensordot(modal.weighted, field, 2)
    return coordinates, -field @ masses / masses.sum() - modal.model.corner @ coordinates
