"""Numbers for people, with their unit: SI as engineers write it, or as American ones do, speeds in mph too."""

from __future__ import annotations

from postprocess.report.units import FOOT, SYSTEMS

MPH = 5280.0 * FOOT / 3600.0
"""[m/s]"""


def value_line(name: str, value: float, unit: str, system: str) -> str:
    """A line of a list of values, given in SI."""
    return f"  {name:<18}{shown(value, unit, system, width=14)}"


def shown(value: float, unit: str, system: str = "si", width: int = 0, digits: int = 7) -> str:
    """The value, given in the SI unit `unit`, as "digits unit"; the digits right-aligned in `width` columns."""
    factor, name = SYSTEMS[system].of(unit)
    also = f" ({value / MPH:.{digits}g} mph)" if (system, unit) == ("us", "m/s") else ""
    return f"{factor * value:>{width}.{digits}g} {name}{also}"
