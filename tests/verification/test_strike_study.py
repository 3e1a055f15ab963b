"""Verification: the study `strike` against laws of similarity, closed forms and single solutions."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from postprocess.report.terminal import printed
from postprocess.signals.filters import moving_mean
from solver.impact import Strike, solve_impacts
from tailslap.case.impact.case import ImpactCase
from tailslap.command_line import _status
from tailslap.errors import InputError
from tailslap.impact.rigid_text import rigid_impact
from tailslap.scene.read import read_scene
from tailslap.scene.vary import vary
from tailslap.studies.strike.bands import Bands, band_of, find_bands
from tailslap.studies.strike.campaign import StrikeResults, find_strikes
from tailslap.studies.strike.impacts import demand_corners, measured
from tailslap.studies.strike.limits import band_ranges, curve_inputs
from tailslap.studies.strike.plates import _point, both_strikes, first_strike
from tailslap.studies.strike.quantities import COLUMNS, STRIKES, column, filtered, peaks_within
from tailslap.studies.strike.report import strike_report
from tailslap.studies.strike.rows import RowBeside

pytestmark = pytest.mark.verification

TRUCK = "impact-mash-tl4-sut"
FIXED = (
    "contact.restitution",
    "contact.friction",
    "impact.speed",
    "impact.angle",
    "vehicle.centre_of_mass",
)


def plan_of(*changes: str) -> ImpactCase:
    return ImpactCase(*read_scene(TRUCK, changes))


@pytest.fixture(scope="module")
def found() -> StrikeResults:
    """The study without a plate, as small as it gets."""
    plan = plan_of("plate=")
    return find_strikes(plan, band_ranges(plan, (), ()), 288)


def test_peak_is_in_proportion_to_speed_and_root_of_stiffness_and_mass() -> None:
    """F = v sqrt(k m) of a point mass, exact here too where the path is the same: k ~ v^2, k ~ m; T ~ sqrt(m/k)."""
    plan, ones = plan_of(), np.ones(3)
    faster, heavier = np.array([1.0, 1.3, 1.0]), np.array([1.0, 1.0, 1.7])
    inputs = {
        "impact.speed": 20.0 * faster,
        "vehicle.mass": 9000.0 * heavier,
        "contact.stiffness": 1e6 * ones * faster**2 * heavier,
    }
    columns = measured(plan, inputs)
    force = faster * np.sqrt(faster**2 * heavier * heavier)
    for strike in STRIKES:
        raw, impulse, duration = (columns[column(strike, name)] for name in ("raw", "impulse", "duration"))
        assert raw / raw[0] == pytest.approx(force, rel=1e-9)
        assert impulse / impulse[0] == pytest.approx(force / faster, rel=1e-9)
        assert duration / duration[0] == pytest.approx(1.0 / faster, rel=1e-9)
        for name in ("mean_50ms", "cfc60"):  # the filters' windows do not scale with the time
            values = columns[column(strike, name)]
            assert values[2] / values[0] == pytest.approx(1.7, rel=1e-9)


def test_many_impacts_are_the_single_one() -> None:
    """Against the solution from event to event, with yaw inertia and centre of mass of their own."""
    plan = plan_of(
        "vehicle.centre_of_mass=4.6 m", "vehicle.yaw_inertia=80000 kg m^2", "contact.initial_force=20 kN"
    )
    exact, many = (
        both_strikes(rigid_impact(plan)),
        measured(plan, {"impact.speed": np.array([25.034, 25.034])}),
    )
    plan_speed = plan.scene.impact.speed if plan.scene.impact else 0.0
    assert plan_speed == pytest.approx(25.034, rel=1e-4)
    for name in COLUMNS:
        assert many[name] == pytest.approx(exact[name], rel=1e-3), name


def test_rows_of_the_force_history_hold_impulse_and_mean() -> None:
    given = {"length": 10.0, "width": 2.438, "mass": 9979.0, "speed": 25.0, "angle": 0.26, "friction": 0.47}
    impacts = solve_impacts(**given, stiffness=np.array([[1e6, 2e6]]), restitution=0.22, interval=5e-4)
    assert impacts.mean_force.shape[1:] == (1, 2)
    for force, mean in zip(impacts.mean_force[:, 0].T, impacts.mean_50ms[0], strict=True):
        assert moving_mean(np.append(0.0, force), 5e-4, 0.05).max() == pytest.approx(mean, rel=1e-3)
    first = impacts.mean_force[: round(0.2 / 5e-4)].sum(axis=0) * 5e-4
    assert first == pytest.approx(impacts.impulse[0], rel=1e-9)
    assert solve_impacts(**given, stiffness=1e6, restitution=0.2).mean_force.shape == (0,)


def test_filtered_peaks_are_those_in_the_strike() -> None:
    """A rectangle of 80 ms and 1 N, and 10 ms later one of 2 N: the mean of the first does not know the second."""
    force = np.zeros(400)
    force[100:180], force[190:300] = 1.0, 2.0
    curves = filtered(force, 1e-3)
    assert peaks_within(curves, 1e-3, 0.1, 0.18)["mean_50ms"] == pytest.approx(1.0, rel=1e-12)
    assert peaks_within(curves, 1e-3, 0.19, 0.3)["mean_50ms"] == pytest.approx(2.0, rel=1e-12)
    assert all(map(math.isnan, peaks_within(curves, 1e-3, math.nan, math.nan).values()))


def test_one_input_has_all_of_the_variance() -> None:
    plan = plan_of()
    ranges = band_ranges(plan, (), (*FIXED, "vehicle.mass"))
    assert [item.key for item in ranges] == ["contact.stiffness"]
    bands = find_bands(plan, ranges, 288, lambda share: None)
    for name in ("strike_1.raw", "strike_2.mean_50ms", "strike_2.duration"):
        (source,) = bands.sources[name]
        assert (source.first_order, source.total) == pytest.approx((1.0, 1.0), abs=0.05)


def test_shares_of_the_variance_and_order_of_the_bands(found: StrikeResults) -> None:
    for name, sources in found.bands.sources.items():
        assert sum(item.total for item in sources) > 0.8, name  # at least 1, but for the few rows
        assert all(item.total > -0.02 for item in sources)
    shares = {item.key: item.total for item in found.bands.sources["strike_2.raw"]}
    assert max(shares, key=lambda key: shares[key]) == "contact.stiffness"
    for name in COLUMNS:
        low, middle, high = found.bands.band(name).percentiles
        assert low < middle < high
        assert low < found.own[name] < high


def test_order_statistics() -> None:
    band = band_of(np.append(np.arange(101.0), np.nan))
    assert band.percentiles == (5.0, 50.0, 95.0)
    assert band.share_below(50.0) == pytest.approx(50.0 / 101.0)
    assert band.standard_deviation == pytest.approx(math.sqrt(101.0 * 102.0 / 12.0), rel=1e-12)


def row(measured_force: float) -> RowBeside:
    band = band_of(np.array([90.0, 100.0, 110.0]))
    return RowBeside("x", "made up", "50 ms mean", measured_force, False, "", 100.0, band, 3.0, 4.0)


def test_validation_uncertainty_by_hand() -> None:
    """u_val^2 = 3^2 + 4^2 without u_D; E = 13 needs u_D = 12."""
    near, far = row(104.0), row(87.0)
    assert (near.error, near.u_known, near.within, near.u_d_needed) == (-4.0, 5.0, True, 0.0)
    assert (far.error, far.within) == (13.0, False)
    assert far.u_d_needed == pytest.approx(12.0, rel=1e-14)
    assert near.verdict == "within u_val"
    assert "unless u_D" in far.verdict


def test_rows_are_the_papers_and_row_b_has_its_own_speed_and_angle(found: StrikeResults) -> None:
    assert [each.row for each in found.rows] == [*"abcdef"] * 2
    by_row = {each.row: each for each in found.rows[:6]}
    assert [by_row[name].measured for name in "abcdef"] == [680e3, 595e3, 415e3, 351e3, 360e3, 375e3]
    assert len({by_row[name].simulated for name in "acdef"}) == 1
    assert by_row["b"].simulated > by_row["a"].simulated
    assert "57.4 mph" in by_row["b"].known


def test_another_test_level_has_no_rows() -> None:
    plan = ImpactCase(*read_scene("impact-mash-tl3-car", ("plate=",)))
    assert find_strikes(plan, band_ranges(plan, (), ()), 288).rows == ()


def test_curves_go_through_the_scenes_own_values(found: StrikeResults) -> None:
    assert [item.key for item in curve_inputs(found.plan)] == [each.input.key for each in found.curves]
    for each in found.curves:
        for name in ("strike_1.raw", "strike_2.impulse"):
            own = np.interp(each.input.own, each.input.values, each.columns[name])
            assert own == pytest.approx(found.own[name], rel=0.02), (each.input.key, name)


def contact(start: float, end: float) -> Strike:
    return Strike("front", start, end, 1.0, 1.0)


def test_contacts_of_a_corner_that_are_close_are_one_strike() -> None:
    contacts = [contact(0.0, 0.1), contact(0.14, 0.2), contact(0.26, 0.3)]
    assert first_strike(contacts) == contacts[:2]
    assert first_strike([]) == []


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"contact.side_stiffness": 1e10}, "contact.side_stiffness"),
        ({"contact.stiffness": None, "contact.restitution": None}, "contact.stiffness"),
    ],
)
def test_contacts_that_the_study_cannot_vary_are_refused(changes: dict[str, Any], key: str) -> None:
    plan = ImpactCase(*vary(plan_of().source, changes))
    with pytest.raises(InputError) as caught:
        demand_corners(plan)
    assert caught.value.key == key


@pytest.mark.parametrize(
    ("study", "scene", "words"),
    [
        ("strike", "mash-tl4-sut", "with this table"),
        ("uncertainty", TRUCK, "without this table"),
    ],
)
def test_a_study_of_the_other_calculation_is_refused(
    study: str, scene: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _status(["study", study, scene, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "contact: given" in said
    assert words in said
    assert not (tmp_path / "out").exists()


def test_ranges_that_make_no_impact_are_refused(tmp_path: Path) -> None:
    for given in ("impact.angle=0 deg:20 deg", "strike.duration=0.1:0.2", "contact.restitution=0.5:1.5"):
        assert _status(["study", "strike", TRUCK, "--range", given, "--out", str(tmp_path / "out")]) == 2
    assert not (tmp_path / "out").exists()


def test_page_files_and_terminal(found: StrikeResults, tmp_path: Path) -> None:
    from postprocess.report.report import write_report

    report = strike_report(found)
    write_report(report, tmp_path)
    page = (tmp_path / "report.html").read_text()
    drawn = {path.stem for path in tmp_path.glob("*.svg")}
    assert {"bands", "sensitivity", "inputs-legend", "against-contact-friction"} <= drawn
    assert page.count("<svg") == len(drawn) == 3 + len(found.curves)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["own"] == pytest.approx(dict(found.own))
    assert {each["u_d"] for each in summary["rows"]} == {None}
    with (tmp_path / "samples.csv").open() as file:
        samples = list(csv.DictReader(file))
    assert len(samples) == found.bands.columns["strike_1.raw"].size
    with (tmp_path / "curves.csv").open() as file:
        assert {line["input"] for line in csv.DictReader(file)} == {each.input.key for each in found.curves}
    assert max(map(len, printed(report.terminal).splitlines())) <= 96


def test_impacts_without_a_second_strike_are_told(found: StrikeResults) -> None:
    columns = {name: values.copy() for name, values in found.bands.columns.items()}
    columns["strike_2.impulse"][:3] = np.nan
    bands: Bands = replace(found.bands, columns=columns)
    assert bands.single == 3
    assert bands.band("strike_2.impulse").values.size == columns["strike_2.impulse"].size - 3
    said = strike_report(replace(found, bands=bands)).page.sections
    assert any("3 impacts have no second strike" in text for part in said for text in part.sentences)


@pytest.mark.long
def test_a_stiff_plate_is_the_rigid_vehicle() -> None:
    plan = plan_of("plate.elements=[10, 4]")
    rigid, point = both_strikes(rigid_impact(plan)), _point(plan, 200.0)
    assert point.failed == ()
    assert point.error < 1e-2
    for name, value in point.values.items():
        assert value == pytest.approx(rigid[name], rel=1e-2), name
