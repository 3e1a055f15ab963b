"""Verification: [tipping] in scenes: keys, refusals, what is printed with the table and that nothing is without."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import tailslap
from postprocess.units import SI
from solver.tipping import TIPPED, RollingVehicle, largest_rolls
from tailslap.case.impact import answers, rigid
from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError
from tailslap.scene.read import read_scene

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENE, BARE = "impact-tipping-tl4-sut", str(EXAMPLES / "linear-truck.toml")

REFUSED = [
    ("tipping.wall_height=0", "tipping.wall_height", "from 0.05 m"),
    ("tipping.centre_height=-1 m", "tipping.centre_height", "from 0.05 m"),
    ("tipping.track=2.5 m", "tipping.track", "up to its width, 2.438 m"),
    ("tipping.suspension=-1 N/m", "tipping.suspension", "a stiffness from"),
    ("tipping.suspension=1e14", "tipping.suspension", "softer"),
    ("tipping.damping_ratio=2", "tipping.damping_ratio", "from 0  to 1"),
    ("tipping.friction=-0.1", "tipping.friction", "a coefficient of friction"),
    ("tipping.suspension=", "tipping.suspension", "required"),
    ("tipping.colour=1", "tipping.colour", "does not exist"),
]


def case(*changes, scene=SCENE):
    return ImpactCase(*read_scene(scene, changes))


def rolled(*changes):
    return case(*changes).rigid_numbers()["tipping"]


@pytest.mark.parametrize(("change", "key", "allowed"), REFUSED)
def test_refusals(change, key, allowed):
    with pytest.raises(InputError) as caught:
        rolled(change)
    assert (caught.value.key, allowed.replace("  ", " ") in caught.value.allowed) == (key, True)


def test_a_constrained_corner_has_no_tipping():
    keys = ("wall_height", "centre_height", "track", "suspension")
    with pytest.raises(InputError, match=r"tipping.*requires \[contact\]"):
        read_scene("mash-tl4-sut", [f"tipping.{key}=1.0" for key in keys])


def test_numbers_of_the_contract(python):
    code = f"from tailslap import cli; raise SystemExit(cli.main(['rigid', '{SCENE}', '--json']))"
    found = json.loads(python(code, check=True).stdout)["tipping"]
    assert found["tips"] is False
    assert found["largest_roll"] == pytest.approx(math.radians(4.0), abs=math.radians(0.5))
    assert 0.69 < found["lowest_safe_wall"] < 0.81
    assert found["wall_margin"] == pytest.approx(0.9144 - found["lowest_safe_wall"], abs=1e-12)
    assert found["centre_margin"] == pytest.approx(found["highest_safe_centre"] - 1.35, abs=1e-12)
    assert found["error"] <= 1e-5


def test_margins_are_where_the_verdict_turns():
    found = rolled()
    edges = ("wall_height", found["lowest_safe_wall"], 1), ("centre_height", found["highest_safe_centre"], -1)
    for key, edge, safe in edges:
        assert not rolled(f"tipping.{key}={edge + 1e-6 * safe}")["tips"]
        assert rolled(f"tipping.{key}={edge - 1.1e-3 * safe}")["tips"]


def test_a_lower_wall_and_a_higher_centre_tip():
    assert rolled("tipping.wall_height=27 in")["largest_roll"] == TIPPED
    assert rolled("tipping.wall_height=32 in", "tipping.centre_height=1.45 m")["tips"]
    assert not rolled("tipping.centre_height=1.45 m")["tips"]


def test_keys_left_out():
    """Roll inertia m (0.45 B)^2, damping 0.15, no friction of the face."""
    bare = [f"tipping.{key}=" for key in ("roll_inertia", "damping_ratio")]
    inertia = f"tipping.roll_inertia={9979.0 * (0.45 * 2.438) ** 2}"
    assert rolled(*bare) == rolled(inertia, "tipping.damping_ratio=0.15", "tipping.friction=0")
    assert rolled("tipping.friction=0.47")["largest_roll"] < rolled()["largest_roll"]


def test_a_centre_below_the_wall_s_top_is_announced():
    text = SI.rendered(case("tipping.wall_height=54 in").headline().answer)
    above = "its centre of mass is below the top of the wall, 1.372 m (54.0 in)."
    assert f"The vehicle cannot tip over this wall: {above}" in text
    assert not rolled("tipping.wall_height=54 in")["tips"]


def test_what_the_roll_takes_off_the_effective_mass():
    """1/m_eff = 1/m + r^2 cos phi (cos phi - mu sin phi)/I at the front corner, 3677 kg by `impact.md` 2, and
    (z - h)^2/I_roll beside it."""
    planar = 1.0 / 3677.0
    roll = (1.35 - 0.9144) ** 2 / 12070.0
    found = rolled()["effective_mass_change"]
    assert found == pytest.approx(-roll / (planar + roll), rel=1e-3)


def test_the_third_strike_counts():
    """The impact is followed to 0.5 s after the second strike, unless time.end is set."""
    own = case()
    assert own.duration == pytest.approx(own.motion.strikes[1].end + 0.5, abs=1e-9)
    assert case("time.end=0.6").duration == 0.6
    force = own.answer.history["force_normal"][1:]
    until = round(own.motion.strikes[2].start / own.answer.interval)
    vehicle = RollingVehicle(9979.0, 1.35, 12070.0, 1.85, 1.2e6)
    cut = largest_rolls(vehicle, 0.72, force[:until], own.answer.interval)
    assert cut < 0.95 * largest_rolls(vehicle, 0.72, force, own.answer.interval)


def test_without_the_table_nothing_of_it_is_there(python):
    code = f"import sys, tailslap; print(tailslap.rigid('{BARE}').summary.keys(), *sys.modules)"
    assert "tipping" not in python(code, check=True).stdout
    assert "tipping" not in "\n".join(case(scene=BARE).rigid_text())


def test_a_run_has_both_forces(tmp_path):
    found = tailslap.run(SCENE, {"verify.companion": False})
    fe, own = (found.summary[model]["tipping"] for model in ("fe", "rigid"))
    assert fe["largest_roll"] == pytest.approx(own["largest_roll"], rel=0.03)
    assert 0.0 < abs(fe["lowest_safe_wall"] - own["lowest_safe_wall"]) < 5e-3
    found.save(tmp_path / "run", pictures=False)
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    for words in ("Tipping over the wall", "Omitted", "shift of the cargo", "Roll would reduce"):
        assert words in page


def test_a_sweep_over_walls(tmp_path):
    heights = "tipping.wall_height=0.7,0.8,0.9"
    found = tailslap.sweep(SCENE, [heights], {"plate": None}, folder=tmp_path / "sweep", workers=1)
    rolls = np.array(found.history["rigid.tipping.largest_roll"])
    assert rolls[0] == TIPPED
    assert (np.diff(rolls) < 0.0).all()


def test_forces_of_an_answer_are_means_whose_sum_is_the_impulse():
    own = case()
    force = own.answer.history["force_normal"][1:]
    assert force.sum() * own.answer.interval == pytest.approx(
        sum(s.impulse for s in own.motion.strikes), rel=1e-9
    )
    assert rigid.tipping_of(case(scene=BARE), own.answer) is None
    assert isinstance(own.answer, answers.ImpactAnswer)
