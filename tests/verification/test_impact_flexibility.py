"""Verify rows, levels and pages of flexibility studies of whole impacts."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_flexibility_study import said

from solver.impact import Impacts
from tailslap.campaign import levels
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.strike_columns import COLUMNS, LARGEST, both_strikes, columns_of_many
from tailslap.scene.read import read_scene
from tailslap.studies.flexibility import impact_flexibility, plate_runs
from tailslap.studies.flexibility.flexibility_report import WORDS, plates_table
from tailslap.studies.flexibility.flexibility_scan import Scan

FREQUENCIES = (256.0, 128.0, 64.0, 32.0, 16.0, 8.0)


@pytest.fixture(scope="module")
def impact():
    return ImpactCase(*read_scene("impact-mash-tl4-sut"))


@pytest.mark.parametrize("name", ["impact-mash-tl4-sut", "impact-mash-tl5-tractor-van"])
def test_plates_of_the_study_have_the_automatic_mesh(name):
    """Corners push over a tenth of the length of the vehicle."""
    case = ImpactCase(*read_scene(name))
    chosen = case.plan()
    changes = {**impact_flexibility.mesh_changes(chosen), "plate.youngs_modulus": chosen.plate.modulus}
    plan = case.varied(changes).plan()
    assert (plan.plate.element, plan.plate.counts) == ("quad9", chosen.plate.counts)
    lengths = [unit.hitch_length for unit in plan.case.scene.trailer]
    assert lengths == [pytest.approx(0.5 * case.scene.vehicle.width)] * len(case.scene.trailer)
    assert plan.case.scene.needed_contact.patch_length == 0.1 * case.scene.vehicle.length


def impact_plate(frequency, why="", size=None):
    """A plate with strike differences of 10/f^2, f in Hz.

    The error of the mesh is a hundredth of that.
    """
    size = 10.0 / frequency**2 if size is None else size
    sizes = {"difference": -size, "error": 0.01 * size}
    groups = {name: dict.fromkeys(impact_flexibility.NAMES, value) for name, value in sizes.items()}
    return impact_flexibility.impact_row(frequency, {**groups, "failed": [why] if why else []})


def test_levels_lie_where_the_difference_of_strikes_crosses_them():
    samples = impact_flexibility.impact_samples([*map(impact_plate, FREQUENCIES)], "strike_2.impulse")
    reaches = [levels.lowest_frequency(samples, level) for level in impact_flexibility.IMPACT_LEVELS]
    assert [level.kind for level in reaches] == ["crossed"] * 3
    expected = [math.sqrt(10.0 / x * 1.01) for x in (0.01, 0.05, 0.1)]  # with the error of a hundredth on top
    assert [level.frequency for level in reaches] == pytest.approx(expected)


def test_a_plate_that_strikes_with_other_corners_tells_no_level():
    rows = [*map(impact_plate, FREQUENCIES[:-1]), impact_plate(8.0, size=math.nan)]
    samples = impact_flexibility.impact_samples(rows, "strike_1.impulse")
    level = levels.lowest_frequency(samples, impact_flexibility.IMPACT_LEVELS[-1])
    assert (level.kind, level.frequency) == ("not reached", 16.0)


def test_what_a_plate_s_run_records(monkeypatch, impact):
    """The check of the mesh is omitted, a refusal stated."""

    def run(case):
        checks = [SimpleNamespace(name=name, passed=False) for name in ("error of impulse", "energy balance")]
        return SimpleNamespace(difference={impact_flexibility.NAMES[0]: 0.5}, mesh_error={}, checks=checks)

    monkeypatch.setattr(ImpactCase, "run", run)
    ran = plate_runs.one_run(impact.source, {"contact.friction": 0.1}, impact_flexibility.strike_record)
    row = impact_flexibility.impact_row(8.0, ran)
    assert (row[f"difference.{impact_flexibility.NAMES[0]}"], row["failed"]) == (0.5, "energy balance")
    assert math.isnan(row[f"difference.{impact_flexibility.NAMES[1]}"])
    refused = {"contact.restitution": 2.0}
    ran = plate_runs.one_run(impact.source, refused, impact_flexibility.strike_record)
    assert "contact.restitution" in impact_flexibility.impact_row(8.0, ran)["failed"]
    measured = impact_flexibility.measure_plate(impact.source, 8.0, refused, refused)
    assert "contact.restitution" in measured["failed"][0]


def reached(samples):
    return tuple(levels.lowest_frequency(samples, level) for level in impact_flexibility.IMPACT_LEVELS)


def test_the_report_of_a_whole_impact_holds_every_plate(tmp_path, impact):
    rows = [*map(impact_plate, FREQUENCIES[:-1]), impact_plate(8.0, "energy balance")]
    samples = {name: impact_flexibility.impact_samples(rows, name) for name in impact_flexibility.NAMES}
    reaches = {name: reached(of_name) for name, of_name in samples.items()}

    def all_of(value):
        return dict.fromkeys(COLUMNS, value)

    results: list[tuple[float, Any, Any, tuple[str, ...]]] = [
        (2.0, {}, {}, ("contact: no",)), (4.0, all_of(3e3), all_of(-0.06), ()),
        (8.0, all_of(3e3), all_of(0.04), ()), (math.inf, all_of(2e3), {}, ()),
    ]  # fmt: skip
    plates = [impact_flexibility.plate_record(*result) for result in results]
    assert [row["passed"] for row in plates] == [False, False, True, True], "5 % between both meshes at most"
    study = plate_runs.Flexibility(impact, rows, reaches, 69.0, {"patch_length": 1.0}, 3.0, {}, plates)
    assert plates_table(study).marks == {0: "failed", 1: "failed"}
    assert "scan.csv" not in said(study, tmp_path)[1]
    names = impact_flexibility.NAMES
    differences = {40.0: dict.fromkeys(names, 0.01), 39.5: dict.fromkeys(names, -0.02)}
    scan_rows = plate_runs.listed_scan(Scan(samples, differences, 0.5), samples)
    study = replace(study, scan=scan_rows, step=0.5)
    terminal, page = said(study, tmp_path)
    assert "from 2 further runs from 39.5 Hz to 40 Hz, at steps of 0.5 Hz" in terminal
    assert "scan.csv" in page
    lines = (tmp_path / "scan.csv").read_text().splitlines()
    assert [lines[0].split(",")[0], *lines[2].split(",")] == ["first_frequency", "39.5", *6 * ["-0.02"]]
    assert "≈ 32 Hz (within 1 %)" in page.replace("\N{NO-BREAK SPACE}", " ")
    assert all(word in page for word in WORDS.values())
    assert [words for words in ("8 Hz: energy balance", "2 Hz: contact: no.") if words not in page] == []
    assert "plate of 8 Hz on the second strike: impulse +50 %" in terminal
    assert page.count("<svg") - page.count("<template>") == 1 + 1
    lines = (tmp_path / "points.csv").read_text().splitlines()
    assert len(lines) == 1 + len(rows)
    assert np.isclose(float(lines[1].split(",")[1]), -10.0 / 256.0**2)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert [plate["frequency"] for plate in summary["plates"]] == [2.0, 4.0, 8.0, None]
    assert summary["levels"]["strike_2.impulse"][0]["kind"] == "crossed"


def test_the_report_of_a_vehicle_in_space_names_its_companion(tmp_path):
    case = ImpactCase(*read_scene("impact-tipping-tl4-sut"))
    plate = impact_flexibility.plate_record(math.inf, dict.fromkeys(COLUMNS, 2e3), {}, ())
    rows = [*map(impact_plate, FREQUENCIES)]
    reaches = {
        name: reached(impact_flexibility.impact_samples(rows, name)) for name in impact_flexibility.NAMES
    }
    study = plate_runs.Flexibility(case, rows, reaches, 8.0, {"patch_length": 1.0}, 3.0, {}, [plate])
    terminal, _ = said(study, tmp_path)
    assert "companion in the plane: the same strips without heights" in " ".join(terminal.split())
    rigid = json.loads((tmp_path / "summary.json").read_text())["rigid"]
    assert rigid["strikes"] != rigid["space"]["strikes"]


def test_contacts_of_a_corner_that_are_close_are_one_strike():
    corner = np.array([[0, 0], [1, 0], [0, 0], [0, 1]])
    start, end = (
        np.array([[0.0, 0.2], [0.05, 0.3], [0.14, 0.51], [0.26, 0.6]]),
        np.array([[0.1, 0.26], [0.12, 0.5], [0.2, 0.55], [0.3, 0.7]]),
    )
    nothing, force = np.zeros(2), np.zeros((2000, 2))
    impacts = Impacts(
        corner, start, end, np.ones_like(start), np.ones_like(start), force, force, nothing, nothing
    )
    columns = columns_of_many(impacts, 5e-4, (0, 1))
    expected = {"duration": ((0.2, 0.35), (0.07, 0.1)), "impulse": ((2.0, 3.0), (1.0, 1.0))}
    for name, strikes in expected.items():
        for number, values in enumerate(strikes, 1):
            assert columns[f"strike_{number}.{name}"] == pytest.approx(values), (name, number)
    none = Impacts(-np.ones_like(corner), *4 * (np.full_like(start, np.nan),), force, force, nothing, nothing)
    assert np.isnan(
        [column for name, column in columns_of_many(none, 5e-4, (0, 1)).items() if name != LARGEST]
    ).all()


@pytest.mark.long
def test_a_stiff_plate_is_the_rigid_vehicle(impact):
    changes = {"plate.youngs_modulus": None, "plate.first_frequency": 200.0, "contact.patch_length": 1.0}
    changes["time.end"] = 2.0 * impact.duration
    meshes = [{**changes, "plate.elements": (10 * n, 4 * n)} for n in (1, 2)]
    rigid = both_strikes(impact.answer)
    plate = impact_flexibility.measure_plate(impact.source, 200.0, *meshes)
    assert plate["failed"] == []
    assert plate["error"] < 1e-2
    for name, value in plate["values"].items():
        assert value == pytest.approx(rigid[name], rel=1e-2), name
