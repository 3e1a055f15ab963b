"""Verify numbers, units and symbols as pages and terminal print them."""

import math

import numpy as np
import pytest
from markupsafe import Markup

from postprocess.report.prose import NO_BREAK, glued, prose
from postprocess.svg.scales import power_text, tick_texts
from postprocess.units import (
    SI,
    US,
    duration,
    force,
    grouped,
    known,
    measure,
    number,
    percent,
    percent_up,
    shown,
)

ABOVE_NOUGHT = known(".1e", negligible=1e-9)

PLAIN = [
    (number(0.1), "0.1"), (number(7421), "7421"), (number(True), "yes"), (number(None), "–"),
    (number("20 x 6"), "20 x 6"), (number(2.0e11), "2e+11"), (number(math.inf), "infinite"),
    (number(-math.inf), "-infinite"), (number(-0.0), "0"),
    (shown(0.1, "#.8g"), "0.10000000"), (shown(-3.0, "#.8g"), "-3.0000000"), (shown(-1.234e-6, "+.2e"), "-1.23e-06"),
    (shown(math.nan, "+.2e"), "not a number"), (shown(None, ".3g"), "–"), (shown(-0.0, ".3g"), "0"),
    (shown(-0.0, "+.1f"), "+0.0"), (grouped(1234567), "1 234 567"),
    (duration(3.2e-5), "32 us"), (duration(0.01234), "12.3 ms"), (duration(12.345), "12.3 s"), (duration(0.0), "–"),
    (ABOVE_NOUGHT(-9e-10), "0"), (ABOVE_NOUGHT(-2e-9), "-2.0e-09"), (ABOVE_NOUGHT(math.inf), "–"),
    (known(".1e")(1e-300), "1.0e-300"),
    (percent(0.0123456, 3), "+1.235 %"), (percent(-0.5, 3), "-50.000 %"), (percent(-1e-9, 3), "0.000 %"),
    (percent_up(2.16e-6), "0.00022 %"), (percent_up(2e-6), "0.0002 %"), (percent_up(0.00567), "0.57 %"),
    (percent_up(-0.0101), "1.1 %"), (percent_up(1.0), "100 %"), (percent_up(0.0), "0 %"),
    (percent_up(5.71e-9), "5.8e-07 %"), (percent_up(math.nan), "unknown"), (percent_up(math.inf), "unknown"),
    (power_text(1e-7), "10⁻⁷"), (power_text(-1e-7), "−10⁻⁷"), (power_text(2.5e8), "2.5×10⁸"),
    (power_text(0.02), "0.02"), (power_text(-3.0), "−3"), (power_text(0.0), "0"),
    (tick_texts([-0.5, 0.0, 0.5]), ["−0.5", "0.0", "0.5"]), (tick_texts([0.0, 200.0]), ["0", "200"]),
    (tick_texts([0.0, 2e-6, 4e-6]), ["0", "2×10⁻⁶", "4×10⁻⁶"]), (tick_texts([23.28, 23.30]), ["23.28", "23.30"]),
    (tick_texts([0.0, 1e6, 2e6]), ["0", "10⁶", "2×10⁶"]),
    (glued("peak impulse [10⁻³ kN s] of it"), "peak impulse [10⁻³\xa0kN\xa0s] of it"),
    (glued("5 kN s of 2 GPa over 3 N m, N of 4"), "5\xa0kN\xa0s of 2\xa0GPa over 3\xa0N\xa0m, N of 4"),
    (glued("v = 3 m/s and 4 %"), "v\xa0=\xa03\xa0m/s and 4\xa0%"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), PLAIN)
def test_numbers_as_printed(text, expected):
    assert text == expected


def unbroken(name):
    return f'<span class="whole">{name}</span>'


IN_PRINT = [
    ("confirmed to 2.2e-06", "confirmed to 2.2×10⁻⁶"), ("at most 1e-03, 1.0e+00, 0.0e+00", "at most 10⁻³, 1.0, 0"),
    ("-3.27 m/s, +5.1e-04", "−3.27 m/s, +5.1×10⁻⁴"), ("+1.32e-01, -4.25e-01", "+0.132, −0.425"),
    ("at least 1.18e+01, 5.30e-01, 2e+02", "at least 11.8, 0.530, 200"),
    ("TL-4, -2, a-b", f"{unbroken('TL-4')}, −2, a-b"),
    ('= "quad4-reduced"', f"= &#34;{unbroken('quad4-reduced')}&#34;"),
    ("quad4-reduced: 4", f"{unbroken('quad4-reduced')}: 4"),
    ("2025-10-11, CFC-180", f"{unbroken('2025-10-11')}, {unbroken('CFC-180')}"),
    ("omega and mu |N|, start.omega", "ω and μ |N|, start.omega"), ("2 MN/m^2, exp(-3)", "2 MN/m², exp(−3)"),
    ("m (v sin(theta))^2/2", "m (v sin(θ))²/2"), ("from v_GX", "from <i>v</i><sub>GX</sub>"),
    ("`omega = -1e-06`", "<code>omega = -1e-06</code>"), ("paper_page", "paper_page"),
    ("v_GY < 1 & θ_0", "<i>v</i><sub>GY</sub> &lt; 1 &amp; <i>θ</i><sub>0</sub>"),
    ("3 <b>", "3 &lt;b&gt;"), (Markup("3 <b>"), "3 <b>"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), IN_PRINT)
def test_numbers_are_set_as_in_print(text, expected):
    assert str(prose(text)).replace(NO_BREAK, " ") == expected


MEASURES = [
    (f"a peak of {measure(445e3, 'N', '.0f')}.", "a peak of 445 kN.", "a peak of 100 kip."),
    (f"from {measure(339, 'kN', 'g', named=False)} to {measure(850, 'kN', 'g')}", "from 339 to 850 kN",
     "from 76.2 to 191 kip"),
    (measure(4.5, "m", "g"), "4.5 m", "14.8 ft"), (measure(10000.0, "kg", ".0f"), "10000 kg", "22046 lb"),
    (measure(25.034, "m/s", ".5g"), "25.034 m/s", "82.133 ft/s"), (measure(20.0, "GPa", "g"), "20 GPa", "2900 ksi"),
    (measure(2e6, "N/m", ".4g"), "2e+06 N/m", "137 kip/ft"),
    (measure(-1250.0, "N s", ".3g"), "-1.25 kN s", "-0.281 kip s"),
    (measure(np.float64(-2), "mm", "g"), "-2 mm", "-0.0787 in."),
    (measure(np.pi / 12.0, "rad", ".3g"), "15 deg", "15 deg"), (measure(8.0, "Hz", "g"), "8 Hz", "8 Hz"),
    (measure(10477.8, "N s", ".1f"), "10.5 kN s", "2.36 kip s"),  # 2.3555, not 2.3605 from 10.5
    (force(653_321.7), "653 kN", "147 kip"), (force(60_250.0), "60.2 kN", "13.5 kip"),
    (force(1_022_000.0), "1022 kN", "229.8 kip"),
    *[("as `impact.speed = 25 m/s` has it",) * 3],
]  # fmt: skip


@pytest.mark.parametrize(("text", "si", "us"), MEASURES)
def test_measures_are_rendered_in_the_units_of_the_reader(text, si, us):
    """Values keep their digits, at least three, and other texts are unchanged.

    A value is converted before it is rounded.
    """
    assert (SI.rendered(text), US.rendered(text)) == (si, us)
