"""Run of the constrained plate from its start to the tail-slap."""

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from fem.explicit import columns
from fem.explicit.measures import advance_and_measure, lagrange_weight, measure
from fem.explicit.time_loop import State
from fem.model.plate_model import PlateModel
from fem.run import observers, runner
from fem.stability.deformed import deformed_frequency
from fem.start import inertia_relief, start_kinds
from machine_code.compiled import Kernel, OnCompile, compile_once, ignore_compiling
from machine_code.object_code import Prepared

T = TypeVar("T")

CORRUPTION_CHECKS = 20
"""Instants of a run at which the check for corruption is made."""

OVERTIME = 1.5
"""Multiple of the expected duration after which a run without tail-slap ends."""


@dataclass(frozen=True)
class StrikeState:
    """State of the plate at the tail-slap.

    Attributes
    ----------
    values : dict of float
        Columns by name: t [s] and `COLUMNS`.
    positions, velocities : ndarray, shape (2, nodes)
        Positions and velocities in the wall's frame [m], [m/s].
    """

    values: dict[str, float]
    positions: np.ndarray
    velocities: np.ndarray


@dataclass(frozen=True)
class Run:
    """A run to the tail-slap.

    Attributes
    ----------
    history : dict of ndarray, shape (rows,)
        Columns by name: t [s] and `COLUMNS`.
    strike : StrikeState or None
        None if the side did not reach the wall, or values became infinite or not a number.
    steps : int
        Number of time steps.
    setup_s, time_loop_s : float
        Computing times of the start and of the steps [s].
    model : PlateModel
        The plate.
    shapes : sequence of ndarray, shape (2, nodes)
        Positions at a few instants of the run [m].
    snapshots : Snapshots or None
        Nodal positions and velocities at some instants, if requested.
    """

    history: dict[str, np.ndarray]
    strike: StrikeState | None
    steps: int
    setup_s: float
    time_loop_s: float
    model: PlateModel
    shapes: Sequence[np.ndarray]
    snapshots: observers.Snapshots | None = None

    @cached_property
    def highest_frequency(self) -> float:
        """Highest frequency of the plate at these instants [rad/s]."""
        return deformed_frequency(self.model, self.shapes)


