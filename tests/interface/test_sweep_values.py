"""Verify values of a sweep, and pictures and page of its rows."""

import json
import math
import re
import shlex
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from chart_samples import samples

from postprocess.comparison.quantities import TAIL_SLAP
from postprocess.figures.sweeps import SweepRows, Varied, draw_sweep
from postprocess.report.command_report import Report
from postprocess.report.page import write_page
from postprocess.svg.chart import FULL, PART
from postprocess.units import SI
from tailslap.campaign import engine, sweep_report
from tailslap.campaign.sweep_definition import (
    Definition,
    TypedRange,
    Variation,
    make_definition,
    parse_varied,
    split_outside,
)
from tailslap.campaign.sweep_table import FinishedSweep
from tailslap.cli import _status
from tailslap.errors import InputError
from tailslap.progress import clock, counted
from tailslap.scene.vary import Source

KEYS = tuple(TAIL_SLAP.quantities)
SCENE = "paper-table-3"
MPH = 1609.344 / 3600.0


def grid(*varied, changes=()):
    return make_definition(SCENE, changes, varied, None, 307)


TYPED = [
    ("0:0.6:13", TypedRange("0", "0.6", 13, False)),
    ("log:1e8:1e13:40", TypedRange("1e8", "1e13", 40, True)),
    ("50 mph : 60 mph : 5", TypedRange("50 mph", "60 mph", 5, False)),
    *(("10deg,15deg", ("10deg", "15deg")), ("quad4, tri3", ("quad4", "tri3"))),
    *(("[6, 2],[12,4]", ("[6, 2]", "[12,4]")), ('"a,b",c', ('"a,b"', "c")), ("0.3", ("0.3",))),
]


@pytest.mark.parametrize(("text", "values"), TYPED)
def test_values_as_typed(text, values):
    assert parse_varied(f"key={text}", False) == ("key", values)


def test_sampled_ranges_have_no_count():
    assert parse_varied("key=log:1:10", True)[1] == TypedRange("1", "10", None, True)
    assert split_outside("a:[b:c]:'d:e'", ":") == ["a", "[b:c]", "'d:e'"]


NUMBERS = [
    ("corner.friction=0:0.6:13", "", [float(Fraction(i, 20)) for i in range(13)]),
    ("plate.youngs_modulus=log:1e8:1e13:6", "Pa", [1e8, 1e9, 1e10, 1e11, 1e12, 1e13]),
    ("impact.speed=50 mph:60 mph:3", "m/s", [50 * MPH, 55 * MPH, 60 * MPH]),
    ("impact.angle=10deg,15deg", "rad", [math.radians(10), math.radians(15)]),
]


@pytest.mark.parametrize(("varied", "unit", "exact"), NUMBERS)
def test_values_are_exact_in_si(varied, unit, exact):
    """The ends are those given, to the last digit."""
    (item,) = grid(varied).variations
    assert item.values == pytest.approx(exact, rel=1e-14 if "log" in varied else 4e-16)
    assert (item.values[0], item.values[-1]) == (exact[0], exact[-1])
    assert (item.settings, item.unit) == (item.values, unit)


def test_words_lists_and_whole_numbers():
    varied = ("plate.element=quad4,tri3", "plate.elements=[6,2],[12,4]", "time.rows=100:300:3")
    element, counts, rows = grid(*varied).variations
    assert (element.values, element.numeric) == (("quad4", "tri3"), False)
    assert (counts.values, counts.settings) == (("6 x 2", "12 x 4"), ((6, 2), (12, 4)))
    assert rows.values == rows.settings == (100, 200, 300)


def test_a_grid_has_every_combination_once():
    definition = grid("corner.friction=0.1,0.2,0.3", "plate.element=quad4,tri3")
    combinations = [tuple(definition.inputs_of(run).values()) for run in range(definition.runs)]
    assert combinations == [(f, e) for f in (0.1, 0.2, 0.3) for e in ("quad4", "tri3")]
    assert definition.changes_of(3) == {"corner.friction": 0.2, "plate.element": "tri3"}
    fixed = grid("corner.friction=0.1,0.2", changes=("strike.duration=0.2",))
    assert fixed.changes_of(1) == {"corner.friction": 0.2}
    assert fixed.source.tables["strike"] == {"duration": 0.2}


def test_samples_fill_their_ranges_evenly():
    """Each of 20 equal parts, or ratios, has one sample."""
    varied = ("corner.friction=0.1:0.5", "plate.youngs_modulus=log:1e9:1e11", "plate.element=quad4,tri3")
    definition = make_definition(SCENE, (), varied, 20, 307)
    friction, modulus, element = definition.variations
    shares = (np.array(friction.values) - 0.1) / 0.4, np.log10(np.array(modulus.values) / 1e9) / 2.0
    assert [sorted((share * 20).astype(int)) for share in shares] == [list(range(20))] * 2
    assert (sorted(element.values), definition.runs) == (["quad4"] * 10 + ["tri3"] * 10, 20)
    assert definition.inputs_of(4) == {item.key: item.values[4] for item in definition.variations}


