"""Verify the study of roll over walls by exact fractions."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from postprocess.report.command_report import write_report
from postprocess.units import SI
from solver import space
from tailslap import cli
from tailslap.campaign import records, space_samples
from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError
from tailslap.scene.read import read_scene
from tailslap.studies.tipping import tipping_report, tipping_study
from tailslap.validation import outcomes
from tailslap.validation.tables import parameters

SCENE, INCH = "impact-tipping-tl4-sut", 0.0254
FREE = ("body.centre_height", "contact.friction", "axle.*.spring")
SMALL = {
    "POINTS": 3, "LINE_CENTRES": 2, "LINE_SAMPLES": 4, "LINE_WALLS": 1, "STEP": 40 * INCH, "WALLS": ()
}  # fmt: skip


def case(*changes):
    return ImpactCase(*read_scene(SCENE, changes))


def fixed(scene_case):
    """All inputs except FREE."""
    items = space_samples.space_ranges(scene_case, (), ())
    return tuple(item.key for item in items if item.key not in FREE)


def computed(scene_case, place, samples=128, ranges=(), **small):
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (SMALL | small).items():
            patch.setattr(tipping_study, name, value)
        patch.setattr(outcomes, "SAMPLES", 8)
        patch.setattr(space, "PROFILES", {name: space.PROFILES[name] for name in ("vertical", "f-shape")})
        return tipping_study.compute(scene_case, place, samples, ranges, fixed(scene_case), 1)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return computed(case(), tmp_path_factory.mktemp("study") / "out")


def by_height(source, inputs):
    """Upright on walls of the centre's height less 0.6 m.

    The force is 1 MN/m of the height of the wall.
    """
    count = max(np.size(values) for values in inputs.values())
    wall, centre, friction = (
        np.broadcast_to(inputs.get(key, default), count)
        for key, default in (
            ("wall.height", 36 * INCH),
            ("body.centre_height", 1.35),
            ("contact.friction", 0.35),
        )
    )
    outcome = np.where(wall >= centre - 0.6, 0.0, 2.0)
    answers = {"outcome": outcome, "largest_roll": 0.1 * centre, "mean_50ms": 1e6 * wall + 1e5 * friction}
    columns = {name: values.tolist() for name, values in answers.items()}
    others = dict.fromkeys(("height", "length", "moment", "moment_height"), wall.tolist())
    return columns | others | {"processor": 0.01}


@pytest.fixture
def exact(monkeypatch, tmp_path):
    monkeypatch.setattr(space_samples, "solve_samples", by_height)
    return computed(case(), tmp_path / "out", 640, WALLS=tuple(np.linspace(0.55, 0.95, 21)), POINTS=9)


def test_walls_of_a_known_law_by_hand(exact):
    """A wall h keeps (h - 0.6)/0.3 of uniform centres upright."""
    law = np.clip((exact.walls - 0.6) / 0.3, 0.0, 1.0)
    assert np.abs(exact.upright - law).max() < 0.01  # stratified samples
    for level in tipping_study.LEVELS:
        wall, low, high = exact.keeps(level)
        assert wall == pytest.approx(0.6 + 0.3 * level, abs=0.006)
        assert low < wall < high
    assert (exact.intervals[0] <= law).all()
    assert (law <= exact.intervals[1]).all()
    middle = 1e6 * exact.walls + 0.225e5
    assert exact.band("mean_50ms")[1] == pytest.approx(middle, rel=1e-3)
    tips = exact.map_walls[:, None] < exact.centres - 0.6
    assert ((exact.rolls == 0.5 * np.pi) == tips).all()
    index = {row["key"]: row["total"] for row in exact.sources["mean_50ms"]}
    assert index == pytest.approx(
        {"body.centre_height": 0.0, "contact.friction": 1.0, "axle.*.spring": 0.0}, abs=0.02
    )


def test_lowest_wall_by_hand():
    walls = np.array([0.5, 0.6, 0.7, 0.8])
    lowest = tipping_study.lowest_wall
    assert lowest(walls, np.array([0.0, 0.4, 0.6, 1.0]), 0.5) == pytest.approx(0.65)
    assert lowest(walls, np.array([0.6, 0.4, 0.6, 1.0]), 0.5) == pytest.approx(0.65), (
        "all higher walls keep it"
    )
    assert lowest(walls, np.array([0.6, 0.7, 0.8, 1.0]), 0.5) == 0.5
    assert np.isnan(lowest(walls, np.array([0.6, 0.7, 0.8, 0.4]), 0.5))


def test_binomial_interval_against_published_values():
    """0, 5 and 10 of 10 by Clopper and Pearson (1934)."""
    low, high = tipping_study.binomial_interval(np.array([0, 5, 10]), 10)
    assert low == pytest.approx([0.0, 0.18709, 0.69150], abs=1e-5)
    assert high == pytest.approx([0.30850, 0.81291, 1.0], abs=1e-5)


def test_an_interrupted_study_resumes(monkeypatch, tmp_path):
    calls = []

    def stopped(source, inputs):
        calls.append(inputs)
        if len(calls) == 4:
            raise InputError("wall.height", 0.0, "stop")
        return by_height(source, inputs)

    monkeypatch.setattr(space_samples, "solve_samples", stopped)
    with pytest.raises(InputError):
        computed(case(), tmp_path / "out")
    before, saved = len(calls), records.count(tmp_path / ".out.journal")
    again = computed(case(), tmp_path / "out")
    monkeypatch.setattr(space_samples, "solve_samples", by_height)
    complete = computed(case(), tmp_path / "other")
    assert saved > 0
    assert len(calls) - before == round(complete.processor / 0.01) - saved
    assert (again.answers["outcome"] == complete.answers["outcome"]).all()
    assert again.sources == complete.sources


def test_fractions_are_those_of_motions_of_their_own(study):
    """Each sample of the scene's wall is solved by its own keys."""
    scene, wall = study.case.scene, int(np.argmin(np.abs(study.walls - 36 * INCH)))
    springs, centre = study.inputs["axle.*.spring"], study.inputs["body.centre_height"]
    values = {
        "wall.height": np.full(springs.size, 36 * INCH), "contact.friction": study.inputs["contact.friction"],
        "body.centre_height": centre, "axle.0.spring": 0.2e6 * springs, "axle.1.spring": 0.35e6 * springs,
    }  # fmt: skip
    direct = space.solve_spaces(*space_samples.space_input(scene, values))
    assert study.upright[wall] == np.mean(direct.outcome == 0)
    assert (study.answers["mean_50ms"][wall] == direct.mean_50ms).all()
    assert (study.answers["height"][wall] == direct.height).all()


