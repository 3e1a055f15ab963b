"""Verification: random scenes are drawn alike every time, judged by a refined model, and can be run again."""

import csv
import json
import re
from dataclasses import replace
from itertools import combinations
from typing import Any

import pytest

from postprocess.report.report import report_text, write_report
from tailslap.case.checks import Check, advice
from tailslap.case.corner.case import CornerCase
from tailslap.case.corner.checks import CHECKS
from tailslap.case.cost import expected_effort
from tailslap.cli import _status
from tailslap.errors import InputError, Interrupted
from tailslap.scene.read import read_scene, source_of_text
from tailslap.scene.validate import validate
from tailslap.scene.vary import Changes, changed_tables, vary
from tailslap.scene.write import scene_file
from tailslap.studies.stability import compute as study
from tailslap.studies.stability.compute import (
    COMBINATIONS,
    ELEMENTS,
    FINER,
    FINEST,
    MAX_ELEMENTS,
    RANDOM_KINDS,
    Found,
    Reference,
    base_source,
    choices_of,
    draw,
    flat,
    grade,
    reference_changes,
    references,
    trustworthy,
    verdict,
)
from tailslap.studies.stability.report import report

TRUCK = read_scene("mash-tl4-sut")[0]
BASE = base_source(TRUCK)
DRAWN = [changed_tables(BASE.given, draw(TRUCK, BASE, 1, number))[0] for number in range(90)]


def test_a_draw_is_known_by_seed_and_number():
    assert draw(TRUCK, BASE, 1, 7) == draw(TRUCK, BASE, 1, 7) != draw(TRUCK, BASE, 2, 7)
    assert DRAWN[7] != DRAWN[8]


@pytest.mark.parametrize("scene", ["mash-tl4-sut", "paper-table-3", "paper-abaqus"])
def test_draws_are_scenes_that_can_be_planned_and_afforded(scene):
    own = read_scene(scene)[0]
    base = base_source(own)
    for number in range(20):
        plan = CornerCase(*vary(base, draw(own, base, 3, number)))
        assert expected_effort(plan.scene, plan.motion.strike.t).steps <= 400_000


def test_a_third_starts_unstressed_and_the_others_share_the_rest():
    starts = [tables["plate"]["start"] for tables in DRAWN]
    assert {name: starts.count(name) for name in starts} == {
        "unstressed": 30,
        "inertia-relief": 30,
        "inertia-relief-momenta": 30,
    }


def test_every_choice_of_the_scene_is_drawn():
    def seen(table: str, key: str) -> set[Any]:
        return {tables.get(table, {}).get(key, "open") for tables in DRAWN}

    assert seen("plate", "element") == {"open", *ELEMENTS}
    assert seen("corner", "constraint") == {"open", "penalty", "exact"}
    assert seen("corner", "reaction") == {"drag", "none", "signed"}
    assert seen("plate", "lumping") == {"open", "row-sum"}
    assert seen("material", "law") == {"open", "neo-hookean"}
    assert seen("damping", "kind") == {"open", "none"}
    for table, key in (("plate", "elements"), ("damping", "ratio"), ("damping", "bulk_viscosity")):
        assert "open" in seen(table, key)
        assert len(seen(table, key)) > 1
    for key in ("patch_length", "penalty_scale", "damping_ratio"):
        assert len(seen("corner", key)) > 5
    assert len(seen("plate", "first_frequency")) > 10


def test_cells_of_a_combination_share_choices_and_nothing_else():
    """What is compiled for one serves the others; starts, which need no code of their own, go round."""
    cells = [draw(TRUCK, BASE, 1, 5 + k * COMBINATIONS) for k in range(6)]
    chosen = choices_of(1, 5, 0)
    for key in ("corner.reaction", "material.law", "plate.lumping"):
        assert len({cell.get(key) for cell in cells}) == 1
    assert {cell["corner.reaction"] for cell in cells} == {chosen["reaction"]}
    assert {"corner.patch_length" in cell for cell in cells} == {chosen["patch"]}
    assert len({cell["plate.start"] for cell in cells}) == 3
    assert len({cell["vehicle.length"] for cell in cells}) == 6


def test_nearly_any_two_choices_meet():
    drawn = [choices_of(1, number, 0).items() for number in range(COMBINATIONS)]
    values = {item for choices in drawn for item in choices}
    pairs = {frozenset(pair) for choices in drawn for pair in combinations(choices, 2)}
    possible = {frozenset(pair) for pair in combinations(values, 2) if pair[0][0] != pair[1][0]}
    assert len(pairs) > 0.93 * len(possible)


