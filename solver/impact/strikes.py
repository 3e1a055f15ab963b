"""Strikes of a whole impact: found in sampled forces, or as the compiled step has counted them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.impact.step import SHORTEST
from solver.impact.train import CORNERS
from solver.rules import Array


@dataclass(frozen=True)
class Strike:
    """One strike: a corner, or its half of each side, is pressed on, until it is off the wall for as long.

    Attributes
    ----------
    corner : str
        One of `CORNERS`; of a trailer with its name in front, as of `corner_name`.
    start, end : float
        [s]; `end` is that of the motion where the strike goes on.
    peak_force : float
        Greatest normal force [N].
    impulse : float
        Of the normal force [N s].
    impulse_tangential : float
        Of the friction on the vehicle along +X [N s].
    point_of_attack : float
        Distance behind the front, along the side, mean weighted with the normal force [m].
    position : float
        The same along the wall, X [m].
    energy_absorbed : float
        Net work of the normal forces on the crush [J].
    friction_work : float
        On the vehicle [J].
    """

    corner: str
    start: float
    end: float
    peak_force: float
    impulse: float
    impulse_tangential: float = math.nan
    point_of_attack: float = math.nan
    position: float = math.nan
    energy_absorbed: float = math.nan
    friction_work: float = math.nan

    @property
    def duration(self) -> float:
        """From start to end [s]."""
        return self.end - self.start

    @property
    def mean_force(self) -> float:
        """Impulse over duration [N]."""
        return self.impulse / self.duration


def is_over(start: Any, end: Any, now: Any) -> Any:
    """True if a strike that began at `start` and last pressed at `end` is over at `now`, all [s]: the corner has been
    off the wall for as long as its strike has lasted. Where it hops, as a plate does, hops are one strike; else a gap
    that a mesh opens or closes would tell how many there are."""
    return now - end >= np.maximum(SHORTEST, end - start)


def strikes_of(
    t: Array,
    force_by_corner: Mapping[str, Array],
    tangential_by_corner: Mapping[str, Array] | None = None,
    station_by_corner: Mapping[str, Array] | None = None,
    position_by_corner: Mapping[str, Array] | None = None,
) -> tuple[Strike, ...]:
    """Strikes from sampled forces, by the rule of the rigid impact.

    Every sample is the mean over an interval, the increment of the impulse over the time between two instants, so that
    impulses are exact. The start lies within the first interval with a force where a straight rise would put it that
    has the means of that interval and the next, and the end likewise; the peak is that of the parabola with the means
    of the highest sample and its neighbours.

    Parameters
    ----------
    t : ndarray, shape (n + 1,)
        Instants [s].
    force_by_corner : dict of ndarray, shape (n,)
        Mean normal forces of each corner [N].
    tangential_by_corner : dict of ndarray, shape (n,), or None
        The same along the wall, on the vehicle [N].
    station_by_corner, position_by_corner : dict of ndarray, shape (n,), or None
        Points of attack, behind the front and along the wall [m].

    Returns
    -------
    tuple of Strike
        In order of time; what was not given is NaN.
    """
    tangential, station = tangential_by_corner or {}, station_by_corner or {}
    found = []
    for corner, force in force_by_corner.items():
        beside = [values.get(corner) for values in (tangential, station, position_by_corner or {})]
        intervals = _pressed(np.asarray(t), np.asarray(force))
        found += [_sampled(corner, np.asarray(t), np.asarray(force), run, beside) for run in intervals]
    return tuple(sorted(found, key=lambda strike: strike.start))


def _pressed(t: Array, force: Array) -> list[tuple[int, int]]:
    """Runs of samples with a force, first and last + 1; those of one strike as one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], force > 0.0, [0]]))).reshape(-1, 2)
    runs: list[tuple[int, int]] = []
    for first, last in edges:
        if runs and not is_over(t[runs[-1][0]], t[runs[-1][1]], t[first]):
            runs[-1] = (runs[-1][0], int(last))
        else:
            runs.append((int(first), int(last)))
    return runs


def _sampled(corner: str, t: Array, force: Array, run: tuple[int, int], beside: list[Array | None]) -> Strike:
    part = slice(*run)
    step = np.diff(t[run[0] : run[1] + 1])
    push = force[part] * step
    start = t[run[0] + 1] - _pressed_fraction(force[part]) * step[0]
    end = t[run[1] - 1] + _pressed_fraction(force[part][::-1]) * step[-1]
    tangential, station, position = (None if v is None else np.asarray(v)[part] for v in beside)
    along = math.nan if tangential is None else float(tangential @ step)
    means = [math.nan if v is None else float(v @ push) / float(push.sum()) for v in (station, position)]
    peak = _parabola_peak(t, force, run)
    return Strike(corner, float(start), float(end), peak, float(push.sum()), along, *means)


def _pressed_fraction(force: Array) -> float:
    """Fraction of the first interval that is under force: u^2/(2 u + 1) = F1/F2 for a straight rise."""
    if force.size < 2 or force[0] >= force[1] / 3.0:
        return 1.0
    ratio = float(force[0] / force[1])
    return ratio + math.sqrt(ratio * (ratio + 1.0))


def _parabola_peak(t: Array, force: Array, run: tuple[int, int]) -> float:
    """Peak of the parabola that has the three highest samples' means; the highest sample where there are not three."""
    k = run[0] + int(np.argmax(force[slice(*run)]))
    if k <= run[0] or k >= run[1] - 1:
        return float(force[k])
    edges = t[k - 1 : k + 3] - t[k]
    impulse = np.concatenate([[0.0], np.cumsum(force[k - 1 : k + 2] * np.diff(edges))])
    cubic = np.polyfit(edges, impulse, 3)  # of the impulse; its slope is the force
    if cubic[0] >= 0.0:
        return float(force[k])
    top = float(np.clip(-cubic[1] / (3.0 * cubic[0]), edges[0], edges[3]))
    return float(np.polyval(np.polyder(cubic), top))


def corner_name(unit: int, corner: int) -> str:
    """Name of a corner of a train.

    Parameters
    ----------
    unit : int
        From 0, the first vehicle.
    corner : int
        Index into `CORNERS`.

    Returns
    -------
    str
        "rear", "trailer rear", "trailer 2 rear" and so on.
    """
    number = f"{unit} " if unit > 1 else ""
    return f"trailer {number}{CORNERS[corner]}" if unit else CORNERS[corner]


def strikes_of_rows(rows: Array, fronts: Sequence[float], end: float) -> tuple[Strike, ...]:
    """Rows of `step.STRIKE` as strikes of units whose centres of mass are so far behind their fronts [m]."""
    found, known = [], (rows[:, 4] > 0.0) & (rows[:, 1] < end)
    for group, start, last, peak, impulse, along, station, place, crush, friction in rows[known]:
        unit, corner = divmod(int(group), 4)
        means = round(fronts[unit] - station / impulse, 12), place / impulse
        values = start, min(last, end), peak, impulse, along, *means, crush, friction
        found.append(Strike(corner_name(unit, corner), *map(float, values)))
    return tuple(sorted(found, key=lambda strike: strike.start))
