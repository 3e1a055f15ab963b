"""Error against run time on a whole impact: settings from the plate's own limit, that of fine quadratic elements."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError
from tailslap.execution.journal import Journal
from tailslap.execution.run_parts import run_parts
from tailslap.impact.checks import failed_but_mesh
from tailslap.impact.fe_plan import make_impact_fe_plan
from tailslap.impact.run import compared, simulated
from tailslap.scene.schema import Plate
from tailslap.scene.vary import Changes, Source, vary
from tailslap.studies.cost.limits import Limit, limit_of
from tailslap.studies.cost.measure import MAX_REPEATS, Record, repeated
from tailslap.studies.cost.points import Point, point_of
from tailslap.studies.cost.settings import DAMPING, ELEMENTS, FE, ODE, RIGID, SAFETY_FACTORS, STEP, Setting
from tailslap.studies.flexibility.impacts import NAMES, patch_length
from tailslap.studies.study import Call

QUAD4, QUAD9 = "quad4", "quad9"
"""Groups of the meshes; the limit is that of quad9."""


@dataclass(frozen=True)
class ImpactCost:
    """The study: the points, the limit that errors are measured from, and the length that a corner's crush is spread
    over [m]; a point would have no limit."""

    plan: ImpactCase
    points: tuple[Point, ...]
    limit: Limit
    patch: float
    seconds: float


def impact_cost(call: Call) -> ImpactCost:
    """Measure every setting; an interrupted study of the same scene goes on from its journal."""
    began, plan = time.perf_counter(), call.plan
    own = make_impact_fe_plan(plan).plate
    todo = impact_settings(own)
    patch = plan.scene.contact.patch_length or max(patch_length(plan), _longest_element(plan, todo))
    fixed: Changes = {"contact.patch_length": patch} if plan.scene.contact.crushes else {}
    _, source = vary(
        plan.source, {**fixed, "plate.youngs_modulus": own.youngs_modulus, "plate.first_frequency": None}
    )
    definition = {"study": "cost", "scene": plan.scene.model_dump(), "settings": [s.key for s in todo]}
    with Journal(call.place, definition) as journal:
        parts = {setting.key: (source, setting) for setting in todo}
        # One after the other: they are timed.
        run_parts(measure, parts, journal, f"{plan.scene.name}: {len(todo)} settings", workers=1)
        records = [journal.records[setting.key] for setting in todo]
    limit = limit_of([r for r, s in zip(records, todo, strict=True) if s.group == QUAD9], NAMES)
    points = tuple(point_of(*each, limit) for each in zip(todo, records, strict=True))
    return ImpactCost(plan, points, limit, patch, time.perf_counter() - began)


def impact_settings(plate: Plate) -> list[Setting]:
    """All settings, cheap ones first; plate: with elements."""
    return [
        Setting(ODE, RIGID, "event-driven"),
        *(_mesh(plate, QUAD4, factor) for factor in (0.5, 1.0, 2.0, 4.0)),
        *(_mesh(plate, QUAD9, factor) for factor in (0.5, 1.0, 2.0)),
        *(_on(plate, ELEMENTS, name, {"plate.element": name}) for name in ("tri3", "tri6", "quad4-reduced")),
        *(_on(plate, STEP, f"safety factor {f:g}", {"time.safety_factor": f}) for f in SAFETY_FACTORS),
        *(_on(plate, DAMPING, f"ratio {ratio:g}", {"damping.ratio": ratio}) for ratio in (0.01, 0.1)),
    ]


def _longest_element(plan: ImpactCase, todo: list[Setting]) -> float:
    """Of the coarsest mesh [m]; no corner's crush is spread over less."""
    along = (s.changes["plate.elements"][0] for s in todo if s.kind == FE)
    return plan.vehicle.length / min(along)


def _mesh(plate: Plate, element: str, factor: float) -> Setting:
    along, across = (max(2, round(factor * count)) for count in plate.counts)
    changes = {"plate.element": element, "plate.elements": (along, across)}
    return Setting(FE, element, f"{along} x {across}", changes, refinement=factor)


def _on(plate: Plate, group: str, label: str, changes: Changes) -> Setting:
    """Something else on the scene's mesh."""
    return Setting(FE, group, label, {"plate.element": QUAD4, "plate.elements": plate.counts, **changes})


def measure(source: Source, setting: Setting) -> Record:
    """What the setting answers: the first two strikes, times [s] of every repeat, checks that failed."""
    try:
        plan = ImpactCase(*vary(source, setting.changes))
        return _rigid(plan) if setting.kind == ODE else _finite_elements(plan)
    except InputError as error:
        return {"refused": str(error)}


def _rigid(plan: ImpactCase) -> Record:
    loops: list[float] = []
    motion = plan.motion
    while len(loops) < MAX_REPEATS:
        began = time.perf_counter()
        motion = plan.motion_until(None)
        loops.append(time.perf_counter() - began)
    return {"values": _values(motion.strikes), "setup": [0.0], "loop": loops, "steps": 0, "failed": []}


def _finite_elements(plan: ImpactCase) -> Record:
    from fem.run.impact import compile_impact_loop

    began = time.perf_counter()
    compile_impact_loop(make_impact_fe_plan(plan).model)
    compiled = time.perf_counter() - began
    fe_plan, run, times = repeated(lambda: make_impact_fe_plan(plan), simulated)
    outcome = compared(fe_plan, run)
    values, failed = _values(outcome.fe.strikes), list(failed_but_mesh(outcome))
    return {"values": values, **times, "compile": compiled, "steps": run.steps, "failed": failed}


def _values(strikes: Any) -> dict[str, float]:
    """Impulse, peak and duration of the first two strikes by `NAMES`, NaN where there are fewer."""
    found = {f"strike_{k}": strike for k, strike in enumerate(strikes[:2], 1)}
    pairs = ((name, name.split(".")) for name in NAMES)
    return {name: getattr(found.get(strike), what, math.nan) for name, (strike, what) in pairs}
