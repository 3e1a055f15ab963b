"""The strikes of a rigid impact: its pieces measured by quadrature."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from solver.elementary import Array
from solver.impact.contact import CORNERS
from solver.impact.dynamics import Forces, Kinematics
from solver.impact.integrate import Piece, Span
from solver.impact.strike import Interval, Strike, joined

_NODES = 8  # Gauss points of a piece


def intervals(spans: Sequence[Span]) -> list[Interval]:
    """When each corner's points were pressed on, joined, in order of time."""
    parts = []
    for span in spans:
        if span.end > span.start:
            parts += [Interval(corner, span.start, span.end) for corner in span.dynamics.corners]
    return joined(parts)


class _Sums(NamedTuple):
    """Of one piece, by corner: integrals over time, shape (4, 6), and peak forces, shape (4,)."""

    integrals: Array
    peaks: Array


def strikes_of_motion(spans: Sequence[Span]) -> tuple[Strike, ...]:
    """The strikes of a motion."""
    pieces = [piece for span in spans for piece in span.pieces if piece.dynamics.pressed.points.size]
    starts = np.array([piece.start for piece in pieces])
    sums = [_sums(piece) for piece in pieces]
    found = []
    for interval in intervals(spans):
        first, last = np.searchsorted(starts, (interval.start - 1e-15, interval.end - 1e-15))
        found.append(_strike(interval, pieces[first:last], sums[first:last]))
    return tuple(found)


def _strike(interval: Interval, pieces: list[Piece], sums: list[_Sums]) -> Strike:
    corner, start, end = interval
    total = np.sum([part.integrals[corner] for part in sums], axis=0) if sums else np.zeros(6)
    peaks = [part.peaks[corner] for part in sums]
    peak = _refined(corner, pieces, int(np.argmax(peaks)), max(peaks)) if peaks else 0.0
    impulse = float(total[0])
    station, position = (total[2:4] / impulse).tolist() if impulse > 0.0 else (np.nan, np.nan)
    name = CORNERS[corner]
    return Strike(name, start, end, peak, impulse, float(total[1]), station, position, *total[4:].tolist())


def _by_corner(piece: Piece, values: Array) -> Array:
    """Sums over the touching points of each corner, shape (4, n)."""
    out = np.zeros((4, values.shape[1]))
    np.add.at(out, piece.dynamics.points.corner[piece.dynamics.pressed.points], values)
    return out


def _forces(piece: Piece, t: Array) -> tuple[Array, Kinematics, Forces]:
    y = piece.dense(t)
    at = piece.dynamics.kinematics(y)
    return y, at, piece.dynamics.recorded_forces(y, at)


@cache
def _gauss() -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    return nodes, weights


def _sums(piece: Piece) -> _Sums:
    nodes, weights = _gauss()
    width = piece.end - piece.start
    t = np.concatenate([piece.start + width * (1.0 + nodes) / 2.0, [piece.start, piece.end]])
    y, at, (normal, tangential) = _forces(piece, t)
    station = piece.dynamics.points.station[piece.dynamics.pressed.points, None]
    work = normal * at.rate, tangential * at.v_x
    integrands = (normal, tangential, normal * station, normal * (y[0] + at.x), *work)
    by_corner = np.stack([_by_corner(piece, values) for values in integrands], axis=1)
    return _Sums(by_corner[..., :_NODES] @ weights * width / 2.0, by_corner[:, 0].max(axis=1))


def _refined(corner: int, pieces: list[Piece], k: int, sampled: float) -> float:
    """The greatest force of the piece with the highest sample and its neighbours."""
    from scipy.optimize import minimize_scalar

    def less(t: float, piece: Piece) -> float:
        _, _, forces = _forces(piece, np.array([t]))
        return -float(_by_corner(piece, forces.normal)[corner, 0])

    found = [sampled]
    for piece in pieces[max(k - 1, 0) : k + 2]:
        options = {"xatol": 1e-9 * (piece.end - piece.start)}
        span = piece.start, piece.end
        run = minimize_scalar(less, bounds=span, args=(piece,), method="bounded", options=options)
        found.append(-float(run.fun))
    return float(max(found))
