"""Verify comparisons of histories, and the files of other programs.

Further subjects are relative differences by hand, the paper's printed table and orders of known sequences.
"""

import csv
import json
import math
import os
import re

import numpy as np
import pytest

import tailslap
from postprocess.comparison import grid_convergence, metrics
from postprocess.comparison.quantities import PAPER_TABLE_3, comparison_rows, relative_difference
from tailslap import InputError, cli
from tailslap.comparing import source
from tailslap.comparing.compare_report import compare_items
from tailslap.comparing.source import Item, parse_mapping, read_table

T = np.linspace(0.0, 1.0, 1001)


@pytest.fixture(scope="module")
def result():
    return tailslap.run("paper-table-3")


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    return result.save(tmp_path_factory.mktemp("compare") / "reference", pictures=False)


def beside(ours, reference):
    """Compare two histories of one column, which have times in common."""
    comparison = metrics.beside("v", ours, reference)
    assert comparison is not None
    return comparison


def command(*arguments):
    return cli._status(["compare", *arguments])


def their_file(path, result, head, factor=1.0):
    """A history of another program at other instants, in other units.

    Its time is in milliseconds, v_GY has the other sign, v_GX is in mph.
    """
    t = np.linspace(0.01, 0.37, 777)
    h = result.history
    v_y, v_x = (np.interp(t, h["t"], h[name]) for name in ("v_gy", "v_gx"))
    rows = zip(1e3 * t, -factor * v_y, v_x / 0.44704, strict=True)
    path.write_text(head + "".join(f"{a:.10g};{b:.10g};{c:.10g}\n" for a, b, c in rows))
    return path


def test_metrics_of_a_scaled_and_of_a_late_history():
    """Twice as large is M = 1, late is P = 0.02."""
    reference = {"t": T, "v": np.sin(2.0 * np.pi * T)}
    twice = beside({"t": T, "v": 2.0 * reference["v"]}, reference)
    late = beside({"t": T, "v": np.sin(2.0 * np.pi * (T - 0.01))}, reference)
    assert twice.metrics.magnitude == pytest.approx(1.0, abs=1e-12)
    assert (twice.metrics.phase, twice.largest[0]) == (pytest.approx(0.0, abs=1e-7), pytest.approx(1.0))
    assert not twice.within
    assert late.metrics.magnitude == pytest.approx(0.0, abs=1e-12)
    assert late.metrics.phase == pytest.approx(0.02, rel=1e-6)
    assert late.within


def test_residuals_of_a_shifted_history():
    reference = {"t": T, "v": 4.0 - T}
    measures = beside({"t": T, "v": reference["v"] + 0.4}, reference)
    assert measures.metrics.mean_residual == pytest.approx(0.1)
    assert measures.metrics.deviation == pytest.approx(0.0, abs=1e-12)
    assert measures.at_end == pytest.approx(0.4 / 3.0)
    assert not measures.within  # the mean residual is beyond 5 %


def test_only_the_common_time_counts():
    reference = {"t": T, "v": T}
    measures = beside({"t": T[200:500:3] + 1e-5, "v": T[200:500:3] + 1e-5}, reference)
    assert (measures.t[0], measures.t[-1]) == (T[200] + 1e-5, T[497] + 1e-5)
    assert measures.covered == pytest.approx(0.297, rel=1e-10)
    assert not measures.within  # less than half of the reference's time
    np.testing.assert_allclose(measures.value, measures.reference, atol=1e-12)
    assert metrics.beside("v", {"t": T + 2.0, "v": T}, reference) is None


def test_rows_that_are_not_finite_are_left_out():
    values = np.where(T > 0.5, np.nan, T)
    measures = beside({"t": T, "v": values}, {"t": T, "v": T})
    assert measures.t[-1] == 0.5
    assert measures.covered == pytest.approx(0.5, rel=1e-12)


