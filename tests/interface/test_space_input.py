"""Verify that wrong input of the vehicle in space is refused."""

import math
import tomllib
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from space_vehicles import truck, truck_unit

import tailslap
from postprocess.units import SYSTEMS, percent_up
from solver import RigidBodyError
from solver.space import SpaceWall, profile_points, solve_space, solve_spaces
from solver.space.wall import face_at
from tailslap.case.impact.space import SpaceAnswer, space_input
from tailslap.case.of_arguments import case_of_scene
from tailslap.scene.read import read_scene

HIGH, HEIGHT = {"at": 0.0, "height": [0.4, 0.9], "stiffness": 4e6}, "strip.0.height"
SCENE, TRAIN = "impact-tipping-tl4-sut", "examples/train-in-space.toml"


def refused(changes):
    """Return the error of a scene with changed keys."""
    with pytest.raises(tailslap.InputError) as caught:
        tailslap.rigid(SCENE, changes=changes)
    return caught.value


@pytest.mark.parametrize(
    ("changes", "key", "allowed"),
    [
        ({"axle.1.position": "11 m"}, "axle.1.position", "10 m"),
        ({"axle.0.position": "6 m"}, "axle.1.position", "before and behind the centre"),
        ({"axle": None}, "axle", "at least 2"),
        ({"strip": None, "contact.restitution": None}, "strip", "at least one strip"),
        ({"strip.0.height": None}, "strip.0.height", "with [body] a strip has heights"),
        ({"contact.stiffness": "2 MN/m"}, "contact.stiffness", "all units have [[strip]]"),
        (
            {"strip.0.unloading_stiffness": 1e7, "strip.0.restitution": 0.2},
            "strip.0.unloading_stiffness",
            "remove one",
        ),
        ({"strip.3.height": ["49 in", "5 m"]}, "strip.3.height", "4.05 m"),
        ({"strip.0.at": "12 m"}, "strip.0.at", "10 m"),
        ({"strip.0.height": ["0.9 m", "0.45 m"]}, "strip.0.height", "upwards"),
        ({"strip.0.inset": "1.3 m"}, "strip.0.inset", "1.219 m"),
        ({"strip.1.axle": 5}, "strip.1.axle", "0, 1"),
        ({"strip.0.unit": 2}, "strip.0.unit", "1 to 1"),
        ({"body.centre_height": "0.4 m"}, "body.centre_height", "0.5 m"),
        ({"body.centre_height": math.nan}, "body.centre_height", "from 0.05"),
        ({"body.roll_inertia": "100 kg m^2"}, "body.roll_inertia", "more than"),
        ({"axle.0.mass": "9.5 t"}, "vehicle.mass", "more than the axles"),
        ({"axle.0.tyre": None}, "axle.0.tyre", "required"),
        ({"wall.profile": [[0, 0], [0.1, 0.9]]}, "wall.profile", "y not"),
        ({"wall.profile": [[0, 0], [-0.1, 0.5], [-0.2, 0.4]]}, "wall.profile", "z growing"),
        ({"wall.profile": [[0, 0]]}, "wall.profile", "at least two points"),
        ({"wall.profile": "jersey"}, "wall.profile", "new-jersey"),
        ({"wall.height": None}, "wall.height", "required"),
        ({"wall.foundation_stiffness": 1e6}, "wall.foundation_stiffness", "rigid"),
        ({"wall.elements": [3, 3]}, "wall.elements", "rigid"),
        ({"contact.restitution": None}, "strip.0.restitution", "required"),
    ],
)
def test_wrong_values_are_refused_with_their_key(changes, key, allowed):
    error = refused(changes)
    assert error.key == key
    assert allowed in str(error)


@pytest.mark.parametrize(
    ("scene", "changes", "key"),
    [
        ("mash-tl4-sut", {"body.centre_height": 1.3}, "body"),
        ("impact-mash-tl4-sut", {"axle.0.track": "1.85 m"}, "axle.0.track"),
        (
            "impact-mash-tl4-sut",
            {"strip": [HIGH], "contact.stiffness": None, "contact.plateau_force": None},
            HEIGHT,
        ),
        ("impact-mash-tl4-sut", {"wall.height": "32 in"}, "wall.length"),
        (TRAIN, {"trailer.0.hitch_height": None}, "trailer.0.hitch_height"),
        (TRAIN, {"axle.3.spring": None}, "axle.3.spring"),
    ],
)
def test_keys_of_space_and_the_body_require_each_other(scene, changes, key):
    with pytest.raises(tailslap.InputError) as caught:
        tailslap.rigid(scene, changes=changes)
    assert caught.value.key == key


