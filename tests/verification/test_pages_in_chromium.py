"""Verification: small pages in Chromium: nothing is wrong on screens and on paper; and what is wrong is found."""

import importlib.util
import sys
from pathlib import Path

import pytest

from postprocess.report.page import write_page
from tailslap.case.corner.report import corner_report
from tailslap.cli import _status

BENCHMARKS = str(Path(__file__).parents[2] / "benchmarks")
sys.path.insert(0, BENCHMARKS)
from browser import charts, paper, screen  # noqa: E402
from browser.looked import look  # noqa: E402
from browser.session import CHROMIUM, chromium, opened  # noqa: E402

sys.path.remove(BENCHMARKS)

NEEDED = ("playwright", "axe_playwright_python", "pypdf")
MISSING = [name for name in NEEDED if importlib.util.find_spec(name) is None]
MISSING += [] if CHROMIUM.exists() else [str(CHROMIUM)]

LACK = f"pages are looked at with what is missing: {', '.join(MISSING)}"
pytestmark = pytest.mark.skipif(bool(MISSING), reason=LACK)

CHART = (
    '<figure><svg class="chart" viewBox="0 0 400 100" width="400" height="100" role="img" aria-label="a chart">'
    "{}</svg><figcaption>A chart</figcaption></figure>"
)


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A page with a table and charts."""
    place = tmp_path_factory.mktemp("pages") / "modes"
    assert _status(["modes", "paper-table-3", "--count", "3", "--quiet", "--out", str(place)]) == 0
    return place / "report.html"


def changed(page, place, old, new):
    """The page with another text in the place of one that it has."""
    text = page.read_text(encoding="utf-8")
    assert old in text
    place.write_text(text.replace(old, new, 1), encoding="utf-8")
    return place


def wrong(looked):
    return {kind: texts for kind, texts in looked.found.items() if texts}


def test_nothing_is_wrong_with_a_small_page(browser, page):
    assert wrong(look(browser, "modes", page, widths=(390,))) == {}


@pytest.mark.long
def test_nothing_is_wrong_with_the_page_of_a_run(browser, tmp_path, outcome):
    path = write_page(tmp_path / "report.html", corner_report(outcome("mash-tl4-sut"), pictures=False).page)
    assert wrong(look(browser, "run", path)) == {}


def test_what_is_wrong_on_a_screen_is_found(browser, page, tmp_path):
    """Without boxes that scroll a table sticks out; pale letters have too little contrast; TL-4 breaks."""
    css = ".scroll { overflow-x: visible !important; } .whole { white-space: normal !important; }"
    css += " table { min-width: 900px; } .kicker { color: #eee !important; }"
    narrow = '<p style="width: 1.5em">TL-4</p></main>'
    path = changed(page, tmp_path / "a.html", "</style>", f"{css}</style>")
    path = changed(path, tmp_path / "b.html", "</main>", narrow)
    with opened(browser, path, 390) as shown:
        assert any("<td>" in said for said in screen.outside(shown.page))
        assert any("color-contrast" in said for said in screen.violations(shown.page))
        assert "broken across lines: TL-4" in screen.broken(shown.page)


def test_a_cut_column_is_found_on_paper(browser, page, tmp_path):
    """A table that is wider than paper, its end cut off."""
    css = "@media print { .scroll { overflow: hidden !important; } table { width: 300% !important; } }"
    with opened(browser, changed(page, tmp_path / "a.html", "</style>", f"{css}</style>")) as shown:
        found = paper.missing(shown.page)
    assert any("not on paper, of table" in said for said in found)
    lost = changed(page, tmp_path / "b.html", "</h2>", "</h2><h3 hidden>A lost heading</h3>")
    with opened(browser, lost) as shown:
        assert paper.missing(shown.page) == ["not on paper: A lost heading"]


def test_words_of_charts_that_are_cut_or_overprinted_are_found(browser, page, tmp_path):
    words = '<text x="390" y="20">outside</text><text x="50" y="60">one</text><text x="55" y="62">two</text>'
    path = changed(page, tmp_path / "a.html", "</main>", CHART.format(words) + CHART.format("") + "</main>")
    with opened(browser, path, scripts=False) as shown:
        found = ['cut in "a chart": outside', 'overprinted in "a chart": one by two']
        assert (charts.words(shown.page), charts.empty(shown.page)) == (found, ["nothing drawn: A chart"])


def test_what_a_page_asks_for_and_complains_of_is_found(browser, page, tmp_path):
    """A picture from elsewhere, which the page's own policy refuses, and without that policy is asked for."""
    picture = '<img src="http://127.0.0.1:9/a.png" alt="a picture">'
    path = changed(page, tmp_path / "a.html", "</main>", f"{picture}</main>")
    with opened(browser, path) as shown:
        assert any("Content Security Policy" in said for said in shown.errors)
    with opened(browser, changed(path, tmp_path / "b.html", "img-src data:;", "img-src *;")) as shown:
        assert shown.requests == ["http://127.0.0.1:9/a.png"]
