"""Verify verdicts of the study of stability, on axes and at random."""

import json
import math
import re
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest
from shared_cases import LINEAR_TRAIN, LINEAR_TRUCK

from postprocess.report.command_report import report_text, write_report
from tailslap import progress
from tailslap.case import case_of
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.numerical_error import NumericalError
from tailslap.scene.read import read_scene
from tailslap.scene.vary import changed_tables, vary
from tailslap.studies.stability import cell_verdicts, stability_study
from tailslap.studies.stability.stability_axes import axes_of, map_cells
from tailslap.studies.stability.stability_report import advised, caught_by, headline, refused_by, report

COARSE = ("plate.elements=[10,3]",)


def verdict_at(first, x, second, y, *changes):
    scene = read_scene("paper-table-3", (*COARSE, *changes))[0]
    by_name = {axis.name: axis for axis in axes_of(scene, 3)}
    return verdict_of(scene, {**by_name[first].changes(scene, x), **by_name[second].changes(scene, y)})


def verdict_of(scene, changes):
    tolerance = 1e-2 if scene.contact else 1e-3
    verify = partial(cell_verdicts.against_rigid, tolerance=tolerance)
    return cell_verdicts.judge(stability_study.base_source(scene), changes, verify)


def test_eight_axes_with_ten_values_make_2800_cells():
    scene = read_scene("paper-table-3")[0]
    assert len(map_cells(scene, axes_of(scene, 10))[0]) == 28 * 100
    frictionless = read_scene("paper-abaqus", ("corner.constraint=exact",))[0]
    assert {axis.name for axis in axes_of(frictionless, 10)}.isdisjoint({"friction", "penalty"})


def test_cells_of_a_scene_that_starts_with_stage_one_change_its_impact():
    scene = read_scene("mash-tl4-sut")[0]
    base = stability_study.base_source(scene)
    axes = tuple(axis for axis in axes_of(scene, 3) if axis.name in ("speed", "angle"))
    cells, places = map_cells(scene, axes)
    changes = next(cells[key] for key, place in places.items() if place["first_value"] > 1.0)
    changed = changed_tables(base.tables, changes)[0]
    assert changed["impact"]["speed"] == 10.0 * base.tables["impact"]["speed"]
    assert changed["impact"]["angle"] == pytest.approx(math.radians(1.0))
    assert "wall" not in changed
    assert 0.2 < base.tables["impact"]["angle"] < 0.3


@pytest.mark.parametrize(("cell", "kind"), [
    (("stiffness", 1.0, "friction", 0.2), "right"), (("time step", 1.2, "friction", 0.2), "refused"),
    pytest.param(("stiffness", 1e-4, "friction", 0.2), "flexible", marks=pytest.mark.long),
    (("stiffness", 1e-4, "penalty", 0.01), "caught"),
])  # fmt: skip
def test_each_kind_of_cell(cell, kind):
    assert verdict_at(*cell)["kind"] == kind


def test_a_soft_slender_plate_follows_its_loads_and_is_confirmed():
    """The predicted damping would hide a third of its flexibility."""
    scene = read_scene("paper-table-3")[0]
    strip = {"vehicle.width": 0.46415888336127774, "plate.youngs_modulus": 0.000774263682681127 * 2e11}
    verdict = verdict_of(scene, strip)
    assert (verdict["kind"], verdict["difference"]) == ("flexible", pytest.approx(0.0358, rel=0.01))
    assert verdict["error"] < 5e-4


@pytest.mark.long
def test_a_wrong_number_that_no_check_catches_is_wrong(monkeypatch):
    monkeypatch.setattr("tailslap.case.corner.corner_run.evaluated", lambda *arguments: ())
    soft_spring = verdict_at("stiffness", 1e-4, "penalty", 0.01)
    assert soft_spring["kind"] == "wrong"
    assert soft_spring["reason"].startswith("the numerical error is ")
    monkeypatch.setattr("tailslap.case.corner.outcome.CornerOutcome.error", NumericalError(*5 * [0.0]))
    unaware = verdict_at("stiffness", 1e-4, "penalty", 0.01)
    assert unaware["kind"] == "wrong"
    assert "differs by" in unaware["reason"]


