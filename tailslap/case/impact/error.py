"""Numerical error of whole impacts by other meshes.

The differences are evaluated as in ASME V&V 20.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from fem.plate import kinds
from solver.impact import Strike
from solver.impact.strikes import nearest
from tailslap.case.impact.answers import MEAN_WINDOW, ImpactAnswer, heavy, mean_peak
from tailslap.case.plate_input import refined
from tailslap.scene.model_tables import Plate

QUANTITIES = {
    "peak_force": "peak force",
    "impulse": "impulse",
    "mean_50ms": "50 ms mean",
    "duration": "duration",
}
"""Quantities of a strike whose error is stated, in words."""

STATED = QUANTITIES | {"hinge": "hinge force"}
"""All quantities whose error is stated, in words."""

RESOLVED = 1e-3
"""Additional error of rows, which is the same on all meshes."""

TWO_MESHES, THREE_MESHES = 3.0, 1.25
"""Factors of safety on an error from two and three meshes (Roache 1994; ASME V&V 20)."""

HALF = 0.5
"""Part of the time step on a coarse mesh: the step on the fine one, so that the mesh alone differs."""

STEP = TWO_MESHES / (HALF**-2.0 - 1.0)
"""Factor on the change by half the time step, in which contact is of second order."""

ORDER = 4.0 / 3.0
"""Order that is assumed for two meshes, and the largest for three. It is below that of the elements, because a corner's
force acts on a point."""

COARSEST = 2
"""Least number of quadratic elements across for the error of linear ones, where the plate has as many."""

COARSEST_THIRD = 4
"""Least number of quadratic elements across of a third mesh that is coarser than the others."""

NEAR = 0.9
"""Impulse or 50 ms mean of a strike over the largest, from which its error is stated."""

LATER = 1.1
"""Durations of a strike after which it is over on other meshes as well; it may last a little longer there."""

FINER_UP_TO, FINEST_UP_TO = 2000, 4000
"""Largest number of elements of a chosen mesh that is refined, and of a finest mesh before a check of one unit
fails."""


def assessed_strikes(answer: ImpactAnswer) -> list[Strike]:
    """Return the first two heavy strikes and those near the largest.

    These have `NEAR` of the largest impulse or 50 ms mean.
    """
    major, has_means = heavy(answer.strikes), is_finite(answer)
    means = [mean_peak(answer, strike) if has_means else math.nan for strike in major]
    sizes = np.array([[strike.impulse for strike in major], means])
    is_near = (sizes >= NEAR * sizes.max(axis=1, initial=0.0, keepdims=True)).any(axis=0)
    return [strike for k, strike in enumerate(major) if k < 2 or is_near[k]]


def is_finite(answer: ImpactAnswer) -> bool:
    """Return False for an impact that diverged."""
    return bool(np.isfinite(answer.history["force_normal"]).all())


def of_weight(differences: Mapping[str, float], strikes: Sequence[Strike]) -> dict[str, float]:
    """Return the differences of the heavy strikes.

    Keys are `strike_1.impulse` and so on. No error is stated for other strikes.
    """
    names = {f"strike_{1 + strikes.index(strike)}" for strike in heavy(strikes)}
    return {name: difference for name, difference in differences.items() if name.partition(".")[0] in names}


def judged_until(answer: ImpactAnswer) -> float:
    """Return the end of a run on another mesh [s].

    An assessed strike may be resumed until then, and its 50 ms mean reaches as far. It is the end for a single strike,
    and for a train, whose hinges may have their largest force there.
    """
    end, judged = float(answer.history["t"][-1]), assessed_strikes(answer)
    if len(judged) < 2 or answer.units > 1:
        return end
    return min(end, max(strike.end + max(LATER * strike.duration, MEAN_WINDOW) for strike in judged))


def companions(plate: Plate) -> Iterator[tuple[Plate, Plate]]:
    """Yield pairs of meshes of quadratic elements, the second twice as fine.

    Pairs are tried in turn; the mesh of the run is one of them where possible. The error of linear elements is
    estimated by quadratic ones with slightly closer nodes: excess stiffness in bending, which two meshes of linear
    elements have in common, has another size on those.
    """
    if higher := kinds.ELEMENT_KINDS[plate.element].higher_order:
        plate = plate.model_copy(update={"lumping": "exact"})  # the corners of tri6 have no mass by row sums
        quarter = (0.25,) if min(plate.counts) >= 4 * COARSEST else ()
        meshes = [refined(plate, part, higher, whole=round) for part in (*quarter, 1.0 / 3.0, 0.5, 1.0)]
        for coarse in [mesh for mesh in meshes if min(mesh.counts) >= COARSEST] or meshes[-1:]:
            yield coarse, refined(coarse)
        return
    if min(plate.counts) > 3 and not any(count % 2 for count in plate.counts):
        yield refined(plate, 0.5), plate
    yield plate, refined(plate)


def coarser(plate: Plate) -> Plate | None:
    """Return a mesh half as fine.

    None if it is too coarse, or if an odd number of elements cannot be halved.
    """
    if min(plate.counts) < 2 * COARSEST_THIRD or any(count % 2 for count in plate.counts):
        return None
    return refined(plate, 0.5)


def finer(plate: Plate, most: int = FINER_UP_TO) -> Plate | None:
    """Return a mesh twice as fine, of at most `most` elements."""
    finest = refined(plate)
    return finest if math.prod(finest.counts) <= most else None


def counterparts(one: ImpactAnswer, other: ImpactAnswer) -> list[Strike]:
    """Return the strikes of another impact that correspond to the assessed ones.

    The list is empty where other corners strike, or where an impact diverged. The first two are those of the other in
    their order, further ones the nearest in time.
    """
    strikes, matched = assessed_strikes(one), heavy(other.strikes)[:2]
    matched += [same for strike in strikes[2:] if (same := nearest(other.strikes, strike))]
    agree = [strike.corner for strike in strikes] == [strike.corner for strike in matched]
    return matched if agree and is_finite(one) and is_finite(other) else []


def changes(one: ImpactAnswer, other: ImpactAnswer) -> dict[str, float]:
    """Return relative changes from one impact to another.

    Keys are `strike_1.impulse` and so on. Changes are infinite without `counterparts`.
    """
    matched = counterparts(one, other)
    return {
        f"strike_{k + 1}.{name}": value(other, matched[k], name) / value(one, strike, name) - 1.0
        if matched
        else math.inf
        for k, strike in enumerate(assessed_strikes(one))
        for name in QUANTITIES
    }


def unsure_end(answer: ImpactAnswer, strike: Strike) -> float:
    """Return the part of a duration that light touches decide on."""
    same = (
        candidate
        for candidate in answer.by_other_touches
        if candidate.corner == strike.corner and candidate.start <= strike.start < candidate.end
    )
    return max((abs(candidate.duration / strike.duration - 1.0) for candidate in same), default=math.inf)


def value(answer: ImpactAnswer, strike: Strike, name: str) -> float:
    """Return a strike's quantity of `QUANTITIES` [SI]."""
    return mean_peak(answer, strike) if name == "mean_50ms" else float(getattr(strike, name))


