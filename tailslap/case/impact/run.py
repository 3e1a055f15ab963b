"""A run of a whole impact: the FE plate, the rigid vehicle at the same instants, and the same on other meshes."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.plate.properties import ModelError
from solver.impact import ImpactMotion, Strike
from tailslap.case.case import Outcome
from tailslap.case.impact import answers, error, plan
from tailslap.case.impact.rigid import LONGEST, RigidImpact, paper_method, tipping_of
from tailslap.case.plate_input import refusal
from tailslap.errors import InputError
from tailslap.progress import announced, compiling, progress_bar
from tailslap.scene.schema import Plate
from tailslap.storage import checkpoints

if TYPE_CHECKING:
    from fem.run.impact import ImpactRun

BEYOND = 1.5
"""Multiples of the rigid vehicle's time after which a plate without a second strike is given up."""


@dataclass(frozen=True)
class ImpactOutcome(Outcome):
    """A finished run of a whole impact.

    Attributes
    ----------
    rigid, fe : ImpactAnswer
        What both models answer, at the same instants.
    mesh_error : dict of float
        Numerical error of each quantity of the first two strikes of weight, relative, by `strike_1.impulse` and so on;
        empty where none is stated.
    hinge_error : list of float
        Of the largest 50 ms mean of the force of each hinge, relative; empty where none is stated.
    """

    fe_plan: plan.ImpactPlan
    run: ImpactRun
    rigid: answers.ImpactAnswer
    fe: answers.ImpactAnswer
    mesh_error: dict[str, float] = field(default_factory=dict)
    hinge_error: list[float] = field(default_factory=list)

    @property
    def stated_errors(self) -> dict[str, float]:
        """Largest error of each quantity by its name in `error.STATED`; NaN where none is stated."""
        found = {name: error.largest(self.mesh_error, name) for name in error.QUANTITIES}
        return found | ({"hinge": max(self.hinge_error, default=math.nan)} if self.fe.units > 1 else {})

    @property
    def stated_error(self) -> float:
        """Largest relative error of all quantities; NaN where none is stated."""
        return max(self.stated_errors.values())

    @property
    def lateral_force(self) -> float:
        """Largest mean over 50 ms of the plate's force on the wall [N]."""
        return float(self.fe.peaks["mean_50ms"])

    @cached_property
    def tipping(self) -> dict[str, Any]:
        """Roll over the wall by the forces of both models, by their names; empty without [tipping]."""
        found = {
            name: tipping_of(self.fe_plan.case, own) for name, own in (("FE", self.fe), ("rigid", self.rigid))
        }
        return {name: each for name, each in found.items() if each}

    @cached_property
    def paper_method(self) -> dict[str, Any] | None:
        """The paper's method beside the rigid vehicle's impact."""
        return paper_method(self.fe_plan.case.scene, self.rigid)


def attempt(case: RigidImpact) -> ImpactOutcome:
    """A single run beside the rigid vehicle, without a second run and checks. Raises InputError."""
    began = time.perf_counter()
    with announced("Building the model ..."):
        from fem.run import impact

        fe_plan = plan.make_impact_plan(case)
    impact.compile_impact_loop(fe_plan.model, on_compile=compiling)
    setup = time.perf_counter() - began
    return replace(compared(fe_plan, simulated(fe_plan, case.scene.kept_fields)), setup_s=setup)


def compared(fe_plan: plan.ImpactPlan, run: ImpactRun) -> ImpactOutcome:
    """A run beside the rigid vehicle at the same instants."""
    fe = _answer(fe_plan, run)
    motion = rigid_motion(fe_plan.case, float(run.history["t"][-1]))
    rigid = answers.rigid_answer(motion, run.history["t"])
    return ImpactOutcome(fe_plan, run, answers.differences(fe, rigid), (), 0.0, rigid, fe)


def rigid_motion(case: RigidImpact, end: float) -> ImpactMotion:
    """The rigid vehicle's impact, no less than to this end [s]."""
    return case.motion if end <= case.motion.t_end else case.motion_until(end)


