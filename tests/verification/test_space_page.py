"""Verify kernels of a page in space against the command."""

from typing import Any

import numpy as np
import pytest
from shared_cases import case

from solver.space import UNDECIDED, solve_spaces
from solver.space.vehicle import fleet_of
from tailslap.browser import space, space_model
from tailslap.campaign import band_samples
from tailslap.case.impact.space.input import space_input
from tailslap.case.of_arguments import case_of_scene

TRUCK, TRAIN = "impact-tipping-tl4-sut", "impact-97-kip-tractor-van"
CHANGES = {"impact.speed": 28.0, "vehicle.mass": 11000.0, "wall.height": 0.8, "contact.friction": 0.2,
           "axle.1.spring": 4e5, "strip.0.stiffness": 3e6, "vehicle.length": 10.5}  # fmt: skip


def called(one, name, changes=None):
    """Return result and arguments of a kernel with changed quantities."""
    built: Any = space_model.model_of(one)
    kernel, arguments = built.calls[name]
    for key, value in (changes or {}).items():
        arguments[0][built.quantities.index(key), 0] = value
    return kernel(*arguments), arguments, kernel


@pytest.mark.parametrize(("scene", "changes"), [(TRUCK, {}), (TRUCK, CHANGES), (TRAIN, {})])
def test_a_motion_is_that_of_the_changed_scene(scene, changes):
    """Quantities that the scene omits follow from the changed ones."""
    (reason, _, count), (_, _, room, curves), _ = called(case(scene), "space", changes)
    inputs = space_input(case_of_scene(scene, changes).scene)
    fleet, one = fleet_of(*inputs), solve_spaces(*inputs)
    fleet.units[:, 0, 15:] = 0.0  # the page has no sensor
    for ours, theirs in zip(room.fleet, fleet, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-13, atol=1e-15)
    assert (reason, count) == (space.POSSIBLE, one.rows[0])
    for name in ("outcome", "largest_roll", "mean_50ms", "height", "moment", "largest_pitch"):
        column = one._fields.index(name)
        assert room.answers[0, column] == pytest.approx(getattr(one, name)[0], rel=1e-9), name
    assert curves.peaks[-1] == pytest.approx(one.mean_50ms[0], rel=1e-9)


@pytest.mark.parametrize("changes", [{}, {"wall.height": 0.64}])
def test_a_refined_motion_has_the_errors_of_the_command(changes):
    """On a wall near the lowest one it is undecided."""
    (reason, _, count), (_, _, room, motions, _, curves), _ = called(case(TRUCK), "space_one", changes)
    motion = case(TRUCK, *(f"{key}={value}" for key, value in changes.items())).space.motion
    parts, points, *errors, undecided, heights = motions.result
    assert reason == space.POSSIBLE
    assert count == len(motion.history["t"])
    assert (1e-3 / parts, points) == (motion.step, motion.points)
    assert errors == pytest.approx([motion.step_error, motion.strip_error, motion.other_error], rel=1e-9)
    assert (undecided == 1.0) == (motion.outcome == UNDECIDED) == bool(changes)
    assert motions.heights[: int(heights)] == pytest.approx(motion.heights)
    assert room.answers[0, 5] == pytest.approx(motion.answers.mean_50ms)
    assert curves.rows[0, :count, 0] == pytest.approx(motion.history["force_normal"])


def test_a_band_is_that_of_the_command():
    """Blocks of an uncalibrated train follow one another."""
    _, arguments, kernel = called(case(TRAIN), "space_band")
    place, forces, outcomes, percentiles = (arguments[k] for k in (8, 6, 7, 9))
    while place[0] < len(forces):
        result = kernel(*arguments)
    band = band_samples.force_band(case(TRAIN))
    assert result == (space.POSSIBLE, 0, band.samples, len(band.ranges), -1)
    np.testing.assert_allclose(percentiles[1], band.percentiles, rtol=1e-9)
    np.testing.assert_allclose(outcomes / band.samples, [*band.outcomes.values()])


def test_the_sweep_of_walls_has_the_wall_of_the_scene_between():
    """On both walls about it forces are near the scene's."""
    _, arguments, kernel = called(case(TRUCK), "space_wall")
    walls, lowest = arguments[4], arguments[5]
    for _ in range(len(walls)):
        kernel(*arguments)
    heights = walls[:, 0]
    inputs = space_input(case(TRUCK).scene)
    at = inputs.vehicle, inputs.wall.__class__(heights), inputs.speed, inputs.angle
    one = solve_spaces(at[0], inputs.wall.__class__(heights, friction=inputs.wall.friction), *at[2:])
    np.testing.assert_array_equal(walls[:, 1], one.outcome)
    np.testing.assert_allclose(
        walls[:, 2:6].T, [one.largest_roll, one.mean_50ms, one.height, one.moment], rtol=1e-9
    )
    assert lowest[0] == pytest.approx(0.638, abs=0.002)
    assert (walls[heights > lowest[0], 1] == 0.0).all()


@pytest.mark.parametrize(("changes", "reason"), [
    ({"body.centre_height": 0.4}, space.OF_COLUMNS + 2), ({"wall.height": 0.01}, space.NO_CONTACT),
    ({"axle.0.tyre": 1e15}, space.STEPS), ({"strip.0.inset": 1.3}, space.OF_COLUMNS + 11),
])  # fmt: skip
def test_impossible_values_have_a_reason(changes, reason):
    (said, item, _), _, _ = called(case(TRUCK), "space", changes)
    assert (said, item) == (reason, 0)
