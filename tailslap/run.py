"""The main job: rigid solution, mesh, finite-element run, comparison, checks, pictures, report."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from postprocess.comparison import relative_difference
from postprocess.metrics import Metrics
from postprocess.report import Check
from tailslap.checks import SPOILT, energy_error, friction_by_ringing, run_checks
from tailslap.fe_plan import FePlan, make_fe_plan
from tailslap.plan import Plan
from tailslap.practice import history_metrics
from tailslap.progress import announced, progress_bar
from tailslap.rigid import COMPARED, stage_two_numbers

if TYPE_CHECKING:
    from fem.simulate import Run
    from tailslap.tolerance.choose import Choice


@dataclass(frozen=True)
class Outcome:
    """A finished run: what was computed, compared and checked. `fe` and `difference` are empty without a strike."""

    fe_plan: FePlan
    run: Run
    fe_history: dict[str, np.ndarray]
    rigid_history: dict[str, np.ndarray]
    rigid: dict[str, float]
    fe: dict[str, float]
    difference: dict[str, float]
    checks: tuple[Check, ...]
    setup_s: float
    pictures: tuple[Path, ...] = field(default=())
    pictures_s: float = 0.0
    choice: Choice | None = None  # what --tolerance picked
    metrics: dict[str, Metrics] = field(default_factory=dict)  # of FE histories against the rigid ones

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)


def run_scene(plan: Plan) -> Outcome:
    """Run the scene's finite-element model and hold it against the rigid motion; writes nothing."""
    began = time.perf_counter()
    with announced("Building the model, or compiling the time loop: once on this machine, about 20 s ..."):
        from fem.simulate import compile_loop, simulate

        fe_plan = make_fe_plan(plan)
        compile_loop(fe_plan.model, fe_plan.start, plan.scene.time.threads)
    setup = time.perf_counter() - began
    scene, duration = plan.scene, plan.motion.strike.t
    with progress_bar(f"{scene.name}: {fe_plan.expected_steps} steps") as progress:
        run = simulate(
            fe_plan.model,
            fe_plan.start,
            duration,
            kind=fe_plan.plate.start,
            rows=scene.time.rows,
            threads=scene.time.threads,
            progress=progress,
            spoilt=lambda row: friction_by_ringing(fe_plan, row) > SPOILT,
        )
    return compare(fe_plan, run, setup)


def compare(fe_plan: FePlan, run: Run, setup: float) -> Outcome:
    """Hold a run against the rigid motion and check it; setup: time [s] that its model took."""
    rigid = stage_two_numbers(fe_plan.plan)
    fe = {name: run.strike.values[name] for name in COMPARED} if run.strike else {}
    difference = relative_difference(fe, rigid) if fe else {}
    rigid_history = rigid_columns(fe_plan, run.history)
    with np.errstate(all="ignore"):  # a run that diverged is judged, not warned about
        fe_history = run.history | {"energy_error": energy_error(run.history)}
        checks = run_checks(fe_plan, run, rigid_history, difference)
        metrics = history_metrics(run.history, rigid_history)
    return Outcome(
        fe_plan, run, fe_history, rigid_history, rigid, fe, difference, checks, setup, metrics=metrics
    )


def rigid_columns(fe_plan: FePlan, history: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The rigid solution of a body with the plate's mass, at the run's instants and by the same names.

    Instants past the end of the rigid motion are NaN. A rigid body has no elastic energy and no damping.
    """
    mass = fe_plan.model.mass
    motion, instants = fe_plan.plan.motion_of_mass(mass), history["t"]
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