@pytest.mark.long
def test_a_cell_of_a_scene_that_leaves_mesh_and_constraint_open_is_confirmed():
    scene = read_scene("paper-table-3", ("plate.elements=",))[0]
    softer = {"plate.youngs_modulus": 1e-4 * scene.needed_plate.modulus}
    assert verdict_of(scene, softer)["kind"] == "flexible"


def test_a_cell_whose_run_would_take_too_long_is_left_out_with_its_reason(monkeypatch):
    monkeypatch.setattr(cell_verdicts, "LONGEST_S", 0.01)
    assert verdict_at("stiffness", 1.0, "friction", 0.2)["kind"] == "right"
    stiff = verdict_at("stiffness", 1e4, "friction", 0.2)
    assert (stiff["kind"], stiff["steps"]) == ("unjudged", 0)
    assert re.fullmatch(r"estimated time of the time loop \S+ s", stiff["reason"])


def breaks(*arguments):
    raise ZeroDivisionError("boom")


def test_a_program_that_breaks_has_not_refused(monkeypatch):
    monkeypatch.setattr("tailslap.case.corner.corner_run.evaluated", breaks)
    broken = verdict_at("stiffness", 1.0, "friction", 0.2)
    assert (broken["kind"], broken["reason"]) == ("wrong", "broke: ZeroDivisionError: boom")
    assert broken["processor_seconds"] > 0.0


def test_axes_of_a_whole_impact_make_a_thousand_cells_and_each_changes_the_scene():
    scene = read_scene(LINEAR_TRUCK)[0]
    axes = {axis.name: axis for axis in axes_of(scene, 6)}
    assert len(map_cells(scene, axes_of(scene, 6))[0]) == 28 * 36
    stiffness = axes["contact stiffness"].values
    assert (stiffness[0], stiffness[-1]) == (pytest.approx(1e4), pytest.approx(1e9))
    ends = [axes[name].values[-1] for name in ("restitution", "friction", "angle")]
    assert ends == [1.0, 2.0, pytest.approx(85.0)]
    keys = [next(iter(axis.changes(scene, axis.values[0]))) for axis in axes.values()]
    assert keys[:4] == ["contact.stiffness", "contact.restitution", "contact.friction", "impact.angle"]
    assert keys[4:] == ["impact.speed", "plate.youngs_modulus", "time.safety_factor", "vehicle.width"]
    stiff = read_scene(
        LINEAR_TRUCK, ("contact.stiffness=", "contact.restitution=", "contact.enforcement=exact")
    )[0]
    absent = {"contact stiffness", "restitution", "penalty"}
    assert {axis.name for axis in axes_of(stiff, 6)}.isdisjoint(absent)


def test_refined_models_of_an_automatic_mesh_have_its_elements_and_lengths():
    case = case_of(*read_scene(LINEAR_TRAIN))
    plan = case.plan()
    (changes,) = cell_verdicts.refinements(case.scene, plan.plate)
    refined = case.varied(changes).plan()
    along, across = plan.plate.counts
    assert (refined.plate.element, refined.plate.counts) == ("quad9", (2 * along, 2 * across))
    scene, half_width = refined.case.scene, pytest.approx(0.5 * case.scene.vehicle.width)
    lengths = scene.needed_contact.patch_length, scene.trailer[0].hitch_length
    assert (scene.time.safety_factor, *lengths) == (0.35, half_width, half_width)


@pytest.mark.long
def test_a_stiff_plate_s_impact_is_right_and_what_cannot_be_is_refused():
    scene = read_scene(LINEAR_TRUCK)[0]
    right = verdict_of(scene, {})
    assert (right["kind"], right["model"]) == ("right", "quad9 16 x 4")
    assert 1e-4 < right["difference"] < 1e-2
    assert verdict_of(scene, {"contact.restitution": 1.1})["kind"] == "refused"
    assert verdict_of(scene, {"time.safety_factor": 1.2})["kind"] == "refused"


WITHOUT_MEANS = {"force_normal": [math.nan]}


