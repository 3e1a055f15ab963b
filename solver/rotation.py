"""Compiled sines of the rotation in a step."""

import numpy as np

from machine_code.compiled import inlined

SERIES = 1e-3
"""Square of the largest angle whose series are used: terms beyond them are less than rounding."""

SINE, VERSINE = (1 / 6, 1 / 20, 1 / 42), (1 / 12, 1 / 30, 1 / 56)
"""Ratios of the coefficients of the series, as factors: a division takes the time of four products."""


@inlined
def sine_and_versine(square: float) -> tuple[float, float]:
    """Return sine over angle, and versine over half its square.

    (sin a) / a and (1 - cos a) / (a^2 / 2); square: a^2.
    """
    if square > SERIES:
        angle = np.sqrt(square)
        return np.sin(angle) / angle, (np.sin(0.5 * angle) / (0.5 * angle)) ** 2
    sine = 1.0 - square * SINE[0] * (1.0 - square * SINE[1] * (1.0 - square * SINE[2]))
    versine = 1.0 - square * VERSINE[0] * (1.0 - square * VERSINE[1] * (1.0 - square * VERSINE[2]))
    return sine, versine
