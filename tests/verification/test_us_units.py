"""Verification: American units in scenes and in what `tailslap rigid --units us` prints, by the units' definitions."""

import json
import subprocess
import sys

import numpy as np
import pytest

from postprocess.report.page import Page, Section
from postprocess.report.report import Report, in_units
from postprocess.report.table import Column, Table
from postprocess.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.svg.marks import Level, Line
from postprocess.units import SI, US, measure
from tailslap.case.corner.case import CornerCase
from tailslap.case.impact.report import RISK
from tailslap.cli import _status
from tailslap.errors import InputError
from tailslap.scene.read import read_scene
from tailslap.scene.units import shown
from tailslap.studies.flexibility.report import STIFF

INCH, FOOT, POUND, MPH = 0.0254, 0.3048, 0.45359237, 1609.344 / 3600.0
POUND_FORCE = POUND * 9.80665
KIP, KSI = 1000.0 * POUND_FORCE, 1000.0 * POUND_FORCE / INCH**2


@pytest.mark.parametrize(
    ("change", "value"),
    [
        ("plate.youngs_modulus=29000 ksi", 29000 * KSI),
        ("plate.youngs_modulus=29e6 psi", 29000 * KSI),
        ("plate.youngs_modulus=29000 kip/in^2", 29000 * KSI),
        ("plate.youngs_modulus=4.176e9 lbf/ft^2", 4.176e9 * POUND_FORCE / FOOT**2),
        ("plate.density=490 lb/ft^3", 490 * POUND / FOOT**3),
        ("plate.thickness=2 in", 2 * INCH),
        ("vehicle.length=32 ft", 32 * FOOT),
        ("vehicle.mass=22000 lb", 22000 * POUND),
        ("vehicle.mass=22 klb", 22000 * POUND),
        ("vehicle.mass=683.8 slug", 683.8 * POUND_FORCE / FOOT),
        ("impact.speed=82 ft/s", 82 * FOOT),
        ("impact.speed=56 mph", 56 * MPH),
    ],
)
def test_scenes_take_american_units(change, value):
    key = change.partition("=")[0]
    table, _, name = key.partition(".")
    scene = read_scene("mash-tl4-sut", (change,))[0]
    assert getattr(getattr(scene, table), name) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    "change", ["plate.youngs_modulus=29000 kip", "vehicle.mass=22 kip", "plate.density=490 lbf/ft^3"]
)
def test_a_force_is_no_mass_and_no_stress(change):
    with pytest.raises(InputError, match="the unit does not fit"):
        read_scene("mash-tl4-sut", (change,))


@pytest.mark.parametrize(
    ("unit", "size"),
    [
        *(
            ("m", FOOT),
            ("m/s", FOOT),
            ("N", KIP),
            ("N s", KIP),
            ("J", KIP * FOOT),
            ("kg", POUND),
            ("Pa", KSI),
        ),
        *(("mm", 1e3 * INCH), ("kN", KIP / 1e3), ("kg/m^3", POUND / FOOT**3), ("N/m", KIP / FOOT)),
        *(("MN/m", KIP / FOOT / 1e6), ("kN/m", KIP / FOOT / 1e3), ("GPa", KSI / 1e9), ("MPa", KSI / 1e6)),
        *(("t", POUND / 1e3), ("kg m^2", POUND * FOOT**2), ("kN s", KIP / 1e3), ("kJ", KIP * FOOT / 1e3)),
    ],
)
def test_definitions(unit, size):
    """How many of the American unit one of the SI unit is."""
    assert US.of(unit)[0] * size == pytest.approx(1.0, rel=1e-14)


def test_what_is_shown():
    assert shown(25.0, "m/s") == "25 m/s"
    assert shown(653321.7, "N") == "653.3217 kN"
    assert shown(KIP * 100.0, "N", "us") == "100 kip"
    assert shown(56 * MPH, "m/s", "us") == "82.13333 ft/s (56 mph)"
    assert shown(np.pi / 12.0, "rad", "us", width=8) == "      15 deg"
    assert shown(np.pi / 12.0, "rad") == "15 deg"


def test_rigid_prints_american_units_and_labels_them(capsys):
    assert _status(["rigid", "mash-tl4-sut", "--units", "us"]) == 0
    text = capsys.readouterr().out
    answer = CornerCase(*read_scene("mash-tl4-sut")).rigid_numbers()
    lines = [line.split() for line in text.splitlines()]
    (peak,) = (line for line in lines if line[:2] == ["peak", "force"])
    (slide,) = (line for line in lines if line[:1] == ["slide"])
    (v_gx,) = (line for line in lines if line[:1] == ["v_GX"])
    assert "Stage 1, impulse at the front corner" in text
    assert peak[3] == "kip"
    assert float(peak[2]) == pytest.approx(answer["stage3"]["peak_force"] / KIP, rel=1e-6)
    assert slide[2] == "ft"
    assert float(slide[1]) == pytest.approx(answer["stage2"]["slide"] / FOOT, rel=1e-6)
    assert (v_gx[2], v_gx[4]) == ("ft/s", "mph)")
    assert float(v_gx[1]) == pytest.approx(answer["stage2"]["v_gx"] / FOOT, rel=1e-6)
    assert float(v_gx[3][1:]) == pytest.approx(answer["stage2"]["v_gx"] / MPH, rel=1e-6)
    for metric in (" m/s", "kN", " m\n"):
        assert metric not in text


