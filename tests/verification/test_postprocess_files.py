"""Verification: histories come back bit for bit, and the summary is strict JSON."""

import json
import math

import numpy as np
import pytest

from postprocess.report.files import read_history, write_history, write_summary


def bits(values: np.ndarray) -> np.ndarray:
    return np.asarray(values, dtype=np.float64).view(np.uint64)


def test_history_round_trip_is_bitwise(tmp_path):
    generator = np.random.default_rng(7)
    any_double = generator.integers(0, 0x7FE0000000000000, size=500, dtype=np.uint64).view(np.float64)
    special = [0.0, -0.0, 5e-324, -1.7976931348623157e308, np.nextafter(1.0, 2.0), 0.1]
    columns = {"t": np.concatenate([any_double, special]), "v_gy": -np.arange(506) / 3.0}
    back = read_history(write_history(tmp_path / "history.csv", columns))
    assert list(back) == ["t", "v_gy"]
    for name, values in columns.items():
        np.testing.assert_array_equal(bits(back[name]), bits(values))


def test_history_has_empty_entries_for_what_is_not_finite(tmp_path):
    columns = {"t": [0.0, 1.0, 2.0], "v_gy": [np.nan, 1.5, -np.inf], "v_gx": [np.inf, 2.5, 3.5]}
    path = write_history(tmp_path / "history.csv", columns)
    assert path.read_text().splitlines() == ["t,v_gy,v_gx", "0,,", "1,1.5,2.5", "2,,3.5"]
    back = read_history(path)
    assert np.isnan(back["v_gy"]).tolist() == [True, False, True]
    np.testing.assert_array_equal(back["t"], columns["t"])


def test_history_is_a_csv_with_a_header(tmp_path):
    path = write_history(tmp_path / "history.csv", {"t": [0.0, 0.5], "slide": [1.0, 0.1]})
    assert path.read_text() == "t,slide\n0,1\n0.5,0.10000000000000001\n"


@pytest.mark.parametrize("rows", [0, 1])
def test_short_histories(tmp_path, rows):
    back = read_history(write_history(tmp_path / "h.csv", {"t": np.zeros(rows), "omega": np.ones(rows)}))
    assert {name: values.shape for name, values in back.items()} == {"t": (rows,), "omega": (rows,)}


@pytest.mark.parametrize(
    "columns",
    [
        {"t": np.zeros(3), "omega": np.zeros(2)},
        {"t": np.zeros((2, 2))},
        {"t, x": np.zeros(2)},
        {"": np.zeros(2)},
    ],
)
def test_what_does_not_fit_a_table_is_refused(tmp_path, columns):
    with pytest.raises(ValueError, match=r"dimension|header"):
        write_history(tmp_path / "h.csv", columns)
    assert not (tmp_path / "h.csv").exists()


def refuse(constant: str) -> None:
    raise AssertionError(f"{constant} is not JSON")


def test_summary_is_strict_json_in_the_order_given(tmp_path):
    summary = {
        "scene": "θ",
        "passed": np.bool_(False),
        "fe": {"t": np.float64(0.1), "omega": math.nan, "slide": np.inf},
        "checks": [{"name": "energy balance", "value": -math.inf, "limit": 0.01}],
        "cost": {"steps": np.int64(7400), "elements": np.array([20, 6])},
        "out": tmp_path,
    }
    path = write_summary(tmp_path / "summary.json", summary)
    text = path.read_text(encoding="utf-8")
    assert json.loads(text, parse_constant=refuse) == {
        "scene": "θ",
        "passed": False,
        "fe": {"t": 0.1, "omega": None, "slide": None},
        "checks": [{"name": "energy balance", "value": None, "limit": 0.01}],
        "cost": {"steps": 7400, "elements": [20, 6]},
        "out": str(tmp_path),
    }
    assert list(json.loads(text)) == list(summary)
    assert text.startswith('{\n  "scene": "θ",\n')
    assert text.endswith("}\n")


def test_summary_keeps_every_digit(tmp_path):
    value = 0.1 + 0.2
    back = json.loads(write_summary(tmp_path / "s.json", {"t": np.float64(value)}).read_text())
    assert back["t"] == value


def test_summary_refuses_what_json_does_not_know(tmp_path):
    with pytest.raises(TypeError):
        write_summary(tmp_path / "s.json", {"mesh": object()})
    assert not (tmp_path / "s.json").exists()