def simulated(fe_plan: plan.ImpactPlan, snapshots: int = 0, end: float | None = None) -> ImpactRun:
    """The run of the model, to the scene's end, or 0.1 s after the second strike, of a train after its last rear's, no
    less than the rigid's, and until neither is in a strike.

    snapshots: instants at which the motion of all nodes is kept; end: another end [s].
    """
    from fem.run import impact

    scene, until = fe_plan.case.scene, fe_plan.case.motion.t_end
    end = scene.time.end if end is None else end
    leaning = {strike.corner for strike in fe_plan.case.motion.strikes if strike.cut}

    def in_progress(strike: Strike) -> bool:
        return strike.cut and strike.corner not in leaning

    def finished(run: ImpactRun) -> bool:
        now = float(run.history["t"][-1])
        if now < until:
            return False
        answer = _answer(fe_plan, run)
        last = answers.last_awaited(answer.strikes, answer.units)
        leans = last is not None and last.cut and not in_progress(last)
        awaited = (last.end + fe_plan.case.after_second) if last else BEYOND * until
        if (now < awaited and not leans) or any(map(in_progress, answer.strikes)):
            return False
        return not any(map(in_progress, rigid_motion(fe_plan.case, now).strikes))

    try:
        with progress_bar(f"{scene.name}: steps", fe_plan.expected_steps) as progress:
            return impact.simulate_impact(
                fe_plan.model,
                fe_plan.touch,
                fe_plan.sample,
                LONGEST if end is None else end,
                finished if end is None else lambda run: False,
                lambda now: progress(min(1.0, now / until)),
                checkpoints.next_checkpoint(),
                snapshots,
                until if end is None else end,
            )
    except ModelError as refused:
        raise refusal(scene, fe_plan.plate, refused) from None


def _answer(fe_plan: plan.ImpactPlan, run: ImpactRun) -> answers.ImpactAnswer:
    history = run.history
    if run.units:
        forces = [
            [each[:, run.unit == number].sum(axis=1) for number in range(len(run.units))]
            for each in (run.normal, run.tangential)
        ]
        history = history | run.units[0] | answers.train_columns(run.units, np.array(forces), run.hinges)
    points = run.points, run.normal, run.tangential, run.place
    return answers.sampled_answer(history, *points, corners_of(fe_plan, run))


def corners_of(fe_plan: plan.ImpactPlan, run: ImpactRun) -> np.ndarray:
    """Number of the corner that each contact point belongs to, see `answers.sampled_answer`; shape (points,)."""
    corner = np.empty_like(run.unit)
    for number, vehicle in enumerate(fe_plan.case.motion.vehicles):
        own = run.unit == number
        corner[own] = 4 * number + answers.nearest_corner(run.points[:, own], vehicle.length)
    return corner


def with_errors(outcome: ImpactOutcome) -> ImpactOutcome:
    """The outcome with its error by two other meshes, and by a third where that may still be within what was asked for;
    without, where they make no model."""
    limit = outcome.fe_plan.case.scene.verify.mesh
    for coarse, fine in error.companions(outcome.fe_plan.plate):
        try:
            sequence = [_on(outcome, plate) for plate in (coarse, fine)]
        except InputError:
            continue
        estimated = _estimated(outcome, sequence)
        moved = list(error.changes(outcome.fe, sequence[-1]).values())
        moved += [distances[-1] for distances in error.hinge_changes(outcome.fe, sequence)]
        within = max(map(abs, moved), default=math.inf) <= limit < max(estimated.stated_errors.values())
        if within and (finest := error.third(fine)):
            estimated = _estimated(outcome, [*sequence, _on(outcome, finest)])
        return estimated
    return outcome


def _estimated(outcome: ImpactOutcome, sequence: list[answers.ImpactAnswer]) -> ImpactOutcome:
    """The outcome with its errors by the answers of other meshes."""
    return replace(
        outcome,
        mesh_error=error.estimate(outcome.fe, sequence),
        hinge_error=error.hinge_errors(outcome.fe, sequence),
    )


def _on(outcome: ImpactOutcome, plate: Plate) -> answers.ImpactAnswer:
    """The impact on another mesh, or the run's own. Raises InputError for one that makes no model."""
    from fem.run import impact

    fe_plan = outcome.fe_plan
    if plate == fe_plan.plate:
        return outcome.fe
    model, _ = plan.impact_model(fe_plan.case, plate, fe_plan.sample)
    impact.compile_impact_loop(model, on_compile=compiling)
    other, end = replace(fe_plan, model=model, plate=plate), error.judged_until(outcome.fe)
    answer = _answer(other, simulated(other, end=end))
    if cut_alone(answer, outcome.fe):
        answer = _answer(other, simulated(other, end=BEYOND * end))
    return answer


def cut_alone(answer: answers.ImpactAnswer, own: answers.ImpactAnswer) -> bool:
    """True where a judged strike is not over on another mesh, while all of the run's own are."""
    return any(each.cut for each in error.weighed(answer.strikes)) and not any(
        each.cut for each in error.weighed(own.strikes)
    )
