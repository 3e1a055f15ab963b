"""Sample vehicles with ranges of inputs, in plane and space."""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from postprocess.signals.filters import force_curves
from postprocess.signals.strike_duration import second_strike
from tailslap.campaign import sampling, space_samples
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.rigid_input import sensor_position
from tailslap.scene.vary import Source, vary

Floats = NDArray[np.float64]

INTERVAL, AFTER_SECOND, STRIKES = 5e-4, 0.1, 32
"""Time between rows of the forces [s], time after the second strike [s], and strikes with room at first."""

FORCES = ("mean_50ms", "cfc60")
"""Forces on the wall in the plane."""

IN_SPACE = ("outcome", "mean_50ms", "inertial_50ms", "height")
"""Answers in space."""

BLOCK, BLOCK_IN_SPACE = 128, 32
"""Motions at a time on one core."""


class Samples(NamedTuple):
    """Inputs and answers of n vehicles, shape (n,) each by key [SI]."""

    inputs: Mapping[str, Floats]
    answers: Mapping[str, Floats]


def samples_of(
    tables: Mapping[str, Any],
    case: Mapping[str, Any],
    wall: Mapping[str, Any] | None,
    count: int,
    names: Sequence[str] = IN_SPACE,
) -> Samples:
    """Return samples of the vehicle of a case.

    tables: as of `tables.parameters`; case: with `vehicle` and possibly `ranges`, in place of those of the vehicle;
    wall: None in the plane; names: of answers in space.
    """
    vehicle = tables["space_vehicles" if wall else "vehicles"][case["vehicle"]]
    scene = vehicle["scene"] | ({"wall": wall} if wall else {})
    impact = ImpactCase(*vary(Source(tables=scene), {}))
    ranges = space_samples.stated_ranges(impact, vehicle["ranges"] | case.get("ranges", {}))
    points, _ = sampling.sobol_points(ranges, count)
    inputs = dict(zip((item.key for item in ranges), points, strict=True))
    in_space = partial(space_samples.sample_answers, impact.scene, names=names)
    solve = in_space if wall else partial(in_plane, impact)
    return Samples(inputs, sampling.solved_in_blocks(solve, inputs, BLOCK_IN_SPACE if wall else BLOCK))


def in_plane(case: ImpactCase, inputs: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return the answers of impacts in the plane.

    A duration is NaN without a second strike, and an inertial estimate of trains.
    """
    values = space_samples.expanded(case.scene, inputs)
    sensor = None if case.trailers else sensor_position(case.scene, values)
    impacts = case.impacts(
        values, after_second=AFTER_SECOND, interval=INTERVAL, strikes=STRIKES, sensor=sensor
    )
    columns: dict[str, list[float]] = {name: [] for name in (*FORCES, "duration")}
    for force in impacts.mean_force.T:
        curves = force_curves(force, INTERVAL, FORCES)
        for name in FORCES:
            columns[name].append(float(curves[name].max()))
        try:
            columns["duration"].append(second_strike(curves["mean_50ms"], INTERVAL).duration)
        except ValueError:
            columns["duration"].append(math.nan)
    answers = {name: np.array(values) for name, values in columns.items()} | {"exit_speed": impacts.end_speed}
    if sensor is not None:
        means = force_curves(impacts.acceleration.T, INTERVAL, ("mean_50ms",))["mean_50ms"].max(axis=-1)
        answers["inertial_50ms"] = means * values.get("vehicle.mass", case.vehicle.mass)
    return answers
