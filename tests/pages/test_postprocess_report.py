"""Verify tables and the completeness and accessibility of pages."""

from __future__ import annotations

import base64
import csv
import hashlib
import html
import io
import json
import math
import re
import tomllib
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from browser.pages import Parsed, written
from PIL import Image

from postprocess.report import page as pages
from postprocess.report import prose
from postprocess.report.command_report import Report, report_text, write_report
from postprocess.report.tables import Column, Table, pairs
from postprocess.svg.chart import Axis, Chart, Plot, draw_legend
from postprocess.svg.marks import PALETTE, Line, Swatch
from postprocess.units import percent_up, shown
from tailslap.case.corner.corner_report import CornerReport
from tailslap.case.report_parts import DESIGN
from tailslap.case.run_report import chosen_sentences
from tailslap.cli import _status

SCENE = 'name = "a<b>&c"  # </pre><script>alert(1)</script>\nwidth = "2438 mm"\n'


@dataclass(frozen=True)
class Inner:
    words: str


@dataclass(frozen=True)
class Record:
    name: str
    size: float
    inner: Inner
    good: bool


RECORDS = (
    Record("v_GX", 1.0 / 3.0, Inner("along <the> wall"), True),
    Record("steps", math.nan, Inner("none"), False),
)
COLUMNS = (
    Column("name", "Name"),
    Column("size", "Size", "m", form=".3g", group="measured", below=Column("inner.words", "")),
    Column("inner.words", "Words"),
    Column("good", "Result", form=lambda good: "passed" if good else "failed", style="badge"),
)
TABLE = Table(COLUMNS, RECORDS, "A table", notes=("A note.",), marks={1: "failed"})


PIXELS = (np.random.default_rng(1).integers(0, 2, (8, 12, 1)) * (20, 120, 250)).astype(np.uint8)


def full_page(folder):
    picture = folder / "contour_v_gx.png"
    Image.fromarray(PIXELS).save(picture)
    line = Line("curve-1", np.arange(2.0), np.arange(2.0))
    curve = Chart("omega", "Angular velocity", (Plot((line,), Axis("ω [rad/s]")),), Axis("t [s]"), "Motion")
    figures = (curve, pages.Picture(picture, "v_GX at the strike"))
    sections = (
        pages.Section("Tables", "A lead.", tables=(TABLE, pairs({"mass": 9979.0}), Table(COLUMNS, ()))),
        pages.Section("Figures. By matplotlib", figures=figures),
        pages.Section("Sentences", sentences=("N < 0 pulls, `corner.friction` holds.",)),
        pages.Section("Empty", tables=(Table(COLUMNS, ()),)),
    )
    headline = pages.Headline("mash<tl4>", "The answer.", "The set-up.", "The certainty.")
    words = ("A kicker", headline, sections, "The footer.", SCENE)
    return pages.Page(*words, True, contents=True)


@pytest.fixture
def page(tmp_path):
    return Parsed(pages.write_page(tmp_path / "report.html", full_page(tmp_path)).read_text(encoding="utf-8"))


def test_every_number_and_word_is_there(page):
    pieces = [
        "A kicker", "mash<tl4>", "The answer.", "The set-up.", "The certainty.", "A lead.", "A table",
        "measured", "Size [m]", "0.333",
    ]  # fmt: skip
    pieces += ["along <the> wall", "not a number", "A note.", "mass", "9979", "curve-1", "Angular velocity"]
    pieces += ["N < 0 pulls", "The footer."]
    assert [piece for piece in pieces if piece not in page.text] == []
    assert (page.pieces.count("passed"), page.pieces.count("failed")) == (1, 1)
    assert "checks passed" in page.pieces
    assert ("tr", "class", "failed") in page.attributes


def test_symbols_and_keys_are_typeset(page):
    assert "GX" in page.pieces
    assert {"sub", "code", "nav"} <= page.tags
    assert "v_GX" not in page.text


