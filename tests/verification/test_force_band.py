"""Verify bands of forces on the first screen.

Exact: stratified points, parts of the variance of linear functions, means of triangles, percentiles of samples.
Agreement: the band of 256 samples with that of the study of uncertainty.
"""

import json
import os
import sys

import numpy as np
import pytest
from shared_cases import case

import solver
import tailslap
from postprocess.signals.filters import moving_mean
from postprocess.units import SI
from solver.impact import trajectories
from tailslap.campaign import band_samples, planar_ranges, sampling
from tailslap.case.case import NO_BAND
from tailslap.case.force_band import Calibration, ForceBand
from tailslap.case.impact import strike_columns

TRUCK, IMPACT, SPACE = "mash-tl4-sut", "impact-mash-tl4-sut", "impact-tipping-tl4-sut"


@pytest.fixture(scope="module")
def bands():
    return {name: band_samples.force_band(case(name)) for name in (TRUCK, IMPACT, SPACE)}


@pytest.mark.parametrize(("columns", "rows"), [(1, 7), (5, 64)])
def test_each_part_of_an_axis_has_one_point(columns, rows):
    points = sampling.latin_hypercube(columns, rows, np.random.default_rng(1))
    assert points.shape == (columns, rows)
    assert np.sort(np.floor(points * rows), axis=1) == pytest.approx(np.tile(np.arange(rows), (columns, 1)))


def test_shares_of_a_linear_function_are_exact():
    random = np.random.default_rng(2)
    x = {"a": random.normal(size=200), "b": random.random(200), "c": random.random(200)}
    y = 1.0 + 2.0 * x["a"] - 5.0 * x["b"]
    shares = band_samples.variance_fractions(x, y)
    assert shares["a"] == pytest.approx(4.0 * np.var(x["a"]) / np.var(y), rel=1e-12)
    assert shares["b"] == pytest.approx(25.0 * np.var(x["b"]) / np.var(y), rel=1e-12)
    assert shares["c"] == pytest.approx(0.0, abs=1e-20)
    assert list(shares) == sorted(shares, key=lambda key: -shares[key])


@pytest.mark.parametrize("duration", [0.02, 0.05, 0.08, 0.1, 0.18])
def test_the_mean_of_a_triangle_is_that_of_the_filter(duration):
    interval = 1e-5
    t = interval * (np.arange(round(0.4 / interval)) + 0.5)
    force = np.interp(t, [0.2 - 0.5 * duration, 0.2, 0.2 + 0.5 * duration], [0.0, 1.0, 0.0], 0.0, 0.0)
    largest = moving_mean(force, interval, 0.05).max()
    assert solver.triangle_mean(1.0, duration, 0.05) == pytest.approx(largest, rel=1e-6)


def test_largest_means_are_those_of_all_columns():
    impact_case = case(IMPACT)
    random = np.random.default_rng(3)
    inputs = {
        item.key: item.lower + (item.upper - item.lower) * random.random(16)
        for item in planar_ranges.impact_ranges(impact_case)
    }
    means = impact_case.largest_means(inputs)[strike_columns.LARGEST]
    assert means == pytest.approx(impact_case.many(inputs)[strike_columns.LARGEST], rel=1e-12)


def test_percentiles_are_those_of_single_solutions(bands):
    """Of the constrained corner, by one call for each sample."""
    truck_case, band = case(TRUCK), bands[TRUCK]
    drawn = sampling.latin_hypercube(len(band.ranges), 256, np.random.default_rng(sampling.SEED))
    inputs = [
        low + (high - low) * row for (low, high, _), row in zip(band.ranges.values(), drawn, strict=True)
    ]
    forces = [
        truck_case.varied(dict(zip(band.ranges, values, strict=True))).force.peak_force
        for values in np.transpose(inputs).tolist()
    ]
    assert band.percentiles == pytest.approx(np.percentile(forces, (5, 50, 95)), rel=1e-12)


