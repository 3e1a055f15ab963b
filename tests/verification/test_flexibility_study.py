"""Verification: the flexibility study against exact laws: E t, the square of the first frequency, synthetic powers.

Further: its discretisation error, what it says of plates that fail, its page, and that it goes on after an interrupt.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from postprocess.comparison.comparison import relative_difference
from tailslap.command_line import CHECK_FAILED, DONE, WRONG_INPUT, _status
from tailslap.errors import InputError
from tailslap.planning.plan import Plan, make_plan
from tailslap.planning.rigid import COMPARED, stage_two_numbers
from tailslap.run import run_scene
from tailslap.scene.files import read_scene, validate
from tailslap.studies.flexibility import survey as survey_module
from tailslap.studies.flexibility.levels import (
    ABOVE_ALL,
    CROSSED,
    NOT_REACHED,
    UNKNOWN,
    Level,
    Sample,
    jointly,
    lowest_frequency,
    power_law,
)
from tailslap.studies.flexibility.measure import (
    farthest,
    largest_difference,
    modal_opinion,
    one_run,
    thickness_tables,
)
from tailslap.studies.flexibility.points import Point, convergence_index, make_point
from tailslap.studies.flexibility.report.words import headline, main_sentence
from tailslap.studies.flexibility.report.write import write_flexibility
from tailslap.studies.flexibility.statements import kept_sentence, statements
from tailslap.studies.flexibility.survey import Survey, samples, start_samples, summed_up, survey
from tailslap.studies.flexibility.sweep import (
    STARTS,
    Sweep,
    define,
    frequencies,
    held,
    run_tables,
    three_meshes,
)

pytestmark = pytest.mark.verification

SMALL = ("plate.elements=[8,4]",)


def small_sweep(scene: str, *given: float) -> Sweep:
    return define(make_plan(*read_scene(scene, SMALL)), given)[0]


@pytest.mark.parametrize(
    ("scene", "hertz"), [("paper-table-3", 0.6), ("paper-table-3", 8.0), ("paper-abaqus", 200.0)]
)
def test_thickness_at_constant_mass_does_what_the_modulus_does(scene: str, hertz: float) -> None:
    sweep = small_sweep(scene, hertz)
    tables = run_tables(sweep, hertz, (8, 4))
    by_modulus = one_run(tables)
    by_thickness = one_run(thickness_tables(tables, by_modulus["youngs_modulus"], sweep.own))
    assert by_thickness["youngs_modulus"] == sweep.own.youngs_modulus
    ratio = by_modulus["youngs_modulus"] / sweep.own.youngs_modulus
    assert by_thickness["thickness"] / sweep.own.thickness == pytest.approx(ratio, rel=1e-14)
    assert farthest(by_thickness["values"], by_modulus["values"]) < 1e-11
    assert by_thickness["stored"] == pytest.approx(by_modulus["stored"], rel=1e-9)


def test_differences_go_with_the_inverse_square_of_the_first_frequency() -> None:
    given = (200.0, 100.0, 50.0, 25.0)
    sweep = small_sweep("paper-abaqus", *given)
    runs = [one_run(run_tables(sweep, hertz, (8, 4))) for hertz in given]
    assert not any(run["failed"] for run in runs)
    rigid = stage_two_numbers(sweep.plan)
    sizes = {
        "v_gy": [relative_difference(run["values"], rigid)["v_gy"] for run in runs],
        "v_gx": [relative_difference(run["values"], rigid)["v_gx"] for run in runs],
        "stored": [run["stored"] for run in runs],
    }
    for name, values in sizes.items():
        exponent = np.polyfit(np.log(given), np.log(np.abs(values)), 1)[0]
        assert exponent == pytest.approx(-2.0, abs=0.01), name
    assert all(1e-8 < abs(value) < 1e-4 for value in sizes["v_gy"])


def test_the_modal_model_is_of_the_same_opinion() -> None:
    sweep = small_sweep("paper-table-3", 20.0)
    tables = run_tables(sweep, 20.0, (8, 4))
    whole, modal = one_run(tables), modal_opinion(tables)
    flexible = farthest(whole["values"], stage_two_numbers(sweep.plan))
    assert farthest(modal["values"], whole["values"]) < 1e-2 * flexible
    assert modal["estimate"] < 0.1 * flexible
    assert (
        "unstressed" in modal_opinion({**tables, "plate": tables["plate"] | {"start": "sudden"}})["refused"]
    )


def test_what_each_start_keeps() -> None:
    sweep = small_sweep("mash-tl4-sut", 2.0)
    relief, momenta, unstressed = (
        one_run(run_tables(sweep, 2.0, (8, 4), name))["departure"] for name in STARTS
    )
    assert relief["v_gy"] > 3e-3 > 1e-5 > max(abs(relief["omega"]), abs(relief["v_p"]))
    assert max(abs(momenta["v_gx"]), abs(momenta["v_gy"])) < 1e-12
    assert momenta["omega"] < -3e-3 < 0.0 < momenta["v_p"]
    assert max(map(abs, unstressed.values())) < 1e-9


def test_the_largest_difference_is_seen_in_any_phase() -> None:
    """An oscillating plate strikes close to the rigid velocity here, and was ten times as far off before."""
    sweep = small_sweep("mash-tl4-sut", 25.0)
    outcome = run_scene(make_plan(validate(run_tables(sweep, 25.0, (8, 4), "unstressed"))))
    largest, at_strike = largest_difference(outcome), abs(outcome.difference["v_gy"])
    difference = outcome.fe_history["v_gy"] - outcome.rigid_history["v_gy"]
    assert largest > 10.0 * at_strike
    assert largest == pytest.approx(np.nanmax(np.abs(difference)) / abs(outcome.rigid["v_gy"]), rel=1e-12)
    # The impulse of a reaction N (1 - cos w t) is off by N / w, with w above that of the free plate, and damping.
    impulse = abs(outcome.rigid_history["reaction_normal"][0]) / (2.0 * math.pi * 25.0)
    whole = outcome.fe_plan.model.mass * abs(outcome.rigid["v_gy"])
    assert 0.3 < largest / (impulse / whole) < 1.0


def power(frequency: float, error: float = 1e-3, passed: bool = True) -> Sample:
    """A point of 0.04 (f1 / 1 Hz)^-2, with an error that is a share of that."""
    return Sample(frequency, 0.04 / frequency**2, error * 0.04 / frequency**2, passed)


SWEEP = tuple(np.geomspace(1000.0, 0.1, 9).tolist())


@pytest.mark.parametrize(("level", "hertz"), [(0.0004, 10.0), (0.01, 2.0), (0.04, 1.0), (0.16, 0.5)])
def test_levels_of_a_power_law_are_exact(level: float, hertz: float) -> None:
    found = lowest_frequency([power(f) for f in SWEEP], level)
    assert (found.kind, found.frequency) == (CROSSED, pytest.approx(hertz, rel=1e-12))


def test_levels_that_are_not_crossed() -> None:
    points = [power(f) for f in SWEEP]
    all_below = lowest_frequency(points[:4], 0.01)
    assert (all_below.kind, all_below.frequency) == (NOT_REACHED, SWEEP[3])
    above = lowest_frequency(points, 1e-12)
    assert (above.kind, above.frequency) == (ABOVE_ALL, SWEEP[0])
    none = lowest_frequency([replace(point, passed=False) for point in points], 0.01)
    assert none.kind == UNKNOWN
    assert math.isnan(none.frequency)


def level(kind: str, frequency: float) -> Level:
    return Level(0.01, kind, frequency)


@pytest.mark.parametrize(
    ("levels", "joint"),
    [
        ([level(CROSSED, 4.0), level(NOT_REACHED, 0.1), level(CROSSED, 2.0)], level(CROSSED, 4.0)),
        ([level(CROSSED, 0.2), level(NOT_REACHED, 0.3)], level(NOT_REACHED, 0.3)),
        ([level(CROSSED, 4.0), level(UNKNOWN, 1.0)], level(UNKNOWN, 1.0)),
        ([level(ABOVE_ALL, 1e3), level(UNKNOWN, 1.0), level(CROSSED, 2.0)], level(ABOVE_ALL, 1e3)),
    ],
)
def test_what_holds_for_every_start(levels: list[Level], joint: Level) -> None:
    assert jointly(levels) == jointly(levels[::-1]) == joint
    assert math.isnan(jointly([level(CROSSED, 2.0), level(UNKNOWN, math.nan)]).frequency)


@pytest.mark.parametrize(("share", "kind"), [(0.333, CROSSED), (0.334, UNKNOWN), (math.nan, UNKNOWN)])
def test_a_level_is_known_up_to_a_third_of_it_in_error(share: float, kind: str) -> None:
    assert lowest_frequency([power(f, share) for f in SWEEP], 0.01).kind == kind


def test_points_below_a_level_must_be_known_to_lie_below_it() -> None:
    points = [power(f) for f in SWEEP]
    points[2] = replace(points[2], error=0.0034)
    unknown = lowest_frequency(points, 0.01)
    assert (unknown.kind, unknown.frequency) == (UNKNOWN, SWEEP[2])
    points[2] = replace(points[2], error=0.0033)
    assert lowest_frequency(points, 0.01).kind == CROSSED


def test_failed_points_say_nothing_of_a_level() -> None:
    points = [power(f) for f in SWEEP]
    points[0] = replace(points[0], passed=False, difference=9.0)
    points[-1] = replace(points[-1], passed=False, difference=0.0)
    found = lowest_frequency(points, 0.01)
    assert (found.kind, found.frequency) == (CROSSED, pytest.approx(2.0, rel=1e-12))
    below = next(i for i, f in enumerate(SWEEP) if f < 2.0)
    points[below] = replace(points[below], passed=False)
    assert lowest_frequency(points, 0.01).kind == UNKNOWN  # the crossing lies beside a point that failed


def test_a_power_law_is_followed_to_its_end() -> None:
    points = [power(f) for f in SWEEP]
    law = power_law(points)
    assert law
    assert (law.exponent, law.factor) == (pytest.approx(-2.0, abs=1e-12), pytest.approx(0.04, rel=1e-12))
    assert (law.highest, law.lowest) == (SWEEP[0], SWEEP[-1])
    bent = [*points[:6], *(replace(p, difference=3.0 * p.difference) for p in points[6:])]
    law = power_law(bent)
    assert law
    assert law.lowest == SWEEP[5]
    assert law.exponent == pytest.approx(-2.0, abs=1e-12)
    assert power_law([power(f, error=0.5) for f in SWEEP]) is None


def test_the_error_is_a_grid_convergence_index_of_a_believable_order() -> None:
    second = [3.0 + 0.01 * h**2 for h in (1.0, 2.0, 4.0)]
    assert convergence_index(*second) * second[0] == pytest.approx(1.25 * 0.01, rel=1e-9)
    lucky = [3.0 + 1e-6 * h**8 for h in (1.0, 2.0, 4.0)]
    assert convergence_index(*lucky) * lucky[0] == pytest.approx(1.25 * 255e-6 / 3.0, rel=1e-9)
    assert convergence_index(1.0, 1.01, 1.0) == pytest.approx(0.03)  # to and fro: three times the change


def test_meshes_and_hold() -> None:
    scene = read_scene("paper-table-3")[0]
    assert three_meshes(scene) == ((10, 3), (20, 6), (40, 12))
    assert held(scene, (10, 3)).patch == 1.0
    assert held(scene, (10, 3)).constraint == "exact"
    assert held(scene, (7, 2)).patch == pytest.approx(10.0 / 7.0)  # a tenth, as whole elements
    odd = read_scene("paper-table-3", ("plate.elements=[15,5]",))[0]
    assert three_meshes(odd) == ((15, 5), (30, 10), (60, 20))
    own = read_scene("paper-table-3", ("corner.patch_length=0.6", "corner.penalty_scale=2"))[0]
    assert three_meshes(own)[0] == (20, 6)  # half of it would have elements longer than the patch
    assert (held(own, (20, 6)).constraint, held(own, (20, 6)).patch) == ("penalty", 0.6)


def test_three_starts_whatever_the_scene_has() -> None:
    own = ("plate.start=unstressed", "plate.elements=", "verify.tolerance=1e-9")
    sweep = define(make_plan(*read_scene("mash-tl4-sut", own)), (50.0,))[0]
    assert sweep.meshes[1] == (20, 6)  # what the program chooses where the scene does not
    tables = {name: run_tables(sweep, 50.0, sweep.meshes[0], name) for name in STARTS}
    assert [tables[name]["plate"]["start"] for name in STARTS] == list(STARTS)
    assert run_tables(sweep, 50.0, sweep.meshes[0]) == tables[STARTS[0]]
    assert not any("verify" in each for each in tables.values())


@pytest.mark.parametrize(
    ("option", "given"),
    [("--lowest", "0"), ("--lowest", "2 kg"), ("--lowest", "2 kHz"), ("--highest", "1 MHz")],
)
def test_wrong_frequencies(option: str, given: str) -> None:
    values = {"--lowest": "1 Hz", "--highest": "1 kHz"} | {option: given}
    with pytest.raises(InputError) as caught:
        frequencies(values["--lowest"], values["--highest"], 5)
    assert caught.value.key == option


def test_frequencies_are_at_even_ratios_from_stiff_to_soft() -> None:
    assert frequencies("1", "1 kHz", 4) == pytest.approx((1000.0, 100.0, 10.0, 1.0), rel=1e-12)


def mesh_record(difference: float, rigid: Mapping[str, float], **changes: Any) -> dict[str, Any]:
    record = {
        "elements": [8, 4],
        "youngs_modulus": 1e9,
        "thickness": 0.1,
        "damping": 0.0,
        "values": {name: value * (1.0 + difference) for name, value in rigid.items()},
        "failed": [],
        "departure": {"v_gx": 0.0, "v_gy": 0.9 * difference, "omega": -0.8 * difference, "v_p": 0.0},
        "largest": abs(difference),
        "reaction": 10.0 * difference,
        "stored": 0.1 * difference,
        "give": difference,
        "error": 1e-3 * abs(difference),
        "unseen": 0.0,
        "steps": 1000,
    }
    return record | changes


def point_record(hertz: float, rigid: Mapping[str, float], **changes: Any) -> dict[str, Any]:
    """Differences of 0.04 (f1 / 1 Hz)^-2 on fine meshes, with an error of second order in the element's size; 0.36
    of it for the second start, and 0.04 f1^-1 for the third."""

    def meshes(factor: float) -> list[dict[str, Any]]:
        sizes = [factor * 0.04 / hertz**2 * (1.0 - 1e-3 * h**2) for h in (4, 2, 1)]
        return [mesh_record(size, rigid, **changes) for size in sizes]

    runs = (meshes(1.0), meshes(0.36), [mesh_record(-0.04 / hertz, rigid, **changes)])
    modal = {"values": runs[0][-1]["values"], "estimate": 1e-6, "failed": []}
    return {"starts": dict(zip(STARTS, runs, strict=True)), "modal": modal}


def main_meshes(record: dict[str, Any]) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = record["starts"][STARTS[0]]
    return found


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make_plan(*read_scene("paper-table-3", SMALL))


@pytest.fixture(scope="module")
def synthetic(plan: Plan) -> Callable[..., Survey]:
    """The survey of a synthetic power law; changes: records by the place of the point."""
    sweep = replace(define(plan, SWEEP)[0], own_frequency=100.0)

    def build(changes: Mapping[int, dict[str, Any]] = {}) -> Survey:
        rigid = stage_two_numbers(plan)
        records = [point_record(f, rigid) for f in SWEEP]
        points = tuple(
            make_point(f, changes.get(i, record), rigid)
            for i, (f, record) in enumerate(zip(SWEEP, records, strict=True))
        )
        return summed_up(sweep, points, 1.0)

    return build


def test_points_carry_difference_and_error(synthetic: Callable[..., Survey]) -> None:
    for point in synthetic().points:
        whole = 0.04 / point.frequency**2
        assert point.difference["v_gy"] == pytest.approx(whole * 0.999, rel=1e-6)
        left = whole / (1.0 + whole)
        assert point.errors["v_gy"] == pytest.approx(1.25e-3 * left, rel=0.01)
        assert point.errors["reaction"] == pytest.approx(1.25e-2 * whole, rel=1e-6)
        assert point.starts[STARTS[0]].error == pytest.approx(1.25e-3 * whole, rel=1e-6)
        assert point.starts["unstressed"].error == pytest.approx(4e-5 / point.frequency, rel=1e-6)
        assert point.passed


def test_what_meshes_do_not_show_is_added_to_the_error(plan: Plan) -> None:
    rigid = stage_two_numbers(plan)
    plain, damped = (make_point(2.0, point_record(2.0, rigid, unseen=u), rigid) for u in (0.0, 1e-4))
    for name in ("v_gy", "reaction"):
        assert damped.errors[name] - plain.errors[name] == pytest.approx(1e-4, rel=1e-6)
    first = STARTS[0]
    assert damped.starts[first].error - plain.starts[first].error == pytest.approx(1e-4, rel=1e-6)


def test_a_start_is_not_credited_with_a_change_of_sign(synthetic: Callable[..., Survey]) -> None:
    rigid = stage_two_numbers(synthetic().sweep.plan)
    record = point_record(SWEEP[5], rigid)
    record["starts"]["unstressed"] = [mesh_record(1e-9, rigid)]
    points: tuple[Point, ...] = synthetic({5: record}).points
    sizes = [sample.difference for sample in start_samples(points, "unstressed")]
    assert sizes[5] == sizes[4] == pytest.approx(0.04 / SWEEP[4])
    assert sizes == sorted(sizes)


def test_what_half_the_patch_changes_is_said(synthetic: Callable[..., Survey]) -> None:
    rigid = stage_two_numbers(synthetic().sweep.plan)
    record = point_record(SWEEP[4], rigid)
    longer = main_meshes(record)[-1]["values"]
    half = {name: rigid[name] + 1.1 * (longer[name] - rigid[name]) for name in rigid}
    found = synthetic({4: record | {"half_patch": mesh_record(0.0, rigid, values=half)}})
    assert "at 10\N{NO-BREAK SPACE}Hz changes by +10 %" in " ".join(statements(found))
    failed = mesh_record(0.0, rigid, values=half, failed=["mesh"])
    assert "changes by" not in " ".join(statements(synthetic({4: record | {"half_patch": failed}})))


def test_headline(synthetic: Callable[..., Survey]) -> None:
    words = headline(synthetic()).replace("\N{NO-BREAK SPACE}", " ")
    assert words.startswith(
        "Rigid-body v_GY is good to 1 %, at the strike and before, down to a first frequency of 2 Hz with inertia "
        "relief, 1.2 Hz with Stage 1's momenta and 4 Hz from the unstressed plate: for any of the three down to 4 Hz "
        "(to 0.1 % down to 40 Hz, to 5 % down to 0.894 Hz, to 10 % down to 0.632 Hz). The scene's own plate has "
        "100 Hz, where with inertia relief the difference is 4.0e-06"
    )


def test_what_the_starts_depart_from_is_said(synthetic: Callable[..., Survey]) -> None:
    rigid = stage_two_numbers(synthetic().sweep.plan)
    said = kept_sentence(synthetic({8: point_record(0.1, rigid, failed=["mesh"])})).replace("\xa0", " ")
    assert "At 0.316 Hz the first begins with a v_GY +3.6e-01 off" in said
    assert "90 % of its difference at the strike" in said
    assert "spin and corner speed -1.2e-01 and +0.0e+00 off" in said


def test_headline_of_what_is_not_known(synthetic: Callable[..., Survey]) -> None:
    refused = {"refused": "plate: no"}
    runs = {name: (3 if name != "unstressed" else 1) * [refused] for name in STARTS}
    nothing = synthetic({i: {"starts": runs, "modal": {"refused": "no"}} for i in range(9)})
    assert "no run passed" in main_sentence(nothing)
    assert "No run passed its checks." in statements(nothing)
    rigid = stage_two_numbers(nothing.sweep.plan)

    def said(found: Survey) -> str:
        return main_sentence(found).replace("\N{NO-BREAK SPACE}", " ")

    assert "frequency of more than 1 kHz with" in said(
        synthetic({i: point_record(0.5, rigid) for i in range(9)})
    )
    stiff = {i: point_record(500.0, rigid) for i in range(9)}
    assert "for any of the three down to 0.1 Hz at least (to 0.1 % down to 0.1 Hz" in said(synthetic(stiff))
    rough = {i: point_record(f, rigid) for i, f in enumerate(SWEEP)}
    for record in rough.values():
        record["starts"]["unstressed"][0]["error"] = 0.01
    words = said(synthetic(rough))
    assert (
        "2 Hz with inertia relief, 1.2 Hz with Stage 1's momenta and an unknown one (not known near 1 kHz)"
        in words
    )
    assert "for any of the three down to an unknown one (not known near 1 kHz) (to 5 % down to" in words


def test_points_that_fail_are_shown_as_such(synthetic: Callable[..., Survey], tmp_path: Path) -> None:
    rigid = stage_two_numbers(synthetic().sweep.plan)
    fails = point_record(SWEEP[2], rigid, failed=["energy balance"])
    lost = point_record(SWEEP[8], rigid, values={}, failed=["tail-slap reached"], stored=math.nan)
    refused = point_record(SWEEP[0], rigid)
    main_meshes(refused)[-1] = {"refused": "left out: its time loop would take too long"}
    found = synthetic({0: refused, 2: fails, 8: lost})
    assert [point.passed for point in found.points] == [i not in (0, 2, 8) for i in range(9)]
    assert not samples(found.points, "t")[2].passed
    said = " ".join(statements(found)).replace("\N{NO-BREAK SPACE}", " ")
    assert "From 0.1 Hz down the plate is too soft for a start by inertia relief (tail-slap reached)" in said
    assert "Stiffer plates that failed: 1 kHz: left out" in said
    assert "; 100 Hz: energy balance." in said
    write_flexibility(found, tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert page.count("<svg") == 5
    assert "failed: energy balance" in page
    assert "none: left out" in page
    assert "failed a check" in page
    assert "NaN" not in page
    assert "nan" not in page
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["headline"] == headline(found)
    assert summary["points"][8]["difference_v_gy"] is None
    assert summary["points"][2]["why"] == "energy balance"
    assert summary["levels_v_gy"][STARTS[0]][1]["frequency"] == pytest.approx(2.0, rel=1e-3)
    assert summary["levels_v_gy_any_start"][1]["frequency"] == pytest.approx(4.0, rel=1e-3)
    assert summary["points"][4]["unstressed:v_gy"] == pytest.approx(-0.004, rel=1e-9)
    assert summary["points"][4]["inertia-relief:v_gy_at_start"] == pytest.approx(3.6e-4, rel=2e-3)
    assert set(summary["power_laws"]) == {*COMPARED, "reaction", "stored"}
    assert len((tmp_path / "points.csv").read_text().splitlines()) == 10


def test_interrupted_study_goes_on(plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rigid, done = stage_two_numbers(plan), []

    def one_at_a_time(function: Any, parts: Any, journal: Any, *rest: Any) -> None:
        for key in parts:
            if key in journal.records:
                continue
            if len(done) == 3:
                done.append("interrupt")
                raise KeyboardInterrupt
            done.append(key)
            journal.add(key, point_record(float(key.split()[0]), rigid))

    monkeypatch.setattr(survey_module, "run_parts", one_at_a_time)
    with pytest.raises(KeyboardInterrupt, match="3 parts are kept"):
        survey(plan, SWEEP, tmp_path / "out", 1)
    found = survey(plan, SWEEP, tmp_path / "out", 1)
    assert len(done) - 1 == len(set(done)) - 1 == len(found.points) == 9
    assert list(tmp_path.iterdir()) == []


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    small = ["--set", "plate.elements=[8,4]", "--points", "4", "--workers", "1", "--out", str(out)]
    given = ["study", "flexibility", "paper-abaqus", *small, "--lowest", "0.05 Hz", "--highest", "50 Hz"]
    assert _status(given) == DONE
    printed = capsys.readouterr().out.replace("\N{NO-BREAK SPACE}", " ")
    assert "good to 1 %, at the strike and before, down to a first frequency of 1." in " ".join(
        printed.split()
    )
    assert "From 0.05 Hz down the plate is too soft" in " ".join(printed.split())
    points = json.loads((out / "summary.json").read_text())["points"]
    assert [point["passed"] for point in points] == [True, True, True, False]
    assert [point["thickness_apart"] is not None for point in points].count(True) == 2
    assert max(point["thickness_apart"] or 0.0 for point in points) < 1e-11
    assert [point["half_patch_v_gy"] is not None for point in points] == [False, False, True, False]
    assert (
        1.0 < points[2]["half_patch_v_gy"] / points[2]["difference_v_gy"] < 1.3
    )  # what holds on less gives more
    assert _status([*given, "--lowest", "50 Hz"]) == WRONG_INPUT
    assert _status(["study", "flexibility", "paper-abaqus", "--points", "3"]) == WRONG_INPUT


def test_exit_status_where_nothing_passed(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def all_fail(function: Any, parts: Any, journal: Any, *rest: Any) -> None:
        rigid = stage_two_numbers(plan)
        for key in parts:
            if key not in journal.records:
                journal.add(key, point_record(5.0, rigid, values={}, failed=["finite numbers"]))

    monkeypatch.setattr(survey_module, "run_parts", all_fail)
    given = [
        "study",
        "flexibility",
        "paper-abaqus",
        "--set",
        "plate.elements=[8,4]",
        "--out",
        str(tmp_path / "out"),
    ]
    assert _status(given) == CHECK_FAILED
    assert "no run passed its checks" in capsys.readouterr().out
    assert "failed</span>" in (tmp_path / "out" / "report.html").read_text()
