"""Verification: with `--units us` pictures and the pages of modes, modal runs and comparisons are in American units."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tailslap
from postprocess.fields.contours import ContourField, Sheet, Situation, draw_contours, draw_instants
from postprocess.figures.animation import write_animation
from postprocess.units import US
from tailslap.cli import _status
from tailslap.errors import InputError

FOOT, KIP = 0.3048, 4448.2216152605
PSI = KIP / 1e3 / (FOOT / 12.0) ** 2
SQUARE = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]])


@pytest.fixture(scope="module")
def result():
    return tailslap.run("paper-table-3", {"output.fields": 3, "plate.elements": [8, 2]})


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    return result.save(tmp_path_factory.mktemp("us") / "reference", pictures=False)


def texts_of(monkeypatch: pytest.MonkeyPatch, draw: Callable[[], Any]) -> list[str]:
    """Words of a picture: the rulers' numbers and what stands beside them."""
    said: list[str] = []
    plain = Sheet.write

    def write(sheet: Sheet, text: str, *more: Any, **others: Any) -> None:
        said.append(text)
        plain(sheet, text, *more, **others)

    monkeypatch.setattr(Sheet, "write", write)
    draw()
    monkeypatch.undo()
    return said


def numbers(texts: list[str]) -> list[float]:
    return [float(text) for text in texts if re.fullmatch(r"[\d.]+", text)]


def test_contours_have_rulers_title_and_values_in_feet(monkeypatch, tmp_path):
    field = ContourField("v", "Velocity", "m/s", SQUARE[:, 0])
    situation = Situation((SQUARE, np.array([[0, 1, 2, 3]])), corner=(0.0, 0.0), centroid=(1.5, 0.5))
    metres, feet = (
        texts_of(monkeypatch, lambda units=units: draw_contours(situation, [field], tmp_path, *units))  # type: ignore[misc]
        for units in ((), (US,))
    )
    for said, length, speed, middle in (
        (metres, "m", "m/s", "G: 1.5 m/s"),
        (feet, "ft", "ft/s", "G: 4.921 ft/s"),
    ):
        assert {f"X [{length}], driving direction →", f"Y [{length}]", f"Velocity [{speed}]", middle} <= {
            *said
        }
    assert max(numbers(metres)) == 3.0
    assert 3.0 / FOOT - 1.0 <= max(numbers(feet)) <= 3.0 / FOOT + 1.0
    assert f"nodal values from 0 to {3.0 / FOOT:.4g} ft/s" in feet


def test_drawn_fields_are_in_feet_and_ksi(result, tmp_path, monkeypatch):
    """Title, range and rulers; the picture itself is the same but for round numbers."""
    series = result.fields
    feet, metres = (
        texts_of(
            monkeypatch,
            lambda units=units: draw_instants(  # type: ignore[misc]
                tmp_path, series, "stress_von_mises", instants=[1], **units
            ),
        )
        for units in ({"units": US}, {})
    )
    stress = series.elemental["stress_von_mises"][1]
    least, most = (f"{end / (1e3 * PSI):.4g}" for end in (stress.min(), stress.max()))
    assert {"stress_von_mises [ksi]", "Y [ft]", "X [ft], driving direction →"} <= {*feet}
    assert f"element values from {least} to {most} ksi" in feet
    assert {"stress_von_mises [Pa]", "Y [m]", f"t = {series.t[1]:.4f} s"} <= {*metres}
    assert f"element values from {stress.min():.4g} to {stress.max():.4g} Pa" in metres


def test_exported_pictures_take_units_and_tables_refuse_them(result, tmp_path, monkeypatch):
    given: list[str] = []
    monkeypatch.setattr(
        "postprocess.fields.contours.draw_instants", lambda *_, units, **__: given.append(units.name)
    )
    tailslap.export(result, "png", tmp_path / "a", field="velocity", units="us")
    assert given == ["us"]
    with pytest.raises(InputError, match="files of csv are in SI always"):
        tailslap.export(result, "csv", tmp_path / "b", units="us")
    with pytest.raises(InputError, match="allowed is one of si, us"):
        tailslap.export(result, "png", tmp_path / "c", units="uk")


