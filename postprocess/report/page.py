"""Pages that contain everything they show.

A page is one file and fetches nothing. Its script shows values of charts; the page's own policy permits no other
script, and without scripts its content is complete.
"""

from __future__ import annotations

import base64
import functools
import hashlib
import io
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from postprocess.report.prose import prose
from postprocess.report.tables import Column, Table
from postprocess.units import SI, US, Units

if TYPE_CHECKING:
    from jinja2 import Template
    from markupsafe import Markup

    from postprocess.svg.chart import Chart

SEPARATOR = "\x1e"
"""Mark of the page's template: end of a part that units change."""

LONG = 24
"""Letters of words in a cell that may be broken."""


@dataclass(frozen=True)
class Picture:
    """PNG or GIF file embedded in the page, with caption.

    dark: its form for dark screens.
    """

    path: Path
    caption: str
    dark: Path | None = None

    def in_units(self, units: Units) -> Picture:
        """Return the picture, which has its units already."""
        return self


@dataclass(frozen=True)
class Section:
    """Part of a page with figures, tables, sentences.

    Empty parts are not shown. layout: "half" sections stand side by side; figures stand "narrow", three or four in a
    row, "wide", two, or "tall", one below the other. is_folded: shown on request; is_of_band: linked by its lead behind
    the origin of the result's interval.
    """

    title: str
    lead: str = ""
    figures: Sequence[Chart | Picture] = ()
    tables: Sequence[Table] = ()
    sentences: Sequence[str] = ()
    layout: str = ""
    is_folded: bool = False
    is_of_band: bool = False

    @property
    def is_empty(self) -> bool:
        """True if the section has no content."""
        tables = any(table.rows for table in self.tables)
        return not (self.lead or self.figures or tables or self.sentences)

    @property
    def is_moving(self) -> bool:
        """True if a figure is animated."""
        return any(getattr(figure, "is_moving", False) for figure in self.figures)

    def in_units(self, units: Units) -> Section:
        """Return the section in other units."""
        return replace(
            self,
            title=units.rendered(self.title),
            lead=units.rendered(self.lead),
            figures=[figure.in_units(units) for figure in self.figures],
            tables=[table.in_units(units) for table in self.tables],
            sentences=[units.rendered(sentence) for sentence in self.sentences],
        )


@dataclass(frozen=True)
class Headline:
    """First lines of a page and of its text on a terminal.

    They are keys of a summary. title: subject of the page; answer: the result; set_up: subject of the computation;
    certainty: reliability of the numbers; band: origin of the interval of the result, after the answer.
    """

    title: str
    answer: str
    set_up: str = ""
    certainty: str = ""
    band: str = ""

    @property
    def lines(self) -> tuple[str, ...]:
        """All lines but the title, without empty ones."""
        return tuple(line for line in (self.answer, self.band, self.set_up, self.certainty) if line)

    def in_units(self, units: Units) -> Headline:
        """Return the headline in these units."""
        return Headline(*map(units.rendered, vars(self).values()))


@dataclass(frozen=True)
class Page:
    """Content of a page.

    passed: outcome of its checks, None without any; checked: their number in words; contents: whether its sections
    are listed on top; original: the page before its conversion to `units`.
    """

    kicker: str
    headline: Headline
    sections: Sequence[Section]
    footer: str
    scene_text: str = ""
    passed: bool | None = None
    contents: bool = False
    checked: str = "checks"
    units: Units = SI
    original: Page | None = None

    @property
    def verdict(self) -> str:
        """Outcome of the checks, not of the computation."""
        return f"{self.checked} {'passed' if self.passed else 'failed'}"

    @property
    def charts(self) -> list[Chart]:
        """All charts."""
        from postprocess.svg.chart import Chart

        figures = (figure for section in self.sections for figure in section.figures)
        return [figure for figure in figures if isinstance(figure, Chart)]

    def in_units(self, units: Units) -> Page:
        """Return the page in other units.

        Its files remain in SI.
        """
        name = "SI units" if units is SI else f"{units.name.upper()} units, files in SI"
        return replace(
            self,
            headline=self.headline.in_units(units),
            sections=[section.in_units(units) for section in self.sections],
            footer=self.footer.replace("SI units", name),
            units=units,
            original=self.original or self,
        )


