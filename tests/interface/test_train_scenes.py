"""Verify answers, files, tables and refusals of train scenes."""

import json
import math
from typing import Any

import numpy as np
import pytest
from sampled_impacts import corner_tables

import tailslap
from postprocess.units import SI
from tailslap.case import case_of
from tailslap.case.impact.answers import ImpactAnswer
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.strike_columns import LARGEST, both_strikes
from tailslap.cli import _status
from tailslap.scene.read import read_scene
from tailslap.scene.vary import Source, vary

SCENE = {
    "name": "train",
    "vehicle": {"length": 6.9, "width": 2.44, "mass": 8200, "centre_of_mass": 2.9, "yaw_inertia": 34621},
    "trailer": [
        {"length": 14.6, "width": 2.59, "mass": 27770, "centre_of_mass": 8.0, "yaw_inertia": 497057,
         "hitch": 5.6, "kingpin": 0.9}
    ],
    "impact": {"speed": 22.35, "angle": "15 deg"},
    "contact": {"stiffness": "1 MN/m", "restitution": 0.22, "friction": 0.47},
}  # fmt: skip
TRIAL = {  # by stiffness: corner, start, duration, peak, impulse of a trial by another scheme; largest 50 ms mean
    "1 MN/m": ([
        ("front", 0.0, 0.1268, 390.5, 31.43), ("trailer front", 0.1958, 0.1590, 531.2, 52.34),
        ("rear", 0.2490, 0.0944, 304.0, 18.59), ("front", 0.4190, 0.0447, 405.2, 13.29),
        ("trailer rear", 0.7058, 0.1721, 704.0, 77.16),
    ], 779.0),
    "2 MN/m": ([
        ("front", 0.0, 0.0904, 554.0, 31.82), ("trailer front", 0.1958, 0.1204, 797.5, 59.50),
        ("rear", 0.2452, 0.0616, 348.8, 13.99), ("front", 0.4414, 0.0297, 561.3, 11.46),
        ("trailer rear", 0.6983, 0.1217, 996.6, 77.23),
    ], 1001.0),
}  # fmt: skip


def train(**changes):
    keys = {key.replace("__", "."): value for key, value in changes.items()}
    return case_of(*vary(Source(tables=SCENE), keys))


@pytest.fixture(scope="module")
def case():
    return train()


@pytest.mark.parametrize("stiffness", TRIAL)
def test_the_table_of_a_trial_by_another_scheme(stiffness):
    """Every printed number of five strikes, and the largest mean."""
    printed, mean = TRIAL[stiffness]
    numbers = train(contact__stiffness=stiffness).rigid_numbers()
    for strike, (corner, start, duration, peak, impulse) in zip(numbers["strikes"], printed, strict=False):
        assert strike["corner"] == corner
        assert (strike["start"], strike["duration"]) == pytest.approx((start, duration), rel=2e-3, abs=5e-5)
        forces = (strike["peak_force"], strike["impulse"])
        assert forces == pytest.approx((1e3 * peak, 1e3 * impulse), rel=2e-3)
    assert numbers["peaks"]["mean_50ms"] == pytest.approx(1e3 * mean, rel=2e-3)
    assert numbers["error"] < 1e-4


def test_columns_of_a_history(case):
    """Momenta of both units follow from the forces of wall and hinge."""
    h, dt = case.rigid_history(), case.answer.interval
    masses = {"": 8200.0, "_2": 27770.0}
    force_on = {unit: mass * np.diff(h[f"v_gy{unit}"]) / dt for unit, mass in masses.items()}
    scale = np.abs(h["force_normal"]).max()
    assert force_on[""] == pytest.approx((h["force_normal_1"] + h["hinge_force_y_1"])[1:], abs=1e-6 * scale)
    assert force_on["_2"] == pytest.approx((h["force_normal_2"] - h["hinge_force_y_1"])[1:], abs=1e-6 * scale)
    for force in ("normal", "tangential"):
        both = h[f"force_{force}_1"] + h[f"force_{force}_2"]
        assert h[f"force_{force}"] == pytest.approx(both, abs=1e-4 * scale)
    along = masses[""] * np.diff(h["v_gx"]) / dt
    assert along == pytest.approx((h["force_tangential_1"] + h["hinge_force_x_1"])[1:], abs=1e-6 * scale)
    assert h["articulation_1"] == pytest.approx(h["theta_2"] - h["theta"])
    (hinge,) = case.rigid_numbers()["hinges"]
    forces = np.hypot(h["hinge_force_x_1"], h["hinge_force_y_1"])
    assert hinge["peak_force"] == forces.max()
    assert hinge["largest_angle"] == np.abs(h["articulation_1"]).max()


