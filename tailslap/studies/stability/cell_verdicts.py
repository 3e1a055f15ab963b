"""Verdicts on cells of the study.

Cells are compared with the rigid motion. Where they differ from it, a refined model must differ likewise. A random cell
of a constrained corner is compared with a refined model of the same plate.
"""

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from fem.plate.kinds import ELEMENT_KINDS
from postprocess.comparison.quantities import largest
from tailslap.campaign.records import Record
from tailslap.case import case_of
from tailslap.case.case import Outcome
from tailslap.case.check import failed_names
from tailslap.case.corner import corner_checks, corner_run
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.case.corner.numerical_error import FLOOR, FRACTION, Histories, distance_in_motion
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.case.impact import run as whole_impact
from tailslap.case.impact.answers import ImpactAnswer, differences
from tailslap.case.impact.checks import failed_but_mesh
from tailslap.case.impact.error import assessed_strikes
from tailslap.case.impact.plan import chosen_lengths, safety_factor
from tailslap.case.impact.rigid import RigidImpact
from tailslap.case.impact.run import ImpactOutcome
from tailslap.case.resources import expected_effort
from tailslap.errors import InputError
from tailslap.scene.model_tables import Plate
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, Source, vary

Verify = Callable[[Any], Record]
"""Function from the outcome of a cell to its verdict."""
RIGHT, FLEXIBLE, REFUSED, CAUGHT, WRONG = "right", "flexible", "refused", "caught", "wrong"
"""Kinds of verdicts."""
REACTION_ONLY, GOOD, UNJUDGED = "reaction only", "good but failed", "unjudged"
"""Further kinds of verdicts."""
MAP_KINDS = {
    RIGHT: "agrees with the rigid motion",
    FLEXIBLE: "flexibility effect, confirmed by refinement",
    REFUSED: "invalid input",
    CAUGHT: "rejected by a check",
    UNJUDGED: "omitted: estimated run time above limit",
    WRONG: "undetected error: passed every check",
}
"""Meanings of the verdicts of the map."""
RANDOM_KINDS = {
    RIGHT: "passed every check; the five quantities agree with a refined model",
    REACTION_ONLY: "correct, but the reaction rings and fails checks of its history",
    GOOD: "failed a check, although the five quantities and the motion are correct",
    CAUGHT: "failed a check; the five quantities are incorrect or uncertain",
    REFUSED: "invalid input",
    UNJUDGED: "no reliable refined model",
    WRONG: "undetected error: passed every check",
}
"""Meanings of the verdicts of random cells."""
UNKNOWN: Record = {
    **{"kind": "", "failed": "", "reason": ""},
    **dict.fromkeys(("distance", "allowed", "difference", "reference", "error"), math.nan),
    **{"model": "", "reference_model": "", "steps": 0},
    **{"seconds": 0.0, "reference_seconds": 0.0, "processor_seconds": 0.0},
}
"""Columns of a verdict, with the values of an unknown one.

`failed` lists the failed checks, and `reason` explains a cell that is refused, omitted, wrong or flexible.
`difference` and `reference` are the largest differences of the five quantities from the rigid motion, of the run and of
the refined model. `distance` is that between the two, and `allowed` its limit. `error` is that stated by the run.
`processor_seconds` include the reference and the planning.
"""
REFINEMENT_TOLERANCE = 0.5
"""Fraction of a difference that refinement may change if the difference is due to flexibility."""
WRONG_FROM = (1e-3, 0.25)
"""Distance from the reference above which a random cell is wrong, as absolute part and fraction of the flexibility."""
GOOD_TO = (FLOOR / 3.0, FRACTION / 3.0)
"""Distance up to which a result is correct with certainty, as parts of the same form.

The factor of safety is that of an error from two meshes (Roache 1994, ASME V&V 20).
"""
FIRST, SECOND, CONFIRMING = (1.5, 1.0, 0.7), (2.0, 1.0, 0.7), (2.0, 1.5)
"""Refinement factors of models that are tried in turn.

They are for the first and second reference of a random cell, and for the confirmation of a cell of the map.
"""
MAX_ELEMENTS, MAX_REFERENCE_S, LONGEST_S = 600, 4.0, 100.0
"""Most elements of a reference, and longest expected time loops of a reference and of any run [s]."""
FLUTTER_DAMPING = 0.05
"""Damping ratio against flutter of the last reference."""
REFERENCE_TOLERANCE = (5e-4, 0.1)
"""Largest effect of damping and ringing on a reference, as absolute part and fraction of its flexibility."""
REQUIRED_CHECKS = {
    *("tail-slap reached", "finite numbers", "time step", "energy balance", "momentum balance"),
    *("friction by ringing", "oscillation"),
    *("contact work", "friction law", "friction work", "friction takes energy"),
}
"""Checks that a reference must pass, although its reaction may ring."""


