"""Verify US units in scenes, commands, pages and pictures."""

import json
import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import tailslap
from postprocess.figures.animation import from_above, write_animation
from postprocess.report.command_report import PAGE, Report, write_report
from postprocess.report.page import Headline, Page, Section, page_text
from postprocess.report.provenance import files_digest
from postprocess.report.tables import Column, Table
from postprocess.svg.chart import Axis, Chart, Plot
from postprocess.svg.marks import Level, Line
from postprocess.units import SI, US, measure
from tailslap import cli, errors
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact import paper_method, report_tables
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.read import read_scene
from tailslap.scene.units import shown
from tailslap.studies.flexibility.flexibility_report import STIFF

INCH, FOOT, POUND, MPH = 0.0254, 0.3048, 0.45359237, 1609.344 / 3600.0
POUND_FORCE = POUND * 9.80665
KIP, KSI = 1000.0 * POUND_FORCE, 1000.0 * POUND_FORCE / INCH**2


DEFINITIONS = [
    *(("m", FOOT), ("m/s", FOOT), ("N", KIP), ("N s", KIP), ("J", KIP * FOOT), ("kg", POUND), ("Pa", KSI)),
    *(("mm", 1e3 * INCH), ("kN", KIP / 1e3), ("kg/m^3", POUND / FOOT**3), ("N/m", KIP / FOOT)),
    *(("MN/m", KIP / FOOT / 1e6), ("kN/m", KIP / FOOT / 1e3), ("GPa", KSI / 1e9), ("MPa", KSI / 1e6)),
    *(("t", POUND / 1e3), ("kg m^2", POUND * FOOT**2), ("kN s", KIP / 1e3), ("kJ", KIP * FOOT / 1e3)),
]


@pytest.mark.parametrize(("unit", "size"), DEFINITIONS)
def test_definitions(unit, size):
    """Size of the SI unit in the US unit."""
    assert US.of(unit)[0] * size == pytest.approx(1.0, rel=1e-14)


def test_what_is_shown():
    assert (shown(25.0, "m/s"), shown(653321.7, "N")) == ("25 m/s", "653.3217 kN")
    assert shown(KIP * 100.0, "N", "us") == "100 kip"
    assert shown(56 * MPH, "m/s", "us") == "82.13333 ft/s (56 mph)"
    assert shown(np.pi / 12.0, "rad", "us", width=8) == "      15 deg"
    assert shown(np.pi / 12.0, "rad") == "15 deg"


def test_rigid_prints_american_units_and_labels_them(capsys):
    assert cli._status(["rigid", "mash-tl4-sut", "--units", "us"]) == 0
    text = capsys.readouterr().out
    answer = CornerCase(*read_scene("mash-tl4-sut")).rigid_numbers()
    lines = [line.split() for line in text.splitlines()]
    (peak,) = (line for line in lines if line[:2] == ["peak", "force"])
    (slide,) = (line for line in lines if line[:1] == ["slide"])
    (v_gx,) = (line for line in lines if line[:1] == ["v_GX"])
    assert "Stage 1, impulse at the front corner" in text
    assert (peak[3], slide[2], v_gx[2], v_gx[4]) == ("kip", "ft", "ft/s", "mph)")
    motion = answer["stage2"]
    printed = [float(text) for text in (peak[2], slide[1], v_gx[1], v_gx[3][1:])]
    lengths = motion["slide"] / FOOT, motion["v_gx"] / FOOT, motion["v_gx"] / MPH
    assert printed == pytest.approx([answer["stage3"]["peak_force"] / KIP, *lengths], rel=1e-6)
    for metric in (" m/s", "kN", " m\n"):
        assert metric not in text


def test_a_report_is_in_american_units_everywhere():
    """Headline, sentences, captions, cells, axes, ticks and values of charts."""
    two, three, force = measure(2.0, "m", "g"), measure(3.0, "m", "g"), measure(445.0, "kN", "g")
    line = Line(force, np.array([0.0, 445.0]), np.zeros(2), values=[force] * 2, at=[two, three])
    chart = Chart("c", two, (Plot((line, Level("", 445.0)), Axis("y [kN]")),), Axis("x [kN]"))
    form = "`{}`".format
    columns = (Column("a", "a", form=str), Column("b", "b", "N", form=".1f"), Column("c", "c", form=form))
    table = Table(columns, [{"a": two, "b": 445e3, "c": "2 m"}], f"of {two}", (two,))
    section = Section(two, two, (chart,), (table,), (two,))
    page = Page("", Headline("", two), (section,), "SI units; x along")
    us_report = Report(page, {}, (two, table)).in_units(US)
    (part,) = us_report.page.sections
    (us_table,), (figure,) = part.tables, part.figures
    assert {us_report.page.headline.answer, part.title, part.lead, *part.sentences, *us_table.notes} == {
        "6.56 ft"
    }
    assert [column.text(us_table.rows[0]) for column in us_table.columns] == ["6.56 ft", "100.0", "`2 m`"]
    assert (us_table.title, us_table.columns[1].heading, us_report.terminal[0]) == (
        "of 6.56 ft",
        "b [kip]",
        "6.56 ft",
    )
    assert isinstance(figure, Chart)
    for text in (">x [kip]<", ">100\xa0kip<", ">100<"):
        assert text in figure.svg
    assert "kN" not in re.sub(r' data-[a-z]+="[^"]*"', "", figure.svg)
    assert us_report.page.footer == "US units, files in SI; x along"
    assert Report(page, {}, ()).in_units(SI).page.headline.answer == SI.rendered(two) == "2 m"
    assert Report(page, {}, ()).in_units(SI).page.footer == page.footer