def test_the_50_ms_mean_of_a_hinge_is_that_of_its_vector():
    """A force that rotates by pi has 2/pi of its size."""
    t, names = np.linspace(0.0, 1.0, 2001), ("hinge_force_x_1", "hinge_force_y_1", "articulation_1", "t")
    phase = np.pi * t / 0.05
    for x, y, mean in ((np.cos(phase), np.sin(phase), 2.0 / np.pi), (0.6 + 0.0 * t, 0.8 + 0.0 * t, 1.0)):
        history = dict(zip(names, (7.0 * x, 7.0 * y, 0.1 * t, t), strict=True))
        (hinge,) = ImpactAnswer((), history, units=2).hinges
        assert hinge["peak_force"] == pytest.approx(7.0)
        assert hinge["mean_50ms"] == pytest.approx(7.0 * mean, rel=2e-3)


def test_the_hinge_stays_closed_in_the_history(case):
    h = case.rigid_history()
    ahead = h["x_g"] - 2.7 * np.cos(h["theta"]), h["y_g"] + 2.7 * np.sin(h["theta"])
    behind = h["x_g_2"] + 7.1 * np.cos(h["theta_2"]), h["y_g_2"] - 7.1 * np.sin(h["theta_2"])
    assert np.array(ahead) == pytest.approx(np.array(behind), abs=1e-6)


def test_modes_of_a_train_are_symmetric_or_antisymmetric():
    """Units that overlap in plan are separately symmetric."""
    changes = ("trailer.0.width=96 in", "plate.elements=[16, 6]")
    analysis = tailslap.modes("impact-mash-tl5-tractor-van", changes, count=8)
    modes = analysis.summary["modes"]
    symmetric = np.array([mode["symmetric"] for mode in modes])
    assert np.abs(symmetric - np.round(symmetric)).max() < 1e-6
    assert {mode["kind"] for mode in modes} == {"bending", "longitudinal"}
    assert [mode["theory"] for mode in modes] == [None] * 8
    assert len(analysis.summary["rigid_frequencies"]) == 4
    plan = case_of(*read_scene("impact-mash-tl5-tractor-van", changes)).plan()
    assert modes[0]["frequency"] == pytest.approx(plan.first_frequency, rel=1e-6)


