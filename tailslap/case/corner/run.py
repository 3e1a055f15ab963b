"""A run of a constrained corner: the FE plate beside the rigid motion, made again where it rings, and a second run."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.comparison import quantities
from postprocess.comparison.quantities import Metrics
from tailslap.case import model
from tailslap.case.case import Outcome, evaluated
from tailslap.case.corner import decisions, error, plan
from tailslap.case.corner.checks import CHECKS, Evidence, energy_error, ringing_checks
from tailslap.case.corner.error import NumericalError, SecondRun
from tailslap.case.corner.plan import CornerPlan
from tailslap.case.corner.rigid import RigidStages
from tailslap.errors import InputError
from tailslap.files import checkpoints
from tailslap.progress import announced, compiling, progress_bar
from tailslap.scene.schema import Plate

if TYPE_CHECKING:
    from fem.run.corner import Run

MORE_DAMPING = 4.0
"""Times the damping that was foreseen, for a run that rings with it."""


@dataclass(frozen=True)
class CornerOutcome(Outcome):
    """A finished run of a constrained corner.

    Attributes
    ----------
    fe_history, rigid_history : dict of str to ndarray, shape (rows,)
        Columns by name, SI, at the same instants.
    rigid, fe : dict of str to float
        The five quantities at the tail-slap; `fe`, and `difference`, are empty without a tail-slap.
    metrics : dict of str to Metrics
        Of FE histories against the rigid ones.
    error : NumericalError
        How far the run may be from its own limit of fine meshes.
    second : SecondRun or None
        A run on another mesh that the error was judged by.
    attempts : int
        2 where the first run rang.
    pictures : tuple of Path
        Contour pictures.
    pictures_s : float
        Time that the pictures took [s].
    """

    fe_plan: CornerPlan
    run: Run
    fe_history: dict[str, np.ndarray]
    rigid_history: dict[str, np.ndarray]
    rigid: dict[str, float]
    fe: dict[str, float]
    metrics: dict[str, Metrics]
    error: NumericalError
    second: SecondRun | None = None
    attempts: int = 1
    pictures: tuple[Path, ...] = ()
    pictures_s: float = 0.0


def run_corner(case: RigidStages) -> CornerOutcome:
    """Run the plate and compare it with the rigid motion, with a second run where statics does not tell the error.

    A run that rings where the program may choose the damping is made once more, with more of it. Raises InputError for
    keys that make no model, and for a start that the plate cannot have.
    """
    outcome = settled(case)
    if not outcome.fe or not error.needs_second_run(outcome.fe_plan, outcome.difference, outcome.error):
        return outcome
    judged = compare(outcome.fe_plan, outcome.run, outcome.setup_s, second_run(outcome))
    return replace(judged, attempts=outcome.attempts)


def settled(case: RigidStages) -> CornerOutcome:
    """The outcome without a second run: made again with more damping where it rings and the program may choose that."""
    outcome = attempt(case)
    if not (rings(outcome) and decisions.damping_is_open(case.scene)):
        return outcome
    again = attempt(case, MORE_DAMPING)
    return replace(again, setup_s=outcome.setup_s + again.setup_s, attempts=2)


def attempt(case: RigidStages, more_damping: float = 1.0) -> CornerOutcome:
    """A single run, compared with the rigid motion; more_damping: factor on the damping that the program chooses [-].

    Raises InputError as `run_corner`.
    """
    began = time.perf_counter()
    with announced("Building the model ..."):
        from fem.run import corner

        fe_plan = plan.make_corner_plan(case, more_damping)
    corner.compile_loop(fe_plan.model, fe_plan.start, fe_plan.case.scene.time.threads, on_compile=compiling)
    setup = time.perf_counter() - began
    run = _simulated(fe_plan)
    return compare(fe_plan, run, setup + run.setup_s)


def _simulated(fe_plan: CornerPlan) -> Run:
    """The run of the model. Raises InputError for a start that the plate cannot have."""
    from fem.run import corner
    from fem.start.inertia_relief import TooSoftError

    scene, start = fe_plan.case.scene, fe_plan.plate.start
    try:
        with progress_bar(f"{scene.name}: steps", fe_plan.expected_steps) as progress:
            return corner.simulate(
                fe_plan.model,
                fe_plan.start,
                fe_plan.case.duration,
                kind=start,
                rows=scene.time.rows,
                threads=scene.time.threads,
                progress=progress,
                corrupted=lambda row: error.friction_by_ringing(fe_plan, row) > error.CORRUPTED,
                checkpoint=checkpoints.next_checkpoint(),
                snapshots=scene.kept_fields,
            )
    except TooSoftError:
        why = "the plate is too soft to be in equilibrium under its reaction"
        raise InputError("plate.start", start, f'{why}; allowed is "unstressed"') from None


def rings(outcome: CornerOutcome) -> bool:
    """True where a check says that the reaction rang, or the run came to no answer."""
    ringing = ringing_checks()
    return any(check.name in ringing and not check.passed for check in outcome.checks)


def compare(fe_plan: CornerPlan, run: Run, setup: float, second: SecondRun | None = None) -> CornerOutcome:
    """Hold a run against the rigid motion and check it; setup: time [s] that its model took."""
    rigid = fe_plan.case.tail_slap
    fe = {name: run.strike.values[name] for name in quantities.KEYS} if run.strike else {}
    rigid_history = rigid_columns(fe_plan, run.history)
    differences = quantities.relative_difference(fe, rigid) if fe else {}
    evidence = Evidence(fe_plan, run, rigid_history, differences, second)
    with np.errstate(all="ignore"):  # a run that diverged is judged, not warned about
        return CornerOutcome(
            fe_plan=fe_plan,
            run=run,
            difference=evidence.differences,
            checks=evaluated(CHECKS.values(), evidence),
            setup_s=setup,
            fe_history=run.history | {"energy_error": energy_error(run.history)},
            rigid_history=rigid_history,
            rigid=rigid,
            fe=fe,
            metrics=evidence.metrics,
            error=evidence.error,
            second=second,
        )


def second_run(outcome: CornerOutcome) -> SecondRun:
    """A run of the same plate on another mesh, with the exact constraint; no differences where none can be made.

    It has the damping of the first run, or where it rings with that, what the program comes to for it; also where the
    scene forbids it, if the plate starts with the elastic state that damping leaves as it is.
    """
    fe_plan = outcome.fe_plan
    for plate in model.second_plates(fe_plan.plate):
        case = on_plate(fe_plan, plate)
        try:
            other = attempt(damped_alike(case, fe_plan))
            if rings(other) and (decisions.damping_is_open(case.scene) or plate.relieved):
                other = settled(damped_freely(case))
        except InputError:
            continue
        mesh = f"{plate.element}, {plate.counts[0]} x {plate.counts[1]}"
        if not other.fe:
            return SecondRun(mesh, {})
        ours, its = ((run.fe_history, run.rigid_history) for run in (outcome, other))
        late = error.distance_in_motion(ours, its, outcome.rigid, False)
        apart = error.distance_in_motion(ours, its, outcome.rigid, not fe_plan.plate.relieved)
        return SecondRun(mesh, other.difference, late, apart)
    return SecondRun("none", {})


def on_plate(fe_plan: CornerPlan, plate: Plate) -> RigidStages:
    """The case as asked for on the mesh of this plate, the exact constraint in place of a spring that is given."""
    changes: dict[str, Any] = {"plate.elements": plate.elements, "plate.element": plate.element}
    changes |= {"plate.distortion": 0.0, "plate.lumping": "exact", "output": None}
    if not fe_plan.asked.scene.corner.constraint_is_open:
        changes |= {"corner.constraint": "exact", "corner.penalty_scale": None, "corner.damping_ratio": None}
    return fe_plan.asked.with_changes(changes)


def damped_alike(case: RigidStages, fe_plan: CornerPlan) -> RigidStages:
    """The case with the elastic velocities damped as in this run."""
    damping = fe_plan.model.loop.elastic_damping
    if damping is not None:
        return case.with_changes({"damping.kind": "elastic-velocity", "damping.rate": damping.rate})
    return case if case.scene.damping else case.with_changes({"damping.kind": "none"})


def damped_freely(case: RigidStages) -> RigidStages:
    """The case with its damping left to the program, but for what is in proportion to the stiffness."""
    damping = case.scene.damping
    if damping is None or damping.kind is None:
        return case
    own = {"damping.kind": None, "damping.rate": None}
    return case.with_changes(own if damping.ratio or damping.bulk_viscosity else {"damping": None})


def rigid_columns(fe_plan: CornerPlan, history: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The rigid solution of a body with the plate's mass, at the run's instants and by the same names.

    Instants past the end of the rigid motion are NaN. A rigid body has no elastic energy and no damping.
    """
    mass = fe_plan.model.mass
    motion, instants = fe_plan.case.motion_of_mass(mass), history["t"]
    known = instants <= motion.latest
    state = motion.at(instants[known])
    columns = {}
    for name in history:
        columns[name] = np.full(instants.shape, np.nan)
        columns[name][known] = getattr(state, name, 0.0)
    columns["t"] = instants
    columns["normal_impulse"] = mass * (columns["v_gy"] - columns["v_gy"][0])
    columns["normal_impulse_magnitude"] = np.abs(columns["normal_impulse"])
    columns["energy_error"] = 0.0 * columns["v_gy"]
    return columns
