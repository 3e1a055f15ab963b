"""Error and run time of one setting."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from postprocess.comparison.comparison import KEYS
from solver import integrate_odes, plane_motion
from tailslap.case.corner.case import CornerCase
from tailslap.case.cost import loop_seconds
from tailslap.errors import InputError
from tailslap.scene.vary import Source, vary
from tailslap.studies.cost.settings import EXACT, MODAL, ODE, Setting
from tailslap.verification.check import failed_names

MAX_REPEATS, MIN_REPEATS, PATIENCE = 7, 2, 1.0
"""Repeats of a setting, and the seconds after which only the least number is done."""

RIGID_PATIENCE = 0.3
"""Seconds for which a rigid method is repeated at least: a millisecond is easily disturbed."""

TOO_LONG = 30.0
"""Expected seconds of a time loop above which a setting is left out."""

Record = dict[str, Any]


def measure(source: Source, setting: Setting) -> Record:
    """What the setting gives: the five quantities, times [s] of every repeat, and what its own checks say."""
    plan = CornerCase(*vary(source, {}))
    if setting.kind == EXACT:
        return _rigid(plan, lambda: plane_motion(*_stage_two(plan)).strike)
    if setting.kind == ODE:
        return _rigid(plan, lambda: _integrated(plan, setting))
    try:
        changed = CornerCase(*vary(source, setting.changes))
        return _modal(changed, setting) if setting.kind == MODAL else _finite_elements(changed, setting)
    except InputError as error:
        return {"refused": str(error)}


def _integrated(plan: CornerCase, setting: Setting) -> Any:
    method, rtol = setting.group, setting.rtol
    return integrate_odes(*_stage_two(plan), method=method, rtol=rtol, atol=0.01 * rtol).strike


def _stage_two(plan: CornerCase) -> tuple[Any, Any, Any, Any, Any, Any]:
    """What the theory takes for Stage 2."""
    start, scene = plan.start, plan.scene
    rest = (scene.corner_friction, scene.corner.rigid_reaction)
    return plan.body, start.angle, start.omega, start.corner_speed, *rest


def _rigid(plan: CornerCase, solve: Callable[[], Any]) -> Record:
    solve()
    strike: Any = None
    loops: list[float] = []
    while len(loops) < 3 * MAX_REPEATS or sum(loops) < RIGID_PATIENCE:
        began = time.perf_counter()
        strike = solve()
        loops.append(time.perf_counter() - began)
    values = {name: float(getattr(strike, name)) for name in KEYS}
    return {"values": values, "setup": [0.0], "loop": loops, "steps": 0, "failed": []}


def _modal(plan: CornerCase, setting: Setting) -> Record:
    """Integration and set-up, of which meshing and assembling are a part; not the runs of its own estimate."""
    from tailslap.modal_analysis.run import modal_run
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
    failed = list(failed_names(found.checks))
    values = found.values or dict.fromkeys(KEYS, math.nan)
    return {"values": values, "setup": setups, "loop": loops, "steps": found.steps, "failed": failed}


def _finite_elements(plan: CornerCase, setting: Setting) -> Record:
    from tailslap.planning.fe_plan import make_fe_plan
    from tailslap.scene_run import compare

    fe_plan = make_fe_plan(plan)
    expected = loop_seconds(plan.scene, "quad9", fe_plan.plate.counts, fe_plan.expected_steps)
    if expected > TOO_LONG:
        return {"refused": f"left out: the time loop would take about {expected:.0f} s"}
    began = time.perf_counter()
    _simulated(fe_plan, setting, rows=10, share=1e-3)
    compiled = time.perf_counter() - began
    fe_plan, run, times = repeated(
        lambda: make_fe_plan(plan), lambda fe_plan: _simulated(fe_plan, setting, plan.scene.time.rows)
    )
    outcome = compare(fe_plan, run, 0.0)
    values, failed = outcome.fe or dict.fromkeys(KEYS, math.nan), list(failed_names(outcome.checks))
    record = {"values": values, **times, "steps": run.steps, "failed": failed}
    return record | {"compile": compiled, "deflection_ratio": fe_plan.deflection_ratio}


def repeated(make: Callable[[], Any], run: Callable[[Any], Any]) -> tuple[Any, Any, dict[str, list[float]]]:
    """The last plan and its run, and the times [s] that set-up and loop took of all."""
    setups: list[float] = []
    loops: list[float] = []
    while len(loops) < MAX_REPEATS and (len(loops) < MIN_REPEATS or sum(loops) + sum(setups) < PATIENCE):
        began = time.perf_counter()
        plan = make()
        setups.append(time.perf_counter() - began)
        done = run(plan)
        loops.append(done.time_loop_s)
    return plan, done, {"setup": setups, "loop": loops}


def _simulated(fe_plan: Any, setting: Setting, rows: int, share: float = 1.0) -> Any:
    from fem.run.corner import Stepper, simulate

    stepper: Any = Stepper
    if setting.single:
        from tailslap.studies.cost.single import SingleStepper

        stepper = SingleStepper
    plan, kind = fe_plan.case, fe_plan.plate.start
    duration, threads = share * plan.motion.strike.t, plan.scene.time.threads
    return simulate(fe_plan.model, fe_plan.start, duration, kind, rows, threads, make_stepper=stepper)
