"""Verify pages in Chromium on screens and paper."""

import csv
from xml.etree import ElementTree

import numpy as np
import pytest
from browser import charts, inspection, paper, screen
from browser.pages import written
from browser.session import opened

from postprocess.figures.impact import Forces, StrikeMark, draw_forces
from postprocess.figures.positions import draw_positions, vehicle_outlines
from postprocess.figures.studies import SweepAxis, SweepLine, draw_sensitivity, draw_sweep
from postprocess.report.page import Headline, Page, Section, write_page
from postprocess.svg.chart import FULL, Axis, Chart, Plot
from postprocess.svg.marks import Line, Words, line_style
from tailslap.case.corner.corner_report import CornerReport
from tailslap.case.report_parts import design_forces_of
from tailslap.cli import _status
from tailslap.scene.read import read_scene

CHART = (
    '<figure><svg class="chart" viewBox="0 0 400 100" width="400" height="100" role="img" aria-label="a chart">'
    "{}</svg><figcaption>A chart</figcaption></figure>"
)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A page with a table and charts."""
    place = tmp_path_factory.mktemp("pages") / "modes"
    assert _status(["modes", "paper-table-3", "--count", "3", "--quiet", "--out", str(place)]) == 0
    return place / "report.html"


def changed(page, place, old, new):
    """The page with one text replaced by another."""
    text = page.read_text(encoding="utf-8")
    assert old in text
    place.write_text(text.replace(old, new, 1), encoding="utf-8")
    return place


def test_nothing_is_wrong_with_a_small_page(browser, page):
    assert inspection.faults(browser, page, widths=(390,)) == {}


@pytest.mark.long
def test_nothing_is_wrong_with_the_page_of_a_run(browser, tmp_path, outcome):
    path = write_page(tmp_path / "report.html", CornerReport(outcome("mash-tl4-sut")).page(pictures=False))
    assert inspection.faults(browser, path) == {}


def test_the_switch_changes_units_and_tables_are_copied_as_shown(browser, tmp_path, outcome):
    report_page = CornerReport(outcome("mash-tl4-sut", "impact.speed=20 m/s")).page(pictures=False)
    with opened(browser, write_page(tmp_path / "p.html", report_page)) as session:
        page = session.page
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])

        def copied(form):
            page.locator(".copy").first.get_by_role("button", name=form).click()
            return page.evaluate("navigator.clipboard.readText()")

        headline = page.locator(".headline")
        assert "kN" in headline.inner_text()
        heading, first, *_ = list(csv.reader(copied("CSV").splitlines()))
        assert heading[1] == "By FE [kN]"
        page.get_by_role("radio", name="US").check()
        assert "kN" not in headline.inner_text()
        in_kip = copied("text").split("\n")[1].split("\t")
        assert float(in_kip[1]) == pytest.approx(float(first[1]) / 4.4482216, rel=1e-3)
        rows = copied("LaTeX").splitlines()
        assert (rows[0], rows[-1]) == (r"\begin{tabular}{lrr}", r"\end{tabular}")
        assert rows[1].endswith(r"& By FE [kip] & By rigid body [kip] \\")
        drawn = page.locator("svg.chart text:visible").all_text_contents()
        assert [text for text in drawn if "kip" in text]
        assert not [text for text in drawn if "kN" in text]
        page.get_by_role("radio", name="SI").check()
        drawn = page.locator("svg.chart text:visible").all_text_contents()
        assert [text for text in drawn if "kN" in text]
        assert not [text for text in drawn if "kip" in text]
        assert not session.errors


@pytest.mark.parametrize("link", ["nav a >> nth=1", "text=A lead."])
def test_links_of_contents_and_band_open_the_folded_section(browser, tmp_path, link):
    folded = Section("Folded", "A lead.", is_folded=True, is_of_band=True)
    headline = Headline("Links", "", band="A band.")
    report_page = Page("", headline, (Section("Open", "A part."), folded), "", contents=True)
    with opened(browser, write_page(tmp_path / "p.html", report_page)) as session:
        details = session.page.locator("details")
        details.evaluate("details => (details.open = false)")
        session.page.locator("header").locator(link).click()
        assert details.evaluate("details => details.open")


CURVES = {"slow": 2.0 * np.arange(41.0), "fast": 5.0 * np.arange(41.0)}


@pytest.fixture
def shown_chart(browser, tmp_path):
    """A page with a chart of two lines over 40 s."""
    t = np.arange(41.0)
    lines = tuple(Line(label, t, force, **line_style(k)) for k, (label, force) in enumerate(CURVES.items()))
    chart = Chart("c", "A chart", (Plot(lines, Axis("force [kN]")),), Axis("t [s]", margin=0.0), width=FULL)
    with opened(browser, written(tmp_path, chart)) as session:
        yield session.page
        assert (session.errors, session.requests) == ([], [])


def ticks_of(page, axis):
    texts = page.locator(f"svg.chart {axis} .ticks text:visible").all_text_contents()
    return [float(text.replace("−", "-")) for text in texts]


def frame_of(page):
    box = page.locator("svg.chart .frame").bounding_box()
    return box["x"], box["y"], box["width"], box["height"]


def test_the_pointer_names_quantity_and_unit_and_covers_no_line(shown_chart):
    x, y, width, height = frame_of(shown_chart)
    shown_chart.mouse.move(x + 0.5 * width, y + 0.5 * height)
    note = shown_chart.locator("output.values")
    assert note.inner_text().split("\n") == ["t 20 s", "force", "● slow 40 kN", "● fast 100 kN"]
    assert note.bounding_box()["y"] >= y + height
    colours = note.locator("b").evaluate_all("dots => dots.map((dot) => getComputedStyle(dot).color)")
    strokes = "lines => lines.map((line) => getComputedStyle(line).stroke)"
    assert colours[2:] == shown_chart.locator("svg.chart .marks path").evaluate_all(strokes)


def test_a_drag_zooms_both_axes_and_a_double_click_resets(shown_chart):
    """A quarter of each axis is shown."""
    x, y, width, height = frame_of(shown_chart)
    low, *_, high = shown_chart.locator("svg.chart .si .y-axis").get_attribute("data-ends").split()
    shown_chart.mouse.move(x + 0.25 * width, y + 0.5 * height)
    shown_chart.mouse.down()
    shown_chart.mouse.move(x + 0.5 * width, y + 0.75 * height, steps=4)
    shown_chart.mouse.up()
    along, up = ticks_of(shown_chart, ".x-axis"), ticks_of(shown_chart, ".plot")
    assert (along[0], along[-1]) == (pytest.approx(10.0, abs=1.0), pytest.approx(20.0, abs=1.0))
    span = float(high) - float(low)
    assert float(low) + 0.25 * span - 0.1 < min(up) < max(up) < float(low) + 0.5 * span + 0.1
    assert "polygon" in shown_chart.locator("svg.chart .marks").get_attribute("style")
    shown_chart.mouse.dblclick(x + 0.5 * width, y + 0.5 * height)
    assert (ticks_of(shown_chart, ".x-axis")[0], ticks_of(shown_chart, ".x-axis")[-1]) == (0.0, 40.0)


def test_a_key_hides_its_line(shown_chart):
    key = shown_chart.get_by_role("button", name="slow")
    key.press("Enter")
    assert key.get_attribute("aria-pressed") == "false"
    x, y, width, height = frame_of(shown_chart)
    shown_chart.mouse.move(x + 0.5 * width, y + 0.5 * height)
    assert "slow" not in shown_chart.locator("output.values").inner_text()
    key.click()
    assert key.get_attribute("aria-pressed") == "true"


def test_arrow_keys_read_the_samples_aloud(shown_chart):
    shown_chart.locator("svg.chart").focus()
    note, readings = shown_chart.locator("output.values"), []
    for key in ("ArrowRight", "ArrowRight", "ArrowDown", "End", "Home", "Escape"):
        shown_chart.keyboard.press(key)
        readings.append(" ".join(note.inner_text().split("\n")[::2]) if note.is_visible() else "")
    assert readings == [
        *("t 0 s ● slow 0 kN", "t 1 s ● slow 2 kN", "t 1 s ● fast 5 kN"),
        *("t 40 s ● fast 200 kN", "t 0 s ● fast 0 kN", ""),
    ]
    assert note.get_attribute("aria-live") == "polite"


def moving():
    """Times and outlines of a vehicle that rotates along the wall."""
    t, x = np.linspace(0.0, 0.5, 20), np.linspace(0.0, 4.0, 20)
    return t, vehicle_outlines(x, 1.2 + 0.0 * x, 0.3 - 0.6 * t, 8.0, 2.0, 4.0)


RIGHT_AND_SIZE = "mark => ((box) => [box.right, box.width / box.height])(mark.getBoundingClientRect())"


def test_motion_fits_a_narrow_window_and_runs_with_the_cursor(browser, tmp_path):
    """Motion has equal scales, and its polygon ends with the last outline.

    No word covers another, and buttons are at least 24 px high.
    """
    t, every = moving()
    strikes = (StrikeMark("front", 0.0, 0.1, (0.0, 2.0)), StrikeMark("rear", 0.2, 0.3, (1.0, 3.0)))
    rows = [0, 4, 8, 12, 16, 19]
    drawn = draw_positions(every[rows], t[rows].tolist(), strikes, motion=(t, every))
    curves = {"raw": 1e3 * t, "cfc60": 2e3 * t, "mean_50ms": t}
    figures = drawn, draw_forces("Force", [Forces("force", t, curves)], motion=t)
    with opened(browser, written(tmp_path, *figures), 390) as narrow:
        page = narrow.page
        starts = page.evaluate("document.getAnimations().map((each) => each.startTime)")
        assert len(starts) == 2
        assert starts[0] == starts[1]
        assert page.locator("svg.chart").first.bounding_box()["width"] <= 358
        page.emulate_media(reduced_motion="reduce")
        end, ratio = page.locator("[data-label='0.50 s']").evaluate(RIGHT_AND_SIZE)
        assert ratio == pytest.approx(np.divide(*np.ptp(every[-1], axis=0)), rel=0.05)
        assert page.locator(".moving").first.evaluate(RIGHT_AND_SIZE)[0] == pytest.approx(end, abs=1.5)
        assert charts.words(page) == []
        assert page.get_by_role("button", name="CFC 60").get_attribute("aria-pressed") == "false"
        heights = page.locator(".keys button").evaluate_all("all => all.map((each) => each.offsetHeight)")
        assert min(heights) >= 24


def test_motion_is_paused_and_is_not_where_the_reader_prefers_none(browser, tmp_path):
    """A box to tick, and the preference of the reader."""
    t, every = moving()
    chart = draw_positions(every[[0, -1]], t[[0, -1]].tolist(), motion=(t, every))
    states = "animations => document.getAnimations().map((each) => each.playState)"
    with opened(browser, written(tmp_path, chart), scripts=False) as session:
        assert session.page.evaluate(states) == ["running"]
        session.page.get_by_label("Pause the motion").check()
        assert session.page.evaluate(states) == ["paused"]
        session.page.emulate_media(reduced_motion="reduce")
        assert session.page.evaluate(states) == []


def test_table_and_drawing_are_kept(shown_chart, tmp_path):
    """The table is in its link, and the drawing as displayed."""
    for kind in ("csv", "svg"):
        with shown_chart.expect_download() as download:
            shown_chart.locator(f"a[download='c.{kind}']").click()
        download.value.save_as(tmp_path / f"c.{kind}")
    heading, *rows = csv.reader((tmp_path / "c.csv").read_text(encoding="utf-8").splitlines())
    assert heading == ["t [s]", "slow: force [kN]", "fast: force [kN]"]
    assert rows[7] == ["7", "14", "35"]
    drawn = ElementTree.parse(tmp_path / "c.svg").getroot()
    assert drawn.get("viewBox", "").split()[:3] == ["0", "0", f"{FULL:g}"]


def test_a_narrow_window_has_a_narrow_chart_with_letters_as_large(shown_chart):
    shown_chart.set_viewport_size({"width": 390, "height": 800})
    shown_chart.wait_for_function("document.querySelector('svg.chart').getBoundingClientRect().width < 370")
    size = "text => parseFloat(getComputedStyle(text).fontSize) * text.ownerSVGElement.getScreenCTM().a"
    assert min(shown_chart.locator("svg.chart text").evaluate_all(f"texts => texts.map({size})")) >= 9.0
    assert ticks_of(shown_chart, ".x-axis") == [0.0, 10.0, 20.0, 30.0, 40.0]


def test_a_chart_is_as_wide_as_the_paper_and_then_as_its_window(shown_chart):
    wide = shown_chart.locator("svg.chart").get_attribute("width")
    shown_chart.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert shown_chart.locator("svg.chart").get_attribute("width") == "700"
    shown_chart.evaluate("dispatchEvent(new Event('afterprint'))")
    shown_chart.wait_for_function(
        "wide => document.querySelector('svg.chart').getAttribute('width') === wide", arg=wide
    )


def test_words_return_when_a_window_is_wide_again(browser, tmp_path):
    """A hidden page is not fitted."""
    names = [Words(f"position {number}", float(number), 1.0) for number in range(8)]
    line = Line("FE", np.array([0.0, 9.0]), np.array([0.0, 2.0]))
    chart = Chart("c", "A chart", (Plot((line, *names)),), Axis("t [s]"), width=FULL)
    with opened(browser, written(tmp_path, chart)) as session:
        for width, state in ((390, "attached"), (1280, "detached")):
            session.page.set_viewport_size({"width": width, "height": 800})
            session.page.locator(".marks text[style*='none']").first.wait_for(state=state)
        drawn = session.page.locator("svg.chart").get_attribute("width")
        session.page.evaluate("document.querySelector('main').style.display = 'none'")
        session.page.evaluate(
            "() => new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next)))"
        )
        assert session.page.locator("svg.chart").get_attribute("width") == drawn


def test_a_plot_beside_long_names_is_seen_in_a_narrow_window(browser, tmp_path):
    """Long names leave 80 pixels to the plot."""
    rows = [
        {"key": f"{name} of an axle of the third trailer", "total": 0.5}
        | {"first_order": 0.4, "total_interval": (0.3, 0.7), "first_order_interval": (0.2, 0.6)}
        for name in ("friction", "cornering coefficient")
    ]
    with opened(browser, written(tmp_path, draw_sensitivity(rows)), 390) as narrow:
        page = narrow.page
        svg, frame = (page.locator(part).first.bounding_box() for part in ("svg.chart", "svg.chart .frame"))
        assert svg["width"] <= 358
        assert frame["width"] >= 80
        assert screen.outside(page) == []


def test_names_on_a_chart_cover_none_in_narrow_windows_and_on_paper(browser, tmp_path):
    """Failed plates at the end where levels have their names."""
    frequencies, sizes = np.geomspace(84.0, 2.0, 12), np.geomspace(0.002, 0.3, 12)
    passed = [number % 5 > 0 for number in range(12)]
    line, axes = (
        SweepLine("impulse", sizes.tolist()),
        [SweepAxis(frequencies.tolist(), runs, at) for runs in (passed, passed[::-1]) for at in (2.2, 20.0)],
    )
    drawn = [
        draw_sweep(f"s{k}", axis, [line], "size", f"Chart {k}", (0.25, 0.1, 0.01))
        for k, axis in enumerate(axes)
    ]
    path = written(tmp_path, *drawn)
    for width, is_paper in ((1280, False), (390, False), (paper.PAPER_WIDTH, True)):
        with opened(browser, path, width, is_paper=is_paper) as session:
            assert charts.words(session.page) == []
            assert session.page.locator(".marks text:visible", has_text="failed").count() == len(drawn)
            names = session.page.locator(".beside text:visible").all_text_contents()
            assert sorted(names) == sorted(["25 %", "10 %", "1 %"] * len(drawn))


@pytest.mark.parametrize("width", [1280, 390])
def test_all_design_loads_of_a_train_have_names(browser, tmp_path, width):
    """Three of them are within 20 pixels of each other."""
    t = np.linspace(0.0, 1.0, 101)
    loads = {
        name: load.force
        for name, load in design_forces_of(read_scene("impact-mash-tl5-tractor-van")[0]).items()
    }
    strikes = [StrikeMark("trailer front", 0.2, 0.3), StrikeMark("rear", 0.25, 0.3)]
    drawn = draw_forces("Force", [Forces("force", t, {"raw": 1.2e6 * np.sin(3.0 * t)})], strikes, loads)
    with opened(browser, written(tmp_path, drawn, layout="tall"), width) as session:
        names = session.page.locator(".beside text:visible").all_text_contents()
        assert sorted(name.rpartition(" ")[0].rpartition(" ")[0] for name in names) == sorted(loads)
        assert charts.words(session.page) == []


def test_what_is_wrong_on_a_screen_is_found(browser, page, tmp_path):
    """A table too wide, pale letters and a broken name are found."""
    css = ".scroll { overflow-x: visible !important; } .whole { white-space: normal !important; }"
    css += " table { min-width: 900px; } .kicker { color: #eee !important; }"
    narrow = '<p style="width: 1.5em">TL-4</p></main>'
    path = changed(page, tmp_path / "a.html", "</style>", f"{css}</style>")
    path = changed(path, tmp_path / "b.html", "</main>", narrow)
    with opened(browser, path, 390) as session:
        assert any("<td>" in fault for fault in screen.outside(session.page))
        assert any("color-contrast" in fault for fault in screen.violations(session.page))
        assert "broken across lines: TL-4" in screen.broken(session.page)


def test_a_cut_column_is_found_on_paper(browser, page, tmp_path):
    """A table that is wider than paper, its end cut off."""
    css = "@media print { .scroll { overflow: hidden !important; } table { width: 300% !important; } }"
    with opened(browser, changed(page, tmp_path / "a.html", "</style>", f"{css}</style>")) as session:
        faults = paper.missing(session.page)
    assert any("not on paper, of table" in fault for fault in faults)
    lost = changed(page, tmp_path / "b.html", "</h2>", "</h2><h3 hidden>A lost heading</h3>")
    with opened(browser, lost) as session:
        assert paper.missing(session.page) == ["not on paper: A lost heading"]


def test_words_of_charts_that_are_cut_or_overprinted_are_found(browser, page, tmp_path):
    words = '<text x="390" y="20">outside</text><text x="50" y="60">one</text><text x="55" y="62">two</text>'
    path = changed(page, tmp_path / "a.html", "</main>", CHART.format(words) + CHART.format("") + "</main>")
    with opened(browser, path, scripts=False) as session:
        assert charts.words(session.page) == [
            'cut in "a chart": outside', 'overprinted in "a chart": one by two'
        ]  # fmt: skip
        assert charts.empty(session.page) == ["nothing drawn: A chart"]


def test_what_a_page_asks_for_and_complains_of_is_found(browser, page, tmp_path):
    """A picture from elsewhere is refused by policy, otherwise requested."""
    picture = '<img src="http://127.0.0.1:9/a.png" alt="a picture">'
    path = changed(page, tmp_path / "a.html", "</main>", f"{picture}</main>")
    with opened(browser, path) as session:
        assert any("Content Security Policy" in error for error in session.errors)
    with opened(browser, changed(path, tmp_path / "b.html", "img-src data:;", "img-src *;")) as session:
        assert session.requests == ["http://127.0.0.1:9/a.png"]