def test_a_gap_is_not_interpolated():
    """The rest agrees over 0.625 of the time, in either order."""
    wild = {"t": T, "v": np.where((T > 0.25) & (T < 0.625), 50.0, T)}
    rows = T[(T <= 0.25) | (T >= 0.625)]
    part = {"t": rows, "v": rows}
    for measures in (beside(part, wild), beside(wild, part)):
        assert measures.gaps == ((0.25, 0.625),)
        assert measures.covered == pytest.approx(0.625, rel=1e-12)
        assert {*vars(measures.metrics).values()} == {0.0}
        assert measures.largest[0] == 0.0


def test_a_gap_of_missing_values_is_one_too():
    values = np.where((T > 0.25) & (T < 0.625), np.nan, T)
    measures = beside({"t": T, "v": values}, {"t": T, "v": T})
    assert measures.gaps == ((0.25, 0.625),)


def test_even_and_dense_rows_have_no_gaps():
    """Five even rows, dense rows in a strike, and a short flight."""
    coarse = np.linspace(0.0, 1.0, 5)
    crowded = np.unique(np.r_[np.linspace(0.0, 1.0, 26), np.linspace(0.5, 0.6, 1001)])
    for t in (coarse, crowded):
        measures = beside({"t": t, "v": t}, {"t": T, "v": T})
        assert (measures.gaps, measures.covered) == ((), 1.0)


def test_rows_of_the_finer_history_count_too():
    """A peak between rows counts by its area of 0.001."""
    reference = {"t": np.linspace(0.0, 1.0, 11), "v": np.full(11, 2.0)}
    value = 2.0 + (np.arange(T.size) == 250)
    measures = beside({"t": T, "v": value}, reference)
    assert measures.metrics.mean_residual == pytest.approx(0.0005, rel=1e-10)
    assert measures.largest == (pytest.approx(0.5, rel=1e-12), T[250])


def test_another_programs_file_is_compared_in_si(result, folder, tmp_path):
    path = their_file(tmp_path / "abaqus.csv", result, "# made by hand\nTIME;VY;VX\n[ms];[m/s];[mph]\n", 1.02)
    comparison = tailslap.compare(folder, path, columns={"v_gy": "-VY", "v_gx": "VX"})
    columns = comparison.summary["compared"]["abaqus"]
    assert columns["v_gy"]["magnitude"] == pytest.approx(0.02, rel=1e-6)
    assert columns["v_gx"]["largest"] == pytest.approx(0.0, abs=1e-5)
    assert 0.01 <= columns["v_gx"]["from"] < columns["v_gx"]["to"] <= 0.37
    assert comparison.passed
    assert comparison.summary["notes"] == []


def test_units_may_be_in_the_names_or_in_the_mapping(result, folder, tmp_path):
    in_names = their_file(tmp_path / "a.csv", result, "Time (ms);VY;VX [mph]\n")
    mapped = their_file(tmp_path / "b.csv", result, "a;VY;VX\n")
    one = tailslap.compare(folder, in_names, columns="v_gy=-VY,v_gx=VX")
    two = tailslap.compare(folder, mapped, columns="time=a [ms],v_gy=-VY,v_gx=VX [mph]")
    assert one.summary["compared"]["a"] == two.summary["compared"]["b"]
    assert one.summary["notes"] == ["a.csv: v_gy without a unit, assumed in SI."]


def test_a_mapping_is_of_the_files_that_need_it(result, folder, tmp_path):
    path = their_file(tmp_path / "their.csv", result, "time [ms];VY;VX [mph]\n")
    comparison = tailslap.compare(folder / "rigid.csv", path, columns="time=time,v_gy=-VY,v_gx=VX")
    assert comparison.passed
    assert {*comparison.summary["compared"]["their"]} == {"v_gx", "v_gy"}


def test_results_are_compared_by_command_and_function(result, folder, tmp_path, capsys):
    soft = tailslap.run("paper-table-3", {"plate.youngs_modulus": "20 GPa"})
    other = soft.save(tmp_path / "soft", pictures=False)
    assert command(str(folder), str(other), "--json", "--out", str(tmp_path / "page")) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == tailslap.compare(folder, other).summary
    assert printed == json.loads((tmp_path / "page" / "summary.json").read_text())
    page = (tmp_path / "page" / "report.html").read_text()
    charts = set(re.findall(r'download="([^"]+)\.svg"', page))
    assert len(charts) == 2 * len(printed["compared"]["soft"])
    number = printed["compared"]["soft"]["v_gy"]
    assert 0.0 < abs(number["largest"]) < 1e-4
    same = tailslap.compare(result, folder).summary["compared"]["reference"]
    assert {measures["combined"] for measures in same.values()} == {0.0}