def impact(impulse, error, passed=True, corner="rear"):
    """As much of an outcome as is judged."""

    def answer(corner, impulse):
        strikes = [("front", 1.0), (corner, 1.0 + impulse)]
        impacts = [SimpleNamespace(corner=c, impulse=j, peak_force=1.0, duration=1.0) for c, j in strikes]
        return SimpleNamespace(strikes=impacts, counted=2, history=WITHOUT_MEANS)

    plate = SimpleNamespace(element="quad9", counts=(4, 2))
    case = SimpleNamespace(scene=read_scene(LINEAR_TRUCK)[0])
    difference = {"strike_1.impulse": 0.0, "strike_2.impulse": impulse, "strike_2.duration": 9.0}
    checks, plan = (SimpleNamespace(name="mesh", passed=passed),), SimpleNamespace(plate=plate, case=case)
    both = {"fe": answer(corner, impulse), "rigid": answer("rear", 0.0), "difference": difference}
    error = {"mesh_error": {"strike_2.impulse": error}}
    return SimpleNamespace(**both, **error, passed=passed, checks=checks, fe_plan=plan)


IMPACTS = [
    *((impact(5e-3, 0.0), None, "right"), (impact(0.1, 0.0, passed=False), None, "caught")),
    *((impact(0.1, 0.0), None, "wrong"), (impact(0.1, 0.0), impact(0.1, 0.0), "flexible")),
    (impact(0.1, 0.03), impact(0.14, 0.0), "flexible"),
    (impact(0.1, 0.03), impact(0.16, 0.0), "wrong"),
    (impact(0.1, 0.0), impact(0.1, 0.0, corner="front"), "wrong"),
    (impact(0.0, 0.0, corner="front"), None, "wrong"),
]


@pytest.mark.parametrize(("answer", "refined", "kind"), IMPACTS)
def test_verdicts_on_impacts(answer, refined, kind, monkeypatch):
    """Beyond the tolerance the refined model decides."""
    monkeypatch.setattr(cell_verdicts, "refined_impact", lambda case, changes: refined)
    assert cell_verdicts.against_rigid(answer, 1e-2)["kind"] == kind


def test_a_train_is_judged_by_the_strikes_whose_error_is_stated():
    """The first two strikes and the largest decide."""
    strikes = ("front", 1.0), ("trailer front", 2.0), ("trailer rear", 3.0), ("rear", 0.5)
    answer = impact(0.0, 0.0)
    answer.fe = answer.rigid = SimpleNamespace(
        strikes=[SimpleNamespace(corner=c, impulse=j) for c, j in strikes], history=WITHOUT_MEANS
    )
    answer.difference = {"strike_3.impulse": 2e-3, "strike_4.impulse": 0.3}
    distance = cell_verdicts.against_rigid(answer, 1e-2)
    assert (distance["kind"], distance["difference"]) == ("right", 2e-3)


def test_every_cell_has_an_estimate_and_those_of_many_steps_the_longest():
    case = CornerCase(*read_scene("paper-table-3"))
    base, axes = stability_study.base_source(case.scene), axes_of(case.scene, 4)
    cells = map_cells(case.scene, axes)[0]
    assert stability_study.expected_seconds(case, base, cells).keys() == cells.keys()
    of = lambda changes: stability_study.expected_seconds(case, base, {"": changes})[""]  # noqa: E731
    seconds = {"usual": of({}), "slender": of({"vehicle.width": 0.02 * case.scene.vehicle.length})}
    seconds |= {"stiff": of({"plate.youngs_modulus": 2e15}), "penalty": of({"corner.penalty_scale": 1e4})}
    seconds["refused"] = of({"time.safety_factor": -1.0})
    assert seconds["refused"] == stability_study.CELL_S < seconds["usual"]
    assert min(seconds[name] for name in ("slender", "stiff", "penalty")) > 1.5 * seconds["usual"]


@pytest.mark.parametrize(("name", "changes"), [
    ("paper-table-3", {"vehicle.width": 0.0834}), ("paper-table-3", {"plate.youngs_modulus": 2e13}),
    ("paper-table-3", {"corner.penalty_scale": 1e3}), (LINEAR_TRUCK, {}), (LINEAR_TRUCK, {"impact.speed": 5.0}),
    (LINEAR_TRUCK, {"plate.elements": (20, 6)}),
])  # fmt: skip
def test_the_estimate_of_a_loop_is_that_of_its_plan_within_a_factor(name, changes):
    case = case_of(*read_scene(name))
    base = stability_study.base_source(case.scene)
    seconds = stability_study.expected_seconds(case, base, {"": changes})[""] - stability_study.CELL_S
    planned = case_of(*vary(base, changes)).plan().expected_seconds
    assert 0.3 < seconds / stability_study.LOOPS / planned < 3.0


