"""Run of a whole impact, compared with the rigid vehicle.

The numerical error is that by runs on other meshes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from fem.plate.properties import ModelError
from postprocess.signals.occupant import RiskMeasure
from solver.impact import ImpactMotion, Strike, outermost
from tailslap.case.case import Outcome
from tailslap.case.impact import answers, error, plan
from tailslap.case.impact.rigid import RigidImpact
from tailslap.case.impact.rigid_motion import AFTER_SECOND, LONGEST
from tailslap.case.plate_input import refusal
from tailslap.errors import InputError
from tailslap.progress import announced, compiling, progress_bar
from tailslap.scene.model_tables import Plate
from tailslap.storage import checkpoints

if TYPE_CHECKING:
    from fem.run.impact import ImpactRun

REFINEMENTS = 2
"""Largest number of refinements of a chosen mesh."""

REACHABLE, REACHABLE_BY_TRAIN = 16.0, 4.0
"""Error over its limit up to which a mesh is refined a second time, which takes minutes for trains."""

BEYOND = 1.5
"""Multiples of the rigid vehicle's time after which a plate without a second strike is not continued."""


@dataclass(frozen=True)
class ImpactOutcome(Outcome):
    """Finished run of a whole impact.

    Attributes
    ----------
    rigid, fe : ImpactAnswer
        Results of both models in the plane at the same instants.
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
        """Largest error of each quantity of `error.STATED`.

        NaN where none is stated.
        """
        errors = {name: error.largest(self.mesh_error, name) for name in error.QUANTITIES}
        return errors | ({"hinge": max(self.hinge_error, default=math.nan)} if self.fe.units > 1 else {})

    @property
    def stated_error(self) -> float:
        """Largest relative error, NaN where none is stated."""
        return max(self.stated_errors.values())

    @property
    def mean_force(self) -> float:
        """Largest 50 ms mean force [N]."""
        return float(self.fe.peaks["mean_50ms"])

    @property
    def occupant_risk(self) -> tuple[RiskMeasure, ...]:
        """Measures of the plate's motion, with [body] of that in space."""
        case = self.fe_plan.case
        answer = case.answer if case.space else self.fe
        return answer.occupant_risk(self.fe_plan.model.mass)


def attempt(case: RigidImpact, refinements: int = 0) -> ImpactOutcome:
    """Run the plate once, and compare it with the rigid vehicle.

    There are no further runs and no checks. refinements: see `make_impact_plan`. Raises InputError.
    """
    began = time.perf_counter()
    with announced("Building the model ..."):
        from fem.run import impact

        fe_plan = plan.make_impact_plan(case, refinements)
    impact.compile_impact_loop(fe_plan.model, on_compile=compiling)
    setup = time.perf_counter() - began
    return replace(compared(fe_plan, simulated(fe_plan, case.scene.kept_fields)), setup_s=setup)


def compared(fe_plan: plan.ImpactPlan, run: ImpactRun) -> ImpactOutcome:
    """Compare a run with the rigid vehicle at the same instants."""
    fe = _answer(fe_plan, run)
    motion = rigid_motion(fe_plan.case, float(run.history["t"][-1]))
    rigid = answers.rigid_answer(motion, run.history["t"])
    return ImpactOutcome(fe_plan, run, answers.differences(fe, rigid), (), 0.0, rigid, fe)


def rigid_motion(case: RigidImpact, end: float) -> ImpactMotion:
    """Return the rigid impact to this end [s] at least."""
    return case.motion if end <= case.motion.t_end else case.motion_until(end)


def simulated(fe_plan: plan.ImpactPlan, snapshots: int = 0, end: float | None = None) -> ImpactRun:
    """Integrate the model to the impact's end.

    It is the scene's end, or `AFTER_SECOND` after the second strike, for a train after that of its last rear, not
    before the rigid vehicle's end, and when neither is in a strike. snapshots: number of instants at which the motion
    of all nodes is stored; end: another end [s].
    """
    from fem.run import impact

    scene, until = fe_plan.case.scene, fe_plan.case.motion.t_end
    end = scene.time.end if end is None else end
    leaning = {strike.corner for strike in fe_plan.case.motion.strikes if strike.cut and fe_plan.case.axles}

    def in_progress(strike: Strike) -> bool:
        return strike.cut and strike.corner not in leaning

    def finished(run: ImpactRun) -> bool:
        now = float(run.history["t"][-1])
        answer = _answer(fe_plan, run)
        last = answers.last_awaited(answer.strikes, fe_plan.case.awaited)
        leans = last is not None and last.cut and not in_progress(last)
        awaited = (last.end + AFTER_SECOND) if last else BEYOND * until
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
            [forces_of[:, run.unit == number].sum(axis=1) for number in range(len(run.units))]
            for forces_of in (run.normal, run.tangential)
        ]
        history = history | run.units[0] | answers.train_columns(run.units, np.array(forces), run.hinges)
    case = fe_plan.case
    ends = outermost(case.contact, case.lengths)
    return answers.sampled_answer(history, run, case.names, ends, len(case.vehicles))


