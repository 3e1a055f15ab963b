"""Verification: the report is one well-formed page that holds every number and fetches nothing."""

import base64
import math
from html.parser import HTMLParser
from pathlib import Path

import pytest

from postprocess.comparison.comparison import comparison_rows
from postprocess.comparison.metrics import Metrics
from postprocess.figures.style import Curve
from postprocess.pages.pages import number, padded, signed
from postprocess.pages.report import (
    Check,
    LeftOut,
    Picture,
    ReportContent,
    Result,
    SceneInput,
    verdict,
    write_report,
)

pytestmark = pytest.mark.verification

VOID = {"meta", "img", "br", "link", "hr", "input"}
SCENE = 'name = "a<b>&c"  # </pre><script>alert(1)</script>\nwidth = "2438 mm"\n'
FE = {"t": 0.38396012, "v_gx": 23.273345, "v_gy": -3.2755311, "omega": 0.65510521, "slide": 9.4236911}
RIGID = {"t": 0.38395974, "v_gx": 23.273331, "v_gy": -3.2755267, "omega": 0.65510534, "slide": 9.4236754}


class Page(HTMLParser):
    """Text by paragraph-like piece, attributes of every element, and whether elements nest."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.pieces: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.tags: set[str] = set()
        self.verbatim = ""
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

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.pieces).split())


def full_content(folder: Path) -> ReportContent:
    picture = folder / "contour_v_gx.png"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)))
    return ReportContent(
        scene="mash<tl4>",
        version="0.1.0",
        passed=True,
        comparison=comparison_rows(FE, RIGID),
        statements=("Reaction model drag: N < 0 pulls.", "Newton's convention would give 1.106 rad/s."),
        checks=(Check("energy balance", 3.25e-9, 0.01, True, "nothing is unaccounted for"),),
        metrics={"v_gy": Metrics(-2.28e-6, 1.15e-8, 3.34e-6, -5.26e-6, 1.97e-7)},
        stage1=(Result("Angular velocity", 0.7071234, "rad/s", "replaced by [start]"),),
        stage3=(Result("Peak force", 653734.5, "N"),),
        curves=(
            Curve("omega", "Motion", "Angular velocity", '<svg viewBox="0 0 1 1"><text>curve-1</text></svg>'),
            Curve("error", "Energy", "Ledger", '<svg viewBox="0 0 1 1"><text>curve-2</text></svg>'),
        ),
        pictures=(Picture(picture, "v_GX at the strike"),),
        cost=(Result("Steps", 7421), Result("Time loop", 0.0681, "s")),
        left_out=(LeftOut("damping", "the scene has no [damping] table"),),
        inputs=(
            SceneInput("vehicle.width", "96 in", 2.438, "m"),
            SceneInput("corner.friction", "", 0.47, "", "impact"),
        ),
        scene_text=SCENE,
    )


@pytest.fixture
def page(tmp_path: Path) -> Page:
    return Page(write_report(tmp_path / "report.html", full_content(tmp_path)).read_text(encoding="utf-8"))


def test_every_number_and_word_is_there(page: Page) -> None:
    numbers = [padded(value) for value in (*FE.values(), *RIGID.values())]
    numbers += [signed(FE[key] / RIGID[key] - 1.0) for key in FE]
    numbers += ["0.383", "23.27", "-3.274", "0.65", "9.42", "0.37", "23.305", "-3.289", "0.66", "8.915"]
    numbers += ["3.25e-09", "0.01", "0.7071234", "653734.5", "7421", "0.0681", "2.438", "0.47"]
    numbers += ["-2.28e-06", "1.15e-08", "3.34e-06", "-5.26e-06", "1.97e-07"]
    words = [
        "Sprague and Geers",
        "mash<tl4>",
        "passed",
        "N < 0 pulls",
        "Newton's convention",
        "nothing is unaccounted for",
        "tailslap 0.1.0",
    ]
    words += ["replaced by [start]", "curve-1", "curve-2", "Motion", "Energy", "v_GX at the strike", "Ledger"]
    words += [
        "the scene has no [damping] table",
        "vehicle.width",
        "96 in",
        "Infrastructures 2025, 10(11), 307",
    ]
    missing = [piece for piece in (*numbers, *words) if piece not in page.text]
    assert missing == []


def test_the_scene_is_shown_verbatim_and_cannot_become_markup(page: Page) -> None:
    assert page.verbatim == SCENE
    assert "script" not in page.tags


def test_nothing_is_fetched(page: Page) -> None:
    links = [
        value
        for _, name, value in page.attributes
        if name in ("src", "href", "xlink:href", "srcset", "action")
    ]
    assert links
    assert all(link.startswith(("data:image/png;base64,", "#")) for link in links)
    assert not {"script", "link", "iframe", "object"} & page.tags
    assert "@import" not in page.text
    assert "url(" not in page.text


def test_the_picture_is_in_the_page_whole(page: Page, tmp_path: Path) -> None:
    (source,) = [value for tag, name, value in page.attributes if (tag, name) == ("img", "src")]
    assert base64.b64decode(source.partition(",")[2]) == (tmp_path / "contour_v_gx.png").read_bytes()


def test_headline_names_the_largest_difference(tmp_path: Path) -> None:
    content = full_content(tmp_path)
    largest = max(abs(row.difference) for row in content.comparison)
    assert f"at most {largest:.1e} " in verdict(content)
    assert "Failed" not in verdict(content)


def test_a_failed_run_says_so(tmp_path: Path) -> None:
    checks = (Check("energy balance", math.nan, 0.01, False), Check("ripple", 0.1, 0.2, True))
    content = ReportContent(
        "s", "0.1.0", False, comparison_rows({"t": math.nan}, {"t": 1.0}, None, ("t",)), checks=checks
    )
    page = Page(write_report(tmp_path / "report.html", content).read_text(encoding="utf-8"))
    assert page.pieces.count("failed") == 2
    assert page.pieces.count("passed") == 1
    assert "Failed: energy balance. At the tail-slap" in page.text
    assert "without bound" in page.text
    assert "not a number" in page.text
    assert "Paper" not in page.text


def test_a_run_without_a_strike_and_without_parts(tmp_path: Path) -> None:
    page = Page(
        write_report(tmp_path / "report.html", ReportContent("s", "0.1.0", False)).read_text(encoding="utf-8")
    )
    assert "did not reach the tail-slap" in page.text
    for heading in ("Checks", "FE histories", "Stage 1", "Inputs", "Cost", "Motion"):
        assert heading not in page.text
    assert "Left out Nothing." in page.text


def test_a_missing_picture_is_an_error(tmp_path: Path) -> None:
    content = ReportContent("s", "0.1.0", True, pictures=(Picture(tmp_path / "none.png", ""),))
    with pytest.raises(FileNotFoundError):
        write_report(tmp_path / "report.html", content)
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize(
    ("shown", "expected"),
    [
        (number(0.1), "0.1"),
        (number(7421), "7421"),
        (number(True), "yes"),
        (number(None), "–"),
        (number("20 x 6"), "20 x 6"),
        (number(2.0e11), "2e+11"),
        (number(math.inf), "infinite"),
        (padded(0.1), "0.10000000"),
        (padded(-3.0), "-3.0000000"),
        (signed(-1.234e-6), "-1.23e-06"),
        (signed(0.0), "+0.00e+00"),
        (signed(math.nan), "not a number"),
    ],
)
def test_numbers_as_printed(shown: str, expected: str) -> None:
    assert shown == expected
