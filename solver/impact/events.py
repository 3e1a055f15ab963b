"""What ends a segment of the motion: margins that are 0 or more as long as the modes of the points hold."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from solver.elementary import Array
from solver.impact.crush_law import virgin_force
from solver.impact.dynamics import Dynamics, Kinematics, kinematics
from solver.impact.friction import stick_margin
from solver.impact.modes import FREE, HELD, LINE, LOADING, Integers

Dense = Callable[[Array], Array]
NEAR, SLOW = 1e-13, 1e-12  # m, m/s: how far a margin may pass 0
HELD_BY = 1e-11  # share of its strength below which a held point is no longer pressed on
SAMPLES = 8  # of a step
_HALVINGS = 30


class Kind(IntEnum):
    """What happens to a point."""

    TOUCH = 0  # a free one reaches the wall, or the end of its unloading line
    PEAK = 1  # the crush has reached its greatest value
    OVER = 2  # reloading has reached the virgin curve
    LEAVE = 3  # unloading has reached its end
    SLIDE = 4  # the sliding has come to rest
    SLIP = 5  # stuck points begin to slide
    RELEASE = 6  # a held point is no longer pressed on
    YIELD = 7  # a held point is pressed on with more than its law resists


class Event(NamedTuple):
    """An event, the point it happens to, -1 for all stuck ones, and when [s]."""

    kind: Kind
    point: int
    t: float


class Watch(NamedTuple):
    """Kinds and points of the margins of a segment, in their order; margins of `grazing` first rows have minima."""

    kinds: Integers
    points: Integers
    grazing: int


def watch(dynamics: Dynamics) -> Watch:
    """What can happen in the modes of a segment."""
    crush, p = dynamics.modes.crush, dynamics.pressed
    sliding = p.points[p.friction != 0.0]
    stuck = np.full(min(p.stuck.size, 1), -1)
    free, loading, line, held = (np.flatnonzero(crush == mode) for mode in (FREE, LOADING, LINE, HELD))
    groups = (free, loading, line, line, sliding, stuck, held, held)
    kinds = np.repeat(np.arange(len(Kind)), [len(group) for group in groups])
    return Watch(kinds, np.concatenate(groups), len(free))


def margins(dynamics: Dynamics, y: Array) -> Array:
    """Of the states y (11, n), in the order of `watch`: shape (margins, n)."""
    points, modes, p = dynamics.points, dynamics.modes, dynamics.pressed
    at = kinematics(points.along, points.across, y)
    most, touch = modes.max_crush[:, None], dynamics.touch[:, None]
    free, loading, line = (modes.crush == mode for mode in (FREE, LOADING, LINE))
    sliding = p.points[p.friction != 0.0]
    parts = [
        (touch - at.crush)[free] + NEAR,
        at.rate[loading] + SLOW,
        (most - at.crush)[line] + NEAR,
        (at.crush - touch)[line] + NEAR,
        modes.sliding[sliding, None] * at.v_x[sliding] + SLOW,
    ]
    if p.stuck.size or p.held.size:
        parts += _constraint_margins(dynamics, y, at)
    return np.concatenate(parts)


def _constraint_margins(dynamics: Dynamics, y: Array, at: Kinematics) -> list[Array]:
    p, mu = dynamics.pressed, dynamics.mu
    normal, tangential = dynamics.forces(y, Kinematics(*(value[p.points] for value in at)))
    stuck = p.stuck
    limit, force, arm = mu * normal[stuck], tangential[stuck], at.y[p.points[stuck]]
    stick = (
        [[stick_margin(arm[:, k], limit[:, k], force[:, k]) for k in range(y.shape[1])]] if stuck.size else []
    )
    most = dynamics.modes.max_crush
    strength = virgin_force(dynamics.points, most)[p.points[p.held]]
    bare = normal[p.held]
    slack = HELD_BY * strength[:, None]
    scale = 1e-12 * (1.0 + np.abs(limit).max(initial=0.0))
    return [np.reshape(stick, (-1, y.shape[1])) + scale, bare - slack, strength[:, None] - bare + slack]


def first_event(dynamics: Dynamics, watched: Watch, span: tuple[float, float], dense: Dense) -> Event | None:
    """The first event on (t_0, t_1], or None."""
    times = np.linspace(*span, SAMPLES + 1)
    states = dense(times)
    values = margins(dynamics, states)
    times, values = _with_minima(dynamics, watched, times, states, values, dense)
    below = (values[:, 1:] < 0.0).any(axis=0)
    if not below.any():
        return None
    k = int(np.argmax(below)) + 1
    rows = np.flatnonzero(values[:, k] < 0.0)
    roots = [
        _root(dynamics, row, (times[k - 1], times[k]), values[row, k - 1], dense) for row in rows.tolist()
    ]
    first = int(np.argmin(roots))
    return Event(Kind(watched.kinds[rows[first]]), int(watched.points[rows[first]]), roots[first])


def _root(dynamics: Dynamics, row: int, span: tuple[float, float], start: float, dense: Dense) -> float:
    """Where a margin falls through 0; at once where it has never been above."""
    from scipy.optimize import brentq

    def value(t: float) -> float:
        return float(margins(dynamics, dense(np.array([t])))[row, 0])

    low, high = span
    if start < 0.0:
        width = high - low
        earlier = (low + width * 0.5**j for j in range(1, _HALVINGS))
        found = next((t for t in earlier if value(t) > 0.0), None)
        if found is None:
            return low
        low = found
    elif start == 0.0:
        return low
    return float(brentq(value, low, high, xtol=1e-16, rtol=1e-15))


def _with_minima(
    dynamics: Dynamics, watched: Watch, times: Array, states: Array, values: Array, dense: Dense
) -> tuple[Array, Array]:
    """The samples, and one more where a free point is nearest to the wall between two of them."""
    free = watched.points[: watched.grazing]
    if not free.size:
        return times, values
    points = dynamics.points
    rate = -kinematics(points.along[free], points.across[free], states).rate
    rows, columns = np.nonzero((rate[:, :-1] < 0.0) & (rate[:, 1:] > 0.0) & (values[: len(free), 1:] >= 0.0))
    share = rate[rows, columns] / (rate[rows, columns] - rate[rows, columns + 1])
    if not rows.size:
        return times, values
    extra = times[columns] + share * (times[columns + 1] - times[columns])
    times, order = np.unique(np.concatenate([times, extra]), return_index=True)
    return times, np.concatenate([values, margins(dynamics, dense(extra))], axis=1)[:, order]
