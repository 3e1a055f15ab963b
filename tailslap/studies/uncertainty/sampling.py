"""Combinations of inputs for Sobol indices, and the peak force of each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tailslap.progress import progress_bar
from tailslap.scene.schema import Scene
from tailslap.studies.uncertainty.model import Array, peak_forces
from tailslap.studies.uncertainty.ranges import Range

SEED = 307
"""Of every random number of the study: the same call gives the same numbers."""


@dataclass(frozen=True)
class Samples:
    """Two tables of combinations that share no row, and their mixtures (Saltelli 2010).

    a, b: values of the inputs, shape (inputs, rows) [SI]; force_a, force_b: peak forces, shape (rows,) [N];
    force_ab: of table a with the values of one input taken from b, shape (inputs, rows). NaN: refused.
    """

    ranges: tuple[Range, ...]
    a: Array
    b: Array
    force_a: Array
    force_b: Array
    force_ab: Array

    @property
    def combinations(self) -> int:
        """How many were computed."""
        return self.force_a.size + self.force_b.size + self.force_ab.size

    @property
    def refused(self) -> int:
        """How many of these the theory refuses."""
        return int(sum(np.count_nonzero(np.isnan(f)) for f in (self.force_a, self.force_b, self.force_ab)))

    @property
    def known(self) -> Array:
        """The forces of both tables that are not refused [N]: the sample of the distribution."""
        forces = np.concatenate([self.force_a, self.force_b])
        return forces[np.isfinite(forces)]

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Which rows have no refused combination, shape (rows,)."""
        return np.asarray(np.isfinite([self.force_a, self.force_b, *self.force_ab]).all(axis=0))

    @property
    def rows_left_out(self) -> int:
        """How many rows have a refused combination."""
        return int(np.count_nonzero(~self.complete))


def draw(scene: Scene, ranges: tuple[Range, ...], at_least: int) -> Samples:
    """Sobol points, scrambled by `SEED`, as many as give `at_least` combinations: a power of two of rows."""
    rows = 1 << max(1, int(np.ceil(np.log2(at_least / (len(ranges) + 2)))))
    a, b = points(ranges, rows)
    keys = [item.key for item in ranges]
    with progress_bar("combinations") as progress:
        forces = [
            _forces(scene, keys, table, progress, done / (len(a) + 2))
            for done, table in enumerate(tables(a, b))
        ]
    return Samples(ranges, a, b, forces[0], forces[1], np.array(forces[2:]))


def tables(a: Array, b: Array) -> Iterator[Array]:
    """Both tables, and for each input the first one with that input's values from the second."""
    yield from (a, b)
    for row in range(len(a)):
        mixed = a.copy()
        mixed[row] = b[row]
        yield mixed


def _forces(
    scene: Scene, keys: list[str], table: Array, progress: Callable[[float], None], share: float
) -> Array:
    progress(share)
    return peak_forces(scene, dict(zip(keys, table, strict=True)))


def points(ranges: tuple[Range, ...], rows: int) -> tuple[Array, Array]:
    """Both tables of inputs, each of shape (inputs, rows): halves of one sequence in twice the dimensions."""
    from scipy.stats import qmc

    random = np.random.default_rng(SEED)
    drawn = qmc.Sobol(2 * len(ranges), scramble=True, bits=64, seed=random).random(rows).T
    lower, upper = (np.array([[getattr(item, end)] for item in ranges]) for end in ("lower", "upper"))
    a, b = (lower + (upper - lower) * half for half in np.split(drawn, 2))
    return a, b
