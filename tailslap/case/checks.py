"""Checks: a kind is registered once with its name, judgement and advice; a check is its outcome for a run."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

FINER = "refine plate.elements, or leave plate.elements and plate.element out"
STEP = "a smaller time.safety_factor"
"""Advice of checks of both kinds of case."""


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
    """Columns of a sweep's table on a run's checks: whether all passed, those that failed, and the values of all."""
    failed = failed_names(checks)
    values = {re.sub("[ -]", "_", f"check.{check.name}"): float(check.value) for check in checks}
    return {"status": "failed" if failed else "passed", "reason": ", ".join(failed), **values}


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


@np.errstate(all="ignore")  # a run that diverged is judged, not warned about
def evaluated(kinds: Iterable[CheckKind], evidence: Any) -> tuple[Check, ...]:
    """The checks that apply, in their order."""
    return tuple(check for kind in kinds if (check := kind.outcome(evidence)))


def advice(kinds: Mapping[str, CheckKind], failed: Iterable[str]) -> str:
    """Advise on what could be changed in a scene whose run failed these checks, each thing once, in their order."""
    parts = [kinds[name].advice for name in failed if name in kinds]
    return "; ".join(dict.fromkeys(part for words in parts for part in words.split("; ")))


def energy_surplus(history: Mapping[str, np.ndarray], stored: Iterable[str]) -> np.ndarray:
    """Energy [J] that the balance has too much at each instant, shape (rows,); stored: columns of what is held."""
    held = np.sum([history[name] for name in stored], axis=0)
    balance = held - history["friction_work"] - history["damping_work"]
    return np.asarray(balance - balance[0])


def time_step(given: Any) -> Evaluation:
    """The time step of a run over the stable one."""
    model, run = given.fe_plan.model, given.run
    ratio = model.loop.time_step / model.stable_time_step * run.highest_frequency / model.highest_frequency
    meaning = "time step over the stable one, with the highest frequency that the deformed plate had"
    return Evaluation(ratio, 1.0, meaning)
