"""Whole impacts by the FE plate against the rigid vehicle: limits, conservation, filters, bad input, the
commands; checks of a whole impact: a force on a node of a soft plate has no limit; a vibration's phase.
"""

import functools
import json
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tailslap import cli, errors
from tailslap.case.case import evaluated
from tailslap.case.corner.case import CornerCase
from tailslap.case.impact import answers, checks, report, rigid, run
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.checks import CHECKS, FLOOR, FRACTION, MODAL_FRACTION, WEDGE, unknown_by_vibration
from tailslap.scene.read import read_scene

SCENE = "impact-mash-tl4-sut"


def planned(*changes, scene=SCENE):
    return ImpactCase(*read_scene(scene, changes))


@functools.cache
def ran(*changes):
    """One run, without the second one that tells the mesh's error."""
    return run.attempt(planned(*changes))


@functools.cache
def whole():
    return planned().run()


def test_the_shipped_impact_passes_its_checks():
    outcome = whole()
    assert [check.name for check in outcome.checks if not check.passed] == []
    assert [strike.corner for strike in outcome.fe.strikes] == ["front", "rear", "front"]


def test_a_stiff_plate_is_near_the_rigid_vehicle_and_nearer_the_stiffer_it_is():
    """Flexibility goes with 1/E: at four times the modulus a quarter is left, and the limit is the rigid vehicle's."""
    soft, stiff, stiffer = (ran(f"plate.youngs_modulus={modulus}") for modulus in ("2e11", "8e11", "3.2e12"))
    for name, difference in soft.difference.items():
        assert abs(difference) < 0.0075, name  # 0.6 % but for the rear strike's duration
        if "peak" not in name:
            assert stiff.difference[name] / difference == pytest.approx(0.25, rel=0.1), name
        limit = (4.0 * stiffer.difference[name] - stiff.difference[name]) / 3.0
        assert abs(limit) < 1e-4, name


def test_published_trial_at_8_hz():
    """The rear strike of a plate of 8 Hz brings 43 % more impulse (shared rough trial, the corners one node each)."""
    outcome = ran("plate.first_frequency=8 Hz", "plate.youngs_modulus=")
    front, rear = outcome.fe.strikes[:2]
    assert (front.peak_force / 1e3, front.impulse / 1e3) == pytest.approx((469.1, 30.79), rel=1e-3)
    assert (rear.peak_force / 1e3, rear.impulse / 1e3) == pytest.approx((453.2, 38.23), rel=1e-3)
    assert outcome.difference["strike_2.impulse"] == pytest.approx(0.43, abs=0.005)


CASES = {
    "as shipped": (), "layer": ("contact.side_stiffness=0.2 MN/m^2", "contact.initial_force=20 kN"),
    "damped": ("damping.ratio=0.05",), "elastic": ("contact.restitution=1",),
    "plastic": ("contact.restitution=0",), "stuck": ("contact.friction=2", "impact.angle=60 deg"),
    "own inertia": ("vehicle.centre_of_mass=4.2 m", "vehicle.yaw_inertia=75000 kg m^2"),
    "penalty": ("contact.stiffness=", "contact.restitution=", "time.end=0.3"),
    "exact": ("contact.stiffness=", "contact.restitution=", "contact.enforcement=exact", "time.end=0.3"),
}  # fmt: skip


COMPILED_APART = {"layer", "damped", "penalty", "exact"}
"""Cases whose loop is compiled for itself."""


