"""What figures share: the style of all curves, and SVG text that goes into a page as it is."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from postprocess.figures.curves import STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@contextmanager
def style(name: str) -> Iterator[None]:
    """The style of all curves; ids in the SVG follow from the name, so the same numbers give the same text."""
    from matplotlib import rc_context, rcdefaults, rcParams

    with rc_context():
        rcdefaults()
        rcParams.update(STYLE)
        rcParams["svg.hashsalt"] = name
        yield


def svg_text(figure: "Figure", name: str, caption: str) -> str:
    """SVG element without prologue; its ids carry the name, so that several fit on one page."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    buffer = io.StringIO()
    FigureCanvasSVG(figure).print_svg(buffer, metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    text = buffer.getvalue()
    text = text[text.index("<svg") :].rstrip()
    for mark in (' id="', 'href="#', "url(#"):
        text = text.replace(mark, mark + name + "-")
    return text.replace("<svg ", f'<svg role="img" aria-label="{caption}" ', 1)
