"""What pages and summaries of all commands have in common: version, scene, files, sizes and times."""

from __future__ import annotations

from collections.abc import Sequence
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


def study_summary(study: str, plan: Case) -> dict[str, Any]:
    """How the summary of a study begins."""
    return {"study": study, "scene": plan.scene.name, "version": tailslap.__version__}
