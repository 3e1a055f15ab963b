"""Verification: the grid convergence procedure against a published worked example and exact power laws."""

from __future__ import annotations

import math

import pytest

from postprocess.comparison.metrics import grid_convergence, observed_order

pytestmark = pytest.mark.verification


def test_published_example() -> None:
    """NPARC Alliance, "Examining Spatial (Grid) Convergence": p = 1.786170, 0.97130, GCI 0.103083 and 0.356249 %."""
    found = grid_convergence((0.97050, 0.96854, 0.96178), (2.0, 2.0))
    assert found.order == pytest.approx(1.786170, abs=5e-7)
    assert found.extrapolated == pytest.approx(0.97130, abs=5e-6)
    assert 100.0 * found.gci_fine == pytest.approx(0.103083, abs=5e-7)
    assert 100.0 * found.gci_coarse == pytest.approx(0.356249, abs=5e-7)
    assert found.behaviour == "converging"
    assert found.asymptotic == pytest.approx(1.0, abs=3e-3)


@pytest.mark.parametrize("order", [0.8, 1.7, 4.0])
@pytest.mark.parametrize("ratios", [(2.0, 2.0), (1.5, 2.2), (3.0, 1.2)])
def test_power_law_is_found_exactly(order: float, ratios: tuple[float, float]) -> None:
    sizes = (1.0, ratios[0], ratios[0] * ratios[1])
    values = tuple(5.0 - 0.01 * size**order for size in sizes)
    found = grid_convergence(values, ratios)
    assert found.order == pytest.approx(order, rel=1e-9)
    assert found.extrapolated == pytest.approx(5.0, rel=1e-12)
    assert found.error == pytest.approx(0.01 / 4.99, rel=1e-9)
    assert found.gci_fine == pytest.approx(1.25 * found.error, rel=1e-9)
    assert found.gci_coarse == pytest.approx(1.25 * 0.01 * sizes[1] ** order / values[1], rel=1e-9)


@pytest.mark.parametrize(
    ("values", "behaviour"),
    [
        ((1.0, 1.1, 0.9), "oscillating"),
        ((1.0, 2.0, 2.5), "diverging"),
        ((3.9, 3.6, 3.29), "slow"),  # a logarithm: it grows by the same with every halving
        ((2.0, 2.0, 2.0), "settled"),
    ],
)
def test_values_that_do_not_converge_are_not_extrapolated(values: tuple[float, ...], behaviour: str) -> None:
    found = grid_convergence(values, (2.0, 2.0))  # type: ignore[arg-type]
    assert found.behaviour == behaviour
    assert found.extrapolated == values[0]
    if behaviour != "settled":
        assert found.gci_fine == pytest.approx(3.0 * abs(values[0] - values[1]) / values[0])


def test_no_order_for_a_quotient_that_no_power_law_has() -> None:
    assert observed_order(0.1, (1.5, 2.2)) == -math.inf


def test_ratios_must_be_above_one() -> None:
    with pytest.raises(ValueError, match="above 1"):
        grid_convergence((1.0, 2.0, 3.0), (1.0, 2.0))
