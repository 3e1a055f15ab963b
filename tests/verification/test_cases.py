"""Verification: over sizes, stiffnesses and frictions a run is right to 2e-3 or fails its own checks."""

from __future__ import annotations

import itertools
import math

import pytest

SIZES = ((4.0, 1.5), (10.0, 2.438), (19.0, 2.7))
FRICTIONS = (0.05, 0.47, 0.8)
MODULI = ("20 GPa", "200 GPa", "2 TPa")


def changes(size: tuple[float, float], modulus: str, friction: float, reaction: str) -> tuple[str, ...]:
    return (
        f"vehicle.length={size[0]}",
        f"vehicle.width={size[1]}",
        f"plate.youngs_modulus={modulus}",
        f"impact.friction={friction}",
        f"corner.reaction={reaction}",
    )


@pytest.mark.parametrize(
    "size", [SIZES[0], *(pytest.param(size, marks=pytest.mark.long) for size in SIZES[1:])]
)
@pytest.mark.parametrize("reaction", ["drag", "none", pytest.param("signed", marks=pytest.mark.long)])
def test_right_or_caught(outcome, size, reaction):
    right = 0
    for modulus, friction in itertools.product(MODULI, FRICTIONS):
        result = outcome("paper-table-3", *changes(size, modulus, friction, reaction))
        worst = max(map(abs, result.difference.values()), default=math.inf)
        assert worst <= 2e-3 or not result.passed, (modulus, friction)
        right += worst <= 2e-3 and result.passed
    assert right >= 5


@pytest.mark.long
def test_each_check_can_fail(outcome):
    """A scene for every check of the run that a wrong model can trip; the balances are tripped in test_checks."""
    tripped: set[str] = set()
    for change in (
        ("plate.youngs_modulus=20 TPa", "impact.friction=0.8", "corner.penalty_scale=3", "damping.kind=none"),
        ("impact.friction=0.8", "corner.penalty_scale=3", "damping.kind=none"),
        ("corner.penalty_scale=1e-5",),
        ("verify.tolerance=1e-6",),
        ("plate.youngs_modulus=20 MPa", "plate.element=tri3", "plate.elements=[4, 2]"),
    ):
        result = outcome("paper-table-3", *change)
        tripped |= {check.name for check in result.checks if not check.passed}
    assert {
        "tail-slap reached",
        "friction by ringing",
        "agreement with rigid",
        "numerical error",
        "reaction against rigid",
        "penetration",
    } <= tripped
