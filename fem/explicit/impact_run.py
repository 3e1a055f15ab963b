"""The run of a whole impact: from a model and its first touch to histories of motion, energies and contact."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fem.compiled import Told, compile_once, silent
from fem.contact.wall_contact import ContactState
from fem.discretisation.model import PlateModel
from fem.discretisation.properties import ModelError
from fem.explicit.checkpoint import Arrays, Checkpoint, NoCheckpoint, packed, unpacked
from fem.explicit.impact_loop import ImpactMeasures, ImpactState, Rows, advance_and_record
from fem.explicit.simulate import LOOKS, Stepper
from fem.explicit.snapshots import SnapshotKeeper, Snapshots
from fem.stability.deformed import deformed_frequency
from fem.start.rigid_state import to_global

CHUNK = 200
"""Rows between two looks at whether the run is over."""


@dataclass(frozen=True)
class FirstTouch:
    """Rigid motion of the plate at t = 0, its corner P at the origin.

    Attributes
    ----------
    angle : float
        Between side and wall [rad].
    v_x, v_y, omega : float
        Of the corner [m/s], and the spin that closes the angle [rad/s].
    """

    angle: float
    v_x: float
    v_y: float
    omega: float = 0.0


@dataclass(frozen=True)
class ImpactRun:
    """What a run gives.

    Attributes
    ----------
    history : dict of ndarray, shape (rows,)
        By name: t [s], the fields of `ImpactMeasures`, and force_normal and force_tangential [N], of the wall on the
        plate, each the mean since the row before, and force_foundation, of the foundation on a wall that gives.
    points : ndarray, shape (2, contact points)
        Places in the body frame [m]; a corner that crushes and has a layer is there twice.
    normal, tangential : ndarray, shape (rows, contact points)
        Force on each, likewise [N].
    depth, place : ndarray, shape (rows, contact points)
        Behind the wall's face, and along the wall [m].
    steps : int
        Time steps taken.
    time_loop_s : float
        Time that they took, records included [s].
    highest_frequency : float
        The largest at a few instants of the run [rad/s].
    snapshots : Snapshots or None
        Nodal positions and velocities at some instants, where they were asked for.
    """

    history: dict[str, np.ndarray]
    points: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    depth: np.ndarray
    place: np.ndarray
    steps: int
    time_loop_s: float
    highest_frequency: float
    snapshots: Snapshots | None = None


class ImpactStepper(Stepper):
    """The compiled loop of a whole impact with its parameters and its workspace; the state is the caller's."""

    @property
    def step_call(self) -> tuple[Any, ...]:
        """The compiled function of the run, and arguments of its types."""
        state, rows = self.at_touch(FirstTouch(0.0, 0.0, 0.0)), self.rows(0)
        parts = (self.loop, *self._parts, self._reference, self._force, self._scratch, rows)
        return advance_and_record, state, 1, *parts

    def at_touch(self, touch: FirstTouch) -> ImpactState:
        """State at t = 0: nothing acts on the plate yet, so that its velocities half a step back are the same."""
        d, points = self.model.discretisation, self.loop.contact.mobility.size
        body = self._reference - self._reference[:, [d.corner]]
        arm = to_global(touch.angle) @ body
        velocities = np.array([[touch.v_x], [touch.v_y]]) + touch.omega * np.array([-arm[1], arm[0]])
        contact = ContactState(*(np.zeros(points) for _ in ContactState._fields))
        return ImpactState(
            np.ascontiguousarray(arm),
            np.ascontiguousarray(velocities),
            np.zeros(3),
            np.zeros(1),
            contact,
            self._wall_at_rest(),
        )

    def _wall_at_rest(self) -> Any:
        if self.loop.wall is None:
            return None
        from fem.contact.elastic_wall import at_rest

        return at_rest(self.loop.wall)

    @property
    def points(self) -> np.ndarray:
        """Places [m] of the contact points in the body frame, shape (2, points)."""
        contact = self.loop.contact
        return np.add.reduceat(
            contact.weights * self._reference[:, contact.nodes], contact.first[:-1], axis=1
        )

    def rows(self, count: int) -> Rows:
        """Room for records."""
        points = self.loop.contact.mobility.size
        return Rows(
            np.empty((count, len(ImpactMeasures._fields))), *(np.empty((count, points)) for _ in range(4))
        )

    def record(self, state: ImpactState, stride: int, count: int) -> Rows:
        """Advance the state in place, with a record every so many steps."""
        rows = self.rows(count)
        advance_and_record(
            state, stride, self.loop, *self._parts, self._reference, self._force, self._scratch, rows
        )
        return rows

    def nodal(self, state: Any) -> tuple[np.ndarray, np.ndarray]:
        """Positions [m] and velocities [m/s] at the state's instant in the wall's frame, shape (2, nodes) each."""
        later = unpacked("state", state, packed("state", state))
        self.record(later, 1, 1)
        on_wall = state.positions + np.array([[state.origin[0]], [0.0]])
        return on_wall, 0.5 * (state.velocities + later.velocities)


def compile_impact_loop(model: PlateModel, told: Told = silent) -> None:
    """As `fem.explicit.simulate.compile_loop`."""
    stepper = ImpactStepper(model)
    touched = stepper.at_touch(FirstTouch(0.3, 0.0, 0.0))
    compile_once(lambda: _touch(stepper, touched), *stepper.step_call, told=told)


def _touch(stepper: ImpactStepper, state: ImpactState) -> None:
    stepper.record(state, 1, 0)


