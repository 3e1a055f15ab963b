"""Verify whole impacts by the FE plate against the rigid vehicle."""

import dataclasses
import functools
import json
import math
import re

import numpy as np
import pytest
from shared_cases import LINEAR_TRUCK

import tailslap
from postprocess.units import SI, percent_up
from tailslap import cli, errors
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact import (
    answers,
    checks,
    error,
    figures,
    paper_method,
    report,
    report_tables,
    run,
    strike_columns,
)
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.read import read_scene

LINEAR = ("plate.elements=[20, 6]",)
"""A given mesh of linear elements, on which the forces of corners act at nodes."""


def planned(*changes, scene=LINEAR_TRUCK):
    return ImpactCase(*read_scene(scene, changes))


@functools.cache
def ran(*changes):
    """Run once, without the second run for the mesh's error."""
    return run.attempt(planned(*changes))


@functools.cache
def shipped():
    return planned().run()


def test_a_plate_that_bends_like_a_truck_passes_its_checks():
    """A plate of 8 Hz strikes longer, on the same plateau."""
    outcome = planned(scene="impact-flexible-tl4-sut").run()
    assert [check.name for check in outcome.checks if not check.passed] == []
    text = " ".join(report.ImpactReport(outcome).headline.in_units(SI).lines)
    frequency = re.search(r"first natural frequency (\S+) Hz", text)
    assert frequency
    assert float(frequency[1]) == pytest.approx(8.0, rel=1e-2)
    assert outcome.fe.strikes[1].duration > 1.4 * outcome.rigid.strikes[1].duration
    assert max(strike.peak_force for strike in outcome.fe.strikes) < 1.005 * 350e3


def test_the_shipped_impact_passes_its_checks():
    outcome = shipped()
    assert [check.name for check in outcome.checks if not check.passed] == []
    assert [strike.corner for strike in outcome.fe.strikes] == ["front", "rear", "front"]


@pytest.mark.parametrize(("mesh", "moduli"), [(LINEAR, ("2e11", "8e11", "3.2e12")), ((), ("8e11", "3.2e12"))])
def test_a_stiff_plate_tends_to_the_rigid_vehicle(mesh, moduli):
    """The difference is in proportion to 1/E, and vanishes in the limit."""
    by_modulus = [ran(f"plate.youngs_modulus={modulus}", *mesh).difference for modulus in moduli]
    for name, difference in by_modulus[0].items():
        assert abs(difference) < 0.0075, name  # 0.6 % but for the rear strike's duration
        if "peak" not in name:
            assert by_modulus[1][name] / difference == pytest.approx(0.25, rel=0.1), name
        stiff, stiffer = (differences[name] for differences in by_modulus[-2:])
        assert abs(4.0 * stiffer - stiff) / 3.0 < 1e-4, name


def test_published_trial_at_8_hz():
    """The rear strike at 8 Hz has 43 % more impulse."""
    outcome = ran("plate.first_frequency=8 Hz", "plate.youngs_modulus=", *LINEAR)
    front, rear = outcome.fe.strikes[:2]
    assert (front.peak_force / 1e3, front.impulse / 1e3) == pytest.approx((469.1, 30.79), rel=1e-3)
    assert (rear.peak_force / 1e3, rear.impulse / 1e3) == pytest.approx((453.2, 38.23), rel=1e-3)
    assert outcome.difference["strike_2.impulse"] == pytest.approx(0.43, abs=0.005)


CORNERS = "{at='0 m', stiffness='2 MN/m', initial_force='20 kN'}, {at='10 m', stiffness='2 MN/m'}"
WHEELS = (
    "{at='0.6 m', stiffness='2 MN/m'}, {at='7.2 m', stiffness='3 MN/m', inset='0.1 m'}, "
    "{at='9.4 m', stiffness='1 MN/m'}"
)
CASES = {
    "as shipped": (),
    "layer": ("contact.stiffness=", f"strip=[{CORNERS}, {{at=['0 m', '10 m'], stiffness='0.2 MN/m^2'}}]"),
    "wheels": ("contact.stiffness=", f"strip=[{WHEELS}]"),
    "damped": ("damping.ratio=0.05",), "elastic": ("contact.restitution=1",),
    "plastic": ("contact.restitution=0",), "stuck": ("contact.friction=2", "impact.angle=60 deg"),
    "plastic from a force on": ("contact.restitution=0", "contact.initial_force=50 kN"),
    "smooth": ("contact.friction=0",),
    "own inertia": ("vehicle.centre_of_mass=4.2 m", "vehicle.yaw_inertia=75000 kg m^2"),
    "penalty": ("contact.stiffness=", "contact.restitution=", "time.end=0.3"),
    "exact": ("contact.stiffness=", "contact.restitution=", "contact.enforcement=exact", "time.end=0.3"),
}  # fmt: skip


