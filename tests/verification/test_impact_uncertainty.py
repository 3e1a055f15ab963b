"""Verify the study `uncertainty` of whole impacts."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from shared_cases import LINEAR_TRUCK
from test_uncertainty import by_key

from postprocess.report.command_report import write_report
from postprocess.report.terminal import printed
from postprocess.signals.filters import force_curves
from tailslap import cli
from tailslap.campaign import planar_ranges
from tailslap.case.impact import case, strike_columns
from tailslap.scene.read import read_scene
from tailslap.studies.uncertainty import uncertainty_study
from tailslap.studies.uncertainty.uncertainty_report import report


@pytest.fixture(scope="module")
def impacts():
    """The study of a whole impact, as small as it gets."""
    plan = impact_of()
    return uncertainty_study.spread(plan, planar_ranges.impact_ranges(plan), 288)


def impact_of(*changes, name=LINEAR_TRUCK):
    return case.ImpactCase(*read_scene(name, changes))


def test_peak_is_in_proportion_to_speed_and_root_of_stiffness_and_mass():
    """F = v sqrt(k m) where the path is equal.

    T ~ sqrt(m/k), so the stiffness is in proportion to v^2 and to m.
    """
    plan, ones = impact_of(), np.ones(3)
    faster, heavier = np.array([1.0, 1.3, 1.0]), np.array([1.0, 1.0, 1.7])
    inputs = {"impact.speed": 20.0 * faster, "vehicle.mass": 9000.0 * heavier}
    inputs["contact.stiffness"] = 1e6 * ones * faster**2 * heavier
    columns, fine = uncertainty_study.solved(plan, inputs), plan.impacts(inputs, tolerance=1e-4)
    force = faster * np.sqrt(faster**2 * heavier * heavier)
    for strike in (1, 2):
        peak, impulse, duration = (
            values[strike - 1] for values in (fine.peak_force, fine.impulse, fine.duration)
        )
        assert peak / peak[0] == pytest.approx(force, rel=1e-4)
        assert impulse / impulse[0] == pytest.approx(force / faster, rel=1e-4)
        assert duration / duration[0] == pytest.approx(1.0 / faster, rel=1e-4)
        for name in ("mean_50ms", "cfc60"):  # the filters' windows do not scale with the time
            values = columns[f"strike_{strike}.{name}"]
            assert values[2] / values[0] == pytest.approx(1.7, rel=1e-9)


def test_many_impacts_are_the_single_one():
    """Many impacts at a coarser step, with other inertia, match one."""
    vehicle = ("vehicle.centre_of_mass=4.6 m", "vehicle.yaw_inertia=80000 kg m^2")
    plan = impact_of(*vehicle, "contact.initial_force=20 kN")
    exact = strike_columns.both_strikes(plan.answer)
    many = uncertainty_study.solved(plan, {"impact.speed": np.array([25.034, 25.034])})
    assert plan.scene.impact.speed == pytest.approx(25.034, rel=1e-4)
    for name in strike_columns.COLUMNS:
        assert many[name] == pytest.approx(exact[name], rel=1e-3), name


def test_filtered_peaks_are_those_in_the_strike():
    """Rectangles of 1 N and 2 N follow each other."""
    force = np.zeros(400)
    force[100:180], force[190:300] = 1.0, 2.0
    curves = force_curves(np.tile(force, (3, 1)), 1e-3, strike_columns.FORCES)
    start, end = np.array([[0.1, 0.19, math.nan], [0.18, 0.3, math.nan]])
    peaks = strike_columns.peaks_within(curves, 1e-3, start, end)
    assert peaks["mean_50ms"][:2] == pytest.approx([1.0, 2.0], rel=1e-12)
    assert peaks["raw"].tolist() == pytest.approx([1.0, 2.0, math.nan], nan_ok=True)
    assert np.isnan([values[2] for values in peaks.values()]).all()


def test_the_shipped_truck_varies_what_is_not_known_of_it():
    """Front and rear vary separately, about the middle values of the scene."""
    truck = impact_of(name="impact-mash-tl4-sut")
    ranges = by_key(planar_ranges.impact_ranges(truck))
    expected = {f"contact.plateau_force{part}": (200e3, 500e3) for part in ("", "@rear")}
    expected |= {f"contact.hardening{part}": (1e5, 9e5) for part in ("", "@rear")}
    expected |= {"contact.restitution": (0.1, 0.35)}
    expected |= {f"contact.stiffness{part}": (1e6, 3e6) for part in ("", "@rear")}
    expected |= {"contact.friction": (0.1, 0.35), **{f"axle.{k}.friction": (0.5, 0.8) for k in (0, 1)}}
    unit = {"plateau_force": 1e3}  # the unit of the scene is kN
    for key, ends in expected.items():
        factor = (
            unit.get(key.removesuffix("@rear").rpartition(".")[2], 1.0) if ranges[key].unit == "kN" else 1.0
        )
        assert np.array([ranges[key].lower, ranges[key].upper]) * factor == pytest.approx(ends, rel=1e-9), key
        if "hardening" not in key and key != "contact.friction":  # the scene omits the first
            assert 0.5 * sum(ends) == pytest.approx(truck.inputs[key.removesuffix("@rear")])
    assert ranges["vehicle.yaw_inertia"].scene_value == pytest.approx(9979.0 * (10.0**2 + 2.438**2) / 12.0)
    assert all(item.origin for item in ranges.values())


def test_the_hardening_varies_where_the_scene_has_one():
    """Front and rear separately, from 0.1 to 0.9 of 0.5 MN/m."""
    keys = {"contact.hardening", "contact.hardening@rear"}
    truck = impact_of("contact.hardening=0.5 MN/m", name="impact-mash-tl4-sut")
    ranges = by_key(planar_ranges.impact_ranges(truck))
    for key in keys:
        assert (ranges[key].lower, ranges[key].upper) == pytest.approx((1e5, 9e5), rel=1e-9)
    peaks = truck.many({"contact.hardening@rear": np.array([0.0, 5e5])})["strike_2.raw"]
    assert peaks[0] == pytest.approx(350e3, rel=1e-6)
    assert peaks[1] > 360e3
    omitted, without = (
        by_key(planar_ranges.impact_ranges(impact_of(*changes, name="impact-mash-tl4-sut")))
        for changes in ((), ("contact.hardening=0",))
    )
    assert {omitted[key].scene_value for key in keys} == {None}
    assert not keys & without.keys()


def test_raw_and_filtered_forces_are_of_the_same_total():
    """Both corners are on their plateaus at once."""
    changes = "contact.restitution=0.1", "contact.friction=0.3"
    truck = impact_of(*changes, name="impact-mash-tl4-sut")
    strikes = {strike.corner: strike for strike in truck.motion.strikes[:2]}
    assert strikes["rear"].peak_force == pytest.approx(350e3, rel=1e-6)
    many = truck.many({"contact.restitution": np.array([0.1])})
    for values in (
        strike_columns.both_strikes(truck.answer),
        {name: column[0] for name, column in many.items()},
    ):
        assert values["strike_2.raw"] > 600e3
        assert values["strike_2.raw"] >= values["strike_2.mean_50ms"]
        assert values[strike_columns.LARGEST] >= values["strike_2.mean_50ms"] * (1.0 - 1e-12)


def test_indices_of_both_strikes_and_order_of_the_bands(impacts):
    for name, sources in impacts.sources.items():
        assert sum(row["total"] for row in sources) >= 1.0 - 1e-12, name
        for row in sources:
            for kind in ("first_order", "total"):
                low, high = row[f"{kind}_interval"]
                assert 0.0 <= low <= row[kind] <= high <= 1.0
    assert impacts.sources_of("strike_2.raw")[0]["key"] == "contact.stiffness@rear"
    assert impacts.sources_of("strike_1.raw")[0]["key"] == "contact.stiffness"
    for name in strike_columns.COLUMNS:
        low, middle, high = impacts.band(name).percentiles
        assert low < middle < high
        assert low < impacts.nominal[name] < high


def test_contacts_that_the_study_cannot_vary_are_refused(refused):
    changes = {"contact.stiffness": None, "contact.restitution": None}
    assert refused(planar_ranges.demand_crush, impact_of().varied(changes)) == "contact.stiffness"


def test_ranges_that_make_no_impact_are_refused(tmp_path):
    for text in ("impact.angle=0 deg:20 deg", "strike.duration=0.1:0.2", "contact.restitution=0.5:1.5"):
        arguments = ["study", "uncertainty", LINEAR_TRUCK, "--range", text, "--out", str(tmp_path / "out")]
        assert cli._status(arguments) == 2
    assert not (tmp_path / "out").exists()


def test_page_files_and_terminal_of_a_whole_impact(impacts, tmp_path):
    study_report = report(impacts)
    write_report(study_report, tmp_path)
    page = (tmp_path / "report.html").read_text()
    drawn = {path.stem for path in tmp_path.glob("*.svg")}
    assert {"bands", "sensitivity"} <= drawn
    assert page.count("<svg") - page.count("<template>") == len(drawn) == 3
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["own"] == pytest.approx(dict(impacts.nominal))
    with (tmp_path / "samples.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 2 * impacts.rows
    assert max(map(len, printed(study_report.terminal).splitlines())) <= 96


def test_impacts_without_a_second_strike_are_told(impacts):
    tables = {name: table.copy() for name, table in impacts.tables.items()}
    tables["strike_2.impulse"][0, :3] = np.nan
    study = replace(impacts, tables=tables)
    assert study.band("strike_2.impulse").values.size == 2 * study.rows - 3
    study_report = report(study)
    assert study_report.summary["without_second_strike"] == 3
    sentences = [text for part in study_report.page.sections for text in part.sentences]
    assert any("3 impacts have no second strike" in text for text in sentences)