class Stepper(runner.PlateStepper[State]):
    """Compiled loop of the plate with its corner constrained.

    threads: 1, or more for large meshes; numbers repeat to the bit for the same number.
    """

    def __init__(self, model: PlateModel, threads: int = 1) -> None:
        super().__init__(model)
        self._later, self._before = (Prepared(runner.copy_state(self.template)) for _ in range(2))
        self._calls: dict[object, tuple[np.ndarray, Callable[[], int]]] = {}
        self._team = None
        if threads > 1:
            from fem.explicit.parallel import Team

            self._team = Team(self.parameters, self._scratch, threads)

    @property
    def template(self) -> State:
        """State with arrays of the right form."""
        return State(self._reference, self._reference, np.zeros(4), np.zeros(1))

    @property
    def step_call(self) -> tuple[Kernel, tuple[object, ...]]:
        """Compiled function of the run, and arguments of its types."""
        if self._team:
            return self._team.step_call(self.template)
        rows = np.zeros((0, len(columns.Measures._fields)))
        return advance_and_measure, (self.template, self.template, 1, *self._all_parts, rows)

    def start(self, start: inertia_relief.RigidStart, kind: str) -> State:
        """Return the state at t = 0.

        Velocities are those of half a step before.
        """
        positions, velocities = map(np.ascontiguousarray, start_kinds.start_fields(self.model, start, kind))
        parameters, state = self.parameters, State(positions, velocities, np.zeros(4), np.zeros(1))
        self._react(state)
        state.velocities[:] -= 0.5 * parameters.time_step * self._force / parameters.mass
        first = self._react(state)
        # The trapezoidal rule takes only half of the first instant; the loop adds it whole.
        speed = float(velocities[0, parameters.corner.nodes] @ parameters.corner.weights)
        friction = 0.5 * parameters.time_step * (first.reaction_tangential * speed)
        works = np.array([friction, first.damping_work, first.normal_impulse, first.normal_impulse_magnitude])
        state.sums[:] = -works
        return state

    def _react(self, state: State) -> columns.Measures:
        """Put all forces into the workspace, and return the record.

        A row without a step takes the code of the run, and no other code is compiled.
        """
        values = self.record(state, 0, 1).rows[0, : len(columns.Measures._fields)]
        return columns.Measures(*values.tolist())

    def advance(self, state: State, steps: int) -> State:
        """Return the state after this many steps."""
        if not self._team:
            return self._compiled_rows(state, steps, 1).state
        later = runner.copy_state(state)
        self._team.advance(later, steps)
        return later

    def measure(self, state: State) -> columns.Measures:
        """Return the record of the state's instant."""
        measures: columns.Measures = measure(state, *self._all_parts)
        return measures

    def record(self, state: State, stride: int, count: int) -> runner.Recorded[State]:
        """Return `count` rows of `COLUMNS`, `stride` steps apart.

        There are fewer where the last one has an angle that is not positive, or a value that is not finite.
        """
        if self._team or any(column.value for column in columns.COLUMNS.values()):
            return self._record_singly(state, stride, count)
        return self._compiled_rows(state, stride, count)

    def _compiled_rows(self, state: State, stride: int, count: int) -> runner.Recorded[State]:
        """Return rows as `record`, made by one compiled call."""
        runner.assign_state(self._later.value, state)
        rows, call = self._prepared_call(stride, count)
        filled = call()
        before, later = (runner.copy_state(part.value) for part in (self._before, self._later))
        return runner.Recorded(rows[:filled].copy(), before, later)

    def _prepared_call(self, stride: int, count: int) -> tuple[np.ndarray, Callable[[], int]]:
        """Return the rows that a call fills, with the call.

        It is prepared once for all of its size.
        """
        size = stride, count, self._fixed
        if size not in self._calls:
            rows = np.empty((count, len(columns.Measures._fields)))
            arguments = self._later, self._before, stride, *self._all_parts, rows
            self._calls[size] = rows, advance_and_measure.bound(*arguments)
        return self._calls[size]

    def _record_singly(self, state: State, stride: int, count: int) -> runner.Recorded[State]:
        """Make rows in Python.

        This serves several threads, and columns that are computed in Python.
        """
        rows: list[tuple[float, ...]] = []
        while len(rows) < count:
            before, state = state, self.advance(state, stride)
            rows.append(columns.row_of(self.measure(state), state, self.model))
            if not (rows[-1][0] > 0.0 and np.isfinite(rows[-1]).all()):
                break
        return runner.Recorded(np.array(rows), before, state)


def compile_loop(
    model: PlateModel,
    start: inertia_relief.RigidStart,
    threads: int = 1,
    on_compile: OnCompile = ignore_compiling,
) -> Stepper:
    """Return the loop of a model with its compiled code.

    Code is compiled, by one process at a time, or loaded from disk. on_compile: see
    `machine_code.compiled.compile_once`.
    """
    stepper = Stepper(model, threads)
    kernel, arguments = stepper.step_call
    record = lambda: stepper.record(stepper.start(start, "unstressed"), 0, 1)  # noqa: E731
    if not kernel.is_loaded(*arguments):
        compile_once(record, kernel, *arguments, on_compile=on_compile)
    return stepper


