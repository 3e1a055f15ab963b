"""Verify predictions by hand, and samples by single impacts."""

import numpy as np
import pytest
from test_conformal import ROWS

import tailslap
from solver import space
from solver.space.vehicle import fleet_of
from tailslap.campaign import sampling, space_samples
from tailslap.case.force_band import Calibration
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.space.input import space_input
from tailslap.scene.vary import Source, vary
from tailslap.validation import outcomes, predictions
from tailslap.validation import validation_report as validation_report_module
from tailslap.validation.calibration import classes
from tailslap.validation.samples import Samples, in_plane, samples_of
from tailslap.validation.tables import SETS, parameters
from tailslap.validation.validation_report import validation_report

TABLES = {name: parameters(name) for name in SETS}
PARAMETERS = TABLES["first"]
VEHICLES = PARAMETERS["vehicles"]


def case_of_vehicle(vehicle):
    return ImpactCase(*vary(Source(tables=dict(vehicle["scene"])), {}))


@pytest.mark.parametrize(
    ("of", "table", "name"),
    [
        (of, table, name)
        for of in SETS
        for table in ("vehicles", "space_vehicles")
        for name in TABLES[of][table]
    ],
)
def test_ranges_are_of_keys_of_the_vehicle_and_contain_its_values(of, table, name):
    vehicle = TABLES[of][table][name]
    ranges = space_samples.stated_ranges(case_of_vehicle(vehicle), vehicle["ranges"])
    assert {item.key for item in ranges} == set(vehicle["ranges"])
    assert all(source.strip() for _, _, source in vehicle["ranges"].values())
    for item in ranges:
        value = 1.0 if "*" in item.key else item.scene_value
        assert value is None or item.lower <= value <= item.upper, item.key


def test_each_case_states_a_source_and_known_quantities():
    for case in PARAMETERS["cases"]:
        assert case["source"], case["name"]
        assert case["study"], case["name"]
        assert {published["quantity"] for published in case["published"]} <= set(predictions.QUANTITIES)
        for tables in TABLES.values():
            for published in case["published"]:
                table = "space_vehicles" if published.get("wall", case.get("wall")) else "vehicles"
                assert set(case.get("ranges", ())) <= set(tables[table][case["vehicle"]]["ranges"])
    names = [case["name"] for case in PARAMETERS["cases"]]
    assert len(names) == len(set(names))
    assert {name for one in PARAMETERS["classes"] for name in one["vehicles"]} <= set(VEHICLES) | {"8000S"}


def test_forces_of_crash_tests_are_inertial_and_heights_are_in_space():
    """A height of design is no row."""
    kinds = {
        (case["name"].partition(":")[0], published["quantity"]): published.get("wall", case.get("wall"))
        for case in PARAMETERS["cases"]
        for published in case["published"]
    }
    rows = ("Table 4, row a", "Table 4, row b", "TL-4 by acceleration, 22 050 lb and 4.5 g")
    assert [name for name, quantity in kinds if quantity == "inertial_50ms"] == list(rows)
    assert all(wall for (_, quantity), wall in kinds.items() if quantity in ("inertial_50ms", "height"))
    assert [name for name, quantity in kinds if quantity == "height"] == ["MASH TL-4, vertical wall of 36 in"]


@pytest.mark.parametrize(("published", "inside"), [("150 kN", True), ("95 kN", False)])
def test_a_row_by_hand(published, inside):
    """A uniform force of 100 to 300 kN has known percentiles."""
    case = {"name": "by hand", "source": "here", "vehicle": "10000S", "study": "ours"}
    random = np.random.default_rng(1).random((2, 4096))
    inputs = dict(zip(("contact.plateau_force@rear", "contact.friction"), random, strict=True))
    samples = Samples(inputs, {"mean_50ms": 1e5 + 2e5 * random[0]})
    row = predictions.compared(case, {"quantity": "mean_50ms", "value": published}, samples, False)
    assert (row.lower, row.predicted, row.upper) == pytest.approx((1.1e5, 2e5, 2.9e5), rel=0.02)
    assert row.ratio == row.predicted / row.published
    assert (row.kind, row.inside) == (predictions.ON_THE_WALL, inside)
    assert row.plateau == pytest.approx(1.0, abs=0.05)


