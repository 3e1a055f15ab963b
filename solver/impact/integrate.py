"""The whole impact, from event to event: SciPy's DOP853 in fixed modes, and from each event on in new ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple
from typing import NamedTuple

import numpy as np

from solver.elementary import Array
from solver.errors import Gate, RigidBodyError
from solver.impact import rules
from solver.impact.contact import CORNERS, WallContact, contact_points
from solver.impact.dynamics import SIZE, Dynamics, kinematics
from solver.impact.events import Dense, Event, first_event, watch
from solver.impact.modes import FREE, Modes
from solver.impact.switch import after, start_dynamics
from solver.impact.vehicle import ImpactState, ImpactVehicle

RTOL, ATOL = 1e-12, 1e-14
_TURN = 0.1  # rad a step, at most
_SAME = 1e-12  # s: events closer than this are counted as simultaneous
_MOST_EVENTS = 100_000


class Piece(NamedTuple):
    """A step of the motion: its span [s], its states, and the dynamics in its modes."""

    start: float
    end: float
    dense: Dense
    dynamics: Dynamics


def at_start(vehicle: ImpactVehicle, contact: WallContact, state: ImpactState) -> tuple[Dynamics, Array]:
    """The dynamics and the state y at time 0."""
    points = contact_points(vehicle, contact)
    count = points.along.size
    free = Modes(np.full(count, FREE), np.ones(count), np.zeros(count))
    dynamics = Dynamics(vehicle.mass, vehicle.inertia, contact.friction, points, free)
    y = np.zeros(SIZE)
    y[:6] = astuple(state)
    depth = kinematics(points.along, points.across, y[:, None]).crush[:4, 0]
    for name, value in zip(CORNERS, depth, strict=True):
        Gate().demand(rules.INSIDE, value <= 1e-9 * vehicle.length, value, name=name, depth=value)
    return start_dynamics(dynamics, y), y


class Span(NamedTuple):
    """From one event to the next, in the same modes: its start and end [s], its steps, the last state, what ends it."""

    start: float
    end: float
    dynamics: Dynamics
    pieces: list[Piece]
    y: Array
    event: Event | None


@np.errstate(over="ignore", invalid="ignore")  # of a first step that is far too long, and not taken
def integrate_span(dynamics: Dynamics, t: float, y: Array, latest: float, speed: float) -> Span:
    """From (t, y) to the next event, or to the latest instant; speed: at the start [m/s]."""
    from scipy.integrate import DOP853

    atol = _tolerances(dynamics, speed)
    watched = watch(dynamics)
    pieces: list[Piece] = []
    spin = abs(y[5])
    flying = dynamics.pressed.points.size == 0
    limit = min(latest - t, _TURN / spin) if spin and flying else latest - t
    options = {"rtol": RTOL, "atol": atol, "max_step": limit}
    stepper = DOP853(dynamics.rates, t, y, latest, first_step=limit if flying else None, **options)
    while stepper.status == "running":
        before, t_0 = stepper.y.copy(), float(stepper.t)
        message = stepper.step()
        _demand(message is None and stepper.status != "failed" and bool(np.isfinite(stepper.y).all()), t_0)
        dense = stepper.dense_output()
        event = first_event(dynamics, watched, (t_0, float(stepper.t)), dense)
        if event is not None:
            more, last = _to_event(dynamics, t_0, before, event, atol)
            return Span(t, event.t, dynamics, pieces + more, last, event)
        pieces.append(Piece(t_0, float(stepper.t), dense, dynamics))
    return Span(t, float(stepper.t), dynamics, pieces, stepper.y, None)


def _to_event(dynamics: Dynamics, t: float, y: Array, event: Event, atol: Array) -> tuple[list[Piece], Array]:
    """The last step once more, to the event: a step is more accurate than its dense output."""
    from scipy.integrate import DOP853

    if event.t - t <= 1e-14 * max(1.0, t):
        return [], y
    options = {"rtol": RTOL, "atol": atol, "first_step": event.t - t}
    stepper, pieces = DOP853(dynamics.rates, t, y, event.t, **options), []
    while stepper.status == "running":
        start = float(stepper.t)
        _demand(stepper.step() is None and stepper.status != "failed", start)
        pieces.append(Piece(start, float(stepper.t), stepper.dense_output(), dynamics))
    return pieces, stepper.y


def _demand(met: bool, t: float) -> None:
    if not met:
        why = f"the steps become too short at {t:.10g} s"
        raise RigidBodyError("contact", "this law", why, "a smaller stiffness or friction")


def _size(dynamics: Dynamics) -> float:
    return float(np.abs(dynamics.points.along).max())


def _tolerances(dynamics: Dynamics, speed: float) -> Array:
    """Of the eleven unknowns, from the speed at the start and what a crush that is off by rounding brings in a step."""
    m, size = dynamics.mass, _size(dynamics)
    natural = math.sqrt(np.abs(dynamics.pressed.slope).sum() / m)
    v = speed + np.finfo(np.float64).eps / ATOL * size * natural
    turn = v / size
    return ATOL * np.array([size, size, 1.0, v, v, turn, m * v, m * v, m * v * size, m * v * v, m * v * v])


Latest = Callable[[list[Span], float, Array, Dynamics], float]  # spans so far, then t, state and dynamics now


def integrate(dynamics: Dynamics, y: Array, latest: Latest) -> list[Span]:
    """The motion from time 0 to what `latest` says after every event."""
    spans: list[Span] = []
    t, crowd, speed = 0.0, 0, math.hypot(y[3], y[4]) + _size(dynamics) * abs(y[5]) or 1.0
    while (end := latest(spans, t, y, dynamics)) > t:
        span = integrate_span(dynamics, t, y, end, speed)
        spans.append(span)
        crowd = crowd + 1 if span.end - t < _SAME else 0
        t, y = span.end, span.y
        if span.event is not None:
            _demand_progress(crowd, len(spans), span.event, dynamics.points.along.size)
            dynamics = after(dynamics, span.event, y)
    return spans


def _demand_progress(crowd: int, total: int, event: Event, points: int) -> None:
    if crowd > 20 + 10 * points or total > _MOST_EVENTS:
        given = f"such that {event.kind.name.lower()} at {event.t:.10g} s repeats"
        why = "events follow each other without an end (Zeno)"
        raise RigidBodyError("contact", given, why, "another restitution or friction")
