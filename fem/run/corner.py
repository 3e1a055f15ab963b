"""The run of the constrained plate: from a model and a start to histories and the state at the tail-slap."""

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fem.explicit import columns, time_loop
from fem.explicit.measures import advance_and_measure, all_forces, measure
from fem.machine_code import compiled
from fem.model.plate_model import PlateModel
from fem.run import runner
from fem.start import inertia_relief, start_kinds

GLANCES = 50
"""Instants of a run at which it is asked whether it is corrupted."""

OVERTIME = 1.5
"""Multiples of the expected duration after which a run that has not struck is given up."""


@dataclass(frozen=True)
class StrikeState:
    """The tail-slap.

    Attributes
    ----------
    values : dict of float
        By name: t [s] and `COLUMNS`.
    positions, velocities : ndarray, shape (2, nodes)
        In the wall's frame [m], [m/s].
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
        By name: t [s] and `COLUMNS`.
    strike : StrikeState or None
        None if the side did not reach the wall, or the numbers left the finite.
    steps : int
        Time steps taken.
    setup_s, time_loop_s : float
        Times that the state at the start and the steps took [s].
    model : PlateModel
        The plate.
    shapes : sequence of ndarray, shape (2, nodes)
        Positions at a few instants of the run [m].
    snapshots : Snapshots or None
        Nodal positions and velocities at some instants, where they were asked for.
    """

    history: dict[str, np.ndarray]
    strike: StrikeState | None
    steps: int
    setup_s: float
    time_loop_s: float
    model: PlateModel
    shapes: Sequence[np.ndarray]
    snapshots: runner.Snapshots | None = None

    @cached_property
    def highest_frequency(self) -> float:
        """The largest at these instants [rad/s]."""
        return runner.highest_frequency(self.model, self.shapes)


