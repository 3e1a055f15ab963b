"""Verify the numbers of headlines, and the scale of drawings."""

import datetime
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shared_cases import case

import tailslap
from postprocess.figures.positions import Unit, draw_set_up
from postprocess.report.page import page_text
from postprocess.report.terminal import concluded
from postprocess.svg.areas import Outline
from postprocess.svg.marks import Words
from postprocess.units import KIP, SI, US, force, percent_up
from tailslap import cli
from tailslap.campaign.band_samples import force_band
from tailslap.case import report_parts as shared
from tailslap.case.corner import corner_report as corner
from tailslap.case.force_band import ForceBand
from tailslap.case.impact import report as impact
from tailslap.scene.read import shipped_scenes
from tailslap.validation.calibration import calibrated_band, class_of, classes


def rigid_force(of):
    summary = of.rigid_numbers()
    if "space" in summary:
        return summary["space"]["force"]["mean_50ms"]
    return summary["peaks"]["mean_50ms"] if "peaks" in summary else summary["stage3"]["peak_force"]


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_scene_has_an_answer_with_its_force(name):
    """The text has SI or US units, and keys of the scene."""
    scene_case = case(name)
    peak = rigid_force(scene_case)
    headline = scene_case.headline().in_units(SI)
    digits = f"{peak / 1e3:.0f}" if peak >= 1e5 else f"{peak / 1e3:.3g}"
    assert f": {digits} kN" in headline.answer
    kips = f"{peak / KIP:.{max(3, len(digits.replace('.', '')))}g} kip"
    assert f": {kips}" in scene_case.headline().in_units(US).answer
    vehicle, hit = scene_case.source.tables["vehicle"], scene_case.source.tables["impact"]
    trailers = scene_case.source.tables.get("trailer", ())
    behind = "".join(f" with a {unit['mass']} trailer" for unit in trailers)
    what = f"tractor{behind}" if trailers else "vehicle"
    subject = f"{vehicle['mass']} {what} at {hit['speed']}, {hit['angle']}"
    if "start" in scene_case.source.tables:
        subject = f"{vehicle['mass']} vehicle at 25.053 m/s, 14.8969 deg"
    assert headline.title.endswith(f": {subject}")
    join = lambda side: " and ".join(dict.fromkeys(u[side] for u in (vehicle, *trailers)))  # noqa: E731
    length, width = join("length"), join("width")
    assert headline.set_up.startswith(f"{name}: {subject}; length {length}, width {width}, ")
    assert headline.certainty
    drawing = scene_case.drawing()
    assert len(drawing.svg) < 12_000
    assert vehicle["length"] in {mark.label for mark in drawing.plots[0].marks if isinstance(mark, Words)}


LEVEL = re.compile(r", ([\d.]+) times (.*) \((\S+) (kN|kip)\)\.")


def test_the_ratio_to_the_design_force():
    metric = LEVEL.search(case("mash-tl4-sut").headline().in_units(SI).answer)
    assert metric
    ratio, name, level, unit = metric.groups()
    assert (name, unit, float(level)) == ("MASH (TTI), TL-4", "kN", round(80.0 * KIP / 1e3))
    mean = 0.75 * rigid_force(case("mash-tl4-sut"))  # of a triangle of 100 ms over its middle 50 ms
    assert float(ratio) == pytest.approx(mean / (80.0 * KIP), abs=0.05)
    customary = LEVEL.search(case("mash-tl4-sut").headline().in_units(US).answer)
    assert customary
    assert customary[3] == "80"
    assert "times" not in case("mash-tl4-sut", "impact.test_level=").headline().answer


