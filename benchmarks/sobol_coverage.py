"""Coverage of the 95 % intervals of Sobol indices.

    .venv/bin/python benchmarks/sobol_coverage.py [--inputs N...] [--rows N...] [--repeats N] [--scene NAME]

Functions have exact indices, with many randomisations of the points. For each function, number of inputs and of rows:
the fraction of first-order and of total indices that lie in their interval, its mean width, and how often the indices
were refused. With a scene of a whole impact: the fraction of the intervals of COUNTS samples that overlap those of
60 000, over all outputs and the repeats, and the lowest of a repeat; the first repeat has the points of the study.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import command_line
import numpy as np

from tailslap.campaign import planar_ranges, sampling
from tailslap.campaign.input_ranges import Range
from tailslap.campaign.sampling import Array
from tailslap.case import case_of
from tailslap.scene.read import read_scene
from tailslap.studies.uncertainty import uncertainty_study

INPUTS, ROWS, REPEATS = (2, 5, 11, 21), (32, 64, 256, 1024, 4096), 40
MOST = 400_000
"""Inputs of the largest set of tables."""
ROUNDING = 1e-9
"""Rounding of exact zeros and ones."""


COUNTS, REFERENCE = (288, 1000, 2000, 4000, 8000), 60_000
"""Numbers of samples of a scene, and of the intervals that they are compared with."""


class Function(NamedTuple):
    """A function of inputs in (0, 1) with exact indices.

    Inputs have the shape (inputs, n), indices (inputs,).
    """

    name: str
    of: Callable[[Array], Array]
    first: Array
    total: Array


def linear(name: str, weights: Array) -> Function:
    """Return the weighted sum, whose indices are squared weights."""
    share = weights**2 / np.sum(weights**2)
    return Function(name, lambda x: weights @ x, share, share)


def ishigami(inputs: int) -> Function:
    """Return Ishigami's function of three inputs, the others without effect.

    sin x + 7 sin^2 y + 0.1 z^4 sin x.
    """

    def of(x: Array) -> Array:
        a, b, c = math.pi * (2.0 * x[:3] - 1.0)
        return np.asarray(np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a))

    alone = np.array([(1.0 + 0.1 * math.pi**4 / 5.0) ** 2 / 2.0, 49.0 / 8.0, 0.0])
    both = 0.01 * math.pi**8 * 8.0 / 225.0
    parts = np.array([alone, alone + np.array([both, 0.0, both])]) / (alone.sum() + both)
    first, total = np.pad(parts, ((0, 0), (0, inputs - 3)))
    return Function("Ishigami", of, first, total)


def product(inputs: int) -> Function:
    """Return the function of Sobol.

    The product of (|4 x - 2| + a)/(1 + a) with a = i²/2.
    """
    a = 0.5 * np.arange(inputs)[:, None] ** 2
    part = (1.0 / 3.0 / (1.0 + a) ** 2)[:, 0]
    variance = np.prod(1.0 + part) - 1.0
    total = part / (1.0 + part) * (variance + 1.0) / variance
    of = lambda x: np.prod((np.abs(4.0 * x - 2.0) + a) / (1.0 + a), axis=0)  # noqa: E731
    return Function("product", of, part / variance, total)


def indicator(name: str, inputs: int, fraction: float) -> Function:
    """Return 1 where the largest input exceeds a limit.

    fraction: of the cases in which it does.
    """
    limit = (1.0 - fraction) ** (1.0 / inputs)
    rest, variance = limit ** (inputs - 1), fraction * (1.0 - fraction)
    total = np.full(inputs, rest * limit * (1.0 - limit) / variance)
    return Function(name, lambda x: np.where(x.max(axis=0) > limit, 1.0, 0.0), rest * total, total)


def jumps(inputs: int, fraction: float) -> Function:
    """Return a sum that jumps by 10 where an input is large.

    fraction: of each input that is large.
    """
    share = np.full(inputs, 1.0 / inputs)
    return Function("jumps", lambda x: (x + 10.0 * (x > 1.0 - fraction)).sum(axis=0), share, share)


def functions(inputs: int) -> list[Function]:
    """Return the test functions of this number of inputs."""
    unequal = 1.0 / np.arange(1.0, inputs + 1.0)
    unequal[2::3] = 0.0
    simple = [linear("linear", np.ones(inputs)), linear("linear 1/i", unequal)]
    simple += [ishigami(inputs)] if inputs >= 3 else []
    simple += [jumps(inputs, 0.03)]
    return [*simple, product(inputs), indicator("1 of 2", inputs, 0.5), indicator("1 of 10", inputs, 0.1)]


def coverage(function: Function, rows: int, repeats: int, first_seed: int = 1) -> dict[str, Any]:
    """Return covered fractions, mean widths and the fraction of refusals."""
    inputs = function.first.size
    ranges = tuple(Range(f"x{i}", 0.0, 1.0, "", None, "") for i in range(inputs))
    exact, seed = np.array([function.first, function.total]), sampling.SEED
    covered, widths = list[Array](), list[Array]()
    try:
        for sampling.SEED in range(first_seed, first_seed + repeats):
            of = lambda values: {"": function.of(np.array([*values.values()]))}  # noqa: E731
            table = sampling.sampled(ranges, rows * (inputs + 2), of)[1][""]
            index_rows, refusal = sampling.index_rows(ranges, table)
            if refusal:
                continue
            kinds = ("first_order_interval", "total_interval")
            low, high = np.moveaxis(np.array([[row[kind] for row in index_rows] for kind in kinds]), -1, 0)
            covered.append(((low - ROUNDING <= exact) & (exact <= high + ROUNDING)).mean(axis=1))
            widths.append((high - low).mean(axis=1))
    finally:
        sampling.SEED = seed
    nothing = [np.full(2, math.nan)]
    return {
        "covered": np.mean(covered or nothing, axis=0),
        "width": np.mean(widths or nothing, axis=0),
        "refused": 1.0 - len(covered) / repeats,
    }


def intervals(case: Any, ranges: tuple[Range, ...], count: int, seed: int) -> dict[str, Array]:
    """Return intervals by output, shape (2 kinds, inputs, 2 ends)."""
    own_seed = sampling.SEED
    sampling.SEED = seed
    try:
        _, tables = sampling.sampled(ranges, count, lambda values: uncertainty_study.solved(case, values))
    finally:
        sampling.SEED = own_seed
    indexed, _ = sampling.rows_and_refusals(ranges, tables)
    kinds = ("first_order_interval", "total_interval")
    return {name: np.array([[row[kind] for row in rows] for kind in kinds]) for name, rows in indexed.items()}


def overlaps(name: str, repeats: int) -> None:
    """Print how many intervals of a scene overlap those of many samples."""
    case = case_of(*read_scene(name))
    ranges = planar_ranges.impact_ranges(case)  # type: ignore[arg-type]
    reference = intervals(case, ranges, REFERENCE, sampling.SEED)
    print(
        f"{name}, {len(ranges)} inputs, {len(reference)} outputs: intervals that overlap those of {REFERENCE}"
    )
    for count in COUNTS:
        fractions = []
        for repeat in range(repeats):
            computed = intervals(case, ranges, count, sampling.SEED + repeat)
            pairs = [(computed[of], reference[of]) for of in reference if len(computed.get(of, ()))]
            meets = [
                np.maximum(x[..., 0], y[..., 0]) <= np.minimum(x[..., 1], y[..., 1])
                for x, y in pairs
                if y.size
            ]
            fractions.append(np.mean(meets, axis=(0, 2)) if meets else np.full(2, math.nan))
        (first, total), (least, lowest) = np.mean(fractions, axis=0), np.min(fractions, axis=0)
        print(
            f"{count:6} samples: first-order {first:.1%}, total {total:.1%}; lowest {least:.1%}, {lowest:.1%}"
        )


def main() -> None:
    """Print the table."""
    options = command_line.options(__doc__, inputs=INPUTS, rows=ROWS, repeats=REPEATS, scene=None)
    if options.scene:
        for name in options.scene:
            overlaps(name, options.repeats)
        return
    print("inputs   rows  function    covered: first  total   width: first  total   refused")
    everything = []
    for inputs in options.inputs:
        most = MOST if options.rows == ROWS else math.inf
        for rows in [rows for rows in options.rows if rows * inputs * (inputs + 2) <= most]:
            for function in functions(inputs):
                covered = coverage(function, rows, options.repeats)
                (first, total), (wide, widest) = covered["covered"], covered["width"]
                everything.append((first, total))
                fractions = f"{first:15.1%} {total:6.1%} {wide:14.4f} {widest:6.4f} {covered['refused']:9.1%}"
                print(f"{inputs:6} {rows:6}  {function.name:10} {fractions}")
    first, total = np.nanmean(everything, axis=0)
    lowest = np.nanmin(everything)
    print(f"all: first-order {first:.1%}, total {total:.1%}; lowest of a row {lowest:.1%}")


if __name__ == "__main__":
    main()
