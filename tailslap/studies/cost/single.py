"""The time loop with its arrays stored in single precision, to measure what that does.

The kernels are generic in the type of their arrays. Their constants are not, so that Numba computes in double
between a load and a store: what is seen is the harm of storing alone, the least there can be.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from fem.discretisation.model import PlateModel
from fem.explicit.time_loop import State
from fem.run.corner import Stepper
from fem.start.rigid_state import RigidStart


def single(values: np.ndarray) -> np.ndarray:
    """The array in single precision."""
    return values.astype(np.float32)


def single_model(model: PlateModel) -> PlateModel:
    """The model with its arrays in single precision."""
    table = model.loop.table
    table = table._replace(gradients=single(table.gradients), weights=single(table.weights), mapping=None)
    positions = single(model.discretisation.positions)
    return dataclasses.replace(
        model,
        discretisation=dataclasses.replace(model.discretisation, positions=positions, table=table),
        loop=model.loop._replace(table=table, mass=single(model.loop.mass)),
    )


class SingleStepper(Stepper):
    """The loop with scratch rows and state in single precision; sums of works stay double."""

    def __init__(self, model: PlateModel, threads: int = 1) -> None:
        super().__init__(single_model(model), threads)
        self._scratch = self._scratch._replace(rows=single(self._scratch.rows))
        self._double = Stepper(model)

    def start(self, start: RigidStart, kind: str) -> State:
        """The start, computed in double and rounded."""
        positions, velocities, *rest = self._double.start(start, kind)
        return State(single(positions), single(velocities), *rest)