def test_values_that_are_not_finite_are_refused():
    with pytest.raises(RigidBodyError, match=r"body.roll_inertia is nan, but it is not a finite number"):
        solve_space(truck(truck_unit(roll_inertia=math.nan)), SpaceWall(0.9), 25.0, 0.26)


def test_strips_above_the_wall_are_refused():
    """Without a strip that reaches the face there is no impact."""
    high = replace(truck(), strips=truck().strips[2:])
    with pytest.raises(RigidBodyError, match="all strips are above the wall"):
        solve_space(high, SpaceWall(0.9), 25.0, 0.26)


def test_step_of_a_motion_is_the_one_that_was_taken():
    assert solve_space(truck(), SpaceWall(0.9), 25.0, 0.26, step=5e-4).step == 5e-4


def test_arrays_of_different_sizes_are_refused():
    with pytest.raises(RigidBodyError, match="samples"):
        solve_spaces(truck(truck_unit(mass=np.full(3, 9979.0))), SpaceWall(np.full(2, 0.9)), 25.0, 0.26)


def test_named_profiles_have_their_published_points():
    """New Jersey and F-shape have their printed dimensions.

    13 in at 7 in back, and 10 at 5 in; both have 3 in upright, 55 deg to there and 84 deg above.
    """
    inch = 0.0254
    for name, height, back in (("new-jersey", 13, 7), ("f-shape", 10, 5)):
        points = profile_points(name)
        assert face_at(points, np.array([0.0, 3 * inch, height * inch])) == pytest.approx(
            [0.0, 0.0, -back * inch]
        )
        assert math.degrees(math.atan2(height - 3, back)) == pytest.approx(55.0, abs=0.6)
        above = face_at(points, height * inch + np.array([0.0, 0.4]))
        assert math.degrees(math.atan2(0.4, above[0] - above[1])) == pytest.approx(84.0)
    slope = face_at(profile_points("single-slope"), np.array([0.0, 0.9]))
    assert math.degrees(math.atan2(slope[0] - slope[1], 0.9)) == pytest.approx(11.0)


def test_results_have_the_keys_of_the_interface():
    space = tailslap.rigid(SCENE).summary["space"]
    assert space["outcome"] in ("upright", "on its side", "over the wall", "undecided")
    assert space["step_error"] + space["strip_error"] <= space["error"]
    assert space["force"]["heights"][0] == space["force"]["height"]
    assert 2e-3 <= space["lowest_wall_error"] < 0.05
    assert {"raw", "mean_50ms", "height", "length"} <= set(space["force"])
    assert 0.1 <= space["lowest_wall"] <= 0.914
    assert 0.0 < space["largest_roll"] < math.pi / 2


def answer(outcome="upright", lowest=0.6, error=2e-3, wall=0.9, heights=(0.65,)):
    """Return an answer with these statements."""
    inputs = space_input(read_scene(SCENE, [f"wall.height={wall}"])[0])
    motion = SimpleNamespace(
        outcome=outcome, heights=heights, error=0.0064, step_error=0.004, strip_error=0.0024, other_error=0.0,
        answers=SimpleNamespace(largest_roll=0.5),
    )  # fmt: skip
    return SpaceAnswer(inputs, motion, lowest, error)  # type: ignore[arg-type]  # a motion without history


