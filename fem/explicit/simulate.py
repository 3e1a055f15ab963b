"""The run: from a model and a start to histories and the state at the tail-slap."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fem.compiled import Told, compile_once, silent
from fem.discretisation.model import PlateModel
from fem.explicit.checkpoint import Arrays, Checkpoint, NoCheckpoint
from fem.explicit.columns import COLUMNS, Measures, row_of
from fem.explicit.internal_force import scratch_for
from fem.explicit.measures import measure
from fem.explicit.recording import advance_and_measure, all_forces
from fem.explicit.snapshots import SnapshotKeeper, Snapshots
from fem.explicit.time_loop import State, advance, copy_state
from fem.machine_code.arguments import Prepared
from fem.stability.deformed import deformed_frequency
from fem.start.rigid_state import RigidStart
from fem.start.start import start_fields

LOOKS = 4
"""Instants of a run at which the stable time step is looked at again, in the deformed plate."""

LONGEST_S = 0.1
"""Time [s] that rows recorded at once may take, about: between them a run says how far it is, and can be ended."""

GLANCES = 50
"""Instants of a run at which it is asked whether it is corrupted."""

OVERTIME = 1.5
"""Multiples of the expected duration after which a run that has not struck is given up."""


@dataclass(frozen=True)
class Strike:
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
    """What a run gives.

    Attributes
    ----------
    history : dict of ndarray, shape (rows,)
        By name: t [s] and `COLUMNS`.
    strike : Strike or None
        None if the side did not reach the wall, or the numbers left the finite.
    steps : int
        Time steps taken.
    time_loop_s : float
        Time that they took [s].
    highest_frequency : float
        The largest at a few instants of the run [rad/s].
    snapshots : Snapshots or None
        Nodal positions and velocities at some instants, where they were asked for.
    """

    history: dict[str, np.ndarray]
    strike: Strike | None
    steps: int
    time_loop_s: float
    highest_frequency: float  # [rad/s], the largest at a few instants of the run
    snapshots: Snapshots | None = None


class Recorded(NamedTuple):
    """Rows of the history, shape (rows, columns), and the states of the last but one, or of the beginning, and of the
    last."""

    rows: np.ndarray
    before: State
    state: State


class Stepper:
    """The compiled loop with its parameters and its workspace; the state is the caller's.

    threads: 1, or more for large meshes; numbers repeat to the bit for the same number.
    """

    def __init__(self, model: PlateModel, threads: int = 1) -> None:
        self.model, self.loop = model, model.loop
        self._reference = model.discretisation.positions
        self._parts = (self.loop.viscosity, self.loop.hourglass)
        self._force = np.zeros_like(self._reference)
        self._scratch = scratch_for(self.loop.table, self.loop.hourglass)
        self._workspace, self._prepared = Prepared(self._scratch), Prepared(self.loop)
        self._team = None
        if threads > 1:
            from fem.explicit.parallel import Team

            self._team = Team(self.loop, self._scratch, threads)

    @property
    def step_call(self) -> tuple[Any, ...]:
        """The compiled function of the run, and arguments of its types."""
        state = State(self._reference, self._reference, np.zeros(4), np.zeros(1))
        if self._team:
            return self._team.step_call(state)
        return advance_and_measure, state, state, 1, *self._all_parts, np.zeros((0, len(Measures._fields)))

    @property
    def _all_parts(self) -> tuple[Any, ...]:
        return self._fixed, *self._parts, self._reference, self._force, self._workspace

    @property
    def _fixed(self) -> Prepared:
        """The loop's parameters, laid out again where they have been replaced."""
        if self._prepared.value is not self.loop:
            self._prepared = Prepared(self.loop)
        return self._prepared

    def start(self, start: RigidStart, kind: str) -> State:
        """State at t = 0, its velocities set back by half a step."""
        positions, velocities = start_fields(self.model, start, kind)
        positions, velocities = np.ascontiguousarray(positions), np.ascontiguousarray(velocities)
        loop, state = self.loop, State(positions, velocities, np.zeros(4), np.zeros(1))
        self._react(state)
        state.velocities[:] -= 0.5 * loop.time_step * self._force / loop.mass
        normal, tangential, damping = self._react(state)
        # The trapezoidal rule takes only half of the first instant; the loop adds it whole.
        friction = tangential * float(velocities[0, loop.corner.nodes] @ loop.corner.weights)
        state.sums[:] = -0.5 * loop.time_step * np.array([friction, damping, normal, abs(normal)])
        return state

    def _react(self, state: State) -> tuple[float, float, float]:
        """Put all forces into the workspace; returns the normal and the tangential reaction [N], and the power
        [W] of the elastic damping with the velocities half a step back."""
        forces: tuple[float, float, float] = all_forces(
            state.positions, state.velocities, self._fixed, *self._parts, self._force, self._workspace
        )
        return forces

    def advance(self, state: State, steps: int) -> State:
        """The state this many steps later; the one given stays as it is."""
        later = copy_state(state)
        if self._team:
            self._team.advance(later, steps)
        else:
            advance(later, steps, self._fixed, *self._parts, self._force, self._workspace)
        return later

    def measure(self, state: State) -> Measures:
        """The record of the state's instant."""
        measures: Measures = measure(
            state, self._fixed, *self._parts, self._reference, self._force, self._workspace
        )
        return measures

    def record_rows(self, state: State, stride: int, count: int) -> Recorded:
        """Rows of the history from a state on, which stays as it is, `stride` steps apart: `count` of them, or fewer
        where the last has an angle that is not above zero, or a number that is not finite."""
        if self._team or any(column.value for column in COLUMNS.values()):
            return self._record_singly(state, stride, count)
        later, before = copy_state(state), copy_state(state)
        rows = np.empty((count, len(Measures._fields)))
        made = advance_and_measure(later, before, stride, *self._all_parts, rows)
        return Recorded(rows[:made], before, later)

    def _record_singly(self, state: State, stride: int, count: int) -> Recorded:
        """The same in Python: on several threads, and for columns that are worked out here."""
        rows: list[tuple[float, ...]] = []
        while len(rows) < count:
            before, state = state, self.advance(state, stride)
            rows.append(row_of(self.measure(state), state, self.model))
            if not (rows[-1][0] > 0.0 and np.isfinite(rows[-1]).all()):
                break
        return Recorded(np.array(rows), before, state)

    def row(self, state: State) -> tuple[float, ...]:
        """Values of all COLUMNS at the state's instant."""
        return tuple(self.record_rows(state, 0, 1).rows[0].tolist())

    def nodal_velocities(self, state: State) -> np.ndarray:
        """Velocities [m/s] at the state's instant, shape (2, nodes)."""
        later = self.record_rows(state, 1, 1).state
        return 0.5 * (state.velocities + later.velocities)

    def nodal(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Positions [m] and velocities [m/s] at the state's instant in the wall's frame, shape (2, nodes) each."""
        return state.positions_on_wall, self.nodal_velocities(state)


def compile_loop(model: PlateModel, start: RigidStart, threads: int = 1, told: Told = silent) -> None:
    """Compile, or load from disk, all that a run of this model needs: one process of the machine at a time.

    told: see `fem.compiled.compile_once`.
    """
    stepper = Stepper(model, threads)
    compile_once(lambda: _touch(stepper, start), *stepper.step_call, told=told)


def _touch(stepper: Stepper, start: RigidStart) -> None:
    """Call all that a run calls."""
    stepper.row(stepper.start(start, "unstressed"))


def simulate(
    model: PlateModel,
    start: RigidStart,
    duration: float,
    kind: str = "inertia-relief",
    rows: int = 400,
    threads: int = 1,
    progress: Callable[[float], None] = lambda share: None,
    corrupted: Callable[[dict[str, float]], bool] = lambda row: False,
    make_stepper: Callable[[PlateModel, int], Stepper] = Stepper,
    checkpoint: Checkpoint | None = None,
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
        Told the share that is done, now and then.
    corrupted : callable
        Told a row of the history by its names, now and then; when it says so, the run is given up there.
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
    stepper, time_step = make_stepper(model, threads), model.loop.time_step
    stride = max(1, round(duration / time_step / rows))
    last = OVERTIME * duration / time_step
    began = time.perf_counter()
    checkpoint, strike = checkpoint or NoCheckpoint(), None
    keeper = SnapshotKeeper(snapshots, duration) if snapshots else None
    if (kept := checkpoint.load()) is not None:
        state, step, table, seen = _resumed(kept, keeper)
    else:
        state, step = stepper.start(start, kind), 0
        table, seen = [(0.0, *stepper.row(state))], []
        if keeper:
            keeper.look(0.0, 0.0, functools.partial(stepper.nodal, state))
    pace = math.inf
    while strike is None and step < last and np.isfinite(table[-1]).all():
        most = 1 if keeper else min(_rows_to_next_look(len(table), rows), math.ceil((last - step) / stride))
        entered = time.perf_counter()
        found = stepper.record_rows(state, stride, max(1, min(most, int(LONGEST_S / pace))))
        pace = (time.perf_counter() - entered) / len(found.rows)
        steps = step + stride * np.arange(1, len(found.rows) + 1)
        instants = [
            (time_step * at, *row) for at, row in zip(steps.tolist(), found.rows.tolist(), strict=True)
        ]
        if instants[-1][1] <= 0.0:
            strike, step = _locate(stepper, found.before, int(steps[-1]) - stride)
            instants[-1] = tuple(strike.values[name] for name in ("t", *COLUMNS))
        else:
            if (len(table) + len(instants) - 1) % max(1, rows // LOOKS) == 0:
                seen.append(found.state.positions)
            state, step = found.state, int(steps[-1])
            if keeper:
                keeper.look(instants[-1][0], stride * time_step, functools.partial(stepper.nodal, state))
        table.extend(instants)
        progress(min(1.0, table[-1][0] / duration))
        if len(table) % max(1, rows // GLANCES) == 0 and corrupted(_named(table[-1])):
            break
        if strike is None:
            checkpoint.save(functools.partial(_kept, state, step, table, seen, keeper))
    elapsed = time.perf_counter() - began
    history = _named(np.array(table).T)
    finite = [
        positions for positions in (*seen[: LOOKS - 1], state.positions) if np.isfinite(positions).all()
    ]
    frequency = max((deformed_frequency(model, positions) for positions in finite), default=np.inf)
    snaps = None
    if keeper:
        end = (strike.positions, strike.velocities) if strike else stepper.nodal(state)
        snaps = keeper.finished(float(history["t"][-1]), end)
    return Run(history, strike, step, elapsed, frequency, snaps)


def _rows_to_next_look(made: int, rows: int) -> int:
    """How many rows may be recorded at once, when so many are made: up to the one after which the run is looked at."""
    glance, look = max(1, rows // GLANCES), max(1, rows // LOOKS)
    return min(glance - made % glance, -made % look + 1)


def _kept(
    state: State, step: int, table: list[Any], seen: list[np.ndarray], keeper: SnapshotKeeper | None
) -> dict[str, np.ndarray]:
    """What the loop needs to go on."""
    rest = {"step": np.array(step), "table": np.array(table), "seen": np.array(seen)}
    return state._asdict() | rest | (keeper.arrays() if keeper else {})


def _resumed(kept: Arrays, keeper: SnapshotKeeper | None) -> tuple[State, int, list[Any], list[np.ndarray]]:
    if keeper:
        keeper.resume(kept)
    state = State(*(np.ascontiguousarray(kept[name]) for name in State._fields))
    return state, int(kept["step"]), list(map(tuple, kept["table"])), list(kept["seen"])


def _named(values: Iterable[Any]) -> dict[str, Any]:
    """Values of a row, or columns of a history, by name."""
    return dict(zip(("t", *COLUMNS), values, strict=True))


def _locate(stepper: Stepper, state: State, step: int) -> tuple[Strike, int]:
    """Strike at angle zero, and the number of steps to just beyond it.

    Steps on singly to one step past the first angle <= 0, and interpolates by the polynomial, cubic where four
    instants are there, that gives everything as a function of the angle.
    """
    found = [(step, state, stepper.row(state))]
    while len(found) < 2 or found[-2][2][0] > 0.0:
        later = stepper.record_rows(state, 1, 1)
        step, state = step + 1, later.state
        found = [*found[-3:], (step, state, tuple(later.rows[0].tolist()))]
    steps, states, rows = zip(*found, strict=True)
    weights = _lagrange(np.array([row[0] for row in rows]), 0.0)
    values = dict(zip(COLUMNS, (weights @ np.array(rows)).tolist(), strict=True))
    values |= {"t": float(weights @ np.array(steps)) * stepper.loop.time_step, "theta": 0.0}
    positions = np.tensordot(weights, [state.positions_on_wall for state in states], 1)
    velocities = np.tensordot(weights, [stepper.nodal_velocities(state) for state in states], 1)
    return Strike(values, positions, velocities), step


def _lagrange(nodes: np.ndarray, at: float) -> np.ndarray:
    """Weights of the values at `nodes` in the interpolating polynomial at `at`."""
    difference = nodes[:, None] - nodes[None, :]
    np.fill_diagonal(difference, 1.0)
    numerator = at - np.tile(nodes, (nodes.size, 1))
    np.fill_diagonal(numerator, 1.0)
    return np.asarray((numerator / difference).prod(axis=1))
