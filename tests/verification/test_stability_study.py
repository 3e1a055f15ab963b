"""Verify verdicts of the study of stability, on axes and at random."""

import contextlib
import csv
import json
import math
import operator
import re
import signal
import sqlite3
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from itertools import combinations
from types import SimpleNamespace
from typing import Any

import pytest
from processes import alive, children
from shared_cases import LINEAR_TRAIN, LINEAR_TRUCK

from postprocess.report.command_report import report_text, write_report
from postprocess.report.provenance import CRATE
from tailslap import progress
from tailslap.campaign import random_scenes
from tailslap.campaign.engine import run_parts
from tailslap.campaign.records import Journal, count
from tailslap.case import case_of
from tailslap.case.check import Check
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_checks import CHECKS
from tailslap.case.corner.numerical_error import NumericalError
from tailslap.case.impact.case import ImpactCase
from tailslap.case.resources import expected_effort
from tailslap.cli import _status
from tailslap.errors import InputError, Interrupted, Verbatim
from tailslap.scene.read import read_scene, source_of_text
from tailslap.scene.validate import validate
from tailslap.scene.vary import changed_tables, vary
from tailslap.scene.write import scene_file
from tailslap.studies.stability import cell_verdicts, stability_study
from tailslap.studies.stability.stability_axes import axes_of, map_cells
from tailslap.studies.stability.stability_report import advised, caught_by, headline, refused_by, report

COARSE = ("plate.elements=[10,3]",)


def computed(folder, count=None, name="mash-tl4-sut", points=10, tolerance=1e-3):
    """Compute a map, or this number of random cells."""
    case = case_of(*read_scene(name))
    return stability_study.compute(case, folder / "out", points, tolerance, count, seed=1, workers=1)


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


@pytest.mark.parametrize("name", [LINEAR_TRUCK, LINEAR_TRAIN])
def test_random_cells_of_a_whole_impact_vary_every_unit_about_its_own(name):
    scene = read_scene(name)[0]
    base = stability_study.base_source(scene)
    cells, places = stability_study.random_cells(scene, base, 1, 3)
    inputs = {key: value for key, value in ImpactCase(scene, base).inputs.items() if value}
    assert ("trailer.0.hitch" in inputs) == (name != LINEAR_TRUCK)
    for key, changes in cells.items():
        factors = [changes[quantity] / value for quantity, value in inputs.items()]
        assert all(1.0 / random_scenes.SCATTER <= factor <= random_scenes.SCATTER for factor in factors)
        assert len(set(factors)) == len(inputs)
        assert all(places[key][quantity] == changes[quantity] for quantity in inputs)
    assert cells["0002"] == random_scenes.draw(scene, base, 1, 2)


def test_random_cells_of_a_whole_impact_are_judged_as_on_the_map(tmp_path, monkeypatch):
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right())
    case = case_of(*read_scene(LINEAR_TRUCK))
    result = stability_study.compute(case, tmp_path / "out", None, None, 2, 1, 1)
    assert (result.kinds, result.axes, result.settings) == (
        cell_verdicts.MAP_KINDS,
        (),
        {"seed": 1, "tolerance": 1e-2},
    )
    assert headline(result).certainty == "Correct: within 0.01 of the rigid motion or a refined model."


@pytest.fixture
def journal(tmp_path):
    return lambda **definition: Journal(tmp_path / "out", definition)


def interrupt(journal, records):
    with journal as begun:
        begun.records.add(records)
        raise KeyboardInterrupt


def test_journal_is_taken_up_after_an_interrupt_and_removed_at_the_end(journal, tmp_path):
    records = {"x": {"value": 1.5}, "y": {"value": float("inf")}}
    with pytest.raises(Interrupted, match="2 parts are saved"):
        interrupt(journal(a=1), records)
    with journal(a=1) as again:
        assert again.records == records
    assert list(tmp_path.iterdir()) == []


def test_a_link_in_the_place_of_the_journal_is_refused(journal, tmp_path):
    with pytest.raises(Interrupted):
        interrupt(journal(a=1), {"x": 1})
    path = journal(a=1).path
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="not a valid journal"), journal(a=1):
        pass
    assert path.is_symlink()