def test_a_scene_without_possible_draws_is_refused(monkeypatch):
    monkeypatch.setattr("tailslap.studies.stability.compute.MAX_STEPS", 10)
    monkeypatch.setattr("tailslap.studies.stability.compute.MAX_TRIES", 5)
    with pytest.raises(InputError, match="none of 5 draws"):
        draw(TRUCK, BASE, 1, 0)


def test_a_draw_read_from_its_file_is_the_same_scene():
    for tables in DRAWN:
        assert vary(source_of_text(scene_file(tables, "x")), {})[0] == validate(tables)


def five(value: float) -> dict[str, float]:
    return {"t": value, "v_gx": 0.0, "v_gy": -value, "omega": 0.5 * value, "slide": value}


@pytest.mark.parametrize(
    ("found", "failed", "truth", "kind"),
    [
        (0.10, (), 0.11, "right"),
        (0.10, (), 0.13, "right"),
        (0.10, (), 0.05, "wrong"),
        (0.0021, (), 0.0005, "wrong"),
        (0.0010, (), 0.0005, "right"),
        (0.10, ("reaction against rigid",), 0.105, "reaction only"),
        (0.10, ("reaction against rigid",), 0.12, "caught"),
        (0.10, ("mesh", "mean residual"), 0.105, "good but failed"),
        (0.10, ("mesh",), 0.12, "caught"),
        (0.10, ("mesh",), 0.5, "caught"),
        (0.10, (), None, "unjudged"),
        (0.10, ("mesh",), None, "unjudged"),
        (None, ("tail-slap reached",), None, "caught"),
        (None, (), None, "wrong"),
        (float("nan"), (), 0.1, "wrong"),
        (float("inf"), ("finite numbers",), 0.1, "caught"),
    ],
)
def test_verdicts(found, failed, truth, kind):
    reference = None if truth is None else Reference(five(truth), "quad9", 1.0, ({}, {}))
    graded = grade({} if found is None else five(found), failed, reference, 0.0)
    assert (graded["kind"], graded["failed"]) == (kind, ", ".join(failed))


def test_the_distance_is_that_of_the_quantity_that_is_farthest_off():
    graded = grade(five(0.01) | {"omega": 0.5}, (), Reference(five(0.01), "quad9", 1.0, ({}, {})), 0.0)
    assert graded["distance"] == pytest.approx(0.495)
    assert graded["allowed"] == pytest.approx(1e-3 + 0.25 * 0.01)


def test_what_is_right_by_chance_is_not_right_beyond_doubt():
    """Oscillations that agree at the strike, and lie apart before it: a check that fails for it has its reason."""
    reference = Reference(five(0.1), "quad9", 1.0, ({}, {}))
    kinds = [grade(five(0.1), ("numerical error",), reference, apart)["kind"] for apart in (0.008, 0.009)]
    assert kinds == ["good but failed", "caught"]
    assert grade(five(0.1), (), reference, 0.5)["kind"] == "right"


@pytest.mark.parametrize(("other", "kind"), [(0.1, "good but failed"), (0.12, "caught"), (None, "caught")])
def test_two_references_say_what_is_beyond_doubt(other, kind, monkeypatch):
    """One may agree by chance, and where there is no other there is doubt."""
    outcome = CornerCase(*vary(SMALL, {})).run()
    histories = outcome.fe_history, outcome.rigid_history
    mesh = Check.at_most("mesh", 1.0, 0.0, "made to fail")
    failed = replace(outcome, difference=five(0.1), checks=(mesh,))
    first = Reference(five(0.1), "quad9 15 x 5", 1.0, histories)
    second = None if other is None else Reference(five(other), "quad9 20 x 6", 1.0, histories)
    found = {FINER: iter([first]), FINEST: iter([first, second] if second else [first])}
    monkeypatch.setattr(study, "references", lambda cell, plate, finest: found[finest])
    assert study.against_reference(failed)["kind"] == kind


def test_a_second_reference_is_another_model():
    plate = vary(SMALL, {})[0].needed_plate
    assert next(references(SMALL, plate, FINER)).model == "quad9 15 x 5"
    assert [found.model for found in references(SMALL, plate, FINEST)][:2] == ["quad9 20 x 6", "quad9 10 x 3"]


