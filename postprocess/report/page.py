"""Pages: one file that holds all it shows and fetches nothing. Its script shows values of charts; by the page's own
policy no other script runs, and without scripts everything is there.

A table is declared once: its columns say how a record is shown, its rows are the records. Terminal, page, CSV and JSON
all take it from here.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, is_dataclass, replace
from decimal import Decimal
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.svg import scales
from postprocess.units import SI, Units, number, shown

if TYPE_CHECKING:
    from postprocess.svg.chart import Chart


Form = str | Callable[[Any], str]

MANY, LONG = 9, 105
"""Columns, and letters of their headings with what is between them, that stand side by side."""


@dataclass(frozen=True)
class Column:
    """Column of a table: form of one entry of each record.

    Parameters
    ----------
    key : str
        Name of the entry, with dots for entries of entries; also its name in files.
    label, unit : str
        Heading, and the unit that stands behind it.
    form : str or callable
        Format specification of a number, or a function that gives the text; "" for words, which stand to the left.
    style : str
        "strong", "soft" or, for words in one line, "whole" on pages.
    group : str
        Heading over several neighbours.
    below : Column, optional
        Shown in small letters below the entry on pages; a terminal leaves it out.
    unit_key : str
        Key of the entry that names the unit, where it differs from record to record.
    is_unit : bool
        Whether the entries are such names.
    units : Units
        What people see of a unit.
    """

    key: str
    label: str
    unit: str = ""
    form: Form = ""
    style: str = ""
    group: str = ""
    below: Column | None = None
    unit_key: str = ""
    is_unit: bool = False
    units: Units = SI

    @property
    def heading(self) -> str:
        """Label with its unit."""
        return f"{self.label} [{self.shown_unit}]" if self.unit else self.label

    @property
    def shown_unit(self) -> str:
        """The unit of all entries as people see it."""
        return self.units.of(self.unit)[1]

    def value(self, record: Any) -> Any:
        """The entry of a mapping, whose keys may have dots, an object or a tuple; None where one on the way is None."""
        return _looked_up(record, self.key)

    def text(self, record: Any) -> str:
        """The entry as people read it."""
        text = self._text(record)
        return self.units.rendered(text)

    def _text(self, record: Any) -> str:
        value = self.value(record)
        if self.is_unit:
            return self.units.of(value)[1]
        factor, _ = self.units.of(_looked_up(record, self.unit_key) if self.unit_key else self.unit)
        if factor != 1.0 and isinstance(value, int | float):
            value = factor * value
        if callable(self.form):
            return self.form(value) if value is not None else number(value)
        return shown(value, self.form) if self.form else number(value)


def _looked_up(record: Any, key: str) -> Any:
    if isinstance(record, Mapping) and key in record:
        return record[key]
    for name in key.split("."):
        record = _entry(record, name)
    return record


def _entry(record: Any, name: str) -> Any:
    if record is None:
        return None
    if isinstance(record, Mapping):
        return record[name]
    return record[int(name)] if name.isdigit() else getattr(record, name)


@dataclass(frozen=True)
class Table:
    """Columns and records. marks: style of rows by their number, "failed" or "marked"; notes stand below it."""

    columns: tuple[Column, ...]
    rows: Sequence[Any]
    title: str = ""
    notes: tuple[str, ...] = ()
    marks: Mapping[int, str] = field(default_factory=dict)

    @property
    def groups(self) -> tuple[tuple[str, int], ...]:
        """The headings above the columns and how many columns each spans; none if no column has one."""
        spans: list[tuple[str, int]] = []
        for column in self.columns:
            if spans and spans[-1][0] == column.group:
                spans[-1] = (column.group, spans[-1][1] + 1)
            else:
                spans.append((column.group, 1))
        return tuple(spans) if any(name for name, _ in spans) else ()

    @property
    def is_wide(self) -> bool:
        """True if its headings need smaller letters to stand side by side on a page."""
        return len(self.columns) > MANY or sum(len(column.heading) + 2 for column in self.columns) > LONG

    def mark(self, row: int) -> str:
        """Style of a row."""
        return self.marks.get(row, "")

    def in_units(self, units: Units) -> Table:
        """Return the table in other units."""
        below = [column.below and replace(column.below, units=units) for column in self.columns]
        both = zip(self.columns, below, strict=True)
        columns = tuple(replace(column, units=units, below=under) for column, under in both)
        notes = tuple(units.rendered(note) for note in self.notes)
        return replace(self, columns=columns, title=units.rendered(self.title), notes=notes)

    def records(self) -> list[dict[str, Any]]:
        """The entries as they are, by key: what JSON and other files hold."""
        return [{column.key: column.value(row) for column in self.columns} for row in self.rows]


def columns(labels: Mapping[str, str], **more: Any) -> tuple[Column, ...]:
    """Columns of one form: their labels by key."""
    return tuple(Column(key, label, **more) for key, label in labels.items())


def listed(rows: Sequence[Mapping[str, Any]], **more: Any) -> Table:
    """A table of flat mappings with the same keys, which are its headings: for files."""
    return Table(tuple(Column(key, key) for key in rows[0]), rows, **more)


def text_table(*columns: str, rows: Sequence[Sequence[str]], texts: int = 1, **more: Any) -> Table:
    """A table of finished text: its headings and cells; the first `texts` columns are words, the others numbers."""
    made = tuple(Column(str(i), name, form="" if i < texts else str) for i, name in enumerate(columns))
    return Table(made, [{str(i): cell for i, cell in enumerate(row)} for row in rows], **more)


def pairs(entries: Mapping[str, Any] | Sequence[tuple[Any, ...]], **more: Any) -> Table:
    """A table without headings: what, its value, and its unit where there is one."""
    lines = [(*line, "")[:3] for line in (entries.items() if isinstance(entries, Mapping) else entries)]
    value = Column("value", "", form=lambda value: number(value, 5), style="strong", unit_key="unit")
    columns = (Column("what", ""), value, Column("unit", "", is_unit=True))
    used = columns if any(unit for *_, unit in lines) else columns[:2]
    return Table(used, [dict(zip(("what", "value", "unit"), line, strict=True)) for line in lines], **more)


def write_history(path: Path, columns: Mapping[str, ArrayLike]) -> Path:
    """Writes the columns, name -> values of shape (n,), in the mapping's order; empty where they are not finite."""
    table = np.column_stack([_column(name, values) for name, values in columns.items()])
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(",".join(columns) + "\n")
        form = ",".join(["%.17g"] * len(columns)) + "\n"
        for row in table.tolist():
            line = form % tuple(row)
            file.write(re.sub("nan|-?inf", "", line) if "n" in line else line)
    return path