def test_a_journal_is_not_lost_if_it_cannot_be_begun_anew(journal, monkeypatch):
    """Another program writes to the file, for example."""
    with pytest.raises(Interrupted):
        interrupt(journal(a=1), {"x": 1})
    monkeypatch.setattr("tailslap.campaign.records.PATIENCE_S", 0.1)
    with contextlib.closing(sqlite3.connect(journal(a=1).path)) as connection:
        connection.execute("BEGIN IMMEDIATE")
        with pytest.raises((InputError, OSError), match="locked"), journal(a=2):
            pass
    with journal(a=1) as again:
        assert again.records == {"x": 1}


def test_parts_that_the_journal_has_are_not_run_again(journal):
    with journal(a=1) as noted:
        noted.records.add({"seven": "kept"})
        run_parts(operator.add, {"seven": (3, 4), "five": (2, 3)}, noted, "adding", workers=1)
        assert noted.records == {"seven": "kept", "five": 5}


def started(journal, parts, expected, monkeypatch):
    """Order of the parts of a single worker, and the messages."""
    messages: list[tuple[str, int]] = []
    order: list[str] = []
    monkeypatch.setattr("tailslap.progress.compiling", lambda text: messages.append((text, len(order))))
    with journal(a=1) as noted:
        noted.records.add({"done": None})
        run_parts(order.append, parts, noted, "cells", 1, expected)
        assert noted.records.keys() == parts.keys()
    return order, messages


def test_the_costliest_parts_come_first_none_is_lost_and_the_time_is_said_before(journal, monkeypatch):
    monkeypatch.delenv(progress.MODE, raising=False)
    parts = {key: (key,) for key in ("a", "done", "b", "c", "d")}
    expected = {"a": 10.0, "done": 1000.0, "b": 40.0, "c": 10.0, "d": 60.0}
    order, said = started(journal, parts, expected, monkeypatch)
    assert order == ["d", "b", "a", "c"]
    assert said == [("cells: expected time 2:00 on one core", 0)]


def test_parts_of_unknown_cost_keep_their_order_and_nothing_is_said(journal, monkeypatch):
    parts = {key: (key,) for key in ("b", "done", "c", "a")}
    assert started(journal, parts, {}, monkeypatch) == (["b", "c", "a"], [])


def test_silent_progress_announces_no_time(journal, monkeypatch):
    monkeypatch.setenv(progress.MODE, "none")
    assert started(journal, {"done": (), "a": ("a",)}, {"a": 1.0}, monkeypatch) == (["a"], [])


def test_the_time_left_is_that_of_the_work_which_is_left(monkeypatch):
    monkeypatch.setattr(progress, "_time_left", lambda rest, part, elapsed: f"{rest:g} after {part:g}")
    lines: list[str] = []
    work = [0.0, 0.5, 1.0, 10.0]
    remaining = lambda n: work[4 - round(n)]  # noqa: E731
    with progress.followed(lines.append), progress.counted("x", 4, 1, work_left=remaining) as show:
        show(2)
        show(4)
    assert [line.rpartition(", ")[2] for line in lines] == ["1 after 9", "0 after 10"]


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