def test_no_reference_is_damped_where_the_plate_oscillates(monkeypatch):
    asked = []

    def noted(plate: Any, finer: float, ratio: float = 0.0) -> Any:
        asked.append(ratio)
        raise InputError("plate.elements", finer, "no model")

    monkeypatch.setattr("tailslap.studies.stability.compute.reference_changes", noted)
    for start, damped in (("inertia-relief", True), ("unstressed", False)):
        asked.clear()
        plate = vary(SMALL, {"plate.start": start})[0].plate
        assert plate is not None
        assert next(references(SMALL, plate, FINER), None) is None
        assert any(asked) is damped


SMALL = base_source(read_scene("paper-table-3", ("plate.elements=[10,3]", "plate.youngs_modulus=20 MPa"))[0])
"""A cell that runs at once, of a plate soft enough to matter."""


def verdict_of(changes: Changes) -> dict[str, Any]:
    return study.judge(SMALL, changes, study.against_reference)


def test_a_refined_model_is_the_same_plate_held_exactly():
    plate_keys = {"element": "quad4-reduced", "distortion": 0.1, "start": "unstressed"}
    corner_keys = {"penalty_scale": 0.1, "damping_ratio": 0.1, "patch_length": 2.0}
    changes = {f"plate.{key}": value for key, value in plate_keys.items()}
    changes |= {f"corner.{key}": value for key, value in corner_keys.items()}
    own, cell = vary(SMALL, {**changes, "damping.ratio": 0.3, "material.law": "neo-hookean"})
    plate = own.plate
    assert plate is not None
    refined = vary(cell, reference_changes(plate, 1.5))[0]
    assert refined.plate is not None
    assert (refined.plate.element, refined.plate.counts) == ("quad9", (15, 5))
    assert (refined.plate.start, refined.plate.distortion, refined.damping) == ("unstressed", 0.0, None)
    assert refined.material == own.material
    assert (refined.corner.constraint, refined.corner.patch_length) == ("exact", 2.0)
    calmed = vary(cell, reference_changes(plate, 1.5, 0.05))[0]
    assert calmed.damping is not None
    assert calmed.damping.ratio == 0.05


def test_a_refined_mesh_has_its_limit():
    plate = vary(SMALL, {})[0].needed_plate
    refined = {
        counts: reference_changes(plate.model_copy(update={"elements": counts}), 1.5)["plate.elements"]
        for counts in ((10, 4), (40, 12))
    }
    assert refined[10, 4] == (15, 6)
    along, across = refined[40, 12]
    assert along * across <= 1.1 * MAX_ELEMENTS


@pytest.mark.long
def test_a_right_cell_and_a_spring_too_soft():
    assert verdict_of({"plate.element": "quad9"})["kind"] == "right"
    assert verdict_of({"corner.penalty_scale": 0.01})["kind"] == "caught"


def test_a_wrong_answer_that_no_check_catches_is_wrong(monkeypatch):
    monkeypatch.setattr("tailslap.case.corner.run.evaluated", lambda *arguments: ())
    assert verdict_of({"corner.penalty_scale": 0.01})["kind"] == "wrong"


@pytest.mark.long
def test_refused_broken_and_unjudged_cells(monkeypatch):
    assert verdict_of({"plate.element": "hexagon"})["kind"] == "refused"
    monkeypatch.setattr(study, "references", lambda *arguments: iter(()))
    assert verdict_of({})["kind"] == "unjudged"

    def breaks(*arguments: Any) -> None:
        raise ZeroDivisionError("boom")

    monkeypatch.setattr(study, "references", breaks)
    assert verdict_of({})["reason"] == "reference broke: ZeroDivisionError: boom"
    monkeypatch.setattr("tailslap.case.corner.run.evaluated", breaks)
    broken = verdict_of({})
    assert (broken["kind"], broken["reason"]) == ("wrong", "broke: ZeroDivisionError: boom")


def test_a_reference_that_fails_a_check_or_is_swayed_or_fed_is_not_trusted():
    outcome = CornerCase(*vary(SMALL, {})).run()
    assert trustworthy(outcome)
    ringing = Check.at_most("reaction against rigid", 1.0, 0.0, "made to fail")
    assert trustworthy(replace(outcome, checks=(ringing,)))
    for name in ("energy balance", "friction work", "contact work"):
        failed = Check.at_most(name, 1.0, 0.0, "made to fail")
        assert not trustworthy(replace(outcome, checks=(failed,)))
    for energy in (1.0, 2.0):  # over that of the start: twice as much has come from friction
        swings = Check.at_most("oscillation", energy, 9.0, "made to pass")
        assert trustworthy(replace(outcome, checks=(swings,))) == (energy < 1.25)
    assert not trustworthy(replace(outcome, error=replace(outcome.error, damping=0.1)))
    assert not trustworthy(replace(outcome, difference={}))


