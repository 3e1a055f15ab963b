"""All inputs at once: how the quantities of both strikes spread, and which input that comes from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError, Verbatim
from tailslap.studies.strike.impacts import measured
from tailslap.studies.strike.quantities import Array
from tailslap.studies.uncertainty.indices import sobol_indices
from tailslap.studies.uncertainty.ranges import Range
from tailslap.studies.uncertainty.sampling import SEED, points, tables
from tailslap.studies.uncertainty.spread import MIN_ROWS, PERCENTILES, VariedInput, varied_inputs


@dataclass(frozen=True)
class Band:
    """How a quantity spreads [SI]: percentiles are those of PERCENTILES; values: all known ones."""

    percentiles: tuple[float, ...]
    mean: float
    standard_deviation: float
    values: Array

    def share_below(self, value: float) -> float:
        """Share of the impacts that stay below a value."""
        return float(np.mean(self.values < value))


@dataclass(frozen=True)
class Bands:
    """All of it.

    Attributes
    ----------
    ranges : tuple of Range
        The inputs, each even over its range, independent of the others.
    inputs : dict of ndarray, shape (n,)
        The combinations of the distribution, by key.
    columns : dict of ndarray, shape (n,)
        What was measured of them.
    sources : dict of tuple of VariedInput
        By column, where its variance comes from; columns without variance are missing.
    computed : int
        Impacts in all, the mixtures for the indices included.
    """

    ranges: tuple[Range, ...]
    inputs: Mapping[str, Array]
    columns: Mapping[str, Array]
    sources: Mapping[str, tuple[VariedInput, ...]]
    computed: int

    def band(self, name: str) -> Band:
        """Of a column."""
        return band_of(self.columns[name])

    def sources_of(self, name: str) -> list[VariedInput]:
        """Where the variance of a column comes from, the most first; nothing where it has none."""
        return sorted(self.sources.get(name, ()), key=lambda item: -item.total)

    @property
    def single(self) -> int:
        """How many of the distribution's impacts have no second strike."""
        return int(np.count_nonzero(np.isnan(self.columns["strike_2.impulse"])))


def band_of(values: Array) -> Band:
    """Of a sample, shape (n,), without what is NaN."""
    known = values[np.isfinite(values)]
    ends = tuple(float(x) for x in np.percentile(known, PERCENTILES))
    return Band(ends, float(known.mean()), float(known.std(ddof=1)), known)


def find_bands(
    plan: ImpactCase, ranges: tuple[Range, ...], at_least: int, progress: Callable[[float], None]
) -> Bands:
    """Draw and solve; at least so many impacts. Raises InputError where most of them have no second strike."""
    rows = 1 << max(5, int(np.ceil(np.log2(at_least / (len(ranges) + 2)))))
    a, b = points(ranges, rows)
    keys = [item.key for item in ranges]
    mixed = np.concatenate(list(tables(a, b)), axis=1)
    found = measured(plan, dict(zip(keys, mixed, strict=True)), progress)
    parts = {name: values.reshape(-1, rows) for name, values in found.items()}
    _demand_second(parts["strike_2.impulse"])
    sources = {name: _sources(ranges, part) for name, part in parts.items()}
    both = np.hstack([a, b])
    return Bands(
        ranges,
        dict(zip(keys, both, strict=True)),
        {name: part[:2].ravel() for name, part in parts.items()},
        {name: inputs for name, inputs in sources.items() if inputs},
        mixed.shape[1],
    )


def _demand_second(impulse: Array) -> None:
    if np.count_nonzero(np.isfinite(impulse).all(axis=0)) < MIN_ROWS:
        words = Verbatim("these ranges")
        raise InputError(
            "--range", words, "hardly any of these impacts has a second strike; allowed are others"
        )


def _sources(ranges: tuple[Range, ...], part: Array) -> tuple[VariedInput, ...]:
    """Rows A, B, and A with each input from B, shape (inputs + 2, rows); rows with NaN are left out."""
    whole = part[:, np.isfinite(part).all(axis=0)]
    if not whole[:2].std() > 1e-9 * abs(whole[:2].mean()):
        return ()
    return varied_inputs(ranges, sobol_indices(whole[0], whole[1], whole[2:], SEED))


def conditional(plan: ImpactCase, bands: Bands, known: Mapping[str, float]) -> Bands:
    """The same combinations with some inputs known: at these values [SI]."""
    rows = bands.columns["strike_1.impulse"].size
    inputs = {**bands.inputs, **{key: np.full(rows, value) for key, value in known.items()}}
    free = tuple(item for item in bands.ranges if item.key not in known)
    return replace(
        bands, ranges=free, inputs=inputs, columns=measured(plan, inputs), sources={}, computed=rows
    )
