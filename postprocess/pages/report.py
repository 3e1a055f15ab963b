"""`report.html`: one file that holds all it shows, with no script and nothing fetched from elsewhere."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from postprocess.comparison.comparison import PAPER_SOURCE, ComparisonRow
from postprocess.comparison.metrics import Metrics
from postprocess.figures.style import Curve
from postprocess.pages.pages import write_page

TEMPLATE = "report.html.j2"


@dataclass(frozen=True)
class Check:
    """A check of the result.

    Attributes
    ----------
    name : str
        As the report shows it.
    value, limit : float
        What was found and what is allowed, in the same unit [as `name` says].
    passed : bool
        The outcome.
    meaning : str
        What it guards against.
    """

    name: str
    value: float
    limit: float
    passed: bool
    meaning: str = ""

    @classmethod
    def at_most(cls, name: str, value: float, limit: float, meaning: str) -> "Check":
        """A check that passes where the value is a finite number and not above the limit.

        Parameters
        ----------
        name, meaning : str
            As in `Check`.
        value, limit : float
            What was found, and the largest that passes [as `name` says].

        Returns
        -------
        Check
            The outcome included.
        """
        return cls(name, float(value), limit, bool(math.isfinite(value) and value <= limit), meaning)


@dataclass(frozen=True)
class Result:
    """A line of a table: what, its value (number or words), unit and a remark."""

    name: str
    value: float | int | str | None
    unit: str = ""
    remark: str = ""


@dataclass(frozen=True)
class SceneInput:
    """An input as used: dotted key, the words of the scene, the SI value, and where it came from."""

    key: str
    given: str
    value: float | int | str | None
    unit: str = ""
    origin: str = "scene"


@dataclass(frozen=True)
class LeftOut:
    """A part that the run leaves out, and why."""

    part: str
    why: str


@dataclass(frozen=True)
class Picture:
    """A PNG file on disk, put into the report whole, and its caption."""

    path: Path
    caption: str


@dataclass(frozen=True)
class ReportContent:
    """All that the report says. A part that is empty is not shown, except `left_out`: then nothing was.

    headline: the verdict in a sentence.
    comparison: rows at the tail-slap, empty if the run did not reach it; metrics: of the FE histories against the
    rigid ones, by the history's name; statements: sentences on what was
    run and what it means; stage1, stage3, cost: tables; curves: as `draw_histories` gives them; scene_text:
    the scene's own text, printed as it stands.
    """

    scene: str
    version: str
    passed: bool
    comparison: tuple[ComparisonRow, ...] = ()
    statements: tuple[str, ...] = ()
    checks: tuple[Check, ...] = ()
    metrics: Mapping[str, Metrics] = field(default_factory=dict)
    stage1: tuple[Result, ...] = ()
    stage3: tuple[Result, ...] = ()
    curves: tuple[Curve, ...] = ()
    pictures: tuple[Picture, ...] = ()
    cost: tuple[Result, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    inputs: tuple[SceneInput, ...] = ()
    scene_text: str = ""
    paper_source: str = PAPER_SOURCE
    headline: str = ""


def write_report(path: Path, content: ReportContent) -> Path:
    """Writes the page and returns its path; every picture must be there."""
    values = {field.name: getattr(content, field.name) for field in fields(content)}
    values["verdict"] = verdict(content)
    values["curve_groups"] = _grouped(content.curves)
    values["has_paper"] = any(row.paper_analytical is not None for row in content.comparison)
    return write_page(path, TEMPLATE, values)


def verdict(content: ReportContent) -> str:
    """The result in a sentence, up to the list of differences: failed checks and the largest difference."""
    failed = [check.name for check in content.checks if not check.passed]
    words = f"Failed: {', '.join(failed)}. " if failed else ""
    words += f"{content.headline} " if content.headline else ""
    if not content.comparison:
        return words + "There is no comparison: the run did not reach the tail-slap."
    sizes = [abs(row.difference) for row in content.comparison]
    largest = max(sizes) if all(map(math.isfinite, sizes)) else math.nan
    size = f"by at most {largest:.1e}" if math.isfinite(largest) else "without bound"
    words += "At the tail-slap the FE run differs from the exact rigid-body solution "
    return words + f"{size} (FE/rigid − 1):"


def _grouped(curves: tuple[Curve, ...]) -> Mapping[str, list[Any]]:
    groups: dict[str, list[Any]] = {}
    for curve in curves:
        groups.setdefault(curve.group, []).append(curve)
    return groups