@pytest.mark.parametrize("name", [TRUCK, IMPACT])
def test_a_band_agrees_with_the_study(bands, name):
    """It is that of 1024 other samples.

    The error of percentiles of 256 samples is about a tenth of the band.
    """
    band_case = case(name)
    ranges = (planar_ranges.impact_ranges if band_case.scene.contact else planar_ranges.corner_ranges)(
        band_case
    )
    a, _ = sampling.sobol_points(ranges, 1024)
    column = "peaks.mean_50ms" if band_case.scene.contact else "peak_force"
    inputs = dict(zip((item.key for item in ranges), a, strict=True))
    lower, middle, upper = np.percentile(band_case.many(inputs)[column], (5, 50, 95))
    assert bands[name].percentiles == pytest.approx((lower, middle, upper), abs=0.1 * (upper - lower))


@pytest.mark.parametrize(("name", "change", "key"), [
    (TRUCK, "impact.restitution=0.95", "impact.restitution"),
    (IMPACT, "contact.restitution=0.6", "contact.restitution"),
])  # fmt: skip
def test_a_value_outside_its_range_is_not_varied(name, change, key):
    """The band contains the force of the scene."""
    band_case = case(name, change)
    band = band_samples.force_band(band_case)
    assert key in band.fixed
    assert key not in band.ranges
    assert f"`{key}`" in band.sentence.partition("not varied, since outside the range: ")[2]
    force = band_case.answer.peaks["mean_50ms"] if band_case.scene.contact else band_case.force.peak_force
    assert band.percentiles[0] < force < band.percentiles[2]


def test_fractions_have_their_bounds_by_the_number_of_samples():
    """Bounds are one-sided for none and all, and two-sided between.

    The latter are those of 5 of 10 by Clopper and Pearson (1934).
    """
    all_upright = ForceBand((1.0, 2.0, 3.0), 72, outcomes={"upright": 1.0, "on its side": 0.0}).sentence
    assert 0.959 < 0.05 ** (1.0 / 72.0) < 0.960
    assert "at least 95.9 % upright, at most 4.1 % on its side (95 % confidence" in all_upright
    half = ForceBand((1.0, 2.0, 3.0), 10, outcomes={"upright": 0.5, "on its side": 0.5}).sentence
    assert "50 % (18 to 82 %) upright" in half


def test_a_calibrated_band_has_its_distance_from_the_median_in_logarithms_times_the_factor():
    """A factor of 2 changes half to a quarter, 2.5 to 6.25."""
    band = ForceBand((2e5, 4e5, 1e6), 72, calibration=Calibration("TL-4", 11, 6, 0.7, 1.5, 2.0, 10, 5))
    assert band.limits == pytest.approx((1e5, 4e5, 2.5e6), rel=1e-12)
    words = "median 400 kN; 90 % band, calibrated on 11 published values of 6 studies: 100 to 2500 kN"
    assert SI.rendered(band.interval) == words
    assert "10 of 11 values and all values of 5 of 6 studies" in band.sentence
    assert (band.numbers()["percentile_95"], band.numbers()["upper"]) == pytest.approx((1e6, 2.5e6))


def test_a_band_of_too_few_published_values_is_that_of_the_inputs():
    band = ForceBand((2e5, 4e5, 1e6), 72, calibration=Calibration("TL-3", 4, 2, 0.7, 1.1))
    assert band.limits == pytest.approx(band.percentiles, rel=1e-15)
    assert "90 % of the inputs alone: 200 to 1000 kN" in SI.rendered(band.interval)
    assert (
        "inputs alone, not calibrated; published over predicted 0.7 to 1.1 in 4 rows of TL-3" in band.sentence
    )


def test_the_first_screen_has_band_origin_and_outcomes(bands):
    for name, band in bands.items():
        lower, middle, upper = band.percentiles
        assert 0.0 < lower < middle < upper
        headline = case(name).headline(band).in_units(SI)
        assert (
            f"median {middle / 1e3:.0f} kN; 90 % of the inputs alone: {lower / 1e3:.0f} to {upper / 1e3:.0f} kN"
            in headline.answer
        )
        assert headline.band == SI.rendered(band.sentence)
        assert headline.lines[1] == headline.band
        assert case(name).headline(band).band.startswith(band.decision)
        assert band.decisive[0] in band.decision
    assert sum(bands[SPACE].outcomes.values()) == pytest.approx(1.0, abs=1e-12)
    assert f"{100.0 * bands[SPACE].outcomes['upright']:.0f} %" in bands[SPACE].sentence
    assert not bands[IMPACT].outcomes


