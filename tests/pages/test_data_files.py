"""Verify entries of tables, and values in files of histories and numbers."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest

from postprocess.report.data_files import write_history, write_summary, write_table
from postprocess.report.tables import Column, columns, listed
from postprocess.units import known
from tailslap.result.load import read_history


@dataclass(frozen=True)
class Run:
    """A record with entries of entries."""

    values: tuple[float, float]
    differences: dict[str, float]
    before: Run | None = None


RUN = Run((1.0, math.nan), {"v_gy": -0.5}, Run((3.0, 4.0), {}))


ENTRIES = [
    *(("values.0", "1.0"), ("values.1", "–"), ("differences.v_gy", "-0.5"), ("before.values.1", "4.0")),
    *(("before.before", "–"), ("before.before.values.0", "–")),
]


@pytest.mark.parametrize(("key", "text"), ENTRIES)
def test_entries_of_entries(key, text):
    """Mappings, tuples and objects, with a dash for None and NaN."""
    assert Column(key, "", form=known(".1f")).text(RUN) == text


def test_columns_of_one_form():
    value_columns = columns({"values.0": "first", "values.1": "second"}, form=".2f", group="values")
    expected = [("values.0", "first", "values"), ("values.1", "second", "values")]
    assert ([(c.key, c.label, c.group) for c in value_columns], value_columns[0].text(RUN)) == (
        expected,
        "1.00",
    )


def test_listed_records_keep_every_digit_in_files(tmp_path):
    path = write_table(tmp_path / "t.csv", listed([{"a": 0.1 + 0.2, "b:c": "x, y"}, {"a": None, "b:c": ""}]))
    assert path.read_text().splitlines() == ["a,b:c", '0.30000000000000004,"x, y"', ","]


def test_a_summary_takes_records(tmp_path):
    read = json.loads(write_summary(tmp_path / "s.json", {"run": RUN}).read_text())
    assert read["run"]["values"] == [1.0, None]
    assert read["run"]["before"]["before"] is None


def bits(values):
    return np.asarray(values, dtype=np.float64).view(np.uint64)


def test_history_round_trip_is_bitwise(tmp_path):
    generator = np.random.default_rng(7)
    any_double = generator.integers(0, 0x7FE0000000000000, size=500, dtype=np.uint64).view(np.float64)
    special = [0.0, -0.0, 5e-324, -1.7976931348623157e308, np.nextafter(1.0, 2.0), 0.1]
    columns = {"t": np.concatenate([any_double, special]), "v_gy": -np.arange(506) / 3.0}
    back = read_history(write_history(tmp_path / "history.csv", columns).read_bytes())
    assert list(back) == ["t", "v_gy"]
    for name, values in columns.items():
        np.testing.assert_array_equal(bits(back[name]), bits(values))


def test_history_has_empty_entries_for_what_is_not_finite(tmp_path):
    columns = {"t": [0.0, 1.0, 2.0], "v_gy": [np.nan, 1.5, -np.inf], "v_gx": [np.inf, 2.5, 3.5]}
    path = write_history(tmp_path / "history.csv", columns)
    assert path.read_text().splitlines() == ["t,v_gy,v_gx", "0,,", "1,1.5,2.5", "2,,3.5"]
    back = read_history(path.read_bytes())
    assert np.isnan(back["v_gy"]).tolist() == [True, False, True]
    np.testing.assert_array_equal(back["t"], columns["t"])


@pytest.mark.parametrize("rows", [0, 1])
def test_short_histories(tmp_path, rows):
    path = write_history(tmp_path / "h.csv", {"t": np.zeros(rows), "omega": np.ones(rows)})
    back = read_history(path.read_bytes())
    assert {name: values.shape for name, values in back.items()} == {"t": (rows,), "omega": (rows,)}


UNFIT = [{"t": np.zeros(3), "omega": np.zeros(2)}, {"t": np.zeros((2, 2))}]
UNFIT += [{"t, x": np.zeros(2)}, {"": np.zeros(2)}]


@pytest.mark.parametrize("columns", UNFIT)
def test_what_does_not_fit_a_table_is_refused(tmp_path, columns):
    with pytest.raises(ValueError, match=r"dimension|header"):
        write_history(tmp_path / "h.csv", columns)
    assert not (tmp_path / "h.csv").exists()


def refuse(constant):
    raise AssertionError(f"{constant} is not JSON")


def test_summary_is_strict_json_in_the_order_given(tmp_path):
    summary = {
        **{"scene": "θ", "passed": np.bool_(False)},
        "fe": {"t": np.float64(0.1 + 0.2), "omega": math.nan, "slide": np.inf},
        "checks": [{"name": "energy balance", "value": -math.inf, "limit": 0.01}],
        **{"cost": {"steps": np.int64(7400), "elements": np.array([20, 6])}, "out": tmp_path},
    }
    path = write_summary(tmp_path / "summary.json", summary)
    text = path.read_text(encoding="utf-8")
    assert json.loads(text, parse_constant=refuse) == {
        **{"scene": "θ", "passed": False, "fe": {"t": 0.1 + 0.2, "omega": None, "slide": None}},
        "checks": [{"name": "energy balance", "value": None, "limit": 0.01}],
        **{"cost": {"steps": 7400, "elements": [20, 6]}, "out": str(tmp_path)},
    }
    assert list(json.loads(text)) == list(summary)
    assert text.startswith('{\n  "scene": "θ",\n')
    assert text.endswith("}\n")


def test_summary_refuses_what_json_does_not_know(tmp_path):
    with pytest.raises(TypeError):
        write_summary(tmp_path / "s.json", {"mesh": object()})
    assert not (tmp_path / "s.json").exists()