def test_what_is_empty_is_not_shown(page):
    assert "Empty" not in page.text
    links = [link for _, link, *_ in page.named("a") if "download" not in link]
    assert [link["href"] for link in links] == ["#part-1", "#part-2", "#part-3"]


def test_the_scene_is_shown_verbatim_and_cannot_become_markup(page):
    assert SCENE in page.inside("pre")
    metas = [value for tag, name, value in page.attributes if (tag, name) == ("meta", "content")]
    (policy,) = [value for value in metas if "src" in value]
    digest = base64.b64encode(hashlib.sha256(page.inside("script").encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy, "the page's own script, and no other"
    assert "alert" not in page.inside("script")


def test_nothing_is_fetched(page):
    names = ("src", "href", "xlink:href", "srcset", "action")
    downloads = [link for _, link, *_ in page.named("a") if "download" in link]
    rest = [attributes for _, attributes, *_ in page.elements if attributes not in downloads]
    links = [value for attributes in rest for name, value in attributes.items() if name in names]
    assert links
    assert all(link.startswith(("data:image/webp;base64,", "#")) for link in links)
    assert [link["href"] for link in downloads] == ["omega.svg"], "a file beside the page"
    assert not {"link", "iframe", "object"} & page.tags
    assert not re.search(r"fetch|import|XMLHttp|https?:(?!//www.w3.org/2000/svg)", page.inside("script"))
    for words in ("@import", "url("):
        assert words not in page.text


def test_the_picture_is_in_the_page_whole(page):
    """Few colours remain as they are."""
    (source,) = [value for tag, name, value in page.attributes if (tag, name) == ("img", "src")]
    image = Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2])))
    np.testing.assert_array_equal(np.array(image), PIXELS)


def test_a_missing_picture_is_an_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        written(tmp_path, pages.Picture(tmp_path / "none.png", ""))
    assert not list(tmp_path.iterdir())


def test_a_table_is_the_same_on_the_terminal_and_in_files(tmp_path):
    """Files hold the values, terminal and page their text."""
    report = Report(full_page(tmp_path), {"a": math.inf}, (TABLE, "A sentence."), {"table.csv": TABLE})
    write_report(report, tmp_path)
    with (tmp_path / "table.csv").open() as file:
        first, second = csv.DictReader(file)
    assert float(first["size"]) == 1.0 / 3.0
    assert (first["inner.words"], second["good"]) == ("along <the> wall", "False")
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert list(summary) == ["title", "answer", "set_up", "certainty", "band", "a"]
    assert (summary["answer"], summary["a"]) == ("The answer.", None)
    text = report_text(report, tmp_path)
    for piece in ("A table", "measured", "Size", "[m]", "0.333", "not a number", "A note.", "A sentence."):
        assert piece in text
    assert text.endswith(f"Report: {tmp_path / 'report.html'}\n\nThe answer.")


def test_a_record_without_the_entry_is_an_error():
    with pytest.raises(AttributeError):
        Table((Column("nothing", ""),), RECORDS).records()


def run_page(outcome, folder):
    report = CornerReport(outcome).composed(pictures=False)
    write_report(report, folder)
    return Parsed((folder / "report.html").read_text(encoding="utf-8"))


def test_the_page_of_a_run_holds_its_numbers(outcome, tmp_path):
    result = outcome("paper-table-3")
    page = run_page(result, tmp_path)
    agreement = f"agree within {percent_up(max(map(abs, result.difference.values())))};"
    assert agreement in page.text.replace(prose.NO_BREAK, " ")
    assert "Failed" not in page.text
    numbers = [
        shown(value, "#.5g").replace("-", "−") for value in (*result.fe.values(), *result.rigid.values())
    ]
    printed = ["0.383", "23.27", "−3.274", "23.305", "−3.289", "8.915", "Infrastructures 2025, 10(11), 307"]
    for text in (*(check.name for check in result.checks), *numbers, *printed):
        assert text in page.text


