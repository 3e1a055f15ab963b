"""Units for people: SI as engineers write it, or US customary ones; files stay in SI."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

FOOT, POUND, KIP = 0.3048, 0.45359237, 4448.2216152605
"""[m], [kg], [N]; 1 kip is 1000 lbf."""

POWER = re.compile(r"^(10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+) (.*)$")


@dataclass(frozen=True)
class Units:
    """A name, and by unit how many of another one it is, and what that is called."""

    name: str
    others: Mapping[str, tuple[float, str]]

    def of(self, unit: str) -> tuple[float, str]:
        """Factor and unit to show a value in; a unit with a power of ten loses it where it is another one."""
        if unit in self.others:
            return self.others[unit]
        power = POWER.match(unit)
        if power and power[2] in self.others:
            factor, name = self.others[power[2]]
            return factor, f"{power[1]} {name}"
        return 1.0, unit


SI = Units(
    "si",
    {
        "N": (1e-3, "kN"),
        "N s": (1e-3, "kN s"),
        "J": (1e-3, "kJ"),
        "rad": (180.0 / math.pi, "deg"),
    },
)
US = Units(
    "us",
    {
        **{"m": (1.0 / FOOT, "ft"), "mm": (1e-3 / FOOT * 12.0, "in."), "m/s": (1.0 / FOOT, "ft/s")},
        **{"N": (1.0 / KIP, "kip"), "kN": (1e3 / KIP, "kip")},
        **{"N s": (1.0 / KIP, "kip s"), "kN s": (1e3 / KIP, "kip s")},
        **{"J": (1.0 / (KIP * FOOT), "kip ft"), "kJ": (1e3 / (KIP * FOOT), "kip ft")},
        **{"kg": (1.0 / POUND, "lb"), "kg/m^3": (FOOT**3 / POUND, "lb/ft^3")},
        **{
            "Pa": ((FOOT / 12.0) ** 2 / KIP, "ksi"),
            "N/m": (FOOT / KIP, "kip/ft"),
            "N/m^2": (FOOT**2 / KIP, "kip/ft^2"),
        },
        "kg m^2": (1.0 / (POUND * FOOT**2), "lb ft^2"),
        "rad": (180.0 / math.pi, "deg"),
    },
)
SYSTEMS = {units.name: units for units in (SI, US)}
