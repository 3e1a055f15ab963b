"""The two panels of error against run time, out of the points."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from postprocess.figures.precision_plots import Diagram, Series
from tailslap.studies.cost.limits import observed_order
from tailslap.studies.cost.points import Point, front
from tailslap.studies.cost.settings import (
    DAMPING,
    EXACT,
    INTEGRATORS,
    MESH,
    MODES,
    PENALTY,
    ROWSUM,
    SINGLE,
    STEP,
    SUDDEN,
)
from tailslap.studies.cost.soft import REFINED, SPRING

RIGID_LABELS = {
    EXACT: "exact solution",
    **{name: name for name in INTEGRATORS},
    MODES: "modal model",
    MESH: "FE, meshes of quad4",
    ROWSUM: "FE, row-sum masses",
    SUDDEN: "FE, unstressed start",
    PENALTY: "FE, penalty scales",
    SINGLE: "FE, single precision",
}
"""Lines of the scene as it is; all other groups are marks of one name."""

OTHERS = "FE, all other settings"
MESH_LABELS = {**{name: name for name in REFINED}, SPRING: SPRING}
CHOICE_LABELS = {PENALTY: "penalty scales", DAMPING: "damping", STEP: "time steps", MODES: "modes"}


def rigid_diagram(points: Sequence[Point], known: float) -> Diagram:
    """Panel (a): the scene as it is; known: what the exact solution is held to."""
    rigid = tuple(p for p in points if not p.setting.soft)
    lines = [_series(label, _of(rigid, group)) for group, label in RIGID_LABELS.items()]
    others = [p for p in rigid if p.setting.group not in RIGID_LABELS]
    return Diagram(
        name="precision-rigid",
        title="(a) How far from the exact rigid motion",
        series=[*lines, _series(OTHERS, others, joined=False)],
        front=[(p.seconds, p.error) for p in front(rigid)],
        front_label="Pareto front, exact solution apart",
        floor=known,
        floor_label=f"the exact solution is known to {known:.0e}",
        error_label="error from the exact rigid motion",
    )


def flexible_diagram(points: Sequence[Point], known: float, mesh_known: float) -> Diagram:
    """Panel (b): the soft plate; known, mesh_known: what its limit and its mesh's own are known to."""
    soft = tuple(p for p in points if p.setting.soft)
    meshes = [
        _series(_with_order(label, _of(soft, group), known), _of(soft, group))
        for group, label in MESH_LABELS.items()
    ]
    choices = [
        _series(_with_order(label, _of(soft, group), mesh_known), _of(soft, group), dashed=True)
        for group, label in CHOICE_LABELS.items()
    ]
    return Diagram(
        name="precision-flexible",
        title="(b) A soft plate: how far from its own limit",
        series=[*meshes, *choices],
        front=[(p.seconds, p.error) for p in front(soft)],
        front_label="Pareto front",
        floor=known,
        floor_label=f"the limit is known to {known:.0e}",
        error_label="error from the soft plate's limit",
    )


def drawn_error(point: Point) -> float:
    """What a choice adds; else the error."""
    return point.added if point.setting.choice else point.error


def order_of(points: Iterable[Point], known: float) -> float:
    """Observed order of the points of a group."""
    good = [p for p in points if math.isfinite(drawn_error(p))]
    return observed_order([p.setting.refinement for p in good], [drawn_error(p) for p in good], known)


def _with_order(label: str, points: list[Point], known: float) -> str:
    order = order_of(points, known) if points and points[0].setting.group != MODES else math.nan
    return f"{label}, order {order:.1f}" if order > 0.5 else label


def _of(points: Iterable[Point], group: str) -> list[Point]:
    return [point for point in points if point.setting.group == group]


def _series(label: str, points: Iterable[Point], joined: bool = True, dashed: bool = False) -> Series:
    """The points that have an error."""
    good = [p for p in points if not p.refused and math.isfinite(drawn_error(p))]
    return Series(
        label,
        [p.seconds for p in good],
        [drawn_error(p) for p in good],
        [not p.failed for p in good],
        joined,
        dashed,
    )
