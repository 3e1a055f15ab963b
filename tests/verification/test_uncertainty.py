"""Verify the study `uncertainty` by closed forms and SciPy's estimators.

With all else held, the peak force is g (1 - e)/dt: v_GY is in proportion to 1 - e by Eqs 24 and 31, and Eq 73
divides by dt. For X = 1 - e and Y = 1/dt, uniform e and dt, all moments are elementary.
"""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from shared_cases import LINEAR_TRUCK

from postprocess.report.provenance import CRATE
from postprocess.units import SI
from tailslap import cli, errors, studies
from tailslap.campaign import planar_ranges, sampling
from tailslap.campaign.input_ranges import Range
from tailslap.campaign.sampling import band_of, sampled
from tailslap.case.corner.corner_case import CornerCase
from tailslap.scene.read import read_scene
from tailslap.storage.manifest import NAME as MANIFEST
from tailslap.studies.uncertainty import uncertainty_study
from tailslap.studies.uncertainty.uncertainty_report import report

TRUCK = "mash-tl4-sut"
HELD = ("impact.friction", "impact.speed", "impact.angle")
E_LOW, E_HIGH, DT_LOW, DT_HIGH = 0.0, 0.4, 0.08, 0.18  # the default ranges
MPH, DEGREE, POUND = 1609.344 / 3600.0, math.pi / 180.0, 0.45359237


def plan_of(name, *changes):
    return CornerCase(*read_scene(name, changes))


def run(name, *ranges, fixed=(), samples=100_000):
    plan = plan_of(name)
    return uncertainty_study.spread(plan, planar_ranges.corner_ranges(plan, ranges, fixed), samples)


@pytest.fixture(scope="module")
def product():
    """Restitution and duration alone vary."""
    return run(TRUCK, fixed=HELD)


def by_key(ranges):
    return {item.key: item for item in ranges}


def indices(spread, name):
    """One of the indices of the peak force, an entry an input."""
    return np.array([row[name] for row in spread.sources["peak_force"]])


def moments():
    """E X, E X^2, E Y, E Y^2."""
    low, high = 1.0 - E_HIGH, 1.0 - E_LOW
    mean_y = math.log(DT_HIGH / DT_LOW) / (DT_HIGH - DT_LOW)
    return (low + high) / 2.0, (low * low + low * high + high * high) / 3.0, mean_y, 1.0 / (DT_LOW * DT_HIGH)


def factor(spread):
    """g [N s], from the scene's own force."""
    scene = spread.case.scene
    return spread.nominal["peak_force"] * scene.strike.duration / (1.0 - scene.impact.restitution)


def test_sobol_indices_of_a_product(product):
    """Compare with variances of a product in closed form.

    V = E X^2 E Y^2 - (E X E Y)^2; alone V_X = Var X (E Y)^2, in all Var X E Y^2; Y has the same form.
    """
    x, xx, y, yy = moments()
    variance, var_x, var_y = xx * yy - (x * y) ** 2, xx - x * x, yy - y * y
    first = np.array([var_x * y * y, var_y * x * x]) / variance
    total = np.array([var_x * yy, var_y * xx]) / variance
    assert [item.key for item in product.ranges] == ["impact.restitution", "strike.duration"]
    for name, exact in (("first_order", first), ("total", total)):
        assert indices(product, name) == pytest.approx(exact, abs=3e-4)
        low, high = indices(product, f"{name}_interval").T
        assert np.all((low < exact) & (exact < high))


def test_distribution_of_a_product(product):
    x, xx, y, yy = moments()
    g, band = factor(product), product.band("peak_force")
    assert band.mean == pytest.approx(g * x * y, rel=1e-6)
    assert band.standard_deviation == pytest.approx(g * math.sqrt(xx * yy - (x * y) ** 2), rel=1e-4)
    for fraction, force in zip((0.05, 0.5, 0.95), band.percentiles, strict=True):
        assert below(force / g) == pytest.approx(fraction, abs=4e-4)  # 2e-3 for random points
    histogram = report(product).summary["peak_force"]["histogram"]
    fractions = np.array([below(edge / g) for edge in histogram["edges"]])
    assert histogram["counts"] / histogram["counts"].sum() == pytest.approx(np.diff(fractions), abs=4e-4)


