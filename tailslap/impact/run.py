"""A run of a whole impact: the FE plate, the rigid vehicle at the same instants, checks."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from tailslap.case.impact.rigid import AFTER_SECOND, LONGEST, RigidImpact
from tailslap.case.model import refusal
from tailslap.case.refine import refined
from tailslap.errors import InputError
from tailslap.files.checkpoints import next_checkpoint
from tailslap.impact.answers import ImpactAnswer, rigid_answer, sampled_answer
from tailslap.impact.checks import impact_checks
from tailslap.impact.fe_plan import ImpactFePlan, impact_model, make_impact_fe_plan
from tailslap.impact.outcome import ImpactOutcome, differences
from tailslap.progress import announced, compiling, progress_bar
from tailslap.scene.schema import Plate

if TYPE_CHECKING:
    from fem.run.impact import ImpactRun

BEYOND = 1.5
"""Multiples of the rigid vehicle's time after which a plate without a second strike is given up."""


def run_impact(plan: RigidImpact) -> ImpactOutcome:
    """Run the plate, the same with richer elements beside it, and set it beside the rigid vehicle; writes nothing.

    Parameters
    ----------
    plan : RigidImpact
        With [plate].

    Returns
    -------
    ImpactOutcome
        Also where checks failed: see `passed`.

    Raises
    ------
    InputError
        For keys that make no model.
    """
    outcome = plain_run(make_fe_plan_timed(plan))
    outcome = _with_errors(outcome)
    return replace(outcome, checks=impact_checks(outcome))


def make_fe_plan_timed(plan: RigidImpact) -> tuple[ImpactFePlan, float]:
    """The FE plan with its loop compiled, and the time that took [s]."""
    began = time.perf_counter()
    with announced("Building the model ..."):
        from fem.run.impact import compile_impact_loop

        fe_plan = make_impact_fe_plan(plan)
    compile_impact_loop(fe_plan.model, told=compiling)
    return fe_plan, time.perf_counter() - began


def plain_run(made: tuple[ImpactFePlan, float]) -> ImpactOutcome:
    """A single run beside the rigid vehicle, without a second run and checks."""
    fe_plan, setup = made
    run = simulated(fe_plan, fe_plan.case.scene.kept_fields)
    return replace(compared(fe_plan, run), setup_s=setup)


def compared(fe_plan: ImpactFePlan, run: ImpactRun) -> ImpactOutcome:
    """A run beside the rigid vehicle at the same instants."""
    fe = _answer(fe_plan, run)
    motion, last = fe_plan.case.motion, float(run.history["t"][-1])
    if last > motion.t_end:
        motion = fe_plan.case.motion_until(last)
    rigid = rigid_answer(motion, run.history["t"])
    return ImpactOutcome(fe_plan, run, differences(fe, rigid), (), 0.0, rigid, fe)


def simulated(fe_plan: ImpactFePlan, snapshots: int = 0) -> ImpactRun:
    """The run of the model, to the scene's end, or 0.1 s after the second strike and no less than the rigid's.

    snapshots: instants at which the motion of all nodes is kept.
    """
    from fem.plate.kinds import ModelError
    from fem.run.impact import simulate_impact

    scene, until = fe_plan.case.scene, fe_plan.case.motion.t_end
    end = scene.time.end

    def finished(run: ImpactRun) -> bool:
        strikes = _answer(fe_plan, run).strikes if len(run.history["t"]) > 2 else ()
        now = float(run.history["t"][-1])
        if len(strikes) < 2:
            return now >= BEYOND * until
        return now >= max(until, strikes[1].end + AFTER_SECOND)

    try:
        with progress_bar(f"{scene.name}: steps", fe_plan.expected_steps) as progress:
            return simulate_impact(
                fe_plan.model,
                fe_plan.touch,
                fe_plan.sample,
                LONGEST if end is None else end,
                finished if end is None else lambda run: False,
                lambda now: progress(min(1.0, now / until)),
                next_checkpoint(),
                snapshots,
                until if end is None else end,
            )
    except ModelError as error:
        raise refusal(scene, fe_plan.plate, error) from None


def _answer(fe_plan: ImpactFePlan, run: ImpactRun) -> ImpactAnswer:
    length = fe_plan.case.vehicle.length
    return sampled_answer(run.history, run.points, run.normal, run.tangential, run.place, length)


def _with_errors(outcome: ImpactOutcome) -> ImpactOutcome:
    """With what richer or finer elements change; without, where they make no model."""
    fe_plan = outcome.fe_plan
    for plate in _higher_order(fe_plan.plate):
        try:
            model, _ = impact_model(fe_plan.case, plate, fe_plan.sample)
        except InputError:
            continue
        from fem.run.impact import compile_impact_loop

        compile_impact_loop(model, told=compiling)
        richer = replace(fe_plan, model=model, plate=plate)
        error = differences(outcome.fe, _answer(fe_plan, simulated(richer)))
        frequency = fe_plan.first_frequency / richer.first_frequency - 1.0
        return replace(outcome, mesh_error=error, frequency_error=frequency)
    return outcome


def _higher_order(plate: Plate) -> list[Plate]:
    """The plate with elements of twice the order, half as many each way where that can be; else twice as many."""
    from fem.plate.kinds import ELEMENT_KINDS

    higher = ELEMENT_KINDS[plate.element].richer
    if not higher:
        return [refined(plate)]
    return [refined(plate, 0.5 if min(plate.counts) > 3 else 1.0, higher), refined(plate)]
