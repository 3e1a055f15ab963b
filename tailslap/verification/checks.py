"""The checks that a run must pass before its numbers are believed. A value that is not finite fails.

Adding one is adding it to the list of `mechanics`, `contact_work` or `crash_practice`, or registering it here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from fem.registry import Registry
from tailslap.planning.fe_plan import FePlan
from tailslap.verification.check import Check, CheckKind, Evidence, evaluated
from tailslap.verification.contact_work import CONTACT
from tailslap.verification.crash_practice import ENERGY_RATIO, PRACTICE
from tailslap.verification.mechanics import MECHANICS
from tailslap.verification.numerical_error import NumericalError, SecondRun

if TYPE_CHECKING:
    from fem.run.corner import Run

CHECKS: Registry[CheckKind] = Registry("check")
"""Checks by name, in the order in which they are told."""

for _kind in (*MECHANICS, ENERGY_RATIO, *CONTACT, *PRACTICE):
    CHECKS.register(_kind)


@np.errstate(all="ignore")  # a run that diverged is judged, not warned about
def run_checks(
    fe_plan: FePlan,
    run: Run,
    rigid: Mapping[str, np.ndarray],
    differences: Mapping[str, float],
    second: SecondRun | None = None,
) -> tuple[Check, ...]:
    """All checks of a run; `rigid` is the rigid history at the run's instants, `differences` may be empty."""
    return evaluated(CHECKS.values(), Evidence(fe_plan, run, rigid, differences, second))


def error_of(
    fe_plan: FePlan, run: Run, differences: Mapping[str, float], second: SecondRun | None
) -> NumericalError:
    """The run's numerical error."""
    return Evidence(fe_plan, run, {}, differences, second).error


def ringing_checks() -> set[str]:
    """Names of the checks that a run which rings fails."""
    return {name for name, kind in CHECKS.items() if kind.shows_ringing}


def reaction_checks() -> set[str]:
    """Names of the checks that a reaction which rings can fail while the five quantities are right."""
    return {name for name, kind in CHECKS.items() if kind.of_reaction}


def advice(failed: Iterable[str]) -> str:
    """What could be changed in a scene whose run failed these checks, each thing once, in their order."""
    told = [CHECKS[name].advice for name in failed if name in CHECKS]
    parts = dict.fromkeys(part for words in told for part in words.split("; "))
    return "; ".join(parts)