COMPILED_APART = {"layer", "damped", "penalty", "exact"}
"""Cases with a compiled loop of their own."""


@pytest.mark.parametrize(
    "case", [pytest.param(c, marks=pytest.mark.long) if c in COMPILED_APART else c for c in CASES]
)
def test_conservation(case):
    outcome = ran(*CASES[case])
    h, mass, touch = outcome.run.history, outcome.fe_plan.model.mass, outcome.fe_plan.case.touch
    energy = 0.5 * mass * (touch.v_gx**2 + touch.v_gy**2)
    assert np.abs(mass * (h["v_gy"] - touch.v_gy) - h["normal_impulse"]).max() < 1e-12 * mass * 25.0
    assert np.abs(mass * (h["v_gx"] - touch.v_gx) - h["tangential_impulse"]).max() < 1e-12 * mass * 25.0
    own_momentum = h["angular_momentum"] - h["moment_impulse"]
    assert np.abs(own_momentum - own_momentum[0]).max() < 1e-12 * np.abs(h["angular_momentum"]).max()
    error, lowest = checks.energy_error(outcome), {"exact": -1e-2, "penalty": -5e-4}
    assert error.max() < 1e-4 * energy
    assert error.min() > lowest.get(case, -1e-4) * energy
    normal, friction = outcome.run.normal, outcome.fe_plan.case.scene.needed_contact.friction
    assert normal.min() >= 0.0
    assert (np.abs(outcome.run.tangential) <= (friction + 1e-12) * normal + 1e-9 * normal.max()).all()
    forces = outcome.fe.history["force_normal"][1:].sum() * outcome.fe.interval
    assert forces == pytest.approx(h["normal_impulse"][-1] - h["normal_impulse"][0], rel=1e-12)


@pytest.mark.parametrize("case", ["own inertia", "stuck"])
def test_other_vehicles_and_contacts_agree_with_the_rigid_one(case):
    outcome = ran(*CASES[case], "plate.youngs_modulus=3.2e12")
    assert len(outcome.difference) >= 3
    for name, difference in outcome.difference.items():
        assert abs(difference) < (1e-2 if "duration" in name else 5e-3), name


@pytest.mark.long
def test_a_layer_along_the_side_agrees_with_the_rigid_one():
    """The difference decreases with the mesh."""
    stiff = (*CASES["layer"], "plate.youngs_modulus=3.2e12")
    coarse, fine = ran(*stiff, *LINEAR), ran(*stiff, "plate.elements=[40, 12]")
    expected = ["front", "0 to 10 m", "rear", "0 to 10 m"]
    assert [strike.corner for strike in fine.fe.strikes[:4]] == expected
    assert len(fine.difference) == 6
    for outcome, bound in ((coarse, 7e-3), (fine, 2e-3)):
        assert max(map(abs, outcome.difference.values())) < bound


def test_wheels_inside_the_sides_strike_as_those_of_the_rigid_vehicle():
    """The difference is in proportion to 1/E, and vanishes in the limit."""
    stiff, stiffer = (
        ran(*CASES["wheels"], f"plate.youngs_modulus={modulus}") for modulus in ("8e11", "3.2e12")
    )
    for answer in (stiffer.fe, stiffer.rigid):
        assert [strike.corner for strike in answer.strikes[:3]] == ["0.6 m", "9.4 m", "7.2 m"]
        assert answer.ends == ("0.6 m", "9.4 m")
    starts = [[strike.start for strike in answer.strikes[:3]] for answer in (stiffer.fe, stiffer.rigid)]
    assert starts[0] == pytest.approx(starts[1], abs=1e-3)
    assert len(stiff.difference) == 6
    for name, difference in stiff.difference.items():
        assert abs(4.0 * stiffer.difference[name] - difference) / 3.0 < 1e-4, name
    loops, along = figures.contact_figures(stiff)
    assert [line.label for line in loops[0].plots[0].marks] == ["0.6 m", "7.2 m", "9.4 m"]
    assert along == []


