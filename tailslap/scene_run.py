"""The main job: rigid solution, mesh, finite-element run, comparison, checks, pictures, report."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from postprocess.comparison.metrics import Metrics
from postprocess.comparison.quantities import KEYS, relative_difference
from tailslap.case.corner.rigid import RigidStages
from tailslap.errors import InputError
from tailslap.files.checkpoints import next_checkpoint
from tailslap.planning.decide_damping import damping_is_open
from tailslap.planning.fe_plan import FePlan, make_fe_plan
from tailslap.progress import announced, compiling, progress_bar
from tailslap.verification.check import Check, history_metrics
from tailslap.verification.checks import error_of, ringing_checks, run_checks
from tailslap.verification.mechanics import energy_error
from tailslap.verification.numerical_error import (
    NumericalError,
    SecondRun,
    distance_in_motion,
    needs_second_run,
)
from tailslap.verification.ringing import CORRUPTED, friction_by_ringing
from tailslap.verification.second_mesh import damped_alike, damped_freely, on_mesh, second_meshes

if TYPE_CHECKING:
    from fem.run.corner import Run
    from tailslap.tolerance.choose import Choice


MORE_DAMPING = 4.0
"""Times the damping that was foreseen, for a run that rings with it."""


@dataclass(frozen=True)
class Outcome:
    """A finished run: what was computed, compared and checked.

    Attributes
    ----------
    fe_plan : FePlan
        What was integrated.
    run : Run
        History and state at the tail-slap.
    fe_history, rigid_history : dict of str to ndarray, shape (rows,)
        Columns by name, SI, at the same instants.
    rigid, fe, difference : dict of str to float
        The five quantities at the tail-slap, and fe/rigid - 1; `fe` and `difference` are empty without a tail-slap.
    checks : tuple of Check
        In the order of the report.
    setup_s : float
        Time that model and compilation took [s].
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
    choice : Choice or None
        What --tolerance picked.
    metrics : dict of str to Metrics
        Of FE histories against the rigid ones.
    """

    fe_plan: FePlan
    run: Run
    fe_history: dict[str, np.ndarray]
    rigid_history: dict[str, np.ndarray]
    rigid: dict[str, float]
    fe: dict[str, float]
    difference: dict[str, float]
    checks: tuple[Check, ...]
    setup_s: float
    error: NumericalError
    second: SecondRun | None = None
    attempts: int = 1
    pictures: tuple[Path, ...] = field(default=())
    pictures_s: float = 0.0
    choice: Choice | None = None
    metrics: dict[str, Metrics] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    @property
    def histories(self) -> dict[str, dict[str, np.ndarray]]:
        """Both histories by the names of their files."""
        return {"history.csv": self.fe_history, "rigid.csv": self.rigid_history}


def run_scene(plan: RigidStages) -> Outcome:
    """Run the scene's finite-element model and compare it with the rigid motion; writes nothing.

    A run that rings where the program may choose the damping is made once more, with more of it.

    Parameters
    ----------
    plan : RigidStages
        With [plate].

    Returns
    -------
    Outcome
        Also where checks failed: see `passed`.

    Raises
    ------
    InputError
        For keys that make no model, and for a start that the plate cannot have.
    """
    return confirmed(settled(plan))


def settled(plan: RigidStages) -> Outcome:
    """The outcome without a second run: made again with more damping where it rings and the program may choose that."""
    outcome = attempt(plan)
    if not (rings(outcome) and damping_is_open(plan.scene)):
        return outcome
    again = attempt(plan, MORE_DAMPING)
    return replace(again, setup_s=outcome.setup_s + again.setup_s, attempts=2)


def attempt(plan: RigidStages, more_damping: float = 1.0) -> Outcome:
    """A single run, compared with the rigid motion.

    Parameters
    ----------
    plan : RigidStages
        With [plate].
    more_damping : float
        Factor on the damping that the program chooses [-].

    Returns
    -------
    Outcome
        Without a second run.

    Raises
    ------
    InputError
        As `run_scene`.
    """
    began = time.perf_counter()
    with announced("Building the model ..."):
        from fem.run.corner import compile_loop

        fe_plan = make_fe_plan(plan, more_damping)
    compile_loop(fe_plan.model, fe_plan.start, fe_plan.case.scene.time.threads, told=compiling)
    setup = time.perf_counter() - began
    run = _simulated(fe_plan)
    return compare(fe_plan, run, setup + run.setup_s)


def _simulated(fe_plan: FePlan) -> Run:
    """The run of the model. Raises InputError for a start that the plate cannot have."""
    from fem.run.corner import simulate
    from fem.start.inertia_relief import TooSoftError

    scene, start = fe_plan.case.scene, fe_plan.plate.start
    try:
        with progress_bar(f"{scene.name}: steps", fe_plan.expected_steps) as progress:
            return simulate(
                fe_plan.model,
                fe_plan.start,
                fe_plan.case.motion.strike.t,
                kind=start,
                rows=scene.time.rows,
                threads=scene.time.threads,
                progress=progress,
                corrupted=lambda row: friction_by_ringing(fe_plan, row) > CORRUPTED,
                checkpoint=next_checkpoint(),
                snapshots=scene.kept_fields,
            )
    except TooSoftError:
        why = "the plate is too soft to be in equilibrium under its reaction"
        raise InputError("plate.start", start, f'{why}; allowed is "unstressed"') from None


def rings(outcome: Outcome) -> bool:
    """Whether a check says that the reaction rang, or the run came to no answer."""
    ringing = ringing_checks()
    return any(check.name in ringing and not check.passed for check in outcome.checks)


def compare(fe_plan: FePlan, run: Run, setup: float, second: SecondRun | None = None) -> Outcome:
    """Hold a run against the rigid motion and check it; setup: time [s] that its model took."""
    rigid = fe_plan.case.tail_slap
    fe = {name: run.strike.values[name] for name in KEYS} if run.strike else {}
    difference = relative_difference(fe, rigid) if fe else {}
    rigid_history = rigid_columns(fe_plan, run.history)
    with np.errstate(all="ignore"):  # a run that diverged is judged, not warned about
        fe_history = run.history | {"energy_error": energy_error(run.history)}
        checks = run_checks(fe_plan, run, rigid_history, difference, second)
        metrics = history_metrics(run.history, rigid_history)
        error = error_of(fe_plan, run, difference, second)
    return Outcome(
        fe_plan,
        run,
        fe_history,
        rigid_history,
        rigid,
        fe,
        difference,
        checks,
        setup,
        metrics=metrics,
        error=error,
        second=second,
    )


def confirmed(outcome: Outcome) -> Outcome:
    """The outcome with a second run of the plate beside it, where statics does not tell how far it may be off."""
    fe_plan = outcome.fe_plan
    if not outcome.fe or not needs_second_run(fe_plan, outcome.difference, outcome.error):
        return outcome
    second = second_run(outcome)
    judged = compare(fe_plan, outcome.run, outcome.setup_s, second)
    return replace(judged, attempts=outcome.attempts)


def second_run(outcome: Outcome) -> SecondRun:
    """A run of the same plate on another mesh, with the exact constraint; no differences where none can be made.

    It has the damping of the first run, or where it rings with that, what the program comes to for it; also where the
    scene forbids it, if the plate starts with the elastic state that damping leaves as it is.
    """
    fe_plan = outcome.fe_plan
    for plate in second_meshes(fe_plan):
        plan = on_mesh(fe_plan, plate)
        try:
            other = attempt(damped_alike(plan, fe_plan))
            if rings(other) and (damping_is_open(plan.scene) or plate.relieved):
                other = settled(damped_freely(plan))
        except InputError:
            continue
        mesh = f"{plate.element}, {plate.counts[0]} x {plate.counts[1]}"
        if not other.fe:
            return SecondRun(mesh, {})
        ours, its = ((run.fe_history, run.rigid_history) for run in (outcome, other))
        late, apart = (
            distance_in_motion(ours, its, outcome.rigid, oscillates)
            for oscillates in (False, not fe_plan.plate.relieved)
        )
        return SecondRun(mesh, other.difference, late, apart)
    return SecondRun("none", {})


def rigid_columns(fe_plan: FePlan, history: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
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