@pytest.mark.parametrize("units", [SI, US])
def test_a_page_in_any_units_shows_the_digest(tmp_path, units):
    write_report(Report(Page("", Headline("Title", ""), (), "SI units"), {}, ()).in_units(units), tmp_path)
    digest = f"<code>{files_digest(tmp_path, PAGE)}</code>"
    assert (tmp_path / PAGE).read_text(encoding="utf-8").count(digest) == 2


def test_a_page_has_both_systems_and_its_switch_shows_one():
    """Texts without a unit stand once.

    The command's units are shown first.
    """
    two = measure(2.0, "m", "g")
    table = Table(
        (Column("a", "a", form=str), Column("b", "b", "N", form=".1f")), [{"a": "same", "b": 445e3}]
    )
    section = Section("Part", two, tables=(table,), sentences=("A sentence.",))
    page = Page("", Headline("Title", two), (section,), "")
    for shown_page, name in ((page, "si"), (page.in_units(US), "us"), (page.in_units(US).in_units(SI), "si")):
        html = page_text(shown_page).replace("\N{NO-BREAK SPACE}", " ")
        assert html.count('<span class="si">2 m</span><span class="us">6.56 ft</span>') == 2
        assert '<span class="si">445.0</span><span class="us">100.0</span>' in html
        assert '<span class="si">b [kN]</span><span class="us">b [kip]</span>' in html
        assert html.count("A sentence.") == html.count(">same<") == 1
        assert re.findall(r'id="(\w+)" checked', html) == [name]
        assert not set("\x1d\x1e\x02\x03") & set(html)


def test_records_that_name_their_unit_are_in_american_units():
    """Occupant risk, and the moduli of the study of flexibility."""
    row = {"name": "THIV", "value": 9.144, "unit": "m/s", "time": 0.1, "lacks": ""}
    risk = Table(report_tables.RISK, [row]).in_units(US)
    assert [column.text(risk.rows[0]) for column in risk.columns[1:3]] == ["30", "ft/s"]
    stiff = Table(STIFF, [{"youngs_modulus": 200e9, "damping": 1.0}]).in_units(US)
    assert (stiff.columns[0].heading, stiff.columns[0].text(stiff.rows[0])) == ("E [ksi]", "2.90e+04")


def second_columns(table):
    table = table.in_units(US)
    return [tuple(column.text(row) for column in table.columns[1:]) for row in table.rows]


def test_tables_of_an_impact_convert_before_they_round(monkeypatch):
    """0.1 kN s is 1 % of the second value."""
    case = ImpactCase(*read_scene("impact-mash-tl3-pickup", ("verify.mesh=0.01",)))
    method = paper_method.paper_method(case.scene, case.answer)
    assert method is not None
    outcome: Any = SimpleNamespace(fe_plan=SimpleNamespace(case=case), paper_method=method)
    (beside,) = report_tables.paper_table(outcome)
    assert second_columns(beside)[0] == (f"{method['impulse'] / KIP:.5g}", "kip s") == ("2.3556", "kip s")
    mean_forces = {f"{name}_mean_50ms": 12_345.6 for name in ("foundation", "contact")}
    state = {"deflection": 1.2345e-3, "place": 3.4567, "t": 0.12345, "foundation_force": 12_345.6}
    monkeypatch.setattr(report_tables, "wall_numbers", lambda outcome: state | mean_forces)
    (wall,) = report_tables.wall_table(outcome)
    cells = [("0.048602", "in."), ("11.341", "ft"), ("0.12345", "s"), *[("2.7754", "kip")] * 3]
    assert second_columns(wall) == cells


def test_json_is_si_always(capsys):
    assert cli._status(["rigid", "mash-tl4-sut", "--json", "--units", "us"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert '--units: given "us"' in err
    assert cli._status(["rigid", "mash-tl4-sut", "--json", "--units", "si"]) == 0
    force = json.loads(capsys.readouterr().out)["stage3"]["peak_force"]
    assert force == CornerCase(*read_scene("mash-tl4-sut")).force.peak_force
    assert cli._status(["rigid", "mash-tl4-sut", "--units", "uk"]) == 2


SQUARE = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]])


