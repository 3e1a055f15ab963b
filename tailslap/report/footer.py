"""What stands on every page and in every summary of this program."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import tailslap

if TYPE_CHECKING:
    from tailslap.impact.plan import ImpactPlan
    from tailslap.planning.plan import Plan


def footer(files: str = "") -> str:
    """The version, and the files beside the page."""
    beside = f" The files beside this page: {files}." if files else ""
    return f"tailslap {tailslap.__version__}.{beside}"


def study_summary(study: str, plan: Plan | ImpactPlan) -> dict[str, Any]:
    """How the summary of a study begins."""
    return {"study": study, "scene": plan.scene.name, "version": tailslap.__version__}