@pytest.mark.parametrize(
    "case", [pytest.param(c, marks=pytest.mark.long) if c in COMPILED_APART else c for c in CASES]
)
def test_conservation(case):
    outcome = ran(*CASES[case])
    h, mass, touch = outcome.run.history, outcome.fe_plan.model.mass, outcome.fe_plan.case.touch
    energy = 0.5 * mass * (touch.v_gx**2 + touch.v_gy**2)
    assert np.abs(mass * (h["v_gy"] - touch.v_gy) - h["normal_impulse"]).max() < 1e-9 * mass * 25.0
    assert np.abs(mass * (h["v_gx"] - touch.v_gx) - h["tangential_impulse"]).max() < 1e-9 * mass * 25.0
    turned = h["angular_momentum"] - h["moment_impulse"]
    assert np.abs(turned - turned[0]).max() < 1e-9 * np.abs(h["angular_momentum"]).max()
    assert checks.energy_error(outcome).max() < 1e-4 * energy
    assert (
        checks.energy_error(outcome).min()
        > (-1e-2 if case == "exact" else -5e-4 if case == "penalty" else -1e-4) * energy
    )
    assert outcome.run.normal.min() >= 0.0
    forces = outcome.fe.history["force_normal"][1:].sum() * outcome.fe.interval
    assert forces == pytest.approx(h["normal_impulse"][-1] - h["normal_impulse"][0], rel=1e-12)


@pytest.mark.parametrize("case", ["own inertia", "stuck"])
def test_other_vehicles_and_contacts_agree_with_the_rigid_one(case):
    outcome = ran(*CASES[case], "plate.youngs_modulus=3.2e12")
    assert len(outcome.difference) >= 3
    for name, difference in outcome.difference.items():
        assert abs(difference) < (1e-2 if "duration" in name else 5e-3), name


@pytest.mark.long
def test_a_layer_along_the_side_agrees_with_the_rigid_one_in_the_limit_of_fine_meshes():
    """A node stands for the layer beside it, so that the error goes with the element's length; flat against the wall
    the vehicle is shared by both corners, and a strike lasts until it is off."""
    stiff = (*CASES["layer"], "plate.youngs_modulus=3.2e12")
    coarse, fine = ran(*stiff).difference, ran(*stiff, "plate.elements=[40, 12]").difference
    assert len(coarse) == 6
    for name, difference in coarse.items():
        limit = 2.0 * fine[name] - difference
        assert abs(limit) < (1e-2 if "duration" in name else 5e-3), name
        assert abs(fine[name]) < max(0.6 * abs(difference), 2e-3), name


def test_momentum_of_the_end_follows_from_the_strikes():
    """Impulses of all strikes are the change of momentum across the wall."""
    for answer in (whole().fe, whole().rigid):
        total = sum(strike.impulse for strike in answer.strikes)
        gained = whole().fe_plan.model.mass * (answer.end["v_gy"] - whole().fe_plan.case.touch.v_gy)
        assert total == pytest.approx(gained, rel=1e-6)


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


@pytest.mark.parametrize(
    "change",
    ["vehicle.centre_of_mass=5 m", "vehicle.yaw_inertia=80000 kg m^2", "time.end=1 s", "verify.mesh=0.02"],
)
def test_keys_of_a_whole_impact_mean_nothing_beside_a_constrained_corner(change):
    with pytest.raises(errors.InputError, match="belongs to a whole impact"):
        read_scene("mash-tl4-sut", (change,))


@pytest.mark.parametrize("command", ["modal", "modes"])
def test_commands_of_the_corner_say_so(command, capsys):
    assert cli._status([command, SCENE]) == 2
    assert "contact: given" in capsys.readouterr().err


def test_rigid_prints_what_the_contract_names(capsys):
    assert cli._status(["rigid", SCENE, "--json", "--set", "plate="]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["strikes"][0]) >= {"corner", "start", "end", "duration", "peak_force", "impulse"}
    assert set(found["peaks"]) == {"raw", "mean_50ms", "cfc60", "cfc180", "cutoff_60hz"}
    assert set(found["end"]) == {"t", "theta", "omega", "v_gx", "v_gy"}


def test_without_companions_no_error_is_stated():
    """The same run; a tolerance cannot be sought then."""
    case = planned("verify.companion=false")
    outcome = case.run()
    assert outcome.fe.strikes == whole().fe.strikes
    assert {check.name for check in whole().checks} - {check.name for check in outcome.checks} >= {"mesh"}
    assert outcome.passed
    assert math.isnan(case.row(outcome)["numerical_error"])
    assert "not stated" in report.headline(outcome)
    with pytest.raises(errors.InputError, match=r"leave verify\.companion out"):
        case.run(1e-2)