def read_history(content: bytes) -> dict[str, NDArray[np.float64]]:
    """The columns of a file that `write_history` wrote, in its order: name -> values of shape (n,)."""
    header, _, body = content.decode().partition("\n")
    names = header.split(",")
    if len({*names}) < len(names) or not all(map(_is_name, names)):
        raise ValueError("its first line has no column names")
    rows = [line.split(",") for line in body.splitlines()]
    table = np.array([[entry or "nan" for entry in row] for row in rows], dtype=np.float64)
    table = table.reshape(-1, len(names))
    return {name: np.ascontiguousarray(table[:, column]) for column, name in enumerate(names)}


def _column(name: str, values: ArrayLike) -> NDArray[np.float64]:
    column = np.asarray(values, dtype=np.float64)
    if column.ndim != 1:
        raise ValueError(f"history column {name!r} must have one dimension, it has {column.ndim}")
    if not _is_name(name):
        raise ValueError(f"history column name {name!r} does not fit a CSV header")
    return column


def _is_name(text: str) -> bool:
    return not re.search(r"[,\n]", text) and text == text.strip() != ""


def write_summary(path: Path, summary: Mapping[str, Any]) -> Path:
    """Writes the mapping, nested as wished, with its own key order, indented by two."""
    path.write_text(summary_text(summary) + "\n", encoding="utf-8")
    return path


def summary_text(summary: Mapping[str, Any]) -> str:
    """The mapping as strict JSON."""
    return json.dumps(plain(summary), indent=2, allow_nan=False, ensure_ascii=False)


def plain(value: Any) -> Any:
    """The value in the types that JSON has: records as mappings, NumPy scalars and arrays unwrapped, non-finite numbers
    None."""
    if is_dataclass(value):
        value = vars(value)
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, str):
        return SI.rendered(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


NO_BREAK = "\N{NO-BREAK SPACE}"
GLUED = re.compile(r"(?<=\d) (?=[a-z%])|(?<=\d x) (?=\d)|(?<==) | (?==)|(?<=row) | (?=[^\[\]]{0,9}\])")
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
class Headline:
    """First lines of a page and of the text on a terminal, and keys of a summary.

    title: subject of the page; answer: the result; set_up: what was computed; certainty: how well the result is known.
    """

    title: str
    answer: str
    set_up: str = ""
    certainty: str = ""

    @property
    def lines(self) -> tuple[str, ...]:
        """All but the title, without empty ones."""
        return tuple(line for line in (self.answer, self.set_up, self.certainty) if line)

    def in_units(self, units: Units) -> Headline:
        """Return it in these units."""
        return Headline(*map(units.rendered, vars(self).values()))


@dataclass(frozen=True)
class Page:
    """Content of a page. passed: whether its checks did, None where nothing is judged; checked: how many did, in words;
    contents: whether it lists its sections on top."""

    kicker: str
    headline: Headline
    sections: Sequence[Section]
    footer: str
    scene_text: str = ""
    passed: bool | None = None
    contents: bool = False
    checked: str = "checks"

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


def write_page(path: Path, page: Page) -> Path:
    """Write the page and return its path; every picture must be there."""
    path.write_text(page_text(page), encoding="utf-8")
    return path


def page_text(page: Page) -> str:
    """HTML of the page; every picture must be there."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("postprocess"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"prose": prose, "data_uri": data_uri, "quoted": partial(quote, safe=" ,:;[]()/")}
    script = (Path(__file__).parents[1] / "templates" / "page.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    return environment.get_template("page.html.j2").render(page=page, script=script, digest=digest)


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
    text = SQUARE.sub(lambda found: found[0][1:].translate(scales.SUPERSCRIPTS), MINUS.sub("−", text))
    return LETTER.sub(lambda found: LETTERS[found[0]], text)


def _power(factor: str, power: int) -> str:
    if not float(factor):
        return "0"
    if power in PLAIN:
        return f"{Decimal(f'{factor}e{power}'):{'+' if factor[0] == '+' else ''}f}"
    times = factor[:-1] if factor.lstrip("+-") == "1" else f"{factor}×"
    return f"{times}10{str(power).translate(scales.SUPERSCRIPTS)}"


def glued(text: str) -> str:
    """The text with no line break between a number and its unit, at an equals sign, nor in a unit in brackets."""
    return GLUED.sub(NO_BREAK, text)


def data_uri(path: Path) -> str:
    """The PNG file as a data URI."""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
