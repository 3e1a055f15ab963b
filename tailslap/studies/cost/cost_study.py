"""Error and run time of all methods and settings.

For a constrained corner, errors are relative to the exact rigid motion of the scene, and to the converged solution of a
soft plate, whose flexibility is large compared to the errors of its meshes. For a whole impact, they are relative to
the converged solution of the scene's own plate.
"""

import math
import statistics
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from fem.run.corner import Run, simulate
from fem.run.impact import compile_impact_loop
from postprocess.comparison import quantities
from postprocess.comparison.grid_convergence import GridConvergence, Limit, finite, grids_of, halved, limit_of
from postprocess.comparison.quantities import KEYS
from solver import integrate_odes, plane_motion
from tailslap import errors, modal_run, studies
from tailslap.campaign import engine
from tailslap.campaign.records import Record
from tailslap.case import case_of, resources
from tailslap.case.case import Case
from tailslap.case.check import failed_names
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.case.corner.corner_run import compare
from tailslap.case.impact import checks, run
from tailslap.scene.vary import Source, shown, vary
from tailslap.studies.cost import cost_settings
from tailslap.studies.cost.cost_settings import FE, MODAL, STEP, Setting
from tailslap.studies.flexibility.impact_flexibility import NAMES

ROUNDING = 2.2e-12
"""Uncertainty of the exact solution, its largest distance from DOP853 over 1000 inputs (benchmarks/rigid.py)."""

TOO_LONG = 30.0
"""Expected time of a time loop above which a setting is omitted [s]."""

T = TypeVar("T")

NO_LIMIT = Limit({}, math.nan)

LEVELS = tuple(10.0**-exponent for exponent in range(2, 12))
"""Levels of error of the fastest settings."""


class CostResult(NamedTuple):
    """Result of the study.

    Attributes
    ----------
    rows : list of dict
        One row per setting.
    limit : Limit
        Converged solution of the soft plate or the impact.
    mesh_limit : Limit
        Solution on the mesh of choices with a converged time step.
    convergence : dict
        Grid convergence by group.
    soft : tuple of str
        Changes that make the plate soft.
    flexibility : float
        Distance of the limit from the rigid motion.
    patch : float
        Length of the crushed side [m].
    """

    case: Case
    rows: list[Record]
    limit: Limit
    seconds: float = 0.0
    mesh_limit: Limit = NO_LIMIT
    convergence: Mapping[str, Mapping[str, GridConvergence]] = {}
    soft: tuple[str, ...] = ()
    flexibility: float = math.nan
    patch: float = math.nan

    def rows_of(self, soft: bool) -> list[Record]:
        """Return the rows of the soft plate, or the others."""
        return [row for row in self.rows if row["soft"] == soft]


def compute(case: Any, place: Path) -> CostResult:
    """Measure all settings.

    An interrupted study resumes from its journal.
    """
    began, impact, patch = time.perf_counter(), case.scene.contact is not None, math.nan
    case = case if impact else studies.with_elements(case)
    if impact:
        todo, changes, patch = cost_settings.impact_settings(case)
    else:
        todo = [*cost_settings.settings(case.scene), *cost_settings.soft_settings(case.scene)]
        changes = cost_settings.soft_changes(case)
    varied = case.varied(changes)
    definition = {"study": "cost", "scene": case.scene.model_dump(), "settings": [s.key for s in todo]}
    parts = {s.key: ((varied if impact or s.soft else case).source, s) for s in todo}
    # One by one, since they are timed.
    records = engine.run_study(place, definition, (measure, parts, f"{len(todo)} settings"), workers=1)
    seconds = time.perf_counter() - began
    if not impact:
        return corner_result(case, todo, records, shown(changes), varied.tail_slap)._replace(seconds=seconds)
    limit = limit_of([records[s.key] for s in todo if s.group == "quad9"], NAMES)
    return CostResult(case, [row_of(s, records[s.key], limit) for s in todo], limit, seconds, patch=patch)