def test_a_run_leaves_what_the_contract_names(tmp_path, capsys):
    assert (
        cli._status(["run", SCENE, "--no-pictures", "--out", str(tmp_path / "out"), "--tolerance", "2e-3"])
        == 0
    )
    summary: dict[str, Any] = json.loads((tmp_path / "out" / "summary.json").read_text())
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


def test_what_is_not_known_of_a_strike_is_left_out():
    numbers = answers.strike_numbers(whole().fe.strikes[0])
    assert "friction_work" not in numbers
    assert all(not isinstance(value, float) or math.isfinite(value) for value in numbers.values())


def test_hops_of_a_plate_leave_the_impulse_of_a_strike_whole():
    """Without restitution the stiff plate's rear corner hops; where the mesh opens and closes gaps between hops, the
    impulse was 23 % off. One strike by any mesh, and near the rigid vehicle's."""
    stiff = ("contact.restitution=0", "plate.youngs_modulus=1.26 TPa")
    meshes = ((), ("plate.elements=[40, 12]",), ("plate.element=quad9",))
    impulses = [ran(*stiff, *mesh).fe.strikes[1].impulse for mesh in meshes]
    assert max(impulses) / min(impulses) < 1.02
    assert impulses[0] == pytest.approx(ran(*stiff).rigid.strikes[1].impulse, rel=0.03)


def judged(impulse, duration, error):
    """What the checks of the mesh say of so large differences from the rigid vehicle, and errors."""
    difference = {"strike_1.impulse": impulse, "strike_2.duration": duration}
    scene = SimpleNamespace(verify=SimpleNamespace(companion=True))
    fe_plan = SimpleNamespace(case=SimpleNamespace(scene=scene))
    outcome = SimpleNamespace(difference=difference, mesh_error=error, fe_plan=fe_plan)
    kinds = [kind for kind in checks.CHECKS if kind.name in checks.MESH_CHECKS[:2]]
    return {check.name: check.passed for check in evaluated(kinds, outcome)}


@pytest.mark.parametrize(
    ("impulse", "duration", "error", "fails"),
    [
        (0.0, 0.0, {"strike_1.impulse": 0.0019, "strike_1.duration": 0.0019}, set()),
        (0.0, 0.0, {"strike_2.peak_force": -0.0021, "strike_1.duration": 0.0}, {"mesh"}),
        (0.1, 0.1, {"strike_1.impulse": 0.0119, "strike_2.duration": -0.0119}, set()),
        (0.1, 9.0, {"strike_1.impulse": 0.0121, "strike_2.duration": 0.05}, {"mesh"}),  # no excuse
        (9.0, 0.1, {"strike_1.impulse": 0.0519, "strike_2.duration": 0.0121}, {"mesh for durations"}),
        (9.0, 9.0, {"strike_1.impulse": 0.0521, "strike_2.duration": 0.0521}, {"mesh", "mesh for durations"}),
        (0.1, 0.1, {}, {"mesh", "mesh for durations"}),
    ],
)  # fmt: skip
def test_the_mesh_may_change_a_tenth_of_what_flexibility_does(impulse, duration, error, fails):
    assert {name for name, passed in judged(impulse, duration, error).items() if not passed} == fails


@pytest.mark.long
@pytest.mark.parametrize("changes", [
    ("contact.stiffness=1e9", "contact.friction=0"),
    ("contact.restitution=0.8", "plate.youngs_modulus=317 MPa"),
    ("contact.friction=0.4", "plate.youngs_modulus=317 MPa"),
    ("vehicle.width=5.49 m", "plate.youngs_modulus=317 MPa"),
])  # fmt: skip
def test_a_contact_too_stiff_for_the_plate_is_caught(changes):
    """Quadratic elements change the impulse by 5 to 30 %."""
    failed = {check.name for check in planned(*changes).run().checks if not check.passed}
    assert failed & {"mesh", "point contact"}


