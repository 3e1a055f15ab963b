"""Pages: one file that holds all it shows and fetches nothing. Its script shows values of charts; by the page's own
policy no other script runs, and without scripts everything is there."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postprocess.report.table import Table
from postprocess.svg import drawing
from postprocess.units import SI

if TYPE_CHECKING:
    from postprocess.svg.chart import Chart

NO_BREAK = "\N{NO-BREAK SPACE}"
GLUED = re.compile(r"(?<=\d) (?=[a-z%])|(?<==) | (?==)|(?<=row) | (?=[^\[\]]{0,9}\])")
SYMBOL = re.compile(r"\b([^\W\d_])_([A-Za-z0-9]+)")
CODE = re.compile(r"`([^`]+)`")
EXPONENT = re.compile(r"(?<![\w.])([+-]?\d+(?:\.\d+)?)e([+-]?\d+)\b")
MINUS = re.compile(r"(?<![\w.\-/])-(?=\d)")
SQUARE = re.compile(r"(?<=[A-Za-z])\^-?[23]\b")
NAMED = re.compile(
    r"(?<![\w;&.\-])[A-Z\d]{1,6}(?:-[A-Z\d]{1,6})*-\d[A-Z\d]*\b|(?<![\w&.\-])[a-z]+\d-[a-z]+\b"
)
PLAIN = range(-1, 3)
"""Powers of ten that are multiplied out."""

LETTERS = {"omega": "ω", "theta": "θ", "mu": "μ", "us": "μs"}
LETTER = re.compile(r"(?<![\w.\-])(?:omega|theta|mu)(?![\w\-]|\.\w)|(?<=\d\N{NO-BREAK SPACE})us\b")


@dataclass(frozen=True)
class Picture:
    """A PNG file on disk, put into the page whole, and its caption."""

    path: Path
    caption: str


@dataclass(frozen=True)
class Section:
    """A part of a page: figures, tables, sentences; what is empty is not shown.

    layout: "half" sections stand side by side; figures stand "narrow", three or four in a row, "wide", two, or "tall",
    one below the other. is_folded: shown when asked for.
    """

    title: str
    lead: str = ""
    figures: Sequence[Chart | Picture] = ()
    tables: Sequence[Table] = ()
    sentences: Sequence[str] = ()
    layout: str = ""
    is_folded: bool = False

    @property
    def is_empty(self) -> bool:
        """True if there is nothing to show."""
        tables = any(table.rows for table in self.tables)
        return not (self.lead or self.figures or tables or self.sentences)


@dataclass(frozen=True)
class Page:
    """All that a page says. passed: None where nothing is judged; contents: whether it lists its sections on top."""

    kicker: str
    title: str
    headline: str
    sections: Sequence[Section]
    footer: str
    scene_text: str = ""
    passed: bool | None = None
    contents: bool = False

    @property
    def charts(self) -> list[Chart]:
        """All charts."""
        from postprocess.svg.chart import Chart

        figures = (figure for section in self.sections for figure in section.figures)
        return [figure for figure in figures if isinstance(figure, Chart)]


def write_page(path: Path, page: Page) -> Path:
    """Write the page and return its path; every picture must be there."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("postprocess"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"prose": prose, "data_uri": data_uri}
    script = (Path(__file__).parents[1] / "templates" / "page.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    text = environment.get_template("page.html.j2").render(page=page, script=script, digest=digest)
    path.write_text(text, encoding="utf-8")
    return path


def prose(text: str) -> Any:
    """The text as HTML: `keys` as code; elsewhere a letter with a subscript, like v_GY, is set as one, numbers and
    Greek letters as in print, and names with numbers, like TL-4, are never broken."""
    from markupsafe import Markup, escape

    parts = CODE.split(glued(str(escape(SI.rendered(text)))))
    parts[1::2] = [f"<code>{part}</code>" for part in parts[1::2]]
    parts[::2] = [SYMBOL.sub(r"<i>\1</i><sub>\2</sub>", printed_numbers(part)) for part in parts[::2]]
    parts[::2] = [NAMED.sub(r'<span class="whole">\g<0></span>', part) for part in parts[::2]]
    return Markup("".join(parts))


def printed_numbers(text: str) -> str:
    """The text with powers of ten as such, a true minus, superscripts, and the letters ω, θ and μ by their names."""
    text = EXPONENT.sub(lambda found: _power(found[1], int(found[2])), text)
    text = SQUARE.sub(lambda found: found[0][1:].translate(drawing.SUPERSCRIPTS), MINUS.sub("−", text))
    return LETTER.sub(lambda found: LETTERS[found[0]], text)


def _power(factor: str, power: int) -> str:
    if not float(factor):
        return "0"
    if power in PLAIN:
        return f"{Decimal(f'{factor}e{power}'):{'+' if factor[0] == '+' else ''}f}"
    times = factor[:-1] if factor.lstrip("+-") == "1" else f"{factor}×"
    return f"{times}10{str(power).translate(drawing.SUPERSCRIPTS)}"


def glued(text: str) -> str:
    """The text with no line break between a number and its unit, at an equals sign, nor in a unit in brackets."""
    return GLUED.sub(NO_BREAK, text)


def data_uri(path: Path) -> str:
    """The PNG file as a data URI."""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