def write_page(path: Path, page: Page) -> Path:
    """Write a page and return its path.

    All its pictures must exist.
    """
    path.write_text(page_text(page), encoding="utf-8")
    return path


def page_text(page: Page) -> str:
    """Return the HTML of a page with both systems of units.

    All its pictures must exist.
    """
    script = template_text("page.js")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    original, render = page.original or page, template("page.html.j2").render
    common: dict[str, Any] = {"shown": page.units.name, "script": script, "digest": digest}
    common["data_uri"] = functools.cache(data_uri)  # for both units
    texts = [render(common, page=original.in_units(units)) for units in (SI, US)]
    return in_both_units(texts if page.units is SI else texts[::-1], page.units)


def template_text(name: str) -> str:
    """Return the text of a file beside the templates."""
    return (Path(__file__).parents[1] / "templates" / name).read_text(encoding="utf-8")


@functools.cache
def template(name: str) -> Template:
    """Return a template of pages.

    Its compiled code is stored beside that of this module, and under the same conditions.
    """
    from jinja2 import Environment, FileSystemBytecodeCache, PackageLoader, StrictUndefined
    from jinja2.bccache import Bucket

    class Bytecode(FileSystemBytecodeCache):
        def load_bytecode(self, bucket: Bucket) -> None:
            with suppress(OSError):
                super().load_bytecode(bucket)

        def dump_bytecode(self, bucket: Bucket) -> None:
            with suppress(OSError):
                super().dump_bytecode(bucket)

    folder = Path(__spec__.cached or "").parent
    environment = Environment(
        loader=PackageLoader("postprocess"),
        bytecode_cache=None if sys.dont_write_bytecode else Bytecode(str(folder), "%s.template"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"words": prose, "prose": compared, "cell": cell}
    return environment.get_template(name)


def compared(text: str) -> Markup:
    """Return a text as HTML that `in_both_units` compares."""
    from markupsafe import Markup

    return Markup(f"{SEPARATOR}{prose(text)}{SEPARATOR}")


def cell(column: Column, record: object, is_head: bool) -> Markup:
    """Return the entry of a record as a cell.

    is_head: whether it is the first of its row.
    """
    from markupsafe import Markup, escape

    text = column.text(record)
    if column.style == "badge" and not is_head:
        kind = "pass" if column.value(record) else "fail"
        return Markup(f'<td><span class="badge {kind}">{escape(text)}</span></td>')
    tag, scope, kind = "td", "", "n" if column.form else "text"
    if is_head:
        tag, scope, kind = "th", ' scope="row"', "whole" if column.form and not column.style else ""
    size = "long" if not column.form and len(text) > LONG else ""
    names = " ".join(filter(None, (kind, column.style, size)))
    style = f' class="{names}"' if names else ""
    below = f"<small>{compared(column.below.text(record))}</small>" if column.below else ""
    return Markup(f"<{tag}{scope}{style}>{compared(text)}{below}</{tag}>")


def in_both_units(texts: Sequence[str], units: Units) -> str:
    """Return one page of two that differ in units.

    It shows the units of the first at the beginning. Texts that differ stand one after the other with the class of
    their system, of which the page's switch shows one.
    """
    names = [units.name, US.name if units is SI else SI.name]
    parts = []
    for number, pair in enumerate(zip(*(text.split(SEPARATOR) for text in texts), strict=True)):
        first, second = pair
        if first == second or number % 2 == 0:
            parts.append(first)
        else:
            spans = [f'<span class="{name}">{text}</span>' for name, text in zip(names, pair, strict=True)]
            parts += sorted(spans)
    return "".join(parts)


def data_uri(path: Path) -> str:
    """Return a picture file as a data URI.

    A PNG becomes a smaller WebP.
    """
    content, kind = path.read_bytes(), path.suffix.removeprefix(".")
    if kind == "png":
        from PIL import Image

        file, kind = io.BytesIO(), "webp"
        Image.open(path).convert("RGB").save(file, kind, lossless=True, quality=0, method=1)
        content = file.getvalue()
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"