def test_the_definition_on_disk_tells_sweeps_apart():
    one = grid("corner.friction=0:0.6:3").as_written()
    assert one == grid("corner.friction=0:0.6:3").as_written() == json.loads(json.dumps(one))
    assert one != grid("corner.friction=0:0.6:4").as_written()
    varied = ("corner.friction=0:0.6",)
    sampled = [make_definition(SCENE, (), varied, 5, seed).as_written() for seed in (1, 2)]
    assert sampled[0]["digest"] != sampled[1]["digest"]


FRICTION, KEY_VALUES = "corner.friction", "KEY=VALUES"
PLACES = {"file": "it is a file", "full": "the folder contains other files"}
PLACES |= {"file/below": "it is a file, or inside"}
WRONG_FRICTIONS = {
    **{"0:0.6": "a range is a:b:n", "0:0.6:1": "at least 2", "0:0.6:2.5": "a number n of values"},
    **{"0.3:0.3:4": "must differ", "log:0:0.6:4": "above 0", "-0.1:0.6:4": "from 0 to"},
    **{"0.1,,0.2": KEY_VALUES, "1:2:3:4": KEY_VALUES, "0:0.6:3 --sample 10": "a range is a:b or log:a:b"},
}
WRONG = [
    *((f"corner.friction={values}", FRICTION, message) for values, message in WRONG_FRICTIONS.items()),
    *(("corner.friction=", "--vary", KEY_VALUES), ("corner.friction", "--vary", KEY_VALUES)),
    *(("corner..friction=1,2", "--vary", KEY_VALUES), ("a:b:c:d=1", "a:b:c:d", "this key does not exist")),
    ("corner.colour=1,2", "corner.colour", "this key does not exist; allowed are reaction"),
    ("corner.reaction=drag,push", "corner.reaction", "allowed is 'drag', 'none' or 'signed'"),
    ("corner.reaction=drag:none:2", "corner.reaction", "a range requires numbers"),
    ("impact.speed='50 kg:60 kg:3'", "impact.speed", "the unit does not fit"),
    ("time.rows=100:200:4", "time.rows", "all values must be whole"),
    ("corner.friction=0:1:3 --vary corner.friction=1,2", "--vary", "is varied twice"),
    ("corner.friction=0:1:3 --set corner.friction=1", "--vary", "exclude each other"),
    ("corner.friction=0:1:2000 --vary plate.poissons_ratio=0:0.4:501", "--vary", "the limit is 1000000"),
    ("time.rows=100:200 --sample 10", "time.rows", "require a list"),
    ("corner.friction=0:1:3 --cluster tcp://x:1 --workers 2", "--workers", "exclude each other"),
    *((f"corner.friction=0:1:3 --out {place}", "--out", message) for place, message in PLACES.items()),
]