def judge(base: Source, changes: Changes, verify: Verify) -> Record:
    """Return the verdict on a cell and its processor time."""
    began = time.process_time()
    row = _judged_cell(base, changes, verify)
    return row | {"processor_seconds": time.process_time() - began}


def _judged_cell(base: Source, changes: Changes, verify: Verify) -> Record:
    """Run a cell and return its verdict."""
    began = time.perf_counter()
    try:
        case: Any = case_of(*vary(base, changes))
        if (expected := case.plan().expected_seconds) > LONGEST_S:
            return verdict(UNJUDGED, reason=f"estimated time of the time loop {expected:.0f} s")
        outcome = case.run()
    except InputError as error:
        return verdict(REFUSED, reason=str(error))
    except Exception as error:  # any other error is a fault of the program
        return verdict(WRONG, reason=f"broke: {type(error).__name__}: {error}")
    seconds = time.perf_counter() - began
    try:
        row = verify(outcome)
    except Exception as error:  # a reference that breaks is a fault of the program
        row = verdict(WRONG, reason=f"reference broke: {type(error).__name__}: {error}")
    run_values = {"error": claimed_error(outcome), "model": model_name(outcome), "steps": outcome.run.steps}
    return row | run_values | {"seconds": seconds}


def verdict(kind: str, **values: Any) -> Record:
    """Return a verdict, with NaN for unknown values."""
    return UNKNOWN | {"kind": kind, **values}


def is_impact(outcome: Outcome) -> bool:
    """Return True for the outcome of a whole impact."""
    return bool(outcome.fe_plan.case.scene.contact)


def claimed_error(outcome: Any) -> float:
    """Return the largest stated error of a run.

    Of a whole impact, it is that of impulse and peak force.
    """
    return float(_largest(outcome.mesh_error) if is_impact(outcome) else outcome.error.total)


def model_name(outcome: Outcome) -> str:
    """Return the elements of a run, such as "quad9 20 x 6"."""
    plate = outcome.fe_plan.plate
    return f"{plate.element} {plate.counts[0]} x {plate.counts[1]}"


def against_rigid(outcome: Any, tolerance: float) -> Record:
    """Return the verdict by the rigid motion.

    A cell is right up to the tolerance.
    """
    impact = is_impact(outcome)
    difference = _judged(outcome.difference, outcome.fe) if impact else largest(outcome.difference)
    if not outcome.passed:
        return verdict(CAUGHT, failed=", ".join(failed_names(outcome.checks)), difference=difference)
    if difference <= tolerance and (not impact or _corners_agree(outcome.fe, outcome.rigid)):
        return verdict(RIGHT, difference=difference)
    # The same bound limits error and flexibility, so that both are large where it is wide.
    if not impact and not outcome.error.total <= tolerance + REFINEMENT_TOLERANCE * max(
        difference, outcome.error.flexibility
    ):
        reason = f"the numerical error is {outcome.error.total:.1e}"
        return verdict(WRONG, reason=reason, difference=difference)
    return (_impact_confirmed if impact else _confirmed)(outcome, difference, tolerance)


def _confirmed(outcome: CornerOutcome, difference: float, tolerance: float) -> Record:
    """Return flexible if the difference survives refinement, else wrong."""
    reference = next(references(outcome.fe_plan, CONFIRMING, LONGEST_S), None)
    if reference is None:
        return verdict(WRONG, reason="no refined model has a result", difference=difference)
    flexibility = largest(reference.difference)
    change = distance(outcome.difference, reference.difference)
    row = _survived(change, tolerance + REFINEMENT_TOLERANCE * flexibility, reference.model)
    return row | {"difference": difference, "reference": flexibility, **reference.columns()}


