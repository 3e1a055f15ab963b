"""Validate A13.3.1 by a published worked example."""

import pytest

from solver.parapet import yield_line_resistance

pytestmark = pytest.mark.validation


def test_worked_example_of_a_barrier():
    """MEMCALC_PRO_MAX (github.com/1xmanMAX), review of its bridges, "Barrera".

    H 0.85 m, L_t 1.07 m, M_c 5.77 t m/m, M_w H 4.35 t m: R_w 38.8 t, above F_t 24.5 t; inputs are rounded to 0.01.
    """
    force = yield_line_resistance(0.85, 0.0, 4.35, 5.77, 1.07, "interior").force
    assert round(force, 1) == 38.8
