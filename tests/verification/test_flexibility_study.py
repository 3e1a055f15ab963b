"""Verify runs, rows, statements and pages of the flexibility study.

Runs agree with E t and the square of the first frequency.
"""

import json
import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from test_levels import SWEEP

from postprocess.comparison.quantities import KEYS, largest_relative, relative_difference
from postprocess.report.command_report import report_text, write_report
from tailslap import cli, delivery
from tailslap.campaign.records import kept
from tailslap.case.corner import corner_run
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.plate_input import plate_density, three_meshes
from tailslap.errors import InputError
from tailslap.modal_run import modal_run
from tailslap.scene.read import read_scene
from tailslap.scene.vary import vary
from tailslap.studies.flexibility import corner_flexibility, plate_runs
from tailslap.studies.flexibility.flexibility_report import answer, report
from tailslap.studies.flexibility.flexibility_scan import Scan

SMALL = ("plate.elements=[8,4]",)


def small_sweep(scene):
    return corner_flexibility.define(CornerCase(*read_scene(scene, SMALL)))


@pytest.mark.parametrize(
    ("scene", "hertz"), [("paper-table-3", 0.6), ("paper-table-3", 8.0), ("paper-abaqus", 200.0)]
)
def test_thickness_at_constant_mass_does_what_the_modulus_does(scene, hertz):
    sweep = small_sweep(scene)
    base, plate = sweep.case.source, sweep.fe_plan.plate
    changes = corner_flexibility.run_changes(sweep, hertz, (8, 4))
    by_modulus = plate_runs.one_run(base, changes, corner_flexibility.fe_record)
    ratio = by_modulus["youngs_modulus"] / plate.modulus
    section = {
        "plate.thickness": plate.thickness * ratio,
        "plate.density": plate_density(sweep.case.scene, plate) / ratio,
        "plate.youngs_modulus": plate.modulus,
        "plate.first_frequency": None,
    }
    by_thickness = plate_runs.one_run(base, {**changes, **section}, corner_flexibility.fe_record)
    assert by_thickness["youngs_modulus"] == plate.modulus
    assert largest_relative(by_thickness["values"], by_modulus["values"]) < 1e-11
    assert by_thickness["stored"] == pytest.approx(by_modulus["stored"], rel=1e-9)


def test_differences_go_with_the_inverse_square_of_the_first_frequency():
    frequencies = (200.0, 100.0, 50.0, 25.0)
    sweep = small_sweep("paper-abaqus")
    changes = [corner_flexibility.run_changes(sweep, hertz, (8, 4)) for hertz in frequencies]
    record = corner_flexibility.fe_record
    runs = [plate_runs.one_run(sweep.case.source, change, record) for change in changes]
    assert not any(run["failed"] for run in runs)
    rigid = sweep.case.tail_slap
    differences = [relative_difference(run["values"], rigid) for run in runs]
    sizes = {name: [difference[name] for difference in differences] for name in ("v_gy", "v_gx")}
    sizes["stored"] = [run["stored"] for run in runs]
    for name, values in sizes.items():
        exponent = np.polyfit(np.log(frequencies), np.log(np.abs(values)), 1)[0]
        assert exponent == pytest.approx(-2.0, abs=0.01), name
    assert all(1e-8 < abs(value) < 1e-4 for value in sizes["v_gy"])


@pytest.mark.long
def test_the_modal_model_is_of_the_same_opinion():
    sweep = small_sweep("paper-table-3")
    base, changes = sweep.case.source, corner_flexibility.run_changes(sweep, 20.0, (8, 4))
    complete = plate_runs.one_run(base, changes, corner_flexibility.fe_record)
    modal = modal_run(CornerCase(*vary(base, changes)).plan(), tolerance=1.0)
    flexible = largest_relative(complete["values"], sweep.case.tail_slap)
    assert largest_relative(modal.values, complete["values"]) < 1e-2 * flexible
    assert modal.estimate.total < 0.1 * flexible
    unstressed = CornerCase(*vary(base, {**changes, "plate.start": "unstressed"})).plan()
    with pytest.raises(InputError, match="unstressed"):
        modal_run(unstressed)


def test_what_each_start_keeps():
    sweep = small_sweep("mash-tl4-sut")
    source, record, names = sweep.case.source, corner_flexibility.fe_record, corner_flexibility.STARTS
    changes = (corner_flexibility.run_changes(sweep, 2.0, (8, 4), name) for name in names)
    relief, momenta, unstressed = (plate_runs.one_run(source, c, record)["departure"] for c in changes)
    assert relief["v_gy"] > 3e-3 > 1e-5 > max(abs(relief["omega"]), abs(relief["v_p"]))
    assert max(abs(momenta["v_gx"]), abs(momenta["v_gy"])) < 1e-12
    assert momenta["omega"] < -3e-3 < 0.0 < momenta["v_p"]
    assert max(map(abs, unstressed.values())) < 1e-9


