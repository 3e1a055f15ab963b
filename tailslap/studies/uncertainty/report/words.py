"""The study in words: what was computed, and what it means."""

from __future__ import annotations

import math

import numpy as np

from tailslap.studies.uncertainty.indices import RESAMPLES
from tailslap.studies.uncertainty.ranges import Range
from tailslap.studies.uncertainty.sampling import SEED
from tailslap.studies.uncertainty.spread import Spread


def order(spread: Spread) -> list[int]:
    """Numbers of the inputs, the one with the largest total index first."""
    return [int(i) for i in np.argsort(-spread.indices.total, kind="stable")]


def range_words(item: Range) -> str:
    """The range, angles in degrees."""
    factor, unit = _unit(item)
    return f"{item.lower * factor:.5g} to {item.upper * factor:.5g} {unit}".strip()


def value_words(item: Range) -> str:
    """The scene's own value, angles in degrees."""
    factor, unit = _unit(item)
    return "–" if item.given is None else f"{item.given * factor:.5g} {unit}".strip()


def headline(spread: Spread) -> str:
    """The result in three sentences, or four."""
    found, samples = spread.distribution, spread.samples
    low, _, high = (force / 1e3 for force in found.percentiles)
    first = order(spread)[0]
    words = (
        f"Mean {found.mean / 1e3:.0f} kN, standard deviation {found.standard_deviation / 1e3:.0f} kN; nine in ten "
        f"combinations lie between {low:.0f} and {high:.0f} kN. The scene's own values give "
        f"{spread.plan.force.peak_force / 1e3:.0f} kN, more than {100.0 * spread.share_below:.0f} % of them. The "
        f"largest part of the variance comes from {samples.ranges[first].key}, with an index of "
        f"{spread.indices.first[first]:.2f}."
    )
    refused = (
        f" The theory refuses {_refused_share(spread)} of the combinations, which are not in these numbers."
    )
    return words + (refused if samples.refused else "")


def statements(spread: Spread) -> tuple[str, ...]:
    """What a reader must know beside the numbers."""
    rows, combinations = _grouped(spread.samples.force_a.size), _grouped(spread.samples.combinations)
    made = (
        f"Each input varies evenly over its range, and independently of the others. {rows} rows of Sobol points, "
        f"scrambled with the seed {SEED}, give {combinations} combinations; each is solved exactly by Stages 1 to 3. "
        "The same call gives the same numbers.",
        refusals(spread),
        f"Held at the scene's value: {', '.join(spread.held)}; --range varies these too."
        if spread.held
        else "",
        "An index is the share of the variance that comes from an input: alone (first order), and with its "
        f"interactions (total). The 95 % intervals are a bootstrap's, of {RESAMPLES} resamples, and err on the wide "
        "side.",
        "The duration of the strike is an input of the method, which does not predict it: the peak force is that "
        "of a triangular pulse of this duration.",
    )
    return tuple(sentence for sentence in made if sentence)


def refusals(spread: Spread) -> str:
    """How many combinations the theory refuses, and what became of them."""
    samples = spread.samples
    if not samples.refused:
        return "The theory refuses none of the combinations."
    return (
        f"The theory refuses {_grouped(samples.refused)} of {_grouped(samples.combinations)} combinations "
        f"({_refused_share(spread)}): they have no force, and the distribution is that of the others. "
        f"{_grouped(samples.rows_left_out)} of {_grouped(samples.force_a.size)} rows have one and are left out of the "
        "indices, which are then approximate, for the inputs of the rest are no longer independent. "
        f"The first: {spread.first_refusal}."
    )


def _refused_share(spread: Spread) -> str:
    return f"{100.0 * spread.samples.refused / spread.samples.combinations:.2g} %"


def _grouped(number: int) -> str:
    """A whole number with its thousands set apart."""
    return f"{number:,}".replace(",", " ")


def _unit(item: Range) -> tuple[float, str]:
    return (180.0 / math.pi, "deg") if item.unit == "rad" else (1.0, item.unit)
