"""Validate A13.3.1 and punching by published values."""

import math

import pytest

from solver.parapet import overhang_tension, punching, section_strengths, yield_line_resistance


@pytest.mark.parametrize(
    ("wall", "base", "lengths", "force"),
    [(4.35, 5.77, None, 38.8), (1.88, 5.64, (2.13, 7.38), 28.3)],
)
def test_worked_examples_of_a_barrier(wall, base, lengths, force):
    """Barriers with H 0.85 m and L_t 1.07 m, to all digits.

    MEMCALC_PRO_MAX (github.com/1xmanMAX), review of its bridges; DISENO_PUENTE_VIGA_1TRAMO (github.com/rsantiagojarah)
    after Rodríguez Serquén, Puentes con AASHTO-LRFD (2020), which also states L_c and R_w/(L_c + 2 H).
    """
    resistance = yield_line_resistance(0.85, 0.0, wall, base, 1.07, "interior")
    assert round(resistance.force, 1) == force
    if lengths:
        tension = overhang_tension(resistance.force, resistance.critical_length, 0.85)
        assert (round(resistance.critical_length, 2), round(tension, 2)) == lengths


def test_worked_example_of_a_section():
    """Part of that second barrier, 47 cm high, to all digits.

    1.775 cm2 of bars, f_y 4200 and f_c 280 kg/cm2, d 10.58 cm: M 0.764 t m.
    """
    area = 1.775e-4 / 0.47
    strengths = section_strengths(
        [(0.0, 0.2), (0.47, 0.2)], 280e4, 4200e4, 0.2 - 0.1058, (area, area), (area, area)
    )
    assert round(strengths.wall / 1e3, 3) == 0.764


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