def test_inputs_stand_in_the_units_in_which_they_are_given():
    changes = ("vehicle.mass=22 klb", "impact.speed=20", "impact.angle=0.25", "vehicle.length=30ft")
    set_up = case("mash-tl4-sut", *changes).headline().set_up
    start = "mash-tl4-sut: 22 klb vehicle at 20 m/s, 14.3239 deg; length 30 ft, width 2438 mm"
    assert SI.rendered(set_up).startswith(start)
    assert "at 65.6 ft/s, 14.3239 deg" in US.rendered(set_up)
    start = SI.rendered(case("paper-table-3", "impact=", "corner.friction=0.47").headline().set_up)
    words = "paper-table-3: 9979 kg vehicle at 25.053 m/s, 14.8969 deg; length 10 m, width 2438 mm, "
    assert start.startswith(words)
    assert start.endswith("start of Stage 2: angular velocity 0.707 rad/s, friction 0.47.")
    later = SI.rendered(case("mash-tl4-sut", "start.corner_speed=24").headline().set_up)
    start = "at 56 mph, 15 deg; length 10 m, width 2438 mm, start of Stage 2: corner speed 24 m/s, friction"
    assert start in later
    contact = case("impact-mash-tl3-car").headline().set_up
    crush = "crush stiffness 0.98 MN/m a corner, initial crush force 75 kN, plateau 250 kN"
    assert f"{crush}, restitution 0.225, tyres of 2 axles, friction 0.35." in contact


def test_a_run_answers_with_the_force_of_the_plate(outcome):
    soft = ("wall=", "plate.youngs_modulus=30 MPa", "corner.patch_length=1", "plate.elements=[40, 12]")
    result = outcome("mash-tl4-sut", *soft)
    headline = corner.CornerReport(result).headline.in_units(SI)
    fe, rigid = result.lateral_force, result.fe_plan.case.force.peak_force
    assert round(fe / 1e3) != round(rigid / 1e3)
    assert (
        f"tail-slap: {fe / 1e3:.0f} kN (triangular pulse of 100 ms, assumed); 50 ms mean " in headline.answer
    )
    changed = percent_up(max(map(abs, result.difference.values())))
    assert headline.certainty.startswith(f"Vehicle flexibility changes the motion by at most {changed}; ")
    newton = result.fe_plan.case.other_convention()[1].force.peak_force
    words = f"{newton / 1e3:.0f} kN ({100 * (newton / rigid - 1):+.0f} %)"
    assert (
        f" With Newton's convention (1 + e) {words}. The constraint makes the wall pull" in headline.certainty
    )


def test_an_impact_answers_with_its_largest_mean_and_strike(outcome):
    result = outcome("impact-mash-tl4-sut")
    strike = result.fe.strikes[0]
    answer = impact.ImpactReport(result).headline.in_units(SI).answer
    where = f"strike 1 (front corner, from {strike.start:.3f} s)"
    assert f"force: {result.fe.peaks['mean_50ms'] / 1e3:.0f} kN in {where}" in answer
    assert ", equal to its assumed plateau. Paper" in answer
    assert answer.endswith(" Paper's method: 490 kN.")
    none = replace(result.fe, strikes=())
    assert result.fe_plan.case.force_sentence(none) == "The vehicle does not strike the wall."


@pytest.mark.parametrize(("plateau", "equals"), [("250 kN", True), ("", False), ("1 MN", False)])
def test_a_force_that_equals_a_plateau_says_so(plateau, equals):
    answer = case("impact-mash-tl4-sut", f"contact.plateau_force={plateau}").headline().answer
    assert ("equal to its assumed plateau" in answer) == equals


def test_a_whole_impact_answers_with_median_band_and_ratio_before_its_own_force():
    band = ForceBand((2e5, 4e5, 6e5), 72, {"a": 0.24}, decisive=("the plateau, assumed 200 to 500 kN",))
    band = replace(band, speeds=("45", "75 mph"), growth=1.5)
    assert case("impact-mash-tl4-sut").headline(band).in_units(SI).answer == (
        "Largest 50 ms mean of the lateral force: median 400 kN; 90 % of the inputs alone: 200 to 600 kN, 1.1 (0.56 to "
        "1.7) times MASH (TTI), TL-4 (356 kN). This scene: 350 kN in strike 1 (front corner, from 0.000 s), equal to "
        "its assumed plateau. Paper's method: 490 kN."
    )
    assert (
        case("impact-mash-tl4-sut")
        .headline(band)
        .in_units(SI)
        .band.startswith(
            "Decided most by the plateau, assumed 200 to 500 kN (24 % of the variance); from 45 to 75 mph the force "
            "grows 1.5 times. Band of 72 rigid vehicles"
        )
    )


def test_a_corner_names_its_whole_impact():
    named = "in strike 1 (front corner, from 0.000 s), equal to its assumed plateau (`tailslap rigid impact-mash-tl4"
    assert named in case("mash-tl4-sut").headline().answer
    assert named not in case("mash-tl4-sut", "vehicle.mass=8 t").headline().answer
    assert "Whole impact" not in case("paper-table-3").headline().answer


