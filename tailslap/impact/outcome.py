"""A finished run of a whole impact: what was computed, compared and checked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from tailslap.impact.answers import ImpactAnswer
from tailslap.impact.fe_plan import ImpactFePlan
from tailslap.impact.paper_method import PaperMethod, paper_method
from tailslap.verification.check import Check

if TYPE_CHECKING:
    from fem.run.impact import ImpactRun

COMPARED = ("impulse", "peak_force", "duration")
"""What is compared of each of the first two strikes."""


@dataclass(frozen=True)
class ImpactOutcome:
    """A finished run of a whole impact.

    Attributes
    ----------
    fe_plan : ImpactFePlan
        What was integrated.
    run : ImpactRun
        Histories of motion and contact.
    rigid, fe : ImpactAnswer
        What both models answer, at the same instants.
    difference : dict of float
        FE/rigid - 1 of impulse, peak force and duration of the first two strikes, by `strike_1.impulse` and so on.
    mesh_error : dict of float
        The same of a run with richer elements against this one: the mesh's error; empty where there was none.
    checks : tuple of Check
        In the order of the report.
    frequency_error : float
        First frequency over that of the richer elements, less 1; NaN where there were none.
    setup_s : float
        Time that model and compilation took [s].
    """

    fe_plan: ImpactFePlan
    run: ImpactRun
    rigid: ImpactAnswer
    fe: ImpactAnswer
    difference: dict[str, float]
    mesh_error: dict[str, float]
    setup_s: float
    frequency_error: float = math.nan
    checks: tuple[Check, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    @cached_property
    def paper_method(self) -> PaperMethod | None:
        """The paper's method beside the rigid vehicle's impact."""
        return paper_method(self.fe_plan.case.scene, self.rigid)


def differences(fe: ImpactAnswer, rigid: ImpactAnswer) -> dict[str, float]:
    """FE/rigid - 1 of the first two strikes; none where the corners do not strike in the same order."""
    found = {}
    for k, (one, other) in enumerate(zip(fe.strikes[:2], rigid.strikes[:2], strict=False), 1):
        if one.corner != other.corner:
            break
        for name in COMPARED:
            found[f"strike_{k}.{name}"] = getattr(one, name) / getattr(other, name) - 1.0
    return found
