"""Verify that files of others are read rightly, or refused.

Every file is that of a motion in closed form, so that a column that is read rightly agrees with itself to its digits.
"""

import json
import math
from typing import Any

import numpy as np
import pytest

import tailslap
from postprocess.comparison import metrics, nodal
from tailslap import InputError, cli
from tailslap.comparing import units
from tailslap.scene.units import UNITS

T = np.linspace(0.0, 0.4, 9)
V = -3.0 - T
G = 9.80665


def table(path, *columns, head="", separator=",", form="{:.10g}"):
    """A file of a line of names and columns."""
    rows = (separator.join(form.format(x) for x in row) for row in zip(*columns, strict=True))
    path.write_text("\n".join([*([head] if head else []), *rows]) + "\n")
    return path


@pytest.fixture
def reference(tmp_path):
    return table(tmp_path / "reference.csv", T, V, head="t [s],v_gy [m/s]")


def compared(*files, **options):
    """Summary and metrics of the last file."""
    summary = tailslap.compare(*files, **options).summary
    return summary, summary["compared"][files[-1].stem]


def agrees(numbers):
    return abs(numbers["largest"]) < 1e-8 and numbers["combined"] < 1e-8


@pytest.mark.parametrize(("unit", "other", "factor"), [
    ("m", "yd", 1.0 / 0.9144), ("m/s2", "g", 1.0 / G), ("g", "m/(s*s)", G), ("m/s\u00b2", "G", 1.0 / G),
    ("rad/s", "dps", 180.0 / math.pi), ("deg/s", "\u00b0/sec", 1.0), ("m/s", "MPH", 1.0 / 0.44704),
    ("km/hr", "mph", 1.0 / 1.609344), ("tonne", "kg", 1000.0), ("kN-m", "N\u00b7m", 1000.0),
    ("m s-1", "mm/msec", 1.0), ("deg", "\u00ba", 1.0), ("widgets", "widgets", 1.0), ("-", "1", 1.0),
])  # fmt: skip
def test_columns_of_any_name_are_compared_in_one_unit(unit, other, factor, tmp_path):
    a = table(tmp_path / "a.csv", T, V, head=f"t [s],dy [{unit}]")
    b = table(tmp_path / "b.csv", T, factor * V, head=f"t [s],dy [{other}]")
    summary, numbers = compared(a, b)
    assert agrees(numbers["dy"])
    assert summary["notes"] == []
    if factor != 1.0:  # equal digits are not equal
        c = table(tmp_path / "c.csv", T, V, head=f"t [s],dy [{other}]")
        assert compared(a, c)[1]["dy"]["magnitude"] == pytest.approx(1.0 / factor - 1.0, rel=1e-8)


@pytest.mark.parametrize(("unit", "words"), [
    ("kg", ['"kg"', "the dimension of m, as the reference has"]), ("widgets", ['"widgets"', "dimension of m"]),
    ("", ["given none", 'the reference has "m"', '--columns "2:dy=dy [UNIT]"']), ("degC", ["not proportional"]),
    ("ton", ["several meanings"]), ("m^99999999", ['"m^99999999"']), ("1", ['"1"']),
])  # fmt: skip
def test_another_dimension_of_one_name_is_refused_with_both(unit, words, tmp_path):
    a = table(tmp_path / "a.csv", T, V, head="t [s],dy [m]")
    b = table(tmp_path / "b.csv", T, V, head=f"t [s],dy [{unit}]" if unit else "t [s],dy")
    with pytest.raises(InputError) as refused:
        tailslap.compare(a, b)
    assert all(word in str(refused.value) for word in words)
    if not unit:
        assert agrees(compared(a, b, columns="2:dy=dy [m]")[1]["dy"])
        with pytest.raises(InputError, match="the reference has none"):
            tailslap.compare(b, a)