def _impact_confirmed(outcome: ImpactOutcome, difference: float, tolerance: float) -> Record:
    """Return flexible if a refined impact differs likewise, else wrong."""
    began, case, plate = time.perf_counter(), outcome.fe_plan.case, outcome.fe_plan.plate
    models = (refined_impact(case, changes) for changes in refinements(case.scene, plate))
    refined = next(filter(None, models), None)
    if refined is None:
        return verdict(WRONG, reason="no refined model has a result", difference=difference)
    name, corners_agree = model_name(refined), _corners_agree(outcome.fe, refined.fe)
    change = _judged(differences(outcome.fe, refined.fe), outcome.fe) if corners_agree else math.inf
    reference = {"reference_model": name, "reference_seconds": time.perf_counter() - began}
    row = _survived(change, tolerance + claimed_error(outcome), name)
    return row | {"difference": difference, "reference": _judged(refined.difference, refined.fe), **reference}


def _survived(change: float, allowed: float, model: str) -> Record:
    """Return flexible for an allowed change by refinement."""
    kind, reason = (FLEXIBLE, model) if change <= allowed else (WRONG, f"{model} differs by {change:.1e}")
    return verdict(kind, reason=reason, distance=change, allowed=allowed)


def refined_impact(case: RigidImpact, changes: Changes) -> ImpactOutcome | None:
    """Return the outcome of a refined whole impact.

    It is None for an invalid or failed model.
    """
    try:
        refined = whole_impact.attempt(case.varied(changes))
    except InputError:
        return None
    return None if failed_but_mesh(refined) else refined


def refinements(scene: Scene, plate: Plate) -> list[Changes]:
    """Return the changes to refined models of a whole impact.

    They have half the time step and quadratic instead of linear elements, or twice the elements per direction, with
    forces over the lengths of the run. `plate` is the plate of the run.
    """
    (along, across), higher_order = plate.counts, ELEMENT_KINDS[plate.element].higher_order
    fixed = {"time.safety_factor": 0.5 * safety_factor(scene, plate), **chosen_lengths(scene)}
    quadratic = {"plate.elements": plate.counts, "plate.element": higher_order, **fixed}
    finer = {"plate.elements": (2 * along, 2 * across), "plate.element": plate.element, **fixed}
    return [quadratic, finer] if higher_order else [finer]


def _corners_agree(*answers: ImpactAnswer) -> bool:
    """Return True if the strikes are at the same corners."""
    first, second = ([strike.corner for strike in answer.strikes[:2]] for answer in answers)
    return first == second


def _judged(difference: Mapping[str, float], answer: ImpactAnswer) -> float:
    """Return the largest difference with a stated error."""
    stated = {f"strike_{1 + answer.strikes.index(strike)}" for strike in assessed_strikes(answer)}
    return _largest({name: value for name, value in difference.items() if name.partition(".")[0] in stated})


def _largest(difference: Mapping[str, float]) -> float:
    """Return the largest of impulse and peak force."""
    sizes = [abs(value) for name, value in difference.items() if name.endswith(("impulse", "peak_force"))]
    return max(sizes, default=math.nan)


def distance(first: Mapping[str, float], second: Mapping[str, float]) -> float:
    """Return the largest difference between two sets of quantities."""
    return max(abs(value - second[name]) for name, value in first.items())


class Reference(NamedTuple):
    """Differences of a trustworthy refined model from the rigid motion.

    `model` names its elements, and `histories` are those of plate and rigid body.
    """

    difference: Mapping[str, float]
    model: str
    seconds: float
    histories: Histories

    def columns(self) -> Record:
        """Return the columns of the model in a verdict."""
        return {"reference_model": self.model, "reference_seconds": self.seconds}


def against_reference(outcome: CornerOutcome) -> Record:
    """Return the verdict by refined models.

    Two references identify results that are correct with certainty.
    """
    fe_plan = outcome.fe_plan
    first, failed = None, failed_names(outcome.checks)
    if outcome.fe:
        first = next(references(fe_plan, FIRST), None)
    if first is None:
        return grade(outcome.difference, failed, None, math.nan)
    oscillates = not fe_plan.plate.relieved
    from_first = partial(
        distance_in_motion, companion=first.histories, rigid=outcome.rigid, oscillates=oscillates
    )
    row = grade(outcome.difference, failed, first, from_first((outcome.fe_history, outcome.rigid_history)))
    if row["kind"] != GOOD:
        return row
    more_references = references(fe_plan, SECOND)
    second = next((other for other in more_references if other.model != first.model), None)
    apart = math.inf
    if second:
        apart = distance(second.difference, first.difference)
        apart = max(from_first(second.histories), apart)
    return row if apart <= _limit(GOOD_TO, largest(first.difference)) else row | {"kind": CAUGHT}