class Stepper(runner.PlateStepper):
    """The compiled loop of the plate with its corner held.

    threads: 1, or more for large meshes; numbers repeat to the bit for the same number.
    """

    def __init__(self, model: PlateModel, threads: int = 1) -> None:
        super().__init__(model)
        self._team = None
        if threads > 1:
            from fem.explicit.parallel import Team

            self._team = Team(self.loop, self._scratch, threads)

    @property
    def form(self) -> time_loop.State:
        """A state, to copy its form."""
        return time_loop.State(self._reference, self._reference, np.zeros(4), np.zeros(1))

    @property
    def step_call(self) -> tuple[Any, ...]:
        """The compiled function of the run, and arguments of its types."""
        if self._team:
            return self._team.step_call(self.form)
        rows = np.zeros((0, len(columns.Measures._fields)))
        return advance_and_measure, self.form, self.form, 1, *self._all_parts, rows

    def start(self, start: inertia_relief.RigidStart, kind: str) -> time_loop.State:
        """State at t = 0, its velocities set back by half a step."""
        positions, velocities = map(np.ascontiguousarray, start_kinds.start_fields(self.model, start, kind))
        loop, state = self.loop, time_loop.State(positions, velocities, np.zeros(4), np.zeros(1))
        self._react(state)
        state.velocities[:] -= 0.5 * loop.time_step * self._force / loop.mass
        normal, tangential, _, _, damping = self._react(state)
        # The trapezoidal rule takes only half of the first instant; the loop adds it whole.
        friction = tangential * float(velocities[0, loop.corner.nodes] @ loop.corner.weights)
        state.sums[:] = -0.5 * loop.time_step * np.array([friction, damping, normal, abs(normal)])
        return state

    def _react(self, state: time_loop.State) -> tuple[float, ...]:
        """Put all forces into the workspace; see `all_forces`."""
        return tuple(all_forces(state, self._fixed, *self._parts, self._force, self._workspace))

    def advance(self, state: time_loop.State, steps: int) -> time_loop.State:
        """The state this many steps later; the one given stays as it is."""
        later: time_loop.State = runner.copy_state(state)
        if self._team:
            self._team.advance(later, steps)
        else:
            time_loop.advance(later, steps, self._fixed, *self._parts, self._force, self._workspace)
        return later

    def measure(self, state: time_loop.State) -> columns.Measures:
        """The record of the state's instant."""
        measures: columns.Measures = measure(state, *self._all_parts)
        return measures

    def record(self, state: time_loop.State, stride: int, count: int) -> runner.Recorded:
        """Rows of `COLUMNS` from a state on, which stays as it is, `stride` steps apart: `count` of them, or fewer
        where the last has an angle that is not above zero, or a number that is not finite."""
        if self._team or any(column.value for column in columns.COLUMNS.values()):
            return self._record_singly(state, stride, count)
        later, before = runner.copy_state(state), runner.copy_state(state)
        rows = np.empty((count, len(columns.Measures._fields)))
        made = advance_and_measure(later, before, stride, *self._all_parts, rows)
        return runner.Recorded(rows[:made], before, later)

    def _record_singly(self, state: time_loop.State, stride: int, count: int) -> runner.Recorded:
        """Make rows in Python: on several threads, and for columns that are worked out here."""
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
    on_compile: compiled.OnCompile = compiled.ignore_compiling,
) -> Stepper:
    """The compiled loop of a model with all that a run needs compiled, or loaded from disk: one process at a time.

    on_compile: see `fem.machine_code.compiled.compile_once`.
    """
    stepper = Stepper(model, threads)
    compiled.compile_once(
        lambda: stepper.record(stepper.start(start, "unstressed"), 0, 1),
        *stepper.step_call,
        on_compile=on_compile,
    )
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
    checkpoint: runner.Checkpoint | None = None,
    snapshots: int = 0,
) -> Run:
    """Run from the start to the tail-slap, the instant when the plate's angle reaches zero.

    Parameters
    ----------
    model : PlateModel
        The plate.
    start : RigidStart
        Motion of the rigid body at t = 0.
    duration : float
        Expected time to the tail-slap [s]; it spaces the rows of the history and bounds the run.
    kind : str
        A name of `START_KINDS`.
    rows : int
        Of the history, about.
    threads : int
        Of the time loop; numbers repeat to the bit for the same number.
    progress : callable
        Called with the fraction that is done, now and then.
    corrupted : callable
        Called with a row of the history by its names, now and then; when it says so, the run is given up there.
    make_stepper : callable
        Makes the compiled loop of a model and a number of threads.
    checkpoint : Checkpoint, optional
        Keeps the run's state now and then; one that has kept it lets the run go on, with the same bits.
    snapshots : int
        Instants at which positions and velocities of all nodes are kept, the tail-slap among them.

    Returns
    -------
    Run
        History and tail-slap.
    """
    entered = time.perf_counter()
    stepper, time_step = make_stepper(model, threads), model.loop.time_step
    stride = max(1, round(duration / time_step / rows))
    interval = time_step * stride

    def is_corrupted(made: np.ndarray) -> bool:
        return corrupted(_named((time_step * (stride * (len(made) - 1)), *made[-1].tolist())))

    glance = max(1, rows // GLANCES)
    shapes = runner.Shapes(max(1, rows // runner.LOOKS), glance)
    keeper = runner.SnapshotKeeper(snapshots, duration / interval, stepper.nodal)
    watching: list[runner.Observer] = [
        runner.Until(lambda made: made[-1, 0] <= 0.0),
        shapes,
        *([keeper] if snapshots else []),
        runner.Progress(lambda t: progress(min(1.0, t / duration)), interval),
        runner.Until(is_corrupted, glance, first=-1),
        runner.Until(lambda made: not np.isfinite(made[-1]).all()),
    ]
    saver, total = runner.Saver(checkpoint, watching), math.ceil(OVERTIME * duration / time_step / stride)
    state, made = saver.begun(stepper, stepper.form, total, lambda: stepper.start(start, kind))
    began = time.perf_counter()
    found = runner.run(stepper, state, stride, total, [*watching, saver], made)
    steps = stride * (len(found.rows) - 1)
    history = _named((time_step * (stride * np.arange(len(found.rows))), *found.rows.T))
    strike = None
    if found.rows[-1, 0] <= 0.0:
        strike, steps = _locate(stepper, found.before, steps - stride)
        for name, values in history.items():
            values[-1] = strike.values[name]
    ended = time.perf_counter()
    last = shapes.last if strike else found.state.positions
    looked = [*shapes.seen[1 : runner.LOOKS], last]
    snaps = None
    if snapshots:
        end = (strike.positions, strike.velocities) if strike else stepper.nodal(found.state)
        snaps = keeper.finished(history["t"], end)
    return Run(history, strike, steps, began - entered, ended - began, model, looked, snaps)


def _named(values: Iterable[Any]) -> dict[str, Any]:
    """Values of a row, or columns of a history, by name."""
    return dict(zip(("t", *columns.COLUMNS), values, strict=True))


def _locate(stepper: Stepper, state: time_loop.State, step: int) -> tuple[StrikeState, int]:
    """StrikeState at angle zero, and the number of steps to just beyond it.

    Steps on singly to one step past the first angle <= 0, and interpolates by the polynomial, cubic where four
    instants are there, that gives everything as a function of the angle.
    """
    found = [(step, state, stepper.record(state, 0, 1).rows[0])]
    while len(found) < 2 or found[-2][2][0] > 0.0:
        later = stepper.record(state, 1, 1)
        step, state = step + 1, later.state
        found = [*found[-3:], (step, state, later.rows[0])]
    steps, states, rows = zip(*found, strict=True)
    weights = _lagrange(np.array([row[0] for row in rows]), 0.0)
    values = dict(zip(columns.COLUMNS, (weights @ np.array(rows)).tolist(), strict=True))
    values |= {"t": float(weights @ np.array(steps)) * stepper.loop.time_step, "theta": 0.0}
    nodal = zip(*map(stepper.nodal, states), strict=True)
    return StrikeState(values, *(np.tensordot(weights, each, 1) for each in nodal)), step


def _lagrange(nodes: np.ndarray, at: float) -> np.ndarray:
    """Weights of the values at `nodes` in the interpolating polynomial at `at`."""
    difference = nodes[:, None] - nodes[None, :]
    np.fill_diagonal(difference, 1.0)
    numerator = at - np.tile(nodes, (nodes.size, 1))
    np.fill_diagonal(numerator, 1.0)
    return np.asarray((numerator / difference).prod(axis=1))
