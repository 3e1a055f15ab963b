"""`report.html` of a study of features: one file that holds all it shows, with no script."""

from dataclasses import dataclass, fields
from pathlib import Path

from postprocess.figures.style import Curve
from postprocess.pages.pages import write_page
from postprocess.pages.report import Result

TEMPLATE = "features.html.j2"


@dataclass(frozen=True)
class PartRow:
    """A line of the table of parts: times of an element update [ns], ratio in words, the whole run's steps and time
    loop [ms], set-up [ms], instructions and those on vector registers."""

    name: str
    what: str
    best: float
    median: float
    ratio: str
    steps: int
    loop: float
    setup: float
    instructions: int | None
    vector: int | None


@dataclass(frozen=True)
class ProcessRow:
    """A line of the table of commands: seconds of the process, modules, seconds of imports, costliest packages."""

    name: str
    best: float
    median: float
    modules: int
    import_s: float
    packages: str


@dataclass(frozen=True)
class FeaturesContent:
    """All that the page says: headline, parts, proof, what is beside the loop, commands, sentences, curves."""

    scene: str
    version: str
    passed: bool
    headline: str
    parts: tuple[PartRow, ...]
    proof: tuple[Result, ...]
    beside: tuple[Result, ...]
    processes: tuple[ProcessRow, ...]
    statements: tuple[str, ...]
    curves: tuple[Curve, ...]
    scene_text: str


def write_features_page(path: Path, content: FeaturesContent) -> Path:
    """Writes the page and returns its path."""
    values = {field.name: getattr(content, field.name) for field in fields(content)}
    return write_page(path, TEMPLATE, values)