def grade(
    difference: Mapping[str, float], failed: tuple[str, ...], reference: Reference | None, apart: float
) -> Record:
    """Return the verdict on a result by its differences.

    The differences are empty without a tail-slap. `apart` is the distance during the motion, since oscillations that
    agree at the tail-slap alone are right by chance.
    """
    names, flexibility = ", ".join(failed), largest(difference)
    if not math.isfinite(flexibility):
        return verdict(CAUGHT if failed else WRONG, failed=names)
    if reference is None:
        return verdict(UNJUDGED, failed=names, difference=flexibility)
    refined, change = largest(reference.difference), distance(difference, reference.difference)
    allowed = _limit(WRONG_FROM, refined)
    if not failed:
        kind = RIGHT if change <= allowed else WRONG
    elif max(change, apart) > _limit(GOOD_TO, refined):
        kind = CAUGHT
    else:
        kind = GOOD if set(failed) - corner_checks.reaction_checks() else REACTION_ONLY
    sizes = {"distance": change, "allowed": allowed, "difference": flexibility, "reference": refined}
    return verdict(kind, failed=names, **sizes, **reference.columns())


def _limit(parts: tuple[float, float], reference: float) -> float:
    """Return a limit from its absolute and relative parts."""
    return parts[0] + parts[1] * reference


def references(
    cell: CornerPlan, factors: Sequence[float], longest: float = MAX_REFERENCE_S
) -> Iterator[Reference]:
    """Yield trustworthy refined models within the expected time [s].

    `factors` are the refinements of the cell. Stiffness-proportional damping is tried last, and not for an unstressed
    start, whose oscillation it would damp.
    """
    began = time.perf_counter()
    models = [(factor, 0.0) for factor in factors]
    if cell.plate.relieved:
        models += [(factor, FLUTTER_DAMPING) for factor in dict.fromkeys((FIRST[0], factors[-1]))]
    for finer, ratio in models:
        try:
            case = cell.original.varied(reference_changes(cell.original.scene, cell.plate, finer, ratio))
            if expected_effort(case.scene, case.duration).seconds > longest:
                continue
            outcome = corner_run.checked(corner_run.damped_run(case))
        except InputError:
            continue
        if trustworthy(outcome):
            name = model_name(outcome) + (", damped" if ratio else "")
            histories = outcome.fe_history, outcome.rigid_history
            yield Reference(outcome.difference, name, time.perf_counter() - began, histories)


def reference_changes(scene: Scene, plate: Plate, finer: float, ratio: float = 0.0) -> Changes:
    """Return the changes to a refined model of a cell.

    It has at most MAX_ELEMENTS. A constraint of the scene becomes the exact one, and an open one remains open, since
    some plates flutter with the exact one. `plate` is the plate of the run, and `ratio` its damping, 0 for the choice
    of the program.
    """
    scale = min(finer, math.sqrt(MAX_ELEMENTS / math.prod(plate.counts)))
    along, across = (max(2, math.ceil(scale * count)) for count in plate.counts)
    changes: Record = dict.fromkeys(("plate.lumping", "plate.distortion", "damping"))
    changes["plate.element"] = ELEMENT_KINDS[plate.element].higher_order or plate.element
    changes["plate.elements"] = along, across
    if not scene.corner.constraint_is_open:
        changes |= dict.fromkeys(("corner.penalty_scale", "corner.damping_ratio"))
        changes["corner.constraint"] = "exact"
    return changes | ({"damping.ratio": ratio} if ratio else {})


def trustworthy(outcome: CornerOutcome) -> bool:
    """Return True if the result can serve as a reference.

    An oscillation fed by friction, which an undamped run may show, is not allowed.
    """
    flexibility, error = largest(outcome.difference), outcome.error
    affected = not error.damping + outcome.ringing <= _limit(REFERENCE_TOLERANCE, flexibility)
    fed = any(
        check.name == "oscillation" and check.value > corner_checks.OSCILLATES for check in outcome.checks
    )
    passed = REQUIRED_CHECKS.isdisjoint(failed_names(outcome.checks))
    return math.isfinite(flexibility) and passed and not affected and not fed