@pytest.fixture(scope="module")
def result():
    return tailslap.run("paper-table-3", {"output.fields": 3, "plate.elements": [8, 2]})


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    return result.save(tmp_path_factory.mktemp("us") / "reference", pictures=False)


def test_exported_pictures_take_units_and_tables_refuse_them(result, tmp_path, monkeypatch):
    drawn_units = []
    draw = "postprocess.fields.contours.draw_instants"
    monkeypatch.setattr(draw, lambda *_, units, **__: drawn_units.append(units.name))
    tailslap.export(result, "png", tmp_path / "a", field="velocity", units="us")
    assert drawn_units == ["us"]
    with pytest.raises(errors.InputError, match="csv files are always in SI"):
        tailslap.export(result, "csv", tmp_path / "b", units="us")
    untyped: Any = tailslap.export
    with pytest.raises(errors.InputError, match=r'allowed is \{"si", "us"\}'):
        untyped(result, "png", tmp_path / "c", units="uk")


def test_an_animation_has_axes_in_feet_and_kip(tmp_path, monkeypatch):
    from matplotlib.axes import Axes

    labels, ends = [], []
    plain = Axes.set_ylabel

    def set_ylabel(axes, label, *rest, **options):
        labels.append(label)
        ends.append(axes.get_ylim()[1])
        return plain(axes, label, *rest, **options)

    monkeypatch.setattr(Axes, "set_ylabel", set_ylabel)
    views, force = (from_above(np.stack([SQUARE, SQUARE])),), np.array([0.0, 10.0 * KIP])
    write_animation(tmp_path / "a.gif", np.array([0.0, 0.1]), views, force, units=US)
    write_animation(tmp_path / "b.gif", np.array([0.0, 0.1]), views, force)
    assert labels == ["Y [ft]", "force [kip]", "Y [m]", "force [kN]"]
    assert (ends[0], ends[1]) == (pytest.approx(ends[2] / FOOT), pytest.approx(10.0 * 1.05))


def test_modes_say_the_beam_in_feet(tmp_path, capsys, words_of):
    arguments = ["modes", "paper-table-3", "--count", "1", "--set", "plate.elements=[8,2]", "--units", "us"]
    assert cli._status([*arguments, "--out", str(tmp_path / "a")]) == 0
    text = words_of(tmp_path / "a", "us")
    assert "free beam of length 32.8 ft and depth 7.999 ft" in text
    for value in ("25.053 m/s", "10 m"):  # as the scene has them, in title and set-up
        text = text.replace(value, "")
    assert not re.search(r"\d (m|m/s)\b", text)


def test_a_modal_run_says_feet_and_json_stays_si(capsys):
    assert cli._status(["modal", "paper-table-3", "--units", "us"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert cli._status(["modal", "paper-table-3", "--units", "us", "--json"]) == 0
    values = json.loads(capsys.readouterr().out)["modal"]
    for symbol, key in (("v_GX", "v_gx"), ("s", "slide")):
        (row,) = (line for line in lines if line[:1] == [symbol])
        assert row[1] == ("ft/s" if key == "v_gx" else "ft")
        assert float(row[2]) == pytest.approx(values[key] / FOOT, rel=1e-6)


def test_a_comparison_has_axes_and_numbers_in_american_units(folder, tmp_path, words_of):
    for units in ("us", "si"):
        arguments = ["compare", str(folder), str(folder), "--units", units, "--out", str(tmp_path / units)]
        assert cli._status(arguments) == 0
    us, si = words_of(tmp_path / "us", "us"), words_of(tmp_path / "si", "si")
    force = ("N [kip]", "N [kN]"), ("difference of R [kip]", "difference of R [kN]")
    for us_unit, si_unit in (("s [ft]", "s [m]"), *force):
        assert us_unit in us
        assert us_unit not in si
        assert si_unit in si
    slide = json.loads((folder / "summary.json").read_text())["fe"]["slide"]
    assert f"{slide / FOOT:.7g}" in us
    assert f"{slide:.7g}" in si
    assert (tmp_path / "us" / "metrics.csv").read_text() == (tmp_path / "si" / "metrics.csv").read_text()


def test_a_run_draws_its_pictures_in_the_units_of_its_page(tmp_path, monkeypatch):
    drawn_units = []

    def draw(situation, fields, out, units, size):
        drawn_units.append(units.name)
        return []

    monkeypatch.setattr("postprocess.fields.contours.draw_contours", draw)
    for units in ("us", "si"):
        place = ["--quiet", "--out", str(tmp_path / units)]
        assert cli._status(["run", "paper-table-3", "--units", units, *place]) == 0
    assert drawn_units == ["us", "si"]
