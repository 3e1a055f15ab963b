"""Verification: the cost study's soft plate, its limit, what choices add to a mesh, and the page of both questions."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from postprocess.comparison.comparison import largest_relative
from postprocess.report.report import write_report
from tailslap.case.corner.case import CornerCase
from tailslap.planning.fe_plan import make_fe_plan
from tailslap.scene.read import read_scene
from tailslap.scene.vary import vary
from tailslap.studies.cost.campaign import ROUNDING, summed_up
from tailslap.studies.cost.limits import Limit, limit_of
from tailslap.studies.cost.measure import measure
from tailslap.studies.cost.report import cost_report
from tailslap.studies.cost.settings import MODAL, Setting, settings
from tailslap.studies.cost.soft import soft_changes, soft_settings

pytestmark = pytest.mark.verification

TRUTH = {"t": 1.0, "v_gx": 2.0, "v_gy": -4.0, "omega": 0.5, "slide": 8.0}


def made_records(todo: list[Setting], order: float = 2.0) -> dict[str, Any]:
    """Errors of 1e-3 over the refinement to the order; steps that are halves; the modal model fails a check."""
    return {
        s.key: {
            "values": {k: v * (1.0 + 1e-3 * max(s.refinement, 0.1) ** -order) for k, v in TRUTH.items()},
            "setup": [0.1],
            "loop": [0.01 * max(s.refinement, 0.1), 0.5],
            "steps": round(1000 * s.refinement),
            "failed": ["linear modes"] if s.kind == MODAL else [],
        }
        for s in todo
    }


@pytest.mark.long
def test_page_and_summary(tmp_path: Path) -> None:
    plan = CornerCase(*read_scene("paper-table-3"))
    todo = [*settings(plan.scene), *soft_settings(plan.scene)]
    found = summed_up(plan, todo, made_records(todo), ("plate.start=inertia-relief",), TRUTH, 1.0)
    report = cost_report(found)
    write_report(report, tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["front"]["flexible"][-1].startswith("soft plate, q")
    assert summary["known"]["rigid"] == ROUNDING
    page = (tmp_path / "report.html").read_text()
    assert page.count("<svg") == sum(len(section.figures) for section in report.page.sections) > 2
    for words in ("Pareto front", "failed a check", "FE, row-sum masses", "quad9, order 2.0", "is known to"):
        assert words in page
    assert len((tmp_path / "points.csv").read_text().splitlines()) == len(todo) + 1


def test_errors_of_the_soft_plate_are_from_its_limit_and_not_below_what_is_known() -> None:
    plan = CornerCase(*read_scene("paper-table-3"))
    todo = [*settings(plan.scene), *soft_settings(plan.scene)]
    found = summed_up(plan, todo, made_records(todo), (), {k: 1.01 * v for k, v in TRUTH.items()}, 1.0)
    assert found.limit.values == pytest.approx(TRUTH, rel=1e-9)
    assert found.limit.known == pytest.approx(1.25e-3 / 64, rel=1e-3)  # the finest is 8 times finer
    assert found.flexibility == pytest.approx(0.01 / 1.01, rel=1e-6)
    errors = {p.setting.label: p.error for p in found.flexible if p.setting.group == "quad9"}
    assert errors["10 x 3"] == pytest.approx(1e-3, rel=1e-6)
    assert errors["80 x 24"] == found.limit.known
    assert all(p.error >= ROUNDING for p in found.rigid)
    added = [p.added for p in found.flexible if p.setting.group == "damping"]
    assert added == sorted(added, reverse=True)


def test_limit_without_convergence_is_the_finest_and_little_known() -> None:
    values = [{"values": {k: v * factor for k, v in TRUTH.items()}} for factor in (1.0, 1.1, 1.0)]
    assert limit_of(values) == Limit(TRUTH, pytest.approx(0.3))  # type: ignore[arg-type]
    assert math.isnan(limit_of(values[:2]).known)


@pytest.mark.parametrize(
    "changes",
    [
        (),
        ("plate.youngs_modulus=", "plate.first_frequency=5 Hz", "corner.patch_length=1", "damping.ratio=0.1"),
        ("corner.penalty_scale=3", "corner.damping_ratio=0.1", "plate.start=unstressed"),
    ],
)
def test_soft_plate_keeps_what_the_scene_gives(changes: tuple[str, ...]) -> None:
    """Its first frequency and patch are the scene's where it has them; nothing that the modal model refuses stays."""
    plan = CornerCase(*read_scene("paper-table-3", changes))
    soft, source = vary(plan.source, {**soft_changes(plan), "plate.element": "quad9"})
    fe_plan = make_fe_plan(CornerCase(soft, source))
    assert soft.plate is not None
    assert soft.plate.first_frequency is None
    frequency, patch = (5.0, 1.0) if "corner.patch_length=1" in changes else (8.0, 2.0)
    assert fe_plan.first_frequency == pytest.approx(frequency, rel=1e-3)
    assert (soft.corner.patch_length, soft.corner_friction) == (patch, 0.0)
    assert (soft.plate.start, soft.corner.constraint, soft.damping) == ("inertia-relief", "exact", None)


@pytest.mark.long
def test_meshes_of_the_soft_plate_converge_and_a_spring_adds_in_proportion() -> None:
    """The three coarser meshes of quad9 approach each other by more than half; ten times the spring, a tenth added."""
    plan = CornerCase(*read_scene("paper-table-3"))
    soft, todo = vary(plan.source, soft_changes(plan))[1], soft_settings(plan.scene)
    by_key = {setting.key.removeprefix("soft plate, "): setting for setting in todo}
    wanted = ("quad9: 10 x 3", "quad9: 20 x 6", "quad9: 40 x 12", "penalty: scale 3", "penalty: scale 30")
    values = [measure(soft, by_key[key])["values"] for key in wanted]
    coarse, medium, fine, loose, stiff = values
    assert largest_relative(medium, fine) < 0.5 * largest_relative(coarse, medium)
    assert largest_relative(loose, medium) == pytest.approx(10.0 * largest_relative(stiff, medium), rel=0.05)
