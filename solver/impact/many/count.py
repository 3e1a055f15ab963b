"""The first two strikes of many impacts, counted from step to step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from solver.elementary import Array
from solver.impact.many.leapfrog import Pushed
from solver.impact.strike import is_over


class Strikes(NamedTuple):
    """What has been counted: (2, n) by strike, (4, n) by corner."""

    corner: Array
    start: Array
    end: Array
    peak: Array
    impulse: Array
    slot: Array  # of each corner's latest strike; -1: none yet
    first: Array  # when its latest strike began
    last: Array  # when it was last pressed on
    number: Array
    raw: Array


def no_strikes(n: int) -> Strikes:
    """Before the first step."""
    nothing, nowhere, zero = np.zeros((2, n)), np.full((4, n), -1.0), np.zeros(n)
    return Strikes(nothing - 1.0, nothing, nothing, nothing, nothing, nowhere, nowhere, nowhere, zero, zero)


def _copies(strikes: Strikes) -> Strikes:
    return Strikes(*(value.copy() for value in strikes))


def counted(strikes: Strikes, t: Array, h: Array, before: Array, p: Pushed) -> Strikes:
    """The strikes after a step."""
    corner, start, end, peak, impulse, slot, first, last, number, raw = _copies(strikes)
    for i in range(4):
        pressed = (before[i] > 0.0) | (p.normal[i] > 0.0)
        if not pressed.any():
            continue
        new = pressed & (h > 0.0) & ((slot[i] < 0.0) | is_over(first[i], last[i], t - h))
        slot[i], first[i] = np.where(new, number, slot[i]), np.where(new, t - h, first[i])
        number += new
        last[i] = np.where(pressed & (h > 0.0), t, last[i])
        for k in range(2):
            mine = pressed & (slot[i] == k)
            corner[k], start[k] = np.where(new & mine, i, corner[k]), np.where(new & mine, t - h, start[k])
            end[k] = np.where(mine & (h > 0.0), t, end[k])
            peak[k] = np.where(mine, np.maximum(peak[k], p.normal[i]), peak[k])
            impulse[k] += np.where(mine, 0.5 * h * (before[i] + p.normal[i]), 0.0)
    raw = np.maximum(raw, p.normal.sum(axis=0))
    return Strikes(corner, start, end, peak, impulse, slot, first, last, number, raw)
