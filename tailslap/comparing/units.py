"""Read units of columns as people write them.

Names are those of `pint`, the grammar that of `tailslap.scene.units`. Units of scenes mean the same here.
"""

import math
import re
from functools import cache
from itertools import product
from typing import Any

from tailslap.scene.units import unit_factors

MEANINGS = {"g": ("gram", "g_0"), "G": ("g_0",), "gn": ("g_0",), "dps": ("degree/second",)}
MEANINGS |= {"psf": ("lbf/ft**2",), "Nm": ("N*m",), "kNm": ("kN*m",)}
"""Names that pint does not have, or only in another meaning; g is a mass or the standard gravity, by the dimension."""

AMBIGUOUS = {"ton": "t, tonne, short_ton or long_ton", "tons": "t, tonne, short_ton or long_ton"}
"""Names of several units of one dimension, with those that are allowed."""

DIMENSIONLESS = ("1", "-", "\N{EN DASH}")
CHARACTERS = str.maketrans("º˚µ²³¹⁻·⋅", "°°μ231-..")
"""Other characters of units: degree and micro signs, superscripts and points."""

SPELLINGS = (
    (r"/\s*\(([^()/]+)\)", lambda match: "/" + re.sub(r"\s*\*\s*(?!\*)|\s+", "/", match[1].strip())),
    (r"(?<=[^\W\d_])(?=-?\d)", "^"),
    (r"(?<=[\w°])\s*[-.]\s*(?=[^\W\d_])", "*"),
)
"""Patterns of other spellings and their replacements, in order, like m/(s*s), m/s2 and kN-m."""


def meanings(unit: str) -> tuple[tuple[float, str], ...]:
    """Return factors to SI and the base units of a unit.

    There are several for g. Raises ValueError for text that is not a unit.
    """
    text = unit.translate(CHARACTERS).strip().rstrip(".")
    if text in DIMENSIONLESS:
        return ((1.0, "dimensionless"),)
    for pattern, replacement in SPELLINGS:
        text = re.sub(pattern, replacement, text)
    names = [[(name, power) for name in MEANINGS.get(name, (name,))] for name, power in unit_factors(text)]
    products = ([_quantity(name) ** power for name, power in chosen] for chosen in product(*names))
    quantities: list[Any] = [math.prod(factors) for factors in products]
    return tuple((float(quantity.magnitude), str(quantity.units)) for quantity in quantities)


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(on_redefinition="ignore")


@cache
def _quantity(name: str) -> Any:
    """Return one of a unit in base units.

    Raises ValueError for an unknown name, and for scales with an offset or logarithm.
    """
    if name in AMBIGUOUS:
        raise ValueError(f'"{name}" has several meanings; allowed are {AMBIGUOUS[name]}')
    try:
        zero, one = (_registry().Quantity(value, name).to_base_units() for value in (0.0, 1.0))
    except Exception as error:  # pint raises errors of many classes, AssertionError among them
        raise ValueError(f'"{name}" is no unit that is known') from error
    if zero.magnitude:
        raise ValueError(f'"{name}" is not proportional to its base unit')
    return one


def is_unit(text: str) -> bool:
    """Return True for the text of a unit."""
    try:
        return bool(meanings(text))
    except ValueError:
        return False


def ratio(unit: str, target: str) -> float:
    """Return the factor from a unit to another.

    Raises ValueError for units of different dimensions, and for text that is not a unit.
    """
    for (factor, base), (target_factor, target_base) in product(meanings(unit), meanings(target)):
        if base == target_base:
            return factor / target_factor
    raise ValueError(f"the dimension of {unit} is not that of {target}")
