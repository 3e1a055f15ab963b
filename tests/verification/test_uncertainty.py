"""Verification: the study `uncertainty` against closed forms, SciPy's estimators and single solutions.

With all else held, the peak force is g (1 - e)/dt: v_GY is in proportion to 1 - e by Eqs 24 and 31, and Eq 73
divides by dt. For X = 1 - e and Y = 1/dt, uniform e and dt, all moments are elementary.
"""

from __future__ import annotations

import csv
import json
import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from tailslap.case.corner.case import CornerCase
from tailslap.command_line import _status
from tailslap.errors import InputError
from tailslap.files.manifest import NAME as MANIFEST
from tailslap.scene.read import read_scene
from tailslap.studies import study_names
from tailslap.studies.uncertainty.indices import sobol_indices
from tailslap.studies.uncertainty.model import peak_forces
from tailslap.studies.uncertainty.ranges import Range, study_ranges
from tailslap.studies.uncertainty.sampling import draw
from tailslap.studies.uncertainty.spread import Spread, describe, find_spread

pytestmark = pytest.mark.verification

TRUCK = "mash-tl4-sut"
HELD = ("impact.friction", "impact.speed", "impact.angle")
E_LOW, E_HIGH, DT_LOW, DT_HIGH = 0.0, 0.4, 0.08, 0.18  # the default ranges
MPH, DEGREE, POUND = 1609.344 / 3600.0, math.pi / 180.0, 0.45359237


def plan_of(name: str, *changes: str) -> CornerCase:
    return CornerCase(*read_scene(name, changes))


def run(name: str, *ranges: str, fixed: tuple[str, ...] = (), samples: int = 100_000) -> Spread:
    plan = plan_of(name)
    return find_spread(plan, study_ranges(plan, ranges, fixed), samples)


@pytest.fixture(scope="module")
def product() -> Spread:
    """Restitution and duration alone vary."""
    return run(TRUCK, fixed=HELD)


@pytest.fixture(scope="module")
def complete() -> Spread:
    """The default study."""
    return run(TRUCK)


def moments() -> tuple[float, float, float, float]:
    """E X, E X^2, E Y, E Y^2."""
    low, high = 1.0 - E_HIGH, 1.0 - E_LOW
    mean_y = math.log(DT_HIGH / DT_LOW) / (DT_HIGH - DT_LOW)
    return (low + high) / 2.0, (low * low + low * high + high * high) / 3.0, mean_y, 1.0 / (DT_LOW * DT_HIGH)


def factor(spread: Spread) -> float:
    """g [N s], from the scene's own force."""
    impact = spread.plan.scene.impact
    assert impact is not None
    return spread.plan.force.peak_force * spread.plan.scene.strike.duration / (1.0 - impact.restitution)


def test_sobol_indices_of_a_product(product: Spread) -> None:
    """V = E X^2 E Y^2 - (E X E Y)^2; alone, V_X = Var X (E Y)^2; in all, V_X = Var X E Y^2; and so for Y."""
    x, xx, y, yy = moments()
    variance, var_x, var_y = xx * yy - (x * y) ** 2, xx - x * x, yy - y * y
    first = np.array([var_x * y * y, var_y * x * x]) / variance
    total = np.array([var_x * yy, var_y * xx]) / variance
    assert [item.key for item in product.samples.ranges] == ["impact.restitution", "strike.duration"]
    found = product.indices
    assert found.first == pytest.approx(first, abs=3e-4)
    assert found.total == pytest.approx(total, abs=3e-4)
    for exact, (low, high) in ((first, found.first_interval), (total, found.total_interval)):
        assert np.all((low < exact) & (exact < high))


def test_distribution_of_a_product(product: Spread) -> None:
    x, xx, y, yy = moments()
    g, found = factor(product), product.distribution
    assert found.mean == pytest.approx(g * x * y, rel=1e-6)
    assert found.standard_deviation == pytest.approx(g * math.sqrt(xx * yy - (x * y) ** 2), rel=1e-4)
    for share, force in zip((0.05, 0.5, 0.95), found.percentiles, strict=True):
        assert below(force / g) == pytest.approx(share, abs=4e-4)  # 2e-3 for random points
    shares = np.array([below(edge / g) for edge in found.edges])
    assert found.counts / found.counts.sum() == pytest.approx(np.diff(shares), abs=4e-4)


