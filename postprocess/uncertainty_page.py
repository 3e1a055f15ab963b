"""`report.html` of an uncertainty study: one file that holds all it shows, with no script."""

from dataclasses import dataclass, fields
from pathlib import Path

from postprocess.curves import Curve
from postprocess.numbers import number
from postprocess.report import Result

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
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("postprocess"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(number=number, interval=interval)
    values = {field.name: getattr(content, field.name) for field in fields(content)}
    path.write_text(environment.get_template(TEMPLATE).render(values), encoding="utf-8")
    return path


def interval(ends: tuple[float, float]) -> str:
    """A confidence interval of an index: its two ends, three digits behind the point."""
    return " to ".join(f"{end:.3f}" for end in ends)
