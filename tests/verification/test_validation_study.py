"""Blind predictions beside published values: exact answers by hand, and samples against single impacts."""

import dataclasses
import itertools

import numpy as np
import pytest

import tailslap
from tailslap.campaign import input_ranges
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.vary import Source, vary
from tailslap.validation import predictions
from tailslap.validation.validation_report import validation_report

PARAMETERS = predictions.parameters()
VEHICLES = PARAMETERS["vehicles"]


def case_of_vehicle(name):
    return ImpactCase(*vary(Source(given=dict(VEHICLES[name]["scene"])), {}))


@pytest.mark.parametrize("name", sorted(VEHICLES))
def test_ranges_are_of_keys_of_the_vehicle_and_contain_its_values(name):
    case, limits = case_of_vehicle(name), VEHICLES[name]["ranges"]
    ranges = input_ranges.ranges_of(case, case.arguments, limits, (), ())
    assert {item.key for item in ranges} == set(limits)
    assert all(source.strip() for _, _, source in limits.values())
    for item in ranges:
        assert item.lower <= case.inputs[item.key] <= item.upper, item.key


def test_each_case_states_a_source_and_known_quantities():
    for case in PARAMETERS["cases"]:
        assert case["source"], case["name"]
        assert case["vehicle"] in VEHICLES
        assert {published["quantity"] for published in case["published"]} <= set(predictions.QUANTITIES)
        assert set(case.get("ranges", ())) <= set(VEHICLES[case["vehicle"]]["ranges"])
    names = [case["name"] for case in PARAMETERS["cases"]]
    assert len(names) == len(set(names))


def test_a_row_by_hand():
    """A force of 100 to 300 kN, uniform: percentiles, ratio, and the variance of the only input with an effect."""
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
    """The truck's own values as one sample, against the impact of `rigid` with its finer step."""
    case = case_of_vehicle("10000S")
    sample = predictions.quantities(case, {"impact.speed": np.array([case.inputs["impact.speed"]])})
    single = case.answer
    for name in ("mean_50ms", "cfc60"):
        assert sample[name][0] == pytest.approx(single.peaks[name], rel=5e-3), name
    assert sample["exit_speed"][0] == pytest.approx(
        np.hypot(single.end["v_gx"], single.end["v_gy"]), rel=1e-3
    )


def test_statistics_and_report_by_hand():
    """Ratios 0.5 and 2 have the geometric mean 1 and the spread exp(sqrt(2) ln 2)."""
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


@pytest.mark.long
def test_rows_that_fail_stay():
    """Every published value of the file has its row, in its order, whether it lies in the band or not."""
    result = tailslap.validate()
    listed = [
        (case["name"], published["quantity"])
        for case, published in itertools.chain.from_iterable(
            ((case, published) for published in case["published"]) for case in PARAMETERS["cases"]
        )
    ]
    assert [(row["case"], row["quantity"]) for row in result.summary["rows"]] == listed
    for row in result.summary["rows"]:
        assert row["lower"] < row["predicted"] < row["upper"]
        assert row["inside"] is (row["lower"] <= row["published"] <= row["upper"])