def test_the_readme_shows_the_headline_of_its_run(outcome):
    text = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    quoted = " ".join(line.removeprefix(">").strip() for line in text.splitlines() if line.startswith(">"))
    result = outcome("paper-table-3")
    lines = corner.CornerReport(result, force_band(result.fe_plan.case)).headline.in_units(SI).lines
    assert " ".join(lines) in " ".join(quoted.split())


def test_a_failed_run_opens_with_check_size_and_remedy(outcome):
    result = outcome("mash-tl4-sut", "corner.penalty_scale=0.0001")
    (failed,) = (check for check in result.checks if not check.passed)
    answer = corner.CornerReport(result).headline.answer
    size = f"{failed.name} {failed.value:.3g} (limit {failed.limit:.3g})"
    assert answer.startswith(f"Failed: {size}. Remedy: {failed.advice}. ")
    assert "a larger corner.penalty_scale" in failed.advice
    assert "Peak lateral force at the tail-slap, not reliable: " in answer
    demanded = outcome("mash-tl4-sut", "verify.tolerance=1e-7")
    assert "not reliable" not in corner.CornerReport(demanded).headline.answer
    assert corner.CornerReport(demanded).headline.answer.startswith("Failed: agreement with rigid ")


def test_the_footer_has_version_date_and_command(tmp_path, capsys):
    words = [
        "modes", "paper-table-3", "--count", "1", "--set", "plate.elements=[8, 2]", "--out",
        str(tmp_path / "a"),
    ]  # fmt: skip
    assert cli._status(words) == 0
    page = (tmp_path / "a" / "report.html").read_text()
    footer = page.partition("<footer>")[2].partition("</footer>")[0].replace("\N{NO-BREAK SPACE}", " ")
    for part in (f"tailslap {tailslap.__version__}", datetime.date.today().isoformat()):
        assert part in re.sub("<[^>]+>", "", footer)
    changes = "--count 1 --set &#39;plate.elements=[8, 2]&#39; --out "
    assert f"<code>tailslap modes paper-table-3 {changes}" in footer


def outlines(drawing):
    outlines = [mark for mark in drawing.plots[0].marks if isinstance(mark, Outline)]
    return [np.stack([mark.x, mark.y], axis=1) for mark in outlines][1:3]


def test_the_drawing_is_to_scale():
    """Corner P at touch, the side at the tail-slap."""
    constrained = case("mash-tl4-sut")
    first, last = outlines(constrained.drawing())
    slide = constrained.motion.strike.slide
    assert first[0] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert first[1] == pytest.approx(10.0 * np.array([-np.cos(np.radians(15)), np.sin(np.radians(15))]))
    assert last[:2] == pytest.approx(np.array([[slide, 0.0], [slide - 10.0, 0.0]]), abs=1e-9)
    assert last[2:] == pytest.approx(np.array([[slide - 10.0, 2.438], [slide, 2.438]]), abs=1e-9)
    hit = case("impact-mash-tl4-sut")
    first, last = outlines(hit.drawing())
    assert np.hypot(*(last[1] - last[2])) == pytest.approx(2.438)
    assert last[1, 1] == pytest.approx(0.0, abs=1e-3), "the rear corner strikes"


def test_the_drawing_takes_symbols_and_several_units():
    at = np.zeros(2), np.ones(2), np.array([0.2, 0.0])
    truck, trailer = Unit(*at, 6.0, 2.0, 3.0), Unit(at[0] - 7.0, at[1] + 1.0, at[2], 6.0, 2.0, 3.0)
    words = {"length": "L", "width": "B", "angle": "θ", "speed": "v_0", "slide": "s"}
    words |= {"first": "first touch", "second": "tail-slap"}
    one, both = (draw_set_up(units, words, "Truck from above") for units in ([truck], [truck, trailer]))
    assert both.svg.count('fill-opacity="0.12"') == 2 * one.svg.count('fill-opacity="0.12"') == 4
    for text in ("θ", "L", "B", "P", "E", "G", "wall", "first touch", "tail-slap"):
        assert f">{text}<" in one.svg, text
    assert 'aria-label="Truck from above"' in one.svg
    assert one.in_units(US).svg.count("<text") == one.svg.count("<text")