def test_the_papers_method_stands_beside():
    """Its impulse is that of the same truck with a constrained corner; with the computed duration its force is less."""
    outcome = whole()
    beside = rigid.paper_method(outcome.fe_plan.case.scene, outcome.rigid)
    corner = CornerCase(*read_scene("mash-tl4-sut"))
    assert beside["impulse"] == pytest.approx(float(corner.force.impulse), rel=1e-12)
    assert beside["peak_force"] == pytest.approx(2.0 * beside["impulse"] / 0.1, rel=1e-12)
    computed = 2.0 * beside["impulse"] / beside["computed_duration"]
    assert beside["computed_peak_force"] == pytest.approx(computed)
    without = planned("impact.friction=", "impact.restitution=")
    assert rigid.paper_method(without.scene, outcome.rigid) is None


WALL = {
    "wall.length": "36 m", "wall.depth": "0.3 m", "wall.height": "1 m", "wall.elements": "[60,1]",
    "wall.foundation_stiffness": "100 MN/m^2",
}  # fmt: skip


@pytest.mark.long
def test_a_wall_that_gives_deflects_and_its_foundation_carries_the_force():
    """The foundation carries what the contact brings, but for the wall's inertia: impulses agree; the ledger closes."""
    outcome = ran(*(f"{key}={value}" for key, value in WALL.items()))
    h, found = outcome.run.history, report.wall_numbers(outcome)
    assert 2e-3 < found["deflection"] < 6e-3  # of the size of the peak force over 2 k'/b, 3.3 mm
    assert h["foundation_impulse"][-1] == pytest.approx(h["normal_impulse"][-1], rel=0.05)
    initial = 0.5 * outcome.fe_plan.model.mass * 25.034**2
    assert np.abs(checks.energy_error(outcome)).max() < 1e-4 * initial


def test_a_wall_that_is_too_short_or_lacks_a_key_is_refused(refused):
    for key in ("wall.height", "wall.foundation_stiffness"):
        assert refused(planned, *(f"{name}={value}" for name, value in WALL.items() if name != key)) == key
    with pytest.raises(errors.InputError, match="belongs to a whole impact"):
        read_scene("mash-tl4-sut", ("wall.height=1 m",))


MASS, LENGTH = 9979.0, 10.0


def point_outcome(modulus, patch=None, stiffness=2e6, off=0.0):
    contact = SimpleNamespace(stiffness=stiffness, patch_length=patch)
    plan = SimpleNamespace(scene=SimpleNamespace(needed_contact=contact))
    plate = SimpleNamespace(modulus=modulus, thickness=0.05)
    fe_plan = SimpleNamespace(case=plan, plate=plate)
    return SimpleNamespace(fe_plan=fe_plan, difference={"strike_1.impulse": off})


def point_contact(made):
    (check,) = evaluated([kind for kind in CHECKS if kind.name == "point contact"], made)
    return check


def test_the_wedge_s_constant():
    """Half the sum of both components' constants of a right-angled wedge, each 2/(pi/2 +- 1)."""
    along, across = 2.0 / (0.5 * math.pi + 1.0), 2.0 / (0.5 * math.pi - 1.0)
    assert pytest.approx(0.5 * (along + across), rel=1e-15) == WEDGE


def test_a_point_on_a_soft_plate_fails():
    """E t = 1e7 N/m against k = 2e6 N/m: 0.2 WEDGE log 2 = 0.297."""
    check = point_contact(point_outcome(2e8))
    assert check.value == pytest.approx(0.2 * WEDGE * math.log(2.0), rel=1e-12)
    assert (check.limit, check.passed) == (FLOOR, False)
    assert point_contact(point_outcome(2e8, off=0.2)).limit == pytest.approx(FLOOR + 0.2 * FRACTION)


def test_what_has_a_limit_passes():
    assert point_contact(point_outcome(2e11)).passed
    assert point_contact(point_outcome(2e8, patch=1.0)).value == 0.0
    assert point_contact(point_outcome(2e8, stiffness=None)).value == 0.0


