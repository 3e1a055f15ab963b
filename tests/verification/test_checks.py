"""Verification: each check of a run fails when its number is made wrong, and only then."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tailslap.checks import run_checks

pytestmark = pytest.mark.verification


def failed(result: Any, differences: Any = None, **columns: Any) -> set[str]:
    """Names of the checks that fail with these columns of the history changed."""
    history = result.run.history | {
        name: change(result.run.history[name].copy()) for name, change in columns.items()
    }
    run = replace(result.run, history=history)
    checks = run_checks(result.fe_plan, run, result.rigid_history, differences or result.difference)
    return {check.name for check in checks if not check.passed}


def at(index: int, value: float) -> Callable[[np.ndarray], np.ndarray]:
    def change(column: np.ndarray) -> np.ndarray:
        column[index] = value
        return column

    return change


def test_a_right_run_fails_nothing(outcome: Callable[..., Any]) -> None:
    assert failed(outcome("paper-table-3")) == set()


def test_energy_that_is_lost_or_gained(outcome: Callable[..., Any]) -> None:
    result = outcome("paper-table-3")
    energy = result.run.history["kinetic_energy"]
    for share in (-3e-6, 3e-6):
        change = at(200, energy[200] + share * energy[0])
        assert failed(result, kinetic_energy=change) == {"energy balance"}


def test_momentum_that_no_reaction_gave(outcome: Callable[..., Any]) -> None:
    result = outcome("paper-table-3")
    assert failed(result, v_gy=lambda v: v * (1.0 + 1e-8 * np.arange(v.size))) == {"momentum balance"}


def test_a_reaction_that_rings(outcome: Callable[..., Any]) -> None:
    result = outcome("paper-table-3")
    ring = failed(result, reaction_normal=lambda n: n * (1.0 + 0.2 * (-1.0) ** np.arange(n.size)))
    assert ring == {"reaction against rigid"}
    assert failed(result, normal_impulse_magnitude=lambda j: 3.0 * j) == {"friction by ringing"}


def test_a_corner_that_leaves_the_wall(outcome: Callable[..., Any]) -> None:
    assert failed(outcome("paper-table-3"), gap=at(5, -0.03)) == {"penetration"}


def test_numbers_that_are_not_finite(outcome: Callable[..., Any]) -> None:
    result = outcome("paper-table-3")
    assert failed(result, theta=at(7, np.nan)) == {"finite numbers"}
    assert failed(result, kinetic_energy=at(7, np.inf)) == {"finite numbers", "energy balance"}


def test_a_difference_that_flexibility_does_not_explain(outcome: Callable[..., Any]) -> None:
    result = outcome("paper-table-3")
    for value in (6e-4, -6e-4, np.nan, np.inf):
        assert failed(result, differences=result.difference | {"slide": value}) == {"agreement with rigid"}


def test_a_run_that_never_strikes(outcome: Callable[..., Any]) -> None:
    result = outcome("paper-table-3")
    run = replace(result.run, strike=None)
    checks = run_checks(result.fe_plan, run, result.rigid_history, {})
    assert {check.name for check in checks if not check.passed} == {
        "tail-slap reached",
        "agreement with rigid",
    }