BAD = {
    "corner.friction=0.2": "corner", "contact.restitution=1.01": "contact.restitution",
    "contact.stiffness=-1": "contact.stiffness", "contact.initial_force=-1": "contact.initial_force",
    "contact.friction=-0.1": "contact.friction", "contact.enforcement=exact": "contact.enforcement",
    "verify.tolerance=0.1": "verify.tolerance",
    "contact.stiffness=": "contact.restitution", "contact.restitution=": "contact.restitution",
    "vehicle.centre_of_mass=10.5 m": "vehicle.centre_of_mass",
    "vehicle.yaw_inertia=300000 kg m^2": "vehicle.yaw_inertia", "impact.speed=0": "impact.speed",
    "impact.angle=90 deg": "impact.angle", "impact.convention=paper": "impact.convention",
    "plate.density=7800": "plate.density", "plate.start=unstressed": "plate.start",
    "start.omega=0.7": "start", "time.end=0": "time.end",
    "contact.patch_length=20 m": "contact.patch_length",
}  # fmt: skip


@pytest.mark.parametrize("change", BAD)
def test_bad_input_names_its_key(change, refused):
    assert refused(ran, change) == BAD[change]


@pytest.mark.parametrize("change", [
    "vehicle.centre_of_mass=5 m", "vehicle.yaw_inertia=80000 kg m^2", "time.end=1 s", "verify.mesh=0.02",
    "wall.height=1 m",
])  # fmt: skip
def test_keys_of_a_whole_impact_mean_nothing_beside_a_constrained_corner(change):
    with pytest.raises(errors.InputError, match="requires \\[contact\\]"):
        read_scene("mash-tl4-sut", (change,))


def test_a_command_of_the_corner_says_so(capsys):
    assert cli._status(["modal", LINEAR_TRUCK]) == 2
    assert "contact: given" in capsys.readouterr().err


def test_modes_of_a_whole_impact_are_those_of_its_free_plate():
    """The constrained corner has the same plate, and both have beam theory."""
    mesh = ["plate.element=quad4", *LINEAR]
    impact, corner = (
        tailslap.modes(name, mesh, count=6).summary["modes"] for name in (LINEAR_TRUCK, "mash-tl4-sut")
    )
    for free, held in zip(impact, corner, strict=True):
        assert free["frequency"] == pytest.approx(held["frequency"], rel=1e-9)
        assert (free["kind"], free["theory"]) == (held["kind"], held["theory"])


def test_rigid_prints_what_the_contract_names(capsys):
    assert cli._status(["rigid", LINEAR_TRUCK, "--json", "--set", "plate="]) == 0
    result = json.loads(capsys.readouterr().out)
    assert set(result["strikes"][0]) >= {"corner", "start", "end", "duration", "peak_force", "impulse"}
    assert set(result["peaks"]) == {"raw", "mean_10ms", "mean_50ms", "cfc60", "cfc180", "cutoff_60hz"}
    assert set(result["end"]) == {"t", "theta", "omega", "v_gx", "v_gy"}


def test_without_companions_no_error_is_stated():
    """The same run states no error, and refuses a tolerance."""
    case = planned("verify.companion=false")
    outcome = case.run()
    assert repr(outcome.fe.strikes) == repr(shipped().fe.strikes)  # NaN differs from itself
    assert {check.name for check in shipped().checks} - {check.name for check in outcome.checks} == ERRORS
    assert outcome.passed
    assert math.isnan(case.row(outcome)["numerical_error"])
    assert report.ImpactReport(outcome).headline.certainty.endswith("discretisation error not estimated.")
    assert not report_tables.errors_table(outcome).rows
    with pytest.raises(errors.InputError, match=r"remove verify\.companion"):
        case.run(1e-2)