def test_what_decides_is_named_with_its_range(bands):
    words = [*map(SI.rendered, bands[IMPACT].decisive)]
    assert sorted(words)[:2] == [
        "the plateau of the crush, assumed 200 to 500 kN", "the restitution, assumed 0.1 to 0.35"
    ]  # fmt: skip
    assert bands[SPACE].decisive[0] == "the plateau of the crush, assumed 0.57 to 1.4 times that of the scene"
    two = ForceBand((1.0, 2.0, 3.0), 9, {"a": 0.5, "b": 0.2}, decisive=("x, 1 to 2", "y, assumed 3 to 4"))
    assert two.decision == "Decided most by x, 1 to 2 (50 %), and y, assumed 3 to 4 (20 % of the variance). "
    assert not NO_BAND.decision


def test_the_growth_of_a_constrained_corner_is_that_of_its_speed(bands):
    """Its force is in proportion to the speed, 75 over 45 mph."""
    assert (bands[TRUCK].speeds, bands[TRUCK].growth) == (
        ("45", "75 mph"),
        pytest.approx(75.0 / 45.0, rel=1e-9),
    )
    started = band_samples.force_band(case("paper-table-3"))
    assert (started.speeds, started.growth) == ((), 0.0)


def test_the_growth_is_that_of_many_vehicles(bands):
    """Of 512 others at both speeds, geometric mean within 6 %."""
    impact_case = case(IMPACT)
    ranges = planar_ranges.impact_ranges(impact_case)
    points, _ = sampling.sobol_points(ranges, 512)
    inputs = dict(zip((item.key for item in ranges), points, strict=True))
    slow, fast = (
        impact_case.largest_means(inputs | {"impact.speed": np.full(512, mph * 0.44704)})[
            strike_columns.LARGEST
        ]
        for mph in (45.0, 75.0)
    )
    assert bands[IMPACT].growth == pytest.approx(np.exp(np.log(fast / slow).mean()), rel=0.06)


def test_results_contain_the_band(bands):
    summary = tailslap.rigid(IMPACT).summary
    assert summary["force_band"]["percentile_95"] == bands[IMPACT].percentiles[2]
    without = tailslap.rigid(IMPACT, band=False).summary
    assert "percentile_95" not in without["force_band"]
    assert without["band"] == "Without a band of the force: not requested."


TEXTS = """
import json, sys
from pathlib import Path
from tailslap.case import force_band
force_band.PERCENTILES = (2.5, 50, 97.5)
import tailslap
from tailslap.validation import validation_report
out = [tailslap.rigid("mash-tl4-sut"), tailslap.rigid("impact-mash-tl4-sut")]
out += [tailslap.study("uncertainty", name, samples=288) for name in ("mash-tl4-sut", "impact-mash-tl4-sut")]
out += [tailslap.study("tipping", "impact-tipping-tl4-sut", samples=128)]
pages = [path.read_text() for number, result in enumerate(out) for path in
         Path(result.save(f"r{number}")).glob("*") if path.suffix in (".json", ".html", ".csv")]
print(json.dumps([*map(str, out), *(result.text for result in out), *pages, str(validation_report.SHORT)]))
"""


@pytest.mark.long
def test_keys_and_texts_follow_from_the_percentiles(python, tmp_path):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    texts = json.loads(python(TEXTS, check=True, cwd=tmp_path, env=environment).stdout)
    everything = " ".join(texts).replace("\N{NO-BREAK SPACE}", " ")
    for old in ('percentile_5"', "percentile_95", "90 % of", "90 % band"):
        assert old not in everything
    for new in (
        "percentile_2.5",
        "percentile_97.5",
        "95 % of the inputs alone",
        "95 % of the samples",
        "97.5 %",
    ):
        assert new in everything


