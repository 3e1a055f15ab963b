"""`report.html` of a study: headline, then sections of figures, tables and sentences; no script."""

from dataclasses import dataclass, fields
from pathlib import Path

from postprocess.figures.style import Curve
from postprocess.pages.pages import write_page

TEMPLATE = "study.html.j2"


@dataclass(frozen=True)
class StudyTable:
    """A table of words: its columns' names, the rows' cells; the first `texts` columns are words, the rest numbers.

    marked: rows that are set off; note: a sentence below.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    texts: int = 1
    marked: frozenset[int] = frozenset()
    title: str = ""
    note: str = ""


@dataclass(frozen=True)
class StudySection:
    """A section of the page; `narrow` figures stand three or four in a row, others two."""

    title: str
    lead: str = ""
    figures: tuple[Curve, ...] = ()
    tables: tuple[StudyTable, ...] = ()
    sentences: tuple[str, ...] = ()
    narrow: bool = False


@dataclass(frozen=True)
class StudyContent:
    """All that the page says; `passed` is None where the study judges nothing."""

    kicker: str
    scene: str
    version: str
    headline: str
    sections: tuple[StudySection, ...]
    scene_text: str
    files: str
    passed: bool | None = None


def write_study_page(path: Path, content: StudyContent) -> Path:
    """Writes the page and returns its path."""
    return write_page(path, TEMPLATE, {field.name: getattr(content, field.name) for field in fields(content)})
