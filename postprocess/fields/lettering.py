"""Texts in images, typeset as in tables."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from postprocess.report.prose import printed_numbers
from postprocess.svg.marks import SUBSCRIPT

if TYPE_CHECKING:
    from PIL import Image, ImageFont

INK = "#1b1f24"


@cache
def font(size: int, is_bold: bool) -> ImageFont.FreeTypeFont:
    """Return DejaVu of this size from matplotlib.

    It has Greek letters and arrows.
    """
    import matplotlib as mpl
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if is_bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)


class Lettering(NamedTuple):
    """Text at a pixel of its base line.

    pixel: from the lower left corner; justify: position of the pixel; ground: opacity of the white behind it.
    """

    text: str
    pixel: tuple[float, float]
    size: float
    justify: str
    is_bold: bool
    ground: float


def typeset(text: str) -> list[tuple[str, bool]]:
    """Return the pieces of a text, and which of them are indices.

    Minus signs and powers of ten are set as in print.
    """
    parts = SUBSCRIPT.split(printed_numbers(text))
    return [(part, number % 3 == 2) for number, part in enumerate(parts) if part]


def write_words(image: Image.Image, words: Lettering) -> None:
    """Write a text into an image of Pillow."""
    from PIL import ImageDraw

    pieces = []
    for piece, is_index in typeset(words.text):
        typeface = font(round((0.72 if is_index else 1.0) * words.size), words.is_bold)
        pieces.append((piece, typeface, 0.2 * words.size * is_index, typeface.getlength(piece)))
    wide = sum(length for *_, length in pieces)
    x = words.pixel[0] - {"left": 0.0, "center": 0.5, "right": 1.0}[words.justify] * wide
    y = image.height - words.pixel[1]
    canvas = ImageDraw.Draw(image, "RGBA")
    if words.ground:
        edge = 0.2 * words.size
        box = (x - edge, y - words.size, x + wide + edge, y + 0.3 * words.size)
        canvas.rectangle(box, fill=(255, 255, 255, round(255 * words.ground)))
    for piece, typeface, lowered, length in pieces:
        canvas.text((x, y + lowered), piece, INK, typeface, anchor="ls")
        x += length
