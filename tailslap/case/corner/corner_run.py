"""A run of a constrained corner.

The plate runs beside the rigid motion, again with more damping where it oscillates, and on other meshes for the error.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fem.plate import kinds
from postprocess.comparison import quantities
from tailslap.case.case import MOST_ELEMENTS
from tailslap.case.check import evaluated
from tailslap.case.corner import decisions, numerical_error
from tailslap.case.corner.corner_checks import CHECKS, rings
from tailslap.case.corner.corner_plan import CornerPlan, make_corner_plan
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.case.plate_input import refined
from tailslap.errors import InputError
from tailslap.progress import announced, compiling, progress_bar
from tailslap.scene.model_tables import Plate
from tailslap.storage import checkpoints

if TYPE_CHECKING:
    from fem.run.corner import Run, Stepper
    from tailslap.case.corner.decisions import Growth

MORE_DAMPING = 4.0
"""Factor on the predicted damping after a run that oscillated."""

MOST_COMPANIONS = 2

HALVED = 16, 6
"""Least elements along and across of a mesh with a companion of half as many, which still resolves the support."""


def run_corner(case: RigidStages) -> CornerOutcome:
    """Run the plate and its companions beside the rigid motion with checks.

    A run that oscillates is repeated with more damping where the program may choose that. Raises InputError for keys
    that make no model, and for a start that the plate cannot have.
    """
    outcome = damped_run(case)
    return checked(with_companions(outcome) if outcome.fe and case.scene.verify.companion else outcome)


def damped_run(case: RigidStages) -> CornerOutcome:
    """Run the plate, and repeat an oscillating run with more damping.

    It is repeated where the damping is open. The outcome is not checked.
    """
    outcome = attempt(case)
    if not (decisions.damping_is_open(case.scene) and rings(outcome)):
        return outcome
    again = attempt(case, MORE_DAMPING)
    return replace(again, setup_s=outcome.setup_s + again.setup_s, attempts=2)


def checked(outcome: CornerOutcome) -> CornerOutcome:
    """Return the outcome with its checks."""
    return replace(outcome, checks=evaluated(CHECKS.values(), outcome))


def with_companions(outcome: CornerOutcome) -> CornerOutcome:
    """Return the outcome with companions.

    There is a second one where the first leaves an error above the allowed one.
    """
    for plate, refinement in companion_plates(outcome.fe_plan):
        additional = companion(outcome, plate, refinement)
        if additional is None or (refinement < 1.0 and not additional.difference):  # too coarse
            continue
        outcome = replace(outcome, companions=(*outcome.companions, additional))
        if outcome.error.total <= outcome.error.allowed or len(outcome.companions) == MOST_COMPANIONS:
            break
    return outcome


def companion_plates(fe_plan: CornerPlan) -> Iterator[tuple[Plate, float]]:
    """Yield plates of companions and their refinement.

    Half as many elements along both sides first, then more of them, and still more where half as many make no model.
    Where linear elements lock, elements of higher order, since two meshes that lock may agree.
    """
    plate, higher = fe_plan.plate, kinds.ELEMENT_KINDS[fe_plan.plate.element].higher_order
    if higher and not fe_plan.mesh.fine_enough:
        yield from ((refined(plate, factor, higher), 2.0 * factor) for factor in (1.0, 2.0))
        return
    is_large = 4 * math.prod(plate.counts) > MOST_ELEMENTS
    is_coarse = math.prod(plate.counts) < math.prod(HALVED) or min(plate.counts) < min(HALVED)
    factors = (2.0, 4.0) if is_coarse else (0.5, 0.25) if is_large else (0.5, 2.0, 4.0)
    yield from ((refined(plate, factor), factor) for factor in factors)


def companion(outcome: CornerOutcome, plate: Plate, refinement: float) -> numerical_error.Companion | None:
    """Run the companion of a run on the mesh of a plate.

    Returns None where it has no model. It has the damping of the run. Where it oscillates with that, or further than
    the run by friction, its damping is open if that of the scene is, or if the plate starts with the elastic state,
    which damping does not change.
    """
    fe_plan = outcome.fe_plan
    case = on_plate(fe_plan, plate)
    try:
        companion = attempt(with_damping_of(fe_plan, case), growth=fe_plan.growth)
        flutters = companion.rectified - outcome.rectified > numerical_error.FLOOR
        is_open = decisions.damping_is_open(fe_plan.original.scene) or plate.relieved
        if is_open and (rings(companion) or flutters):
            companion = damped_run(with_open_damping(case))
    except InputError:
        return None
    return compared(outcome, companion, refinement)


def compared(outcome: CornerOutcome, other: CornerOutcome, refinement: float) -> numerical_error.Companion:
    """Compare a run with another one as its companion.

    refinement: of the mesh of the other.
    """
    plate = other.fe_plan.plate
    mesh = f"{plate.element}, {plate.counts[0]} x {plate.counts[1]}"
    if not other.fe:
        return numerical_error.Companion(mesh, refinement, {})
    motions = (outcome.run.history, outcome.rigid_history), (other.run.history, other.rigid_history)
    apart = numerical_error.distance_in_motion(*motions, outcome.rigid, not outcome.relieved)
    return numerical_error.Companion(mesh, refinement, other.difference, apart)


def on_plate(fe_plan: CornerPlan, plate: Plate) -> RigidStages:
    """Return the case of a run on the mesh of another plate."""
    changes = {"plate.elements": plate.elements, "plate.element": plate.element, "plate.lumping": "exact"}
    constraint = {"corner.constraint": fe_plan.case.scene.corner.constraint, "output": None}
    return fe_plan.case.with_changes(changes | constraint)


def with_damping_of(fe_plan: CornerPlan, case: RigidStages) -> RigidStages:
    """Return the case with the damping of elastic velocities of a plan."""
    damping = fe_plan.model.parameters.elastic_damping
    if damping is not None:
        return case.with_changes({"damping.kind": "elastic-velocity", "damping.rate": damping.rate})
    return case if case.scene.damping else case.with_changes({"damping.kind": "none"})


def with_open_damping(case: RigidStages) -> RigidStages:
    """Return the case with open damping of elastic velocities.

    Damping in proportion to the stiffness remains.
    """
    damping = case.scene.damping
    if damping is None or damping.kind is None:
        return case
    kind_and_rate = {"damping.kind": None, "damping.rate": None}
    return case.with_changes(kind_and_rate if damping.ratio or damping.bulk_viscosity else {"damping": None})


def attempt(case: RigidStages, more_damping: float = 1.0, growth: Growth | None = None) -> CornerOutcome:
    """Run the plate once beside the rigid motion, without checks.

    more_damping, growth: see `make_corner_plan`. Raises InputError as `run_corner`.
    """
    began = time.perf_counter()
    with announced("Building the model ..."):
        from fem.run import corner

        fe_plan = make_corner_plan(case, more_damping, growth)
    stepper = corner.compile_loop(
        fe_plan.model, fe_plan.start, fe_plan.case.scene.time.threads, on_compile=compiling
    )
    setup = time.perf_counter() - began
    run = _simulated(fe_plan, stepper)
    return compare(fe_plan, run, setup + run.setup_s)


def _simulated(fe_plan: CornerPlan, stepper: Stepper) -> Run:
    """Integrate the model.

    Raises InputError for a start that the plate cannot have.
    """
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


def compare(fe_plan: CornerPlan, run: Run, setup: float) -> CornerOutcome:
    """Compare a run with the rigid motion.

    setup: time for its model [s].
    """
    rigid = fe_plan.case.tail_slap
    fe = {name: run.strike.values[name] for name in quantities.KEYS} if run.strike else {}
    difference = quantities.relative_difference(fe, rigid) if fe else {}
    columns = rigid_columns(fe_plan, run.history)
    return CornerOutcome(fe_plan, run, difference, (), setup, columns, rigid, fe)


def rigid_columns(
    fe_plan: CornerPlan, history: dict[str, NDArray[np.float64]]
) -> dict[str, NDArray[np.float64]]:
    """Return the rigid motion as history columns.

    The body has the mass of the plate. Instants after the end of the rigid motion are NaN; elastic energy and damping
    are 0.
    """
    mass = fe_plan.model.mass
    motion, instants = fe_plan.case.motion_of_mass(mass), history["t"]
    rows = instants <= motion.latest
    state = motion.at(instants[rows])
    columns = {}
    for name in history:
        columns[name] = np.full(instants.shape, np.nan)
        columns[name][rows] = getattr(state, name, 0.0)
    columns["t"] = instants
    columns["normal_impulse"] = mass * (columns["v_gy"] - columns["v_gy"][0])
    columns["normal_impulse_magnitude"] = np.abs(columns["normal_impulse"])
    columns["energy_error"] = 0.0 * columns["v_gy"]
    return columns
