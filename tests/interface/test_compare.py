"""Verify comparisons of histories with files of other programs, and refused files."""

import csv
import json
import os
import re

import numpy as np
import pytest

import tailslap
from tailslap import InputError, cli
from tailslap.comparing import text_tables
from tailslap.comparing.compare_report import compare_items
from tailslap.comparing.source import Item, parse_mapping
from tailslap.comparing.text_tables import read_table
from tailslap.result.columns import column_units


@pytest.fixture(scope="module")
def result():
    return tailslap.run("paper-table-3")


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    return result.save(tmp_path_factory.mktemp("compare") / "reference", pictures=False)


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


def test_another_programs_file_is_compared_in_si(result, folder, tmp_path):
    path = their_file(tmp_path / "abaqus.csv", result, "# made by hand\nTIME;VY;VX\n[ms];[m/s];[mph]\n", 1.02)
    comparison = tailslap.compare(folder, path, columns={"v_gy": "-VY", "v_gx": "VX"})
    columns = comparison.summary["compared"]["abaqus"]
    assert columns["v_gy"]["magnitude"] == pytest.approx(0.02, rel=1e-6)
    assert columns["v_gx"]["largest"] == pytest.approx(0.0, abs=1e-5)
    assert 0.01 <= columns["v_gx"]["from"] < columns["v_gx"]["to"] <= 0.37
    assert comparison.passed
    assert comparison.summary["notes"] == []


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
    monkeypatch.setattr(text_tables, "MAX_BYTES", 5)
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
    units = column_units(columns)
    heads = ",".join([f"time [{unit}]" if unit else "time", *(f"{name} [{units[name]}]" for name in columns)])
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
    t = np.linspace(0.0, 1.0, 1001)
    sound = Item("sound", {"t": t, "v_gy": 1.0 - t}, {})
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
    advice = capsys.readouterr().err.rpartition("--columns ")[2].strip().strip('"')
    assert advice == "2:time=time [s]"
    assert (
        command(str(folder), str(path), "--columns", advice, "--out", str(tmp_path / "page"), "--force") == 1
    )


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
    path = written(tmp_path / "their.csv", t, v_gx=np.nan * t, v_gy=v_gy)
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
