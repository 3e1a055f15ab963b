"""Verification: how tables take entries out of records, show what is none, and go to files."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import pytest

from postprocess.report.files import write_summary
from postprocess.report.report import write_table
from postprocess.report.table import Column, columns, listed
from postprocess.units import duration, known


@dataclass(frozen=True)
class Run:
    """A record with entries of entries."""

    values: tuple[float, float]
    differences: dict[str, float]
    before: Run | None = None


RUN = Run((1.0, math.nan), {"v_gy": -0.5}, Run((3.0, 4.0), {}))


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("values.0", "1.0"),
        ("values.1", "–"),
        ("differences.v_gy", "-0.5"),
        ("before.values.1", "4.0"),
        ("before.before", "–"),
        ("before.before.values.0", "–"),
    ],
)
def test_entries_of_entries(key, text):
    """Of mappings, tuples and objects; a dash where one on the way is None, or a number is none."""
    assert Column(key, "", form=known(".1f")).text(RUN) == text


def test_columns_of_one_form():
    made = columns({"values.0": "first", "values.1": "second"}, form=".2f", group="values")
    assert [(c.key, c.label, c.group) for c in made] == [
        ("values.0", "first", "values"),
        ("values.1", "second", "values"),
    ]
    assert made[0].text(RUN) == "1.00"


def test_negligible_numbers_are_zero():
    shown = known(".1e", negligible=1e-9)
    assert [shown(x) for x in (-9e-10, -2e-9, math.inf)] == ["0", "-2.0e-09", "–"]
    assert known(".1e")(1e-300) == "1.0e-300"


def test_a_time_that_was_not_measured_is_a_dash():
    assert [duration(x) for x in (0.0, 2e-6, 0.5, 3.0)] == ["–", "2 us", "500 ms", "3 s"]


def test_listed_records_keep_every_digit_in_files(tmp_path):
    path = write_table(tmp_path / "t.csv", listed([{"a": 0.1 + 0.2, "b:c": "x, y"}, {"a": None, "b:c": ""}]))
    assert path.read_text().splitlines() == ["a,b:c", '0.30000000000000004,"x, y"', ","]


def test_a_summary_takes_records(tmp_path):
    read = json.loads(write_summary(tmp_path / "s.json", {"run": RUN}).read_text())
    assert read["run"]["values"] == [1.0, None]
    assert read["run"]["before"]["before"] is None