def test_files_hold_the_force_and_its_ratio_to_design_forces(outcome):
    """Stage 3 is a triangular pulse of m v_GY in 0.1 s."""
    result = outcome("mash-tl4-sut", "impact.speed=20 m/s")
    summary = CornerReport(result).summary(pictures=False)
    force = 2.0 * 9979.0 * abs(result.fe["v_gy"]) / 0.1
    assert summary["peak_force"]["fe"] == pytest.approx(force, rel=1e-12)
    assert summary["peak_force"]["rigid"] == summary["stage3"]["peak_force"]
    first = summary["design_forces"][0]
    mean = 0.75 * force  # over the middle 50 ms
    assert first["ratio"] * first["force"] == pytest.approx(mean, rel=1e-12)
    assert result.fe_plan.case.row(result)["fe.peak_force"] == summary["peak_force"]["fe"]


def test_a_failed_run_says_so(outcome, tmp_path):
    result = outcome("mash-tl4-sut", "impact.speed=20 m/s")
    first, *passing = result.checks
    broken = replace(first, passed=False, value=math.nan)
    difference = dict.fromkeys(result.difference, math.nan)
    page = run_page(replace(result, checks=(broken, *passing), difference=difference), tmp_path)
    assert (page.pieces.count("failed"), page.pieces.count("passed")) == (1, len(passing))
    assert f"1 of {len(result.checks)} checks failed" in page.pieces
    assert ("body", "class", "failed") in page.attributes, "whose numbers are grey"
    assert ".failed section:not(:first-child) .strong { color: var(--soft)" in page.inside("style")
    assert f"Failed: {first.name} not a number (limit {first.limit:.3g}). Remedy: " in page.text.replace(
        prose.NO_BREAK, " "
    )
    assert "Failed checks and remedies" in page.text
    for text in (*first.advice.split("; "), *chosen_sentences(result.fe_plan), *CornerReport(result).causes):
        plain = re.sub("<[^>]+>", "", html.unescape(str(prose.prose(text))))
        assert plain.replace(prose.NO_BREAK, " ") in page.text
    assert "not a number" in page.text
    assert "Paper, ABAQUS" not in page.text


def test_the_terminal_tells_once_what_was_chosen(outcome):
    result = outcome("mash-tl4-sut", "impact.speed=20 m/s", "plate.start=unstressed")
    decisions = [decision.text for decision in result.fe_plan.decisions]
    failed = replace(result.checks[0], passed=False)
    terminal = CornerReport(replace(result, checks=(failed, *result.checks[1:]))).terminal
    text = "\n".join(line for line in terminal if isinstance(line, str))
    assert [text.count(decision) for decision in decisions] == [1] * len(decisions) != []
    (cause,) = CornerReport(result).causes
    assert cause in text


def test_the_answer_comes_first_and_detail_is_folded(outcome, tmp_path):
    """Set-up, forces and quantities are first, with at most 60 numbers."""
    result = outcome("mash-tl4-sut", "impact.speed=20 m/s")
    report = CornerReport(result).composed(pictures=False)
    set_up, forces, quantities, *_ = (section for section in report.page.sections if not section.is_empty)
    titles = set_up.title, forces.title, quantities.title
    assert titles == ("Set-up", "Peak lateral force", "At the tail-slap")
    force = result.fe_plan.case.force.peak_force
    assert f"{force / 1e3:#.4g}" in forces.tables[0].columns[2].text({"rigid": force})
    names = [row["name"] for row in forces.tables[1].rows]
    assert names[:2] == ["This impact, 50 ms mean", "MASH (TTI), TL-4"]
    opened = [section for section in report.page.sections if not section.is_folded]
    cells = [c.text(r) for s in opened for t in s.tables for r in t.rows for c in t.columns if c.form]
    assert 15 <= sum(text != "–" for text in cells) <= 60
    write_report(report, tmp_path)
    assert (tmp_path / "report.html").read_text().count("<details>") >= 6


