"""Verify units of scenes and their products by definition."""

import math

import pytest

from tailslap.scene.units import UNITS, converted, to_si

# International yard and pound (1959), standard gravity (CGPM 1901), SI prefixes.
POUND, POUND_FORCE = 0.45359237, 0.45359237 * 9.80665
DEFINED = {
    **{"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "in": 0.0254, "ft": 0.3048, "yd": 0.9144, "mi": 1609.344},
    **{"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": POUND, "klb": 1e3 * POUND, "slug": POUND_FORCE / 0.3048},
    **{"s": 1.0, "us": 1e-6, "ms": 1e-3, "min": 60.0, "h": 3600.0, "rad": 1.0, "deg": math.pi / 180.0},
    **{"mph": 1609.344 / 3600.0, "kph": 1000.0 / 3600.0, "Hz": 1.0, "kHz": 1e3, "J": 1.0, "kJ": 1e3},
    **{"N": 1.0, "kN": 1e3, "MN": 1e6, "GN": 1e9, "lbf": POUND_FORCE, "kip": 1e3 * POUND_FORCE},
    **{"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12, "bar": 1e5},
    **{"psf": POUND_FORCE / 0.3048**2, "psi": POUND_FORCE / 0.0254**2, "ksi": 1e3 * POUND_FORCE / 0.0254**2},
}
DIMENSIONS = {
    "psi": "kg/m/s^2", "kip": "kg m/s^2", "mph": "m/s", "kJ": "kg m^2/s^2", "slug": "kg", "Hz": "1/s",
}  # fmt: skip


def test_every_unit_has_its_defined_factor():
    assert {name: factor for name, (factor, _) in UNITS.items()} == pytest.approx(DEFINED, rel=1e-15)


@pytest.mark.parametrize(("name", "base"), DIMENSIONS.items())
def test_dimensions_are_those_of_base_units(name, base):
    assert to_si(name)[1] == to_si(base)[1]


@pytest.mark.parametrize(("compound", "unit", "factor"), [
    *(("km/h", "m/s", 1.0 / 3.6), ("ft/s", "m/s", 0.3048), ("lbf/ft^2", "Pa", 47.88025898033584)),
    *(("lb/ft^3", "kg/m^3", 16.018463373960142), ("kN/mm", "N/m", 1e6), ("MPa", "N/m^2", 1e6)),
    *(("t m^2", "kg m^2", 1e3), ("kHz", "1/s", 1e3), ("kip/ft", "N/m", 4448.2216152605 / 0.3048)),
])  # fmt: skip
def test_products_convert_by_their_factors(compound, unit, factor):
    assert converted(12.34, compound, unit) == pytest.approx(12.34 * factor, rel=2e-15)


@pytest.mark.parametrize(
    ("other", "unit"), [("kg", "m"), ("Hz", "rad/s"), ("1/s", "rad/s"), ("deg", "m/m"), ("s", "1/s")]
)
def test_another_dimension_is_refused(other, unit):
    with pytest.raises(ValueError, match="its dimension differs"):
        converted(1.0, other, unit)


def test_an_unknown_name_is_refused_with_those_that_are_known():
    with pytest.raises(ValueError, match=r'"furlong" is unknown; allowed are m, mm, .*ksi, J, kJ, Hz, kHz'):
        converted(1.0, "furlong/h", "m/s")


def test_a_radian_is_a_dimension_of_its_own():
    assert to_si("rad/s")[1] == (0, 0, -1, 1)
