"""Run of a whole impact from the first touch to its histories."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fem.explicit import impact_loop
from fem.explicit.columns import IMPACT_COLUMNS
from fem.explicit.impact_loop import ImpactLoopState
from fem.laws import tyres
from fem.laws.hinges import HINGE, UNIT, unloaded
from fem.laws.wall_contact import ContactState
from fem.model.plate_model import PlateModel
from fem.plate.properties import ModelError
from fem.run import observers, runner
from fem.stability.deformed import deformed_frequency
from fem.start import inertia_relief
from machine_code.compiled import Kernel, OnCompile, compile_once, ignore_compiling

CHECK_ROWS = 200
"""Rows between two checks for the end of the run."""


@dataclass(frozen=True)
class FirstTouch:
    """Rigid motion of the plate at t = 0.

    Corner P is at X = 0.

    Attributes
    ----------
    angle : float
        Angle between side and wall [rad].
    v_x, v_y, omega : float
        Velocity of the corner [m/s], and angular velocity [rad/s], positive as the rear rotates towards the wall.
    height : float
        Distance of the corner from the wall [m]; 0 where it touches first, negative where a part behind it does.
    """

    angle: float
    v_x: float
    v_y: float
    omega: float = 0.0
    height: float = 0.0


@dataclass(frozen=True)
class ImpactRun:
    """A run of a whole impact.

    Attributes
    ----------
    history : dict of ndarray, shape (rows,)
        Columns by name: t [s], the fields of `ImpactMeasures`, and force_normal and force_tangential [N], of the wall
        on the plate, each the mean since the row before, and force_foundation, of the foundation on a deformable wall.
    points : ndarray, shape (2, contact points)
        Places in the body frames of their plates [m].
    unit, group : ndarray, shape (contact points,)
        Numbers of the plate and of the group of each point, see `fem.model.contact_points.wall_contact`.
    normal, tangential : ndarray, shape (rows, contact points)
        Force on each, the mean since the row before [N].
    depth, place : ndarray, shape (rows, contact points)
        Behind the wall's face, and along the wall [m].
    units : tuple of dict of ndarray, shape (rows,)
        Rigid motion of each plate of a train by the names of `fem.laws.hinges.UNIT`; empty for one plate.
    hinges : ndarray, shape (hinges, 2, rows)
        Force of the plate behind on the one ahead along X and Y, mean since the row before [N].
    steps : int
        Number of time steps.
    time_loop_s : float
        Their computing time, records included [s].
    model : PlateModel
        The plate.
    shapes : sequence of ndarray, shape (2, nodes)
        Positions at a few instants of the run [m].
    snapshots : Snapshots or None
        Nodal positions and velocities at some instants, if requested.
    """

    history: dict[str, np.ndarray]
    points: np.ndarray
    unit: np.ndarray
    group: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    depth: np.ndarray
    place: np.ndarray
    units: tuple[dict[str, np.ndarray], ...]
    hinges: np.ndarray
    steps: int
    model: PlateModel
    time_loop_s: float = np.nan
    shapes: Sequence[np.ndarray] = ()
    snapshots: observers.Snapshots | None = None

    @cached_property
    def highest_frequency(self) -> float:
        """Highest frequency of the plate at these instants [rad/s]."""
        return deformed_frequency(self.model, self.shapes)


class ImpactStepper(runner.PlateStepper[ImpactLoopState]):
    """Compiled loop of a plate in contact with the wall."""

    @property
    def step_call(self) -> tuple[Kernel, tuple[object, ...]]:
        """Compiled function of the run, and arguments of its types."""
        state = self.at_touch(FirstTouch(0.0, 0.0, 0.0))
        return impact_loop.advance_and_record, (state, 1, *self._all_parts, self._new_rows(0))

    def at_touch(self, touch: FirstTouch) -> ImpactLoopState:
        """Return the state at t = 0.

        No force acts on the plate yet, so that its velocities half a step back are the same.
        """
        points, wall = self.parameters.contact.mobility.size, None
        body = self._reference - self._reference[:, [self.model.discretisation.corner]]
        arm = inertia_relief.to_global(touch.angle) @ body
        velocities = np.array([[touch.v_x], [touch.v_y]]) + touch.omega * np.array([-arm[1], arm[0]])
        contact = ContactState(*(np.zeros(points) for _ in ContactState._fields))
        if self.parameters.wall is not None:
            from fem.laws import wall_contact

            wall = wall_contact.at_rest(self.parameters.wall)
        arm[1] += touch.height
        positions, velocities = np.ascontiguousarray(arm), np.ascontiguousarray(velocities)
        sums, origin, hinges = np.zeros(3), np.zeros(1), unloaded(self.parameters.hinges)
        axles = tyres.at_rest(self.parameters.axles)
        return ImpactLoopState(positions, velocities, sums, origin, contact, wall, hinges, axles)

    @property
    def points(self) -> np.ndarray:
        """Places [m] of the contact points, shape (2, points).

        They are in the body frames of their plates.
        """
        contact, hinges = self.parameters.contact, self.parameters.hinges
        places = np.add.reduceat(
            contact.weights * self._reference[:, contact.nodes], contact.first[:-1], axis=1
        )
        for number in range(len(hinges.inertia) + 1 if hinges is not None else 0):
            plate = self._reference[:, hinges.unit == number]
            places[:, self.unit == number] -= [[plate[0].max()], [plate[1].min()]]
        return places

    @property
    def unit(self) -> np.ndarray:
        """Number of the plate of each contact point, shape (points,)."""
        contact, hinges = self.parameters.contact, self.parameters.hinges
        nodes = contact.nodes[contact.first[:-1]]
        return np.zeros(nodes.size, dtype=int) if hinges is None else np.asarray(hinges.unit[nodes])

    def _new_rows(self, count: int) -> impact_loop.Rows:
        """Return arrays for this number of rows."""
        hinges = 0 if self.parameters.hinges is None else len(self.parameters.hinges.inertia)
        units = len(UNIT) * (hinges + 1) + len(HINGE) * hinges if hinges else 0
        road = 0 if self.parameters.axles is None else len(tyres.SUMS)
        sizes = (
            len(impact_loop.ImpactMeasures._fields),
            *4 * (self.parameters.contact.mobility.size,),
            units,
            road,
        )
        return impact_loop.Rows(*(np.empty((count, size)) for size in sizes))

    def parts(self, rows: np.ndarray) -> tuple[np.ndarray, ...]:
        """Split rows into the fields of `Rows`."""
        ends = np.cumsum([part.shape[1] for part in self._new_rows(0)])
        return tuple(np.split(rows, ends[:-1], axis=1))

    def record(self, state: ImpactLoopState, stride: int, count: int) -> runner.Recorded[ImpactLoopState]:
        """Return `count` rows, `stride` steps apart.

        A row has the fields of `Rows` side by side. Raises ModelError where the plate presses on a deformable wall
        beyond its end.
        """
        later, rows = runner.copy_state(state), self._new_rows(count)
        impact_loop.advance_and_record(later, stride, *self._all_parts, rows)
        if later.wall is not None and (beyond := later.wall.beyond[0]) > 0.0:
            why = f"contact extends {beyond:.3g} m beyond the end of the wall; increase the length"
            raise ModelError("wall.length", why)
        return runner.Recorded(np.hstack(rows), state, later)


def compile_impact_loop(model: PlateModel, on_compile: OnCompile = ignore_compiling) -> None:
    """Compile or load all code of a run of this model.

    See `fem.run.corner.compile_loop`.
    """
    stepper = ImpactStepper(model)
    touched = stepper.at_touch(FirstTouch(0.3, 0.0, 0.0))
    kernel, arguments = stepper.step_call
    compile_once(lambda: stepper.record(touched, 1, 0), kernel, *arguments, on_compile=on_compile)


def simulate_impact(
    model: PlateModel,
    touch: FirstTouch,
    sample: float,
    latest: float,
    finished: Callable[[ImpactRun], bool] = lambda run: False,
    progress: Callable[[float], None] = lambda now: None,
    checkpoint: observers.Checkpoint | None = None,
    snapshots: int = 0,
    duration: float | None = None,
) -> ImpactRun:
    """Run a whole impact from the first touch.

    It ends at the latest instant, or earlier when it is finished.

    Parameters
    ----------
    model : PlateModel
        Model of `build_impact_model`.
    touch : FirstTouch
        Motion at t = 0.
    sample : float
        Time between rows [s], rounded to a multiple of the time step.
    latest : float
        End of the run [s], to a row.
    finished : callable
        Called at intervals from the expected end; the run ends when it returns True for the rows so far.
    progress : callable
        Called with the simulated time [s].
    checkpoint : Checkpoint, optional
        Saves the run's state at intervals; a saved run is resumed with the same bits.
    snapshots : int
        Number of instants at which positions and velocities of all nodes are recorded, with the end.
    duration : float, optional
        Expected end of the run [s], which determines the spacing of the snapshots; by default the latest for these,
        and the start for `finished`.

    Returns
    -------
    ImpactRun
        It ends early where values become infinite or not a number.

    Raises
    ------
    ModelError
        Where contact extends beyond the end of a deformable wall.
    """
    stepper = ImpactStepper(model)
    stride = max(1, round(sample / model.parameters.time_step))
    interval = stride * model.parameters.time_step

    def over(rows: np.ndarray) -> bool:
        if not np.isfinite(rows[-1]).all():
            return True
        return (len(rows) - 1) * interval >= (duration or 0.0) and finished(_run(stepper, rows, stride))

    shapes = observers.ShapeSampler(CHECK_ROWS)
    keeper = observers.SnapshotKeeper(snapshots, (duration or latest) / interval, stepper.nodal)
    observing: list[runner.Observer] = [
        shapes,
        *([keeper] if snapshots else []),
        observers.Progress(progress, interval),
        observers.EndCondition(over, CHECK_ROWS),
    ]
    saver, touched = observers.Saver(checkpoint, observing), stepper.at_touch(touch)
    total = max(1, -int(-latest // interval))
    state, earlier = saver.resumed_state(stepper, touched, total, lambda: touched)
    began = time.perf_counter()
    rows, _, state = runner.run(stepper, state, stride, total, [*observing, saver], earlier)
    elapsed, run = time.perf_counter() - began, _run(stepper, rows, stride)
    positions = shapes.samples + ([state.positions] if (len(rows) - 1) % CHECK_ROWS else [])
    sampled = [
        positions[k] for k in np.unique(np.linspace(0, len(positions) - 1, observers.SHAPES).astype(int))
    ]
    snaps = keeper.finished(run.history["t"], stepper.nodal(state)) if snapshots else None
    return replace(run, time_loop_s=elapsed, shapes=sampled, snapshots=snaps)


def _run(stepper: ImpactStepper, rows: np.ndarray, stride: int) -> ImpactRun:
    """Return the run of the rows so far.

    Impulses become mean forces since the row before; those of the first row are zero.
    """
    values, normal, tangential, depth, place, units, road = stepper.parts(rows)
    interval = stride * stepper.parameters.time_step
    history = {"t": interval * np.arange(len(values))}
    history |= dict(zip(impact_loop.ImpactMeasures._fields, values.T, strict=True))
    history |= dict(zip(tyres.SUMS, road.T, strict=False))  # none without axles
    history["theta"] = np.unwrap(history["theta"])
    push, drag = (
        np.diff(impulse, axis=0, prepend=impulse[:1]) / interval for impulse in (normal, tangential)
    )
    history["force_normal"], history["force_tangential"] = push.sum(axis=1), drag.sum(axis=1)
    history["force_foundation"] = np.diff(history["foundation_impulse"], prepend=0.0) / interval
    for column in IMPACT_COLUMNS.values():
        if column.value is not None:
            history[column.name] = column.value(history, stepper.model)
    steps = stride * (len(values) - 1)
    motions, hinges = _train_motion(units, interval)
    group = np.asarray(stepper.model.contact_groups)
    contact = stepper.points, stepper.unit, group, push, drag, depth, place
    return ImpactRun(history, *contact, motions, hinges, steps, stepper.model)


def _train_motion(rows: np.ndarray, interval: float) -> tuple[tuple[dict[str, np.ndarray], ...], np.ndarray]:
    """Return motions of the plates of a train, and hinge forces.

    rows: columns of plates, then of hinges.
    """
    count = (rows.shape[1] + len(HINGE)) // (len(UNIT) + len(HINGE)) if rows.shape[1] else 0
    split = len(UNIT) * count
    motions = [
        dict(zip(UNIT, columns, strict=True))
        for columns in rows[:, :split].T.reshape(count, len(UNIT), len(rows))
    ]
    for motion in motions:
        motion["theta"] = np.unwrap(motion["theta"])
    impulses = rows[:, split:].T.reshape(max(0, count - 1), len(HINGE), len(rows))
    return tuple(motions), np.diff(impulses, prepend=0.0) / interval
