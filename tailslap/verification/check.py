"""What a check is: a kind, registered once with its name, judgement and advice, and its outcome for a run."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from postprocess.comparison.metrics import Metrics, compare_histories
from tailslap.verification.numerical_error import NumericalError, SecondRun, numerical_error
from tailslap.verification.ringing import friction_by_ringing

if TYPE_CHECKING:
    from fem.laws.friction import FrictionLaw
    from fem.run.corner import Run
    from tailslap.planning.fe_plan import FePlan

Columns = Mapping[str, np.ndarray]

FINER = "refine plate.elements, or leave plate.elements and plate.element out"
STIFFER = 'a larger corner.penalty_scale, or corner.constraint = "exact"'
MORE_DAMPING = "leave damping.kind out, or give damping.rate"
STEP = "a smaller time.safety_factor"
SOFT = "a stiffer plate: it is softer than the theory of this start allows"
ROUGH = f"{MORE_DAMPING}; leave the corner's spring out"
"""Advice that several checks share."""

COMPARED_HISTORIES = ("v_gx", "v_gy", "omega", "theta", "reaction_normal")
"""Histories that are compared with the rigid motion's."""


@dataclass(frozen=True)
class Check:
    """The outcome of a check: its value, its limit, whether it passed, and what it guards against."""

    name: str
    value: float
    limit: float
    passed: bool
    meaning: str = ""

    @classmethod
    def at_most(cls, name: str, value: float, limit: float, meaning: str) -> Check:
        """A check that passes where the value is a finite number and not above the limit."""
        return cls(name, float(value), limit, bool(math.isfinite(value) and value <= limit), meaning)


def failed_names(checks: Iterable[Check]) -> tuple[str, ...]:
    """Names of the checks that failed."""
    return tuple(check.name for check in checks if not check.passed)


def check_columns(checks: Iterable[Check]) -> dict[str, Any]:
    """What the table of a sweep has of a run's checks: whether all passed, those that failed, and the values of all."""
    failed = failed_names(checks)
    values = {re.sub("[ -]", "_", f"check.{check.name}"): float(check.value) for check in checks}
    return {"status": "failed" if failed else "passed", "reason": ", ".join(failed), **values}


@dataclass(frozen=True)
class Evidence:
    """What a run is judged by: plan and run, the rigid histories at the run's instants, differences of the five
    quantities, empty where it came to no result, and a second run on another mesh, if there was one."""

    fe_plan: FePlan
    run: Run
    rigid: Columns
    differences: Mapping[str, float]
    second: SecondRun | None = None

    @property
    def history(self) -> Columns:
        """The run's history."""
        return self.run.history

    @property
    def relieved(self) -> bool:
        """Whether the plate starts by inertia relief."""
        return self.fe_plan.plate.relieved

    @property
    def friction(self) -> FrictionLaw:
        """The friction law of the scene."""
        from fem.laws.friction import FRICTION_LAWS

        return FRICTION_LAWS[self.fe_plan.case.scene.corner.reaction]

    @cached_property
    def ringing(self) -> float:
        """Friction by ringing at the end of the run."""
        return friction_by_ringing(self.fe_plan, {name: float(c[-1]) for name, c in self.history.items()})

    @cached_property
    def error(self) -> NumericalError:
        """The run's numerical error."""
        return numerical_error(self.fe_plan, self.differences, self.ringing, self.second)

    @cached_property
    def metrics(self) -> dict[str, Metrics]:
        """Metrics of each compared history while the rigid solution is known."""
        return history_metrics(self.history, self.rigid)


class Evaluation(NamedTuple):
    """Value, the limit that it may reach, and what both are."""

    value: float
    limit: float
    meaning: str


@dataclass(frozen=True)
class CheckKind:
    """A check.

    evaluate: value and limit by the evidence, of a whole impact its outcome; None where it does not apply. advice: what
    could be changed in a scene whose run fails it. shows_ringing: whether a run that rings fails it. of_reaction:
    whether a reaction that rings can fail it while the five quantities are right.
    """

    name: str
    evaluate: Callable[[Any], Evaluation | None]
    advice: str
    shows_ringing: bool = False
    of_reaction: bool = False

    def outcome(self, evidence: Any) -> Check | None:
        """The check of this run, or None where it does not apply."""
        found = self.evaluate(evidence)
        return found and Check.at_most(self.name, *found)


def evaluated(kinds: Iterable[CheckKind], evidence: Any) -> tuple[Check, ...]:
    """The checks that apply."""
    return tuple(check for kind in kinds if (check := kind.outcome(evidence)))


def history_metrics(history: Columns, rigid: Columns) -> dict[str, Metrics]:
    """Metrics of each compared history while the rigid solution is known."""
    known = np.isfinite(rigid["v_gx"])
    instants = history["t"][known]
    return {
        name: compare_histories(instants, history[name][known], rigid[name][known])
        for name in COMPARED_HISTORIES
    }