def test_samples_are_the_single_impact():
    """The truck's values as one sample equal the impact of `rigid`."""
    case = case_of_vehicle(VEHICLES["10000S"])
    sample = in_plane(case, {"impact.speed": np.array([case.inputs["impact.speed"]])})
    single = case.answer
    for name in ("mean_50ms", "cfc60"):
        assert sample[name][0] == pytest.approx(single.peaks[name], rel=5e-3), name
    assert sample["inertial_50ms"][0] == pytest.approx(case.inertial["mean_50ms"], rel=5e-3)
    assert sample["exit_speed"][0] == pytest.approx(
        np.hypot(single.end["v_gx"], single.end["v_gy"]), rel=1e-3
    )


def test_statistics_and_report_by_hand():
    """Ratios 0.5 and 2 have the mean 1, spread exp(sqrt(2) ln 2)."""
    row = ROWS[0]._replace(
        kind=predictions.ON_THE_WALL, predicted=1e5, lower=0.9e5, upper=1.1e5, published=2e5, ratio=0.5,
        inside=False, plateau=0.1, vehicle="10000S",
    )  # fmt: skip
    rows = (
        row,
        row._replace(case="b", published=0.5e5, ratio=2.0, plateau=0.9),
        row._replace(case="c", quantity="exit_speed", published=1e5, ratio=1.0, inside=True, plateau=0.8),
    )
    former = (row._replace(ratio=0.4), row._replace(ratio=1.5), rows[2])
    classes_of = Calibration("trucks", 11, 6, 0.8, 1.3, 1.4, 10, 5), Calibration("cars", 1, 1, 1.3, 1.3)
    validation = predictions.Validation("second", rows, (), 10, 1.0, former=former, calibrations=classes_of)
    assert validation.geometric_mean == pytest.approx(1.0)
    assert validation.spread == pytest.approx(2.0 ** np.sqrt(2.0))
    assert [row.case for row in validation.independent] == ["a"]
    assert [row.case for row in validation.worse] == ["b"]
    report = validation_report(validation)
    of_trucks = {"factor": 1.4, "rows": 11, "studies": 6, "left_out_rows": 10, "left_out_studies": 5}
    assert report.summary["calibration"]["trucks"] == of_trucks
    assert report.summary["calibration"]["cars"].startswith("inputs alone, not calibrated; ")
    assert report.summary["inside"] == 1
    assert [row["case"] for row in report.summary["rows"]] == ["a", "b", "c"]
    assert "1 of 3" in report.page.headline.answer
    assert "Worse than with the first set: b (largest 50 ms mean)." in str(report.terminal[1])


@pytest.mark.parametrize("of", SETS)
def test_space_vehicles_are_possible(of):
    """Samples have loaded wheels, and strips within the vehicle."""
    for vehicle in TABLES[of]["space_vehicles"].values():
        vehicle_case = case_of_vehicle(vehicle)
        ranges = space_samples.stated_ranges(vehicle_case, vehicle["ranges"])
        points, _ = sampling.sobol_points(ranges, outcomes.SAMPLES)
        inputs = dict(zip((item.key for item in ranges), points, strict=True))
        values = space_samples.expanded(vehicle_case.scene, inputs)
        fleet = fleet_of(*space_input(vehicle_case.scene, values))
        assert len(fleet.units) == outcomes.SAMPLES


def test_each_published_outcome_states_a_source():
    for case in PARAMETERS["outcomes"]:
        assert case["source"], case["name"]
        assert case["vehicle"] in PARAMETERS["space_vehicles"]
    assert {case["published"] for case in PARAMETERS["outcomes"]} <= set(outcomes.STATED)
    assert all(case["why"] for case in PARAMETERS["not_computed"])


def test_rules_reproduce_published_heights():
    """AASHTO LRFD has 34.0 in for TL-4, 36.6 in for 80 kip."""
    inches = [outcomes.rule_height(rule) / 0.0254 for rule in PARAMETERS["rules"]]
    assert inches == pytest.approx([34.0, 36.625, 32.0, 36.0], abs=1e-9)


