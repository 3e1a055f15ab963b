"""The two panels of error against run time, out of the points."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from postprocess.figures.precision_plots import Diagram, Series
from postprocess.figures.svg.scale import power_text
from tailslap.studies.cost import settings
from tailslap.studies.cost.points import Point, front, order_of
from tailslap.studies.cost.soft import REFINED, SPRING

RIGID_LINES = {
    settings.EXACT: "exact solution",
    **{name: name for name in (*settings.INTEGRATORS, settings.MODES)},
    settings.MESH: "FE, meshes of quad4",
    **{name: f"FE, {name}" for name in (settings.ROWSUM, settings.UNSTRESSED)},
    settings.PENALTY: "FE, penalty scales",
    settings.SINGLE: f"FE, {settings.SINGLE}",
}
"""Groups of the scene as it is that are lines; all others are marks of one name."""

CHOICES = {settings.PENALTY: "penalty scales", settings.DAMPING: "damping"}
CHOICES |= {settings.STEP: "time steps", settings.MODES: "modes"}
SOFT_LINES = {**{name: name for name in (*REFINED, SPRING)}, **CHOICES}
"""Groups of the soft plate: meshes of an element, then choices made on one mesh."""


IMPACT_LINES = {settings.RIGID: settings.RIGID, "quad4": "meshes of quad4", "quad9": "meshes of quad9"}
IMPACT_LINES |= {settings.STEP: "time steps", settings.DAMPING: "damping"}
"""Groups of whole impacts that are lines; other elements are marks of one name."""


@dataclass(frozen=True)
class Line:
    """The points of a group that have an error, as refined, and the order observed, NaN where there is none."""

    label: str
    points: list[Point]
    order: float = math.nan

    @property
    def coarsest(self) -> Point | None:
        """The first."""
        return self.points[0] if self.points else None

    @property
    def finest(self) -> Point | None:
        """The last."""
        return self.points[-1] if self.points else None


def soft_lines(points: Iterable[Point], known: float, mesh_known: float) -> list[Line]:
    """The lines of the soft plate; known, mesh_known: what its limit and its mesh's own are known to."""
    soft, found = [p for p in points if p.setting.soft], []
    for group, label in SOFT_LINES.items():
        line = _of(soft, group)
        found.append(Line(label, line, order_of(line, mesh_known if group in CHOICES else known)))
    return found


def rigid_diagram(points: Iterable[Point], known: float) -> Diagram:
    """Panel (a): the scene as it is; known: what the exact solution is held to."""
    rigid = [p for p in points if not p.setting.soft]
    others = [p for p in rigid if p.setting.group not in RIGID_LINES]
    lines = [_series(label, _of(rigid, group)) for group, label in RIGID_LINES.items()]
    return Diagram(
        name="precision-rigid",
        title="(a) How far from the exact rigid motion",
        series=[*lines, _series("FE, all other settings", others, joined=False)],
        front=[(p.seconds, p.error) for p in front(rigid)],
        front_label="Pareto front, exact solution apart",
        floor=known,
        floor_label=_known_to("exact solution", known),
        error_label="error from the exact rigid motion",
    )


def flexible_diagram(points: Iterable[Point], known: float, mesh_known: float) -> Diagram:
    """Panel (b): the soft plate; known, mesh_known: as in `soft_lines`."""
    soft = [p for p in points if p.setting.soft]
    return Diagram(
        name="precision-flexible",
        title="(b) A soft plate: how far from its own limit",
        series=[_series(_with_order(line), line.points) for line in soft_lines(soft, known, mesh_known)],
        front=[(p.seconds, p.error) for p in front(soft)],
        front_label="Pareto front",
        floor=known,
        floor_label=_known_to("limit", known),
        error_label="error from the soft plate's limit",
    )


def impact_diagram(points: Iterable[Point], known: float) -> Diagram:
    """Of whole impacts; known: what the plate's limit is known to."""
    points = list(points)
    lines = [_series(label, _of(points, group)) for group, label in IMPACT_LINES.items()]
    others = [p for p in points if p.setting.group not in IMPACT_LINES]
    return Diagram(
        name="precision",
        title="How far from the plate's own limit",
        series=[*lines, _series(settings.ELEMENTS, others, joined=False)],
        front=[(p.seconds, p.error) for p in front(points)],
        front_label="Pareto front",
        floor=known,
        floor_label=_known_to("limit", known),
        error_label="error of both strikes from the plate's limit",
    )


def _with_order(line: Line) -> str:
    ordered = line.order > 0.5 and line.label != CHOICES[settings.MODES]
    return f"{line.label}, order {line.order:.1f}" if ordered else line.label


def _of(points: Iterable[Point], group: str) -> list[Point]:
    return [p for p in points if p.setting.group == group and math.isfinite(p.own_error)]


def _series(label: str, points: Iterable[Point], joined: bool = True) -> Series:
    """What choices add is dashed."""
    good = [p for p in points if math.isfinite(p.own_error)]
    numbers = [(p.seconds, p.own_error, not p.failed) for p in good]
    times, errors, passed = zip(*numbers, strict=True) if numbers else ((), (), ())
    return Series(label, times, errors, passed, joined, any(p.setting.choice for p in good))


def _known_to(what: str, error: float) -> str:
    """With one digit."""
    return f"the {what} is known to {power_text(float(f'{error:.0e}'))}"
