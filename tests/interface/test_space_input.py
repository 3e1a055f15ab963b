"""Verify that wrong input of the vehicle in space is refused."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from shared_cases import case
from space_vehicles import truck, truck_unit

import tailslap
from postprocess.signals import occupant
from postprocess.signals.filters import LABELS
from postprocess.units import SYSTEMS, percent_up
from solver import RigidBodyError
from solver.space import SpaceWall, profile_points, solve_space, solve_spaces
from solver.space.wall import face_at
from tailslap.case.case import NO_BAND
from tailslap.case.check import evaluated
from tailslap.case.impact import rigid_motion
from tailslap.case.impact.answers import ImpactAnswer
from tailslap.case.impact.checks import CHECKS
from tailslap.case.impact.rigid_input import above_wall, touching, wall_contact
from tailslap.case.impact.space.answer import SpaceAnswer
from tailslap.case.impact.space.input import space_input
from tailslap.case.of_arguments import case_of_scene
from tailslap.scene.read import read_scene

SCENE, TRAIN = "impact-tipping-tl4-sut", "examples/train-in-space.toml"


def test_a_strip_at_the_rear_may_be_in_other_units():
    """The length of 393.7007 in is 2 um short of 10 m."""
    strikes = tailslap.rigid(SCENE, {"vehicle.length": "393.7007 in"}, band=False).summary["strikes"]
    assert "rear" in {strike["corner"] for strike in strikes}


@pytest.mark.parametrize(("speed", "angle", "end", "law", "key"), [
    (-1.0, 0.26, None, {}, "speed"), (25.0, -0.1, None, {}, "angle"), (25.0, math.nan, None, {}, "angle"),
    (25.0, 0.26, -1.0, {}, "end"), (25.0, 0.26, None, {"restitution": 3.0}, "strip.0.restitution"),
    (25.0, 0.26, None, {"initial_force": 1e6}, "strip.0.plateau"),
    (25.0, 0.26, None, {"restitution": 0.0, "unloading": 1e5}, "strip.0.unloading"),
])  # fmt: skip
def test_python_refuses_what_a_scene_refuses(speed, angle, end, law, key):
    first, *others = truck().strips
    vehicle = replace(truck(), strips=(replace(first, **law), *others))
    with pytest.raises(RigidBodyError) as caught:
        solve_space(vehicle, SpaceWall(0.9), speed, angle, end=end)
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


def test_initial_force_of_a_strip_reaches_the_vehicle():
    strips = space_input(read_scene(SCENE, ["strip.1.initial_force=40 kN/m"])[0]).vehicle.strips
    assert [strip.initial_force for strip in strips] == [40e3 * (k == 1) for k in range(len(strips))]


def test_results_have_the_keys_of_the_interface():
    space = case(SCENE).rigid_numbers()["space"]
    assert space["outcome"] in ("upright", "on its side", "over the wall", "undecided")
    assert space["step_error"] + space["strip_error"] <= space["error"]
    assert space["force"]["heights"][0] == space["force"]["height"]
    assert 2e-3 <= space["lowest_wall_error"] < 0.05
    assert {"raw", "mean_50ms", "height", "length"} <= set(space["force"])
    assert 0.1 <= space["lowest_wall"] <= 0.914
    assert 0.0 < space["largest_roll"] < math.pi / 2


@pytest.mark.parametrize("scene", [SCENE, TRAIN])
def test_a_vehicle_in_space_is_solved_in_space_alone(scene, monkeypatch):
    """Strikes, forces, end, history, drawing and row are of that motion."""
    monkeypatch.setattr(rigid_motion, "_solved", None)
    result = tailslap.rigid(scene, {"plate": None}, band=False)
    one: Any = case_of_scene(scene, {"plate": None})
    space, summary = one.space, result.summary
    assert ("error" in summary, len(summary.get("hinges", []))) == (False, len(one.scene.trailer))
    assert summary["strikes"] == summary["space"]["strikes"]
    impulse = sum(strike["impulse"] for strike in summary["strikes"])
    assert impulse == pytest.approx(5e-4 * one.answer.history["force_normal"].sum(), rel=2e-3)
    assert result.tables["Strikes"].rows[0]["title"] == "1 front"
    lines, impulses = one.rigid_text(), np.array([strike["impulse"] for strike in summary["strikes"]])
    light = int((impulses < 0.05 * impulses.max()).sum())
    assert light > 0
    assert f"  {light} lighter, below 5 % of the largest impulse: --json" in lines
    assert sum(" s: peak" in line for line in lines) == len(impulses) - light
    assert summary["peaks"] == {name: curve.max() for name, curve in space.curves["lateral"].items()}
    assert summary["peaks"]["mean_50ms"] == pytest.approx(float(space.motion.answers.mean_50ms), rel=1e-3)
    assert set(LABELS) == set(summary["peaks"])
    h = space.motion.history
    assert abs(summary["end"]["t"] - h["t"][-1]) < 1.1e-3
    for name, column, sign in (("theta", "yaw", -1.0), ("omega", "omega_z", 1.0), ("v_gx", "v_gx", 1.0)):
        assert summary["end"][name] == pytest.approx(sign * h[column][-1], rel=5e-3, abs=5e-4)
    assert {"roll", "theta", "force_normal_mean_50ms"} <= set(one.rigid_history())
    assert "parallel to the wall, after" in SYSTEMS["si"].rendered(result.charts["set-up"].caption)
    for words in ("plane", "Tyres"):
        assert words not in result.text
    assert ("Hinges" in result.text) == bool(one.scene.trailer)
    assert f"60 Hz cut-off: lateral {1e-3 * summary['peaks']['cutoff_60hz']:.0f}" in " ".join(
        result.text.split()
    )
    assert set(one.row(None)) <= {"status", "reason", *one.columns(one.scene)}
    hinges = {name for name in one.row(None) if "hinge" in name}
    assert hinges == {name for name in one.columns(one.scene) if "hinge" in name}
    assert len(hinges) == 3 * len(one.scene.trailer)


@pytest.mark.parametrize("scene", [SCENE, TRAIN])
def test_a_row_at_half_the_interval_is_of_the_same_motion(scene):
    """The mean of two rows is one of the motion."""
    h, fine = case(scene).space.motion.history, case(scene).answer.history
    assert fine["t"][1] == pytest.approx(0.5 * h["t"][1])
    pairs = fine["force_normal"][1 : 1 + (len(fine["t"]) - 1) // 2 * 2].reshape(-1, 2)
    assert pairs.mean(axis=1) == pytest.approx(h["force_normal"][1 : 1 + len(pairs)], abs=1e-6)


HELD = {
    "body.roll_inertia": 1e14,
    "body.pitch_inertia": 1e14,
    "axle.0.friction": 0.0,
    "axle.1.friction": 0.0,
    "strip": [{"at": at, "height": [0.4, 0.9], "stiffness": 4e6, "plateau": 7e5} for at in (0.0, 10.0)],
}
"""Changes by which a vehicle neither rolls nor pitches, without side forces of tyres."""


def test_a_held_vehicle_has_the_values_of_its_companion():
    """Forces, occupant values and the second strike of both motions are equal."""
    one: Any = case_of_scene(SCENE, HELD)
    space, plane = one.answer, one.in_plane
    assert space.in_space
    assert not plane.in_space
    for name in ("mean_50ms", "cfc60"):
        assert space.peaks[name] == pytest.approx(plane.peaks[name], rel=2e-3)
    pairs = zip(space.occupant_risk(1.0), plane.occupant_risk(one.vehicle.mass), strict=True)
    for measure, planar in pairs:
        assert measure.name == planar.name
        assert measure.value == pytest.approx(planar.value, rel=5e-3, abs=1e-3), measure.name
    assert space.second_strike["cfc60"] == pytest.approx(plane.second_strike["cfc60"], rel=0.02)


def test_accelerations_in_space_are_along_the_axes_of_the_body(monkeypatch):
    """Yaw, then pitch nose down, then roll to the right."""
    t = np.linspace(0.0, 0.5, 1001)
    angles = np.array([0.3 * t, 0.2 * np.sin(9.0 * t), 0.9 * np.sin(5.0 * t)])
    speeds = np.array([20.0 - 9.0 * t, np.sin(7.0 * t), 0.5 * np.cos(6.0 * t)])
    names = "yaw", "pitch", "roll", "v_gx", "v_gy", "v_gz"
    history = {"t": t, "omega": 0.3 + 0.0 * t, **dict(zip(names, [*angles, *speeds], strict=True))}
    seen: list[Any] = []
    monkeypatch.setattr(occupant, "occupant_risk", seen.append)
    ImpactAnswer((), history).occupant_risk(1.0)
    (motion,) = seen
    (cy, cp, cr), (sy, sp, sr) = np.cos(angles[:, 1:]), np.sin(angles[:, 1:])
    zero, one = 0.0 * cy, 0.0 * cy + 1.0
    yaw = np.array([[cy, sy, zero], [-sy, cy, zero], [zero, zero, one]])
    pitch = np.array([[cp, zero, -sp], [zero, one, zero], [sp, zero, cp]])
    roll = np.array([[one, zero, zero], [zero, cr, sr], [zero, -sr, cr]])
    turned = np.einsum("ijt,jkt,klt,lt->it", roll, pitch, yaw, np.diff(speeds) / t[1])
    assert np.array([motion.ax, motion.ay, motion.az]) == pytest.approx(turned, abs=1e-9)
    assert motion.yaw == pytest.approx(0.3 * t[1:])


def test_a_run_names_the_companion_and_has_occupant_values_in_space(tmp_path):
    """The plate's motion is named, the headline in space."""
    changes = {"plate.elements": [8, 2], "verify.companion": False}
    result = tailslap.run(SCENE, changes, band=False)
    summary = result.summary
    risk = [measure.value for measure in case(SCENE).answer.occupant_risk(1.0)]
    assert [measure["value"] for measure in summary["occupant_risk"]] == risk
    assert [strike["corner"] for strike in summary["rigid"]["strikes"]] == ["front", "7.2 m"]
    assert {strike["corner"] for strike in summary["space"]["strikes"]} > {"front", "7.2 m", "2.6 to 10 m"}
    assert {row["model"] for row in result.tables["Strikes"].rows} == {"in space"}
    assert summary["answer"] == case(SCENE).headline(NO_BAND).in_units(SYSTEMS["si"]).answer
    assert "Companion in the plane: the same strips without heights" in summary["certainty"]
    assert summary["paper_method"] == case(SCENE).rigid_numbers()["paper_method"]
    result.save(tmp_path / "out", pictures=False)
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "Occupant risk, in space" in page
    assert "Occupant risk, planar" not in page
    for words in (
        "Strikes, companion in the plane",
        "Companion in the plane: the same strips without heights",
        "above the wall omitted",
        "Companion in the plane, 50",
        "For the design", "In space, largest moment", "Inertial estimate, assumed place",
        "Impact severity", "Strip of the body",
        "the scene has no wall.depth", "needs a road as wide, which the scene does not state",
    ):  # fmt: skip
        assert words in page
    space = summary["space"]
    assert space["lacking"] == ["wall.depth", "width of the road"]
    force, moment = space["force"], space["moment"]
    assert moment["mean_50ms"] >= force["mean_50ms"] * force["height"]
    assert summary["design_forces"][0]["ratio"] == pytest.approx(
        force["mean_50ms"] / 355.86e3, rel=1e-4
    )  # TTI
    assert moment["force"] * moment["height"] == pytest.approx(moment["mean_50ms"])
    assert {row["strip"] for row in space["intrusion"]} == {2, 3, 4}
    assert space["working_width"] == max(row["intrusion"] for row in space["intrusion"])  # of an upright face
    texts = tailslap.check(SCENE).summary
    assert texts["companion"][0].startswith("Companion in the plane: ")
    assert "companion" not in tailslap.check(SCENE, {"plate": None}).summary
    assert "companion" not in tailslap.check("impact-mash-tl4-sut").summary


