"""Numbers and units for people: SI as engineers write it, or US customary ones; files stay in SI."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

OPEN, SEPARATOR, CLOSE = "\x02", "\x1f", "\x03"
MEASURE = re.compile(f"{OPEN}([^{SEPARATOR}]*){SEPARATOR}([^{SEPARATOR}]*){SEPARATOR}([^{CLOSE}]*){CLOSE}")
"""A value, its unit and its format within a text."""

FOOT, INCH, POUND, KIP, MPH = 0.3048, 0.0254, 0.45359237, 4448.2216152605, 0.44704
"""[m], [m], [kg], [N], [m/s]; 1 kip is 1000 lbf, pounds under standard gravity, and 1 mph is 5280 ft/h."""

POWER = re.compile(r"^(10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+) (.*)$")


def measure(value: float, unit: str, form: str = ".4g", named: bool = True) -> str:
    """Text of a value, to stand in a sentence, which `Units.rendered` shows in the units of its reader.

    Parameters
    ----------
    value : float
        In `unit`.
    unit : str
        Unit in which SI shows it, like "kN"; of "N", "N s", "J" and "rad" SI shows "kN", "kN s", "kJ" and "deg".
    form : str
        Format specification in SI; other units have as many digits, but three at least.
    named : bool
        Whether the unit stands behind the number; False for all but the last of a list.
    """
    return f"{OPEN}{float(value)!r}{SEPARATOR}{unit if named else '!' + unit}{SEPARATOR}{form}{CLOSE}"


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

    def rendered(self, text: str, gap: str = " ") -> str:
        """Return a text with its measures in these units; gap: between number and unit."""
        return MEASURE.sub(lambda found: self._measure(found, gap), text) if OPEN in text else text

    def _measure(self, found: re.Match[str], gap: str) -> str:
        value, unit, form = float(found[1]), found[2].removeprefix("!"), found[3]
        factor, name = SI.of(unit)
        text = format(factor * value, form)
        factor_here, name_here = self.of(unit)
        if name_here != name:
            digits = len(re.sub(r"\D", "", text.split("e")[0]).lstrip("0"))
            text = f"{factor_here * value:.{max(3, digits)}g}"
            text = f"{float(text):.0f}" if "e+" in text else text
        return text if found[2].startswith("!") else f"{text}{gap}{name_here}"


SI = Units(
    "si", {"N": (1e-3, "kN"), "N s": (1e-3, "kN s"), "J": (1e-3, "kJ"), "rad": (180.0 / math.pi, "deg")}
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
            "J/m^3": (FOOT**2 / KIP, "kip ft/ft^3"),
        },
        **{
            "kN/m": (1e3 * FOOT / KIP, "kip/ft"),
            "MN/m": (1e6 * FOOT / KIP, "kip/ft"),
            "t": (1e3 / POUND, "lb"),
        },
        **{"GPa": (1e9 * (FOOT / 12.0) ** 2 / KIP, "ksi"), "MPa": (1e6 * (FOOT / 12.0) ** 2 / KIP, "ksi")},
        "kg m^2": (1.0 / (POUND * FOOT**2), "lb ft^2"),
        "rad": (180.0 / math.pi, "deg"),
    },
)
SYSTEMS = {units.name: units for units in (SI, US)}


def shown(value: Any, form: str) -> str:
    """A value by its format specification; words, None, truth and what is not finite in words."""
    if isinstance(value, bool | str) or value is None or not math.isfinite(value):
        return number(value)
    return format(value + 0, form).rstrip(".")  # the sum has no negative zero


def known(form: str, negligible: float = 0.0) -> Callable[[float], str]:
    """A form of numbers that shows a dash for one that is not finite, 0 for one below what is negligible."""

    def text(value: float) -> str:
        if not math.isfinite(value):
            return "–"
        return "0" if abs(value) < negligible else format(value, form)

    return text


def number(value: object, digits: int = 7) -> str:
    """A number with so many significant digits at most; words as they are, a dash for None."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, float):
        return str(value)
    if math.isfinite(value):
        return f"{value + 0.0:.{digits}g}"
    return "not a number" if math.isnan(value) else ("infinite" if value > 0 else "-infinite")


def percent(fraction: float | None, decimals: int = 2) -> str:
    """A relative difference with its sign, or with none where it rounds to zero."""
    if fraction is None or not math.isfinite(fraction):
        return number(fraction)
    text = f"{100.0 * fraction:+.{decimals}f}"
    return f"{text if float(text) else text[1:]} %"


def rounded_up(value: float) -> float:
    """The least number of two digits that is not below a positive value, but for rounding errors."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit * (1.0 - 1e-9)) * unit


def percent_up(fraction: float) -> str:
    """Bound of a relative error in per cent, rounded up to two digits; "unknown" where it is not finite."""
    if not math.isfinite(fraction):
        return "unknown"
    text = f"{100.0 * rounded_up(abs(fraction)):.2g}" if fraction else "0"
    return f"{text if abs(fraction) < 1e-7 else f'{Decimal(text):f}'} %"


def force(newtons: float) -> str:
    """Measure of a force with three digits at least."""
    return measure(newtons, "N", ".0f" if abs(newtons) >= 1e5 else ".3g")


def grouped(count: int) -> str:
    """A whole number with its thousands set apart."""
    return f"{count:,}".replace(",", " ")


def duration(seconds: float) -> str:
    """A time in the unit that suits it; a dash for 0, which was not measured."""
    if not seconds:
        return "–"
    if seconds < 1e-3:
        return f"{1e6 * seconds:.0f} us"
    return f"{1e3 * seconds:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"
