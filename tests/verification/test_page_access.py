"""Verification: pages can be read by keyboard and by ear, in the dark, narrow, on paper, and with scripts blocked."""

import re
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from postprocess.report.page import Page, Section, write_page
from postprocess.report.table import Table, text_table
from postprocess.svg.chart import Axis, Plot, draw_chart, draw_legend
from postprocess.svg.drawing import PALETTE
from postprocess.svg.marks import Line, Swatch
from tailslap.case.corner.report import corner_report
from tailslap.case.report import DESIGN
from tailslap.cli import _status

TEMPLATES = Path(__file__).parents[2] / "postprocess" / "templates"
VOID = {"meta", "img", "br", "link", "hr", "input", "path", "rect", "circle", "image", "use"}


class Tree(HTMLParser):
    """Every element with its attributes, those above it, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str], tuple[str, ...], list[str]]] = []
        self.open: list[int] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        above = tuple(self.elements[i][0] for i in self.open)
        self.elements.append((tag, {name: value or "" for name, value in attrs}, above, []))
        if tag not in VOID:
            self.open.append(len(self.elements) - 1)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        above = tuple(self.elements[i][0] for i in self.open)
        self.elements.append((tag, {name: value or "" for name, value in attrs}, above, []))

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            self.open.pop()

    def handle_data(self, data: str) -> None:
        for number in self.open:
            self.elements[number][3].append(data)

    def elements_with(self, name: str) -> list[tuple[str, dict[str, str], tuple[str, ...], list[str]]]:
        return [element for element in self.elements if name in element[1]]

    def named(self, *tags: str) -> list[tuple[str, dict[str, str], tuple[str, ...], str]]:
        return [(t, a, above, "".join(said).strip()) for t, a, above, said in self.elements if t in tags]


@pytest.fixture(scope="module", params=["run", "failed", "impact", "paper", "modes"])
def page(request, tmp_path_factory, outcome):
    place = tmp_path_factory.mktemp("pages") / "out"
    if request.param in ("run", "failed"):
        flutter = ("impact.friction=0.8", "corner.penalty_scale=3", "damping.kind=none")
        made = outcome("mash-tl4-sut", *(flutter if request.param == "failed" else ()))
        place.mkdir()
        write_page(place / "report.html", corner_report(made, pictures=False).page)
        return Tree((place / "report.html").read_text(encoding="utf-8"))
    commands = {
        "impact": ("run", "impact-mash-tl4-sut", "--no-pictures"),
        "paper": ("paper",),
        "modes": ("modes", "paper-table-3", "--count", "3"),
    }
    assert _status([*commands[request.param], "--quiet", "--out", str(place)]) == 0
    (path,) = place.glob("*.html")
    return Tree(path.read_text(encoding="utf-8"))


def test_landmarks_and_headings(page):
    for tag in ("header", "main", "footer", "h1", "title"):
        assert len(page.named(tag)) == 1, tag
    levels = [int(tag[1]) for tag, *_ in page.named("h1", "h2", "h3")]
    assert levels[0] == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    assert all(text for *_, text in page.named("h1", "h2", "h3", "summary", "a"))
    assert page.named("html")[0][1]["lang"] == "en"


def test_tables_have_captions_and_headings_scopes(page):
    tables = page.named("table")
    captions = page.named("caption")
    assert len(captions) == len(tables)
    assert all(text for *_, text in captions)
    for _, attributes, _, text in page.named("th"):
        assert attributes.get("scope") in ("row", "col", "colgroup")
        assert text, "an empty heading says nothing"


def test_what_scrolls_is_reached_by_keyboard_and_named_once(page):
    boxes = [attributes for _, attributes, *_ in page.named("div") if "scroll" in attributes.get("class", "")]
    assert len(boxes) >= len(page.named("table"))
    for attributes in boxes:
        assert (attributes["tabindex"], attributes["role"]) == ("0", "region")
    names = [attributes["aria-label"] for attributes in boxes]
    assert len(names) == len(set(names))
    assert all(above.count("div") for _, _, above, _ in page.named("table"))


def test_pictures_have_words(page):
    assert all(attributes.get("alt") for _, attributes, *_ in page.named("img"))
    drawings = page.named("svg")
    assert all(attributes["role"] == "img" and attributes["aria-label"] for _, attributes, *_ in drawings)
    assert len(page.named("figure")) == len(page.named("figcaption"))


def test_ids_are_unique_and_links_lead_somewhere(page):
    ids = [attributes["id"] for _, attributes, *_ in page.elements_with("id")]
    assert len(ids) == len(set(ids))
    targets = [attributes["href"][1:] for _, attributes, *_ in page.named("a")]
    assert set(targets) <= set(ids)


def test_without_scripts_all_is_there(page):
    """The script adds what the pointer shows, and nothing else: no element waits for it."""
    (script,) = page.named("script")
    assert script[2] == ("html", "body")
    assert not any("hidden" in attributes for _, attributes, *_ in page.elements)
    assert "style" not in {
        name for _, attributes, *_ in page.named("section", "div", "p") for name in attributes
    }


def test_every_colour_of_charts_has_one_in_the_dark():
    css = (TEMPLATES / "page.css").read_text(encoding="utf-8")
    dark = css[css.index("prefers-color-scheme: dark") : css.index("@media print")]
    assert set(PALETTE) == set(re.findall(r"svg \.(\w+) \{ color:", dark))
    for name, light in PALETTE.items():
        (other,) = re.findall(rf"svg \.{name} \{{ color: (#\w{{6}})", dark)
        assert (brightness(other) > 0.3) == (name != "grid"), name
        assert (brightness(light) < 0.3) == (name != "grid"), name


def brightness(colour: str) -> float:
    """Relative luminance by WCAG, its exponent rounded to two."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return 0.2126 * red**2 + 0.7152 * green**2 + 0.0722 * blue**2


