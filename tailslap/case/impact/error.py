"""The numerical error of a whole impact: the same vehicle on other meshes, judged as ASME V&V 20 judges them."""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from fem.plate import kinds
from solver.impact import Strike
from tailslap.case.impact.answers import MEAN_WINDOW, ImpactAnswer, heavy, mean_peak
from tailslap.case.plate_input import refined
from tailslap.scene.schema import Plate

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
"""Error that comes on top: of time steps and rows, which all meshes share."""

TWO_MESHES, THREE_MESHES = 3.0, 1.25
"""Factors of safety on an error that so many meshes tell (Roache 1994; ASME V&V 20)."""

ORDER = 4.0 / 3.0
"""Order that is assumed of two meshes, and of three at most: below that of the elements, for a corner's force acts on a
point."""

COARSEST = 2
"""Quadratic elements across that judge linear ones, at least, where the plate has as many."""

LATER = 1.1
"""Durations of a strike after which it is over on other meshes as well, on which it may last a little longer."""

THIRD_UP_TO = 1000
"""Elements that a third mesh has at most."""


def weighed(strikes: Sequence[Strike]) -> list[Strike]:
    """The first two strikes of weight; of a train the largest too, which may be the trailer's rear one."""
    found = heavy(strikes)
    largest = max((strike.impulse for strike in found), default=0.0)
    is_train = any("trailer" in strike.corner for strike in strikes)
    return found[:2] + [strike for strike in found[2:] if is_train and strike.impulse == largest]


def of_weight(differences: Mapping[str, float], strikes: Sequence[Strike]) -> dict[str, float]:
    """Differences, by `strike_1.impulse` and so on, of the heavy strikes: no error is stated for others."""
    names = {f"strike_{1 + strikes.index(strike)}" for strike in heavy(strikes)}
    return {name: each for name, each in differences.items() if name.partition(".")[0] in names}


def judged_until(answer: ImpactAnswer) -> float:
    """Return the instant up to which another mesh is run [s].

    A judged or the largest strike may be resumed until then, and its 50 ms mean reaches as far. It is the end for a
    single strike, and for a train, whose hinges may have their largest force there.
    """
    end, strikes = float(answer.history["t"][-1]), answer.strikes
    if len(weighed(strikes)) < 2 or answer.units > 1:
        return end
    judged = (*weighed(strikes), max(strikes, key=lambda strike: strike.impulse))
    return min(end, max(strike.end + max(LATER * strike.duration, MEAN_WINDOW) for strike in judged))


def companions(plate: Plate) -> Iterator[tuple[Plate, Plate]]:
    """A mesh of quadratic elements and one twice as fine, to try in turn; the plate's own is one of them where it can.

    Linear elements are judged by quadratic ones, with nodes a little closer: an error that two meshes of theirs share,
    of a plate too stiff in bending, has another size on those.
    """
    if higher := kinds.ELEMENT_KINDS[plate.element].higher_order:
        plate = plate.model_copy(update={"lumping": "exact"})  # row sums give the corners of tri6 no mass
        quarter = (0.25,) if min(plate.counts) >= 4 * COARSEST else ()
        meshes = [refined(plate, part, higher, whole=round) for part in (*quarter, 1.0 / 3.0, 0.5, 1.0)]
        for coarse in [mesh for mesh in meshes if min(mesh.counts) >= COARSEST] or meshes[-1:]:
            yield coarse, refined(coarse)
        return
    if min(plate.counts) > 3 and not any(count % 2 for count in plate.counts):
        yield refined(plate, 0.5), plate
    yield plate, refined(plate)


def third(finer: Plate) -> Plate | None:
    """The next mesh of the sequence, twice as fine; None where that is too large."""
    finest = refined(finer)
    return finest if math.prod(finest.counts) <= THIRD_UP_TO else None


def changes(one: ImpactAnswer, other: ImpactAnswer) -> dict[str, float]:
    """Relative changes from one impact to another by `strike_1.impulse` and so on; infinite where other corners strike,
    or where one diverged."""
    strikes = weighed(one.strikes)
    its = weighed(other.strikes)[:2]
    for strike in strikes[2:]:  # the largest of the other train may be another one
        alike = [each for each in other.strikes if each.corner == strike.corner]
        apart = [abs(each.start - strike.start) for each in alike]
        its += [alike[int(np.argmin(apart))]] if alike else []
    same = [strike.corner for strike in strikes] == [strike.corner for strike in its]
    same = same and all(np.isfinite(each.history["force_normal"]).all() for each in (one, other))
    found = {}
    for k, strike in enumerate(strikes):
        for name in QUANTITIES:
            moved = value(other, its[k], name) / value(one, strike, name) - 1.0 if same else math.inf
            found[f"strike_{k + 1}.{name}"] = moved
    return found