@pytest.mark.parametrize(("name", "changes", "key"), [
    (IMPACT, ("contact=", "contact.friction=0.3"), "contact.stiffness"),
])  # fmt: skip
def test_a_band_that_cannot_be_computed_is_named(name, changes, key):
    band = band_samples.force_band(case(name, *changes))
    assert not band.percentiles
    assert key in band.refusal
    assert band.sentence.startswith("Without a band of the force: ")
    assert not band.interval


@pytest.mark.parametrize("rear", [5.26, 5.3])
def test_vehicles_without_equilibrium_are_counted_and_named(rear):
    """Loads follow from moments about the rear axle."""
    band = band_samples.force_band(case(SPACE, f"axle.1.position={rear}"))
    drawn = sampling.latin_hypercube(len(band.ranges), 72, np.random.default_rng(sampling.SEED))
    values = {
        key: low + (high - low) * column
        for (key, (low, high, _)), column in zip(band.ranges.items(), drawn, strict=True)
    }
    load = values["vehicle.mass"] * (rear - values["vehicle.centre_of_mass"]) / (rear - 1.2)
    standing = np.count_nonzero(load >= 400.0)  # its own mass
    assert (band.samples, band.unsolved) == (standing, 72 - standing)
    assert sum(band.outcomes.values()) == pytest.approx(1.0, abs=1e-12)
    assert f"{band.unsolved} further vehicles omitted" in band.sentence
    assert "`axle.0.position`: the axles cannot carry the vehicle" in band.sentence


def test_the_work_of_a_band_is_bounded(monkeypatch):
    """Steep unloading requires more steps than a sample may have."""
    seconds, compile_once = [], trajectories.compile_once

    def counted(*arguments, **options):
        clock = arguments[6]
        seconds.append(clock.most * len(clock.step) * trajectories.STEP_COST)
        return compile_once(*arguments, **options)

    monkeypatch.setattr(trajectories, "compile_once", counted)
    monkeypatch.setattr(trajectories, "LONGEST_RUN", 0.25 * trajectories.LONGEST_RUN)
    assert "leave an error" in band_samples.force_band(case(IMPACT, "contact.restitution=1e-4")).refusal
    assert 0.0 < sum(seconds) < 5.0 * trajectories.LONGEST_RUN


def test_a_band_of_too_few_vehicles_is_refused(monkeypatch):
    monkeypatch.setattr(sampling, "MIN_ROWS", 60)
    band = band_samples.force_band(case(SPACE, "axle.1.position=5.3"))
    assert band.refusal.startswith(f"{band_samples.TOO_FEW}; `axle.0.position`")


def test_a_band_of_fewer_vehicles_than_those_at_two_speeds():
    band = band_samples.force_band(case(SPACE, "vehicle.centre_of_mass=6.955", "body.centre_height=0.8668"))
    assert (band.samples, band.samples + band.unsolved) == (17, band_samples.SAMPLES_OF_SLOW)
    assert band.growth > 1.0


def test_a_band_of_vehicles_that_oscillate_too_fast_is_refused():
    band = band_samples.force_band(case(SPACE, "axle.0.spring=1e14"))
    assert "too fast to be followed" in band.refusal
    with pytest.raises(tailslap.InputError, match="too fast to be followed") as caught:
        _ = case(SPACE, "axle.0.spring=1e14").space
    assert caught.value.key == "axle"


def test_no_ratio_to_loads_of_lighter_vehicles():
    """A 50 ms mean stands over MASH's load of TL-4 alone.

    TL-1 has loads of Report 350 alone.
    """
    assert "times" not in case("impact-mash-tl1-car").headline(NO_BAND).answer
    truck = case(TRUCK)
    mean = solver.triangle_mean(float(truck.force.peak_force), truck.scene.strike.duration, 0.05)
    assert f", {mean / 355_858:.2g} times MASH (TTI), TL-4" in truck.headline().answer


def test_a_pull_of_the_wall_is_named():
    pulls = case(TRUCK).headline().in_units(SI).certainty
    reaction = case(TRUCK).rigid_history()["reaction_normal"]
    assert f"first with {-reaction[0] / 1e3:.3g} kN, at the end with {-reaction[-1] / 1e3:.3g} kN" in pulls