def test_paper_cuts_no_column_and_leaves_no_heading_alone():
    css = (TEMPLATES / "page.css").read_text(encoding="utf-8")
    paper = css[css.index("@media print") :]
    for rule in (".scroll { overflow: visible; }", "white-space: normal", "size: A4"):
        assert rule in paper
    kept = ", ".join(re.findall(r"^  (.*) \{ break-after: avoid; \}", paper, re.MULTILINE))
    assert {"h2", "h3", "summary", "caption", "thead"} <= set(kept.split(", "))
    script = (TEMPLATES / "page.js").read_text(encoding="utf-8")
    assert "beforeprint" in script, "what is folded is printed"


def test_a_name_that_is_kept_whole_is(tmp_path):
    """TL-4 in the table of design forces."""
    table = Table(DESIGN, [{"name": "AASHTO LRFD, TL-4", "force": 240e3, "share": 2.0, "source": ""}])
    page = Page("", "x", "", (Section("Forces", tables=(table,)),), "")
    text = write_page(tmp_path / "p.html", page).read_text(encoding="utf-8")
    assert '<th scope="row" class="whole">AASHTO LRFD, <span class="whole">TL-4</span><' in text
    assert ".whole { white-space: nowrap; }" in text


def test_a_table_of_many_columns_is_set_smaller(tmp_path):
    """By their number, or by the letters of their headings."""
    tables = [text_table(*headings, rows=[["1"] * len(headings)]) for headings in (["a"] * 9, ["a"] * 10)]
    tables += [text_table(*["a" * n] * 4, rows=[["1"] * 4]) for n in (24, 25)]
    assert [table.is_wide for table in tables] == [False, True, False, True]
    page = Page("", "x", "", (Section("Tables", tables=tables),), "")
    assert write_page(tmp_path / "p.html", page).read_text().count('<table class="dense">') == 2


def test_a_legend_of_several_charts_has_a_row_of_its_own(tmp_path):
    """In narrow columns its letters would be smaller than those of the charts."""
    line = Line("", np.arange(2.0), np.arange(2.0))
    chart = draw_chart("b", "A chart", (Plot((line,), Axis("y")),), Axis("x"))
    charts = (draw_legend("a", "What colours mean", (Swatch("right", "green"),)), chart)
    page = Page("", "x", "", (Section("Charts", figures=charts, layout="narrow"),), "")
    text = write_page(tmp_path / "p.html", page).read_text(encoding="utf-8")
    assert text.count('<figure class="legend">') == 1
    assert ".legend { grid-column: 1 / -1; }" in text


def test_a_long_word_does_not_widen_the_page(tmp_path):
    text = write_page(tmp_path / "p.html", Page("", "x" * 200, "", (), "")).read_text()
    assert "overflow-wrap" in text
