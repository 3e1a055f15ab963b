"""Verification: American units in scenes and in what `tailslap rigid --units us` prints, by the units' definitions."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tailslap.command_line import _status
from tailslap.errors import InputError
from tailslap.planning.plan import make_plan
from tailslap.planning.rigid import rigid_answer, rigid_lines
from tailslap.scene.files import read_scene
from tailslap.scene.us_units import converted, shown

pytestmark = pytest.mark.verification

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
def test_scenes_take_american_units(change: str, value: float) -> None:
    key = change.partition("=")[0]
    table, _, name = key.partition(".")
    scene = read_scene("mash-tl4-sut", (change,))[0]
    assert getattr(getattr(scene, table), name) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    "change", ["plate.youngs_modulus=29000 kip", "vehicle.mass=22 kip", "plate.density=490 lbf/ft^3"]
)
def test_a_force_is_no_mass_and_no_stress(change: str) -> None:
    with pytest.raises(InputError, match="the unit does not fit"):
        read_scene("mash-tl4-sut", (change,))


def test_definitions() -> None:
    assert converted(FOOT, "m") == ((pytest.approx(1.0, rel=1e-14), "ft"),)
    assert converted(MPH, "m/s") == (
        (pytest.approx(5280 / 3600, rel=1e-14), "ft/s"),
        (pytest.approx(1.0, rel=1e-14), "mph"),
    )
    assert converted(KIP, "N") == ((pytest.approx(1.0, rel=1e-14), "kip"),)
    assert converted(-2.0 * KIP, "N s") == ((pytest.approx(-2.0, rel=1e-14), "kip s"),)


def test_what_is_shown() -> None:
    assert shown(25.0, "m/s") == "25 m/s"
    assert shown(653321.7, "N") == "653.3217 kN"
    assert shown(KIP * 100.0, "N", "us") == "100 kip"
    assert shown(56 * MPH, "m/s", "us") == "82.13333 ft/s (56 mph)"
    assert shown(0.25, "rad", "us", width=8) == "    0.25 rad"


def test_rigid_prints_american_units_and_labels_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert _status(["rigid", "mash-tl4-sut", "--units", "us"]) == 0
    text = capsys.readouterr().out
    answer = rigid_answer(make_plan(*read_scene("mash-tl4-sut")))
    lines = [line.split() for line in text.splitlines()]
    (peak,) = (line for line in lines if line[:2] == ["peak", "force"])
    (slide,) = (line for line in lines if line[:1] == ["slide"])
    (v_gx,) = (line for line in lines if line[:1] == ["v_GX"])
    assert peak[3] == "kip"
    assert float(peak[2]) == pytest.approx(answer["stage3"]["peak_force"] / KIP, rel=1e-6)
    assert slide[2] == "ft"
    assert float(slide[1]) == pytest.approx(answer["stage2"]["slide"] / FOOT, rel=1e-6)
    assert (v_gx[2], v_gx[4]) == ("ft/s", "mph)")
    assert float(v_gx[1]) == pytest.approx(answer["stage2"]["v_gx"] / FOOT, rel=1e-6)
    assert float(v_gx[3][1:]) == pytest.approx(answer["stage2"]["v_gx"] / MPH, rel=1e-6)
    for metric in (" m/s", "kN", " m\n"):
        assert metric not in text


def test_si_stays_the_default() -> None:
    plan = make_plan(*read_scene("mash-tl4-sut"))
    assert rigid_lines(plan) == rigid_lines(plan, "si")
    assert "kip" not in "\n".join(rigid_lines(plan))


def test_json_is_si_always(capsys: pytest.CaptureFixture[str]) -> None:
    assert _status(["rigid", "mash-tl4-sut", "--json", "--units", "us"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert '--units: given "us"' in err
    assert _status(["rigid", "mash-tl4-sut", "--json", "--units", "si"]) == 0
    force = json.loads(capsys.readouterr().out)["stage3"]["peak_force"]
    assert force == make_plan(*read_scene("mash-tl4-sut")).force.peak_force
    assert _status(["rigid", "mash-tl4-sut", "--units", "uk"]) == 2


def test_rigid_imports_neither_statistics_nor_plots() -> None:
    code = "import sys; from tailslap.command_line import _status; _status(['rigid','mash-tl4-sut','--units','us'])\n"
    code += "print(sorted({'scipy.stats', 'scipy.special', 'matplotlib', 'rich', 'jinja2'} & {*sys.modules}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