def test_the_report_shows_the_ten_costliest_cells_and_the_processor_time_of_all(tmp_path):
    rows = {
        f"{n:04d}": cell_verdicts.verdict("right", steps=n, processor_seconds=float(n)) for n in range(1, 25)
    }
    result = campaign_of()._replace(rows=rows, cells={key: {} for key in rows})
    write_report(report(result), tmp_path)
    cost = json.loads((tmp_path / "summary.json").read_text())["cost"]
    assert cost["processor_seconds"] == 300.0
    assert [row["cell"] for row in cost["costliest"]] == [f"{n:04d}" for n in range(24, 14, -1)]
    assert cost["costliest"][0]["share"] == 0.08
    page = (tmp_path / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    assert "Processor time of all 24 cells: 300 s; these 10 take 65%." in page
    assert "8.0%" in page


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


@pytest.mark.long
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_study_that_is_ended_keeps_what_was_done_and_leaves_no_process(tmp_path, sent):
    """Two parts sleep for ten minutes, and end with their workers."""
    code = (
        "import time\nfrom pathlib import Path\nfrom tailslap.campaign.engine import run_parts\n"
        "from tailslap.campaign.records import Journal\nif __name__ == '__main__':\n"
        "    parts = {'short': (0.0,), 'long': (600.0,), 'longer': (600.0,)}\n"
        f"    with Journal(Path({str(tmp_path / 'out')!r}), {{}}) as journal:\n"
        "        run_parts(time.sleep, parts, journal, 'x', workers=2)\n"
    )
    script = tmp_path / "script.py"
    script.write_text(code)
    journal = tmp_path / ".out.journal"
    process = subprocess.Popen([sys.executable, str(script)], stderr=subprocess.PIPE, text=True)
    for _ in range(4800):
        if journal.is_file() and count(journal):
            break
        time.sleep(0.05)
    below = children(process.pid)
    assert len(below) >= 2
    began = time.monotonic()
    process.send_signal(sent)
    _, error = process.communicate(timeout=120)
    while any(map(alive, below)):
        assert time.monotonic() - began < 120.0
        time.sleep(0.05)
    assert ("1 parts are saved" in error, count(journal)) == (sent == signal.SIGINT, 1)


@pytest.mark.long
def test_a_part_s_error_is_raised_as_it_was(journal):
    """It keeps its type across processes, and earlier parts remain."""
    for workers in (1, 2):
        with pytest.raises(InputError, match="SCENE: given nothing-1; x"), journal(workers=workers) as noted:
            run_parts(raising, {"a": (0,), "b": (1,)}, noted, "raising", workers)
        with journal(workers=workers) as again:
            assert again.records == {"a": 0}


def raising(number):
    if number:
        time.sleep(1.0)
        raise InputError("SCENE", Verbatim(f"nothing-{number}"), "x")
    return number


SCENE = read_scene("mash-tl4-sut")[0]
BASE = stability_study.base_source(SCENE)
DRAWN = [changed_tables(BASE.tables, random_scenes.draw(SCENE, BASE, 1, number))[0] for number in range(90)]


def test_a_draw_is_known_by_seed_and_number():
    drawn = [random_scenes.draw(SCENE, BASE, seed, 7) for seed in (1, 1, 2)]
    assert drawn[0] == drawn[1] != drawn[2]
    assert DRAWN[7] != DRAWN[8]


@pytest.mark.parametrize("scene", ["mash-tl4-sut", "paper-table-3", "paper-abaqus"])
def test_draws_are_scenes_that_can_be_planned_and_afforded(scene):
    scene_drawn = read_scene(scene)[0]
    base = stability_study.base_source(scene_drawn)
    for number in range(20):
        plan = CornerCase(*vary(base, random_scenes.draw(scene_drawn, base, 3, number)))
        assert expected_effort(plan.scene, plan.motion.strike.t).steps <= 400_000


def test_a_third_starts_unstressed_and_the_others_share_the_rest():
    starts = [tables["plate"]["start"] for tables in DRAWN]
    kinds = ("unstressed", "inertia-relief", "inertia-relief-momenta")
    assert {name: starts.count(name) for name in starts} == dict.fromkeys(kinds, 30)


CHOICES = {
    "plate.element": {"open", "quad4", "quad4-reduced", "quad9", "tri3", "tri6"}, "plate.lumping": {"open", "row-sum"},
    "corner.constraint": {"open", "penalty", "exact"}, "corner.reaction": {"drag", "none", "signed"},
    "material.law": {"open", "neo-hookean"}, "damping.kind": {"open", "none"},
}  # fmt: skip


def test_every_choice_of_the_scene_is_drawn():
    def seen(table, key):
        return {tables.get(table, {}).get(key, "open") for tables in DRAWN}

    for key, values in CHOICES.items():
        assert seen(*key.split(".")) == values
    for table, key in (("plate", "elements"), ("damping", "ratio"), ("damping", "bulk_viscosity")):
        assert "open" in seen(table, key)
        assert len(seen(table, key)) > 1
    for key in ("patch_length", "penalty_scale", "damping_ratio"):
        assert len(seen("corner", key)) > 5
    assert len(seen("plate", "first_frequency")) > 10


def test_cells_of_a_combination_share_choices_and_nothing_else():
    """Compiled choices are shared, starts alternate."""
    cells = [random_scenes.draw(SCENE, BASE, 1, 5 + k * random_scenes.COMBINATIONS) for k in range(6)]
    chosen = random_scenes.choices_of(1, 5, 0)
    for key in ("corner.reaction", "material.law", "plate.lumping"):
        assert len({cell.get(key) for cell in cells}) == 1
    assert {cell["corner.reaction"] for cell in cells} == {chosen["reaction"]}
    assert {"corner.patch_length" in cell for cell in cells} == {chosen["patch"]}
    assert len({cell["plate.start"] for cell in cells}) == 3
    assert len({cell["vehicle.length"] for cell in cells}) == 6


def test_nearly_any_two_choices_meet():
    drawn = [random_scenes.choices_of(1, number, 0).items() for number in range(random_scenes.COMBINATIONS)]
    values = {item for choices in drawn for item in choices}
    pairs = {frozenset(pair) for choices in drawn for pair in combinations(choices, 2)}
    possible = {frozenset(pair) for pair in combinations(values, 2) if pair[0][0] != pair[1][0]}
    assert len(pairs) > 0.93 * len(possible)


def test_a_scene_without_possible_draws_is_refused(monkeypatch):
    monkeypatch.setattr("tailslap.campaign.random_scenes.MAX_STEPS", 10)
    monkeypatch.setattr("tailslap.campaign.random_scenes.MAX_TRIES", 5)
    with pytest.raises(InputError, match="none of 5 random scenes"):
        random_scenes.draw(SCENE, BASE, 1, 0)


def test_a_draw_read_from_its_file_is_the_same_scene():
    for tables in DRAWN:
        assert vary(source_of_text(scene_file(tables, "x")), {})[0] == validate(tables)


def five(value):
    return {"t": value, "v_gx": 0.0, "v_gy": -value, "omega": 0.5 * value, "slide": value}


MESH, REACTION = ("mesh",), ("reaction against rigid",)


@pytest.mark.parametrize(("omega", "failed", "truth", "kind"), [
    (0.10, (), 0.11, "right"), (0.10, (), 0.13, "right"), (0.10, (), 0.05, "wrong"),
    (0.0021, (), 0.0005, "wrong"), (0.0010, (), 0.0005, "right"), (0.10, (), None, "unjudged"),
    (0.10, REACTION, 0.105, "reaction only"), (0.10, REACTION, 0.12, "caught"), (0.10, MESH, 0.12, "caught"),
    (0.10, ("mesh", "mean residual"), 0.105, "good but failed"), (0.10, MESH, 0.5, "caught"),
    (0.10, MESH, None, "unjudged"), (None, ("tail-slap reached",), None, "caught"), (None, (), None, "wrong"),
    (math.nan, (), 0.1, "wrong"), (math.inf, ("finite numbers",), 0.1, "caught"),
])  # fmt: skip
def test_verdicts(omega, failed, truth, kind):
    reference = None if truth is None else cell_verdicts.Reference(five(truth), "quad9", 1.0, ({}, {}))
    graded = cell_verdicts.grade({} if omega is None else five(omega), failed, reference, 0.0)
    assert (graded["kind"], graded["failed"]) == (kind, ", ".join(failed))


def test_the_distance_is_that_of_the_quantity_that_is_farthest_off():
    reference = cell_verdicts.Reference(five(0.01), "quad9", 1.0, ({}, {}))
    graded = cell_verdicts.grade(five(0.01) | {"omega": 0.5}, (), reference, 0.0)
    assert graded["distance"] == pytest.approx(0.495)
    assert graded["allowed"] == pytest.approx(1e-3 + 0.25 * 0.01)


def test_what_is_right_by_chance_is_not_right_beyond_doubt():
    """Oscillations that differ before the strike justify a failed check."""
    reference = cell_verdicts.Reference(five(0.1), "quad9", 1.0, ({}, {}))
    verdicts = [
        cell_verdicts.grade(five(0.1), ("numerical error",), reference, apart) for apart in (0.008, 0.009)
    ]
    kinds = [verdict["kind"] for verdict in verdicts]
    assert kinds == ["good but failed", "caught"]
    assert cell_verdicts.grade(five(0.1), (), reference, 0.5)["kind"] == "right"


@pytest.mark.parametrize(
    ("second_value", "kind"), [(0.1, "good but failed"), (0.12, "caught"), (None, "caught")]
)
def test_two_references_say_what_is_beyond_doubt(second_value, kind, monkeypatch, soft):
    """One reference may agree by chance, and a single one is insufficient."""
    histories = soft.fe_history, soft.rigid_history
    mesh = Check.at_most("mesh", 1.0, 0.0, "made to fail")
    failed = replace(soft, difference=five(0.1), checks=(mesh,))
    first = cell_verdicts.Reference(five(0.1), "quad9 15 x 5", 1.0, histories)
    second = (
        None
        if second_value is None
        else cell_verdicts.Reference(five(second_value), "quad9 20 x 6", 1.0, histories)
    )
    kinds = {
        cell_verdicts.FIRST: iter([first]),
        cell_verdicts.SECOND: iter([first, second] if second else [first]),
    }
    monkeypatch.setattr(cell_verdicts, "references", lambda cell, factors: kinds[factors])
    assert cell_verdicts.against_reference(failed)["kind"] == kind


def test_a_second_reference_is_another_model():
    cell = CornerCase(*vary(SMALL, {})).plan()
    assert next(cell_verdicts.references(cell, cell_verdicts.FIRST)).model == "quad9 15 x 5"
    models = [reference.model for reference in cell_verdicts.references(cell, cell_verdicts.SECOND)]
    assert models[:2] == ["quad9 20 x 6", "quad9 10 x 3"]


def test_no_reference_is_damped_where_the_plate_oscillates(monkeypatch):
    calls = []

    def noted(scene, plate, finer, ratio=0.0):
        calls.append(ratio)
        raise InputError("plate.elements", finer, "no model")

    monkeypatch.setattr("tailslap.studies.stability.cell_verdicts.reference_changes", noted)
    for start, damped in (("inertia-relief", True), ("unstressed", False)):
        calls.clear()
        cell = CornerCase(*vary(SMALL, {"plate.start": start})).plan()
        assert next(cell_verdicts.references(cell, cell_verdicts.FIRST), None) is None
        assert any(calls) is damped


SOFT = ("plate.elements=[10,3]", "plate.youngs_modulus=20 MPa")
SMALL = stability_study.base_source(read_scene("paper-table-3", SOFT)[0])
"""A cell that runs at once, of a plate soft enough to matter."""


@pytest.fixture(scope="module")
def soft():
    return CornerCase(*vary(SMALL, {})).run()


def verdict_by_reference(changes):
    return cell_verdicts.judge(SMALL, changes, cell_verdicts.against_reference)


def test_a_refined_model_is_the_same_plate_held_exactly():
    plate_keys = {"element": "quad4-reduced", "distortion": 0.1, "start": "unstressed"}
    corner_keys = {"penalty_scale": 0.1, "damping_ratio": 0.1, "patch_length": 2.0}
    changes = {f"plate.{key}": value for key, value in plate_keys.items()}
    changes |= {f"corner.{key}": value for key, value in corner_keys.items()}
    source, cell = vary(SMALL, {**changes, "damping.ratio": 0.3, "material.law": "neo-hookean"})
    refined = vary(cell, cell_verdicts.reference_changes(source, source.needed_plate, 1.5))[0]
    plate = refined.needed_plate
    assert (plate.element, plate.counts) == ("quad9", (15, 5))
    assert (plate.start, plate.distortion, refined.damping) == ("unstressed", 0.0, None)
    assert refined.material == source.material
    assert (refined.corner.constraint, refined.corner.patch_length) == ("exact", 2.0)
    calmed = vary(cell, cell_verdicts.reference_changes(source, source.needed_plate, 1.5, 0.05))[0]
    assert calmed.damping is not None
    assert calmed.damping.ratio == 0.05
    left_open = vary(SMALL, {})[0]
    assert "corner.constraint" not in cell_verdicts.reference_changes(left_open, left_open.needed_plate, 1.5)


def test_a_refined_mesh_has_its_limit():
    scene = vary(SMALL, {})[0]
    plates = (scene.needed_plate.model_copy(update={"elements": counts}) for counts in ((10, 4), (40, 12)))
    refined = (cell_verdicts.reference_changes(scene, plate, 1.5) for plate in plates)
    small, (along, across) = (changes["plate.elements"] for changes in refined)
    assert small == (15, 6)
    assert along * across <= 1.1 * cell_verdicts.MAX_ELEMENTS


@pytest.mark.long
def test_a_right_cell_and_a_spring_too_soft():
    assert verdict_by_reference({"plate.element": "quad9"})["kind"] == "right"
    assert verdict_by_reference({"corner.penalty_scale": 0.01})["kind"] == "caught"


def test_a_wrong_answer_that_no_check_catches_is_wrong(monkeypatch):
    monkeypatch.setattr("tailslap.case.corner.corner_run.evaluated", lambda *arguments: ())
    assert verdict_by_reference({"corner.penalty_scale": 0.01})["kind"] == "wrong"


@pytest.mark.long
def test_refused_broken_and_unjudged_cells(monkeypatch):
    assert verdict_by_reference({"plate.element": "hexagon"})["kind"] == "refused"
    monkeypatch.setattr(cell_verdicts, "references", lambda *arguments: iter(()))
    assert verdict_by_reference({})["kind"] == "unjudged"
    monkeypatch.setattr(cell_verdicts, "references", breaks)
    assert verdict_by_reference({})["reason"] == "reference broke: ZeroDivisionError: boom"
    monkeypatch.setattr("tailslap.case.corner.corner_run.evaluated", breaks)
    broken = verdict_by_reference({})
    assert (broken["kind"], broken["reason"]) == ("wrong", "broke: ZeroDivisionError: boom")


def test_a_reference_that_fails_a_check_or_is_swayed_or_fed_is_not_trusted(soft):
    assert cell_verdicts.trustworthy(soft)
    ringing = Check.at_most("reaction against rigid", 1.0, 0.0, "made to fail")
    assert cell_verdicts.trustworthy(replace(soft, checks=(ringing,)))
    for name in ("energy balance", "friction work", "contact work"):
        failed = Check.at_most(name, 1.0, 0.0, "made to fail")
        assert not cell_verdicts.trustworthy(replace(soft, checks=(failed,)))
    for energy in (1.0, 2.0):  # over that of the start: twice as much has come from friction
        swings = Check.at_most("oscillation", energy, 9.0, "made to pass")
        assert cell_verdicts.trustworthy(replace(soft, checks=(swings,))) == (energy < 1.25)
    swayed = replace(soft)
    vars(swayed)["error"] = replace(soft.error, damping=0.1)
    assert not cell_verdicts.trustworthy(swayed)
    assert not cell_verdicts.trustworthy(replace(soft, difference={}))


def test_where_no_reference_is_trusted_there_is_none(monkeypatch):
    cell = CornerCase(*vary(SMALL, {})).plan()
    assert not list(cell_verdicts.references(cell, cell_verdicts.FIRST, longest=0.0))


def campaign_of(*kinds):
    case = CornerCase(*read_scene("mash-tl4-sut"))
    failed, cells, rows = {"caught": "mesh, time step", "good but failed": "mesh"}, {}, {}
    for number, kind in enumerate(kinds):
        key = f"{number:04d}"
        cells[key] = random_scenes.draw(SCENE, BASE, 1, number)
        rows[key] = {"number": number, **stability_study.flat(DRAWN[number])}
        rows[key] |= cell_verdicts.verdict(kind, failed=failed.get(kind, ""), distance=0.1, allowed=0.01)
    meanings, settings = cell_verdicts.RANDOM_KINDS, {"seed": 1}
    return stability_study.StabilityResult(case, BASE, (), settings, meanings, cells, rows, 1.0)


def test_the_result_folder_holds_every_draw_and_the_cells_that_matter(tmp_path):
    printed = report(campaign_of(*cell_verdicts.RANDOM_KINDS))
    write_report(printed, tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    cells = {"cells.csv", "cell-0002.toml", "cell-0006.toml"}
    assert names == {"report.html", "set-up.svg", "summary.json", CRATE} | cells
    counts = json.loads((tmp_path / "summary.json").read_text())["counts"]
    assert counts == dict.fromkeys(cell_verdicts.RANDOM_KINDS, 1)
    with (tmp_path / "cells.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows] == list(cell_verdicts.RANDOM_KINDS)
    caught = rows[list(cell_verdicts.RANDOM_KINDS).index("caught")]
    assert "time.safety_factor" in caught["what could be changed"]
    assert float(rows[0]["vehicle.length"]) == stability_study.flat(DRAWN[0])["vehicle.length"]
    page = (tmp_path / "report.html").read_text()
    for text in ("unjudged", "failed</span>"):
        assert text in page
    assert re.search("0006 +wrong", report_text(printed, tmp_path))


@pytest.mark.long
def test_a_cells_file_can_be_run(tmp_path):
    result = campaign_of("wrong")._replace(base=SMALL, cells={"0000": {}})
    write_report(report(result), tmp_path)
    assert CornerCase(*read_scene(str(tmp_path / "cell-0000.toml"))).run().fe


def test_a_survey_is_made_of_its_draws_and_its_journal_goes(tmp_path, monkeypatch):
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right())
    case, place = CornerCase(*read_scene("mash-tl4-sut")), tmp_path / "out"
    result = stability_study.compute(case, place, points=10, tolerance=1e-3, count=4, seed=1, workers=1)
    assert [changed_tables(result.base.tables, cell)[0] for cell in result.cells.values()] == DRAWN[:4]
    assert (len(result.of_kind("right")), list(tmp_path.iterdir())) == (4, [])


def all_right(stop_at=""):
    """Replacement of run_parts with right verdicts, interrupted at `stop_at`."""

    def run(function, parts, journal, *rest):
        for key in parts:
            if key == stop_at:
                raise KeyboardInterrupt
            if key not in journal.records:
                journal.records.add({key: cell_verdicts.verdict("right", steps=len(parts))})

    return run


def test_an_interrupted_campaign_goes_on_with_more_cells(tmp_path, monkeypatch):
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right(stop_at="0002"))
    with pytest.raises(Interrupted, match="2 parts are saved"):
        computed(tmp_path, 3)
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right())
    result = computed(tmp_path, 4)
    assert [row["steps"] for row in result.rows.values()] == [3, 3, 4, 4]


