"""Verification: histories side by side: metrics of known differences, files of other programs, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import tailslap
from postprocess.comparison.metrics import beside
from tailslap import InputError, Result, cli
from tailslap.comparing.source import parse_mapping, read_table

T = np.linspace(0.0, 1.0, 1001)


@pytest.fixture(scope="module")
def result():
    return tailslap.run("paper-table-3")


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    return result.save(tmp_path_factory.mktemp("compare") / "reference", pictures=False)


def command(*arguments: str) -> int:
    with pytest.raises(SystemExit) as left:
        cli.main(["compare", *arguments])
    return int(str(left.value.code))


def their_file(path: Path, result: Result, head: str, factor: float = 1.0) -> Path:
    """A history of another program: other instants, milliseconds, v_GY with the other sign, v_GX in mph."""
    t = np.linspace(0.01, 0.37, 777)
    h = result.history
    v_y, v_x = (np.interp(t, h["t"], h[name]) for name in ("v_gy", "v_gx"))
    rows = zip(1e3 * t, -factor * v_y, v_x / 0.44704, strict=True)
    path.write_text(head + "".join(f"{a:.10g};{b:.10g};{c:.10g}\n" for a, b, c in rows))
    return path


def test_metrics_of_a_scaled_and_of_a_late_history():
    """Twice as large: M = 1, P = 0, C = 1. Late by a hundredth of a turn: M = 0, P = 0.02."""
    reference = {"t": T, "v": np.sin(2.0 * np.pi * T)}
    twice = beside("v", {"t": T, "v": 2.0 * reference["v"]}, reference)
    late = beside("v", {"t": T, "v": np.sin(2.0 * np.pi * (T - 0.01))}, reference)
    assert twice is not None
    assert late is not None
    assert twice.metrics.magnitude == pytest.approx(1.0, abs=1e-12)
    assert twice.metrics.phase == pytest.approx(0.0, abs=1e-7)
    assert twice.largest[0] == pytest.approx(1.0)
    assert not twice.within
    assert late.metrics.magnitude == pytest.approx(0.0, abs=1e-12)
    assert late.metrics.phase == pytest.approx(0.02, rel=1e-6)
    assert late.within


def test_residuals_of_a_shifted_history():
    reference = {"t": T, "v": 4.0 - T}
    found = beside("v", {"t": T, "v": reference["v"] + 0.4}, reference)
    assert found is not None
    assert found.metrics.mean_residual == pytest.approx(0.1)
    assert found.metrics.deviation == pytest.approx(0.0, abs=1e-12)
    assert found.at_end == pytest.approx(0.4 / 3.0)
    assert not found.within  # the mean residual is beyond 5 %


def test_only_the_common_time_counts():
    reference = {"t": T, "v": T}
    found = beside("v", {"t": T[200:500:3] + 1e-5, "v": T[200:500:3] + 1e-5}, reference)
    assert found is not None
    assert (found.t[0], found.t[-1]) == (T[201], T[497])
    np.testing.assert_allclose(found.value, found.reference, atol=1e-12)
    assert beside("v", {"t": T + 2.0, "v": T}, reference) is None


def test_rows_that_are_not_finite_are_left_out():
    values = np.where(T > 0.5, np.nan, T)
    found = beside("v", {"t": T, "v": values}, {"t": T, "v": T})
    assert found is not None
    assert found.t[-1] == 0.5


def test_another_programs_file_is_compared_in_si(result, folder, tmp_path):
    path = their_file(tmp_path / "abaqus.csv", result, "# made by hand\nTIME;VY;VX\n[ms];[m/s];[mph]\n", 1.02)
    found = tailslap.compare(folder, path, columns={"v_gy": "-VY", "v_gx": "VX"})
    columns = found.summary["compared"]["abaqus"]
    assert columns["v_gy"]["magnitude"] == pytest.approx(0.02, rel=1e-6)
    assert columns["v_gx"]["largest"] == pytest.approx(0.0, abs=1e-5)
    assert 0.01 <= columns["v_gx"]["from"] < columns["v_gx"]["to"] <= 0.37
    assert found.passed
    assert found.summary["notes"] == []


def test_units_may_be_in_the_names_or_in_the_mapping(result, folder, tmp_path):
    in_names = their_file(tmp_path / "a.csv", result, "Time (ms);VY;VX [mph]\n")
    mapped = their_file(tmp_path / "b.csv", result, "a;VY;VX\n")
    one = tailslap.compare(folder, in_names, columns="v_gy=-VY,v_gx=VX")
    two = tailslap.compare(folder, mapped, columns="time=a [ms],v_gy=-VY,v_gx=VX [mph]")
    assert one.summary["compared"]["a"] == two.summary["compared"]["b"]
    assert one.summary["notes"] == ["a.csv: no unit given for v_gy; SI is assumed."]


def test_a_mapping_is_of_the_files_that_need_it(result, folder, tmp_path):
    path = their_file(tmp_path / "their.csv", result, "time [ms];VY;VX [mph]\n")
    found = tailslap.compare(folder / "rigid.csv", path, columns="time=time,v_gy=-VY,v_gx=VX")
    assert found.passed
    assert {*found.summary["compared"]["their"]} == {"v_gx", "v_gy"}


def test_results_are_compared_by_command_and_function(result, folder, tmp_path, capsys):
    soft = tailslap.run("paper-table-3", {"plate.youngs_modulus": "20 GPa"})
    other = soft.save(tmp_path / "soft", pictures=False)
    assert command(str(folder), str(other), "--json", "--out", str(tmp_path / "page")) == 0
    said = json.loads(capsys.readouterr().out)
    assert said == tailslap.compare(folder, other).summary
    assert said == json.loads((tmp_path / "page" / "summary.json").read_text())
    page = (tmp_path / "page" / "report.html").read_text()
    assert page.count("<svg") == 2 * len(said["compared"]["soft"])
    number = said["compared"]["soft"]["v_gy"]
    assert 0.0 < abs(number["largest"]) < 1e-4
    same = tailslap.compare(result, folder).summary["compared"]["reference"]
    assert {each["combined"] for each in same.values()} == {0.0}


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


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("1,2\n3,4\n5,6\n", "its first line has no names of columns"),
        ("t,v_gy\n0,1\n", "less than two rows"),
        ("a,v_gy\n0,1\n1,2\n", "it has no column of instants"),
        ("t,v_gy\n1,1\n0,2\n", "its instants do not rise"),
        ("t,colour\n0,1\n1,2\n", "no column over a common time"),
        ("t,v_gy [kg]\n0,1\n1,2\n", "allowed is a unit that fits m/s"),
    ],
)
def test_files_that_are_no_histories_are_refused(text, why, folder, tmp_path):
    path = tmp_path / "wrong.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=why):
        tailslap.compare(folder, path)


def test_what_is_not_there_is_refused(folder, tmp_path):
    with pytest.raises(InputError, match="there is no such file or folder"):
        tailslap.compare(folder, tmp_path / "none.csv")
    with pytest.raises(InputError, match="allowed are two or more"):
        tailslap.compare(folder)
    with pytest.raises(InputError, match="allowed are the columns in common"):
        tailslap.compare(folder, folder, only=["colour"])
    with pytest.raises(InputError, match=r"there is no summary\.json"):
        tailslap.compare(folder, tmp_path)
    assert command(str(folder), str(tmp_path / "none.csv")) == 2


@pytest.mark.parametrize("text", ["", "v_gy", "=VY", "v_gy="])
def test_a_mapping_names_both(text):
    with pytest.raises(InputError, match="allowed is NAME=THEIRS"):
        parse_mapping(text)


def test_columns_apart_by_blanks_and_gaps(tmp_path):
    path = tmp_path / "blank.txt"
    path.write_text("$ LS-DYNA\ntime  vy\n0.0  1.0\n0.1\n0.2  nonsense\n")
    columns, _ = read_table(path)
    np.testing.assert_array_equal(columns["time"], [0.0, 0.1, 0.2])
    np.testing.assert_array_equal(columns["vy"], [1.0, np.nan, np.nan])