def test_strips_over_the_wall_are_no_part_of_the_plane():
    """Only a unit that has no others keeps those."""
    scene = read_scene(SCENE)[0]
    assert above_wall(scene) == [2, 3, 4]
    assert [part.number for part in touching(scene)] == [0, 1]
    assert len(wall_contact(scene).strips) == 2
    assert len(wall_contact(read_scene(SCENE, ["wall.height=54 in"])[0]).strips) == 5
    for height, above in (("49 in", []), ("1.24 m", [2, 3, 4])):
        assert above_wall(read_scene(SCENE, [f"wall.height={height}"])[0]) == above
    train = read_scene(TRAIN, ["wall.height=0.8 m"])[0]
    assert {strip.unit for strip in wall_contact(train).strips} == {0, 1}


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
    words, space = SYSTEMS["si"].rendered(str(case(SCENE).headline())), case(SCENE).space
    assert f"Rigid vehicle in space; {SYSTEMS['si'].rendered(space.accuracy)}.'" in words
    assert percent_up(space.motion.error) in space.accuracy


@pytest.fixture(scope="module")
def train():
    """Return the result of the train of the examples."""
    return case(TRAIN).rigid_numbers()["space"]


def test_each_unit_of_a_train_rolls(train):
    """Both units roll, and the stated roll is the larger."""
    rolls = np.abs(train["unit_rolls"])
    assert rolls.shape == (2,)
    assert abs(train["largest_roll"]) == rolls.max()
    assert rolls.min() > 0.2 * rolls.max()