def below(ratio: float) -> float:
    """P(X/dt <= ratio) = E of the share of the durations above X/ratio, by the midpoint rule over X."""
    x = 1.0 - E_HIGH + (E_HIGH - E_LOW) * (np.arange(20_000) + 0.5) / 20_000
    return float(np.clip((DT_HIGH - x / ratio) / (DT_HIGH - DT_LOW), 0.0, 1.0).mean())


def test_one_input_has_all_the_variance_and_a_uniform_force() -> None:
    """Restitution alone: F = g (1 - e)/dt is uniform, and its index is 1."""
    spread = run(TRUCK, fixed=(*HELD, "strike.duration"))
    top = factor(spread) / spread.plan.scene.strike.duration
    expected = [top * (1.0 - E_HIGH + share * (E_HIGH - E_LOW)) for share in (0.05, 0.5, 0.95)]
    assert spread.distribution.percentiles == pytest.approx(expected, rel=1e-4)
    assert spread.distribution.standard_deviation == pytest.approx(top * 0.4 / math.sqrt(12.0), rel=1e-5)
    assert (*spread.indices.first, *spread.indices.total) == pytest.approx((1.0, 1.0), abs=1e-3)


def test_indices_lie_between_zero_and_one_and_alone_below_in_all(complete: Spread) -> None:
    first, total = complete.indices.first, complete.indices.total
    assert np.all((first > 0.0) & (first < total) & (total < 1.0))
    assert first.sum() < 1.0 < total.sum()
    shown = dict(zip((item.key for item in complete.samples.ranges), total, strict=True))
    assert max(shown, key=lambda key: shown[key]) == "strike.duration"


def ishigami(rows: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """f(A), f(B), f(AB) of sin x + 7 sin^2 y + 0.1 z^4 sin x on (-pi, pi)^3."""
    points = math.pi * (2.0 * stats.qmc.Sobol(6, seed=np.random.default_rng(1)).random(rows).T - 1.0)
    a, b = points[:3], points[3:]
    tables = [a, b, *(np.where(np.arange(3)[:, None] == i, b, a) for i in range(3))]
    forces = [np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x) for x, y, z in tables]
    return forces[0], forces[1], np.array(forces[2:])


def test_estimators_are_scipys_and_give_ishigamis_indices() -> None:
    """Exact: V = V_1 + V_2 + V_13, V_1 = (1 + 0.1 pi^4/5)^2/2, V_2 = 7^2/8, V_13 = 0.1^2 pi^8 8/225."""
    f_a, f_b, f_ab = ishigami(2**14)
    found = sobol_indices(f_a, f_b, f_ab, seed=1)
    reference = stats.sobol_indices(func={"f_A": f_a[None], "f_B": f_b[None], "f_AB": f_ab[:, None]}, n=2**14)
    assert found.first == pytest.approx(reference.first_order, abs=1e-12)
    assert found.total == pytest.approx(reference.total_order, abs=1e-12)
    v_1, v_2, v_13 = (1 + 0.1 * math.pi**4 / 5) ** 2 / 2, 49 / 8, 0.01 * math.pi**8 * 8 / 225
    variance = v_1 + v_2 + v_13
    assert found.first == pytest.approx(np.array([v_1, v_2, 0.0]) / variance, abs=2e-3)
    assert found.total == pytest.approx(np.array([v_1 + v_13, v_2, v_13]) / variance, abs=2e-3)


def test_the_bootstrap_is_the_estimators_on_rows_drawn_with_replacement() -> None:
    f_a, f_b, f_ab = ishigami(256)
    mean = np.mean([f_a, f_b])
    f_a, f_b, f_ab = f_a - mean, f_b - mean, f_ab - mean
    random, drawn = np.random.default_rng(5), []
    for _ in range(500):
        rows = random.integers(0, 256, 256, dtype=np.int32)
        a, b, ab = f_a[rows], f_b[rows], f_ab[:, rows]
        variance = np.var([a, b])
        drawn.append([np.mean(b * (ab - a), axis=1), np.mean((a - ab) ** 2, axis=1) / 2.0] / variance)
    found = sobol_indices(f_a, f_b, f_ab, seed=5)
    for i, interval in enumerate((found.first_interval, found.total_interval)):
        assert interval == pytest.approx(np.percentile(drawn, [2.5, 97.5], axis=0)[:, i], abs=1e-12)


