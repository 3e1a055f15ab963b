"""Error and run time of one setting."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from postprocess.comparison.comparison import relative_difference
from solver import integrate_odes, plane_motion
from tailslap.errors import InputError
from tailslap.planning.cost import loop_seconds
from tailslap.planning.plan import Plan, make_plan
from tailslap.planning.rigid import COMPARED, stage_two_numbers
from tailslap.scene.vary import Source, vary
from tailslap.studies.cost.settings import EXACT, MODAL, ODE, Setting

MAX_REPEATS, MIN_REPEATS, PATIENCE = 7, 2, 1.0
"""Repeats of a setting, and the seconds after which only the least number is done."""

RIGID_PATIENCE = 0.3
"""Seconds for which a rigid method is repeated at least: a millisecond is easily disturbed."""

TOO_LONG = 30.0
"""Expected seconds of a time loop above which a setting is left out."""

Record = dict[str, Any]


def measure(source: Source, setting: Setting) -> Record:
    """What the setting gives: the five quantities, times [s] of every repeat, and what its own checks say."""
    plan = make_plan(*vary(source, {}))
    if setting.kind == EXACT:
        return _rigid(plan, lambda: _exact(plan))
    if setting.kind == ODE:
        return _rigid(plan, lambda: _integrated(plan, setting))
    try:
        changed = make_plan(*vary(source, setting.changes))
        return _modal(changed, setting) if setting.kind == MODAL else _finite_elements(changed, setting)
    except InputError as error:
        return {"refused": str(error)}


def _exact(plan: Plan) -> Any:
    start, scene = plan.start, plan.scene
    motion = plane_motion(
        plan.body,
        start.angle,
        start.omega,
        start.corner_speed,
        scene.corner_friction,
        scene.corner.rigid_reaction,
    )
    return motion.strike


def _integrated(plan: Plan, setting: Setting) -> Any:
    start, scene = plan.start, plan.scene
    return integrate_odes(
        plan.body,
        start.angle,
        start.omega,
        start.corner_speed,
        scene.corner_friction,
        scene.corner.rigid_reaction,
        method=setting.group,
        rtol=setting.rtol,
        atol=0.01 * setting.rtol,
    ).strike


def _rigid(plan: Plan, solve: Callable[[], Any]) -> Record:
    solve()
    strike: Any = None
    loops: list[float] = []
    while len(loops) < 3 * MAX_REPEATS or sum(loops) < RIGID_PATIENCE:
        began = time.perf_counter()
        strike = solve()
        loops.append(time.perf_counter() - began)
    values = {name: float(getattr(strike, name)) for name in COMPARED}
    return {"values": values, "setup": [0.0], "loop": loops, "steps": 0, "failed": []}


def _modal(plan: Plan, setting: Setting) -> Record:
    """Integration and set-up, of which meshing and assembling are a part; not the runs of its own estimate."""
    from tailslap.modal_run import modal_run
    from tailslap.planning.fe_plan import make_fe_plan

    setups: list[float] = []
    loops: list[float] = []
    for _ in range(MAX_REPEATS):
        began = time.perf_counter()
        fe_plan = make_fe_plan(plan)
        planned = time.perf_counter() - began
        found = modal_run(fe_plan, setting.modes, tolerance=1.0)
        setups.append(planned + found.setup_s)
        loops.append(found.integration_s)
    failed = [check.name for check in found.checks if not check.passed]
    values = found.values or dict.fromkeys(COMPARED, math.nan)
    return {"values": values, "setup": setups, "loop": loops, "steps": found.steps, "failed": failed}


def _finite_elements(plan: Plan, setting: Setting) -> Record:
    from tailslap.planning.fe_plan import make_fe_plan
    from tailslap.scene_run import compare

    fe_plan = make_fe_plan(plan)
    expected = loop_seconds("quad9", fe_plan.plate.counts, fe_plan.expected_steps)
    if expected > TOO_LONG:
        return {"refused": f"left out: the time loop would take about {expected:.0f} s"}
    began = time.perf_counter()
    _simulated(fe_plan, setting, rows=10, share=1e-3)
    compiled = time.perf_counter() - began
    setups: list[float] = []
    loops: list[float] = []
    while len(loops) < MAX_REPEATS and (len(loops) < MIN_REPEATS or sum(loops) + sum(setups) < PATIENCE):
        began = time.perf_counter()
        fe_plan = make_fe_plan(plan)
        setups.append(time.perf_counter() - began)
        run = _simulated(fe_plan, setting, plan.scene.time.rows)
        loops.append(run.time_loop_s)
    outcome = compare(fe_plan, run, 0.0)
    failed = [check.name for check in outcome.checks if not check.passed]
    values = outcome.fe or dict.fromkeys(COMPARED, math.nan)
    record = {"values": values, "setup": setups, "loop": loops, "steps": outcome.run.steps, "failed": failed}
    return record | {"compile": compiled, "deflection_ratio": fe_plan.deflection_ratio}


def _simulated(fe_plan: Any, setting: Setting, rows: int, share: float = 1.0) -> Any:
    from fem.explicit.simulate import Stepper, simulate

    stepper: Any = Stepper
    if setting.single:
        from tailslap.studies.cost.single import SingleStepper

        stepper = SingleStepper
    plan, kind = fe_plan.plan, fe_plan.plate.start
    duration, threads = share * plan.motion.strike.t, plan.scene.time.threads
    return simulate(fe_plan.model, fe_plan.start, duration, kind, rows, threads, make_stepper=stepper)


def error_from(values: dict[str, float], truth: dict[str, float]) -> float:
    """Largest relative distance of the five quantities from the truth; NaN where one is none."""
    sizes = [abs(value) for value in relative_difference(values, truth).values()]
    return max(sizes) if all(map(math.isfinite, sizes)) else math.nan


def rigid_truth(plan: Plan) -> dict[str, float]:
    """The exact solution's five quantities."""
    return stage_two_numbers(plan)
