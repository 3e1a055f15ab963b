"""The one integral of Stage 2: the time at which an angle is reached, and the angle reached at a time.

Both in units of 1/omega_0: tau = omega_0 t = integral of omega_0/omega d(theta) from theta to theta_0.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from solver.closed_form import Path, slowness
from solver.elementary import Array
from solver.errors import RigidBodyError, holds
from solver.rules import GROWTH

COARSE, FINE = 12, 20  # Gauss points; the answer is the fine rule's, its distance to the coarse one the check
TOLERANCE = 1e-13  # on that distance, relative; the fine rule's own error is far below
BISECTIONS = 24
POINTS = 32  # of a panel of the clock
TAIL = 1e-14  # largest admissible last coefficients of a panel, relative
PANELS = 1024
CLOSE = 1e-14  # Newton's method takes its last step from here; the step squares the rest


def scaled_time(path: Path) -> Any:
    """tau at theta = 0; NaN where it cannot be had to TOLERANCE. Floats, or arrays of one shape."""
    fine, coarse = _panel(path, 0.0 * path.theta_0, path.theta_0)
    done = abs(fine - coarse) <= TOLERANCE * fine
    if holds(done):
        return fine
    arrays = Path(*(np.ravel(value) for value in path))
    tau = _bisected(arrays, np.ravel(fine)).reshape(np.shape(fine))
    return tau if tau.ndim else tau.item()


@cache
def _rules() -> tuple[Array, Array]:
    """Nodes of both rules in (0, 1), and a column of weights for each."""
    (x_f, w_f), (x_c, w_c) = (np.polynomial.legendre.leggauss(n) for n in (FINE, COARSE))
    weights = np.zeros((FINE + COARSE, 2))
    weights[:FINE, 0], weights[FINE:, 1] = w_f / 2.0, w_c / 2.0
    return (np.concatenate([x_f, x_c]) + 1.0) / 2.0, weights


def _panel(path: Path, lower: Any, upper: Any) -> tuple[Any, Any]:
    """The integral from lower to upper by both rules, without a loop over rows."""
    nodes, weights = _rules()
    if isinstance(lower, float):
        fine, coarse = (slowness(path, lower + (upper - lower) * nodes) @ weights).tolist()
        return fine * (upper - lower), coarse * (upper - lower)
    columns = Path(*(value[..., None] for value in path))
    sums = slowness(columns, lower[..., None] + (upper - lower)[..., None] * nodes) @ weights
    return sums[..., 0] * (upper - lower), sums[..., 1] * (upper - lower)


def _bisected(path: Path, scale: Array) -> Array:
    """The integral of each row, its panels halved until both rules agree; scale: a first estimate."""
    total, rows = np.zeros(scale.size), np.arange(scale.size)
    lower, upper = np.zeros(scale.size), path.theta_0
    for _ in range(BISECTIONS):
        fine, coarse = _panel(Path(*(value[rows] for value in path)), lower, upper)
        open_ = ~(abs(fine - coarse) <= TOLERANCE * np.maximum(fine, 0.1 * scale[rows]))
        total += np.bincount(rows[~open_], fine[~open_], scale.size)
        rows, lower, upper = rows[open_], lower[open_], upper[open_]
        if rows.size == 0:
            return total
        middle = 0.5 * (lower + upper)
        rows, lower, upper = np.tile(rows, 2), np.append(lower, middle), np.append(middle, upper)
    total[rows] = np.nan
    return total


class Clock(NamedTuple):
    """tau(theta) of one motion as Legendre series on equal panels, and its inverse."""

    path: Path
    edges: Array  # of the panels, ascending [rad]
    tau: Array  # at the edges, descending
    series: Array  # of tau within each panel, less its value at the upper edge; a column each

    def read(self, theta: Array) -> Array:
        """tau at the angles theta [rad]."""
        panel = np.clip(np.searchsorted(self.edges, theta, side="right") - 1, 0, self.edges.size - 2)
        lower, upper = self.edges[panel], self.edges[panel + 1]
        x = (2.0 * theta - lower - upper) / (upper - lower)
        series = np.polynomial.legendre.legval(x, self.series[:, panel], tensor=False)
        return self.tau[panel + 1] + np.asarray(series)

    def angle(self, tau: Array) -> Array:
        """The angles [rad] at the times tau, by Newton's method to rounding."""
        theta = np.interp(tau, self.tau[::-1], self.edges[::-1])
        for _ in range(50):
            late = self.read(theta) - tau
            theta = np.clip(theta + late / slowness(self.path, theta), self.edges[0], self.edges[-1])
            if np.all(abs(late) <= CLOSE * self.tau[0]):  # before the step just taken
                return theta
        raise RigidBodyError(GROWTH.key, f"{abs(self.path.mu):.10g}", GROWTH.why, GROWTH.allowed)


@cache
def _projection() -> tuple[Array, Array]:
    """POINTS nodes in (-1, 1), and the matrix that makes Legendre coefficients of values there."""
    x, w = np.polynomial.legendre.leggauss(POINTS)
    values = np.polynomial.legendre.legvander(x, POINTS - 1)
    return x, (np.arange(POINTS) + 0.5)[:, None] * (values * w[:, None]).T


def clock(path: Path, lowest: float) -> Clock:
    """The clock of one motion (floats) from theta_0 down to the angle lowest [rad].

    Doubles the panels until the last coefficients of each are rounding; raises RigidBodyError if none do.
    """
    (x, transform), panels = _projection(), 1
    while panels <= PANELS:
        edges = np.linspace(lowest, path.theta_0, panels + 1)
        half = (path.theta_0 - lowest) / (2.0 * panels)
        series = transform @ slowness(path, (edges[:-1] + half) + half * x[:, None])
        if np.max(abs(series[-2:])) <= TAIL * np.max(abs(series[0])):
            integral = half * np.polynomial.legendre.legint(-series, lbnd=1.0)
            across = 2.0 * half * series[0]
            return Clock(path, edges, np.append(np.cumsum(across[::-1])[::-1], 0.0), integral)
        panels *= 2
    raise RigidBodyError(GROWTH.key, f"{abs(path.mu):.10g}", GROWTH.why, GROWTH.allowed)
