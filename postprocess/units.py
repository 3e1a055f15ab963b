"""Systems of units, and numbers as text.

SI as engineers write it, or US customary units; files remain in SI.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal

OPEN, SEPARATOR, CLOSE = "\x02", "\x1f", "\x03"
MEASURE = re.compile(f"{OPEN}([^{SEPARATOR}]*){SEPARATOR}([^{SEPARATOR}]*){SEPARATOR}([^{CLOSE}]*){CLOSE}")
"""A value, its unit and its format within a text."""

FOOT, INCH, POUND, KIP, MPH = 0.3048, 0.0254, 0.45359237, 4448.2216152605, 0.44704
"""[m], [m], [kg], [N], [m/s]; 1 kip is 1000 lbf, pounds under standard gravity, and 1 mph is 5280 ft/h."""

SUBSCRIPT = re.compile(r"\b([^\W\d_])_([A-Za-z0-9]+)")
"""A letter and its subscript, like v_GY."""

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

POWER = re.compile(r"^(10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+) (.*)$")


def measure(value: float, unit: str, form: str = ".4g", named: bool = True) -> str:
    """Return a value as text that `Units.rendered` converts to the reader's units.

    Parameters
    ----------
    value : float
        In `unit`.
    unit : str
        Unit of the value, like "kN". SI shows "N", "N s", "N m", "J" and "rad" with "k", and as "deg".
    form : str
        Format specification in SI; other units have equally many digits, at least three.
    named : bool
        Whether the unit follows the number; in lists True for the last alone.
    """
    return f"{OPEN}{float(value)!r}{SEPARATOR}{unit if named else '!' + unit}{SEPARATOR}{form}{CLOSE}"


@dataclass(frozen=True)
class Units:
    """System of units.

    conversions: by unit, its size in another unit, and the name of that.
    """

    name: str
    conversions: Mapping[str, tuple[float, str]]

    def of(self, unit: str) -> tuple[float, str]:
        """Return the factor and unit of displayed values.

        A power of ten before the unit is kept, and replaces "k".
        """
        if unit in self.conversions:
            return self.conversions[unit]
        power = POWER.match(unit)
        if power and power[2] in self.conversions:
            factor, name = self.conversions[power[2]]
            return (1.0, unit) if name == f"k{power[2]}" else (factor, f"{power[1]} {name}")
        return 1.0, unit

    def rendered(self, text: str, gap: str = " ") -> str:
        """Return a text with measures in these units.

        gap: between number and unit.
        """
        return MEASURE.sub(lambda match: self._measure(match, gap), text) if OPEN in text else text

    def _measure(self, match: re.Match[str], gap: str) -> str:
        value, unit, form = float(match[1]), match[2].removeprefix("!"), match[3]
        factor, name = SI.of(unit)
        text = format(factor * value, form)
        factor_here, name_here = self.of(unit)
        if name_here != name:
            digits = len(re.sub(r"\D", "", text.split("e")[0]).lstrip("0"))
            text = f"{factor_here * value:.{max(3, digits)}g}"
            text = f"{float(text):.0f}" if "e+" in text else text
        return text if match[2].startswith("!") else f"{text}{gap}{name_here}"


SI = Units(
    "si",
    {
        **{unit: (1e-3, f"k{unit}") for unit in ("N", "N s", "N m", "N m/m", "J")},
        "rad": (180.0 / math.pi, "deg"),
    },
)
US = Units(
    "us",
    {
        "m": (1.0 / FOOT, "ft"), "mm": (1e-3 / INCH, "in."), "m/s": (1.0 / FOOT, "ft/s"),
        "N": (1.0 / KIP, "kip"), "kN": (1e3 / KIP, "kip"),
        "N s": (1.0 / KIP, "kip s"), "kN s": (1e3 / KIP, "kip s"),
        "N m": (1.0 / (KIP * FOOT), "kip ft"), "kN m": (1e3 / (KIP * FOOT), "kip ft"),
        "N m/m": (1.0 / KIP, "kip ft/ft"), "J": (1.0 / (KIP * FOOT), "kip ft"), "kJ": (1e3 / (KIP * FOOT), "kip ft"),
        "kg": (1.0 / POUND, "lb"), "t": (1e3 / POUND, "lb"), "kg/m^3": (FOOT**3 / POUND, "lb/ft^3"),
        "Pa": (INCH**2 / KIP, "ksi"), "MPa": (1e6 * INCH**2 / KIP, "ksi"), "GPa": (1e9 * INCH**2 / KIP, "ksi"),
        "N/m": (FOOT / KIP, "kip/ft"), "kN/m": (1e3 * FOOT / KIP, "kip/ft"), "MN/m": (1e6 * FOOT / KIP, "kip/ft"),
        "N/m^2": (FOOT**2 / KIP, "kip/ft^2"), "J/m^3": (FOOT**2 / KIP, "kip ft/ft^3"),
        "kg m^2": (1.0 / (POUND * FOOT**2), "lb ft^2"), "rad": (180.0 / math.pi, "deg"),
    },
)  # fmt: skip
SYSTEMS = {units.name: units for units in (SI, US)}
"""Systems of units by name."""


def shown(value: float | str | None, form: str) -> str:
    """Format a value, or describe it in words.

    Words, None, truth values and values that are not finite have no format.
    """
    if isinstance(value, bool | str) or value is None or not math.isfinite(value):
        return number(value)
    return format(value + 0, form).rstrip(".")  # the sum has no negative zero


def known(form: str, negligible: float = 0.0) -> Callable[[float], str]:
    """Return a format with dashes for unknown values.

    Values that are not finite are unknown. Values below `negligible` are shown as 0.
    """

    def text(value: float) -> str:
        if not math.isfinite(value):
            return "–"
        return "0" if abs(value) < negligible else format(value, form)

    return text


def number(value: object, digits: int = 7) -> str:
    """Format a number to `digits` significant digits.

    Words remain unchanged, and None is a dash.
    """
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
    """Format a relative difference with its sign.

    Where it rounds to zero it has none.
    """
    if fraction is None or not math.isfinite(fraction):
        return number(fraction)
    text = f"{100.0 * fraction:+.{decimals}f}"
    return f"{text if float(text) else text[1:]} %"


def rounded_up(value: float) -> float:
    """Round a positive value up to two digits.

    Rounding errors of the value are ignored.
    """
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit * (1.0 - 1e-9)) * unit


def percent_up(fraction: float) -> str:
    """Format the bound of a relative error in per cent, rounded up.

    Two digits; "unknown" where it is not finite.
    """
    if not math.isfinite(fraction):
        return "unknown"
    text = f"{100.0 * rounded_up(abs(fraction)):.2g}" if fraction else "0"
    return f"{text if abs(fraction) < 1e-7 else f'{Decimal(text):f}'} %"


def force(newtons: float) -> str:
    """Return the measure of a force with at least three digits."""
    return measure(newtons, "N", ".0f" if abs(newtons) >= 1e5 else ".3g")


def grouped(count: int) -> str:
    """Format an integer with separated thousands."""
    return f"{count:,}".replace(",", " ")


def milliseconds(seconds: float) -> str:
    """Return a time [s] in milliseconds."""
    return f"{1e3 * seconds:.1f}"


def duration(seconds: float) -> str:
    """Format a time in a suitable unit.

    A time of 0 was not measured and is a dash.
    """
    if not seconds:
        return "–"
    if seconds < 1e-3:
        return f"{1e6 * seconds:.0f} us"
    return f"{1e3 * seconds:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"