def simulate_impact(
    model: PlateModel,
    touch: FirstTouch,
    sample: float,
    latest: float,
    finished: Callable[[ImpactRun], bool] = lambda run: False,
    progress: Callable[[float], None] = lambda share: None,
    checkpoint: Checkpoint | None = None,
    keeper: SnapshotKeeper | None = None,
) -> ImpactRun:
    """Run from the first touch until the latest instant, or until it is finished.

    Parameters
    ----------
    model : PlateModel
        Of `build_impact_model`.
    touch : FirstTouch
        Motion at t = 0.
    sample : float
        Time between rows [s]; a multiple of the time step near it is taken.
    latest : float
        End of the run [s], to a row.
    finished : callable
        Asked now and then whether what there is so far is enough.
    progress : callable
        Told the time that is done [s].
    checkpoint : Checkpoint, optional
        Keeps the run's state now and then; one that has kept it lets the run go on, with the same bits.
    keeper : SnapshotKeeper, optional
        Keeps positions and velocities of all nodes at some rows and at the end.

    Returns
    -------
    ImpactRun
        It ends early where numbers leave the finite.

    Raises
    ------
    ModelError
        Where the plate presses on a wall that gives beyond its end.
    """
    stepper, time_step = ImpactStepper(model), model.loop.time_step
    stride = max(1, round(sample / time_step))
    total = max(1, -int(-latest // (stride * time_step)))
    began, checkpoint = time.perf_counter(), checkpoint or NoCheckpoint()
    state = stepper.at_touch(touch)
    chunks, seen = [stepper.record(state, 0, 1)], [state.positions.copy()]
    if (kept := checkpoint.load()) is not None:
        state, chunks, seen = _resumed(kept, state, chunks[0])
        if keeper:
            keeper.resume(kept)
    elif keeper:
        keeper.look(0.0, 0.0, functools.partial(stepper.nodal, state))
    run = _run(stepper, chunks, stride, 0.0)
    while sum(len(chunk.values) for chunk in chunks) <= total and np.isfinite(chunks[-1].values).all():
        done = sum(len(chunk.values) for chunk in chunks) - 1
        chunks.append(_chunk(stepper, state, stride, done, min(CHUNK, total - done), keeper))
        seen.append(state.positions.copy())
        _check_length(state)
        run = _run(stepper, chunks, stride, time.perf_counter() - began)
        progress(float(run.history["t"][-1]))
        if finished(run) or len(run.history["t"]) > total:
            break
        checkpoint.save(functools.partial(_kept, state, chunks, seen, keeper))
    looked = [seen[k] for k in np.unique(np.linspace(0, len(seen) - 1, LOOKS).astype(int))]
    finite = [positions for positions in looked if np.isfinite(positions).all()]
    frequency = max((deformed_frequency(model, positions) for positions in finite), default=np.inf)
    run = _run(stepper, chunks, stride, run.time_loop_s, frequency)
    if keeper is None:
        return run
    return replace(run, snapshots=keeper.finished(float(run.history["t"][-1]), stepper.nodal(state)))


def _chunk(
    stepper: ImpactStepper, state: ImpactState, stride: int, done: int, count: int, keeper: Any
) -> Rows:
    """So many more rows after those that are done, cut where a snapshot is due: the bits are those of a whole chunk."""
    if keeper is None:
        return stepper.record(state, stride, count)
    row, parts, last = stride * stepper.loop.time_step, [], done + count
    while done < last:
        until = min(last, max(done + 1, round(min(keeper.due, row * last) / row)))
        parts.append(stepper.record(state, stride, until - done))
        done = until
        keeper.look(row * done, row, functools.partial(stepper.nodal, state))
    return Rows(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _check_length(state: ImpactState) -> None:
    if state.wall is not None and state.wall.beyond[0] > 0.0:
        raise ModelError(
            "wall.length",
            f"the plate presses {state.wall.beyond[0]:.3g} m beyond the wall's end; make it longer",
        )


def _kept(
    state: ImpactState, chunks: list[Rows], seen: list[np.ndarray], keeper: SnapshotKeeper | None
) -> dict[str, np.ndarray]:
    """What the loop needs to go on; the state is of this instant, for the loop advances it in place."""
    rows = Rows(*(np.concatenate(parts) for parts in zip(*chunks, strict=True)))
    snapshots = keeper.arrays() if keeper else {}
    return packed("state", state) | packed("rows", rows) | {"seen": np.array(seen)} | snapshots


def _resumed(
    kept: Arrays, state: ImpactState, rows: Rows
) -> tuple[ImpactState, list[Rows], list[np.ndarray]]:
    """The same again; state and rows: any others of this model."""
    return unpacked("state", state, kept), [unpacked("rows", rows, kept)], list(kept["seen"])


def _run(
    stepper: ImpactStepper, chunks: list[Rows], stride: int, seconds: float, frequency: float = np.nan
) -> ImpactRun:
    """The rows so far, impulses as mean forces since the row before; the first row, before any, has none."""
    values, normal, tangential, depth, place = (np.concatenate(parts) for parts in zip(*chunks, strict=True))
    interval = stride * stepper.loop.time_step
    history = {"t": interval * np.arange(len(values))}
    history |= dict(zip(ImpactMeasures._fields, values.T, strict=True))
    history["theta"] = np.unwrap(history["theta"])
    push, drag = (
        np.diff(impulse, axis=0, prepend=impulse[:1]) / interval for impulse in (normal, tangential)
    )
    history["force_normal"], history["force_tangential"] = push.sum(axis=1), drag.sum(axis=1)
    history["force_foundation"] = np.diff(history["foundation_impulse"], prepend=0.0) / interval
    steps = stride * (len(values) - 1)
    return ImpactRun(history, stepper.points, push, drag, depth, place, steps, seconds, frequency)