def simulate(
    model: PlateModel,
    start: inertia_relief.RigidStart,
    duration: float,
    kind: str = "inertia-relief",
    rows: int = 400,
    threads: int = 1,
    progress: Callable[[float], None] = lambda fraction: None,
    corrupted: Callable[[dict[str, float]], bool] = lambda row: False,
    make_stepper: Callable[[PlateModel, int], Stepper] = Stepper,
    checkpoint: observers.Checkpoint | None = None,
    snapshots: int = 0,
) -> Run:
    """Run the plate until the tail-slap.

    The tail-slap is the instant at which the plate's angle reaches zero.

    Parameters
    ----------
    model : PlateModel
        The plate.
    start : RigidStart
        Motion of the rigid body at t = 0.
    duration : float
        Expected time to the tail-slap [s], which determines the spacing of the rows and bounds the run.
    kind : str
        A name of `START_KINDS`.
    rows : int
        Approximate number in the history.
    threads : int
        Threads of the time loop; numbers repeat to the bit for the same number.
    progress : callable
        Called with the completed fraction at intervals.
    corrupted : callable
        Called with a row of the history by its names at intervals; if it returns True, the run ends there.
    make_stepper : callable
        Makes the stepper of a model and a number of threads.
    checkpoint : Checkpoint, optional
        Saves the run's state at intervals; a saved run is resumed with the same bits.
    snapshots : int
        Number of instants at which positions and velocities of all nodes are recorded, with the tail-slap.

    Returns
    -------
    Run
        History and tail-slap.
    """
    entered = time.perf_counter()
    stepper, time_step = make_stepper(model, threads), model.parameters.time_step
    stride = stride_of(duration, model, rows)
    interval = time_step * stride

    def is_corrupted(made_rows: np.ndarray) -> bool:
        return corrupted(_named((time_step * (stride * (len(made_rows) - 1)), *made_rows[-1].tolist())))

    refresh = max(1, rows // CORRUPTION_CHECKS)
    shapes = observers.ShapeSampler(max(1, rows // observers.SHAPES), refresh)
    keeper = observers.SnapshotKeeper(snapshots, duration / interval, stepper.nodal)
    observing: list[runner.Observer] = [
        observers.EndCondition(lambda made_rows: made_rows[-1, 0] <= 0.0),
        shapes,
        *([keeper] if snapshots else []),
        observers.Progress(lambda t: progress(min(1.0, t / duration)), interval),
        observers.EndCondition(is_corrupted, refresh, first=-1),
        observers.EndCondition(lambda made_rows: not np.isfinite(made_rows[-1]).all()),
    ]
    saver, total = observers.Saver(checkpoint, observing), math.ceil(OVERTIME * duration / time_step / stride)
    state, earlier = saver.resumed_state(stepper, stepper.template, total, lambda: stepper.start(start, kind))
    began = time.perf_counter()
    recorded = runner.run(stepper, state, stride, total, [*observing, saver], earlier)
    steps = stride * (len(recorded.rows) - 1)
    history = _named((time_step * (stride * np.arange(len(recorded.rows))), *recorded.rows.T))
    strike = None
    if recorded.rows[-1, 0] <= 0.0:
        strike, steps = _locate_strike(stepper, recorded.before, steps - stride, stride)
        for name, values in history.items():
            values[-1] = strike.values[name]
    ended = time.perf_counter()
    last = shapes.last if strike else recorded.state.positions
    sampled = [*shapes.samples[1 : observers.SHAPES], last]
    snaps = None
    if snapshots:
        end = (strike.positions, strike.velocities) if strike else stepper.nodal(recorded.state)
        snaps = keeper.finished(history["t"], end)
    return Run(history, strike, steps, began - entered, ended - began, model, sampled, snaps)


def stride_of(duration: float, model: PlateModel, rows: int) -> int:
    """Return the steps between about this many rows of a duration [s]."""
    return max(1, round(duration / model.parameters.time_step / rows))


def _named(values: Iterable[T]) -> dict[str, T]:
    """Return values of a row, or columns of a history, by name."""
    return dict(zip(("t", *columns.COLUMNS), values, strict=True))


def _locate_strike(stepper: Stepper, state: State, step: int, stride: int) -> tuple[StrikeState, int]:
    """Return the state at angle zero and the steps to it.

    The angle reaches zero within `stride` steps. The state is interpolated by the polynomial of the angle through the
    last instants, the last of them one step past the first angle <= 0, cubic where there are four. The number of steps
    is that to just beyond the angle.
    """
    crossing = len(stepper.record(state, 1, stride).rows)
    skipped = max(0, crossing - 2)
    instants = [stepper.record(state, skipped, 1)]
    while len(instants) < crossing + 2 - skipped:
        instants.append(stepper.record(instants[-1].state, 1, 1))
    steps, states = step + np.arange(skipped, crossing + 2), [instant.state for instant in instants]
    rows = np.array([instant.rows[0] for instant in instants])
    weights = np.array([lagrange_weight(rows[:, 0], 0, len(rows), k, 0.0) for k in range(len(rows))])
    values = dict(zip(columns.COLUMNS, (weights @ rows).tolist(), strict=True))
    values |= {"t": float(weights @ steps) * stepper.parameters.time_step, "theta": 0.0}
    nodal = zip(*map(stepper.nodal, states, [*states[1:], None]), strict=True)
    fields = (np.tensordot(weights, values_at, 1) for values_at in nodal)
    return StrikeState(values, *fields), int(steps[-1])
