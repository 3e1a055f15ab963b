"""How numbers are printed for people: digits enough to tell two solutions apart, words for what is none."""

import math


def number(value: object, digits: int = 7) -> str:
    """A number with so many significant digits at most; words and None as they are."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, float):
        return str(value)
    return f"{value:.{digits}g}" if math.isfinite(value) else _words(value)


def padded(value: float, digits: int = 8) -> str:
    """A number with exactly so many significant digits, so that two in a row compare digit by digit."""
    return f"{value:#.{digits}g}".rstrip(".") if math.isfinite(value) else _words(value)


def signed(value: float) -> str:
    """A relative difference: sign, three digits, exponent."""
    return f"{value:+.2e}" if math.isfinite(value) else _words(value)


def subscripted(symbol: str) -> tuple[str, str]:
    """A symbol and its subscript: "v_GX" is v with GX."""
    letter, _, subscript = symbol.partition("_")
    return letter, subscript


def _words(value: float) -> str:
    return "not a number" if math.isnan(value) else ("infinite" if value > 0 else "-infinite")