@pytest.mark.parametrize(
    ("values", "outcome", "words"),
    [
        ({}, "upright", "Lowest wall for these inputs: 0.600 m (23.6 in), error at most 2 mm"),
        ({"lowest": math.nan, "error": 0.0}, "upright", "lower ones may. A lowest wall is not stated."),
        (
            {"lowest": math.nan, "error": math.inf},
            "upright",
            "It is undecided whether a wall as high as the centre",
        ),
        ({"wall": 0.61, "error": 0.02}, "undecided", "error at most 20 mm"),
        ({"wall": 0.5}, "upright", "The wall of the scene is an exception"),
        ({"outcome": "over the wall"}, "over the wall", "The wall of the scene is an exception"),
    ],
)
def test_statements_on_walls_do_not_contradict_each_other(values, outcome, words):
    statement = answer(**values)
    assert statement.outcome == outcome
    assert words in SYSTEMS["si"].rendered(statement.lowest)
    assert "No wall" not in statement.lowest
    assert ("undecided" in statement.verdict) == (outcome == "undecided")


def test_equal_strikes_have_both_heights_in_words():
    assert SYSTEMS["si"].rendered(answer(heights=(0.65, 0.43)).heights) == "0.43 or 0.65 m"


def test_the_page_states_the_error_in_space():
    """The error is that of the motion in space."""
    case: Any = case_of_scene(SCENE, None)
    words = SYSTEMS["si"].rendered(str(case.headline()))
    assert (
        f"Rigid vehicle in space; {SYSTEMS['si'].rendered(case.space.accuracy)}. In the plane; error" in words
    )
    assert percent_up(case.space.motion.error) in case.space.accuracy


def test_scene_without_a_body_loads_no_space():
    """Without [body] the packages of the vehicle in space are not imported."""
    import subprocess
    import sys

    code = (
        "import sys, tailslap; tailslap.rigid('impact-mash-tl4-sut'); "
        "print([name for name in sys.modules if name.startswith('solver.space')])"
    )
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert output.stdout.strip() == "[]"


def test_shipped_scene_is_a_scene_file():
    from importlib import resources

    text = resources.files("tailslap.scene").joinpath(f"shipped/{SCENE}.toml").read_text("utf-8")
    assert len(tomllib.loads(text)["strip"]) == 5


@pytest.fixture(scope="module")
def train():
    """Return the result of the train of the examples."""
    return tailslap.rigid(TRAIN).summary["space"]


def test_each_unit_of_a_train_rolls(train):
    """Both units roll, and the stated roll is the larger."""
    rolls = np.abs(train["unit_rolls"])
    assert rolls.shape == (2,)
    assert abs(train["largest_roll"]) == rolls.max()
    assert rolls.min() > 0.2 * rolls.max()


def test_stiffness_of_the_fifth_wheel_joins_the_rolls(train):
    """Without stiffness the tractor is level, and the trailer rolls more."""
    loose = tailslap.rigid(TRAIN, changes={"trailer.0.roll_stiffness": 0.0}).summary["space"]
    assert abs(loose["unit_rolls"][0]) < abs(train["unit_rolls"][0])
    assert abs(loose["unit_rolls"][1]) > abs(train["unit_rolls"][1])


def test_trailer_without_an_axle_is_refused():
    with pytest.raises(tailslap.InputError, match="unit 2 of the train requires at least 1"):
        tailslap.rigid(TRAIN, changes={f"axle.{n}.{key}": 1 for n in (3, 4) for key in ("unit", "position")})


def test_checks_of_a_run_judge_the_motion_in_space():
    """A missing work and an error above verify.mesh fail."""
    from types import SimpleNamespace

    from tailslap.case import case_of
    from tailslap.case.check import evaluated
    from tailslap.case.impact.checks import CHECKS
    from tailslap.scene.read import read_scene

    names = "energy in space", "error in space"
    case: Any = case_of(*read_scene(SCENE))
    motion = case.space.motion

    judged: Any = [CHECKS[name] for name in names]

    def failed(motion: Any) -> list[str]:
        space = replace(case.space, motion=motion)
        outcome: Any = SimpleNamespace(
            fe_plan=SimpleNamespace(case=SimpleNamespace(space=space, scene=case.scene))
        )
        return [check.name for check in evaluated(judged, outcome) if not check.passed]

    assert failed(motion) == []
    assert failed(replace(motion, history=motion.history | {"friction_work": 0.0 * motion.history["t"]})) == [
        names[0]
    ]
    assert failed(replace(motion, other_error=0.03)) == [names[1]]
