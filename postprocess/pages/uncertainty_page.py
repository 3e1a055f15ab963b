"""`report.html` of an uncertainty study: one file that holds all it shows, with no script."""

from dataclasses import dataclass, fields
from pathlib import Path

from postprocess.figures.curves import Curve
from postprocess.pages.pages import write_page
from postprocess.pages.report import Result

TEMPLATE = "uncertainty.html.j2"


@dataclass(frozen=True)
class VariedInput:
    """A line of the table of inputs: key, range and the scene's own value in words, and the two indices.

    origin: where the range comes from. The intervals are the ends of a 95 % confidence interval.
    """

    key: str
    range: str
    scene_value: str
    origin: str
    first: float
    first_interval: tuple[float, float]
    total: float
    total_interval: tuple[float, float]


@dataclass(frozen=True)
class UncertaintyContent:
    """All that the page says: headline, the distribution's numbers, inputs, curves, sentences, the scene's text."""

    scene: str
    version: str
    headline: str
    distribution: tuple[Result, ...]
    inputs: tuple[VariedInput, ...]
    statements: tuple[str, ...]
    curves: tuple[Curve, ...]
    scene_text: str


def write_uncertainty_page(path: Path, content: UncertaintyContent) -> Path:
    """Writes the page and returns its path."""
    values = {field.name: getattr(content, field.name) for field in fields(content)}
    return write_page(path, TEMPLATE, values, {"interval": interval})


def interval(ends: tuple[float, float]) -> str:
    """A confidence interval of an index: its two ends, three digits behind the point."""
    return " to ".join(f"{end:.3f}" for end in ends)