def test_an_animation_has_axes_in_feet_and_kip(tmp_path, monkeypatch):
    from matplotlib.axes import Axes

    labels: list[str] = []
    ends: list[float] = []
    plain = Axes.set_ylabel

    def set_ylabel(axes: Axes, label: str, *more: Any, **others: Any) -> Any:
        labels.append(label)
        ends.append(axes.get_ylim()[1])
        return plain(axes, label, *more, **others)

    monkeypatch.setattr(Axes, "set_ylabel", set_ylabel)
    outlines, force = np.stack([SQUARE, SQUARE]), np.array([0.0, 10.0 * KIP])
    write_animation(tmp_path / "a.gif", np.array([0.0, 0.1]), outlines, force, units=US)
    write_animation(tmp_path / "b.gif", np.array([0.0, 0.1]), outlines, force)
    assert labels == ["Y [ft]", "force [kip]", "Y [m]", "force [kN]"]
    assert ends[0] == pytest.approx(ends[2] / FOOT)
    assert ends[1] == pytest.approx(10.0 * 1.05)


def page_text(place: Path) -> str:
    """Words of a page without tags, what is folded and drawn included."""
    text = re.sub(r"<style>.*?</style>|<pre.*?</pre>|<script>.*?</script>", "", _html(place), flags=re.DOTALL)
    return re.sub(r"<[^>]+>", "", text).replace("\N{NO-BREAK SPACE}", " ")


def _html(place: Path) -> str:
    return (place / "report.html").read_text(encoding="utf-8")


def test_modes_say_the_beam_in_feet(tmp_path, capsys):
    arguments = ["modes", "paper-table-3", "--count", "1", "--set", "plate.elements=[8,2]", "--units", "us"]
    assert _status([*arguments, "--out", str(tmp_path / "a")]) == 0
    text = page_text(tmp_path / "a")
    assert "free beam of length 32.8 ft and depth 7.999 ft" in text
    assert not re.search(r"\d (m|m/s)\b", text)


def test_a_modal_run_says_feet_and_json_stays_si(capsys):
    assert _status(["modal", "paper-table-3", "--units", "us"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert _status(["modal", "paper-table-3", "--units", "us", "--json"]) == 0
    values = json.loads(capsys.readouterr().out)["modal"]
    for symbol, key in (("v_GX", "v_gx"), ("s", "slide")):
        (row,) = (line for line in lines if line[:1] == [symbol])
        assert row[1] == ("ft/s" if key == "v_gx" else "ft")
        assert float(row[2]) == pytest.approx(values[key] / FOOT, rel=1e-6)


def test_a_comparison_has_axes_and_numbers_in_american_units(folder, tmp_path):
    for units in ("us", "si"):
        given = ["compare", str(folder), str(folder), "--units", units, "--out", str(tmp_path / units)]
        assert _status(given) == 0
    us, si = page_text(tmp_path / "us"), page_text(tmp_path / "si")
    for unit, other in (
        ("s [ft]", "s [m]"),
        ("N [kip]", "N [kN]"),
        ("difference of R [kip]", "difference of R [kN]"),
    ):
        assert unit in us
        assert unit not in si
        assert other in si
    slide = json.loads((folder / "summary.json").read_text())["fe"]["slide"]
    assert f"{slide / FOOT:.7g}" in us
    assert f"{slide:.7g}" in si
    assert (tmp_path / "us" / "metrics.csv").read_text() == (tmp_path / "si" / "metrics.csv").read_text()


def test_a_run_draws_its_pictures_in_the_units_of_its_page(tmp_path, monkeypatch):
    given: list[str] = []

    def draw(situation: Situation, fields: Any, out: Path, units: Any) -> list[Path]:
        given.append(units.name)
        return []

    monkeypatch.setattr("tailslap.case.corner.report.draw_contours", draw)
    for units in ("us", "si"):
        assert (
            _status(["run", "paper-table-3", "--units", units, "--quiet", "--out", str(tmp_path / units)])
            == 0
        )
    assert given == ["us", "si"]