def test_stiffness_of_the_fifth_wheel_joins_the_rolls(train):
    """Without stiffness the tractor is level, and the trailer rolls more."""
    loose = case(TRAIN, "trailer.0.roll_stiffness=0").rigid_numbers()["space"]
    assert abs(loose["unit_rolls"][0]) < abs(train["unit_rolls"][0])
    assert abs(loose["unit_rolls"][1]) > abs(train["unit_rolls"][1])


def test_checks_of_a_run_judge_the_motion_in_space():
    """A missing work and an error above verify.mesh fail."""
    names, one = ("energy in space", "error in space"), case(SCENE)
    motion = one.space.motion
    judged: Any = [CHECKS[name] for name in names]

    def failed(motion: Any) -> list[str]:
        judged_case = SimpleNamespace(space=replace(one.space, motion=motion), scene=one.scene)
        outcome: Any = SimpleNamespace(fe_plan=SimpleNamespace(case=judged_case))
        return [check.name for check in evaluated(judged, outcome) if not check.passed]

    assert failed(motion) == []
    assert failed(replace(motion, history=motion.history | {"friction_work": 0.0 * motion.history["t"]})) == [
        names[0]
    ]
    assert failed(replace(motion, other_error=0.03)) == [names[1]]


def test_a_sweep_in_space_shows_its_force(tmp_path):
    """Rows and charts have the force of the motion in space."""
    swept = tailslap.sweep(
        SCENE, {"wall.height": [0.8, 0.9144]}, changes={"plate": None}, folder=tmp_path / "out"
    )
    table, force = swept.histories["table"], "rigid.peaks.mean_50ms"
    assert table[force][1] == case(SCENE).answer.peaks["mean_50ms"]
    assert (table["rigid.strike_1.corner"][1], table["rigid.strikes"][1] > 2) == ("front", True)