def test_meshes_are_companions_of_each_other(monkeypatch):
    """A comparison that breaks is a missing result, not the end."""
    sweep, compared = small_sweep("mash-tl4-sut"), []
    meshes = corner_flexibility.mesh_changes(sweep, 20.0, "inertia-relief")
    checked = corner_run.checked

    def breaking(outcome):
        compared.append([companion.refinement for companion in outcome.companions])
        if len(compared) == 2:
            raise FloatingPointError("nothing")
        return checked(outcome)

    monkeypatch.setattr(corner_run, "checked", breaking)
    first, second, third = corner_flexibility.mesh_records(sweep.case.source, [*meshes[:2], None])
    assert compared == [[2.0], [0.5]]
    assert plate_runs.run_passed(first)
    assert second["refused"] == "broke: FloatingPointError: nothing"
    assert third["refused"].startswith("omitted")


def test_the_largest_difference_is_seen_in_any_phase():
    """An unstressed plate strikes near the rigid velocity by its phase."""
    sweep = small_sweep("mash-tl4-sut")
    changes = corner_flexibility.run_changes(sweep, 25.0, (8, 4), "unstressed")
    outcome = sweep.case.varied(changes).run()
    largest, at_strike = corner_flexibility.largest_difference(outcome), abs(outcome.difference["v_gy"])
    difference = outcome.fe_history["v_gy"] - outcome.rigid_history["v_gy"]
    assert largest > 10.0 * at_strike
    assert largest == pytest.approx(np.nanmax(np.abs(difference)) / abs(outcome.rigid["v_gy"]), rel=1e-12)
    # The impulse of a reaction N (1 - cos w t) is off by N / w. A beam pinned at its end has 0.689 of the first
    # frequency of the free one, (3.927 / 4.730)^2, and without damping N / w is reached.
    impulse = abs(outcome.rigid_history["reaction_normal"][0]) / (2.0 * math.pi * 25.0)
    momentum = outcome.fe_plan.model.mass * abs(outcome.rigid["v_gy"])
    assert 0.3 < largest / (impulse / momentum) < 1.0 / 0.689


def test_meshes_and_hold():
    scene = read_scene("paper-table-3")[0]
    assert three_meshes(scene) == ((10, 3), (20, 6), (40, 12))
    assert corner_flexibility.corner_support(scene, (10, 3))["patch"] == 1.0
    assert corner_flexibility.corner_support(scene, (10, 3))["constraint"] == "exact"
    # A tenth, as whole elements.
    assert corner_flexibility.corner_support(scene, (7, 2))["patch"] == pytest.approx(10.0 / 7.0)
    odd = read_scene("paper-table-3", ("plate.elements=[15,5]",))[0]
    assert three_meshes(odd) == ((15, 5), (30, 10), (60, 20))
    with_patch = read_scene("paper-table-3", ("corner.patch_length=0.6", "corner.penalty_scale=2"))[0]
    assert three_meshes(with_patch)[0] == (20, 6)  # half as many elements would be longer than the patch
    corner = {"own_constraint": True, "own_patch": True}
    assert corner_flexibility.corner_support(with_patch, (20, 6)) == {
        "constraint": "penalty",
        "patch": 0.6,
        **corner,
    }


def test_three_starts_whatever_the_scene_has():
    changed_start = ("plate.start=unstressed", "plate.elements=", "verify.tolerance=1e-9")
    sweep = corner_flexibility.define(CornerCase(*read_scene("mash-tl4-sut", changed_start)))
    assert sweep.meshes[1] == (20, 6)  # the program's choice for an omitted key
    coarse, names = sweep.meshes[0], corner_flexibility.STARTS
    changes = {name: corner_flexibility.run_changes(sweep, 50.0, coarse, name) for name in names}
    scenes = {name: vary(sweep.case.source, change)[0] for name, change in changes.items()}
    assert [scene.plate and scene.plate.start for scene in scenes.values()] == list(corner_flexibility.STARTS)
    assert (
        corner_flexibility.run_changes(sweep, 50.0, sweep.meshes[0]) == changes[corner_flexibility.STARTS[0]]
    )
    assert not any(scene.verify.tolerance or scene.wall for scene in scenes.values())
    for start in corner_flexibility.STARTS:  # an oscillation's error too is that of three meshes
        changed = corner_flexibility.mesh_changes(sweep, 50.0, start)
        assert [run and run["plate.elements"] for run in changed] == list(sweep.meshes)


