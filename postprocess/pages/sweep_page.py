"""`report.html` of a sweep: one file that holds all it shows, with no script."""

from dataclasses import dataclass, fields
from pathlib import Path

from postprocess.figures.style import Curve
from postprocess.pages.pages import write_page

TEMPLATE = "sweep.html.j2"


@dataclass(frozen=True)
class VariedKey:
    """A line of the table of keys: key, its values in words, and how many there are."""

    key: str
    values: str
    count: int


@dataclass(frozen=True)
class Spread:
    """A compared quantity over rows: symbol, unit, least and largest FE value, largest difference and its run."""

    symbol: str
    unit: str
    least: float
    most: float
    difference: float
    run: int


@dataclass(frozen=True)
class Trouble:
    """A row that did not pass: run, inputs in words, status, reason."""

    run: int
    inputs: str
    status: str
    reason: str


@dataclass(frozen=True)
class SweepContent:
    """All that the page says: headline, keys, spreads, rows that did not pass (the first ones, and how many in all),
    curves, sentences, the scene's text."""

    scene: str
    version: str
    headline: str
    keys: tuple[VariedKey, ...]
    spreads: tuple[Spread, ...]
    troubles: tuple[Trouble, ...]
    trouble_count: int
    curves: tuple[Curve, ...]
    statements: tuple[str, ...]
    scene_text: str


def write_sweep_page(path: Path, content: SweepContent) -> Path:
    """Writes the page and returns its path."""
    values = {field.name: getattr(content, field.name) for field in fields(content)}
    return write_page(path, TEMPLATE, values)
