"""Verification: histories side by side: metrics of known differences, files of other programs, what is refused;
relative differences and metrics by hand, the paper's printed table, orders of known sequences.
"""

import csv
import json
import math
import os

import numpy as np
import pytest

import tailslap
from postprocess.comparison import quantities
from postprocess.comparison.quantities import PAPER_TABLE_3, comparison_rows, relative_difference
from tailslap import InputError, cli
from tailslap.comparing import source
from tailslap.comparing.source import parse_mapping, read_table

T = np.linspace(0.0, 1.0, 1001)


@pytest.fixture(scope="module")
def result():
    return tailslap.run("paper-table-3")


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    return result.save(tmp_path_factory.mktemp("compare") / "reference", pictures=False)


def command(*arguments):
    return cli._status(["compare", *arguments])


def their_file(path, result, head, factor=1.0):
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
    twice = quantities.beside("v", {"t": T, "v": 2.0 * reference["v"]}, reference)
    late = quantities.beside("v", {"t": T, "v": np.sin(2.0 * np.pi * (T - 0.01))}, reference)
    assert twice is not None
    assert late is not None
    assert twice.metrics.magnitude == pytest.approx(1.0, abs=1e-12)
    assert (twice.metrics.phase, twice.largest[0]) == (pytest.approx(0.0, abs=1e-7), pytest.approx(1.0))
    assert not twice.within
    assert late.metrics.magnitude == pytest.approx(0.0, abs=1e-12)
    assert late.metrics.phase == pytest.approx(0.02, rel=1e-6)
    assert late.within


def test_residuals_of_a_shifted_history():
    reference = {"t": T, "v": 4.0 - T}
    found = quantities.beside("v", {"t": T, "v": reference["v"] + 0.4}, reference)
    assert found is not None
    assert found.metrics.mean_residual == pytest.approx(0.1)
    assert found.metrics.deviation == pytest.approx(0.0, abs=1e-12)
    assert found.at_end == pytest.approx(0.4 / 3.0)
    assert not found.within  # the mean residual is beyond 5 %


def test_only_the_common_time_counts():
    reference = {"t": T, "v": T}
    found = quantities.beside("v", {"t": T[200:500:3] + 1e-5, "v": T[200:500:3] + 1e-5}, reference)
    assert found is not None
    assert (found.t[0], found.t[-1]) == (T[201], T[497])
    np.testing.assert_allclose(found.value, found.reference, atol=1e-12)
    assert quantities.beside("v", {"t": T + 2.0, "v": T}, reference) is None


def test_rows_that_are_not_finite_are_left_out():
    values = np.where(T > 0.5, np.nan, T)
    found = quantities.beside("v", {"t": T, "v": values}, {"t": T, "v": T})
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
    assert one.summary["notes"] == ["a.csv: v_gy without a unit, assumed in SI."]


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


