"""The whole impact of a rigid vehicle: its motion at any instant, and its strikes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from solver.elementary import Array, number
from solver.errors import Gate
from solver.impact import rules
from solver.impact.contact import ContactPoints, WallContact
from solver.impact.dynamics import Dynamics
from solver.impact.integrate import Piece, Span, at_start, integrate
from solver.impact.measure import intervals, strikes_of_motion
from solver.impact.record import ImpactRecord, PointRecord, by_point, record_of, sums
from solver.impact.strike import Strike
from solver.impact.vehicle import ImpactState, ImpactVehicle


@dataclass(frozen=True)
class ImpactMotion:
    """One whole impact; made by `solve_impact`.

    Attributes
    ----------
    vehicle : ImpactVehicle
        As given.
    contact : WallContact
        As given.
    points : ContactPoints
        The four corners, and those of the layer.
    strikes : tuple of Strike
        In order of time.
    t_end : float
        How far the motion was followed [s].
    end : ImpactState
        The state there.
    """

    vehicle: ImpactVehicle
    contact: WallContact
    points: ContactPoints
    strikes: tuple[Strike, ...]
    t_end: float
    end: ImpactState
    _pieces: tuple[Piece, ...] = field(repr=False)

    @cached_property
    def event_times(self) -> Array:
        """Instants at which the integration stopped for an event or a step, shape (n,) [s]."""
        return np.array([piece.start for piece in self._pieces] + [self.t_end])

    def at(self, times: ArrayLike) -> ImpactRecord:
        """The motion at given instants.

        Parameters
        ----------
        times : array_like, of any shape
            From 0 to `t_end` [s].

        Returns
        -------
        ImpactRecord
            Arrays of the shape of `times`.

        Raises
        ------
        RigidBodyError
            For an instant outside that range.
        """
        t, flat = self._instants(times)
        values = self._read_off(sums, np.zeros((15, flat.size)), flat)
        return record_of(self.vehicle, t, values.reshape(15, *t.shape))

    def points_at(self, times: ArrayLike) -> PointRecord:
        """Crush and forces of every point at given instants.

        Parameters
        ----------
        times : array_like, of any shape
            From 0 to `t_end` [s].

        Returns
        -------
        PointRecord
            Arrays of shape (points, ...).

        Raises
        ------
        RigidBodyError
            For an instant outside that range.
        """
        t, flat = self._instants(times)
        values = self._read_off(by_point, np.zeros((4, self.points.along.size, flat.size)), flat)
        return PointRecord(*values.reshape(4, -1, *t.shape))

    def _instants(self, times: ArrayLike) -> tuple[Array, Array]:
        t = np.asarray(number("time", times), dtype=np.float64)
        Gate().demand(rules.TIME, (t >= 0.0) & (t <= self.t_end), t, end=self.t_end)
        return t, t.ravel()

    def _read_off(self, read: Callable[[Piece, Array], Array], out: Array, t: Array) -> Array:
        """What is read off the pieces at these instants, into out, shape (..., n)."""
        index = np.maximum(np.searchsorted(self.event_times[:-1], t, side="right") - 1, 0)
        order = np.argsort(index, kind="stable")
        for here in np.split(order, np.flatnonzero(np.diff(index[order])) + 1) if order.size else ():
            out[..., here] = read(self._pieces[index[here[0]]], t[here])
        return out


def solve_impact(
    vehicle: ImpactVehicle,
    contact: WallContact,
    state: ImpactState,
    end: float | None = None,
    after_second: float = 0.1,
    longest: float = 5.0,
) -> ImpactMotion:
    """The whole impact of a rigid vehicle, any number of strikes, from event to event.

    Parameters
    ----------
    vehicle : ImpactVehicle
        The vehicle.
    contact : WallContact
        What happens where it touches.
    state : ImpactState
        At the start, outside the wall or touching it.
    end : float or None
        How far to follow the motion [s]; None: `after_second` after the first two strikes, and without a second until
        nothing can touch any more, but for `after_second` at least.
    after_second : float
        [s].
    longest : float
        With end None: how far at most [s].

    Returns
    -------
    ImpactMotion
        Gives the motion at any instant.

    Raises
    ------
    RigidBodyError
        For a start inside the wall, for an end that is not positive, and where events follow each other without an end.

    Notes
    -----
    SciPy's DOP853 from event to event, with fixed modes in between: a point touches, unloads, leaves, returns to the
    virgin curve, sticks, slips. Tolerances are 1e-12.
    """
    if end is not None:
        rules.positive(rules.END, end)
    rules.positive(rules.END, after_second)
    rules.positive(rules.END, longest)

    def latest(spans: list[Span], t: float, y: Array, dynamics: Dynamics) -> float:
        return (
            end if end is not None else min(longest, _open_end(vehicle, spans, t, y, dynamics, after_second))
        )

    dynamics, y = at_start(vehicle, contact, state)
    spans = integrate(dynamics, y, latest)
    last, pieces = spans[-1], tuple(piece for span in spans for piece in span.pieces)
    strikes = strikes_of_motion(spans)
    if end is None:
        Gate().demand(rules.NEVER, bool(strikes), state.v_gy)
    return ImpactMotion(
        vehicle, contact, dynamics.points, strikes, last.end, ImpactState(*last.y[:6].tolist()), pieces
    )


def _open_end(
    vehicle: ImpactVehicle, spans: list[Span], t: float, y: Array, dynamics: Dynamics, after_second: float
) -> float:
    """The end after the first two strikes; without a second, when no corner can reach the wall any more, at least
    `after_second` from the start."""
    strikes = intervals(spans)[:2]
    if len(strikes) == 2 and not any(s.end == t and s.corner in dynamics.corners for s in strikes):
        return max(strike.end for strike in strikes) + after_second
    if y[4] <= 0.0:
        return math.inf
    return max(t + max(vehicle.reach - float(y[1]), 0.0) / float(y[4]), after_second)
