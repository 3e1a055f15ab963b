"""Verification: a table declared once is shown alike everywhere; a page is well formed, whole, and fetches nothing."""

import base64
import csv
import hashlib
import html
import math
import re
import tomllib
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from postprocess.report.page import (
    NO_BREAK,
    Page,
    Picture,
    Section,
    glued,
    printed_numbers,
    prose,
    write_page,
)
from postprocess.report.report import Report, report_text, write_report
from postprocess.report.table import Column, Table, pairs
from postprocess.svg.chart import Chart
from postprocess.units import duration, grouped, number, shown
from tailslap.case.checks import advice
from tailslap.case.corner.checks import CHECKS
from tailslap.case.corner.report import corner_report
from tailslap.case.corner.text import diagnosis, prediction

VOID = {"meta", "img", "br", "link", "hr", "input"}
SCENE = 'name = "a<b>&c"  # </pre><script>alert(1)</script>\nwidth = "2438 mm"\n'


class Parsed(HTMLParser):
    """Text by paragraph-like piece, attributes of every element, and whether elements nest."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.pieces: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.tags: set[str] = set()
        self.verbatim = self.script = ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.pieces.append(data)
        if self.open and self.open[-1] == "pre":
            self.verbatim += data
        if self.open and self.open[-1] == "script":
            self.script += data

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.pieces).split())


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


def full_page(folder: Path) -> Page:
    picture = folder / "contour_v_gx.png"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)))
    curve = Chart("omega", "Motion", "Angular velocity", '<svg viewBox="0 0 1 1"><text>curve-1</text></svg>')
    sections = (
        Section("Tables", "A lead.", tables=(TABLE, pairs({"mass": 9979.0}), Table(COLUMNS, ()))),
        Section("Figures. By matplotlib", figures=(curve, Picture(picture, "v_GX at the strike"))),
        Section("Sentences", sentences=("N < 0 pulls, `corner.friction` holds.",)),
        Section("Empty", tables=(Table(COLUMNS, ()),)),
    )
    return Page("A kicker", "mash<tl4>", "The headline.", sections, "The footer.", SCENE, True, contents=True)


@pytest.fixture
def page(tmp_path):
    return Parsed(write_page(tmp_path / "report.html", full_page(tmp_path)).read_text(encoding="utf-8"))


def test_every_number_and_word_is_there(page):
    said = ["A kicker", "mash<tl4>", "The headline.", "A lead.", "A table", "measured", "Size [m]", "0.333"]
    said += ["along <the> wall", "not a number", "A note.", "mass", "9979", "curve-1", "Angular velocity"]
    said += ["N < 0 pulls", "The footer."]
    assert [piece for piece in said if piece not in page.text] == []
    assert page.pieces.count("passed") == 2
    assert page.pieces.count("failed") == 1
    assert ("tr", "class", "failed") in page.attributes


def test_symbols_and_keys_are_typeset(page):
    assert "GX" in page.pieces
    assert {"sub", "code", "nav"} <= page.tags
    assert "v_GX" not in page.text


def test_what_is_empty_is_not_shown(page):
    assert "Empty" not in page.text
    assert [value for tag, _, value in page.attributes if tag == "a"] == ["#part-1", "#part-2", "#part-3"]


def test_the_scene_is_shown_verbatim_and_cannot_become_markup(page):
    assert SCENE in page.verbatim
    (policy,) = [
        value for tag, name, value in page.attributes if (tag, name) == ("meta", "content") and "src" in value
    ]
    digest = base64.b64encode(hashlib.sha256(page.script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy, "the page's own script, and no other"
    assert "alert" not in page.script


def test_nothing_is_fetched(page):
    links = [
        value
        for _, name, value in page.attributes
        if name in ("src", "href", "xlink:href", "srcset", "action")
    ]
    assert links
    assert all(link.startswith(("data:image/png;base64,", "#")) for link in links)
    assert not {"link", "iframe", "object"} & page.tags
    assert not re.search(r"fetch|import|XMLHttp|https?:(?!//www.w3.org/2000/svg)", page.script)
    assert "@import" not in page.text
    assert "url(" not in page.text


def test_the_picture_is_in_the_page_whole(page, tmp_path):
    (source,) = [value for tag, name, value in page.attributes if (tag, name) == ("img", "src")]
    assert base64.b64decode(source.partition(",")[2]) == (tmp_path / "contour_v_gx.png").read_bytes()


def test_a_missing_picture_is_an_error(tmp_path):
    missing = Section("Pictures", figures=(Picture(tmp_path / "none.png", ""),))
    with pytest.raises(FileNotFoundError):
        write_page(tmp_path / "report.html", Page("", "s", "", (missing,), ""))
    assert not (tmp_path / "report.html").exists()


def test_a_table_is_the_same_on_the_terminal_and_in_files(tmp_path):
    """Files hold the values themselves, terminal and page what people read of them."""
    report = Report(full_page(tmp_path), {"a": math.inf}, (TABLE, "A sentence."), {"table.csv": TABLE})
    write_report(report, tmp_path)
    with (tmp_path / "table.csv").open() as file:
        first, second = csv.DictReader(file)
    assert float(first["size"]) == 1.0 / 3.0
    assert (first["inner.words"], second["good"]) == ("along <the> wall", "False")
    assert (tmp_path / "summary.json").read_text() == '{\n  "a": null\n}\n'
    said = report_text(report, tmp_path)
    for piece in ("A table", "measured", "Size", "[m]", "0.333", "not a number", "A note.", "A sentence."):
        assert piece in said
    assert said.endswith(f"Report: {tmp_path / 'report.html'}")


def test_a_record_without_the_entry_is_an_error():
    with pytest.raises(AttributeError):
        Table((Column("nothing", ""),), RECORDS).records()


def run_page(made: Any, folder: Path) -> Parsed:
    report = corner_report(made, pictures=False)
    write_report(report, folder)
    return Parsed((folder / "report.html").read_text(encoding="utf-8"))


def test_the_headline_of_a_run_names_the_largest_difference(outcome, tmp_path):
    made = outcome("paper-table-3")
    page = run_page(made, tmp_path)
    assert printed_numbers(f"confirmed to {max(map(abs, made.difference.values())):.1e};") in page.text
    assert "Failed" not in page.text
    for check in made.checks:
        assert check.name in page.text
    for value in (*made.fe.values(), *made.rigid.values()):
        assert shown(value, "#.5g").replace("-", "−") in page.text
    for printed in (
        "0.383",
        "23.27",
        "−3.274",
        "23.305",
        "−3.289",
        "8.915",
        "Infrastructures 2025, 10(11), 307",
    ):
        assert printed in page.text


def test_a_failed_run_says_so(outcome, tmp_path):
    made = outcome("mash-tl4-sut", "impact.speed=20 m/s")
    first, *others = made.checks
    broken = replace(first, passed=False, value=math.nan)
    difference = dict.fromkeys(made.difference, math.nan)
    page = run_page(replace(made, checks=(broken, *others), difference=difference), tmp_path)
    assert page.pieces.count("failed") == 2
    assert page.pieces.count("passed") == len(others)
    assert f"Failed: {first.name}." in page.text
    assert "Failed checks, and what to do" in page.text
    for said in (*advice(CHECKS, [first.name]).split("; "), *diagnosis(made)):
        assert re.sub("<[^>]+>", "", html.unescape(str(prose(said)))).replace(NO_BREAK, " ") in page.text
    assert "not a number" in page.text
    assert "Paper, ABAQUS" not in page.text


def test_the_terminal_tells_once_what_was_chosen(outcome):
    made = outcome("mash-tl4-sut", "impact.speed=20 m/s", "plate.start=unstressed")
    shown_ones = [decision.shown for decision in made.fe_plan.decisions]
    failed = replace(made.checks[0], passed=False)
    said = corner_report(replace(made, checks=(failed, *made.checks[1:])), pictures=False).terminal
    text = "\n".join(line for line in said if isinstance(line, str))
    assert [text.count(each) for each in shown_ones] == [1] * len(shown_ones) != []
    assert prediction(made) in text


def whole(name: str) -> str:
    return f'<span class="whole">{name}</span>'


def test_a_unit_in_brackets_stays_in_one_piece():
    assert glued("peak impulse [10⁻³ kN s] of it") == "peak impulse [10⁻³\xa0kN\xa0s] of it"


def test_zero_has_no_sign():
    assert (shown(-0.0, ".3g"), shown(-0.0, "+.1f"), number(-0.0)) == ("0", "+0.0", "0")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("confirmed to 2.2e-06", "confirmed to 2.2×10⁻⁶"),
        ("at most 1e-03, 1.0e+00, 0.0e+00", "at most 10⁻³, 1.0, 0"),
        ("-3.27 m/s, +5.1e-04", "−3.27 m/s, +5.1×10⁻⁴"),
        ("at least 1.18e+01, 5.30e-01, 2e+02", "at least 11.8, 0.530, 200"),
        ("TL-4, -2, a-b", f"{whole('TL-4')}, −2, a-b"),
        ('= "quad4-reduced"', f"= &#34;{whole('quad4-reduced')}&#34;"),
        ("quad4-reduced: 4", f"{whole('quad4-reduced')}: 4"),
        ("2025-10-11, CFC-180", f"{whole('2025-10-11')}, {whole('CFC-180')}"),
        ("omega and mu |N|, start.omega", "ω and μ |N|, start.omega"),
        ("2 MN/m^2, exp(-3)", "2 MN/m², exp(−3)"),
        ("from v_GX", "from <i>v</i><sub>GX</sub>"),
        ("`omega = -1e-06`", "<code>omega = -1e-06</code>"),
    ],
)
def test_numbers_are_set_as_in_print(text, expected):
    assert str(prose(text)).replace(NO_BREAK, " ") == expected


def test_the_answer_comes_first_and_detail_is_folded(outcome, tmp_path):
    """Forces, design forces and the five quantities before all else; no more than 60 numbers are in the open."""
    made = outcome("mash-tl4-sut", "impact.speed=20 m/s")
    report = corner_report(made, pictures=False)
    titles = [section.title for section in report.page.sections if not section.is_empty]
    assert titles[:2] == ["Peak lateral force", "At the tail-slap"]
    force = made.fe_plan.case.force.peak_force
    assert f"{force / 1e3:#.4g}" in report.page.sections[0].tables[0].columns[2].text({"rigid": force})
    assert report.page.sections[0].tables[1].rows[0]["name"] == "AASHTO LRFD, TL-4"
    assert str(report.terminal[0]).startswith("mash-tl4-sut: The rigid motion is confirmed to")
    opened = [section for section in report.page.sections if not section.is_folded]
    cells = [c.text(r) for s in opened for t in s.tables for r in t.rows for c in t.columns if c.form]
    assert 15 <= len(cells) <= 60
    write_report(report, tmp_path)
    assert (tmp_path / "report.html").read_text().count("<details>") >= 6


def test_the_page_shows_the_scene_as_it_was_run(outcome):
    text = corner_report(outcome("mash-tl4-sut", "impact.speed=20 m/s"), pictures=False).page.scene_text
    given = tomllib.loads(text)
    assert given["impact"]["speed"] == "20 m/s"
    assert "56 mph" not in text
    assert given["vehicle"] == {"length": "10 m", "width": "2438 mm", "mass": "9979 kg"}
    assert "changed: impact.speed" in text


def test_a_run_without_a_strike(outcome, tmp_path):
    made = replace(outcome("mash-tl4-sut"), fe={}, difference={}, metrics={})
    page = run_page(made, tmp_path)
    assert "did not reach the tail-slap" in page.text
    for heading in ("FE histories against", "The plate at the tail-slap"):
        assert heading not in page.text


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (number(0.1), "0.1"),
        (number(7421), "7421"),
        (number(True), "yes"),
        (number(None), "–"),
        (number("20 x 6"), "20 x 6"),
        (number(2.0e11), "2e+11"),
        (number(math.inf), "infinite"),
        (number(-math.inf), "-infinite"),
        (shown(0.1, "#.8g"), "0.10000000"),
        (shown(-3.0, "#.8g"), "-3.0000000"),
        (shown(-1.234e-6, "+.2e"), "-1.23e-06"),
        (shown(math.nan, "+.2e"), "not a number"),
        (shown(None, ".3g"), "–"),
        (grouped(1234567), "1 234 567"),
        (duration(3.2e-5), "32 us"),
        (duration(0.01234), "12.3 ms"),
        (duration(12.345), "12.3 s"),
    ],
)
def test_numbers_as_printed(said, expected):
    assert said == expected


@pytest.mark.parametrize(
    ("written", "printed"),
    [
        ("+1.32e-01", "+0.132"),
        ("-4.25e-01", "−0.425"),
        ("9.25e-01", "0.925"),
        ("+3.59e-02", "+3.59×10⁻²"),
        ("1e-3", "10⁻³"),
        ("+0.0e+00", "0"),
    ],
)
def test_numbers_in_print_keep_their_sign(written, printed):
    assert printed_numbers(written) == printed