def test_where_no_reference_is_trusted_there_is_none(monkeypatch):
    plate = vary(SMALL, {})[0].plate
    assert plate is not None
    monkeypatch.setattr("tailslap.studies.stability.compute.MAX_REFERENCE_S", 0.0)
    assert not list(references(SMALL, plate, FINER))


def campaign_of(*kinds: str) -> Found:
    case = CornerCase(*read_scene("mash-tl4-sut"))
    failed, cells, rows = {"caught": "mesh, time step", "good but failed": "mesh"}, {}, {}
    for number, kind in enumerate(kinds):
        key = f"{number:04d}"
        cells[key] = draw(TRUCK, BASE, 1, number)
        rows[key] = {"number": number, **flat(DRAWN[number])}
        rows[key] |= verdict(kind, failed=failed.get(kind, ""), distance=0.1, allowed=0.01)
    return Found(case, BASE, (), {"seed": 1}, RANDOM_KINDS, cells, rows, 1.0)


def test_the_result_folder_holds_every_draw_and_the_cells_that_matter(tmp_path):
    made = report(campaign_of(*RANDOM_KINDS))
    write_report(made, tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"report.html", "cells.csv", "summary.json", "cell-0002.toml", "cell-0006.toml"}
    assert json.loads((tmp_path / "summary.json").read_text())["counts"] == dict.fromkeys(RANDOM_KINDS, 1)
    with (tmp_path / "cells.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows] == list(RANDOM_KINDS)
    assert "time.safety_factor" in rows[list(RANDOM_KINDS).index("caught")]["what could be changed"]
    assert float(rows[0]["vehicle.length"]) == flat(DRAWN[0])["vehicle.length"]
    page = (tmp_path / "report.html").read_text()
    assert "unjudged" in page
    assert "failed</span>" in page
    assert re.search("0006 +wrong", report_text(made, tmp_path))


@pytest.mark.long
def test_a_cells_file_can_be_run(tmp_path):
    found = campaign_of("wrong")._replace(base=SMALL, cells={"0000": {}})
    write_report(report(found), tmp_path)
    assert CornerCase(*read_scene(str(tmp_path / "cell-0000.toml"))).run().fe


def test_a_survey_is_made_of_its_draws_and_its_journal_goes(tmp_path, monkeypatch):
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right())
    case, place = CornerCase(*read_scene("mash-tl4-sut")), tmp_path / "out"
    found = study.compute(case, place, points=10, tolerance=1e-3, count=4, seed=1, workers=1)
    assert [changed_tables(found.base.given, cell)[0] for cell in found.cells.values()] == DRAWN[:4]
    assert len(found.of_kind("right")) == 4
    assert list(tmp_path.iterdir()) == []


def all_right(stop_at: str = "") -> Any:
    """Instead of run_parts: every part that the journal lacks is right; an interrupt at the key `stop_at`."""

    def run(function: Any, parts: Any, journal: Any, *rest: Any) -> None:
        for key in parts:
            if key == stop_at:
                raise KeyboardInterrupt
            if key not in journal.records:
                journal.add(key, verdict("right", steps=len(parts)))

    return run


def test_an_interrupted_campaign_goes_on_with_more_cells(tmp_path, monkeypatch):
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right(stop_at="0002"))
    case, place = CornerCase(*read_scene("mash-tl4-sut")), tmp_path / "out"
    with pytest.raises(Interrupted, match="2 parts are kept"):
        study.compute(case, place, points=10, tolerance=1e-3, count=3, seed=1, workers=1)
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right())
    found = study.compute(case, place, points=10, tolerance=1e-3, count=4, seed=1, workers=1)
    assert [row["steps"] for row in found.rows.values()] == [3, 3, 4, 4]


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "folder", "cells"),
    [(("--random", "2"), "paper-table-3-random", 2), (("--points", "2"), "paper-table-3-stability", 112)],
)
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
    assert advice(CHECKS, ["time step", "energy balance", "unknown"]) == "a smaller time.safety_factor"
    assert advice(CHECKS, ["penetration", "time step"]).endswith("; a smaller time.safety_factor")