def test_the_report(study, tmp_path):
    report = tipping_report.report(study)
    write_report(report, tmp_path)
    assert (tmp_path / "samples.csv").read_text(encoding="utf-8").startswith("body.centre_height")
    for words in ("95 % of the samples upright", "Profiles of a wall", "AASHTO (Report 350)", "f-shape"):
        assert words in str(report.page)
    assert np.size(report.histories["map.csv"]["largest_roll"]) == study.rolls.size
    assert np.size(report.histories["samples.csv"]["outcome"]) == study.answers["outcome"].shape[1]
    walls = report.summary["lowest_walls"]
    assert [walls[level]["wall"] for level in ("5", "50", "95")] == [
        study.keeps(level)[0] for level in (0.05, 0.5, 0.95)
    ]
    assert {row["profile"] for row in report.summary["profiles"]} == {"vertical", "f-shape"}
    assert all(
        0.0 <= row["interval"][0] <= row["upright"] <= row["interval"][1] <= 1.0
        for row in report.summary["walls"]
    )


def test_the_answer_has_profile_36_inches_and_published_outcomes(exact):
    """By the law all samples are upright at 36 in."""
    answer = SI.rendered(tipping_report.headline(exact).answer)
    count = exact.count
    assert answer.startswith("Lowest wall that keeps 95 % of the samples upright, profile vertical: 0.8")
    assert (
        f"At 0.91 m (36.0 in) at least {math.floor(1e3 * 0.05 ** (1 / count)) / 10:.1f} % remain upright."
        in answer
    )
    row = exact.published[0]
    tests = (("a", "contained", 0.9, 0.1), ("b", "over the wall", 0.2, 0.2), ("c", "contained", 0.4, 0.6))
    rows = [
        row._replace(case=name, published=outcome, stated=part, probabilities={"over the wall": over})
        for name, outcome, part, over in tests
    ]
    assert tipping_report.published_in_words(rows) == (
        'Published outcomes of 3 crash tests: 1 are given a probability above one half, 2 by "always contained"; the '
        "least has 0.20: b, over the wall."
    )
    assert len(exact.published) == len(parameters()["outcomes"])