def outcome(speed, frequency, flight, lasts, error, corner="rear"):
    """A plate whose ends move at this speed, that flies towards the wall at 8 m/s and turns by 0.4 rad/s, so that its
    rear corner comes at 10 m/s and its front corner at 6."""
    t = np.linspace(0.0, flight + 0.3, 400)
    energy = 0.5 * MODAL_FRACTION * MASS * speed**2 * np.cos(40.0 * t) ** 2
    still = {"t": t, "v_gy": np.full_like(t, -8.0), "omega": np.full_like(t, 0.4), "theta": np.zeros_like(t)}
    strikes = [SimpleNamespace(corner="front", start=0.0, end=0.1, duration=0.1)]
    strikes.append(
        SimpleNamespace(corner=corner, start=0.1 + flight, end=0.1 + flight + lasts, duration=lasts)
    )
    plan = SimpleNamespace(vehicle=SimpleNamespace(front_distance=5.0, length=LENGTH))
    return SimpleNamespace(
        fe=SimpleNamespace(strikes=strikes),
        run=SimpleNamespace(history={**still, "strain_energy": energy}),
        fe_plan=SimpleNamespace(case=plan, model=SimpleNamespace(mass=MASS), first_frequency=frequency),
        frequency_error=error,
    )


def test_modal_mass_of_a_free_beam():
    """Its first mode, scaled to 1 at the ends: the mean of its square is 1/4 (cosh a cos a = 1)."""
    a = 4.730040744862704
    x = np.linspace(0.0, 1.0, 20001) * a
    ratio = (math.cosh(a) - math.cos(a)) / (math.sinh(a) - math.sin(a))
    shape = np.cosh(x) + np.cos(x) - ratio * (np.sinh(x) + np.sin(x))
    mean = np.trapezoid(shape**2, x) / a / shape[0] ** 2
    assert mean == pytest.approx(MODAL_FRACTION, rel=1e-6)


@pytest.mark.parametrize("lasts", [1e-4, 0.02, 0.1, 0.37])
def test_no_phase_moves_the_mean_velocity_of_a_strike_by_more(lasts):
    """Of a velocity of 0.5 m/s at 8 Hz beside an approach at 10 m/s."""
    phases = np.linspace(0.0, 2.0 * math.pi, 721)
    t = np.linspace(0.0, lasts, 2001)
    means = [abs(np.trapezoid(0.5 * np.cos(16.0 * math.pi * t + phase), t) / lasts) for phase in phases]
    found = unknown_by_vibration(outcome(0.5, 8.0, 2.0, lasts, 1.0))
    assert max(means) / 10.0 <= found * (1.0 + 1e-3)
    assert found <= 0.05 * (1.0 + 1e-3)
    assert found == pytest.approx(0.05 * min(1.0, 1.0 / (math.pi * 8.0 * lasts)), rel=1e-3)


def test_a_mesh_that_tells_the_phase_leaves_little():
    """16 cycles at a frequency 1e-4 off: a phase of 0.01 rad."""
    known, unknown = (unknown_by_vibration(outcome(0.5, 8.0, 2.0, 0.01, error)) for error in (1e-4, -1.0))
    assert known / unknown == pytest.approx(2.0 * math.pi * 16.0 * 1e-4)


def test_it_is_of_the_corner_that_strikes():
    struck = (outcome(0.5, 8.0, 2.0, 0.01, 1.0, corner) for corner in ("rear", "front"))
    rear, front = map(unknown_by_vibration, struck)
    assert front / rear == pytest.approx(10.0 / 6.0)


def test_without_flight_or_second_strike_there_is_none():
    assert unknown_by_vibration(outcome(0.5, 8.0, 0.0, 0.01, 1.0)) == 0.0
    single = outcome(0.5, 8.0, 2.0, 0.01, 1.0)
    single.fe.strikes.pop()
    assert unknown_by_vibration(single) == 0.0


def test_without_a_second_mesh_no_phase_is_known():
    none, unknown = (unknown_by_vibration(outcome(0.5, 8.0, 2.0, 0.01, error)) for error in (math.nan, 1.0))
    assert none == unknown