def test_beyond_the_limits_the_exit_status_is_one(result, folder, tmp_path):
    path = their_file(tmp_path / "far.csv", result, "time [ms];VY [m/s];VX [mph]\n", 2.0)
    mapping = ("--columns", "v_gy=-VY,v_gx=VX")
    assert command(str(folder), str(path), *mapping, "--out", str(tmp_path / "a")) == 1
    only = ("--only", "v_gx")
    assert command(str(folder), str(path), *mapping, *only, "--out", str(tmp_path / "b")) == 0


def test_the_table_fits_eighty_columns(folder, tmp_path, capsys):
    command(str(folder), str(folder / "rigid.csv"), "--out", str(tmp_path / "a"))
    table = capsys.readouterr().out
    assert "reaction_tangential" in table
    assert max(map(len, table.splitlines()[:11])) <= 80


@pytest.mark.parametrize(("text", "why"), [
    ("1,2\n3,4\n5,6\n", "its first line has no column names"), ("t,v_gy\n0,1\n", "fewer than two rows"),
    ("a,v_gy\n0,1\n1,2\n", "it has no time column"),
    ("t,v_gy\n1,1\n0,2\n", "line 3: time does not increase from row to row, 0 s after 1 s"),
    ("t,v_gy\n0,1\n\n,2\n", "line 4: the instant is missing"),
    ("t;v_gy\n0;1\n1\n", "line 3 is cut short: 1 entries for 2"),
    ("t,colour\n0,1\n1,2\n", "no column with two values at times in common"),
    ("t,v_gy [kg]\n0,1\n1,2\n", "allowed is a unit of the dimension of m/s"),
    ("t;v_gy\n0,0;1,5\n0,1;2,5\n", "the decimal separator is a point"),
    ("t v_gy\n0 1,5\n1 2,5\n", "the decimal separator is a point"),
    ("t,v_gy\n0,0,1,5\n0,1,2,5\n", "4 entries for 2 names"),
    ("t,v_gy,v_gy\n0,1,2\n1,2,3\n", "two columns v_gy"),
    ("t,x_g [km]\n0,1\n0.1,9e29\n0.2,1\n",
     r"line 3, column x_g: 9e\+32 in SI; allowed are numbers of at most 1e\+30"),
    ("t,v_gy\n0,\0\n1,2\n", "neither text in UTF-8"), (f't,v_gy\n0,"{"1" * 200_000}"\n1,2\n', "field larger"),
])  # fmt: skip
def test_files_that_are_no_histories_are_refused(text, why, folder, tmp_path):
    path = tmp_path / "wrong.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=why):
        tailslap.compare(folder, path)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_encodings_of_windows(encoding, tmp_path):
    path = tmp_path / "\u00b5.csv"
    path.write_bytes("t [s];v_gy [m/s];\u00b5\r\n0;1.5;1\r\n1;2.5;1\r\n".encode(encoding))
    cells = read_table(path)
    assert cells.names[:2] == ["t", "v_gy"]
    np.testing.assert_array_equal(cells.numbers("v_gy"), [1.5, 2.5])
    assert (cells.units["t"], cells.units["v_gy"]) == ("s", "m/s")