@pytest.mark.long
@pytest.mark.parametrize(("arguments", "folder", "cells"), [
    (("--random", "2"), "paper-table-3-random", 2), (("--points", "2"), "paper-table-3-stability", 112),
])  # fmt: skip
def test_map_and_random_cells_have_folders_of_their_own(tmp_path, monkeypatch, arguments, folder, cells):
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right())
    monkeypatch.chdir(tmp_path)
    assert _status(["study", "stability", "paper-table-3", *arguments]) == 0
    summary = json.loads((tmp_path / "results" / folder / "summary.json").read_text())
    assert (summary["cells"], summary["counts"]["right"], summary["passed"]) == (cells, cells, True)


@pytest.mark.parametrize("start", ["inertia-relief", "unstressed"])
def test_every_check_has_advice(start):
    scene, source = vary(SMALL, {"plate.start": start, "verify.tolerance": 1e-3})
    names = {check.name for check in CornerCase(scene, source).run().checks}
    assert names <= {name for name, kind in CHECKS.items() if kind.advice}


def test_advice_says_each_thing_once():
    assert advised(["time step", "energy balance", "unknown"]) == "a smaller time.safety_factor"
    assert advised(["penetration", "time step"]).endswith("; a smaller time.safety_factor")
    both = advised(["error of duration", "error of impulse"], impact=True)
    assert both.startswith("refine plate.elements")
    assert both.count("contact.patch_length") == 1
