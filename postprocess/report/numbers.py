"""How values are printed for people: digits enough to tell two solutions apart, words for what is none."""

import math
from collections.abc import Callable
from typing import Any


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


def percent(share: float | None, decimals: int = 2) -> str:
    """A relative difference with its sign, or with none where it rounds to zero."""
    if share is None or not math.isfinite(share):
        return number(share)
    text = f"{100.0 * share:+.{decimals}f}"
    return f"{text if float(text) else text[1:]} %"


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