def test_python_and_terminal_end_alike(capsys):
    result = tailslap.rigid("mash-tl4-sut")
    assert result.headline.answer == result.summary["answer"]
    assert result.headline.answer in repr(result)
    assert result.headline.answer in result._repr_html_()
    assert str(result).endswith(concluded(result.headline))
    us = tailslap.rigid("mash-tl4-sut", units="us")
    assert "147 kip" in str(us).rpartition("\n\n")[2]


def test_ratios_and_the_other_restitution_are_named(outcome):
    """Columns name the force, rows the convention of the second peak."""
    truck, hit = outcome("mash-tl4-sut"), outcome("impact-mash-tl4-sut")
    tables = (shared.design_table(result.fe_plan.case, result.mean_force) for result in (truck, hit))
    named = [table.columns[2].label for table in tables]
    assert named == ["50 ms mean / design"] * 2
    for result in (truck, hit):
        rows = shared.design_table(result.fe_plan.case, result.mean_force).rows
        computed, *estimates, first, second, _ = rows
        assert computed["force"] == result.mean_force
        assert first["ratio"] == pytest.approx(result.mean_force / (80.0 * KIP))
        assert [row["name"] for row in estimates] == ["Inertial estimate, assumed place"] * (result is hit)
        for estimate in estimates:
            assert second["ratio"] == pytest.approx(estimate["force"] / (22.05 * 4.5 * KIP))
    peak, mean = corner.peak_table(truck).rows
    assert (mean["fe"], mean["rigid"]) == pytest.approx((0.75 * peak["fe"], 0.75 * peak["rigid"]))
    case = truck.fe_plan.case
    other = SI.rendered(force(case.other_convention()[1].force.peak_force))
    assert f"With Newton's convention (1 + e) {other} (" in SI.rendered(case.other_force())


@pytest.mark.parametrize(("name", "verdict"), [
    ("impact-mash-tl4-sut", "9 of 11 published values of this class lie in the 90 % band of the inputs."),
    ("impact-tipping-tl4-sut", "9 of 11 published values of this class lie in the 90 % band of the inputs."),
    ("impact-mash-tl3-pickup", "0 of 1 published values of this class lie in the 90 % band of the inputs. They are "
     "too few for a calibrated band."),
])  # fmt: skip
def test_the_band_links_to_the_published_values_of_its_class(name, verdict, outcome):
    """In plane and space, with calibration and without."""
    result = outcome(name)
    of = result.fe_plan.case
    text = page_text(of.report(result, calibrated_band(of)).page(False)).replace("\N{NO-BREAK SPACE}", " ")
    ((part, words),) = re.findall(r' <a href="#([\w-]+)">([^<]*)</a></p>', text)
    assert words == verdict
    section = text.partition(f'<section id="{part}">')[2].partition("</section>")[0]
    assert section.strip().startswith("<details>")
    lines = re.sub('<span class="us">.*?</span>', "", section.partition("</tbody>")[0]).split("<tr>")[2:]
    one = class_of(of, classes())
    assert one
    for row, line in zip(one.published, lines, strict=True):
        numbers = [f"{1e-3 * row[key]:.0f}" for key in ("published", "predicted", "lower", "upper")]
        expected = [row["source"], *numbers, f"{row['ratio']:.2f}", "yes" if row["inside"] else "no"]
        cells = [
            re.sub("<.*?>", "", cell) for cell in re.findall(r"<(?:small|td).*?>(.*?)</(?:small|td)>", line)
        ]
        assert [cells[0], *cells[4:]] == expected


def test_without_published_values_the_band_has_no_link(outcome):
    result = outcome("impact-mash-tl1-car")
    of = result.fe_plan.case
    assert "</a></p>" not in page_text(of.report(result, calibrated_band(of)).page(False))


def test_headings_name_what_is_drawn(outcome, tmp_path):
    """A layer has a heading where there is one."""
    page = impact.ImpactReport(outcome("impact-mash-tl4-sut")).written(tmp_path, False).page
    assert "Energy and crush" in [section.title for section in page.sections]
    assert not [chart for chart in page.charts if "along the side" in chart.caption]
    (caption,) = (chart.caption for chart in page.charts if chart.name == "positions")
    assert "later ones more opaque" in caption
