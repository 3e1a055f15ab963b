"""Typography of sentences on pages, in pictures and on the terminal."""

from __future__ import annotations

import functools
import re
from decimal import Decimal
from typing import TYPE_CHECKING

from postprocess.units import SI, SUBSCRIPT, SUPERSCRIPTS

if TYPE_CHECKING:
    from markupsafe import Markup

NO_BREAK = "\N{NO-BREAK SPACE}"

GLUED = re.compile(
    r"(?<=\d) (?=[a-z%]|[GM]?(?:N|J|Pa)\b)|(?<=N) (?=[sm]\b)|(?<=\d x) (?=\d)"
    r"|(?<==) | (?==)|(?<=row) | (?=[^\[\]]{0,9}\])"
)


CODE = re.compile(r"`([^`]+)`")

EXPONENT = re.compile(r"(?<![\w.])([+-]?\d+(?:\.\d+)?)e([+-]?\d+)\b")

MINUS = re.compile(r"(?<![\w.\-/])-(?=\d)")

SQUARE = re.compile(r"(?<=[A-Za-z)])\^-?[23]\b")

NAMED = re.compile(
    r"(?<![\w;&.\-])[A-Z\d]{1,6}(?:\.\d)?(?:-[A-Z\d]{1,6})*-\d[A-Z\d]*\b|(?<![\w&.\-])[a-z]+\d-[a-z]+\b"
)

PLAIN = range(-1, 3)
"""Powers of ten that are multiplied out."""

LETTERS = {"omega": "ω", "theta": "θ", "mu": "μ", "us": "μs"}

LETTER = re.compile(r"(?<![\w.\-])(?:omega|theta|mu)(?![\w\-]|\.\w)|(?<=\d\N{NO-BREAK SPACE})us\b")


@functools.lru_cache(4096, typed=True)  # by type, as only a plain text is escaped
def prose(text: str) -> Markup:
    """Return a text as HTML.

    `Keys` are set as code. Elsewhere a letter with a subscript, like v_GY, is set as one, numbers and Greek letters
    as in print, and names with numbers, like TL-4, are not broken.
    """
    from markupsafe import Markup, escape

    parts = CODE.split(glued(str(escape(SI.rendered(text)))))
    parts[1::2] = [f"<code>{part}</code>" for part in parts[1::2]]
    parts[::2] = [SUBSCRIPT.sub(r"<i>\1</i><sub>\2</sub>", printed_numbers(part)) for part in parts[::2]]
    parts[::2] = [NAMED.sub(r'<span class="whole">\g<0></span>', part) for part in parts[::2]]
    return Markup("".join(parts))


def printed_numbers(text: str) -> str:
    """Return a text with numbers and letters as in print.

    Powers of ten, a true minus sign, superscripts, and ω, θ and μ for their names.
    """
    text = EXPONENT.sub(lambda match: _power(match[1], int(match[2])), text)
    text = SQUARE.sub(lambda match: match[0][1:].translate(SUPERSCRIPTS), MINUS.sub("−", text))
    return LETTER.sub(lambda match: LETTERS[match[0]], text)


def _power(factor: str, power: int) -> str:
    if not float(factor):
        return "0"
    if power in PLAIN:
        return f"{Decimal(f'{factor}e{power}'):{'+' if factor[0] == '+' else ''}f}"
    times = factor[:-1] if factor.lstrip("+-") == "1" else f"{factor}×"
    return f"{times}10{str(power).translate(SUPERSCRIPTS)}"


def glued(text: str) -> str:
    """Return a text in which numbers and units are not separated.

    There are also no line breaks at equals signs, nor in a unit in brackets.
    """
    return GLUED.sub(NO_BREAK, text)