def test_a_run_leaves_what_the_contract_names(tmp_path, capsys):
    words = ["--no-pictures", "--out", str(tmp_path / "out"), "--tolerance", "1e-2"]
    assert cli._status(["run", LINEAR_TRUCK, *words]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["passed"] is True
    assert {"strikes", "peaks", "end"} <= set(summary["fe"]) & set(summary["rigid"])
    header, *rows = (tmp_path / "out" / "history.csv").read_text().splitlines()
    names = header.split(",")
    assert header.startswith("t,x_g,y_g,theta,omega,v_gx,v_gy,force_normal,force_tangential,")
    table = np.array([list(map(float, row.split(","))) for row in rows])
    assert np.isfinite(table).all()
    interval, force = table[1, 0], table[:, names.index("force_normal")]
    impulses = sum(strike["impulse"] for strike in summary["fe"]["strikes"])
    assert force.sum() * interval == pytest.approx(impulses, rel=1e-6)
    assert "rear" in capsys.readouterr().out


@pytest.mark.parametrize("angle", [12, 13, pytest.param(16, marks=pytest.mark.long)])
def test_a_run_ends_between_strikes_of_plate_and_rigid_vehicle(angle):
    """Compare the third strike, which ended too early at these angles."""
    outcome = ran(f"impact.angle={angle} deg")
    alone = outcome.fe_plan.case.answer
    for answer in (alone, outcome.fe, outcome.rigid):
        assert [strike.corner for strike in answer.strikes] == ["front", "rear", "front"]
        assert not answer.cut
        assert answer.peaks["mean_50ms"] == pytest.approx(alone.peaks["mean_50ms"], rel=5e-3)
        assert answer.strikes[2].impulse == pytest.approx(alone.strikes[2].impulse, rel=0.01)
    sampled = outcome.fe_plan.case.many({"impact.angle": np.array([math.radians(angle)])})
    single = strike_columns.both_strikes(alone)
    for name in strike_columns.COLUMNS:
        assert sampled[name][0] == pytest.approx(single[name], rel=2e-3), name


def test_a_plate_that_strikes_at_the_end_of_the_rigid_vehicle_goes_on(monkeypatch):
    """The run lasts until neither model is in a strike."""
    monkeypatch.setattr("fem.run.impact.CHECK_ROWS", 20)
    case = planned()
    case.__dict__["motion"] = case.motion_until(case.motion.strikes[2].start + 0.01)
    outcome = run.attempt(case)
    third = outcome.fe.strikes[2]
    assert (outcome.fe.cut, outcome.rigid.cut) == ([], [])
    assert outcome.fe.end["t"] == pytest.approx(third.end + third.duration, abs=5e-3)


def test_a_strike_that_the_end_cuts_is_named(tmp_path, capsys):
    """Summary, terminal and page name it, with values as lower bounds."""
    words, cut = ["--set", "time.end=0.46", "--set", "verify.companion=false"], [False, False, True]
    assert (
        cli._status(["run", LINEAR_TRUCK, *words, "--full", "--no-pictures", "--out", str(tmp_path / "out")])
        == 0
    )
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    for model in ("fe", "rigid"):
        assert [strike["cut"] for strike in summary[model]["strikes"]] == cut
    (remark,) = summary["remarks"]
    assert remark.startswith("Strike 3 (front corner) continues beyond the end at 0.46")
    assert remark.endswith("are lower bounds.")
    terminal = capsys.readouterr().out
    assert terminal.count("3 front (cut)") == 2
    assert "at least 49" in terminal
    page = (tmp_path / "out" / "report.html").read_text().replace("\xa0", " ")
    assert page.count("front (cut)") == 2
    assert remark in page
    assert cli._status(["rigid", LINEAR_TRUCK, *words]) == 0
    terminal = capsys.readouterr().out
    assert "for at least 0.0140 s: peak at least" in terminal
    assert "Strike 3 (front corner) continues beyond the end at 0.46 s" in " ".join(terminal.split())
    row = planned("time.end=0.46").row(None)
    assert (row["rigid.strikes"], row["rigid.strikes_cut"]) == (3, 1)


def test_values_of_a_cut_history_are_lower_bounds():
    """No filtered value exceeds that of the whole impact."""
    complete = planned().answer
    for end in np.linspace(0.447, 0.479, 9):
        cut = planned(f"time.end={end}").answer
        assert cut.cut == [3]
        for name, peak in cut.peaks.items():
            assert peak <= complete.peaks[name] * (1.0 + 1e-4), name
        largest = answers.mean_peak(complete, complete.strikes[2])
        assert answers.mean_peak(cut, cut.strikes[2]) <= largest * (1.0 + 1e-4)


def test_another_mesh_is_run_until_its_strikes_are_over(monkeypatch):
    """An assessed strike is completed there."""
    outcome, plate = ran(), ran().fe_plan.plate.model_copy(update={"elements": (10, 3)})
    rear = outcome.fe.strikes[1]
    monkeypatch.setattr(error, "judged_until", lambda answer: rear.end - 0.01)
    repeated = run._on(outcome, plate, {})
    assert not repeated.strikes[1].cut
    assert repeated.strikes[1].impulse == pytest.approx(rear.impulse, rel=0.02)
    short = dataclasses.replace(outcome, fe=ran("time.end=0.34").fe)
    assert run._on(short, plate, {}).strikes[1].cut


def test_what_is_not_known_of_a_strike_is_left_out():
    numbers = answers.strike_numbers(shipped().fe.strikes[0])
    assert "friction_work" not in numbers
    assert all(not isinstance(value, float) or math.isfinite(value) for value in numbers.values())


def test_hops_of_a_plate_leave_the_impulse_of_a_strike_whole():
    """Four meshes agree where the stiff rear corner rebounds repeatedly.

    Without restitution the mesh opens and closes gaps between rebounds: the impulse was 23 % off.
    """
    stiff = ("contact.restitution=0", "plate.youngs_modulus=1.26 TPa")
    meshes = ((), LINEAR, ("plate.elements=[40, 12]",), (*LINEAR, "plate.element=quad9"))
    impulses = [ran(*stiff, *mesh).fe.strikes[1].impulse for mesh in meshes]
    assert max(impulses) / min(impulses) < 1.02
    assert impulses[0] == pytest.approx(ran(*stiff).rigid.strikes[1].impulse, rel=0.03)


ERRORS = {checks.MESH_CHECKS[name] for name in error.QUANTITIES}


def test_the_papers_method_stands_beside():
    """The impulse equals that of the same truck with a constrained corner."""
    outcome = shipped()
    beside = paper_method.paper_method(outcome.fe_plan.case.scene, outcome.rigid)
    corner = CornerCase(*read_scene("mash-tl4-sut"))
    assert beside is not None
    assert beside["impulse"] == pytest.approx(float(corner.force.impulse), rel=1e-12)
    assert beside["peak_force"] == pytest.approx(2.0 * beside["impulse"] / 0.1, rel=1e-12)
    computed = 2.0 * beside["impulse"] / beside["computed_duration"]
    assert beside["computed_peak_force"] == pytest.approx(computed)
    without = planned("impact.friction=", "impact.restitution=")
    assert paper_method.paper_method(without.scene, outcome.rigid) is None


WALL = {
    "wall.length": "36 m", "wall.depth": "0.3 m", "wall.height": "1 m", "wall.elements": "[60,1]",
    "wall.foundation_stiffness": "100 MN/m^2",
}  # fmt: skip


@pytest.mark.long
def test_a_wall_that_gives_deflects_and_its_foundation_carries_the_force():
    """The foundation carries the contact force except the inertia of the wall."""
    outcome = ran(*(f"{key}={value}" for key, value in WALL.items()))
    h, wall = outcome.run.history, report_tables.wall_numbers(outcome)
    assert wall is not None
    assert 2e-3 < wall["deflection"] < 6e-3  # of the size of the peak force over 2 k'/b, 3.3 mm
    assert h["foundation_impulse"][-1] == pytest.approx(h["normal_impulse"][-1], rel=0.05)
    initial = 0.5 * outcome.fe_plan.model.mass * 25.034**2
    assert np.abs(checks.energy_error(outcome)).max() < 1e-4 * initial


def test_a_wall_that_is_too_short_or_lacks_a_key_is_refused(refused):
    for key in ("wall.height", "wall.foundation_stiffness"):
        assert refused(planned, *(f"{name}={value}" for name, value in WALL.items() if name != key)) == key


def test_the_headline_says_of_which_strikes_the_difference_is():
    heavy, light = (
        report.ImpactReport(of).headline for of in (shipped(), planned("vehicle.width=10.0").run())
    )
    assert heavy.certainty.startswith("Vehicle flexibility changes the impulses by at most ")
    text = "Vehicle flexibility changes the impulses of strikes above 5 % of the largest by at most 0.06"
    assert light.certainty.startswith(text)
    by_strike = error.of_weight(shipped().difference, shipped().fe.strikes)
    longest = max(abs(value) for key, value in by_strike.items() if key.endswith("duration"))
    assert f", durations by {percent_up(longest)}, peak forces by " in heavy.certainty