@pytest.mark.long
def test_command(tmp_path, capsys):
    out = tmp_path / "out"
    small = ["--set", "plate.elements=[8,4]", "--points", "4", "--workers", "1", "--out", str(out)]
    arguments = ["study", "flexibility", "paper-abaqus", *small, "--lowest", "0.05 Hz", "--highest", "50 Hz"]
    assert cli._status(arguments) == cli.DONE
    printed = capsys.readouterr().out.replace("\N{NO-BREAK SPACE}", " ")
    printed = " ".join(printed.split())
    assert "≈ 1.1 Hz (unstressed)" in printed
    assert "Failed plates: 0.05 Hz: plate.start" in printed
    points = json.loads((out / "summary.json").read_text())["points"]
    assert [point["passed"] for point in points] == [True, True, True, False]
    assert cli._status([*arguments, "--lowest", "50 Hz"]) == cli.WRONG_INPUT
    assert cli._status(["study", "flexibility", "paper-abaqus", "--points", "3"]) == cli.WRONG_INPUT


def mesh_record(difference, rigid, **changes):
    record = {
        "elements": [8, 4], "youngs_modulus": 1e9, "thickness": 0.1, "damping": 0.0,
        "values": {name: value * (1.0 + difference) for name, value in rigid.items()}, "failed": [],
        "departure": {"v_gx": 0.0, "v_gy": 0.9 * difference, "omega": -0.8 * difference, "v_p": 0.0},
        "largest": abs(difference), "reaction": 10.0 * difference, "stored": 0.1 * difference,
        "deflection_ratio": difference, "unresolved": 0.0, "steps": 1000,
    }  # fmt: skip
    return record | changes


def point_record(hertz, rigid, **changes):
    """Differences decrease with the square of the frequency.

    They are 0.04 (f1 / 1 Hz)^-2, with an error of second order. The second start has 0.36 times these, the third
    0.04 f1^-1.
    """

    def meshes(size):
        return [mesh_record(size * (1.0 - 1e-3 * h**2), rigid, **changes) for h in (4, 2, 1)]

    runs = [meshes(size) for size in (0.04 / hertz**2, 0.36 * 0.04 / hertz**2, -0.04 / hertz)]
    return dict(zip(corner_flexibility.STARTS, runs, strict=True))


def main_meshes(record):
    return record[corner_flexibility.STARTS[0]]


@pytest.fixture(scope="module")
def plan():
    return CornerCase(*read_scene("paper-table-3", SMALL))


@pytest.fixture(scope="module")
def synthetic(plan):
    """The campaign of a power law, with changed records by index."""
    sweep = corner_flexibility.define(plan)

    def build(changes={}):  # noqa: B006
        rigid = plan.tail_slap
        records = {i: point_record(f, rigid) for i, f in enumerate(SWEEP)} | changes
        rows = [corner_flexibility.plate_row(f, records[i], rigid) for i, f in enumerate(SWEEP)]
        scans = {
            start: Scan(series, {}, math.nan) for start, series in corner_flexibility.all_series(rows).items()
        }
        return replace(corner_flexibility.corner_result(sweep, rows, scans, 1.0), own_frequency=100.0)

    return build


def test_points_carry_difference_and_error(synthetic):
    for row in synthetic().rows:
        size = 0.04 / row["first_frequency"] ** 2
        assert row["difference_v_gy"] == pytest.approx(size * 0.999, rel=1e-6)
        relative = size / (1.0 + size)
        assert row["error_v_gy"] == pytest.approx(1.25e-3 * relative, rel=0.01)
        assert row["error_reaction"] == pytest.approx(1.25e-2 * size, rel=1e-6)
        assert row["inertia-relief:v_gy_error"] == pytest.approx(1.25e-3 * size, rel=1e-6)
        assert row["unstressed:v_gy_error"] == pytest.approx(
            1.25e-3 * 0.04 / row["first_frequency"], rel=1e-6
        )
        assert row["passed"]


def test_what_meshes_do_not_show_is_added_to_the_error(plan):
    rigid = plan.tail_slap
    plain, damped = (
        corner_flexibility.plate_row(2.0, point_record(2.0, rigid, unresolved=u), rigid) for u in (0.0, 1e-4)
    )
    for name in ("error_v_gy", "error_reaction", "inertia-relief:v_gy_error"):
        assert damped[name] - plain[name] == pytest.approx(1e-4, rel=1e-6)