def corner_result(
    case: CornerCase, todo: list[Setting], by_key: Record, soft: tuple[str, ...], truth: Mapping[str, float]
) -> CostResult:
    """Return the result for a constrained corner.

    `truth` is the rigid motion of the scene with the soft plate.
    """
    meshes = [s for s in todo if s.group == cost_settings.MESH and s.refinement >= 0.5]
    # Steps are that of the scene's own mesh and its halves.
    steps = [s for s in todo if not s.soft and (s.group == STEP or (s in meshes and s.refinement == 1.0))]
    groups = {cost_settings.MESH: meshes, STEP: steps}
    for name in ("quad4", "quad9", STEP):
        groups[f"soft plate, {name}"] = [s for s in todo if s.soft and s.group == name]
    records = {group: [by_key[s.key] for s in members] for group, members in groups.items()}
    limit, step_records = limit_of(records["soft plate, quad9"]), records[f"soft plate, {STEP}"]
    mesh_limit = limit_of(step_records if halved(step_records) else [])
    exact = Limit(case.tail_slap, ROUNDING)
    rows = [row_of(s, by_key[s.key], limit if s.soft else exact, mesh_limit) for s in todo]
    regular = {key: runs for key, runs in records.items() if STEP not in key or halved(finite(runs))}
    convergence = {group: grids for group, runs in regular.items() if (grids := grids_of(runs))}
    flexibility = quantities.largest_relative(limit.values, truth)
    return CostResult(case, rows, limit, 0.0, mesh_limit, convergence, soft, flexibility)


def row_of(setting: Setting, record: Record, limit: Limit, mesh_limit: Limit = NO_LIMIT) -> Record:
    """Return the row of a setting.

    `error` is the distance from the limit, at least its uncertainty. `added` is the error of a choice beyond that of
    its mesh, otherwise NaN. Times [s] exclude compilation and loading; they are the fastest of several, and the median.
    """
    columns = ("kind", "group", "label", "refinement", "soft", "choice")
    values, setups, loops = (record.get(name) for name in ("values", "setup", "loop"))
    error = limit.error_of(values) if values else math.nan
    added = mesh_limit.error_of(values) if values and setting.choice else math.nan
    setup, loop, median = min(setups or [0.0]), min(loops or [0.0]), statistics.median(loops or [0.0])
    times = {"seconds": setup + loop, "setup_s": setup, "loop_s": loop, "median_s": median}
    row = {"setting": setting.key, **{name: getattr(setting, name) for name in columns}}
    row |= {"error": error, "added": added, **times, "compile_s": record.get("compile", 0.0)}
    failed = ", ".join(record.get("failed", ()))
    return row | {"steps": record.get("steps", 0), "failed": failed, "refused": record.get("refused", "")}


def own_error(row: Record) -> float:
    """Return the added error of a choice, otherwise the error."""
    return float(row["added" if row["choice"] else "error"])


def is_valid(row: Record) -> bool:
    """Return True if a result passed its checks."""
    return not row["refused"] and not row["failed"] and math.isfinite(row["error"])


def front(rows: Iterable[Record]) -> list[Record]:
    """Return the Pareto front of time and error.

    The exact solution, from which errors are measured, and choices on one mesh are excluded.
    """
    best: list[Record] = []
    for row in sorted(filter(is_valid, rows), key=lambda row: (row["seconds"], row["error"])):
        beats = not best or row["error"] < best[-1]["error"]
        if beats and row["kind"] != cost_settings.EXACT and not row["choice"]:
            best.append(row)
    return best


def cheapest(rows: Iterable[Record], level: float) -> Record | None:
    """Return the fastest valid row with at most this error."""
    accurate = [row for row in rows if is_valid(row) and row["error"] <= level]
    return min(accurate, key=lambda row: row["seconds"], default=None)


def measure(source: Source, setting: Setting) -> Record:
    """Return the record of a setting.

    It contains values, times of all repetitions [s], steps and failed checks, or the reason `refused`.
    """
    try:
        case = case_of(*vary(source, setting.changes))
        method = {FE: _finite_elements, MODAL: _modal}.get(setting.kind, _rigid)
        return method(case, setting)
    except errors.InputError as error:
        return {"refused": str(error)}


def _clocked(function: Callable[..., T], *arguments: object) -> tuple[float, T]:
    """Return a call's time [s] and result."""
    began = time.perf_counter()
    result = function(*arguments)
    return time.perf_counter() - began, result


