"""Compute the force band of a scene.

It is that of few rigid vehicles with varied inputs.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tailslap.campaign import planar_ranges, sampling
from tailslap.campaign.input_ranges import Range
from tailslap.campaign.sampling import Array
from tailslap.case.case import Case
from tailslap.case.force_band import LEAST_NAMED, MOST_NAMED, ForceBand
from tailslap.case.resources import available_cores
from tailslap.errors import InputError
from tailslap.scene.units import to_si

SAMPLES, SAMPLES_OF_SLOW = 256, 72
"""Number of vehicles, and of trains and vehicles in space."""

PAIRS, SPEEDS = 32, (0.8, 4.0 / 3.0)
"""Most vehicles at each of two speeds, and these over the speed of the scene [-]."""

WORDS = {
    "plateau_force": "the plateau of the crush", "plateau": "the plateau of the crush",
    "stiffness": "the stiffness of the crush", "restitution": "the restitution",
    "hardening": "the hardening of the crush",
    "duration": "the duration of the strike",
    "centre_of_mass": "the place of the centre of mass", "centre_height": "the height of the centre of mass",
    "angle": "the angle", "mass": "the mass", "yaw_inertia": "the yaw inertia", "friction": "friction",
    "roll_inertia": "the roll inertia", "spring": "the springs of the axles", "spacing": "the spacing of the springs",
    "tyre": "the stiffness of the tyres", "cornering": "the cornering of the tyres",
    "axle.*.friction": "the friction of the tyres",
}  # fmt: skip
"""Inputs in words by their keys or the last part of these."""
FIRST = 8
"""Impacts in the plane before all others: a law that requires too many steps is mostly refused among them."""

TOO_FEW = "too few of the varied inputs have a solution"

Columns = Mapping[str, Array]


def force_band(case: Case) -> ForceBand:
    """Return the force band over the default ranges.

    The force is that of the headline: the peak of a constrained corner, otherwise the largest 50 ms mean. An input with
    a value outside its range is not varied, as the vehicle would not belong to the band. A band that cannot be computed
    contains the reason.
    """
    try:
        count = SAMPLES_OF_SLOW if case.scene.trailer or case.scene.body else SAMPLES
        pairs = min(PAIRS, count // 4)
        every, solve = _problem(case, math.ceil((count + 2 * pairs) / available_cores()))
        ranges = tuple(item for item in every if _contains_own(item))
        if not ranges:
            return ForceBand(refusal="all inputs of the scene are outside their ranges")
        drawn = sampling.latin_hypercube(len(every), count, np.random.default_rng(sampling.SEED))
        inputs = {
            item.key: item.lower + (item.upper - item.lower) * column
            for item, column in zip(every, drawn, strict=True)
            if item in ranges
        }
        rows, reason = _possible(case, inputs, count)
        if len(rows) < sampling.MIN_ROWS:
            return ForceBand(refusal=f"{TOO_FEW}; {reason}")
        inputs, pairs = {key: values[rows] for key, values in inputs.items()}, min(pairs, len(rows))
        speeds = two_speeds(case)
        columns = solve(_with_speeds(inputs, [*speeds.values()], pairs))
    except InputError as error:
        return ForceBand(refusal=str(error))
    fixed = tuple(item.key for item in every if item not in ranges)
    band = _band(ranges, inputs, {name: values[: len(rows)] for name, values in columns.items()})
    band = replace(band, fixed=fixed, unsolved=count - band.samples, reason=reason)
    return _with_growth(band, tuple(speeds), next(iter(columns.values()))[len(rows) :].reshape(-1, pairs))


def two_speeds(case: Case) -> dict[str, float]:
    """Return a lower and a higher speed [m/s] by text.

    They are 0.8 and 1.33 of the scene's, and have two digits in its unit. Empty for a scene that starts later.
    """
    if case.scene.impact is None or case.scene.starts_later:
        return {}
    unit = case.quantity("impact.speed").partition(" ")[2] or "m/s"
    factor, _ = to_si(unit)
    slow, fast = (float(f"{part * case.scene.impact.speed / factor:.2g}") for part in SPEEDS)
    return {f"{slow:g}": slow * factor, f"{fast:g} {unit}": fast * factor}


def _with_speeds(inputs: Columns, speeds: list[float], pairs: int) -> Columns:
    """Return inputs with the first vehicles besides at speeds [m/s]."""
    further = {key: np.tile(values[:pairs], len(speeds)) for key, values in inputs.items()}
    further["impact.speed"] = np.repeat(speeds, pairs)
    return {key: np.concatenate([values, further[key]]) for key, values in inputs.items()}


def _with_growth(band: ForceBand, speeds: tuple[str, ...], forces: Array) -> ForceBand:
    """Return a band with the growth of the forces, shape (speeds, pairs)."""
    if not band.percentiles or not speeds:
        return band
    ratios = np.divide(forces[1], forces[0], out=np.zeros_like(forces[0]), where=forces[0] > 0.0)
    solved = ratios[np.isfinite(ratios) & (ratios > 0.0)]
    return replace(band, speeds=speeds, growth=float(np.exp(np.log(solved).mean())) if solved.size else 0.0)


def _contains_own(item: Range) -> bool:
    """Return whether a range contains the scene's value."""
    margin = 1e-9 * (item.upper - item.lower)
    return item.scene_value is None or item.lower - margin <= item.scene_value <= item.upper + margin