def estimate(
    base: ImpactAnswer, sequence: Sequence[ImpactAnswer], steps: Sequence[ImpactAnswer]
) -> dict[str, float]:
    """Estimate the error of each quantity of the assessed strikes.

    Errors are by `strike_1.impulse` and so on, relative: the distance from the finest mesh, plus the errors of that and
    of the time step. A step between meshes may be small by chance: it counts as no less than its geometric mean with
    the largest of its strike. Half a row, in which a strike ends, and `unsure_end` are added to a duration.

    Parameters
    ----------
    base : ImpactAnswer
        Impact whose error is estimated.
    sequence : sequence of ImpactAnswer
        On two or three meshes, each twice as fine as the one before.
    steps : sequence of ImpactAnswer
        On the coarser of two meshes, with a whole and with half a time step.
    """
    strikes, impacts = assessed_strikes(base), (*sequence, *steps)
    matched = [counterparts(base, answer) for answer in impacts]
    *apart, whole, halved = (changes(base, answer) for answer in impacts)
    if not all(matched):
        return dict.fromkeys(whole, math.inf)
    errors: dict[str, float] = {}
    for k, same in enumerate(zip(strikes, *matched, strict=True), 1):
        names = [f"strike_{k}.{name}" for name in QUANTITIES]
        steps_of = [abs(apart[-1][name] - apart[-2][name]) for name in names]
        for name, step in zip(names, steps_of, strict=True):
            least = math.sqrt(step * max(steps_of))
            stepped = STEP * abs(halved[name] - whole[name])
            errors[name] = _judged([changed[name] for changed in apart], least) + stepped
        unsure = max(map(unsure_end, (base, *sequence), same))
        errors[f"strike_{k}.duration"] += 0.5 * base.interval / same[0].duration + unsure
    return errors


