"""Verify random cells of the study of stability, and their references."""

import csv
import json
import math
import re
from dataclasses import replace
from functools import partial
from itertools import combinations

import pytest
from shared_cases import LINEAR_TRAIN, LINEAR_TRUCK
from test_stability_study import breaks

import tailslap
from postprocess.report.command_report import report_text, write_report
from postprocess.report.provenance import CRATE
from tailslap.campaign import random_scenes
from tailslap.campaign.records import kept
from tailslap.case import case_of
from tailslap.case.check import Check
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_checks import CHECKS
from tailslap.case.impact.case import ImpactCase
from tailslap.case.resources import expected_effort
from tailslap.cli import _status
from tailslap.errors import InputError, Interrupted
from tailslap.scene.read import read_scene, source_of_text
from tailslap.scene.validate import validate
from tailslap.scene.vary import changed_tables, vary
from tailslap.scene.write import scene_file
from tailslap.studies.stability import cell_verdicts, stability_study
from tailslap.studies.stability.stability_report import headline, report


def computed(folder, count=None, name="mash-tl4-sut", points=10, tolerance=1e-3):
    """Compute a map, or this number of random cells."""
    case, place = case_of(*read_scene(name)), folder / "out"
    points, tolerance = (None, None) if count else (points, tolerance)
    with kept(place):
        return stability_study.compute(case, place, points, tolerance, count, seed=1, workers=1)


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


@pytest.mark.parametrize(
    ("option", "key"), [({"points": 4}, "--points"), ({"tolerance": 1e-3}, "--tolerance")]
)
def test_options_without_effect_on_random_cells_are_refused(option, key, refused):
    assert refused(partial(tailslap.study, "stability", "mash-tl4-sut", random=1, **option)) == key


def test_a_survey_is_made_of_its_draws_and_its_journal_goes(tmp_path, monkeypatch):
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right())
    case, place = CornerCase(*read_scene("mash-tl4-sut")), tmp_path / "out"
    with kept(place):
        result = stability_study.compute(case, place, None, None, count=4, seed=1, workers=1)
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


def test_a_command_leaves_no_journal_beside_its_result(tmp_path, monkeypatch):
    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_right())
    monkeypatch.chdir(tmp_path)
    assert _status(["study", "stability", "mash-tl4-sut", "--random", "2", "--out", "out"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