@pytest.mark.parametrize(("text", "why"), [
    ("1,2\n3,4\n5,6\n", "its first line has no column names"), ("t,v_gy\n0,1\n", "fewer than two rows"),
    ("a,v_gy\n0,1\n1,2\n", "it has no time column"),
    ("t,v_gy\n1,1\n0,2\n", "time does not increase"),
    ("t,colour\n0,1\n1,2\n", "no column and time range in common"),
    ("t,v_gy [kg]\n0,1\n1,2\n", "allowed is a unit of the dimension of m/s"),
    ("t;v_gy\n0,0;1,5\n0,1;2,5\n", "the decimal separator is a point"),
    ("t v_gy\n0 1,5\n1 2,5\n", "the decimal separator is a point"),
    ("t,v_gy\n0,0,1,5\n0,1,2,5\n", "4 entries for 2 names"),
    ("t,v_gy,v_gy\n0,1,2\n1,2,3\n", "two columns v_gy"),
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
    columns, units = read_table(path)
    assert list(columns)[:2] == ["t", "v_gy"]
    np.testing.assert_array_equal(columns["v_gy"], [1.5, 2.5])
    assert (units["t"], units["v_gy"]) == ("s", "m/s")


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
    """The label of a file is its name, and stands in metrics.csv."""
    path = their_file(tmp_path / '=HYPERLINK("x").csv', result, "time [ms];VY;VX [mph]\n")
    page = tailslap.compare(folder, path, columns="v_gy=-VY,v_gx=VX").save(tmp_path / "page")
    rows = list(csv.reader((page / "metrics.csv").read_text().splitlines()))
    assert {row[0] for row in rows[1:]} == {'\'=HYPERLINK("x")'}
    assert not [cell for row in rows for cell in row if cell.startswith(("=", "@", "+"))]


def test_what_is_not_there_is_refused(folder, tmp_path):
    for given, only, message in (
        ((folder, tmp_path / "none.csv"), (), "the file or folder does not exist"),
        ((folder,), (), "two or more results are required"),
        ((folder, folder), ("colour",), "allowed are the common columns"),
        ((folder, tmp_path), (), r"it has no readable summary\.json"),
    ):
        with pytest.raises(InputError, match=message):
            tailslap.compare(*given, only=only)
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
    found = quantities.compare_histories(PERIODS, factor * signal, signal)
    assert found.magnitude == pytest.approx(factor - 1.0, abs=1e-14)
    assert found.phase == pytest.approx(0.0, abs=1e-14)
    assert found.combined == pytest.approx(abs(factor - 1.0), abs=1e-14)


@pytest.mark.parametrize("shift", [1e-9, 1e-3, 0.5, 2.0, math.pi])
def test_a_sine_with_a_phase_shift(shift):
    found = quantities.compare_histories(PERIODS, np.sin(PERIODS - shift), np.sin(PERIODS))
    assert found.phase == pytest.approx(shift / math.pi, rel=1e-6, abs=1e-15)
    assert found.magnitude == pytest.approx(0.0, abs=1e-13)


def test_magnitude_and_phase_combine_as_the_sides_of_a_right_angle():
    found = quantities.compare_histories(PERIODS, 1.3 * np.sin(PERIODS - 0.4 * math.pi), np.sin(PERIODS))
    assert found.combined == pytest.approx(0.5, abs=1e-12)


def test_a_constant_offset_is_all_mean_and_no_deviation():
    """Over the peak of the reference, whatever its sign; and signed."""
    reference = -4.0 - np.sin(PERIODS)
    found = quantities.compare_histories(PERIODS, reference - 0.25, reference)
    assert found.mean_residual == pytest.approx(-0.05, abs=1e-14)
    assert found.deviation == pytest.approx(0.0, abs=1e-14)


def test_a_wave_on_top_is_all_deviation():
    reference = 2.0 + 0.0 * PERIODS
    found = quantities.compare_histories(PERIODS, reference + 0.6 * np.sin(PERIODS), reference)
    assert found.mean_residual == pytest.approx(0.0, abs=1e-14)
    assert found.deviation == pytest.approx(0.3 / math.sqrt(2.0), abs=1e-12)


def test_it_is_time_that_counts_and_not_rows():
    """Rows crowd where the two differ: the mean over time is that of the trapezoids, -0.07, not that of the rows."""
    instants = np.array([0.0, 0.01, 0.02, 0.03, 0.04, 0.1, 0.9, 1.0])
    residual = np.where(instants < 0.05, -1.0, 0.0)
    found = quantities.compare_histories(instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    assert found.mean_residual == pytest.approx(-(0.04 + 0.5 * 0.06), abs=1e-15)
    later = quantities.compare_histories(7.0 + 3.0 * instants, 10.0 + 10.0 * residual, np.full(8, 10.0))
    for name in ("magnitude", "phase", "mean_residual", "deviation"):
        assert getattr(later, name) == pytest.approx(getattr(found, name), abs=1e-13)


def test_the_trapezoidal_rule_converges_in_second_order():
    """Norms of exp and 1 on [0, 1]: M = sqrt((e^2 - 1) / 2) - 1, cos(pi P) = (e - 1) sqrt(2 / (e^2 - 1))."""
    square = (math.e**2 - 1.0) / 2.0
    exact = (math.sqrt(square) - 1.0, math.acos((math.e - 1.0) / math.sqrt(square)) / math.pi)
    errors = []
    for rows in (20, 40, 80):
        t = np.linspace(0.0, 1.0, rows + 1)
        found = quantities.compare_histories(t, np.exp(t), np.ones_like(t))
        errors.append([abs(found.magnitude - exact[0]), abs(found.phase - exact[1])])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.01)
    assert max(errors[-1]) < 1e-4


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_give_none_that_could_pass(value):
    history = np.sin(PERIODS)
    history[7] = value
    found = quantities.compare_histories(PERIODS, history, np.sin(PERIODS))
    assert all(math.isnan(x) for x in vars(found).values())


def test_nothing_to_compare_gives_none():
    for rows in (0, 1):
        few = np.ones(rows)
        assert all(math.isnan(x) for x in vars(quantities.compare_histories(few, few, few)).values())
    zero = quantities.compare_histories(PERIODS, np.sin(PERIODS), 0.0 * PERIODS)
    assert all(math.isnan(x) for x in vars(zero).values())


def test_published_example():
    """NPARC Alliance, "Examining Spatial (Grid) Convergence": p = 1.786170, 0.97130, GCI 0.103083 and 0.356249 %."""
    found = quantities.grid_convergence((0.97050, 0.96854, 0.96178), (2.0, 2.0))
    assert found.order == pytest.approx(1.786170, abs=5e-7)
    assert found.extrapolated == pytest.approx(0.97130, abs=5e-6)
    assert 100.0 * found.gci_fine == pytest.approx(0.103083, abs=5e-7)
    assert (100.0 * found.gci_coarse, found.behaviour) == (pytest.approx(0.356249, abs=5e-7), "converging")
    assert found.asymptotic == pytest.approx(1.0, abs=3e-3)


@pytest.mark.parametrize("order", [0.8, 1.7, 4.0])
@pytest.mark.parametrize("ratios", [(2.0, 2.0), (1.5, 2.2), (3.0, 1.2)])
def test_power_law_is_found_exactly(order, ratios):
    sizes = (1.0, ratios[0], ratios[0] * ratios[1])
    values = tuple(5.0 - 0.01 * size**order for size in sizes)
    found = quantities.grid_convergence(values, ratios)
    assert found.order == pytest.approx(order, rel=1e-9)
    assert found.extrapolated == pytest.approx(5.0, rel=1e-12)
    assert found.error == pytest.approx(0.01 / 4.99, rel=1e-9)
    assert found.gci_fine == pytest.approx(1.25 * found.error, rel=1e-9)
    assert found.gci_coarse == pytest.approx(1.25 * 0.01 * sizes[1] ** order / values[1], rel=1e-9)


@pytest.mark.parametrize(("values", "behaviour"), [
    ((1.0, 1.1, 0.9), "oscillating"), ((1.0, 2.0, 2.5), "diverging"), ((2.0, 2.0, 2.0), "settled"),
    ((3.9, 3.6, 3.29), "slow"),  # a logarithm: it grows by the same with every halving
])  # fmt: skip
def test_values_that_do_not_converge_are_not_extrapolated(values, behaviour):
    found = quantities.grid_convergence(values, (2.0, 2.0))
    assert (found.behaviour, found.extrapolated) == (behaviour, values[0])
    if behaviour != "settled":
        assert found.gci_fine == pytest.approx(3.0 * abs(values[0] - values[1]) / values[0])


def test_no_order_for_a_quotient_that_no_power_law_has():
    assert quantities.observed_order(0.1, (1.5, 2.2)) == -math.inf


def test_ratios_must_be_above_one():
    with pytest.raises(ValueError, match="above 1"):
        quantities.grid_convergence((1.0, 2.0, 3.0), (1.0, 2.0))