def test_all_of_few_samples_are_at_least():
    """None of 72 on its side leaves a bound of 95.9 %."""
    columns = {"outcome": np.zeros(72)} | dict.fromkeys(tipping_report.BANDS, np.ones(72))
    row = tipping_report.distribution(columns)
    assert (row["upright"], row["words"]) == (1.0, "at least 95.9 %")


def test_refused_indices_are_stated(study):
    refusal = "Sobol indices are not determined."
    report = tipping_report.report(
        replace(study, sources={}, refusals={"roll": refusal, "mean_50ms": refusal})
    )
    assert "Main source" not in report.page.headline.certainty
    assert refusal in report.terminal
    assert report.summary["indices_refused"]["roll"] == refusal


@pytest.mark.long
def test_a_low_vehicle_is_upright_on_every_wall(tmp_path):
    """A centre at 0.7 m is below all walls."""
    box = [f'strip.{number}.height=["1.2 m", "1.3 m"]' for number in (3, 4)]
    low = case("body.centre_height=0.7 m", *box, "strip.2.height=1.2 m")
    result = computed(low, tmp_path / "out", ranges=("body.centre_height=0.66 m:0.74 m",), LOWEST=36 * INCH)
    assert (result.upright == 1.0).all()
    assert result.keeps(0.95)[0] == result.walls[0]
    assert "at most" in tipping_report.headline(result).answer


def test_factors_apply_to_all_axles_and_strips():
    scene = case().scene
    values = space_samples.expanded(
        scene, {"axle.*.spring": np.array([2.0]), "axle.1.spring": np.array([1e5])}
    )
    assert values["axle.0.spring"] == pytest.approx(0.4e6)
    assert values["axle.1.spring"] == pytest.approx(1e5), "a key of its own comes before the factor"


@pytest.mark.parametrize(("options", "key"), [
    (("--range", "axle.*.spring=2:1"), "axle.*.spring"), (("--range", "axle.*.spring=a:b"), "axle.*.spring"),
    (("--range", "nosuch=1:2"), "nosuch"), (("--fix", "nosuch"), "nosuch"),
    (("--range", "axle.*.spring=1:2", "--fix", "axle.*.spring"), "axle.*.spring"),
    (("--range", "axle.*.spring=1:2", "--range", "axle.*.spring=1:3"), "two ranges"),
])  # fmt: skip
def test_refused_ranges(options, key, tmp_path, capsys):
    assert cli._status(["study", "tipping", SCENE, "--out", str(tmp_path / "out"), *options]) == 2
    assert key in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_factors_alone_may_vary():
    keys = [item.key for item in space_samples.space_ranges(case(), (), ())]
    factors = [key for key in keys if "*" in key]
    varied = space_samples.space_ranges(case(), (), tuple(key for key in keys if key not in factors))
    assert [item.key for item in varied] == factors


def test_a_planar_scene_is_refused(tmp_path, capsys):
    assert cli._status(["study", "tipping", "impact-mash-tl4-sut", "--out", str(tmp_path / "out")]) == 2
    assert "body" in capsys.readouterr().err


@pytest.mark.long
def test_the_command_with_another_profile(tmp_path, monkeypatch):
    for name, value in SMALL.items():
        monkeypatch.setattr(tipping_study, name, value)
    words = [
        "--samples",
        "128",
        "--workers",
        "1",
        "--set",
        "wall.profile=f-shape",
        "--out",
        str(tmp_path / "out"),
    ]
    assert cli._status(["study", "tipping", SCENE, *words]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    by_profile = {row["profile"]: row["upright"] for row in summary["profiles"]}
    at_scene = next(row for row in summary["walls"] if row["height_of_wall"] == pytest.approx(36 * INCH))
    assert at_scene["upright"] == by_profile["f-shape"]
    assert "f-shape" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