@pytest.mark.parametrize(
    ("text", "si", "us"),
    [
        (f"a peak of {measure(445e3, 'N', '.0f')}.", "a peak of 445 kN.", "a peak of 100 kip."),
        (
            f"between {measure(339, 'kN', 'g', named=False)} and {measure(850, 'kN', 'g')}",
            "between 339 and 850 kN",
            "between 76.2 and 191 kip",
        ),
        (measure(4.5, "m", "g"), "4.5 m", "14.8 ft"),
        (measure(10000.0, "kg", ".0f"), "10000 kg", "22046 lb"),
        (measure(25.034, "m/s", ".5g"), "25.034 m/s", "82.133 ft/s"),
        (measure(20.0, "GPa", "g"), "20 GPa", "2900 ksi"),
        (measure(2e6, "N/m", ".4g"), "2e+06 N/m", "137 kip/ft"),
        (measure(-1250.0, "N s", ".3g"), "-1.25 kN s", "-0.281 kip s"),
        (measure(np.float64(-2), "mm", "g"), "-2 mm", "-0.0787 in."),
        (measure(np.pi / 12.0, "rad", ".3g"), "15 deg", "15 deg"),
        (measure(8.0, "Hz", "g"), "8 Hz", "8 Hz"),
        (
            "as `impact.speed = 25 m/s` has it",
            "as `impact.speed = 25 m/s` has it",
            "as `impact.speed = 25 m/s` has it",
        ),
    ],
)
def test_measures_are_rendered_in_the_units_of_the_reader(text, si, us):
    """Values by the units' definitions, to as many digits, but three at least; texts without a measure as they are."""
    assert (SI.rendered(text), US.rendered(text)) == (si, us)


def test_a_measure_is_converted_before_it_is_rounded():
    """10.4778 kN s are 2.3555 kip s; rounded to 10.5 kN s first they would be 2.3605."""
    assert US.rendered(measure(10477.8, "N s", ".1f")) == "2.36 kip s"
    assert US.rendered(measure(10477.8, "N s", ".3f")) == f"{10477.8 / KIP:.5g} kip s"


def test_a_report_is_in_american_units_everywhere():
    """Headline, lead, sentences, captions, cells, axes, ticks, and what charts say at the pointer."""
    two, three, force = measure(2.0, "m", "g"), measure(3.0, "m", "g"), measure(445.0, "kN", "g")
    line = Line(force, np.array([0.0, 445.0]), np.zeros(2), values=[force] * 2, at=[two, three])
    chart = draw_chart("c", two, (Plot((line, Level("", 445.0)), Axis("y [kN]")),), Axis("x [kN]"))
    columns = (
        Column("a", "a", form=str),
        Column("b", "b", "N", form=".1f"),
        Column("c", "c", form="`{}`".format),
    )
    table = Table(columns, [{"a": two, "b": 445e3, "c": "2 m"}], f"of {two}", (two,))
    section = Section(two, two, (chart,), (table,), (two,))
    page = Page("", "", two, (section,), "SI units; x along")
    shown = in_units(Report(page, {}, (two, table)), US)
    (part,) = shown.page.sections
    (made,), (figure,) = part.tables, part.figures
    assert {shown.page.headline, part.title, part.lead, *part.sentences, *made.notes} == {"6.56 ft"}
    assert [column.text(made.rows[0]) for column in made.columns] == ["6.56 ft", "100.0", "`2 m`"]
    assert (made.title, made.columns[1].heading, shown.terminal[0]) == ("of 6.56 ft", "b [kip]", "6.56 ft")
    assert isinstance(figure, Chart)
    for text in (
        ">x [kip]<",
        ">100\xa0kip<",
        ">100<",
        'data-at="6.56\xa0ft 9.84\xa0ft"',
        'data-values="100\xa0kip ',
    ):
        assert text in figure.svg
    assert "kN" not in figure.svg
    assert shown.page.footer == "US units, files in SI; x along"
    assert in_units(Report(page, {}, ()), SI).page.headline == SI.rendered(two) == "2 m"
    assert in_units(Report(page, {}, ()), SI).page.footer == page.footer


def test_records_that_name_their_unit_are_in_american_units():
    """Occupant risk, and the moduli of the study of flexibility."""
    risk = Table(RISK, [{"name": "THIV", "value": 9.144, "unit": "m/s", "time": 0.1, "lacks": ""}]).in_units(
        US
    )
    assert [column.text(risk.rows[0]) for column in risk.columns[1:3]] == ["30", "ft/s"]
    stiff = Table(STIFF, [{"youngs_modulus": 200e9, "damping": 1.0}]).in_units(US)
    assert (stiff.columns[0].heading, stiff.columns[0].text(stiff.rows[0])) == ("E [ksi]", "2.90e+04")


def test_si_stays_the_default():
    plan = CornerCase(*read_scene("mash-tl4-sut"))
    assert plan.rigid_text() == plan.rigid_text("si")
    assert "kip" not in "\n".join(plan.rigid_text())


def test_json_is_si_always(capsys):
    assert _status(["rigid", "mash-tl4-sut", "--json", "--units", "us"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert '--units: given "us"' in err
    assert _status(["rigid", "mash-tl4-sut", "--json", "--units", "si"]) == 0
    force = json.loads(capsys.readouterr().out)["stage3"]["peak_force"]
    assert force == CornerCase(*read_scene("mash-tl4-sut")).force.peak_force
    assert _status(["rigid", "mash-tl4-sut", "--units", "uk"]) == 2


def test_rigid_imports_neither_statistics_nor_plots():
    code = "import sys; from tailslap.cli import _status; _status(['rigid','mash-tl4-sut','--units','us'])\n"
    code += "print(sorted({'scipy.stats', 'scipy.special', 'matplotlib', 'rich', 'jinja2'} & {*sys.modules}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