def below(ratio):
    """P(X/dt <= ratio), averaged over X by the midpoint rule."""
    x = 1.0 - E_HIGH + (E_HIGH - E_LOW) * (np.arange(20_000) + 0.5) / 20_000
    return float(np.clip((DT_HIGH - x / ratio) / (DT_HIGH - DT_LOW), 0.0, 1.0).mean())


def test_one_input_has_all_the_variance_and_a_uniform_force():
    """Restitution alone has a uniform force and an index of 1."""
    spread = run(TRUCK, fixed=(*HELD, "strike.duration"))
    top = factor(spread) / spread.case.scene.strike.duration
    expected = [top * (1.0 - E_HIGH + share * (E_HIGH - E_LOW)) for share in (0.05, 0.5, 0.95)]
    assert spread.band("peak_force").percentiles == pytest.approx(expected, rel=1e-4)
    deviation = spread.band("peak_force").standard_deviation
    assert deviation == pytest.approx(top * 0.4 / math.sqrt(12.0), rel=1e-5)
    assert (*indices(spread, "first_order"), *indices(spread, "total")) == pytest.approx((1.0, 1.0), abs=1e-3)


@pytest.mark.parametrize("name", [TRUCK, LINEAR_TRUCK])
def test_refused_indices_are_said_and_not_shown(name, monkeypatch, tmp_path, capsys):
    """Page, summary and terminal report it for similar points."""
    points_of = sampling.sobol_points

    def near(ranges, rows):
        a, b = points_of(ranges, rows)
        return a, a + 0.1 * (b - a)

    monkeypatch.setattr(sampling, "sobol_points", near)
    assert (
        cli._status(["study", "uncertainty", name, "--samples", "288", "--out", str(tmp_path / "out")]) == 0
    )
    terminal = " ".join(capsys.readouterr().out.split())
    page = (tmp_path / "out" / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    for text in (terminal, page):
        assert "Sobol indices are not determined: the sum of the total indices is 0.0" in text
        assert "Largest part of the variance" not in text
        assert "total Sobol index" not in text
    part = summary if name == TRUCK else summary["bands"]["strike_2.mean_50ms"]
    assert part["indices_refused"].startswith("Sobol indices are not determined")
    assert not part.get("indices")
    assert not any("total" in row for row in summary["inputs"])
    assert not (tmp_path / "out" / "sensitivity.svg").exists()


PLANS = [
    (TRUCK, (), ()),
    ("mash-tl3-pickup", ("vehicle.length=5 m:7 m", "vehicle.width=1.8 m:2.2 m"), ()),
    ("paper-table-3", ("start.angle=10 deg:20 deg", "start.omega=0.5:0.9"), ()),
    ("paper-abaqus", ("start.corner_speed=20:30",), ()),
    (TRUCK, ("corner.friction=0:1.2",), ()),
    (TRUCK, ("corner.friction=0:0.5",), ("corner.reaction=signed",)),
    (TRUCK, (), ("start.angle=0.2", "impact.convention=newton")),
]


@pytest.mark.parametrize(("name", "ranges", "changes"), PLANS)
def test_each_combination_is_the_plan_s_own_solution(name, ranges, changes):
    plan = CornerCase(*read_scene(name, changes))
    ranges = planar_ranges.corner_ranges(plan, ranges)
    keys = [*by_key(ranges)]
    inputs, tables = sampled(ranges, 10, plan.many)
    assert list(inputs) == keys
    columns = np.array([*inputs.values()]).T[:64].tolist()
    for column, force in zip(columns, tables["peak_force"].ravel(), strict=False):
        changed = plan.varied(dict(zip(keys, column, strict=True)))
        assert changed.force.peak_force == pytest.approx(force, rel=1e-12)


def test_mixtures_take_one_input_from_the_second_table():
    ranges = planar_ranges.corner_ranges(plan_of(TRUCK))
    inputs, tables = sampled(ranges, 100, lambda columns: {"sum": sum(columns.values(), np.zeros(()))})
    keys, values = list(inputs), np.array([*inputs.values()]).reshape(len(ranges), len(ranges) + 2, -1)
    a, b, *mixed = np.moveaxis(values, 1, 0)
    for i in range(len(keys)):
        assert np.array_equal(mixed[i][i], b[i])
        assert np.array_equal(np.delete(mixed[i], i, 0), np.delete(a, i, 0))
        assert np.array_equal(tables["sum"][i + 2], sum(mixed[i]))
    assert tables["sum"].size >= 100


def test_what_the_theory_refuses_is_counted_and_said(tmp_path, capsys):
    """Half of the range of friction does not rotate the vehicle."""
    phi = math.radians(15.0) + math.atan2(2.438, 10.0)
    limit, out = 1.0 / math.tan(phi), tmp_path / "out"
    arguments = ["--fix", "impact.angle", "--range", f"impact.friction=0:{2.0 * limit}", "--samples", "20000"]
    assert cli._status(["study", "uncertainty", TRUCK, *arguments, "--out", str(out)]) == 0
    summary = json.loads((out / "summary.json").read_text())
    with (out / "samples.csv").open() as file:
        rows = list(csv.DictReader(file))
    refused = [row for row in rows if row["peak_force"] == ""]
    assert len(rows) == 2 * summary["rows"]
    assert all((float(row["impact.friction"]) >= limit) == (row in refused) for row in rows[:500])
    assert len(refused) / len(rows) == pytest.approx(0.5, abs=1e-3)
    assert summary["refused"] / summary["combinations"] == pytest.approx(0.5, abs=1e-3)
    omitted = summary["rows_left_out"] / summary["rows"]
    assert omitted == pytest.approx(0.75, abs=5e-3)  # in A, in B or in both
    assert "impact.friction: given" in summary["first_refusal"]
    assert sum(summary["peak_force"]["histogram"]["counts"]) == len(rows) - len(refused)
    terminal, page = (
        capsys.readouterr().out,
        (out / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " "),
    )
    for text in (terminal, page):
        assert "(50 %) have no solution" in " ".join(text.split())
    assert "does not rotate the side of the vehicle" in page


def test_a_study_of_which_nothing_is_left_is_refused(tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["study", "uncertainty", TRUCK, "--range", "impact.friction=2.5:3", "--out", str(out)]
    assert cli._status(arguments) == 2
    assert (
        "too few samples have a solution; first reason: impact.friction: given 2." in capsys.readouterr().err
    )
    assert not out.exists()


@pytest.mark.parametrize(
    "command", [f"study uncertainty {LINEAR_TRUCK}", f"study uncertainty {TRUCK}", "validate"]
)
def test_interrupted_it_says_that_no_progress_is_saved(command, tmp_path, monkeypatch, capsys):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(sampling, "sobol_points", interrupted)
    assert cli._status([*command.split(), "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err.endswith(f"tailslap: {cli.UNDONE}\n")
    assert not (tmp_path / "out").exists()


def test_the_same_call_gives_the_same_files(tmp_path):
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder in folders:
        arguments = ["mash-tl3-car", "--samples", "2000", "--out", str(folder)]
        assert cli._status(["study", "uncertainty", *arguments]) == 0
        files = {
            "report.html",
            "samples.csv",
            "summary.json",
            "histogram.svg",
            "sensitivity.svg",
            MANIFEST,
            CRATE,
        }
        assert {path.name for path in folder.iterdir()} == files | {"set-up.svg"}
    assert len({(folder / "samples.csv").read_bytes() for folder in folders}) == 1
    assert len({(folder / "report.html").read_text().partition("<footer>")[0] for folder in folders}) == 1
    one, two = (json.loads((folder / "summary.json").read_text()) | {"cost": None} for folder in folders)
    assert (one, one["seed"]) == (two, 307)
    page = (tmp_path / "one" / "report.html").read_text()
    assert "seed 307" in page
    assert page.count("<svg") - page.count("<template>") == 3
    assert "http" not in page.replace("http://www.w3.org", "").replace("http-equiv", "")


def test_default_ranges():
    """MASH has tolerances of speed, angle and mass.

    2.5 mph, 1.5 deg, 110 lb for the pickup, 55 lb for the car.
    """
    ranges = by_key(planar_ranges.corner_ranges(plan_of("mash-tl3-pickup")))
    expected = {"vehicle.mass": (4890 * POUND, 5110 * POUND), "impact.speed": (59.5 * MPH, 64.5 * MPH)}
    expected |= {"impact.angle": (23.5 * DEGREE, 26.5 * DEGREE), "impact.friction": (0.3, 0.6)}
    expected |= {"impact.restitution": (0.0, 0.4), "strike.duration": (0.08, 0.18)}
    assert set(ranges) == set(expected)
    for key, ends in expected.items():
        assert (ranges[key].lower, ranges[key].upper) == pytest.approx(ends, rel=1e-12)
    mass = by_key(planar_ranges.corner_ranges(plan_of("mash-tl1-car")))["vehicle.mass"]
    assert (mass.lower / POUND, mass.upper / POUND) == pytest.approx((2365, 2475), rel=1e-12)
    assert "vehicle.mass" not in by_key(planar_ranges.corner_ranges(plan_of(TRUCK)))


def test_only_what_the_force_depends_on_varies():
    """[start] overrides Stage 1, and a frictionless corner its coefficient."""
    cases = ("paper-table-3", ["impact.friction", "strike.duration"]), ("paper-abaqus", ["strike.duration"])
    for scene, keys in cases:
        assert [*by_key(planar_ranges.corner_ranges(plan_of(scene)))] == keys


def test_given_ranges_take_units_and_replace_the_default():
    texts = ("impact.speed=50 mph:60 mph", "vehicle.length=30 ft:10 m", "impact.friction=0.2:0.5")
    ranges = by_key(planar_ranges.corner_ranges(plan_of(TRUCK), texts, ("impact.angle",)))
    for key, ends in (("impact.speed", (50 * MPH, 60 * MPH)), ("vehicle.length", (9.144, 10.0))):
        assert (ranges[key].lower, ranges[key].upper) == pytest.approx(ends)
    assert ranges["impact.friction"] == Range("impact.friction", 0.2, 0.5, "", 0.47, "--range")
    assert "impact.angle" not in ranges


WRONG = [
    (("impact.friction=-0.1:0.5",), (), "impact.friction", "from 0 to"),
    (("impact.restitution=0.2:1.1",), (), "impact.restitution", "from 0 to 1"),
    (("impact.speed=20 kg:30 kg",), (), "impact.speed", "the unit does not fit"),
    (("impact.speed=20:nan",), (), "impact.speed", "a speed from 1e-06 m/s"),
    (("impact.friction=0.5:0.2",), (), "impact.friction", "must exceed"),
    (("impact.friction=0.2:0.2",), (), "impact.friction", "must exceed"),
    (("impact.friction=0.2",), (), "--range", "KEY=LOWER:UPPER"),
    (("impact.friction",), (), "--range", "KEY=LOWER:UPPER"),
    (
        ("plate.thickness=1:2",),
        (),
        "plate.thickness",
        "is independent of this key; allowed are vehicle.length",
    ),
    (("corner.reaction=drag:none",), (), "corner.reaction", "is independent of this key"),
    (("colour=1:2",), (), "colour", "is independent of this key"),
    ((), ("vehicle.mass",), "--fix", "this key does not vary; allowed are"),
    ((), (*HELD, "strike.duration", "impact.restitution"), "--fix", "at least one key must vary"),
]


@pytest.mark.parametrize(("ranges", "fixed", "key", "message"), WRONG)
def test_wrong_ranges_are_told_which_key(ranges, fixed, key, message):
    with pytest.raises(errors.InputError) as caught:
        planar_ranges.corner_ranges(plan_of(TRUCK), ranges, fixed)
    assert caught.value.key == key
    assert message in caught.value.allowed


def test_a_default_range_that_does_not_fit_says_whose_it_is():
    message = r"impact\.angle: given .* by default .*1\.5 deg, MASH.*--range changes"
    with pytest.raises(errors.InputError, match=message):
        planar_ranges.corner_ranges(plan_of(TRUCK, "impact.angle=1 deg"))


def test_a_force_that_does_not_change_has_no_indices():
    """[start] overrides Stage 1, so the speed has no effect."""
    plan = CornerCase(*read_scene("paper-abaqus"))
    with pytest.raises(errors.InputError, match="constant within these ranges"):
        uncertainty_study.spread(plan, (Range("impact.speed", 20.0, 30.0, "m/s", 25.0, "test"),), 100)


def test_bands_by_hand():
    small = band_of(np.array([1.0, 2.0, 3.0, 4.0, 5.0, np.nan]))
    assert (small.mean, small.percentiles[1]) == (3.0, 3.0)
    assert small.standard_deviation == pytest.approx(math.sqrt(2.5), rel=1e-15)
    assert (small.percentiles[0], small.percentiles[2]) == pytest.approx((1.2, 4.8), rel=1e-15)
    assert small.fraction_below(3.0) == 0.4
    large = band_of(np.append(np.arange(101.0), np.nan))
    assert large.percentiles == (5.0, 50.0, 95.0)
    assert large.standard_deviation == pytest.approx(math.sqrt(101.0 * 102.0 / 12.0), rel=1e-12)
    table = band_of(np.array([[1.0, np.nan], [2.0, 3.0], [9.0, 9.0]]))
    assert table.values.tolist() == [1.0, 2.0, 3.0], "mixtures are not of the distribution"


def test_an_unknown_study_lists_the_known_ones(capsys):
    assert cli._status(["study", "certainty", TRUCK]) == 2
    message = capsys.readouterr().err
    assert 'NAME: given "certainty"' in message
    assert all(name in message for name in studies.study_names())
    assert cli._status(["study", "uncertainty", "nowhere"]) == 2
    assert cli._status(["study", "uncertainty", TRUCK, "--samples", "10"]) == 2


def test_what_is_held_and_how_the_scene_s_own_force_compares():
    complete = run(TRUCK, samples=25_000)
    study_report = report(complete)
    assert study_report.summary["held"] == ("vehicle.length", "vehicle.width", "vehicle.mass")
    below_own = np.mean(complete.samples["peak_force"] < complete.case.force.peak_force)
    assert f"exceeds {100.0 * below_own:.0f} % of the samples" in study_report.page.headline.answer
    tables = {"peak_force": np.where(np.arange(complete.rows) < 0, 0.0, complete.tables["peak_force"])}
    tables["peak_force"][0] = np.nan
    summary = report(replace(complete, tables=tables)).summary
    assert summary["rows_left_out"] == summary["refused"] == complete.rows


def test_ranges_have_four_digits_and_no_powers_of_ten():
    large = Range("vehicle.yaw_inertia", 70480.9, 105721.4, "kg m^2", 88101.1, "assumed")
    assert [SI.rendered(text) for text in large.in_words()] == ["70480 to 105700 kg m^2", "88100 kg m^2"]
    stiff = Range("contact.stiffness", 1e6, 3e6, "N/m", None, "assumed")
    assert [SI.rendered(text) for text in stiff.in_words()] == ["1 to 3 MN/m", "–"]