def test_the_bootstrap_s_intervals_are_those_of_random_rows() -> None:
    """For independent rows, half the 95 % interval is 1.96 standard deviations of the indices over repetitions."""
    random, found, half = np.random.default_rng(2), [], []
    for seed in range(60):
        x, y = random.uniform(0.5, 1.0, (2, 2, 512))
        result = sobol_indices(x[0] * y[0], x[1] * y[1], np.array([x[1] * y[0], x[0] * y[1]]), seed)
        found.append([*result.first, *result.total])
        intervals = np.hstack([result.first_interval, result.total_interval])
        half.append((intervals[1] - intervals[0]) / 2.0)
    assert np.mean(half, axis=0) == pytest.approx(1.96 * np.std(found, axis=0, ddof=1), rel=0.3)


@pytest.mark.parametrize(
    ("name", "ranges", "changes"),
    [
        (TRUCK, (), ()),
        ("mash-tl3-pickup", ("vehicle.length=5 m:7 m", "vehicle.width=1.8:2.2"), ()),
        ("paper-table-3", ("start.angle=10 deg:20 deg", "start.omega=0.5:0.9"), ()),
        ("paper-abaqus", ("start.corner_speed=20:30",), ()),
        (TRUCK, ("corner.friction=0:1.2",), ()),
        (TRUCK, ("corner.friction=0:0.5",), ("corner.reaction=signed",)),
        (TRUCK, (), ("start.angle=0.2", "impact.convention=newton")),
    ],
)
def test_each_combination_is_the_plan_s_own_solution(
    name: str, ranges: tuple[str, ...], changes: tuple[str, ...]
) -> None:
    plan = CornerCase(*read_scene(name, changes))
    samples = draw(plan.scene, study_ranges(plan, ranges, ()), 10)
    for table, forces in ((samples.a, samples.force_a), (samples.b, samples.force_b)):
        for column, force in zip(table.T.tolist(), forces, strict=True):
            values = {item.key: x for item, x in zip(samples.ranges, column, strict=True)}
            assert plan.varied(values).force.peak_force == pytest.approx(force, rel=1e-12)


def test_mixtures_take_one_input_from_the_second_table() -> None:
    plan = CornerCase(*read_scene(TRUCK))
    samples = draw(plan.scene, study_ranges(plan, (), ()), 100)
    keys = [item.key for item in samples.ranges]
    for i in range(len(keys)):
        inputs = {key: (samples.b if key == keys[i] else samples.a)[j] for j, key in enumerate(keys)}
        assert np.array_equal(samples.force_ab[i], peak_forces(plan.scene, inputs))
    assert samples.combinations == len(samples.force_a) * (len(keys) + 2) >= 100


