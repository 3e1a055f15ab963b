"""Band of a force over uncertain inputs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from postprocess.units import force as force_text
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


def fraction_in_words(fraction: float, samples: int) -> str:
    """Return a fraction of samples with its interval.

    It is one-sided for none and all.
    """
    if fraction in (0.0, 1.0):
        one_sided = 1e3 * (1.0 - CONFIDENCE) ** (1.0 / samples)  # Clopper and Pearson
        none, every = math.ceil(1e3 - one_sided), math.floor(one_sided)
        return f"at least {0.1 * every:.1f} %" if fraction else f"at most {0.1 * none:.1f} %"
    ends = 100.0 * binomial_interval(np.array([fraction * samples]), samples)[:, 0]
    return f"{100.0 * fraction:.0f} % ({math.floor(ends[0])} to {math.ceil(ends[1])} %)"


def percentile_names() -> tuple[str, ...]:
    """Return the keys of percentiles in results."""
    return tuple(f"percentile_{p:g}" for p in PERCENTILES)


def central_part() -> str:
    """Return the part of samples between the outer percentiles, in words."""
    return f"{PERCENTILES[-1] - PERCENTILES[0]:g} %"


@dataclass(frozen=True)
class Calibration:
    """Published over predicted forces of a class of vehicles.

    Attributes
    ----------
    name : str
        Class of vehicles.
    rows, studies : int
        Numbers of published values, and of studies that published them.
    least, most : float
        Smallest and largest published value over its predicted median [-].
    factor : float or None
        Factor on the logarithms of the band of the inputs; None where the rows are too few.
    rows_held, studies_held : int or None
        Rows within the band that the other studies calibrate, and studies with all of their rows in it; None likewise.
    """

    name: str
    rows: int
    studies: int
    least: float
    most: float
    factor: float | None = None
    rows_held: int | None = None
    studies_held: int | None = None

    @property
    def sentence(self) -> str:
        """How the band was tested, in words."""
        if self.factor is None:
            ends = dict.fromkeys(f"{ratio:.1f}" for ratio in (self.least, self.most))
            ratios = f"{' to '.join(ends)} in {self.rows} row{'s' if self.rows > 1 else ''}"
            return (
                f"inputs alone, not calibrated; published over predicted {ratios} of {self.name} "
                "(`tailslap validate`)"
            )
        return (
            f"calibrated by {self.name} (`tailslap validate`): the logarithms of the band of the inputs times "
            f"{self.factor:.2f}; of studies left out one by one, {self.rows_held} of {self.rows} values and all values "
            f"of {self.studies_held} of {self.studies} studies lie in the band of the others"
        )


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
    decisive : tuple of str
        Inputs with the largest fractions of the variance, with their ranges, in words.
    speeds : tuple of str
        Lower and higher speed than that of the scene, empty where the scene has none.
    growth : float
        Force at the higher over that at the lower one, geometric mean of the same vehicles; 0 if unknown [-].
    calibration : Calibration or None
        Published values of this class of vehicles, None without any.
    published : sequence of dict
        These values beside their predictions, as `tailslap validate` has them.
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
    decisive: tuple[str, ...] = ()
    speeds: tuple[str, ...] = ()
    growth: float = 0.0
    calibration: Calibration | None = None
    published: Sequence[Mapping[str, Any]] = field(default=(), repr=False)

    def calibrated(self, forces: Sequence[float]) -> tuple[float, ...]:
        """Return forces [N] with the calibrated distance from the median.

        Without a factor they are returned as they are.
        """
        factor = (self.calibration and self.calibration.factor) or 1.0
        return tuple(self.percentiles[1] * (force / self.percentiles[1]) ** factor for force in forces)

    @property
    def limits(self) -> tuple[float, ...]:
        """Lower end, median and upper end of the band [N].

        Calibrated if possible; empty without a band.
        """
        return self.calibrated(self.percentiles)

    @property
    def name(self) -> str:
        """What the band is of, in words."""
        of = self.calibration
        if of is None or of.factor is None:
            return f"{central_part()} of the inputs alone"
        return f"{central_part()} band, calibrated on {of.rows} published values of {of.studies} studies"

    @property
    def median(self) -> str:
        """Median in words, empty without a band."""
        return f"median {force_text(self.percentiles[1])}" if self.percentiles else ""

    @property
    def interval(self) -> str:
        """Median and limits of the band in words, empty without a band."""
        if not self.percentiles:
            return ""
        lower, _, upper = self.limits
        form = ".0f" if lower >= 1e5 else ".3g"
        ends = measure(lower, "N", form, named=False), measure(upper, "N", form)
        return f"{self.median}; {self.name}: {ends[0]} to {ends[1]}"

    @property
    def decision(self) -> str:
        """Sentence on the inputs and the speed that decide the force."""
        fractions = [f"{100.0 * fraction:.0f} %" for fraction in self.variance_fractions.values()]
        inputs = [f"{words} ({part})" for words, part in zip(self.decisive, fractions, strict=False)]
        parts = [f"decided most by {', and '.join(inputs)} of the variance"] if inputs else []
        if self.growth:
            slow, fast = self.speeds
            parts.append(f"from {slow} to {fast} the force grows {self.growth:.2g} times")
        text = "; ".join(parts).replace(") of the variance", " of the variance)")
        return f"{text[0].upper()}{text[1:]}. " if text else ""

    @property
    def sentence(self) -> str:
        """What decides the force, and the origin of the band."""
        if not self.percentiles:
            return f"Without a band of the force: {self.refusal}." if self.refusal else ""
        assumed = sum("assumed" in origin for *_, origin in self.ranges.values())
        parts = [
            f"Band of {self.samples} rigid vehicles over {len(self.ranges)} inputs, {assumed} with assumed ranges",
            self.calibration.sentence if self.calibration else "",
            self._outcomes,
            f"not varied, since outside the range: {', '.join(f'`{key}`' for key in self.fixed)}"
            if self.fixed
            else "",
            f"{self.unsolved} further vehicles omitted, which have no solution" if self.unsolved else "",
            f"the first of them: {self.reason}" if self.reason else "",
        ]
        return f"{self.decision}{'; '.join(filter(None, parts))}."

    @property
    def _outcomes(self) -> str:
        """Fractions of the outcomes in words, with bounds by their number."""
        if not self.outcomes:
            return ""
        parts = [
            f"{fraction_in_words(fraction, self.samples)} {name}" for name, fraction in self.outcomes.items()
        ]
        return f"{', '.join(parts)} (95 % confidence by their number)"

    def numbers(self) -> dict[str, object]:
        """Return the part `force_band` of results, SI."""
        further = {
            name: value
            for name, value in vars(self).items()
            if name not in ("percentiles", "forces", "decisive", "published")
        }
        ends = dict(zip(("lower", "median", "upper"), self.limits, strict=False))
        of = {"calibration": self.calibration and vars(self.calibration)}
        return dict(zip(percentile_names(), self.percentiles, strict=False)) | ends | further | of