def _repeated(
    once: Callable[[], tuple[float, float, T]], least: int = 2, most: float = 7, patience: float = 1.0
) -> tuple[T, Record]:
    """Return the last result and all times [s].

    `once` returns time of the set-up, time of the loop and result.
    """
    setups, loops = [], []
    while True:
        setup, loop, result = once()
        setups.append(setup)
        loops.append(loop)
        if len(loops) >= most or (len(loops) >= least and sum(setups) + sum(loops) >= patience):
            return result, {"setup": setups, "loop": loops}


def _rigid(case: Any, setting: Setting) -> Record:
    """Measure the rigid solution by many repetitions."""
    scene, rtol = case.scene, setting.number
    if scene.contact:
        solve: Callable[[], Any] = partial(case.motion_until, None)
    else:
        motion = case.body, case.start.angle, case.start.omega, case.start.corner_speed
        inputs = *motion, scene.corner_friction, scene.corner.rigid_reaction
        solve = partial(plane_motion, *inputs)
        if setting.kind == cost_settings.ODE:
            solve = partial(integrate_odes, *inputs, method=setting.group, rtol=rtol, atol=0.01 * rtol)
    solve()
    solution, times = _repeated(lambda: (0.0, *_clocked(solve)), least=21, most=math.inf, patience=0.3)
    values = {} if scene.contact else {name: float(getattr(solution.strike, name)) for name in KEYS}
    return {"values": values or strike_values(solution.strikes), **times, "steps": 0, "failed": []}


def _modal(case: CornerCase, setting: Setting) -> Record:
    """Measure the modal model with its set-up.

    Meshing and assembly are included, the runs for the error estimate are not.
    """

    def once() -> tuple[float, float, Any]:
        planned, fe_plan = _clocked(case.plan)
        modal = modal_run.modal_run(fe_plan, int(setting.number), tolerance=1.0)
        return planned + modal.setup_s, modal.integration_s, modal

    modal, times = _repeated(once)
    values, failed = modal.values or dict.fromkeys(KEYS, math.nan), list(failed_names(modal.checks))
    return {"values": values, **times, "steps": modal.steps, "failed": failed}


def _finite_elements(case: Any, setting: Setting) -> Record:
    """Measure finite elements after a run that compiles."""
    impact = case.scene.contact is not None
    integrate: Callable[[Any], Any] = run.simulated if impact else _simulated
    fe_plan = case.plan()
    if impact:
        compiled, _ = _clocked(compile_impact_loop, fe_plan.model)
    else:
        expected = resources.loop_seconds(case.scene, "quad9", fe_plan.plate.counts, fe_plan.expected_steps)
        if expected > TOO_LONG:
            return {"refused": f"omitted: estimated time of the time loop {expected:.0f} s"}
        compiled, _ = _clocked(_simulated, fe_plan, 10, 1e-3)

    def once() -> tuple[float, float, Any]:
        planned, fe_plan = _clocked(case.plan)
        result = integrate(fe_plan)
        return planned, result.time_loop_s, (fe_plan, result)

    (fe_plan, result), times = _repeated(once)
    if impact:
        outcome: Any = run.compared(fe_plan, result)
        values, failed = strike_values(outcome.fe.strikes), checks.failed_but_mesh(outcome)
    else:
        outcome = compare(fe_plan, result, 0.0)
        values, failed = outcome.fe or dict.fromkeys(KEYS, math.nan), failed_names(outcome.checks)
    return {"values": values, **times, "compile": compiled, "steps": result.steps, "failed": list(failed)}


def strike_values(strikes: Sequence[object]) -> dict[str, float]:
    """Return the quantities of the first two strikes.

    They are by `NAMES`, NaN for fewer strikes.
    """
    by_name = {f"strike_{k}": strike for k, strike in enumerate(strikes[:2], 1)}
    pairs = ((name, name.split(".")) for name in NAMES)
    return {name: getattr(by_name.get(strike), quantity, math.nan) for name, (strike, quantity) in pairs}


def _simulated(fe_plan: CornerPlan, rows: int = 0, part: float = 1.0) -> Run:
    """Run a part of the motion.

    `rows` of its history are those of the scene if 0.
    """
    case, kind = fe_plan.case, fe_plan.plate.start
    duration, threads = part * case.motion.strike.t, case.scene.time.threads
    rows = rows or case.scene.time.rows
    return simulate(fe_plan.model, fe_plan.start, duration, kind, rows, threads)