def test_what_the_theory_refuses_is_counted_and_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Friction from cot(phi) on does not turn the vehicle; a range from 0 to twice that is refused by half."""
    phi = math.radians(15.0) + math.atan2(2.438, 10.0)
    limit, out = 1.0 / math.tan(phi), tmp_path / "out"
    arguments = ["--fix", "impact.angle", "--range", f"impact.friction=0:{2.0 * limit}", "--samples", "20000"]
    assert _status(["study", "uncertainty", TRUCK, *arguments, "--out", str(out)]) == 0
    summary = json.loads((out / "summary.json").read_text())
    with (out / "samples.csv").open() as file:
        rows = list(csv.DictReader(file))
    refused = [row for row in rows if row["peak_force"] == ""]
    assert len(rows) == 2 * summary["rows"]
    assert all((float(row["impact.friction"]) >= limit) == (row in refused) for row in rows[:500])
    assert len(refused) / len(rows) == pytest.approx(0.5, abs=1e-3)
    assert summary["refused"] / summary["combinations"] == pytest.approx(0.5, abs=1e-3)
    assert summary["rows_left_out"] / summary["rows"] == pytest.approx(
        0.75, abs=5e-3
    )  # in A, in B or in both
    assert "impact.friction: given" in summary["first_refusal"]
    assert sum(summary["peak_force"]["histogram"]["counts"]) == len(rows) - len(refused)
    said, page = capsys.readouterr().out, (out / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    for text in (said, page):
        assert "The theory refuses 50 % of the combinations" in text
    assert "wrong side of the centre of mass" in page


def test_a_study_of_which_nothing_is_left_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    arguments = ["study", "uncertainty", TRUCK, "--range", "impact.friction=2.5:3", "--out", str(out)]
    assert _status(arguments) == 2
    assert "refuses nearly all of them, like impact.friction: given 2." in capsys.readouterr().err
    assert not out.exists()


def test_the_same_call_gives_the_same_files(tmp_path: Path) -> None:
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder in folders:
        assert (
            _status(["study", "uncertainty", "mash-tl3-car", "--samples", "2000", "--out", str(folder)]) == 0
        )
        assert {path.name for path in folder.iterdir()} == {
            "report.html",
            "samples.csv",
            "summary.json",
            "histogram.svg",
            "sensitivity.svg",
            MANIFEST,
        }
    for name in ("report.html", "samples.csv"):
        assert len({(folder / name).read_bytes() for folder in folders}) == 1
    one, two = (json.loads((folder / "summary.json").read_text()) | {"cost": None} for folder in folders)
    assert one == two
    assert one["seed"] == 307
    assert "seed 307" in (tmp_path / "one" / "report.html").read_text()


def test_the_result_folder_has_the_scene_s_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert _status(["study", "uncertainty", TRUCK, "--samples", "1000"]) == 0
    assert [path.name for path in (tmp_path / "results").iterdir()] == [f"{TRUCK}-uncertainty"]
    page = (tmp_path / "results" / f"{TRUCK}-uncertainty" / "report.html").read_text()
    assert page.count("<svg") == 2
    assert "http" not in page.replace("http://www.w3.org", "").replace("http-equiv", "")


def test_default_ranges() -> None:
    """MASH: 2.5 mph, 1.5 deg; 110 lb for the pickup, 55 lb for the car; the truck's tolerance is not known."""
    found = {item.key: item for item in study_ranges(plan_of("mash-tl3-pickup"), (), ())}
    expected = {
        "vehicle.mass": (4890 * POUND, 5110 * POUND),
        "impact.speed": (59.5 * MPH, 64.5 * MPH),
        "impact.angle": (23.5 * DEGREE, 26.5 * DEGREE),
        "impact.friction": (0.3, 0.6),
        "impact.restitution": (0.0, 0.4),
        "strike.duration": (0.08, 0.18),
    }
    assert set(found) == set(expected)
    for key, ends in expected.items():
        assert (found[key].lower, found[key].upper) == pytest.approx(ends, rel=1e-12)
    (mass,) = (item for item in study_ranges(plan_of("mash-tl1-car"), (), ()) if item.key == "vehicle.mass")
    assert (mass.lower / POUND, mass.upper / POUND) == pytest.approx((2365, 2475), rel=1e-12)
    assert "vehicle.mass" not in {item.key for item in study_ranges(plan_of(TRUCK), (), ())}


def test_only_what_the_force_depends_on_varies() -> None:
    """[start] overrides Stage 1; without friction no coefficient counts."""
    assert [item.key for item in study_ranges(plan_of("paper-table-3"), (), ())] == [
        "impact.friction",
        "strike.duration",
    ]
    assert [item.key for item in study_ranges(plan_of("paper-abaqus"), (), ())] == ["strike.duration"]


def test_given_ranges_take_units_and_replace_the_default() -> None:
    given = ("impact.speed=50 mph:60 mph", "vehicle.length=30 ft:10 m", "impact.friction=0.2:0.5")
    found = {item.key: item for item in study_ranges(plan_of(TRUCK), given, ("impact.angle",))}
    assert (found["impact.speed"].lower, found["impact.speed"].upper) == pytest.approx((50 * MPH, 60 * MPH))
    assert (found["vehicle.length"].lower, found["vehicle.length"].upper) == pytest.approx((9.144, 10.0))
    friction = found["impact.friction"]
    assert friction == Range("impact.friction", 0.2, 0.5, "", 0.47, "--range")
    assert "impact.angle" not in found