def test_files_of_a_train(tmp_path, capsys):
    assert _status(["rigid", write(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "trailer rear" in out
    assert "hinge 1: peak force 453.6" in out
    result = tailslap.rigid(SCENE)
    assert all(f">trailer {end}<" in result.charts["force"].svg for end in ("front", "rear"))
    result.save(tmp_path / "out")
    trajectory = tailslap.load(tmp_path / "out").rigid
    assert result.rigid is not None
    assert trajectory is not None
    units = tailslap.rigid(SCENE).histories["rigid"].units
    assert (units["hinge_force_x_1"], units["articulation_1"], units["v_gx_2"]) == ("N", "rad", "m/s")


def write(folder):
    from tailslap.scene.write import scene_file

    (folder / "train.toml").write_text(scene_file(vary(Source(tables=SCENE), {})[1].tables, "a train"))
    return str(folder / "train.toml")


def test_a_trailers_crush_is_its_own():
    """A softer trailer strikes longer, after the same first strike."""
    strikes = [
        train(strip=corner_tables(14.6, law, law, 2)).motion.strikes
        for law in ({"stiffness": 1e6}, {"stiffness": 5e5})
    ]
    assert strikes[0][0] == strikes[1][0]
    assert strikes[1][1].duration > 1.1 * strikes[0][1].duration
    assert strikes[0] == train().motion.strikes


def test_occupant_risk_is_that_of_the_tractor(case):
    """ASI by the accelerations of the tractor, not by the wall force."""
    h, step = case.answer.history, case.answer.interval
    asi = next(item for item in case.answer.occupant_risk(1.0) if item.name.startswith("ASI"))
    width = round(0.05 / step)
    window = np.ones(width) / width
    means = [np.convolve(np.diff(h[name]) / step, window, "valid") for name in ("v_gx", "v_gy")]
    heading = np.convolve(h["theta"][1:], np.ones(width) / width, "valid")
    ahead = np.cos(heading) * means[0] - np.sin(heading) * means[1]
    across = np.sin(heading) * means[0] + np.cos(heading) * means[1]
    rough = np.hypot(ahead / 12.0, across / 9.0).max() / 9.81
    assert asi.value == pytest.approx(rough, rel=0.05)


def test_the_set_up_names_and_draws_every_unit(case):
    sentence = SI.rendered(case.headline().set_up)
    assert sentence.startswith("train: 8200 kg tractor with a 27770 kg trailer at 22.35 m/s")
    assert str(case.drawing()).count("trailer rear") >= 1


def test_a_wide_trailer_and_a_jack_knife_are_told():
    wide = train(trailer__0__width=9.0, trailer__0__kingpin=4.0)
    assert wide.motion.strikes[0].corner == "trailer front"
    assert "so wide that it touches the wall first" in "\n".join(wide.rigid_text())
    light = {"vehicle.mass": 2000.0, "vehicle.yaw_inertia": 8000.0, "impact.angle": 1.1, "time.end": 1.0}
    folded = case_of(*vary(Source(tables=SCENE), light))
    (remark,) = folded.rigid_numbers()["remarks"]
    assert remark.startswith("The train jack-knifes: from 0.")
    assert isinstance(folded, ImpactCase)
    assert np.abs(folded.answer.history["articulation_1"]).max() > math.pi / 2
    assert train().rigid_numbers()["remarks"] == []


def test_a_train_of_three_units_strikes_with_its_last_rear():
    trailer: Any = SCENE["trailer"]
    third = {**trailer[0], "hitch": 14.0, "kingpin": -1.0}
    case = train(trailer=[trailer[0], third], time__end=2.5)
    assert {"trailer rear", "trailer 2 rear"} <= {strike.corner for strike in case.motion.strikes}
    assert len(case.rigid_numbers()["hinges"]) == 2
    assert set(case.columns(case.scene)) >= {"rigid.strike_8.impulse", "rigid.hinge_2.peak_force"}


def test_a_sweep_has_a_row_of_every_strike_that_counts(tmp_path):
    masses = {"trailer.0.mass": [20000.0, 27770.0]}
    sweep = tailslap.sweep(write(tmp_path), vary=masses, folder=tmp_path / "sweep")
    table = sweep.histories["table"]
    assert list(table["trailer.0.mass"]) == [20000.0, 27770.0]
    answer = train().answer
    assert table["rigid.strike_5.impulse"][1] == pytest.approx(answer.strikes[4].impulse, rel=1e-9)
    assert table["rigid.hinge_1.largest_angle"][1] == pytest.approx(
        answer.hinges[0]["largest_angle"], rel=1e-9
    )


def test_many_trains_have_the_strikes_of_each(case):
    """First front, last rear and largest mean agree at a coarser step."""
    keys = {"contact.stiffness": [1e6, 2e6]}
    keys["trailer.0.mass"] = [27770.0, 20000.0]
    many = case.many({key: np.array(values) for key, values in keys.items()})
    inertia = 497057 * 20000 / 27770
    changes = {"contact__stiffness": 2e6, "trailer__0__mass": 2e4, "trailer__0__yaw_inertia": inertia}
    for i, single in enumerate((case, train(**changes))):
        answer = both_strikes(single.answer)
        assert list(answer) == list(many)
        for name in (LARGEST, "strike_1.raw", "strike_2.impulse", "strike_2.mean_50ms"):
            assert many[name][i] == pytest.approx(answer[name], rel=3e-3), name


def test_a_study_of_what_is_not_known_stands_beside_design_forces(tmp_path):
    path = write(tmp_path)
    changes = {"impact.test_level": "TL-5"}
    study = tailslap.study("uncertainty", path, changes, samples=1000)
    summary = study.summary
    keys = {row["key"] for row in summary["inputs"]}
    assert keys >= {f"trailer.0.{key}" for key in ("centre_of_mass", "yaw_inertia", "hitch")}
    assert keys >= {f"contact.stiffness@{name}" for name in ("rear", "trailer front", "trailer rear")}
    levels = {round(row["force"] / 1e3): row["above"] for row in summary["levels"]}
    assert set(levels) == {552, 712, 845, 1165, 778, 1334}
    assert sorted(levels.values(), reverse=True) == [levels[force] for force in sorted(levels)]
    indices = summary["bands"][LARGEST]["indices"]
    first, total = (sum(row[name] for row in indices.values()) for name in ("first_order", "total"))
    assert 0.0 < first <= 1.1  # of independent inputs the sums are at most and at least 1
    assert total >= 0.9
    assert study.headline.answer.startswith("Largest 50 ms mean")
    json.dumps(summary)
