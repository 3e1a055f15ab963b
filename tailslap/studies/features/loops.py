"""The loops that are timed: each with a model, a start and a workspace of its own, ready to run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fem.explicit.internal_force import scratch_for
from fem.explicit.simulate import Stepper
from fem.explicit.time_loop import State, advance, copy_state
from tailslap.planning.fe_plan import FePlan
from tailslap.studies.features.bare import advance_bare, bare_parameters, bare_scratch
from tailslap.studies.features.parts import Part
from tailslap.studies.features.timing import seconds

CHUNK_S = 0.012
"""Seconds that one loop runs in a turn, about: long against the call of compiled code, some 30 microseconds."""

TRIAL, MAX_STEPS = 100, 1_000_000


@dataclass(frozen=True)
class Loop:
    """A loop to time: `run` advances by this many steps and returns seconds."""

    name: str
    run: Callable[[int], float]
    elements: int
    compile_s: float

    def chunk(self) -> int:
        """Steps that take CHUNK_S."""
        best = min(self.run(TRIAL) for _ in range(3))
        return int(np.clip(CHUNK_S * TRIAL / best, 1, MAX_STEPS))


def program_loop(name: str, fe_plan: FePlan, part: Part) -> Loop:
    """The program's own loop of this part."""
    fe_plan = without_control(fe_plan) if not part.controlled else fe_plan
    threads = part.scene.time.threads
    start = start_state(fe_plan)
    if threads > 1:
        stepper = Stepper(fe_plan.model, threads)
        return _loop(name, fe_plan, lambda steps: seconds(lambda: stepper.advance(start, steps)))
    loop = fe_plan.model.loop

    def run(steps: int) -> float:
        state, force, scratch = workspace(fe_plan, start)
        return seconds(lambda: advance(state, steps, loop, loop.viscosity, loop.hourglass, force, scratch))

    return _loop(name, fe_plan, run)


def bare_loop(name: str, fe_plan: FePlan) -> Loop:
    """The bare loop on the same model."""
    start, loop = start_state(fe_plan), fe_plan.model.loop
    model = bare_parameters(loop)

    def run(steps: int) -> float:
        (state, force, _), scratch = workspace(fe_plan, start), bare_scratch(loop)
        return seconds(lambda: advance_bare(state.positions, state.velocities, steps, model, force, scratch))

    return _loop(name, fe_plan, run)


def rows_of_history(fe_plan: FePlan, rows: int) -> Callable[[], float]:
    """Seconds for so many rows of the history: the state copied, the loop called, everything measured."""
    stepper, state = Stepper(fe_plan.model), start_state(fe_plan)

    def work() -> None:
        for _ in range(rows):
            stepper.measure(stepper.advance(state, 0))

    return lambda: seconds(work)


def difference(fe_plan: FePlan, steps: int) -> float:
    """Largest distance between the positions of the two loops after so many steps, over the plate's length."""
    start, loop = start_state(fe_plan), fe_plan.model.loop
    one, force, scratch = workspace(fe_plan, start)
    advance(one, steps, loop, loop.viscosity, loop.hourglass, force, scratch)
    other, force, _ = workspace(fe_plan, start)
    advance_bare(other.positions, other.velocities, steps, bare_parameters(loop), force, bare_scratch(loop))
    return float(np.abs(one.positions_on_wall - other.positions).max() / fe_plan.plan.body.length)


def start_state(fe_plan: FePlan) -> State:
    """State at t = 0 of the plate as it starts."""
    return Stepper(fe_plan.model).start(fe_plan.start, fe_plan.plate.start)


def workspace(fe_plan: FePlan, start: State) -> tuple[State, np.ndarray, Any]:
    """State, forces and scratch of its own: where they lie in memory is then chance, turn by turn."""
    state = copy_state(start)
    return (
        state,
        np.zeros_like(state.positions),
        scratch_for(fe_plan.model.loop.table, fe_plan.model.loop.hourglass),
    )


def without_control(fe_plan: FePlan) -> FePlan:
    """The same model, its hourglass modes left alone: only to be timed."""
    loop = fe_plan.model.loop._replace(hourglass=None)
    return replace(fe_plan, model=replace(fe_plan.model, loop=loop))


def _loop(name: str, fe_plan: FePlan, run: Callable[[int], float]) -> Loop:
    """The first call compiles, or loads what was compiled before."""
    compile_s = seconds(lambda: run(0))
    return Loop(name, run, int(fe_plan.model.loop.table.connectivity.shape[1]), compile_s)
