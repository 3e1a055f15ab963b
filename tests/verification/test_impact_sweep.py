"""Verify that sweeps of whole impacts have their results."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

from postprocess.comparison.quantities import STRIKES
from postprocess.figures.sweeps import SweepRows, Varied, draw_sweep
from tailslap import case, errors
from tailslap.campaign import sweep_report
from tailslap.campaign.sweep_definition import make_definition
from tailslap.campaign.sweep_run import perform
from tailslap.campaign.sweep_table import compute_row, table_schema
from tailslap.case.impact.case import ImpactCase
from tailslap.result.columns import read_columns
from tailslap.scene.read import source_of_text
from tailslap.scene.vary import vary

RIGID = """name = "rigid"
vehicle = {length = 10, width = 2.438, mass = 9979}
impact = {speed = 25, angle = 0.26}
contact = {stiffness = 2e6, restitution = 0.22, friction = 0.47}
"""
PLATE = "plate = {thickness = 0.053, youngs_modulus = 2e11, poissons_ratio = 0.3, elements = [8, 2]}\n"


def scene_file(folder, text):
    path = folder / "scene.toml"
    path.write_text(text)
    return str(path)


def test_a_row_is_what_the_rigid_vehicle_gives():
    source = source_of_text(RIGID, "rigid")
    row = compute_row(3, source, {"contact.stiffness": 3e6})
    plan = case.case_of(*vary(source, {"contact.stiffness": 3e6}))
    assert isinstance(plan, ImpactCase)
    first, second = plan.motion.strikes[:2]
    assert (row["run"], row["status"], row["rigid.strike_2.corner"]) == (3, "passed", "rear")
    assert row["rigid.strike_1.impulse"] == first.impulse
    assert row["rigid.strike_2.duration"] == second.duration
    assert 0.0 < row["rigid.strike_1.mean_50ms"] < first.peak_force
    overall = max(row[f"rigid.strike_{k}.mean_50ms"] for k in (1, 2))
    assert overall == pytest.approx(row["rigid.peaks.mean_50ms"], rel=1e-12)
    assert compute_row(0, source, {"contact.restitution": 2.0})["status"] == "refused"


def test_a_sweep_of_the_rigid_vehicle_alone(tmp_path, words_of):
    """No FE columns, strikes on the page, and no repeated work."""
    varied = ("contact.stiffness=1e6,4e6", "contact.restitution=0,2")
    definition = make_definition(scene_file(tmp_path, RIGID), (), ("contact.stiffness=1e6,4e6",), None, 1)
    sweep = perform(definition, tmp_path / "sweep", workers=1)
    assert (sweep.statuses["passed"], sweep.effort.runs) == (2, 2)
    columns = read_columns(
        tmp_path / "sweep" / "sweep.parquet", ["run", "rigid.strike_1.peak_force", "rigid.strike_1.mean_50ms"]
    )
    soft, stiff = columns["rigid.strike_1.peak_force"]
    assert stiff / soft == pytest.approx(2.0, rel=0.1)
    names = table_schema(definition, []).names
    assert not [name for name in names if name.startswith(("fe.", "difference."))]
    page = (tmp_path / "sweep" / "report.html").read_text()
    assert [words for words in ("Of both strikes", "Rigid, least") if words not in page] == []
    assert "F₁, 50 ms [kN]" in page
    charts = {path.stem for path in (tmp_path / "sweep").glob("*.svg")}
    against = {f"against-contact-stiffness-{name.replace('.', '-')}" for name in STRIKES.quantities}
    assert charts == against | {"set-up"}
    perform(definition, tmp_path / "sweep", units="us")
    page = (tmp_path / "sweep" / "report.html").read_text()
    assert [words for words in ("F₁, 50 ms [kip]", "contact.stiffness [kip/ft]") if words not in page] == []
    assert "kN" not in words_of(tmp_path / "sweep", "us")
    least = columns["rigid.strike_1.mean_50ms"].min() / 4448.2216152605
    assert f"{least:.5g}" in page
    assert perform(definition, tmp_path / "sweep").effort.runs == 0
    with pytest.raises(errors.InputError, match=r"contact\.restitution"):
        make_definition(scene_file(tmp_path, RIGID), (), varied, None, 1)


def test_the_range_is_of_the_runs_that_have_a_force(tmp_path):
    """A single run has one value, and the number of all."""
    definition = make_definition(
        scene_file(tmp_path, RIGID), ("contact.restitution=0.9",), ("contact.initial_force=0,1e5",), None, 1
    )
    perform(definition, tmp_path / "sweep", workers=0)
    answer = json.loads((tmp_path / "sweep" / "summary.json").read_text())["answer"]
    assert re.fullmatch(r"Largest 50 ms mean of the lateral force: [0-9]+ kN over 1 of 2 runs\.", answer)


def test_columns_of_both_calculations(tmp_path):
    """The corner has its columns, an impact the strikes of both models."""
    corner = table_schema(
        make_definition("paper-table-3", (), ("plate.thickness=1,2",), None, 1), ["check.x"]
    ).names
    assert corner[:5] == ["run", "status", "reason", "plate.thickness", "rigid.t"]
    assert corner[18:21] == ["difference.slide", "rigid.peak_force", "fe.peak_force"]
    assert corner[21:23] == ["deflection_ratio", "check.x"]
    assert corner[23:27] == ["cost.elements", "cost.nodes", "cost.steps", "cost.time_step"]
    impact = make_definition(scene_file(tmp_path, RIGID + PLATE), (), ("contact.friction=0,1",), None, 1)
    names = table_schema(impact, []).names
    assert {"fe.strike_2.mean_50ms", "difference.strike_2.impulse", "numerical_error"} <= set(names)


def test_a_corner_without_a_plate_is_no_sweep():
    with pytest.raises(errors.InputError, match="plate"):
        make_definition("paper-table-3", ("plate=",), ("corner.friction=0,1",), None, 1)


def rows(fe):
    columns = ("a.x", [1, 1, 2, 2]), ("b.y", [1, 2, 1, 2])
    a, b = (Varied(key, "", np.array(values), False) for key, values in columns)
    rigid = {key: np.linspace(1.0, 2.0, 4) for key in STRIKES.quantities}
    error = {key: np.geomspace(1e-6, 1e-3, 4) for key in rigid}
    flexible = {key: rigid[key] * (1.0 + error[key]) for key in rigid}
    status = np.full(4, "passed", dtype=object)
    return SweepRows((a, b), status, flexible if fe else {}, rigid, error if fe else {}, STRIKES)


def test_pictures_of_impacts():
    """Every result is drawn against each key, and in maps.

    Of both models with the difference; of the rigid vehicle alone without FE.
    """
    both, alone = draw_sweep(rows(True)), draw_sweep(rows(False))
    names = [curve.name for curve in alone]
    assert [curve.name for curve in both if not curve.name.endswith(("-difference", "-worst"))] == names
    assert len(both) == len(alone) + 3
    assert [name for name in names if name.startswith("against-a-x")]
    assert names[-2:] == ["map-result", "map-status"]
    assert all("FE" not in curve.caption for curve in alone)
    assert both[-3].caption == "Second strike's peak, 50 ms mean by FE"
    assert draw_sweep(replace(rows(False), rigid=dict.fromkeys(STRIKES.quantities, np.full(4, np.nan)))) == ()


def test_spreads_leave_out_what_a_row_lacks():
    """An impact without a second strike has none of its quantities."""
    some = rows(False)
    some.rigid["strike_2.impulse"][0] = math.nan
    spreads = {item["quantity"].key: item for item in sweep_report.spreads(some)}
    assert spreads["strike_2.impulse"]["least"] == some.rigid["strike_2.impulse"][1]
    assert "difference" not in spreads["strike_1.impulse"]
