"""Numbers for people, with their unit: SI, or as American engineers write them (ft, ft/s, mph, kip)."""

from __future__ import annotations

from tailslap.scene.units import registry

SI = {"N": (1e3, "kN"), "N s": (1e3, "kN s")}
"""SI units that are shown in thousands."""

US = {"m": ("ft",), "m/s": ("ft/s", "mph"), "N": ("kip",), "N s": ("kip s",)}
"""SI units and what stands for them; where there are two, the second is shown in brackets. 1 kip is 1000 lbf."""


def converted(value: float, unit: str) -> tuple[tuple[float, str], ...]:
    """A value in the SI unit `unit`, in each unit that stands for it in `US`, and the unit's name."""
    quantity = registry().Quantity(value, unit)
    return tuple((float(quantity.to(name).magnitude), name) for name in US[unit])


def shown(value: float, unit: str, system: str = "si", width: int = 0, digits: int = 7) -> str:
    """The value, given in the SI unit `unit`, as "digits unit"; the digits right-aligned in `width` columns."""
    if system == "us" and unit in US:
        (first, name), *others = converted(value, unit)
        behind = "".join(f" ({other:.{digits}g} {also})" for other, also in others)
        return f"{first:>{width}.{digits}g} {name}{behind}"
    thousands, name = SI.get(unit, (1.0, unit))
    return f"{value / thousands:>{width}.{digits}g} {name}"