def value(answer: ImpactAnswer, strike: Strike, name: str) -> float:
    """A quantity of `QUANTITIES` of a strike [SI]."""
    return mean_peak(answer, strike) if name == "mean_50ms" else float(getattr(strike, name))


def estimate(own: ImpactAnswer, sequence: Sequence[ImpactAnswer]) -> dict[str, float]:
    """Error of each quantity of the first two strikes of weight.

    Parameters
    ----------
    own : ImpactAnswer
        Whose error it is.
    sequence : sequence of ImpactAnswer
        Of two or three meshes, each twice as fine as the one before.

    Returns
    -------
    dict of float
        By `strike_1.impulse` and so on, relative: the distance from the finest mesh, and what that lacks. A step
        between meshes counts as the geometric mean of it and the largest of its strike: it may be small by chance.
    """
    moved = [changes(own, answer) for answer in sequence]
    apart = {key: [each[key] for each in moved] for key in moved[0]}
    steps = {key: abs(each[-1] - each[-2]) for key, each in apart.items()}
    found: dict[str, float] = {}
    for k, strike in enumerate(weighed(own.strikes), 1):
        keys = [f"strike_{k}.{name}" for name in QUANTITIES]
        most = max(steps[key] for key in keys)
        found |= {key: _judged(apart[key], math.sqrt(steps[key] * most)) for key in keys}
        found[f"strike_{k}.duration"] += 0.5 * own.interval / strike.duration  # of a row, in which it ends
    return found


def hinge_errors(own: ImpactAnswer, sequence: Sequence[ImpactAnswer]) -> list[float]:
    """Relative errors of the largest 50 ms mean of the force of each hinge of a train; arguments of `estimate`.

    A step between meshes may be small by chance. It counts as no less than a third, the factor of safety, of the
    largest difference of the 50 ms means about the peak, which bounds it.
    """
    apart = hinge_changes(own, sequence)
    bounds = [_difference_at_peak(own, sequence[-2:], hinge) for hinge in range(len(apart))]
    return [
        _judged(distances, max(abs(distances[-1] - distances[-2]), bound / TWO_MESHES))
        for distances, bound in zip(apart, bounds, strict=True)
    ]


def hinge_changes(own: ImpactAnswer, sequence: Sequence[ImpactAnswer]) -> list[list[float]]:
    """Relative changes of the largest 50 ms mean of each hinge, to each answer of the sequence."""
    means = np.array([[hinge["mean_50ms"] for hinge in answer.hinges] for answer in (own, *sequence)])
    return list((means[1:] / means[0] - 1.0).T.tolist())


def _difference_at_peak(own: ImpactAnswer, pair: Sequence[ImpactAnswer], hinge: int) -> float:
    """Largest difference of the 50 ms means of two answers within 25 ms of the own peak, over that peak."""
    end = min(float(answer.history["t"][-1]) for answer in (own, *pair))
    width = min(MEAN_WINDOW, end)
    starts = own.history["t"][own.history["t"] <= end - width]
    mean, one, other = (hinge_means(answer, hinge, starts, width) for answer in (own, *pair))
    near = np.abs(starts - starts[np.argmax(mean)]) <= 0.5 * MEAN_WINDOW
    return float(np.abs(one - other)[near].max() / mean.max())


def hinge_means(answer: ImpactAnswer, hinge: int, starts: np.ndarray, width: float) -> np.ndarray:
    """Mean force [N] of a hinge over windows of a width [s] from each start; shape (starts,)."""
    t = answer.history["t"]
    impulses = [np.cumsum(answer.history[f"hinge_force_{x}_{hinge + 1}"]) * answer.interval for x in "xy"]
    gained = [np.interp(starts + width, t, impulse) - np.interp(starts, t, impulse) for impulse in impulses]
    return np.hypot(*gained) / width


def _judged(apart: Sequence[float], step: float) -> float:
    """The error from the distances of the meshes, the finest last; step: between the last two, as it counts."""
    if not all(map(math.isfinite, apart)):
        return math.inf
    *before, last = (later - earlier for earlier, later in pairwise(apart))
    factor = safety(before[0] / last if last else math.inf) if before else TWO_MESHES / (2.0**ORDER - 1.0)
    return RESOLVED + abs(apart[-1]) + factor * step


def safety(ratio: float) -> float:
    """Multiple of the last step between three meshes that is stated as the error of the finest; ratio: of the step
    before to it. Without an order, that of two meshes of first order."""
    if ratio <= 1.0:
        return TWO_MESHES
    return min(TWO_MESHES, THREE_MESHES / (2.0 ** min(ORDER, math.log2(ratio)) - 1.0))


def largest(errors: Mapping[str, float], quantity: str = "") -> float:
    """The largest error of a quantity in both strikes, or of all; NaN where none is stated."""
    return max((error for name, error in errors.items() if name.endswith(quantity)), default=math.nan)
