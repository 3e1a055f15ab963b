"""Verification: the check that a corner's force on a node of a soft plate has no limit as the mesh is refined."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from tailslap.case.checks import Check, evaluated
from tailslap.case.impact.checks import CHECKS, FLOOR, SHARE, WEDGE

pytestmark = pytest.mark.verification


def outcome(
    modulus: float, patch: float | None = None, stiffness: float | None = 2e6, off: float = 0.0
) -> Any:
    contact = SimpleNamespace(stiffness=stiffness, patch_length=patch)
    plan = SimpleNamespace(scene=SimpleNamespace(needed_contact=contact))
    plate = SimpleNamespace(modulus=modulus, thickness=0.05)
    return SimpleNamespace(
        fe_plan=SimpleNamespace(case=plan, plate=plate), difference={"strike_1.impulse": off}
    )


def point_contact(made: Any) -> Check:
    (check,) = evaluated([kind for kind in CHECKS if kind.name == "point contact"], made)
    return check


def test_the_wedge_s_constant() -> None:
    """Half the sum of both components' constants of a right-angled wedge, each 2/(pi/2 +- 1)."""
    along, across = 2.0 / (0.5 * math.pi + 1.0), 2.0 / (0.5 * math.pi - 1.0)
    assert pytest.approx(0.5 * (along + across), rel=1e-15) == WEDGE


def test_a_point_on_a_soft_plate_fails() -> None:
    """E t = 1e7 N/m against k = 2e6 N/m: 0.2 WEDGE log 2 = 0.297."""
    check = point_contact(outcome(2e8))
    assert check.value == pytest.approx(0.2 * WEDGE * math.log(2.0), rel=1e-12)
    assert (check.limit, check.passed) == (FLOOR, False)
    assert point_contact(outcome(2e8, off=0.2)).limit == pytest.approx(FLOOR + 0.2 * SHARE)


def test_what_has_a_limit_passes() -> None:
    assert point_contact(outcome(2e11)).passed
    assert point_contact(outcome(2e8, patch=1.0)).value == 0.0
    assert point_contact(outcome(2e8, stiffness=None)).value == 0.0