def test_devices_and_pipes_are_refused(folder, tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe")
    for name in ("/dev/zero", str(tmp_path / "pipe")):
        assert command(str(folder), name) == 2
        assert "not a regular file" in capsys.readouterr().err


def test_a_large_file_is_refused(monkeypatch, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t,v\n0,1\n1,2\n")
    monkeypatch.setattr(source, "MAX_BYTES", 5)
    with pytest.raises(ValueError, match="too large; the limit is 5 bytes"):
        read_table(path)


def test_a_name_is_no_formula_of_a_spreadsheet(result, folder, tmp_path):
    """The label of a file in metrics.csv is its name."""
    path = their_file(tmp_path / '=HYPERLINK("x").csv', result, "time [ms];VY;VX [mph]\n")
    page = tailslap.compare(folder, path, columns="v_gy=-VY,v_gx=VX").save(tmp_path / "page")
    rows = list(csv.reader((page / "metrics.csv").read_text().splitlines()))
    assert {row[0] for row in rows[1:]} == {'\'=HYPERLINK("x")'}
    assert not [cell for row in rows for cell in row if cell.startswith(("=", "@", "+"))]


def test_what_is_not_there_is_refused(folder, tmp_path):
    for mapping, only, message in (
        ((folder, tmp_path / "none.csv"), (), "the file or folder does not exist"),
        ((folder,), (), "two or more results are required"),
        ((folder, folder), ("colour",), "allowed are the common columns"),
        ((folder, tmp_path), (), r"it has no readable summary\.json"),
    ):
        with pytest.raises(InputError, match=message):
            tailslap.compare(*mapping, only=only)
    assert command(str(folder), str(tmp_path / "none.csv")) == 2


@pytest.mark.parametrize("text", ["", "v_gy", "=VY", "v_gy="])
def test_a_mapping_names_both(text):
    with pytest.raises(InputError, match="allowed is NAME=THEIRS"):
        parse_mapping(text)


def test_columns_apart_by_blanks_and_missing_values(tmp_path):
    path = tmp_path / "blank.txt"
    path.write_text("$ LS-DYNA\ntime  vy\n0.0  1.0\n0.1 NaN\n# more\n0.2  2.0\n")
    cells = read_table(path)
    np.testing.assert_array_equal(cells.numbers("time"), [0.0, 0.1, 0.2])
    np.testing.assert_array_equal(cells.numbers("vy"), [1.0, np.nan, 2.0])
    assert cells.lines == [3, 4, 6]


def written(path, t, unit="s", **columns):
    """A file with these columns of motion, empty where they are NaN."""
    heads = ",".join([f"time [{unit}]" if unit else "time", *columns])
    rows = np.column_stack([t, *columns.values()]).tolist()
    lines = (",".join(f"{x:.10g}" for x in row).replace("nan", "") for row in rows)
    path.write_text("\n".join([heads, *lines, ""]))
    return path


@pytest.mark.parametrize("cell", ["inf", "-Infinity", "1e999", "1e308", "1e31", "nonsense", "1_0"])
def test_cells_without_a_number_are_refused_by_line_and_column(cell, folder, tmp_path, capsys):
    path = tmp_path / "their.csv"
    path.write_text(f"# by hand\nTIME;VY;note\n0;-3;\n0.1;{cell};word\n0.2;-3;\n")
    mapping = ("--columns", "time=TIME,v_gy=VY", "--out", str(tmp_path / "page"))
    assert command(str(folder), str(path), *mapping) == 2
    message = capsys.readouterr().err
    assert f'line 4, column VY: given "{cell}"; allowed are numbers of at most 1e+30' in message
    assert not (tmp_path / "page").exists()


def test_histories_in_memory_are_held_to_the_same():
    """They are read by the same function as those of results."""
    sound = Item("sound", {"t": T, "v_gy": 1.0 - T}, {})
    missing = (7, "v_gy", "row 8, column v_gy: inf in SI"), (3, "t", "row 4: the instant is missing")
    for k, name, why in missing:
        columns = {column: values.copy() for column, values in sound.columns.items()}
        columns[name][k] = np.inf
        with pytest.raises(InputError, match=why):
            compare_items([sound, Item("wrong", columns, {})])


def test_many_columns_are_refused(folder, tmp_path):
    path = tmp_path / "wide.csv"
    names = ["t", "v_gy", *(f"c{k}" for k in range(999))]
    for columns in (1000, 1001):
        values = (columns - 1) * ["1"]
        rows = [",".join(names[:columns]), *(",".join([str(0.3 * k), *values]) for k in range(2))]
        path.write_text("\n".join(rows) + "\n")
        if columns == 1000:
            assert len(read_table(path).names) == 1000
    with pytest.raises(InputError, match="it has 1001 columns; allowed are at most 1000"):
        tailslap.compare(folder, path)


def part_of(result, first=0.0, last=1.0, rows=400):
    """Instants and v_gy between parts of the time of a result."""
    times, v_gy = (np.asarray(result.history[name]) for name in ("t", "v_gy"))
    t = np.linspace(first * times[-1], last * times[-1], rows)
    return t, np.interp(t, times, v_gy)


def test_milliseconds_without_a_unit_are_refused_with_the_option_that_gives_it(
    result, folder, tmp_path, capsys
):
    t, v_gy = part_of(result)
    path = written(tmp_path / "their.csv", 1e3 * t, "", v_gy=v_gy)
    assert command(str(folder), str(path)) == 2
    message = capsys.readouterr().err
    assert "their lasts 384 s and reference 0.384 s if times without a unit are seconds" in message
    advice = message.rpartition("--columns ")[2].strip().strip('"')
    assert tailslap.compare(folder, path, columns=advice).summary["notes"] == []


def test_a_unit_in_a_file_holds_against_one_of_the_option(result, folder, tmp_path):
    """Columns of this program's files are in SI for any option."""
    t, v_gy = part_of(result)
    path = written(tmp_path / "their.csv", 1e3 * t, "", v_gy=v_gy).rename(tmp_path / "a.csv")
    path.write_text(path.read_text().replace("time", "t"))
    comparison = tailslap.compare(folder / "rigid.csv", path, columns="time=t [ms],v_gy=v_gy [m/s]")
    assert comparison.passed
    assert comparison.summary["compared"]["a"]["v_gy"]["to"] == pytest.approx(t[-1])
    assert comparison.summary["notes"] == ["rigid.csv: t is in s by the file, not in ms."]
    copy = tmp_path / "copy.csv"
    copy.write_bytes((folder / "rigid.csv").read_bytes())
    with pytest.raises(InputError, match=r"a lasts 0\.384 s and copy 0\.000384 s"):
        tailslap.compare(copy, path, columns="time=t [ms]")


def test_a_few_rows_of_the_record_are_not_enough(result, folder, tmp_path, capsys):
    """Four rows over 2.8 of 384 ms."""
    t, v_gy = part_of(result, 0.0, 0.0028 / 0.384, 4)
    path = written(tmp_path / "their.csv", t, "s", v_gy=v_gy)
    assert command(str(folder), str(path), "--out", str(tmp_path / "page")) == 1
    output = capsys.readouterr().out
    assert "Failed: compared for less than 50 % of the time of the reference: v_gy of their." in output
    assert "their: v_gy compared for 0.7 % of the 0.384 s of reference." in output
    assert command(str(folder), str(written(path, t, "", v_gy=v_gy))) == 2
    assert "time [ms]" in capsys.readouterr().err


def test_half_of_the_record_is_enough_and_named(result, folder, tmp_path):
    for part, passed in ((0.55, True), (0.45, False)):
        t, v_gy = part_of(result, 0.0, part)
        comparison = tailslap.compare(folder, written(tmp_path / "their.csv", t, v_gy=v_gy))
        assert comparison.passed == passed
        assert comparison.summary["notes"] == [
            f"their: v_gy compared for {100 * part:g} % of the 0.384 s of reference."
        ]
        assert comparison.summary["compared"]["their"]["v_gy"]["within"] == passed


def test_missing_values_and_gaps_are_named_everywhere(result, folder, tmp_path, capsys):
    """Terminal, summary and both pages name them."""
    t, v_gy = part_of(result, rows=401)
    v_gy[[10, 12]] = np.nan
    v_gy[101:200] = np.nan
    path = written(tmp_path / "their.csv", t, v_gy=v_gy)
    assert command(str(folder), str(path), "--out", str(tmp_path / "page")) == 0
    output = " ".join(capsys.readouterr().out.split())
    summary = json.loads((tmp_path / "page" / "summary.json").read_text())
    assert summary["notes"] == [
        "their: v_gy without a value in 101 of 401 rows, interpolated or excluded.",
        "their: v_gy not compared from 0.09599 to 0.192 s, a gap of one of both.",
        "their: v_gy compared for 75 % of the 0.384 s of reference.",
    ]
    pages = [(tmp_path / "page" / name).read_text() for name in ("report.html", "validation.html")]
    pages = [page.replace("\N{NO-BREAK SPACE}", " ") for page in pages]
    for note in summary["notes"]:
        assert note in output
        assert all(note.partition("v_gy")[2] in page for page in pages)


def test_a_column_without_values_is_named(result, folder, tmp_path):
    t, v_gy = part_of(result)
    path = written(tmp_path / "their.csv", t, v_gy=v_gy, v_gx=np.nan * t)
    comparison = tailslap.compare(folder, path)
    assert comparison.summary["notes"] == ["their: no values at times of reference, not compared: v_gx."]
    with pytest.raises(InputError, match="it has no v_gx with two values"):
        tailslap.compare(folder, path, only=["v_gx", "v_gy"])


def test_a_spike_between_rows_of_a_coarser_reference_is_seen(tmp_path):
    """500 kN are in one row, between rows of the reference."""
    t = np.linspace(0.0, 0.4, 4001)
    force = 650e3 * np.sin(np.pi * t / 0.4)
    spiked = force - 500e3 * (np.arange(t.size) == 2050)
    reference = written(tmp_path / "test.csv", t[::100], force_normal=force[::100])
    comparison = tailslap.compare(reference, written(tmp_path / "fine.csv", t, force_normal=spiked))
    numbers = comparison.summary["compared"]["fine"]["force_normal"]
    assert numbers["largest"] == pytest.approx(-500.0 / 650.0, rel=2e-3)
    assert numbers["at"] == pytest.approx(0.205)
    (note,) = comparison.summary["notes"]
    assert note.startswith(
        "fine: force_normal differs by 77 % of the peak at 0.205 s; the metrics, means over time"
    )


FE = {"t": 0.5, "v_gx": 22.0, "v_gy": -3.0, "omega": 0.75, "slide": 9.0}
RIGID = {"t": 0.4, "v_gx": 20.0, "v_gy": -4.0, "omega": 0.75, "slide": 10.0}


def test_relative_difference_by_hand():
    difference = relative_difference(FE, RIGID)
    assert list(difference) == ["t", "v_gx", "v_gy", "omega", "slide"]
    expected = {"t": 0.25, "v_gx": 0.1, "v_gy": -0.25, "omega": 0.0, "slide": -0.1}
    assert difference == pytest.approx(expected, abs=1e-15)


def test_keys_choose_the_quantities():
    assert relative_difference({"a": 3.0, "b": 1.0}, {"a": 2.0, "b": 1.0}, keys=("a",)) == {"a": 0.5}


@pytest.mark.parametrize(("fe", "expected"), [(0.0, 0.0), (1e-300, math.inf), (-2.0, -math.inf)])
def test_against_zero_only_zero_agrees(fe, expected):
    assert relative_difference({"t": fe}, {"t": 0.0}, keys=("t",)) == {"t": expected}


def test_not_a_number_stays_one():
    difference = relative_difference({"t": math.nan}, {"t": 1.0}, keys=("t",))["t"]
    assert not difference <= 1.0


def test_paper_table_3_as_printed():
    columns = {name: list(values.items()) for name, values in PAPER_TABLE_3.items()}
    names = ("t", "v_gx", "v_gy", "omega", "slide")
    assert columns["analytical"] == [*zip(names, (0.383, 23.270, -3.274, 0.65, 9.420), strict=True)]
    assert columns["abaqus"] == [*zip(names, (0.37, 23.305, -3.289, 0.66, 8.915), strict=True)]


def test_paper_analytical_column_is_the_rounded_exact_solution():
    values = (0.3839597401, 23.2733311090, -3.2755267205, 0.6551053441, 9.4236754419)
    exact = dict(zip(PAPER_TABLE_3["analytical"], values, strict=True))
    for key, difference in relative_difference(PAPER_TABLE_3["analytical"], exact).items():
        assert abs(difference) < 0.01, key


def test_rows_hold_everything_a_table_shows():
    rows = comparison_rows(FE, RIGID)
    assert [row.quantity.key for row in rows] == list(FE)
    v_gy = rows[2]
    assert (v_gy.quantity.symbol, v_gy.quantity.unit) == ("v_GY", "m/s")
    assert (v_gy.fe, v_gy.rigid, v_gy.difference) == (-3.0, -4.0, -0.25)
    assert (v_gy.paper_analytical, v_gy.paper_abaqus) == (-3.274, -3.289)


def test_rows_of_a_scene_that_is_not_the_papers():
    papers = {(row.paper_analytical, row.paper_abaqus) for row in comparison_rows(FE, RIGID, None)}
    assert papers == {(None, None)}


PERIODS = np.linspace(0.0, 6.0 * np.pi, 3001)
"""Three whole periods of a sine, over which the trapezoidal rule is exact."""


@pytest.mark.parametrize("factor", [0.3, 1.0, 1.0 + 1e-9, 2.5])
def test_a_scaled_signal_differs_in_magnitude_alone(factor):
    signal = np.exp(-0.1 * PERIODS) * np.cos(PERIODS)
    measures = metrics.compare_histories(PERIODS, factor * signal, signal)
    assert measures.magnitude == pytest.approx(factor - 1.0, abs=1e-14)
    assert measures.phase == pytest.approx(0.0, abs=1e-14)
    assert measures.combined == pytest.approx(abs(factor - 1.0), abs=1e-14)


@pytest.mark.parametrize("shift", [1e-9, 1e-3, 0.5, 2.0, math.pi])
def test_a_sine_with_a_phase_shift(shift):
    measures = metrics.compare_histories(PERIODS, np.sin(PERIODS - shift), np.sin(PERIODS))
    assert measures.phase == pytest.approx(shift / math.pi, rel=1e-6, abs=1e-15)
    assert measures.magnitude == pytest.approx(0.0, abs=1e-13)


def test_magnitude_and_phase_combine_as_the_sides_of_a_right_angle():
    measures = metrics.compare_histories(PERIODS, 1.3 * np.sin(PERIODS - 0.4 * math.pi), np.sin(PERIODS))
    assert measures.combined == pytest.approx(0.5, abs=1e-12)


def test_a_constant_offset_is_all_mean_and_no_deviation():
    """It is relative to the peak of the reference, with its sign."""
    reference = -4.0 - np.sin(PERIODS)
    measures = metrics.compare_histories(PERIODS, reference - 0.25, reference)
    assert measures.mean_residual == pytest.approx(-0.05, abs=1e-14)
    assert measures.deviation == pytest.approx(0.0, abs=1e-14)


def test_a_wave_on_top_is_all_deviation():
    reference = 2.0 + 0.0 * PERIODS
    measures = metrics.compare_histories(PERIODS, reference + 0.6 * np.sin(PERIODS), reference)
    assert measures.mean_residual == pytest.approx(0.0, abs=1e-14)
    assert measures.deviation == pytest.approx(0.3 / math.sqrt(2.0), abs=1e-12)


def test_it_is_time_that_counts_and_not_rows():
    """The mean over time is that of the trapezoids, -0.07."""
    instants = np.array([0.0, 0.01, 0.02, 0.03, 0.04, 0.1, 0.9, 1.0])
    residual = np.where(instants < 0.05, -1.0, 0.0)
    measures = metrics.compare_histories(instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    assert measures.mean_residual == pytest.approx(-(0.04 + 0.5 * 0.06), abs=1e-15)
    later = metrics.compare_histories(7.0 + 3.0 * instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    for name in ("magnitude", "phase", "mean_residual", "deviation"):
        assert getattr(later, name) == pytest.approx(getattr(measures, name), abs=1e-13)


def test_the_trapezoidal_rule_converges_in_second_order():
    """exp against 1 on [0, 1] has closed forms of its norms.

    M = sqrt((e^2 - 1)/2) - 1 and cos(pi P) = (e - 1) sqrt(2/(e^2 - 1)).
    """
    square = (math.e**2 - 1.0) / 2.0
    exact = (math.sqrt(square) - 1.0, math.acos((math.e - 1.0) / math.sqrt(square)) / math.pi)
    errors = []
    for rows in (20, 40, 80):
        t = np.linspace(0.0, 1.0, rows + 1)
        measures = metrics.compare_histories(t, np.exp(t), np.ones_like(t))
        errors.append([abs(measures.magnitude - exact[0]), abs(measures.phase - exact[1])])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.01)
    assert max(errors[-1]) < 1e-4


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_give_none_that_could_pass(value):
    history = np.sin(PERIODS)
    history[7] = value
    measures = metrics.compare_histories(PERIODS, history, np.sin(PERIODS))
    assert all(math.isnan(x) for x in vars(measures).values())


def test_nothing_to_compare_gives_none():
    for rows in (0, 1):
        few = np.ones(rows)
        assert all(math.isnan(x) for x in vars(metrics.compare_histories(few, few, few)).values())
    zero = metrics.compare_histories(PERIODS, np.sin(PERIODS), 0.0 * PERIODS)
    assert all(math.isnan(x) for x in vars(zero).values())


def test_published_example():
    """The example of the NPARC Alliance, "Examining Spatial (Grid) Convergence".

    p = 1.786170, limit 0.97130, GCI 0.103083 and 0.356249 %.
    """
    estimate = grid_convergence.grid_convergence((0.97050, 0.96854, 0.96178), (2.0, 2.0))
    assert estimate.order == pytest.approx(1.786170, abs=5e-7)
    assert estimate.extrapolated == pytest.approx(0.97130, abs=5e-6)
    assert 100.0 * estimate.gci_fine == pytest.approx(0.103083, abs=5e-7)
    assert (100.0 * estimate.gci_coarse, estimate.behaviour) == (
        pytest.approx(0.356249, abs=5e-7),
        "converging",
    )
    assert estimate.asymptotic == pytest.approx(1.0, abs=3e-3)


@pytest.mark.parametrize("order", [0.8, 1.7, 4.0])
@pytest.mark.parametrize("ratios", [(2.0, 2.0), (1.5, 2.2), (3.0, 1.2)])
def test_power_law_is_found_exactly(order, ratios):
    sizes = (1.0, ratios[0], ratios[0] * ratios[1])
    values = tuple(5.0 - 0.01 * size**order for size in sizes)
    estimate = grid_convergence.grid_convergence(values, ratios)
    assert estimate.order == pytest.approx(order, rel=1e-9)
    assert estimate.extrapolated == pytest.approx(5.0, rel=1e-12)
    assert estimate.error == pytest.approx(0.01 / 4.99, rel=1e-9)
    assert estimate.gci_fine == pytest.approx(1.25 * estimate.error, rel=1e-9)
    assert estimate.gci_coarse == pytest.approx(1.25 * 0.01 * sizes[1] ** order / values[1], rel=1e-9)


@pytest.mark.parametrize(("values", "behaviour"), [
    ((1.0, 1.1, 0.9), "oscillating"), ((1.0, 2.0, 2.5), "diverging"), ((2.0, 2.0, 2.0), "settled"),
    ((3.9, 3.6, 3.29), "slow"),  # a logarithm: it grows by the same with every halving
])  # fmt: skip
def test_values_that_do_not_converge_are_not_extrapolated(values, behaviour):
    estimate = grid_convergence.grid_convergence(values, (2.0, 2.0))
    assert (estimate.behaviour, estimate.extrapolated) == (behaviour, values[0])
    if behaviour != "settled":
        assert estimate.gci_fine == pytest.approx(3.0 * abs(values[0] - values[1]) / values[0])


def test_no_order_for_a_quotient_that_no_power_law_has():
    assert grid_convergence.observed_order(0.1, (1.5, 2.2)) == -math.inf


def test_ratios_must_be_above_one():
    with pytest.raises(ValueError, match="above 1"):
        grid_convergence.grid_convergence((1.0, 2.0, 3.0), (1.0, 2.0))