@pytest.mark.parametrize(
    ("ranges", "fixed", "key", "message"),
    [
        (("impact.friction=-0.1:0.5",), (), "impact.friction", "from 0 to"),
        (("impact.restitution=0.2:1.1",), (), "impact.restitution", "from 0 to 1"),
        (("impact.speed=20 kg:30 kg",), (), "impact.speed", "the unit does not fit"),
        (("impact.speed=20:nan",), (), "impact.speed", "a speed from 1e-06 m/s"),
        (("impact.friction=0.5:0.2",), (), "impact.friction", "must be larger"),
        (("impact.friction=0.2:0.2",), (), "impact.friction", "must be larger"),
        (("impact.friction=0.2",), (), "--range", "KEY=LOWER:UPPER"),
        (("impact.friction",), (), "--range", "KEY=LOWER:UPPER"),
        (
            ("plate.thickness=1:2",),
            (),
            "plate.thickness",
            "does not depend on it; allowed are vehicle.length",
        ),
        (("corner.reaction=drag:none",), (), "corner.reaction", "does not depend on it"),
        (("colour=1:2",), (), "colour", "does not depend on it"),
        ((), ("vehicle.mass",), "--fix", "it does not vary; allowed are"),
        ((), (*HELD, "strike.duration", "impact.restitution"), "--fix", "nothing varies"),
    ],
)
def test_wrong_ranges_are_told_which_key(
    ranges: tuple[str, ...], fixed: tuple[str, ...], key: str, message: str
) -> None:
    with pytest.raises(InputError) as caught:
        study_ranges(plan_of(TRUCK), ranges, fixed)
    assert caught.value.key == key
    assert message in caught.value.allowed


def test_a_default_range_that_does_not_fit_says_whose_it_is() -> None:
    with pytest.raises(
        InputError, match=r"impact\.angle: given .* by default .*1\.5 deg, MASH.*--range gives"
    ):
        study_ranges(plan_of(TRUCK, "impact.angle=1 deg"), (), ())


def test_a_force_that_does_not_change_has_no_indices() -> None:
    """[start] gives the state after the impact, so that the speed, forced to vary here, has no effect."""
    plan = CornerCase(*read_scene("paper-abaqus"))
    with pytest.raises(InputError, match="the same all over"):
        find_spread(plan, (Range("impact.speed", 20.0, 30.0, "m/s", 25.0, "test"),), 100)


def test_describe_by_hand() -> None:
    found = describe(np.array([1.0, 2.0, 3.0, 4.0, 5.0]))
    assert (found.mean, found.percentiles[1]) == (3.0, 3.0)
    assert found.standard_deviation == pytest.approx(math.sqrt(2.5), rel=1e-15)
    assert (found.percentiles[0], found.percentiles[2]) == pytest.approx((1.2, 4.8), rel=1e-15)
    assert found.counts.sum() == 5


def test_a_hundred_thousand_combinations_in_two_seconds() -> None:
    plan = plan_of("mash-tl3-pickup")
    ranges = study_ranges(plan, (), ())
    began = time.process_time()
    spread = find_spread(plan, ranges, 100_000)
    assert time.process_time() - began < 2.0
    assert spread.samples.combinations >= 100_000


def test_more_rows_come_closer(complete: Spread) -> None:
    """A quarter of the combinations agrees with the whole within its own intervals."""
    fewer = run(TRUCK, samples=25_000)
    assert fewer.samples.force_a.size * 4 == complete.samples.force_a.size
    low, high = fewer.indices.first_interval
    assert np.all((low < complete.indices.first) & (complete.indices.first < high))


def test_an_unknown_study_lists_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert _status(["study", "certainty", TRUCK]) == 2
    message = capsys.readouterr().err
    assert 'NAME: given "certainty"' in message
    assert all(name in message for name in study_names())
    assert _status(["study", "uncertainty", "nowhere"]) == 2
    assert _status(["study", "uncertainty", TRUCK, "--samples", "10"]) == 2


def test_parts_of_the_record(complete: Spread) -> None:
    """What is held, and how the scene's own force compares."""
    assert complete.fixed == ("vehicle.length", "vehicle.width", "vehicle.mass")
    forces: Any = np.concatenate([complete.samples.force_a, complete.samples.force_b])
    assert complete.share_below == np.mean(forces < complete.plan.force.peak_force)
    nothing = replace(complete.samples, force_a=np.full_like(complete.samples.force_a, np.nan))
    assert nothing.rows_left_out == nothing.refused == len(nothing.force_a)