def _possible(case: Case, inputs: Columns, count: int) -> tuple[list[int], str]:
    """Return rows of vehicles that stand, and why another does not."""
    if case.scene.body is None:
        return [*range(count)], ""
    from tailslap.campaign import space_samples

    return space_samples.possible_samples(case.scene, inputs)


def _problem(case: Any, block: int) -> tuple[tuple[Range, ...], Any]:
    """Return ranges, and the function from inputs to forces.

    block: number of vehicles at a time. Raises InputError.
    """
    if case.scene.contact is None:
        return planar_ranges.corner_ranges(case), case.many  # closed forms, faster than a thread starts
    first = 1
    if case.scene.body is not None:
        from tailslap.campaign import space_samples

        ranges = space_samples.space_ranges(case, (), ())
        solve = partial(space_samples.sample_answers, case.scene, names=("mean_50ms", "outcome"))
    else:
        planar_ranges.demand_crush(case)
        ranges, solve, first = planar_ranges.impact_ranges(case), case.largest_means, FIRST
    return ranges, partial(sampling.solved_in_blocks, solve, block=block, first=first)


def _band(ranges: tuple[Range, ...], inputs: Columns, columns: Columns) -> ForceBand:
    """Return the band of samples, without those that have no solution."""
    force = next(iter(columns.values()))
    solved = np.isfinite(force)
    if np.count_nonzero(solved) < sampling.MIN_ROWS:
        return ForceBand(refusal=TOO_FEW)
    fractions: dict[str, float] = {}
    if "outcome" in columns:
        from solver.space import OUTCOMES

        outcome = columns["outcome"][solved]
        fractions = {name: float(np.mean(outcome == k)) for k, name in enumerate(OUTCOMES)}
    parts = variance_fractions({key: values[solved] for key, values in inputs.items()}, force[solved])
    items = {item.key: item for item in ranges}
    named = [key for key, fraction in parts.items() if fraction > LEAST_NAMED][:MOST_NAMED]
    return ForceBand(
        sampling.band_of(force).percentiles,
        int(np.count_nonzero(solved)),
        parts,
        {item.key: (item.lower, item.upper, item.origin) for item in ranges},
        fractions,
        forces=tuple(force[solved].tolist()),
        decisive=tuple(in_words(items[key]) for key in named),
    )


def input_name(key: str) -> str:
    """Return an input in words."""
    return WORDS.get(key, WORDS.get(key.partition("@")[0].rpartition(".")[2], f"`{key}`"))


def in_words(item: Range) -> str:
    """Return an input with its range in words."""
    name = input_name(item.key)
    span = item.in_words()[0]
    if "*" in item.key:
        span = f"{item.lower:.2g} to {item.upper:.2g} times that of the scene"
    return f"{name}, {'assumed ' if 'assumed' in item.origin else ''}{span}"


def variance_fractions(inputs: Columns, output: Array) -> dict[str, float]:
    """Return each input's fraction of the variance.

    The largest is first. The output is approximated by a linear function of independent inputs (Saltelli et al., Global
    Sensitivity Analysis, 2008, section 1.2.5, squared standardised regression coefficients).
    """
    values = np.array(list(inputs.values()))
    scaled = (values - values.mean(axis=1, keepdims=True)) / values.std(axis=1, keepdims=True)
    slopes = np.linalg.lstsq(scaled.T, output - output.mean(), rcond=None)[0]
    fractions = slopes**2 / max(float(np.var(output)), np.finfo(float).tiny)
    order = np.argsort(-fractions)
    keys = list(inputs)
    return {keys[number]: float(fractions[number]) for number in order}
