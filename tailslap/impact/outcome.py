"""A finished run of a whole impact: what was computed, compared and checked."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from tailslap.case.case import Outcome
from tailslap.impact.answers import ImpactAnswer
from tailslap.impact.fe_plan import ImpactFePlan
from tailslap.impact.paper_method import PaperMethod, paper_method

if TYPE_CHECKING:
    from fem.run.impact import ImpactRun

COMPARED = ("impulse", "peak_force", "duration")
"""What is compared of each of the first two strikes."""


@dataclass(frozen=True)
class ImpactOutcome(Outcome):
    """A finished run of a whole impact.

    Attributes
    ----------
    rigid, fe : ImpactAnswer
        What both models answer, at the same instants.
    mesh_error : dict of float
        What higher-order elements change in `difference`, by `strike_1.impulse` and so on; empty where there were none.
    frequency_error : float
        First frequency over that of the richer elements, less 1; NaN where there were none.
    """

    fe_plan: ImpactFePlan
    run: ImpactRun
    rigid: ImpactAnswer
    fe: ImpactAnswer
    mesh_error: dict[str, float] = field(default_factory=dict)
    frequency_error: float = math.nan

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