def hinge_errors(
    base: ImpactAnswer, sequence: Sequence[ImpactAnswer], steps: Sequence[ImpactAnswer]
) -> list[float]:
    """Return the relative error of each hinge's largest 50 ms mean.

    Arguments as of `estimate`. A step between meshes may be small by chance. It counts as no less than a third, the
    factor of safety, of the largest difference of the 50 ms means about the peak, which bounds it.
    """
    apart, stepped = hinge_changes(base, sequence), hinge_changes(base, steps)
    bounds = [_difference_at_peak(base, sequence[-2:], hinge) for hinge in range(len(apart))]
    return [
        _judged(distances, max(abs(distances[-1] - distances[-2]), bound / TWO_MESHES))
        + STEP * abs(halved - whole)
        for distances, bound, (whole, halved) in zip(apart, bounds, stepped, strict=True)
    ]


def hinge_changes(base: ImpactAnswer, sequence: Sequence[ImpactAnswer]) -> list[list[float]]:
    """Return the relative changes of each hinge's largest 50 ms mean.

    They are from `base` to each answer of the sequence.
    """
    means = np.array([[hinge["mean_50ms"] for hinge in answer.hinges] for answer in (base, *sequence)])
    return list((means[1:] / means[0] - 1.0).T.tolist())


def _difference_at_peak(base: ImpactAnswer, pair: Sequence[ImpactAnswer], hinge: int) -> float:
    """Return the relative difference of two answers near the peak.

    It is the largest of their 50 ms means within 25 ms of the peak of `base`, over that peak.
    """
    end = min(float(answer.history["t"][-1]) for answer in (base, *pair))
    width = min(MEAN_WINDOW, end)
    starts = base.history["t"][base.history["t"] <= end - width]
    mean, one, other = (hinge_means(answer, hinge, starts, width) for answer in (base, *pair))
    near = np.abs(starts - starts[np.argmax(mean)]) <= 0.5 * MEAN_WINDOW
    return float(np.abs(one - other)[near].max() / mean.max())


def hinge_means(answer: ImpactAnswer, hinge: int, starts: np.ndarray, width: float) -> np.ndarray:
    """Return the mean force [N] of a hinge over windows.

    starts, width: of the windows [s].
    """
    t = answer.history["t"]
    impulses = [np.cumsum(answer.history[f"hinge_force_{x}_{hinge + 1}"]) * answer.interval for x in "xy"]
    gains = [np.interp(starts + width, t, impulse) - np.interp(starts, t, impulse) for impulse in impulses]
    return np.hypot(*gains) / width


def _judged(apart: Sequence[float], step: float) -> float:
    """Return the error from distances to other meshes.

    apart: the finest mesh last; step: between the last two, at its least value.
    """
    if not all(map(math.isfinite, apart)):
        return math.inf
    *before, last = (later - earlier for earlier, later in pairwise(apart))
    factor = safety(before[0] / last if last else math.inf) if before else TWO_MESHES / (2.0**ORDER - 1.0)
    return RESOLVED + abs(apart[-1]) + factor * step


def safety(ratio: float) -> float:
    """Return the factor on the last step.

    Its product with the step is the error of the finest of three meshes. ratio: of the first step to the last. Without
    an order it is that of two meshes of first order.
    """
    if ratio <= 1.0:
        return TWO_MESHES
    return min(TWO_MESHES, THREE_MESHES / (2.0 ** min(ORDER, math.log2(ratio)) - 1.0))


def largest(errors: Mapping[str, float], quantity: str = "") -> float:
    """Return the largest error of a quantity in both strikes.

    Without a quantity it is that of all; NaN where none is stated.
    """
    return max((error for name, error in errors.items() if name.endswith(quantity)), default=math.nan)
