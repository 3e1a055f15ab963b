"""Verification: pictures and page of a sweep show the rows that they are given, and nothing else."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from postprocess.comparison.comparison import KEYS
from postprocess.figures.sweep_plots import SweepRows, Varied, _edges, _scale, draw_sweep
from postprocess.pages.sweep_page import Spread, SweepContent, Trouble, VariedKey, write_sweep_page
from tailslap.sweep.complete import Effort
from tailslap.sweep.progress import clock, sweep_progress
from tailslap.sweep.report.words import shown, values_words
from tailslap.sweep.variation import Variation

pytestmark = pytest.mark.verification


def rows(*varied: Varied, status: str = "passed") -> SweepRows:
    count = len(varied[0].values)
    rigid = {key: np.linspace(1.0, 2.0, count) for key in KEYS}
    difference = {key: np.geomspace(1e-6, 1e-3, count) for key in KEYS}
    fe = {key: rigid[key] * (1.0 + difference[key]) for key in KEYS}
    return SweepRows(varied, np.full(count, status, dtype=object), fe, rigid, difference)


def key(name: str, *values: float | str, logarithmic: bool = False) -> Varied:
    numbers = all(not isinstance(value, str) for value in values)
    return Varied(name, "", np.array(values, dtype=float if numbers else object), logarithmic)


def test_which_plots_there_are() -> None:
    """One against one for each number; a map for two numbers and no words; parallels for three keys or more."""
    a, b = key("a.x", 1, 1, 2, 2), key("b.y", 1, 10, 1, 10, logarithmic=True)
    word, c = key("c.z", "p", "q", "p", "q"), key("d.w", 1, 2, 3, 4)
    assert [curve.name for curve in draw_sweep(rows(a))] == ["against-a-x"]
    assert [curve.name for curve in draw_sweep(rows(a, b))] == ["against-a-x", "against-b-y", "maps"]
    assert [curve.name for curve in draw_sweep(rows(a, word))] == ["against-a-x"]
    names = [curve.name for curve in draw_sweep(rows(a, word, c))]
    assert names == ["against-a-x", "against-d-w", "parallels"]
    nothing = rows(a)
    assert draw_sweep(replace(nothing, difference={k: np.full(4, np.nan) for k in KEYS})) == ()


def test_each_row_is_a_point() -> None:
    """Five panels with a rigid and an FE mark for each row, one with the differences: 11 marks a row; failed ones once
    more in red, and without a result none."""
    a = key("a.x", 1, 2, 3)
    (curve,) = draw_sweep(rows(a))
    assert _marks(curve.svg) == 3 * 11
    (failed,) = draw_sweep(rows(a, status="failed"))
    assert _marks(failed.svg) == 3 * 11 + 3 * 5
    assert "a check failed" in failed.svg
    assert "a check failed" not in curve.svg


def _marks(svg: str) -> int:
    """Marks of data; those of the ticks, two lengths of stroke, are left out."""
    return sum(len(re.findall("<use ", group)) for group in re.findall(r"<g clip-path=.*?</g>", svg, re.S))


def test_edges_of_cells() -> None:
    assert _edges(np.array([1.0, 2.0, 4.0]), False).tolist() == [0.5, 1.5, 3.0, 5.0]
    ratios = _edges(np.array([1.0, 100.0, 1e4]), True)
    assert ratios == pytest.approx([0.1, 10.0, 1e3, 1e5], rel=1e-12)


def test_heights_of_parallels() -> None:
    assert _scale("x", np.array([2.0, 3.0, 4.0]), False).heights.tolist() == [0.0, 0.5, 1.0]
    assert _scale("x", np.array([1.0, 10.0, 100.0]), True).heights == pytest.approx([0.0, 0.5, 1.0])
    assert _scale("x", np.array([5.0, 5.0]), False).heights.tolist() == [0.5, 0.5]
    words = _scale("x", np.array(["p", "q", "p"], dtype=object), False)
    assert words.heights.tolist() == [0.25, 0.75, 0.25]


def test_the_worst_of_the_five_differences() -> None:
    some = rows(key("a", 1, 2))
    changed = dict(some.difference) | {"omega": np.array([-0.5, 0.0]), "t": np.array([0.1, np.nan])}
    worst = replace(some, difference=changed).worst
    assert worst[0] == 0.5
    assert math.isnan(worst[1])


def test_the_page_holds_what_it_is_given(tmp_path: Path) -> None:
    a, b = key("a.x", 1, 1, 2, 2), key("b.y", 1, 10, 1, 10)
    content = SweepContent(
        scene="a<b",
        version="1.2.3",
        headline="Four runs.",
        keys=(VariedKey("a.x", "1 to 2", 2),),
        spreads=(Spread("v_GY", "m/s", -2.5, -1.5, 3e-4, 7),),
        troubles=(Trouble(3, "a.x = 2", "failed", "energy <balance>"),),
        trouble_count=5,
        curves=draw_sweep(rows(a, b)),
        statements=("All combinations.",),
        scene_text="name = 1",
    )
    page = write_sweep_page(tmp_path / "report.html", content).read_text()
    for text in (
        "a&lt;b",
        "Four runs.",
        "-2.5",
        "+3.00e-04",
        "energy &lt;balance&gt;",
        "The first 1 of 5",
        "1.2.3",
    ):
        assert text in page
    assert page.count("<svg") == 3
    assert "http" not in page.replace("http://www.w3.org", "")
    empty = write_sweep_page(
        tmp_path / "e.html", replace(content, curves=(), troubles=(), spreads=())
    ).read_text()
    assert "<svg" not in empty
    assert "did not pass" not in empty


def test_words() -> None:
    angle = Variation("impact.angle", "rad", ("1", "2"), (math.radians(10), math.radians(15)), False)
    assert values_words(angle) == "10 deg, 15 deg"
    modulus = Variation("e", "Pa", ("",) * 6, (1e8, 1e9, 1e10, 1e11, 1e12, 1e13), True)
    assert values_words(modulus) == "1e+08 Pa to 1e+13 Pa, in equal ratios"
    assert (shown("quad4", ""), shown(0.25, "")) == ("quad4", "0.25")


def test_rate_and_overhead_by_hand() -> None:
    """Two threads for 10 s are 20 s; 100 runs of 0.15 s leave 5 s, 0.05 s a run."""
    effort = Effort(100, 2, 10.0, 15.0)
    assert (effort.rate, effort.overhead_s) == (10.0, pytest.approx(0.05))
    assert (Effort().rate, Effort().overhead_s) == (0.0, 0.0)
    assert [clock(seconds) for seconds in (0.4, 59.6, 61, 3725)] == ["0:00", "1:00", "1:01", "1:02:05"]


def test_progress_where_there_is_no_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Silent for half a minute; then 40 runs made in 40 s are one a second, and 40 are left."""
    now = [0.0]
    monkeypatch.setattr("tailslap.sweep.progress.time.monotonic", lambda: now[0])
    with sweep_progress(90, 10) as show:
        now[0] = 5.0
        show(20, 0, 2)
        assert capsys.readouterr().err == ""
        now[0] = 40.0
        show(50, 1, 0)
    said = capsys.readouterr().err
    assert (
        said
        == "tailslap: 50 of 90 done, 1 failed, 1 runs/s, 0:40 left; no worker is there, waiting for one\n"
    )
