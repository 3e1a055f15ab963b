"""Band of a force over uncertain inputs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from postprocess.units import measure

PERCENTILES = (5, 50, 95)
"""Percentiles of all bands, of which names and texts follow."""

MOST_NAMED, LEAST_NAMED = 2, 0.05
"""Number of inputs that the sentence names, and their least fraction of the variance."""

CONFIDENCE = 0.95
"""Probability of the intervals of fractions due to the number of samples."""


def binomial_interval(successes: np.ndarray, trials: int) -> np.ndarray:
    """Return the interval of Clopper and Pearson of fractions, shape (2, n)."""
    from scipy.special import betaincinv

    tail, successes = 0.5 * (1.0 - CONFIDENCE), np.asarray(successes, dtype=float)
    low = betaincinv(successes, np.maximum(trials - successes + 1.0, 0.5), tail)
    high = betaincinv(successes + 1.0, np.maximum(trials - successes, 0.5), 1.0 - tail)
    return np.array([np.where(successes == 0.0, 0.0, low), np.where(successes == trials, 1.0, high)])


def percentile_names() -> tuple[str, ...]:
    """Return the keys of percentiles in results."""
    return tuple(f"percentile_{p:g}" for p in PERCENTILES)


def central_part() -> str:
    """Return the part of samples between the outer percentiles, in words."""
    return f"{PERCENTILES[-1] - PERCENTILES[0]:g} %"


@dataclass(frozen=True)
class ForceBand:
    """Distribution of the force of rigid vehicles with varied inputs.

    Attributes
    ----------
    percentiles : tuple of float
        PERCENTILES of the force [N], empty where there are none.
    samples : int
        Number of vehicles.
    variance_fractions : dict of str to float
        Fraction of the variance due to each input by linear regression, by key, largest first [-].
    ranges : dict of str to tuple
        Lower and upper end [SI] and origin of the range of each key.
    outcomes : dict of str to float
        Fraction of the vehicles in space by outcome [-], empty in the plane.
    fixed : tuple of str
        Keys that are not varied, as the scene's values are outside their ranges.
    refusal : str
        Reason why there is no band, or "".
    unsolved : int
        Number of further vehicles, which have no solution.
    reason : str
        Reason why the first of them does not stand on its axles, or "".
    forces : tuple of float
        Forces of the vehicles [N].
    """

    percentiles: tuple[float, ...] = ()
    samples: int = 0
    variance_fractions: Mapping[str, float] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float, str]] = field(default_factory=dict)
    outcomes: Mapping[str, float] = field(default_factory=dict)
    fixed: tuple[str, ...] = ()
    refusal: str = ""
    unsolved: int = 0
    reason: str = ""
    forces: tuple[float, ...] = field(default=(), repr=False)

    @property
    def interval(self) -> str:
        """Limits of the central part in words, empty without a band."""
        if not self.percentiles:
            return ""
        lower, _, upper = self.percentiles
        form = ".0f" if lower >= 1e5 else ".3g"
        ends = measure(lower, "N", form, named=False), measure(upper, "N", form)
        return f"{central_part()} of such impacts: {ends[0]} to {ends[1]}"

    @property
    def sentence(self) -> str:
        """Origin of the band, and the inputs that change the force most."""
        if not self.percentiles:
            return f"Without a band of the force: {self.refusal}." if self.refusal else ""
        assumed = sum("assumed" in origin for *_, origin in self.ranges.values())
        largest = [
            f"`{key}` ({100.0 * fraction:.0f} %)"
            for key, fraction in list(self.variance_fractions.items())[:MOST_NAMED]
            if fraction > LEAST_NAMED
        ]
        parts = [
            f"Band of {self.samples} rigid vehicles over {len(self.ranges)} inputs, {assumed} with assumed ranges",
            self._outcomes,
            f"largest parts of the variance: {', '.join(largest)}" if largest else "",
            f"not varied, since outside the range: {', '.join(f'`{key}`' for key in self.fixed)}"
            if self.fixed
            else "",
            f"{self.unsolved} further vehicles omitted, which have no solution" if self.unsolved else "",
            f"the first of them: {self.reason}" if self.reason else "",
        ]
        return f"{'; '.join(filter(None, parts))}."

    @property
    def _outcomes(self) -> str:
        """Fractions of the outcomes in words, with bounds by their number."""
        if not self.outcomes:
            return ""
        one_sided = 1e3 * (1.0 - CONFIDENCE) ** (1.0 / self.samples)  # Clopper and Pearson, none or all
        words = {0.0: f"at most {0.1 * math.ceil(1e3 - one_sided):.1f} %"}
        words[1.0] = f"at least {0.1 * math.floor(one_sided):.1f} %"
        parts = []
        for name, fraction in self.outcomes.items():
            if fraction not in words:
                ends = 100.0 * binomial_interval(np.array([fraction * self.samples]), self.samples)[:, 0]
                words[fraction] = (
                    f"{100.0 * fraction:.0f} % ({math.floor(ends[0])} to {math.ceil(ends[1])} %)"
                )
            parts.append(f"{words[fraction]} {name}")
        return f"{', '.join(parts)} (95 % confidence by their number)"

    def numbers(self) -> dict[str, object]:
        """Return the part `force_band` of results, SI."""
        further = {name: value for name, value in vars(self).items() if name not in ("percentiles", "forces")}
        return dict(zip(percentile_names(), self.percentiles, strict=False)) | further
