"""Validate A13.3.1 and punching by published values."""

import math

import pytest

from solver.parapet import punching, yield_line_resistance

pytestmark = pytest.mark.validation


def test_worked_example_of_a_barrier():
    """MEMCALC_PRO_MAX (github.com/1xmanMAX), review of its bridges, "Barrera".

    H 0.85 m, L_t 1.07 m, M_c 5.77 t m/m, M_w H 4.35 t m: R_w 38.8 t, above F_t 24.5 t; inputs are rounded to 0.01.
    """
    force = yield_line_resistance(0.85, 0.0, 4.35, 5.77, 1.07, "interior").force
    assert round(force, 1) == 38.8


@pytest.mark.parametrize(
    ("sides", "factor"), [((42.0, 12.0), 0.063 + 0.126 * 12.0 / 42.0), ((12.0, 12.0), 0.126)]
)
def test_punching_is_the_two_way_action_of_footings(sides, factor):
    """AASHTO LRFD 5.12.8.6.3 as in CivilPy (github.com/drparks71w/CivilPy), substructure.

    V_n = (0.063 + 0.126/beta) sqrt(f_c) b_0 d, at most 0.126 sqrt(f_c) b_0 d [kip, ksi, in]; factors have three digits.
    """
    inch, kip, concrete, depth = 0.0254, 4448.2216152605, 4.0, 8.0
    perimeter = sides[0] + depth + 2.0 * (sides[1] + 0.5 * depth)
    strength = punching(concrete * kip / inch**2, depth * inch, sides[0] * inch, sides[1] * inch) / kip
    assert strength == pytest.approx(factor * math.sqrt(concrete) * perimeter * depth, rel=5e-3)
