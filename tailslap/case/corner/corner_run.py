"""A run of a constrained corner: the FE plate beside the rigid motion, made again where it rings, and companions."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fem.plate import kinds
from postprocess.comparison import quantities
from tailslap.case import plate_input
from tailslap.case.case import MOST_ELEMENTS, evaluated
from tailslap.case.corner import corner_checks, corner_plan, decisions, numerical_error
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.errors import InputError
from tailslap.progress import announced, compiling, progress_bar
from tailslap.scene.schema import Plate
from tailslap.storage import checkpoints

if TYPE_CHECKING:
    from fem.run.corner import Run, Stepper

MORE_DAMPING = 4.0
"""Times the damping that was foreseen, for a run that rings with it."""

MOST_COMPANIONS = 2

HALVED = 16, 6
"""Least elements along and across of a mesh whose companion has half as many: fewer do not resolve the support."""


def run_corner(case: RigidStages) -> CornerOutcome:
    """Run the plate, and its companions where the scene wants the error; compare with the rigid motion and check.

    A run that rings where the program may choose the damping is made once more, with more of it. Raises InputError for
    keys that make no model, and for a start that the plate cannot have.
    """
    outcome = settled(case)
    return judged(with_companions(outcome) if outcome.fe and case.scene.verify.companion else outcome)


def settled(case: RigidStages) -> CornerOutcome:
    """The outcome, not checked: made again with more damping where it rings and the program may choose that."""
    outcome = attempt(case)
    if not (decisions.damping_is_open(case.scene) and corner_checks.rings(outcome)):
        return outcome
    again = attempt(case, MORE_DAMPING)
    return replace(again, setup_s=outcome.setup_s + again.setup_s, attempts=2)


def judged(outcome: CornerOutcome) -> CornerOutcome:
    """The outcome with its checks."""
    return replace(outcome, checks=evaluated(corner_checks.CHECKS.values(), outcome))


def with_companions(outcome: CornerOutcome) -> CornerOutcome:
    """The outcome with companions: a second one where the first leaves an error above what is allowed."""
    for plate, refinement in companion_plates(outcome.fe_plan):
        made = companion(outcome, plate, refinement)
        if made is None or (refinement < 1.0 and not made.difference):  # too coarse
            continue
        outcome = replace(outcome, companions=(*outcome.companions, made))
        if outcome.error.total <= outcome.error.allowed or len(outcome.companions) == MOST_COMPANIONS:
            break
    return outcome


def companion_plates(fe_plan: corner_plan.CornerPlan) -> Iterator[tuple[Plate, float]]:
    """Plates of companions, to try in turn, and their refinement: half as many elements each way, then more of them;
    elements of higher order where linear ones lock, for two meshes that lock may agree."""
    plate, higher = fe_plan.plate, kinds.ELEMENT_KINDS[fe_plan.plate.element].higher_order
    if higher and fe_plan.locks:
        yield from ((plate_input.refined(plate, factor, higher), 2.0 * factor) for factor in (1.0, 2.0))
        return
    large = 4 * math.prod(plate.counts) > MOST_ELEMENTS
    few = math.prod(plate.counts) < math.prod(HALVED) or min(plate.counts) < min(HALVED)
    factors = (2.0, 4.0) if few else (0.5, 0.25) if large else (0.5, 2.0)
    yield from ((plate_input.refined(plate, factor), factor) for factor in factors)


def companion(outcome: CornerOutcome, plate: Plate, refinement: float) -> numerical_error.Companion | None:
    """The companion of a run on the mesh of this plate; None where none can be made.

    It has the damping of the run, or where it rings with that, what the program comes to for it; also where the scene
    forbids it, if the plate starts with the elastic state that damping leaves as it is.
    """
    fe_plan = outcome.fe_plan
    case = on_plate(fe_plan, plate)
    try:
        other = attempt(damped_alike(case, fe_plan))
        if (decisions.damping_is_open(fe_plan.asked.scene) or plate.relieved) and corner_checks.rings(other):
            other = settled(damped_freely(case))
    except InputError:
        return None
    mesh = f"{plate.element}, {plate.counts[0]} x {plate.counts[1]}"
    if not other.fe:
        return numerical_error.Companion(mesh, refinement, {})
    ours, its = ((run.run.history, run.rigid_history) for run in (outcome, other))
    apart = numerical_error.distance_in_motion(ours, its, outcome.rigid, not fe_plan.plate.relieved)
    return numerical_error.Companion(mesh, refinement, other.difference, apart)


def on_plate(fe_plan: corner_plan.CornerPlan, plate: Plate) -> RigidStages:
    """The case as it is run, on the mesh of this plate."""
    changes = {"plate.elements": plate.elements, "plate.element": plate.element, "plate.lumping": "exact"}
    constraint = {"corner.constraint": fe_plan.case.scene.corner.constraint, "output": None}
    return fe_plan.case.with_changes(changes | constraint)


def damped_alike(case: RigidStages, fe_plan: corner_plan.CornerPlan) -> RigidStages:
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


def attempt(case: RigidStages, more_damping: float = 1.0) -> CornerOutcome:
    """A single run beside the rigid motion, not checked; more_damping: factor on the damping that is chosen [-].

    Raises InputError as `run_corner`.
    """
    began = time.perf_counter()
    with announced("Building the model ..."):
        from fem.run import corner

        fe_plan = corner_plan.make_corner_plan(case, more_damping)
    stepper = corner.compile_loop(
        fe_plan.model, fe_plan.start, fe_plan.case.scene.time.threads, on_compile=compiling
    )
    setup = time.perf_counter() - began
    run = _simulated(fe_plan, stepper)
    return compare(fe_plan, run, setup + run.setup_s)


def _simulated(fe_plan: corner_plan.CornerPlan, stepper: Stepper) -> Run:
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
                progress=progress,
                make_stepper=lambda *_: stepper,
                corrupted=lambda row: (
                    numerical_error.friction_by_ringing(fe_plan, row) > numerical_error.CORRUPTED
                ),
                checkpoint=checkpoints.next_checkpoint(),
                snapshots=scene.kept_fields,
            )
    except TooSoftError:
        why = "the plate is too soft to be in equilibrium under its reaction"
        raise InputError("plate.start", start, f'{why}; allowed is "unstressed"') from None


def compare(fe_plan: corner_plan.CornerPlan, run: Run, setup: float) -> CornerOutcome:
    """Hold a run against the rigid motion; setup: time [s] that its model took."""
    rigid = fe_plan.case.tail_slap
    fe = {name: run.strike.values[name] for name in quantities.KEYS} if run.strike else {}
    difference = quantities.relative_difference(fe, rigid) if fe else {}
    columns = rigid_columns(fe_plan, run.history)
    return CornerOutcome(fe_plan, run, difference, (), setup, columns, rigid, fe)


def rigid_columns(fe_plan: corner_plan.CornerPlan, history: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
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