def assessed(case: RigidImpact) -> ImpactOutcome:
    """Run the plate, with its error by other meshes.

    A mesh that the scene leaves open is refined, at most `REFINEMENTS` times, while the error exceeds the limit; the
    second time only where the error is at most `REACHABLE` times the limit, and not where light touches decide on a
    duration, which they do on finer meshes too. Raises InputError.
    """
    outcome, computed = attempt(case), Computed()
    if case.scene.needed_plate.elements is None:
        for refinements in range(1, 1 + REFINEMENTS):
            if not error.finer(outcome.fe_plan.plate):
                break
            outcome = with_errors(outcome, computed, meshes=2)
            stated, limit = outcome.stated_error, case.scene.verify.mesh
            unsure = max(
                (error.unsure_end(outcome.fe, strike) for strike in error.assessed_strikes(outcome.fe)),
                default=0.0,
            )
            reachable = (REACHABLE_BY_TRAIN if outcome.fe.units > 1 else REACHABLE) * limit
            if not stated > limit or unsure > limit or (refinements > 1 and stated > reachable):
                return outcome
            outcome = attempt(case, refinements)
    return with_errors(outcome, computed)


Computed = dict[tuple[str, tuple[int, int], float], answers.ImpactAnswer]
"""Impacts by the kind and the numbers of elements, and the part of the time step."""


def with_errors(outcome: ImpactOutcome, computed: Computed | None = None, meshes: int = 3) -> ImpactOutcome:
    """Return the outcome with its error by two or three meshes.

    Without possible meshes no error is added.

    Parameters
    ----------
    outcome : ImpactOutcome
        Finished run.
    computed : dict
        Impacts on other meshes, used where they last long enough; others are added.
    meshes : int
        With 3 a mesh finer than both is run where the error may then be within the limit, and is not by a coarser
        third.
    """
    limit, plate = outcome.fe_plan.case.scene.verify.mesh, outcome.fe_plan.plate
    computed = {} if computed is None else computed
    computed[plate.element, plate.counts, 1.0] = outcome.fe
    for coarse, fine in error.companions(plate):
        try:
            whole, halved = (_on(outcome, coarse, computed, part) for part in (1.0, error.HALF))
            sequence, steps = [halved, _on(outcome, fine, computed)], (whole, halved)
        except InputError:
            continue
        estimated = _estimated(outcome, sequence, steps)
        moved = list(error.changes(outcome.fe, sequence[-1]).values())
        moved += [distances[-1] for distances in error.hinge_changes(outcome.fe, sequence)]
        if max(map(abs, moved), default=math.inf) <= limit < max(estimated.stated_errors.values()):
            if coarsest := error.coarser(coarse):
                third = _on(outcome, coarsest, computed, error.HALF)
                estimated = _estimated(outcome, [third, *sequence], steps)
            most = error.FINER_UP_TO if outcome.fe.units > 1 else error.FINEST_UP_TO
            is_above = max(estimated.stated_errors.values()) > limit
            if meshes > 2 and is_above and (finest := error.finer(fine, most)):
                estimated = _estimated(outcome, [*sequence, _on(outcome, finest, computed)], steps)
        return estimated
    return outcome


def _estimated(
    outcome: ImpactOutcome, sequence: list[answers.ImpactAnswer], steps: Sequence[answers.ImpactAnswer]
) -> ImpactOutcome:
    """Return the outcome with errors by other runs, see `error.estimate`."""
    by = outcome.fe, sequence, steps
    return replace(outcome, mesh_error=error.estimate(*by), hinge_error=error.hinge_errors(*by))


def _on(outcome: ImpactOutcome, plate: Plate, computed: Computed, part: float = 1.0) -> answers.ImpactAnswer:
    """Return the impact on another mesh.

    part: of its time step that is taken; see `with_errors`. Raises InputError for an impossible mesh.
    """
    from fem.run import impact

    fe_plan, end = outcome.fe_plan, error.judged_until(outcome.fe)
    answer = computed.get((plate.element, plate.counts, part))
    if answer is None or answer.history["t"][-1] + answer.interval < end:
        model, _ = plan.impact_model(fe_plan.case, plate, fe_plan.sample, part)
        impact.compile_impact_loop(model, on_compile=compiling)
        other_plan = replace(fe_plan, model=model, plate=plate)
        answer = _answer(other_plan, simulated(other_plan, end=end))
        if cut_alone(answer, outcome.fe):
            answer = _answer(other_plan, simulated(other_plan, end=BEYOND * end))
        computed[plate.element, plate.counts, part] = answer
    return answer


def cut_alone(answer: answers.ImpactAnswer, main: answers.ImpactAnswer) -> bool:
    """Return True for an incomplete strike on another mesh alone.

    All assessed strikes of the run itself are complete.
    """
    return any(strike.cut for strike in error.assessed_strikes(answer)) and not any(
        strike.cut for strike in error.assessed_strikes(main)
    )
