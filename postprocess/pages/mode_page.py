"""`report.html` of the plate's modes: one file that holds all it shows, with no script."""

from dataclasses import dataclass, fields
from pathlib import Path

from postprocess.figures.style import Curve
from postprocess.pages.pages import write_page

TEMPLATE = "modes.html.j2"


@dataclass(frozen=True)
class ModeRow:
    """A line of the table, in words: number, frequency, kind, beam theory, difference from it, slender beam."""

    number: str
    frequency: str
    kind: str
    theory: str
    difference: str
    slender: str


@dataclass(frozen=True)
class ModesContent:
    """All that the page says: headline, table, pictures of the shapes, sentences, the scene's text."""

    scene: str
    version: str
    headline: str
    modes: tuple[ModeRow, ...]
    pictures: tuple[Curve, ...]
    statements: tuple[str, ...]
    scene_text: str


def write_modes_page(path: Path, content: ModesContent) -> Path:
    """Writes the page and returns its path."""
    values = {field.name: getattr(content, field.name) for field in fields(content)}
    return write_page(path, TEMPLATE, values)