def test_an_announced_map_has_all_cells_in_their_order_and_says_how_long(tmp_path, monkeypatch):
    said: list[str] = []
    order: list[Any] = []

    def verdict(base, changes, verify):
        order.append(changes)
        return cell_verdicts.verdict("right", steps=len(order), processor_seconds=1.0)

    monkeypatch.delenv(progress.MODE, raising=False)
    monkeypatch.setattr("tailslap.progress.compiling", said.append)
    monkeypatch.setattr(stability_study, "judge", verdict)
    case = CornerCase(*read_scene("paper-table-3"))
    result = stability_study.compute(
        case, tmp_path / "out", points=2, tolerance=1e-3, count=None, seed=1, workers=1
    )
    assert list(result.rows) == list(result.cells)
    expected = stability_study.expected_seconds(case, result.base, result.cells)
    by_start = sorted(result.rows, key=lambda key: result.rows[key]["steps"])
    assert [expected[key] for key in by_start] == sorted(expected.values(), reverse=True)
    assert len(said) == 1
    assert re.fullmatch(r"paper-table-3: 112 cells: expected time [\d:]+ on one core", said[0])


def test_page_and_summary_say_what_was_found(tmp_path):
    case = CornerCase(*read_scene("paper-table-3"))
    axes = axes_of(case.scene, 3)[:2]
    cells, places = map_cells(case.scene, axes)
    caught = cell_verdicts.verdict("caught", failed="energy balance, mesh")
    refused = cell_verdicts.verdict("refused", reason="k: given 3; allowed less")
    left_out = cell_verdicts.verdict("unjudged", reason="estimated time of the time loop 427 s")
    right, wrong = cell_verdicts.verdict("right"), cell_verdicts.verdict("wrong", reason="x")
    verdicts = (*5 * [right], caught, refused, left_out, wrong)
    rows = {key: places[key] | verdict for key, verdict in zip(cells, verdicts, strict=True)}
    base, settings = stability_study.base_source(case.scene), {"tolerance": 1e-3}
    result = stability_study.StabilityResult(
        case, base, axes, settings, cell_verdicts.MAP_KINDS, cells, rows, 1.0
    )
    kinds = "1 refused as invalid, 1 rejected by the checks, 1 undecided, 1 wrong and undetected"
    assert headline(result).answer == f"9 cells: 5 correct, {kinds}."
    assert caught_by(result) == {"energy balance": 1, "mesh": 1}
    assert refused_by(result) == {"k: allowed less": 1}
    printed = report(result)
    write_report(printed, tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    once = dict.fromkeys(list(cell_verdicts.MAP_KINDS)[2:], 1)
    assert summary["counts"] == {"right": 5, "flexible": 0, **once}
    assert not summary["passed"]
    assert len(summary["wrong"]) == 1
    page = (tmp_path / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    charts = set(re.findall(r'download="([^"]+)\.svg"', page))
    assert len(charts) == 2, "set-up and map"
    assert 'class="legend"' in page
    key = next(iter(result.of_kind("wrong")))
    advised = "k: allowed less", "a smaller time.safety_factor", "failed</span>"
    for text in ("undetected error: passed every check", key, left_out["reason"], *advised):
        assert text in page
    assert re.search("unjudged +estimated time", report_text(printed, tmp_path))
    assert len((tmp_path / "cells.csv").read_text().splitlines()) == 10


def test_advice_says_each_thing_once():
    assert advised(["time step", "energy balance", "unknown"]) == "a smaller time.safety_factor"
    assert advised(["penetration", "time step"]).endswith("; a smaller time.safety_factor")
    both = advised(["error of duration", "error of impulse"], impact=True)
    assert both.startswith("refine plate.elements")
    assert both.count("contact.patch_length") == 1
