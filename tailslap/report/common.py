"""What pages and summaries of all commands have in common: version, scene, files, sizes and times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import tailslap
from postprocess.report.page import Page, Section

if TYPE_CHECKING:
    from tailslap.case.case import Case


def footer(files: str = "") -> str:
    """The version, and the files beside the page."""
    beside = f" The files beside this page: {files}." if files else ""
    return f"tailslap {tailslap.__version__}.{beside}"


def study_page(
    plan: Any, kicker: str, headline: str, sections: Sequence[Section], files: str, passed: bool | None = None
) -> Page:
    """The page of a study of a plan; files: those beside it."""
    return Page(kicker, plan.scene.name, headline, sections, footer(files), plan.source.text, passed)


def run_summary(outcome: Any, omitted: Sequence[tuple[str, str]]) -> dict[str, Any]:
    """What the summaries of both calculations' runs have alike, SI; omitted: parts left out, and why."""
    fe_plan, model = outcome.fe_plan, outcome.fe_plan.model
    return {
        "scene": fe_plan.case.scene.name,
        "version": tailslap.__version__,
        "passed": outcome.passed,
        "checks": [asdict(check) for check in outcome.checks],
        "chosen": [asdict(decision) for decision in fe_plan.decisions],
        "cost": run_cost(outcome),
        "left_out": [{"part": part, "why": why} for part, why in omitted],
        "plate": {
            "mass": model.mass,
            "youngs_modulus": fe_plan.plate.youngs_modulus,
            "first_frequency": fe_plan.first_frequency,
            "highest_frequency": model.highest_frequency,
            "stable_time_step": model.stable_time_step,
        },
    }


def run_cost(outcome: Any) -> dict[str, float | int]:
    """Sizes and times of a run."""
    loop = outcome.fe_plan.model.loop
    return {
        "elements": int(loop.table.connectivity.shape[1]),
        "nodes": int(loop.mass.size),
        "steps": outcome.run.steps,
        "time_step": loop.time_step,
        "setup_s": outcome.setup_s,
        "time_loop_s": outcome.run.time_loop_s,
    }


def study_summary(study: str, plan: Case) -> dict[str, Any]:
    """How the summary of a study begins."""
    return {"study": study, "scene": plan.scene.name, "version": tailslap.__version__}
