"""Verify blind predictions by hand, and samples by single impacts."""

import dataclasses
import itertools

import numpy as np
import pytest

import tailslap
from solver import space
from solver.space.vehicle import fleet_of
from tailslap.campaign import input_ranges, sampling, space_samples
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.space import space_input
from tailslap.scene.vary import Source, vary
from tailslap.validation import outcomes, predictions
from tailslap.validation import validation_report as validation_report_module
from tailslap.validation.validation_report import validation_report

PARAMETERS = predictions.parameters()
VEHICLES = PARAMETERS["vehicles"]


def case_of_vehicle(name):
    return ImpactCase(*vary(Source(tables=dict(VEHICLES[name]["scene"])), {}))


@pytest.mark.parametrize("name", sorted(VEHICLES))
def test_ranges_are_of_keys_of_the_vehicle_and_contain_its_values(name):
    case, limits = case_of_vehicle(name), VEHICLES[name]["ranges"]
    ranges, nominal = space_samples.stated_ranges(case, limits), case.inputs
    assert {item.key for item in ranges} == set(limits)
    assert all(source.strip() for _, _, source in limits.values())
    for item in ranges:
        value = 1.0 if "*" in item.key else nominal[item.key.partition("@")[0]]
        assert item.lower <= value <= item.upper, item.key


def test_each_case_states_a_source_and_known_quantities():
    for case in PARAMETERS["cases"]:
        assert case["source"], case["name"]
        assert case["vehicle"] in VEHICLES
        assert {published["quantity"] for published in case["published"]} <= set(predictions.QUANTITIES)
        assert set(case.get("ranges", ())) <= set(VEHICLES[case["vehicle"]]["ranges"])
    names = [case["name"] for case in PARAMETERS["cases"]]
    assert len(names) == len(set(names))


def test_a_row_by_hand():
    """A uniform force of 100 to 300 kN has known percentiles."""
    case = {"name": "by hand", "source": "here", "vehicle": "10000S"}
    ranges = tuple(
        input_ranges.Range(key, 0.0, 1.0, "", None, "")
        for key in ("contact.plateau_force", "contact.friction")
    )
    random = np.random.default_rng(1)
    a, b = random.random((2, 4096)), random.random((2, 4096))
    force = lambda inputs: 1e5 + 2e5 * inputs[0]  # noqa: E731
    mixed = [np.array([b[0], a[1]]), np.array([a[0], b[1]])]
    table = np.array([force(a), force(b), *map(force, mixed)])
    row = predictions.compared(
        case, {"quantity": "mean_50ms", "value": "150 kN"}, ranges, {"mean_50ms": table}
    )
    assert (row.lower, row.predicted, row.upper) == pytest.approx((1.1e5, 2e5, 2.9e5), rel=0.02)
    assert row.published == 1.5e5
    assert row.ratio == row.predicted / 1.5e5
    assert row.inside
    assert row.plateau == pytest.approx(1.0, abs=0.05)
    outside = predictions.compared(
        case, {"quantity": "mean_50ms", "value": "95 kN"}, ranges, {"mean_50ms": table}
    )
    assert not outside.inside


def test_samples_are_the_single_impact():
    """The truck's values as one sample equal the impact of `rigid`."""
    case = case_of_vehicle("10000S")
    sample = predictions.quantities(case, {"impact.speed": np.array([case.inputs["impact.speed"]])})
    single = case.answer
    for name in ("mean_50ms", "cfc60"):
        assert sample[name][0] == pytest.approx(single.peaks[name], rel=5e-3), name
    assert sample["exit_speed"][0] == pytest.approx(
        np.hypot(single.end["v_gx"], single.end["v_gy"]), rel=1e-3
    )


def test_statistics_and_report_by_hand():
    """Ratios 0.5 and 2 have the mean 1, spread exp(sqrt(2) ln 2)."""
    row = predictions.Row("a", "mean_50ms", 1e5, 0.9e5, 1.1e5, 2e5, 0.5, False, 0.1, "here")
    rows = (
        row,
        row._replace(case="b", published=0.5e5, ratio=2.0, plateau=0.9),
        row._replace(case="c", quantity="exit_speed", published=1e5, ratio=1.0, inside=True, plateau=None),
    )
    validation = predictions.Validation(rows, (), 10, 1.0)
    assert validation.geometric_mean == pytest.approx(1.0)
    assert validation.spread == pytest.approx(2.0 ** np.sqrt(2.0))
    assert [row.case for row in validation.independent] == ["a"]
    report = validation_report(validation)
    assert report.summary["inside"] == 1
    assert [row["case"] for row in report.summary["rows"]] == ["a", "b", "c"]
    assert "1 of 3" in report.page.headline.answer
    assert dataclasses.is_dataclass(validation)


def test_space_vehicles_contain_their_own_values_and_are_possible():
    """Samples have loaded wheels, and strips within the vehicle."""
    for name, vehicle in PARAMETERS["space_vehicles"].items():
        vehicle_case = ImpactCase(*vary(Source(tables=dict(vehicle["scene"])), {}))
        ranges, nominal = (
            space_samples.stated_ranges(vehicle_case, vehicle["ranges"]),
            space_samples.nominal_values(vehicle_case),
        )
        for item in ranges:
            assert item.lower <= nominal[item.key] <= item.upper, (name, item.key)
        points, _ = sampling.sobol_points(ranges, outcomes.SAMPLES)
        inputs = dict(zip((item.key for item in ranges), points, strict=True))
        values = space_samples.expanded(vehicle_case.scene, inputs)
        fleet = fleet_of(*space_input(vehicle_case.scene, values).arguments)
        assert len(fleet.units) == outcomes.SAMPLES


def test_each_published_outcome_states_a_source():
    for case in (*PARAMETERS["outcomes"], *PARAMETERS["space_cases"]):
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
    validation = predictions.Validation((), (), 10, 1.0, tuple(rows), ({"name": "b", "why": "unknown"},))
    sections = validation_report_module._outcome_sections(validation, outcomes.scores(rows))
    assert "published outcome" in str(sections[0].figures[0])
    assert [len(table.rows) for table in sections[0].tables] == [3, 3, 1]


def test_outcomes_of_samples_are_motions_of_their_own():
    """The first samples of a case are scenes of their own."""
    case = PARAMETERS["outcomes"][0]
    vehicle = PARAMETERS["space_vehicles"][case["vehicle"]]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(outcomes, "SAMPLES", 32)
        samples = outcomes.predicted_samples(case, vehicle)
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
        single = space.solve_spaces(*space_input(scene).arguments)
        assert samples["outcome"][number] == single.outcome[0]
        assert samples["space_mean_50ms"][number] == pytest.approx(float(single.mean_50ms[0]), rel=1e-9)


@pytest.mark.long
def test_rows_that_fail_stay():
    """Every published value has a row in order, also outside the band."""
    result = tailslap.validate()
    listed = [
        (case["name"], published["quantity"])
        for case, published in itertools.chain.from_iterable(
            ((case, published) for published in case["published"])
            for case in (*PARAMETERS["cases"], *PARAMETERS["space_cases"])
        )
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