def test_brier_scores_by_hand():
    """Probabilities 0.6, 0.1 and 0.2 have (0.16 + 0.81 + 0.04)/3."""
    parts = np.repeat([0, 1, 2], [10, 10, 12])
    heights = {"rule": 0.9}
    base = {
        "name": "a",
        "vehicle": "10000S",
        "wall": {"height": "0.8 m"},
        "source": "here",
        "published": "contained",
    }
    row = outcomes.outcome_row(base, parts, heights)
    assert sum(row.probabilities.values()) == pytest.approx(1.0, abs=1e-15)
    assert row.probabilities == pytest.approx(
        {"upright": 10 / 32, "on its side": 10 / 32, "over the wall": 12 / 32}
    )
    assert row.stated == pytest.approx(20 / 32)
    assert row.holds == {"rule": False}

    def with_probability(over, published, holds):
        probabilities = {"upright": 1.0 - over, "on its side": 0.0, "over the wall": over}
        return row._replace(probabilities=probabilities, published=published, holds={"rule": holds})

    rows = [
        with_probability(0.6, "over the wall", False), with_probability(0.1, "over the wall", True),
        with_probability(0.2, "contained", True),
    ]  # fmt: skip
    ours, rule, always = outcomes.scores(rows)
    assert (ours.score, ours.right) == (pytest.approx((0.16 + 0.81 + 0.04) / 3.0), 2)
    assert (rule.score, rule.right) == (pytest.approx(1.0 / 3.0), 2)
    assert (always.score, always.right) == (pytest.approx(2.0 / 3.0), 1)
    skipped = ({"name": "b", "why": "unknown"},)
    validation = predictions.Validation("first", (), (), 10, 1.0, tuple(rows), skipped)
    sections = validation_report_module._outcome_sections(validation, outcomes.scores(rows))
    assert "published outcome" in str(sections[0].figures[0])
    assert [len(table.rows) for table in sections[0].tables] == [3, 3, 1]


def test_outcomes_of_samples_are_motions_of_their_own():
    """The first samples of a case are scenes of their own."""
    case = PARAMETERS["outcomes"][0]
    vehicle = PARAMETERS["space_vehicles"][case["vehicle"]]
    samples = samples_of(PARAMETERS, case, case["wall"], 32).answers
    vehicle_case = ImpactCase(*vary(Source(tables=vehicle["scene"] | {"wall": case["wall"]}), {}))
    ranges = space_samples.stated_ranges(vehicle_case, vehicle["ranges"])
    points, _ = sampling.sobol_points(ranges, 32)
    for number in (0, 7):
        inputs = {item.key: float(value) for item, value in zip(ranges, points[:, number], strict=True)}
        changes = {
            key: value
            for key, value in space_samples.expanded(vehicle_case.scene, inputs).items()
            if ".height." not in key
        }
        centre = inputs["body.centre_height"]
        changes |= {"strip.3.height": [1.2446, min(2.6, 2.0 * centre)]}
        scene, _ = vary(Source(tables=vehicle["scene"] | {"wall": case["wall"]}), changes)
        single = space.solve_spaces(*space_input(scene))
        assert samples["outcome"][number] == single.outcome[0]
        assert samples["mean_50ms"][number] == pytest.approx(float(single.mean_50ms[0]), rel=1e-9)


@pytest.mark.long
def test_rows_that_fail_stay():
    """Every published value has a row in order, also outside the band."""
    result = tailslap.validate()
    listed = [
        (case["name"], published["quantity"])
        for case in PARAMETERS["cases"]
        for published in case["published"]
    ]
    assert [(row["case"], row["quantity"]) for row in result.summary["rows"]] == listed
    for row in result.summary["rows"]:
        assert row["lower"] < row["predicted"] < row["upper"]
        assert row["inside"] is (row["lower"] <= row["published"] <= row["upper"])
    assert [row["case"] for row in result.summary["outcomes"]] == [
        case["name"] for case in PARAMETERS["outcomes"]
    ]
    for row in result.summary["outcomes"]:
        assert sum(row["probabilities"].values()) == pytest.approx(1.0, abs=1e-12)
    for one, of in zip(PARAMETERS["classes"], classes(), strict=True):
        rows = [row for row in result.summary["rows"] if row["vehicle"] in one["vehicles"]]
        forces = [row for row in rows if row["quantity"] in predictions.FORCES]
        assert [{name: row[name] for name in forces[0]} for row in of.published] == forces