@pytest.mark.parametrize(("arguments", "key", "message"), WRONG)
def test_wrong_input_is_told_and_nothing_is_written(arguments, key, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("kept")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "summary.json").write_text("{}")
    assert _status(["sweep", SCENE, "--vary", *shlex.split(arguments)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"tailslap: {key}: given")
    assert message in " ".join(said.split())
    assert {path.name for path in tmp_path.rglob("*")} == {"file", "full", "summary.json"}


def test_a_scene_without_plate_is_refused(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text('name = "x"\n[vehicle]\nlength = 10\nwidth = 2.4\nmass = 9979\n')
    with pytest.raises(InputError, match=r"plate: given no value; this table is required"):
        make_definition(str(scene), (), ("vehicle.mass=1:2:3",), None, 307)


def rows(*varied, status="passed"):
    count = len(varied[0].values)
    rigid = {key: np.linspace(1.0, 2.0, count) for key in KEYS}
    difference = {key: np.geomspace(1e-6, 1e-3, count) for key in KEYS}
    fe = {key: rigid[key] * (1.0 + difference[key]) for key in KEYS}
    return SweepRows(varied, np.full(count, status, dtype=object), fe, rigid, difference)


def key(name, *values, logarithmic=False):
    numbers = all(not isinstance(value, str) for value in values)
    return Varied(name, "", np.array(values, dtype=float if numbers else object), logarithmic)


def names(*varied):
    """Names of plots, the six against a key as one."""
    plots = [curve.name for curve in draw_sweep(rows(*varied))]
    ends = tuple(f"-{key}" for key in (*KEYS, "difference"))
    return list(dict.fromkeys(next((n.removesuffix(e) for e in ends if n.endswith(e)), n) for n in plots))


def test_which_plots_there_are():
    """Numbers have charts, two keys also maps."""
    a, b = key("a.x", 1, 1, 2, 2), key("b.y", 1, 10, 1, 10, logarithmic=True)
    word, c = key("c.z", "p", "q", "p", "q"), key("d.w", 1, 2, 3, 4)
    assert names(a) == ["against-a-x"]
    assert names(a, b) == ["against-a-x", "against-b-y", "map-result", "map-worst", "map-status"]
    assert names(a, word) == ["against-a-x"]
    assert names(a, word, c) == ["against-a-x", "against-d-w"]
    nothing = rows(a)
    assert draw_sweep(replace(nothing, difference={k: np.full(4, np.nan) for k in KEYS})) == ()


def values_drawn(curves):
    return sum(len(column.values) for c in curves for column in samples(c) if ": " in column.heading)


def test_each_row_is_a_point():
    """13 marks a row are a rigid and six FE ones.

    The differences are one more plot. Failed rows are repeated in red; rows without a result have none. The force has
    the width of the page.
    """
    a = key("a.x", 1, 2, 3)
    passed, failed = draw_sweep(rows(a)), draw_sweep(rows(a, status="failed"))
    assert ((len(passed), values_drawn(passed)), values_drawn(failed)) == ((7, 3 * 13), 3 * 13 + 3 * 6)
    assert (passed[0].name, passed[0].width, passed[1].width) == ("against-a-x-peak_force", FULL, PART)
    assert "a check failed" in failed[0].svg
    assert "a check failed" not in passed[0].svg


def test_of_very_many_rows_all_that_failed_are_drawn():
    """And the page stays small."""
    some = rows(key("a.x", *np.linspace(0.0, 0.9, 20_000)))
    some.status[777::4000] = "failed"
    curves = draw_sweep(some)
    assert sum(len(curve.svg) for curve in curves) < 1e6
    failed = samples(curves[0])[-1]
    assert failed.heading.startswith("FE, a check failed: ")
    assert len(failed.values) >= 5


def lowest_drawn(varied):
    first, *_ = draw_sweep(rows(varied))
    (low,) = re.findall(r'class="x-axis"[^>]*data-ends="(\S+) ', first.svg)
    return float(low)


def test_axes_show_no_negative_friction_and_do_not_begin_at_zero_over_decades():
    """The axis of moduli over decades begins at the smallest one."""
    assert lowest_drawn(key("impact.friction", 0.0, 0.3, 0.6, 0.9)) == 0.0
    assert 0.5e9 < lowest_drawn(key("plate.youngs_modulus", 1e9, 1e10, 1e12, logarithmic=True)) < 1e9


def test_maps_show_each_run():
    """Cells of a grid or points, failed runs in red."""
    a, b = key("a.x", 1, 1, 2, 2), key("b.y", 1, 10, 1, 10, logarithmic=True)
    some = rows(a, b)
    some.status[:] = ["refused", "passed", "failed", "passed"]
    some.fe["peak_force"][0] = np.nan
    result, _, status = draw_sweep(some)[-3:]
    (cells,), (statuses,) = samples(result), samples(status)
    value = cells.values[0]
    assert (cells.where, cells.at[0], value, len(cells.values)) == ("a.x; b.y", "1; 10", "0.0013333 kN", 3)
    assert statuses.at == ["1; 1", "1; 10", "2; 1", "2; 10"]
    (red,) = re.findall(r'<g class="red"[^>]*><path d="([^"]*)"', status.svg)
    assert red.count("M") == 1


def test_the_worst_of_the_five_differences():
    some = rows(key("a", 1, 2))
    changed = dict(some.difference) | {"omega": np.array([-0.5, 0.0]), "t": np.array([0.1, np.nan])}
    worst = replace(some, difference=changed).worst
    assert worst[0] == 0.5
    assert math.isnan(worst[1])


def sweep_of(some):
    """A sweep with these rows."""
    varied = [Variation(v.key, v.unit, tuple(v.values.tolist()), v.logarithmic) for v in some.varied]
    source = Source("name = 1")
    definition = Definition("a<b", source.text, (), source, (), tuple(varied), len(some.status), 307)
    statuses = {name: int((some.status == name).sum()) for name in ("passed", "failed", "refused", "error")}
    return FinishedSweep(definition, statuses, engine.CampaignEffort())


def page_of(some, reasons):
    sweep = sweep_of(some)
    return sweep_report.sweep_page(sweep, some, reasons, sweep_report.headline(sweep, some))


def test_the_page_holds_what_it_is_given(tmp_path):
    some = rows(key("a.x", 1, 1, 2, 2), key("b.y", 1, 10, 1, 10))
    some.status[:] = ["refused", "passed", "failed", "passed"]
    reasons = np.array(["beyond <theory>", "", "energy <balance>", ""], dtype=object)
    page = write_page(tmp_path / "report.html", page_of(some, reasons)).read_text()
    plain = page.replace("\N{NO-BREAK SPACE}", " ")
    statuses = "2 passed all checks, 1 failed a check, 1 refused"
    for text in ("a&lt;b", statuses, "name = 1", "+1.00×10⁻³", "1, 10"):
        assert text in plain
    assert plain.index("energy &lt;balance&gt;") < plain.index("beyond &lt;theory&gt;")
    assert plain.count('<tr class="failed">') == 1
    assert "The first" not in plain
    assert page.count("<svg") - page.count("<template>") == 17, "charts in other units are templates"
    assert "http" not in page.replace("http://www.w3.org", "").replace("http-equiv", "")


def test_a_page_of_runs_that_were_all_refused(tmp_path):
    """The page has the first rows and their number, without plots."""
    count = sweep_report.MAX_LISTED + 5
    some = rows(key("a.x", *range(count)), status="refused")
    nothing = replace(some, difference={k: np.full(count, np.nan) for k in KEYS})
    page = page_of(nothing, np.full(count, "no", dtype=object))
    text = write_page(tmp_path / "e.html", page).read_text()
    assert "<svg" not in text
    assert f"First {sweep_report.MAX_LISTED} of {count}" in text.replace("\N{NO-BREAK SPACE}", " ")
    assert "At the tail-slap" not in text
    assert "did not pass" not in write_page(tmp_path / "p.html", all_passed()).read_text()


def all_passed():
    some = rows(key("a.x", 1, 2, 3))
    return page_of(some, np.full(3, "", dtype=object))


def test_the_largest_differences():
    some = rows(key("a.x", 1, 2, 3))
    some.status[2] = "failed"
    (time, *_) = sweep_report.spreads(some)
    assert (time["run"], time["difference"]) == (1, some.difference["t"][1])
    assert (time["least"], time["most"]) == (some.fe["t"][0], some.fe["t"][1])


def test_what_the_terminal_says():
    finished = replace(sweep_of(rows(key("a.x", 1, 2, 3))), report=Report(all_passed(), {}, ()))
    lines = sweep_report.sweep_text(finished, Path("results/x")).splitlines()
    assert lines[-2] == "3 runs: 3 passed all checks. Finite elements and rigid body differ by at most"
    files = ["Table:  results/x/sweep.parquet", "Report: results/x/report.html"]
    assert lines[:-2] == ["Cost:   no runs remained", "", "Varied: a.x 1, 2, 3.", *files, ""]


def test_words():
    angle = Variation("impact.angle", "rad", (math.radians(10), math.radians(15)), False)
    assert SI.rendered(sweep_report.values_words(angle)) == "10 deg, 15 deg"
    modulus = Variation("e", "Pa", (1e8, 1e9, 1e10, 1e11, 1e12, 1e13), True)
    assert SI.rendered(sweep_report.values_words(modulus)) == "1e+08 Pa to 1e+13 Pa, in equal ratios"
    assert (sweep_report.shown("quad4", ""), SI.rendered(sweep_report.shown(0.25, ""))) == ("quad4", "0.25")


def test_rate_and_overhead_by_hand():
    """Two threads leave 0.05 s for each run.

    100 runs of 0.15 s on two threads in 10 s.
    """
    effort = engine.CampaignEffort(100, 2, 10.0, 15.0)
    assert (effort.rate, effort.overhead_s) == (10.0, pytest.approx(0.05))
    assert (engine.CampaignEffort().rate, engine.CampaignEffort().overhead_s) == (0.0, 0.0)
    assert [clock(seconds) for seconds in (0.4, 59.6, 61, 3725)] == ["0:00", "1:00", "1:01", "1:02:05"]


def test_progress_where_there_is_no_terminal(monkeypatch, capsys):
    """The remaining time follows from the rate.

    40 runs in 40 s after a silent start leave 0:40.
    """
    now = [0.0]
    monkeypatch.setattr("tailslap.progress.time.monotonic", lambda: now[0])
    with counted("sut", 90, 10) as show:
        now[0] = 5.0
        show(20)
        assert capsys.readouterr().err == ""
        now[0] = 40.0
        show(50, ", 1 failed")
    line = capsys.readouterr().err
    assert line == "tailslap: sut: 50 of 90, 1/s, 0:40 left, 1 failed\n"