def test_a_start_is_not_credited_with_a_change_of_sign(synthetic):
    rigid = synthetic().case.tail_slap
    record = point_record(SWEEP[5], rigid)
    record["unstressed"] = 3 * [mesh_record(1e-9, rigid)]
    samples = corner_flexibility.start_samples(synthetic({5: record}).rows, "unstressed")
    sizes = [sample.difference for sample in samples]
    assert sizes[5] == sizes[4] == pytest.approx(0.999 * 0.04 / SWEEP[4])
    assert sizes == sorted(sizes)


def said(study, tmp_path):
    """Terminal and page, with plain spaces."""
    study_report = report(study)
    write_report(study_report, tmp_path)
    page = (tmp_path / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    return " ".join(report_text(study_report, tmp_path).split()), page


def test_answer(synthetic):
    assert " ".join(answer(synthetic())).replace("\N{NO-BREAK SPACE}", " ") == (
        "Lowest natural frequency at which rigid-body v_GY is within 1 %: ≈ 4.1 Hz. By start of the plate: ≈ 2.1 Hz "
        "(inertia relief), ≈ 1.3 Hz (Stage 1's momenta), ≈ 4.1 Hz (unstressed). Numerical errors are added to the "
        "differences."
    )


@pytest.mark.long
def test_levels_of_any_start_are_said(synthetic, tmp_path):
    terminal, _ = said(synthetic(), tmp_path)
    any_start = "all three starts ≈ 41 Hz ≈ 4.1 Hz ≈ 0.9 Hz ≈ 0.64 Hz"
    for words in (any_start, "inertia relief ≈ 6.4 Hz ≈ 2.1 Hz"):
        assert words in terminal


@pytest.mark.long
def test_what_the_starts_depart_from_is_said(synthetic, tmp_path):
    """Values at t = 0 of each start that passed."""
    rigid = synthetic().case.tail_slap
    study = synthetic({8: point_record(0.1, rigid, failed=["mesh"])})
    page = said(study, tmp_path)[1]
    rows = page[page.index("Differences from Stage 1 at t = 0") :].split("<tr>")
    assert [number(cell) for cell in cells(rows, "0.316 Hz")] == pytest.approx(
        [0.0, 0.36, -0.32, 0.0, 0.0, 0.1296, -0.1152, 0.0], rel=5e-3
    )
    assert set(cells(rows, "0.1 Hz")) == {"–"}
    ratio = study.rows[7]["inertia-relief:v_gy_at_start"] / study.rows[7]["inertia-relief:v_gy"]
    assert ratio == pytest.approx(0.9, rel=1e-3)


def number(text):
    """A number with a typographic minus sign."""
    return float(text.replace("\N{MINUS SIGN}", "-"))


def cells(rows, first):
    """The further cells of a row with this first cell."""
    row = next(row for row in rows if f">{first}<" in row)
    return re.findall(r"<td[^>]*>([^<]*)</td>", row)


def test_answer_where_levels_are_not_known(synthetic):
    refused = {"refused": "plate: no"}
    runs = {name: 3 * [refused] for name in corner_flexibility.STARTS}
    unknown = synthetic(dict.fromkeys(range(9), runs))
    assert "no run passed its checks" in answer(unknown)[0]
    rigid = unknown.case.tail_slap

    def words(study):
        return " ".join(answer(study)).replace("\N{NO-BREAK SPACE}", " ")

    soft = words(synthetic({i: point_record(0.5, rigid) for i in range(9)}))
    assert "By start of the plate: > 1 kHz (inertia relief)" in soft
    stiff = words(synthetic({i: point_record(500.0, rigid) for i in range(9)}))
    assert "within 1 %: < 0.1 Hz." in stiff
    rough = {i: point_record(f, rigid) for i, f in enumerate(SWEEP)}
    for record in rough.values():
        record["unstressed"][1]["largest"] += 0.003
    study = synthetic(rough)
    by_start = "≈ 2.1 Hz (inertia relief), ≈ 1.3 Hz (Stage 1's momenta), < 100 Hz (unstressed)"
    assert by_start in words(study)
    assert "within 1 %: < 100 Hz." in words(study)
    assert study.band[1].frequency == SWEEP[2]  # the softest plate below the level with its error
    assert study.band[2].text.endswith("Hz")


def test_points_that_fail_are_shown_as_such(synthetic, tmp_path):
    rigid = synthetic().case.tail_slap
    fails = point_record(SWEEP[2], rigid, failed=["energy balance"])
    diverged = point_record(SWEEP[8], rigid, values={}, failed=["tail-slap reached"], stored=math.nan)
    refused = point_record(SWEEP[0], rigid)
    main_meshes(refused)[-1] = {"refused": "omitted: the estimated time exceeds the limit"}
    study = synthetic({0: refused, 2: fails, 8: diverged})
    assert [row["passed"] for row in study.rows] == [i not in (0, 2, 8) for i in range(9)]
    assert not corner_flexibility.samples_of(study.rows, "t")[2].passed
    terminal, page = said(study, tmp_path)
    assert "Failed plates: 1 kHz: omitted" in terminal
    assert "; 100 Hz: energy balance; 0.1 Hz: tail-slap reached." in terminal
    assert page.count("<svg") - page.count("<template>") == 1 + 4
    assert [words for words in ("failed: energy balance", "none: omitted") if words not in page] == []
    assert "failed a check" in page
    assert [words for words in ("NaN", "nan") if words in page] == []
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["answer"], summary["certainty"]) == answer(study)
    assert summary["points"][8]["difference_v_gy"] is None
    assert summary["points"][2]["why"] == "energy balance"
    assert summary["levels_v_gy"][corner_flexibility.STARTS[0]][1]["frequency"] == pytest.approx(
        2.0, rel=1e-3
    )
    assert summary["levels_v_gy_any_start"][1]["frequency"] == pytest.approx(4.0, rel=1e-3)
    assert summary["points"][4]["unstressed:v_gy"] == pytest.approx(-0.004 * 0.999, rel=1e-9)
    assert summary["points"][4]["inertia-relief:v_gy_at_start"] == pytest.approx(3.6e-4, rel=2e-3)
    assert set(summary["levels"]) == {*KEYS, "reaction"} - {"v_gy"}
    assert len((tmp_path / "points.csv").read_text().splitlines()) == 10


