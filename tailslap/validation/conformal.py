"""Calibrate bands on published values by split conformal prediction.

The score of a published value is its logarithm over the median, in units of the logarithm of the end of the band of the
inputs on its side. The factor on the band is the k-th smallest of n scores, k the least integer of at least 0.9 (n + 1)
(Lei et al. 2018, J. Am. Stat. Assoc. 113, 1094, algorithm 2), which exists from nine values on. Values of one study are
not independent: how the band holds is tested on whole studies that are left out one by one.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

from tailslap.case.force_band import PERCENTILES, Calibration

COVERAGE = 0.01 * (PERCENTILES[-1] - PERCENTILES[0])
"""Probability of a calibrated band for a further value."""


def score(published: float, lower: float, median: float, upper: float) -> float:
    """Return the distance from the median in half widths, in logarithms."""
    end = upper if published >= median else lower
    return math.log(published / median) / math.log(end / median)


def conformal_factor(scores: Sequence[float]) -> float | None:
    """Return the factor on the band, None for too few scores."""
    place = math.ceil(COVERAGE * (len(scores) + 1) - 1e-9)
    return sorted(scores)[place - 1] if place <= len(scores) else None


def held_of_left_out(scores: Sequence[float], studies: Sequence[str]) -> list[bool]:
    """Return which values lie in the band that other studies calibrate.

    Where the others are too few for a factor, it is their largest score.
    """
    held = []
    for value, study in zip(scores, studies, strict=True):
        others = [other for other, of in zip(scores, studies, strict=True) if of != study]
        factor = conformal_factor(others)
        held.append(bool(others) and value <= (max(others) if factor is None else factor))
    return held


def calibration_of(
    name: str, published: Sequence[float], bands: Sequence[tuple[float, float, float]], studies: Sequence[str]
) -> Calibration:
    """Return the calibration of a class of vehicles.

    published [N], bands: lower end, median and upper end of the inputs [N], and studies of each value.
    """
    scores = [score(value, *band) for value, band in zip(published, bands, strict=True)]
    ratios = [value / median for value, (_, median, _) in zip(published, bands, strict=True)]
    calibration = Calibration(name, len(scores), len(set(studies)), min(ratios), max(ratios))
    if (factor := conformal_factor(scores)) is None:
        return calibration
    held = held_of_left_out(scores, studies)
    failed = {study for study, is_held in zip(studies, held, strict=True) if not is_held}
    return replace(
        calibration, factor=factor, rows_held=sum(held), studies_held=calibration.studies - len(failed)
    )
