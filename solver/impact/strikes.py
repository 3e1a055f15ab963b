"""Strikes of a whole impact, from sampled forces or rows."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from solver.conditions import Array
from solver.impact.counting import LIGHT, over_from

CORNER_ENDS = ("front", "rear", "side")
"""Last words of the names of corners."""

ROUNDING = 1e-12
"""Force over the largest of its corner up to which it is none."""


@dataclass(frozen=True)
class Strike:
    """Contact of a strip, or of a corner, with the wall.

    It ends when the strip is off the wall for as long as the strike has lasted. Touches until then belong to it, and
    prolong it if they have `LIGHT` of its impulse or more.

    Attributes
    ----------
    corner : str
        What strikes, a name of `group_names`.
    start, end : float
        Start and end [s]; `end` is that of the motion where the contact lasts until then.
    peak_force : float
        Greatest normal force [N].
    impulse : float
        Impulse of the normal force [N s].
    impulse_tangential : float
        Impulse of the friction on the vehicle along +X [N s].
    point_of_attack : float
        Distance behind the front, along the side, mean weighted with the normal force [m].
    position : float
        Mean place along the wall, X, weighted likewise [m].
    energy_absorbed : float
        Net work of the normal forces on the crush [J].
    friction_work : float
        Work of friction on the vehicle [J].
    cut : bool
        The motion ends before the strike is over: duration, peak and impulse are at least these.
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
    cut: bool = field(default=False, kw_only=True)

    @property
    def part(self) -> str:
        """What strikes, in words."""
        return (
            f"{self.corner} corner" if self.corner.split()[-1] in CORNER_ENDS else f"strip at {self.corner}"
        )

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.end - self.start


def strikes_of(
    t: Array,
    force_by_corner: Mapping[str, Array],
    tangential_by_corner: Mapping[str, Array] | None = None,
    station_by_corner: Mapping[str, Array] | None = None,
    position_by_corner: Mapping[str, Array] | None = None,
    light: float = LIGHT,
    apart: float = 1.0,
) -> tuple[Strike, ...]:
    """Return strikes from sampled forces.

    The rule is that of the rigid impact.

    Every sample is the mean over an interval, the increment of the impulse over the time between two instants, so that
    impulses are exact. The start lies within the first interval with a force, at the foot of the linear rise with the
    means of that interval and the next, and the end likewise. The peak is that of the parabola with the means of the
    highest sample and its neighbours, of equal length.

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
    light : float
        Impulse of later touches over that of the strike, from which they prolong it.
    apart : float
        Time off the wall after which a strike is over, over that of the rule.

    Returns
    -------
    tuple of Strike
        In order of time; omitted quantities are NaN.
    """
    tangential, station = tangential_by_corner or {}, station_by_corner or {}
    strikes = []
    for corner, force in force_by_corner.items():
        further = [values.get(corner) for values in (tangential, station, position_by_corner or {})]
        touches = _touches(np.asarray(t), np.asarray(force), light, apart)
        strikes += [_sampled(corner, np.asarray(t), np.asarray(force), touch, further) for touch in touches]
    return tuple(sorted(strikes, key=lambda strike: strike.start))


def _touches(t: Array, force: Array, light: float, apart: float) -> list[tuple[int, int, int]]:
    """Return the samples of each strike.

    The first, the end of those that prolong it, and the end of all.
    """
    edges = np.flatnonzero(
        np.diff(np.concatenate([[0], force > ROUNDING * force.max(initial=0.0), [0]]))
    ).reshape(-1, 2)
    impulse = np.concatenate([[0.0], np.cumsum(force * np.diff(t))])
    strikes: list[tuple[int, int, int]] = []
    for first, last in edges.tolist():
        start, until, _ = strikes[-1] if strikes else (0, 0, 0)
        over = over_from.py_func(t[start], t[until])
        if not strikes or t[first] >= over + (apart - 1.0) * (over - t[until]):
            strikes.append((first, last, last))
            continue
        is_light = impulse[last] - impulse[until] < light * (impulse[last] - impulse[start])
        strikes[-1] = start, until if is_light else last, last
    return strikes


def _sampled(
    corner: str, t: Array, force: Array, touches: tuple[int, int, int], further: list[Array | None]
) -> Strike:
    first, last, until = touches
    part, step = slice(first, until), np.diff(t[first : until + 1])
    impulse, pressed = force[part] * step, force[first:last]
    start = t[first + 1] - _pressed_fraction(pressed) * step[0]
    end = t[last - 1] + _pressed_fraction(pressed[::-1]) * (t[last] - t[last - 1])
    tangential, station, position = (None if v is None else np.asarray(v)[part] for v in further)
    along = math.nan if tangential is None else float(tangential @ step)
    total = float(impulse.sum())
    means = [math.nan if v is None else float(v @ impulse) / total for v in (station, position)]
    peak = _parabola_peak(force, (first, until))
    cut = bool(until == force.size or over_from.py_func(t[first], t[last]) > t[-1])
    return Strike(corner, float(start), float(end), peak, total, along, means[0], means[1], cut=cut)


def _pressed_fraction(force: Array) -> float:
    """Return the fraction of the first interval with a force.

    u^2/(2 u + 1) = F1/F2 for a linear rise.
    """
    if force.size < 2 or force[0] >= force[1] / 3.0:
        return 1.0
    ratio = float(force[0] / force[1])
    return ratio + math.sqrt(ratio * (ratio + 1.0))


def _parabola_peak(force: Array, run: tuple[int, int]) -> float:
    """Return the peak of a fitted parabola.

    Its means are the highest sample and its neighbours; with fewer samples it is the highest. The top is above that no
    further than by the least curvature there, since a force that drops from one sample to the next has its peak before.
    """
    k = run[0] + int(np.argmax(force[slice(*run)]))
    bends = -np.diff(force[max(k - 2, run[0]) : min(k + 3, run[1])], 2)
    if k <= run[0] or k >= run[1] - 1 or bends.min() <= 0.0:
        return float(force[k])
    before, top, after = force[k - 1 : k + 2]
    bend = 2.0 * top - before - after
    return float(top + min(bend / 24.0 + (after - before) ** 2 / (8.0 * bend), bends.min() / 6.0))


def nearest(strikes: Sequence[Strike], strike: Strike) -> Strike | None:
    """Return the strike of the same corner that is nearest in time."""
    same = [candidate for candidate in strikes if candidate.corner == strike.corner]
    return min(same, key=lambda candidate: abs(candidate.start - strike.start), default=None)


def strikes_of_rows(
    rows: Array, names: Sequence[str], fronts: Sequence[float], end: float
) -> tuple[Strike, ...]:
    """Convert rows of `state.STRIKE` to strikes.

    names: of the groups; fronts: distance of the centre of mass of each group's unit behind its front [m].
    """
    strikes, occurred = [], (rows[:, 4] > 0.0) & (rows[:, 1] < end)
    for group, start, last, peak, impulse, along, station, place, crush, friction, cut in rows[
        occurred
    ].tolist():
        number, until = int(group), min(last, end)
        attack, position = round(fronts[number] - station / impulse, 12), place / impulse
        further = along, attack, position, crush, friction
        strikes.append(Strike(names[number], start, until, peak, impulse, *further, cut=bool(cut)))
    return tuple(sorted(strikes, key=lambda strike: strike.start))
