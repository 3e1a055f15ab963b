"""Verification: the study of flexibility on whole impacts, its levels and its report from given plates."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from postprocess.report.report import write_report
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.read import read_scene
from tailslap.scene.vary import Changes, Source
from tailslap.studies.flexibility import impacts
from tailslap.studies.flexibility.impact_report import WORDS, impact_flexibility_report
from tailslap.studies.flexibility.impacts import (
    NAMES,
    ImpactFlexibility,
    ImpactPoint,
    levels_of,
    measure_impact,
)

pytestmark = pytest.mark.verification

FREQUENCIES = (256.0, 128.0, 64.0, 32.0, 16.0, 8.0)


def plate(frequency: float, why: str = "") -> ImpactPoint:
    """A plate whose strikes differ by 10/f^2 at f in Hz; its mesh's error is a hundredth of that."""
    size = 10.0 / frequency**2
    return ImpactPoint(frequency, dict.fromkeys(NAMES, -size), dict.fromkeys(NAMES, 0.01 * size), why)


def test_levels_lie_where_the_difference_crosses_them() -> None:
    levels = levels_of(tuple(map(plate, FREQUENCIES)), "strike_2.impulse")
    assert [level.kind for level in levels] == ["crossed"] * 3
    assert [level.frequency for level in levels] == pytest.approx(
        [math.sqrt(10.0 / x) for x in (0.01, 0.05, 0.1)]
    )


def test_a_plate_that_strikes_with_other_corners_tells_no_level() -> None:
    soft = ImpactPoint(8.0, dict.fromkeys(NAMES, math.nan), dict.fromkeys(NAMES, math.nan), "")
    levels = levels_of((*map(plate, FREQUENCIES[:-1]), soft), "strike_1.impulse")
    assert (levels[-1].kind, levels[-1].frequency) == ("not reached", 16.0)


def test_what_a_plate_s_run_records(monkeypatch: pytest.MonkeyPatch) -> None:
    """The mesh's check is left to the levels; what is not compared is not a number; a refusal is its reason."""

    def run(plan: Any) -> Any:
        checks = [SimpleNamespace(name=name, passed=False) for name in ("mesh", "energy balance")]
        return SimpleNamespace(difference={NAMES[0]: 0.5}, mesh_error={}, checks=checks)

    monkeypatch.setattr(impacts, "run_impact", run)
    source: Source = read_scene("impact-mash-tl4-sut")[1]
    changes: Changes = {"contact.friction": 0.1}
    record = measure_impact(source, changes)
    assert (record["difference"][NAMES[0]], record["why"]) == (0.5, "energy balance")
    assert math.isnan(record["difference"][NAMES[1]])
    assert "contact.restitution" in measure_impact(source, {"contact.restitution": 2.0})["why"]


def test_the_report_holds_every_plate(tmp_path: Path) -> None:
    plan = ImpactCase(*read_scene("impact-mash-tl4-sut"))
    points = (*map(plate, FREQUENCIES[:-1]), plate(8.0, "energy balance"))
    levels = {name: levels_of(points, name) for name in NAMES}
    found = ImpactFlexibility(plan, points, levels, 69.0, 1.0, 3.0)
    report = impact_flexibility_report(found)
    write_report(report, tmp_path)
    page = (tmp_path / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    assert "to 1 % down to 31.6 Hz" in page
    assert all(word in page for word in WORDS.values())
    assert "8 Hz: energy balance" in page
    rows = (tmp_path / "points.csv").read_text().splitlines()
    assert len(rows) == 1 + len(points)
    assert np.isclose(float(rows[1].split(",")[1]), -10.0 / 256.0**2)