def scan_record(key, rigid):
    """The finest mesh of a key of the scan."""
    _, start, frequency, _ = key.split()
    return point_record(float(frequency), rigid)[start][-1]


def test_interrupted_study_goes_on(plan, tmp_path, monkeypatch):
    events: list[Any] = []
    rigid = plan.tail_slap

    def one_at_a_time(function, parts, journal, *rest):
        for key in parts:
            if key in journal.records:
                continue
            if function is plate_runs.one_run:
                journal.records.add({key: scan_record(key, rigid)})
                continue
            if len(events) == 3:
                events.append("interrupt")
                raise KeyboardInterrupt
            events.append(key)
            journal.records.add({key: point_record(float(key.split()[0]), rigid)})

    monkeypatch.setattr("tailslap.campaign.engine.run_parts", one_at_a_time)
    with pytest.raises(KeyboardInterrupt, match="3 parts are saved"):
        corner_flexibility.corner_flexibility(plan, SWEEP, tmp_path / "out", 1)
    with kept(tmp_path / "out"):
        study = corner_flexibility.corner_flexibility(plan, SWEEP, tmp_path / "out", 1)
    assert len(events) - 1 == len(set(events)) - 1 == len(study.rows) == 9
    assert list(tmp_path.iterdir()) == []
    assert {row["start"] for row in study.scan} == {*corner_flexibility.STARTS}
    expected = [math.sqrt(0.04 / level * 1.001) for level in corner_flexibility.LEVELS]
    for reach, hertz in zip(study.levels[corner_flexibility.STARTS[0]], expected, strict=True):
        assert hertz <= reach.frequency <= hertz + 2.0 * min(study.step, 0.05 * hertz)


def test_exit_status_where_nothing_passed(plan, tmp_path, monkeypatch, capsys):
    def all_fail(function, parts, journal, *rest):
        rigid = plan.tail_slap
        for key in parts:
            if key not in journal.records:
                journal.records.add({key: point_record(5.0, rigid, values={}, failed=["finite numbers"])})

    monkeypatch.setattr("tailslap.campaign.engine.run_parts", all_fail)
    arguments = ["study", "flexibility", "paper-abaqus", "--set", *SMALL, "--out", str(tmp_path / "out")]
    assert cli._status(arguments) == delivery.CHECK_FAILED
    assert "no run passed its checks" in " ".join(capsys.readouterr().out.split())
    assert "failed</span>" in (tmp_path / "out" / "report.html").read_text()


def test_rows_of_the_scans_of_all_starts_have_the_same_columns():
    """Later starts have v_GY alone, `scan.csv` one heading."""
    differences = {2.0: {"v_gy": 0.5, "t": 0.25}}
    scans = [Scan(dict.fromkeys(names, ()), differences, 0.5) for names in (("v_gy", "t"), ("v_gy",))]
    first, second = ([*plate_runs.listed_scan(scan, scans[0].samples)[0]] for scan in scans)
    assert first == second == ["first_frequency", "difference_v_gy", "difference_t"]