def test_units_of_scenes_mean_the_same_in_files():
    """pint and the table of scenes are independent of each other."""
    for name, (factor, dimension) in UNITS.items():
        scale, base = units.meanings(name)[0]
        assert scale == pytest.approx(factor, rel=1e-14), name
        same = next(other for other, (_, powers) in UNITS.items() if powers == dimension)
        assert base == units.meanings(same)[0][1], name


def test_zero_agrees_with_zero_alone(reference, tmp_path):
    """A frictionless run agrees with itself."""
    for value, within in ((0.0, True), (1e-300, False)):
        files = [
            table(tmp_path / f"{k}.csv", T, V, 0.0 * T + x, head="t [s],v_gy [m/s],reaction_tangential [N]")
            for k, x in enumerate((0.0, value))
        ]
        summary, numbers = compared(*files)
        assert (summary["passed"], numbers["reaction_tangential"]["within"]) == (within, within)
        assert numbers["reaction_tangential"]["largest"] == 0.0 or not within
        assert numbers["reaction_tangential"]["at_end"] == 0.0 or not within
    zero = np.zeros(9)
    assert vars(metrics.compare_histories(T, zero, zero)) == dict.fromkeys(metrics.LIMITS, 0.0)


ISO = """Test object number          :1
Name of the channel         :Vehicle CG velocity Y
Channel code                :11VEHC000000VEYD
Unit                        :km/h
Reference channel           :implicit
Time of first sample        :{start}
Sampling interval           :{interval}
Number of samples           :{samples}
"""
FORTRAN = "\n".join(f"  {t:.9E}  {v:.9E}".replace("E", "D") for t, v in zip(T, V, strict=True)) + "\n"
BLANKS = "\n".join(f"{t:.9g}  {v:.9g}" for t, v in zip(T, V, strict=True)) + "\n"
COMMAS = "\n".join(f"{t:.9g},{v:.9g}" for t, v in zip(T, V, strict=True)) + "\n"
GERMAN = COMMAS.replace(",", ";").replace(".", ",")
CHANNEL = ISO.format(start=0, interval=0.05, samples=9) + "\n".join(f"{3.6 * v:.9E}" for v in V) + "\n"
READ: dict[str, tuple[str, dict[str, Any]]] = {
    "any.dat": ("t v_gy\n" + BLANKS, {}),
    "excel.csv": ("sep=;\nt;v_gy\n" + COMMAS.replace(",", ";"), {}),
    "fortran.txt": ("t  v_gy\n" + FORTRAN, {}),
    "fortran_units.txt": ("t [sec]  v_gy (m / s)\n" + FORTRAN, {}),
    "savetxt.txt": ("# t v_gy\n" + BLANKS, {}),
    "savetxt_units.txt": ("# made by hand\n# t   v_gy\n# msec  mm/msec\n" + BLANKS.replace("0.", "0."), {"t": 1e3}),
    "savetxt_comma.txt": ("# t,v_gy\n" + COMMAS, {}),
    "words.txt": ("$ t v_gy note\n" + BLANKS.replace("\n", " word\n"), {}),
    "remark.csv": ("t [s],v_gy [m/s] (CFC 60)\n" + COMMAS, {}),
    "remark_first.csv": ("t (s),v_gy (CFC 60) [m/s]\n" + COMMAS, {}),
    "number.csv": ("t,v_gy,mu\ns,m/s,1\n" + COMMAS.replace("\n", ",0.4\n"), {}),
    "quoted.csv": ('"t [s]";"v_gy [m/s]"\n' + COMMAS.replace(",", ";"), {}),
    "two.txt": (BLANKS, {"columns": "v_gy=2"}),
    "two_times.txt": (BLANKS, {"columns": "time=1 [s],v_gy=2 [m/s]"}),
    "minus.csv": (COMMAS.replace("-", ""), {"columns": "2:time=1,2:v_gy=-2"}),
    "report.rpt": ("\n      X        V2 N: 12  \n\n" + BLANKS, {"columns": "time=X,v_gy=V2 N: 12"}),
    "german.csv": ("t;v_gy\n" + GERMAN, {"decimal_commas": [2]}),
    "german.txt": ("t v_gy\n" + GERMAN.replace(";", " "), {"decimal_commas": [2]}),
    "iso.001": (CHANNEL, {"columns": "v_gy=11VEHC000000VEYD"}),
    "iso_number.001": (CHANNEL, {"columns": "v_gy=2"}),
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_files_as_people_have_them_are_read(name, reference, tmp_path):
    text, options = READ[name]
    options = dict(options)
    if scale := options.pop("t", None):
        text = text.replace(
            BLANKS, "\n".join(f"{scale * t:.9g} {v:.9g}" for t, v in zip(T, V, strict=True)) + "\n"
        )
    path = tmp_path / name
    path.write_text(text)
    numbers = compared(reference, path, **options)[1]["v_gy"]
    assert agrees(numbers)
    assert (numbers["from"], numbers["to"]) == pytest.approx((0.0, 0.4), abs=1e-9)


REFUSED: dict[str, tuple[str, dict[str, Any], str]] = {
    "rows longer than the names": ("t,v_gy\n0,1\n1,2,3\n", {}, "line 3 has 3 entries for 2 names"),
    "all shifted": ("t,v_gy,VZ\n0,1,\n1,2,\n", {}, "neither line 2 nor another has an entry under the last of 3 names"),
    "a thousand": ("t;v_gy\n0;1.234,5\n1;2\n", {"decimal_commas": [2]}, 'v_gy: given "1.234,5"; allowed are decimal'),
    "comma": ("t;v_gy\n0;1,5\n1;2\n", {}, "line 2, column v_gy: given \"1,5\"; the decimal separator is a point"),
    "binary": ("t,v_gy\n0,1\n1,2\n", {"decimal_commas": [1, 3]}, "--decimal-comma: given 3; allowed are the numbers"),
    "stars": ("t v_gy\n0 1.0\n1 *****\n", {}, "line 3, column v_gy: given \"*****\""),
    "a date": ("t,v_gy\n2026-11-28,1\n2026-11-29,2\n", {}, 'line 2, column t: given "2026-11-28"'),
    "two filters": ("t,v_gy (CFC 60),v_gy (CFC 180)\n0,1,1\n1,2,2\n", {}, "two columns v_gy, \"v_gy (CFC 60)\" and"),
    "two units": ("t [s],v_gy [m/s]\ns,ft/s\n0,1\n1,2\n", {}, "column v_gy has two units, m/s and ft/s"),
    "number of none": (BLANKS, {"columns": "v_gy=3"}, "no file has this column; allowed are t, v_gy, 1, 2"),
    "no file": ("t,v_gy\n0,1\n1,2\n", {"columns": "v_gy=VYY"}, "given \"VYY\"; no file has this column"),
    "number beside names": ("t,v_gy\n0,1\n1,2\n", {"columns": "v_gx=2"}, "no file has this column"),
    "of a result": ("t,v_gy\n0,1\n1,2\n", {"columns": "3:v_gy=2"}, "allowed are the numbers of the results, from 1"),
    "alone": ("t,v_gy\n0,1\n1,2\n", {"columns": "2:v_gy=VY"}, "does not have this column"),
    "no time": ("a,v_gy\n0,1\n1,2\n", {}, "its columns are a, v_gy"),
    "an open quote": ('t,"v_gy\n0,1\n1,2\n', {}, "it has fewer than two rows of numbers"),
    "a long mapping": ("t,v_gy\n0,1\n1,2\n", {"columns": {"v_gy": 2000 * "x"}}, "no file has this column"),
    "a long name": ("t," + "[" * 100_000 + "\n0,1\n1,2\n", {}, "allowed are at most 1000 characters"),
    "cut channel": (CHANNEL.rsplit("\n", 2)[0] + "\n", {}, "it has 8 lines of samples, by line 8 9"),
    "channel over another": (CHANNEL.replace("implicit", "explicit"), {}, "line 5: reference channel \"explicit\""),
    "no interval": (CHANNEL.replace(":0.05", ":NOVALUE"), {}, "line 7, sampling interval: given \"NOVALUE\""),
    "two samples": (CHANNEL[:-1] + " 7\n", {"columns": "v_gy=2"}, "line 17, column 11VEHC000000VEYD: given"),
    "magic alone": ("PAR1 and no more", {}, "arquet"),
    "no names": ("1,2\n3,4\n5,6\n", {}, "its first line has no column names"),
    "a single row": ("t,v_gy\n0,1\n", {}, "fewer than two rows"),
    "backwards": ("t,v_gy\n1,1\n0,2\n", {}, "line 3: time does not increase from row to row, 0 s after 1 s"),
    "no instant": ("t,v_gy\n0,1\n\n,2\n", {}, "line 4: the instant is missing"),
    "cut short": ("t;v_gy\n0;1\n1\n", {}, "line 3 is cut short: 1 entries for 2"),
    "nothing common": ("t,colour\n0,1\n1,2\n", {}, "no column with two values at times in common"),
    "other unit": ("t,v_gy [kg]\n0,1\n1,2\n", {}, "allowed is a unit of the dimension of m/s"),
    "commas and blanks": ("t v_gy\n0 1,5\n1 2,5\n", {}, "the decimal separator is a point"),
    "commas between commas": ("t,v_gy\n0,0,1,5\n0,1,2,5\n", {}, "4 entries for 2 names"),
    "one name twice": ("t,v_gy,v_gy\n0,1,2\n1,2,3\n", {}, "two columns v_gy"),
    "beyond numbers": ("t,v_gy [km/s]\n0,1\n0.1,9e29\n0.2,1\n", {},
                       "line 3, column v_gy: 9e+32 in SI; allowed are numbers of at most 1e+30"),
    "no text": ("t,v_gy\n0,\0\n1,2\n", {}, "neither text in UTF-8"),
    "a long field": (f't,v_gy\n0,"{"1" * 200_000}"\n1,2\n', {}, "field larger"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_other_files_are_refused_with_line_and_reason(name, reference, tmp_path):
    text, options, words = REFUSED[name]
    path = tmp_path / "wrong.txt"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        tailslap.compare(reference, path, **options)
    assert words in str(refused.value)
    assert ("decimal" in str(refused.value)) == ("decimal" in words)


def test_parquet_of_this_program_is_read(tmp_path):
    result = tailslap.run("paper-table-3", {"corner.reaction": "none"})
    tailslap.export(result, "parquet", tmp_path / "exported")
    moved = (tmp_path / "exported" / "history.parquet").rename(tmp_path / "moved.bin")
    summary = tailslap.compare(result, moved).summary
    assert summary["passed"]
    assert {numbers["largest"] for numbers in summary["compared"]["moved"].values()} == {0.0}
    assert summary["notes"] == []


def test_sweeps_have_no_time(reference, tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = tmp_path / "sweep.parquet"
    pq.write_table(pa.table({"run": ["a", "b"], "fe.v_gy": [1.0, 2.0]}), path)
    with pytest.raises(InputError, match=r"it has no time column; .*its columns are run, fe\.v_gy"):
        tailslap.compare(reference, path)
    with pytest.raises(InputError, match="column run has no numbers"):
        tailslap.compare(reference, path, columns="time=fe.v_gy,v_gy=run")


def test_the_advice_on_time_is_followed_once(tmp_path):
    """Neither file has a unit, and both have the same names."""
    a = table(tmp_path / "a.csv", T, V, head="t,v_gy")
    b = table(tmp_path / "b.csv", 1e3 * T, V, head="t,v_gy")
    for files in ((a, b), (b, a)):
        for columns in ("v_gy=v_gy", "time=t [ms]", "time=t [s]"):
            with pytest.raises(InputError) as refused:
                tailslap.compare(*files, columns=columns)
            advice = str(refused.value).rpartition("--columns ")[2].strip('"')
            assert sorted(part[2:] for part in advice.split(",")) == ["time=t [ms]", "time=t [s]"]
            assert agrees(compared(*files, columns=f"{columns},{advice}")[1]["v_gy"])


def test_units_of_time_that_are_stated_are_not_doubted(tmp_path):
    """Both are stated, and one record is a twentieth of the other."""
    t = np.linspace(0.0, 0.4, 81)
    a, b = (table(tmp_path / f"{k}.csv", t[:k], -3.0 - t[:k], head="t,v_gy") for k in (81, 5))
    numbers = compared(a, b, columns="1:time=t [s],2:time=t [s]")[1]["v_gy"]
    assert (agrees(numbers), numbers["covered"]) == (True, pytest.approx(0.05))
    with pytest.raises(InputError, match=r"lasts 0\.02 s"):
        tailslap.compare(a, b, columns="time=t [s]")


def test_what_is_not_compared_is_named_with_its_reason(tmp_path, capsys):
    a = table(tmp_path / "a.csv", T, V, V, V, head="t [s],v_gy [m/s],slide [m],kinetic_energy [J]")
    b = tmp_path / "b.csv"
    rows = [f"{t},{v},,word,{v},{t}" for t, v in zip(T, V, strict=True)]
    b.write_text("\n".join(["t [s],v_gy (CFC 60),VZ,note,kinetic_energy,", *rows]) + "\n")
    assert cli._status(["compare", str(a), str(b), "--out", str(tmp_path / "page")]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    summary = json.loads((tmp_path / "page" / "summary.json").read_text())
    assert summary["not_compared"] == {"b": {
        "kinetic_energy": "no main column, compared by --only", "slide": "not in b", "note": "not in a",
        "VZ": "not in a; without an entry in 9 of 9 rows, first in line 2", "6": "not in a",
    }}  # fmt: skip
    assert summary["notes"] == [
        'b.csv: v_gy is its column "v_gy (CFC 60)"; the remark is not considered.',
        "b.csv: v_gy, kinetic_energy without a unit, assumed in SI.",
    ]
    pages = [(tmp_path / "page" / name).read_text() for name in ("report.html", "validation.html")]
    for text in (printed, *(page.replace("\N{NO-BREAK SPACE}", " ") for page in pages)):
        assert "b, not compared: note, 6 (not in a)." in text
        assert "b, not compared: slide (not in b)." in text


def test_a_mapped_name_of_another_program_is_compared_with_the_main_ones(reference, tmp_path):
    files = [
        table(tmp_path / f"{name}.csv", T, V, V, head=f"t [s],v_gy [m/s],{name} [m]") for name in ("D1", "D2")
    ]
    assert {*compared(*files, columns="1:dy=D1,2:dy=D2")[1]} == {"v_gy", "dy"}
    (tmp_path / "D2.csv").write_text((tmp_path / "D2.csv").read_text().replace("D2", "dy"))
    assert {*compared(*files, columns="dy=D1")[1]} == {"v_gy", "dy"}


@pytest.mark.parametrize(("text", "value"), [
    ("1.0D+00", 1.0), ("-2.5d-3", -2.5e-3), ("1.234-100", 1.234e-100), (".5D2", 50.0),
    ("1.0D", None), ("2026-100", None), ("1_0", None), ("D1", None),
])  # fmt: skip
def test_numbers_of_fortran(text, value):
    if value is not None:
        assert nodal.number(text) == value
    else:
        with pytest.raises(ValueError, match="allowed are numbers"):
            nodal.number(text)
