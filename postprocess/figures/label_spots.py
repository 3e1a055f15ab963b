"""Places for labels in a picture, in pixels: what each covers and crosses."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STRIDE = 3.0
"""Pixels between points by which lines are sampled."""

COVERED, CROSSED, MET = 4.0, 1.0, 5.0
"""Cost of each point of a line that a label covers, or that its leader crosses; of a leader met, in such crossings."""


@dataclass(frozen=True)
class Box:
    """A rectangle in pixels."""

    left: float
    low: float
    right: float
    high: float

    def overlaps(self, other: "Box") -> bool:
        """Whether the two share any of their inside."""
        return (
            self.left < other.right
            and other.left < self.right
            and self.low < other.high
            and other.low < self.high
        )

    def inside(self, other: "Box") -> bool:
        """Whether all of it lies in the other."""
        across = other.left <= self.left and self.right <= other.right
        return across and other.low <= self.low and self.high <= other.high

    def covered(self, points: Floats) -> int:
        """How many of the points, shape (n, 2), lie in it."""
        x, y = points.T
        return int(np.count_nonzero((x > self.left) & (x < self.right) & (y > self.low) & (y < self.high)))


@dataclass(frozen=True)
class Spot:
    """A place for a label, in pixels: its box, its leader, shape (n, 2), the point it belongs to; and what it costs."""

    box: Box
    leader: Floats
    at: Floats
    cost: float


@dataclass(frozen=True)
class Ground:
    """What labels must keep off, in pixels: all must lie in `frame`; `taken` is taken, points are costly."""

    frame: Box
    points: Floats
    taken: Sequence[Box]

    def cost(self, spot: Spot, others: Sequence[Spot], bound: float) -> float:
        """Cost of a label there, beside the others; infinite where it cannot be, or dearer than the bound."""
        boxes = [*self.taken, *(other.box for other in others)]
        cost = spot.cost + COVERED * spot.box.covered(self.points)
        if cost >= bound or not spot.box.inside(self.frame) or any(spot.box.overlaps(box) for box in boxes):
            return math.inf
        if any(spot.box.covered(other.leader) for other in others) or any(
            b.covered(spot.leader) for b in boxes
        ):
            return math.inf
        met = sum(_meet(spot.leader, other.leader) for other in others)
        return cost + CROSSED * (_near(spot.leader[2:], self.points) + MET * met)


def sampled(line: Floats) -> Floats:
    """Points every few pixels along a line, shape (n, 2), its own points included."""
    pieces = []
    for start, end in pairwise(line):
        count = max(2, math.ceil(math.dist(start, end) / STRIDE))
        pieces.append(start + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (end - start))
    return np.concatenate([*pieces, line[-1:]])


def leader_to(box: Box, at: Floats) -> Floats:
    """Points from the given one towards the middle of the box, up to its edge, shape (n, 2)."""
    middle = np.array([0.5 * (box.left + box.right), 0.5 * (box.low + box.high)])
    points = sampled(np.array([at, middle]))
    x, y = points.T
    return points[(x < box.left) | (x > box.right) | (y < box.low) | (y > box.high)]


def _meet(one: Floats, other: Floats) -> bool:
    """Whether two rows of points come as near as their stride."""
    if not (len(one) and len(other)):
        return False
    return bool(np.abs(one[:, None] - other).max(axis=2).min() < STRIDE)


def _near(leader: Floats, points: Floats) -> int:
    """How many points of the leader lie on a line."""
    if not (len(leader) and len(points)):
        return 0
    return int(np.count_nonzero(np.abs(leader[:, None] - points).max(axis=2).min(axis=1) < 2.0))
