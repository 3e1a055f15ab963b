"""Checks of a run, whose values must be finite and within limits.

A `CheckKind` is registered once, with its name, evaluation and advice; a `Check` is its result for one run.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from fem.registry import Registry
from postprocess.units import percent_up, shown

T = TypeVar("T")
OutcomeT = TypeVar("OutcomeT", contravariant=True)
"""Outcome of a run of one kind of case."""

FINER = "refine plate.elements, or remove plate.elements and plate.element"
STEP = "a smaller time.safety_factor"
"""Advice of checks of both kinds of case."""


@dataclass(frozen=True)
class Check:
    """Result of a check of one run.

    Attributes
    ----------
    value, limit : float
        What was evaluated, and the largest value that passes.
    meaning : str
        What value and limit are.
    advice : str
        Changes of the scene that may let a failed run pass, separated by semicolons.
    in_percent : bool
        Whether value and limit are printed in per cent.
    """

    name: str
    value: float
    limit: float
    passed: bool
    meaning: str = ""
    advice: str = ""
    in_percent: bool = False

    @classmethod
    def at_most(
        cls, name: str, value: float, limit: float, meaning: str, advice: str = "", in_percent: bool = False
    ) -> Check:
        """Make a check that a finite value passes up to the limit."""
        passed = bool(math.isfinite(value) and value <= limit)
        return cls(name, float(value), limit, passed, meaning, advice, in_percent)


class Evaluation(NamedTuple):
    """Value, limit and meaning of a check, and advice for this run."""

    value: float
    limit: float
    meaning: str
    advice: str = ""


@dataclass(frozen=True)
class CheckKind(Generic[OutcomeT]):
    """Check of every run of a kind of case.

    Attributes
    ----------
    evaluate : callable
        Returns the evaluation of an outcome, or None where the check does not apply.
    advice : str
        Changes of the scene that may let a failed run pass.
    group : str
        Heading of its table.
    shows_ringing : bool
        Whether a run with an oscillating reaction fails it.
    of_reaction : bool
        Whether an oscillating reaction alone, with correct quantities at the tail-slap, can fail it.
    in_percent : bool
        Whether value and limit are printed in per cent.
    """

    name: str
    evaluate: Callable[[OutcomeT], Evaluation | None]
    advice: str
    group: str = "Others"
    shows_ringing: bool = False
    of_reaction: bool = False
    in_percent: bool = False

    def check(self, outcome: OutcomeT) -> Check | None:
        """Return the check of this run, None where it does not apply."""
        result = self.evaluate(outcome)
        return result and Check.at_most(self.name, *result[:3], result.advice or self.advice, self.in_percent)


class CheckRegistry(Registry[CheckKind[T]]):
    """Checks of a kind of case by name.

    Their order is that of the report.
    """

    def add(
        self, name: str, advice: str, group: str = "Others", **flags: bool
    ) -> Callable[[Callable[[T], Evaluation | None]], Callable[[T], Evaluation | None]]:
        """Register a function as a check, see `CheckKind`."""

        def register(evaluate: Callable[[T], Evaluation | None]) -> Callable[[T], Evaluation | None]:
            self.register(CheckKind(name, evaluate, advice, group, **flags))
            return evaluate

        return register


@np.errstate(all="ignore")  # diverged runs fail their checks; warnings would add nothing
def evaluated(kinds: Iterable[CheckKind[OutcomeT]], outcome: OutcomeT) -> tuple[Check, ...]:
    """Return the checks that apply to a run, in their order."""
    return tuple(check for kind in kinds if (check := kind.check(outcome)))


def energy_surplus(history: Mapping[str, NDArray[np.float64]], stored: Iterable[str]) -> NDArray[np.float64]:
    """Return the energy error [J], shape (rows,).

    stored: names of the columns of stored energy.
    """
    total = np.sum([history[name] for name in stored], axis=0)
    balance = total - history["friction_work"] - history["damping_work"]
    return np.asarray(balance - balance[0])


def advice(texts: Iterable[str]) -> str:
    """Join the advice of several checks without repetitions."""
    return "; ".join(dict.fromkeys(part for text in texts for part in text.split("; ") if part))


def printed_check(check: Mapping[str, Any]) -> dict[str, Any]:
    """Return a check of a summary with value and limit as text."""
    value, limit = check["value"], check["limit"]
    if not check.get("in_percent"):
        return {**check, "value": shown(value, ".3g"), "limit": shown(limit, ".3g")}
    return {
        **check,
        "value": percent_up(math.nan if value is None else value),
        "limit": f"{100.0 * limit:g} %",
    }


def failed_names(checks: Iterable[Check]) -> tuple[str, ...]:
    """Return the names of the checks that failed."""
    return tuple(check.name for check in checks if not check.passed)


def failed_sentence(checks: Iterable[Check]) -> str:
    """Return failed checks and their remedy as a sentence, empty without any."""
    failed = [printed_check(vars(check)) for check in checks if not check.passed]
    if not failed:
        return ""
    named = ", ".join(f"{check['name']} {check['value']} (limit {check['limit']})" for check in failed)
    return f"Failed: {named}. Remedy: {advice(check['advice'] for check in failed)}. "


def check_columns(checks: Iterable[Check]) -> dict[str, str | float]:
    """Return the checks as columns of the table of a sweep.

    Whether all passed, the names of those that failed, and the values of all.
    """
    failed = failed_names(checks)
    values = {re.sub("[ -]", "_", f"check.{check.name}"): float(check.value) for check in checks}
    return {"status": "failed" if failed else "passed", "reason": ", ".join(failed), **values}
