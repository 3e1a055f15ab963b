"""Verify conformal calibration by known order statistics."""

import json
import math

import numpy as np
import pytest

from machine_code.system import folder
from tailslap.case import case_of
from tailslap.scene.read import read_scene
from tailslap.validation import calibration, predictions
from tailslap.validation.conformal import calibration_of, conformal_factor, held_of_left_out, score
from tailslap.validation.tables import parameters

ROWS = [
    predictions.Row("a", "mean_50ms", "", False, 1.0, 0.5, 2.0, 1.5, 0.7, True, 0.0, vehicle, "A", "here")
    for vehicle in ("8000S", "2270P", "36000T")
]
"""A force of each class."""


@pytest.mark.parametrize(("count", "place"), [(8, None), (9, 9), (11, 11), (19, 18), (29, 27), (99, 90)])
def test_the_factor_is_the_order_statistic(count, place):
    """It is the ceil(0.9 (n + 1))-th smallest, from nine on."""
    scores = np.random.default_rng(count).permutation(np.arange(1.0, count + 1.0)).tolist()
    assert conformal_factor(scores) == place


def test_nine_of_ten_further_values_lie_in_the_band():
    """For exchangeable scores coverage is ceil(0.9 (n + 1))/(n + 1)."""
    random = np.random.default_rng(1).exponential(size=(4000, 12))
    held = np.mean([row[-1] <= conformal_factor(row[:-1].tolist()) for row in random])
    assert held == pytest.approx(11.0 / 12.0, abs=4.0 * math.sqrt(11.0 / 144.0 / 4000.0))


@pytest.mark.parametrize(("published", "expected"), [(4e5, 2.0), (2e5, 1.0), (1e5, 0.0), (0.5e5, 0.5)])
def test_scores_are_half_widths_of_either_side(published, expected):
    """The band of 25 to 200 kN about 100 kN."""
    assert score(published, 0.25e5, 1e5, 2e5) == pytest.approx(expected, abs=1e-15)


def test_whole_studies_are_left_out():
    """Both values of A exceed what B and C allow."""
    scores, studies = [5.0, 4.0, 3.0, 0.5, *10 * [1.0]], ["A", "A", "B", "B", *10 * ["C"]]
    assert held_of_left_out(scores, studies) == [False, False, True, True, *10 * [True]]
    calibration = calibration_of(
        "all", [2.0**one for one in scores], len(scores) * [(0.5, 1.0, 2.0)], studies
    )
    assert (calibration.rows, calibration.studies) == (14, 3)
    assert calibration.factor == pytest.approx(5.0)
    assert (calibration.rows_held, calibration.studies_held) == (12, 2)
    assert (calibration.least, calibration.most) == pytest.approx((math.sqrt(2.0), 32.0))


def test_eight_values_have_no_factor():
    calibration = calibration_of("few", 8 * [1.5], 8 * [(0.5, 1.0, 2.0)], [*"ABCDEFGH"])
    assert (calibration.factor, calibration.rows_held, calibration.most) == (None, None, 1.5)


@pytest.mark.parametrize(("scene", "changes", "place"), [
    ("impact-mash-tl4-sut", (), 0),
    ("impact-mash-tl4-sut", ("impact.speed=75 mph",), None),
    ("impact-mash-tl4-sut", ("vehicle.mass=20000",), None),
    ("impact-mash-tl3-pickup", (), 1),
    ("impact-mash-tl5-tractor-van", (), 2),
    ("impact-mash-tl1-car", (), None),
])  # fmt: skip
def test_a_class_has_its_level_mass_and_speed(scene, changes, place):
    known = calibration.described(parameters(), [ROWS[0]._replace(quantity="duration"), *ROWS])
    assert [[row["vehicle"] for row in of.published] for of in known] == [[row.vehicle] for row in ROWS]
    found = calibration.class_of(case_of(*read_scene(scene, changes)), known)
    assert found is (None if place is None else known[place])


def test_calibrations_are_kept_under_the_digest_of_what_they_depend_on(tmp_path, monkeypatch):
    monkeypatch.setattr(folder, "cache_folder", lambda: tmp_path)
    computed, sources = [], ["1"]

    def rows(*arguments):
        computed.append(arguments)
        return ROWS, 0

    expected = calibration.described(parameters(), ROWS)
    monkeypatch.setattr(predictions, "predicted_rows", rows)
    monkeypatch.setattr(folder, "own_sources", lambda *packages: sources[0])
    for digest, count in (("1", 1), ("1", 1), ("2", 2)):
        sources[0] = digest
        calibration.classes.cache_clear()
        assert calibration.classes() == expected
        assert len(computed) == count
    (path, other) = sorted(tmp_path.glob("calibration-*.json"))
    for damage in (b"", b"[1]", json.dumps([{"name": "x"}]).encode()):
        path.write_bytes(damage), other.write_bytes(damage)
        calibration.classes.cache_clear()
        assert calibration.classes() == expected
    calibration.classes.cache_clear()
