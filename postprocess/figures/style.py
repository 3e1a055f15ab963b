"""What figures share: the style of all of them, and SVG text that goes into a page as it is.

Text stays text in the SVG, so it can be searched and copied and takes the font of the page around it.
"""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RIGID, FE, DIFFERENCE = "#dd8a1d", "#14467c", "#8a1c3b"
STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "font.family": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-6, 9),
    "axes.unicode_minus": True,
    "axes.grid": True,
    "grid.color": "#e3e6ea",
    "grid.linewidth": 0.6,
    "axes.edgecolor": "#8a929b",
    "axes.axisbelow": True,
    "axes.xmargin": 0.0,
}
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Curve:
    """One plot: short name, heading of the group it belongs to, caption, SVG text, and width in pixels."""

    name: str
    group: str
    caption: str
    svg: str
    width: float = 0.0


@contextmanager
def style() -> Iterator[None]:
    """The style of all figures, whatever the user's own settings are."""
    from matplotlib import rc_context, rcdefaults, rcParams

    with rc_context():
        rcdefaults()
        rcParams.update(STYLE)
        yield


def drawn(figure: "Figure", name: str, caption: str, group: str = "") -> Curve:
    """The figure as SVG. Its ids follow from the name: several fit on a page, and equal numbers give equal text."""
    return Curve(name, group, caption, svg_text(figure, name, caption))


def svg_text(figure: "Figure", name: str, caption: str) -> str:
    """SVG element without prologue."""
    from matplotlib import rcParams
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    buffer = io.StringIO()
    rcParams["svg.hashsalt"] = name
    FigureCanvasSVG(figure).print_svg(buffer, metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    text = buffer.getvalue()
    text = text[text.index("<svg") :].rstrip()
    for mark in (' id="', 'href="#', "url(#"):
        text = text.replace(mark, mark + name + "-")
    return text.replace("<svg ", f'<svg role="img" aria-label="{caption}" ', 1)