def test_the_page_shows_the_scene_as_it_was_run(outcome):
    text = CornerReport(outcome("mash-tl4-sut", "impact.speed=20 m/s")).page(pictures=False).scene_text
    scene = tomllib.loads(text)
    assert scene["impact"]["speed"] == "20 m/s"
    assert "56 mph" not in text
    assert scene["vehicle"] == {"length": "10 m", "width": "2438 mm", "mass": "9979 kg"}
    assert "changed: impact.speed" in text


def test_a_run_without_a_strike(outcome, tmp_path):
    result = replace(outcome("mash-tl4-sut"), fe={}, difference={})
    vars(result)["metrics"] = {}
    page = run_page(result, tmp_path)
    assert "No tail-slap within the run." in page.text
    for heading in ("FE histories against", "The plate at the tail-slap"):
        assert heading not in page.text


TEMPLATES = Path(__file__).parents[2] / "postprocess" / "templates"


@pytest.fixture(scope="module", params=["run", "failed", "impact", "paper", "modes"])
def any_page(request, tmp_path_factory, outcome):
    place = tmp_path_factory.mktemp("pages") / "out"
    if request.param in ("run", "failed"):
        flutter = ("impact.friction=0.8", "corner.penalty_scale=3", "damping.kind=none")
        result = outcome("mash-tl4-sut", *(flutter if request.param == "failed" else ()))
        place.mkdir()
        pages.write_page(place / "report.html", CornerReport(result).page(pictures=False))
        return Parsed((place / "report.html").read_text(encoding="utf-8"))
    commands = {
        "impact": ("run", "impact-mash-tl4-sut", "--no-pictures"),
        "paper": ("paper",),
        "modes": ("modes", "paper-table-3", "--count", "1"),
    }
    assert _status([*commands[request.param], "--quiet", "--out", str(place)]) == 0
    (path,) = place.glob("*.html")
    return Parsed(path.read_text(encoding="utf-8"))


def test_landmarks_and_headings(any_page):
    for tag in ("header", "main", "footer", "h1", "title"):
        assert len(any_page.named(tag)) == 1, tag
    levels = [int(tag[1]) for tag, *_ in any_page.named("h1", "h2", "h3")]
    assert levels[0] == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    assert all(text for *_, text in any_page.named("h1", "h2", "h3", "summary", "a"))
    assert any_page.named("html")[0][1]["lang"] == "en"


def test_tables_have_captions_and_headings_scopes(any_page):
    tables = any_page.named("table")
    captions = any_page.named("caption")
    assert len(captions) == len(tables)
    assert all(text for *_, text in captions)
    for _, attributes, _, text in any_page.named("th"):
        assert attributes.get("scope") in ("row", "col", "colgroup")
        assert text, "an empty heading says nothing"


def test_what_scrolls_is_reached_by_keyboard_and_named_once(any_page):
    divisions = [attributes for _, attributes, *_ in any_page.named("div")]
    boxes = [attributes for attributes in divisions if "scroll" in attributes.get("class", "")]
    assert len(boxes) >= len(any_page.named("table"))
    for attributes in boxes:
        assert (attributes["tabindex"], attributes["role"]) == ("0", "region")
    names = [attributes["aria-label"] for attributes in boxes]
    assert len(names) == len(set(names))
    assert all(above.count("div") for _, _, above, _ in any_page.named("table"))


def test_pictures_have_words(any_page):
    assert all(attributes.get("alt") for _, attributes, *_ in any_page.named("img"))
    drawings = [
        attributes for _, attributes, *_ in any_page.named("svg") if attributes.get("class") == "chart"
    ]
    assert all(attributes["role"] == "img" and attributes["aria-label"] for attributes in drawings)
    assert len(any_page.named("figure")) == len(any_page.named("figcaption"))


def test_ids_are_unique_and_links_lead_somewhere(any_page):
    ids = [attributes["id"] for _, attributes, *_ in any_page.elements if "id" in attributes]
    assert len(ids) == len(set(ids))
    links = [attributes for _, attributes, *_ in any_page.named("a")]
    assert {link["href"][1:] for link in links if "download" not in link} <= set(ids)
    files = {link["download"]: link["href"] for link in links if "download" in link}
    assert all(link.startswith("data:text/csv;") or link == name for name, link in files.items())


def test_without_scripts_all_is_there(any_page):
    """The script adds the values at the pointer alone."""
    (script,) = any_page.named("script")
    assert script[2] == ("html", "body")
    assert not any("hidden" in attributes for _, attributes, *_ in any_page.elements)
    parts = any_page.named("section", "div", "p")
    assert "style" not in {name for _, attributes, *_ in parts for name in attributes}


def test_every_colour_of_charts_has_one_in_the_dark():
    dark = (TEMPLATES / "dark.css").read_text(encoding="utf-8")
    assert set(PALETTE) == set(re.findall(r"svg \.(\w+) \{ color:", dark))
    for name, light in PALETTE.items():
        (other,) = re.findall(rf"svg \.{name} \{{ color: (#\w{{6}})", dark)
        assert (brightness(other) > 0.3) == (name != "grid"), name
        assert (brightness(light) < 0.3) == (name != "grid"), name


def brightness(colour):
    """Relative luminance by WCAG, its exponent rounded to two."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return 0.2126 * red**2 + 0.7152 * green**2 + 0.0722 * blue**2


def test_paper_cuts_no_column_and_leaves_no_heading_alone():
    css = (TEMPLATES / "page.css").read_text(encoding="utf-8")
    paper = css[css.index("@media print") :]
    for rule in (".scroll { overflow: visible; }", "white-space: normal", "size: A4"):
        assert rule in paper
    for rule in (".whole { white-space: nowrap; }", ".legend { grid-column: 1 / -1; }", "overflow-wrap"):
        assert rule in css, "names, legends and long words"
    selectors = ", ".join(re.findall(r"^  (.*) \{ break-after: avoid; \}", paper, re.MULTILINE))
    assert {"h2", "h3", "summary", "caption", "thead"} <= set(selectors.split(", "))
    script = (TEMPLATES / "page.js").read_text(encoding="utf-8")
    assert "beforeprint" in script, "what is folded is printed"


def test_a_name_that_is_kept_whole_is(tmp_path):
    """TL-4 in the table of design forces."""
    row = dict.fromkeys(column.key for column in DESIGN)
    table = Table(DESIGN, [row | {"name": "AASHTO LRFD, TL-4", "force": 240e3, "ratio": 2.0}])
    text = written(tmp_path, tables=(table,)).read_text(encoding="utf-8")
    assert '<th scope="row" class="whole">AASHTO LRFD, <span class="whole">TL-4</span><' in text


def test_a_table_of_many_columns_is_set_smaller(tmp_path):
    """By their number, or by the letters of their headings."""
    headings = [["a"] * 9, ["a"] * 10, ["a" * 24] * 4, ["a" * 25] * 4]
    tables = [
        Table(tuple(map(Column, map(str, range(10)), names)), [["1"] * len(names)]) for names in headings
    ]
    assert [table.is_wide for table in tables] == [False, True, False, True]
    assert written(tmp_path, tables=tables).read_text().count('<table class="dense">') == 2


def test_a_legend_of_several_charts_has_a_row_of_its_own(tmp_path):
    """Its letters are as large as those of the charts."""
    chart = Chart("b", "A chart", (Plot((Line("", np.arange(2.0), np.arange(2.0)),)),), Axis("x"))
    legend = draw_legend("a", "What colours mean", (Swatch("right", "green"),))
    text = written(tmp_path, legend, chart, layout="narrow").read_text(encoding="utf-8")
    assert text.count('<figure class="legend">') == 1
