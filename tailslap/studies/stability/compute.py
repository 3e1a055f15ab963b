"""The study `stability`: where the program is right, refuses, or catches itself.

A map varies two axes at a time and judges each cell against the rigid motion; where the two differ, a refined model
must differ likewise. With --random every quantity and choice of the scene is drawn at once, and a cell is judged by a
refined model of the same plate.
"""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from fem.plate.kinds import ELEMENT_KINDS
from postprocess.comparison.quantities import largest
from tailslap.campaign import engine
from tailslap.campaign.draws import draw
from tailslap.case import case_of
from tailslap.case.case import failed_names
from tailslap.case.corner import checks, run
from tailslap.case.corner.error import FLOOR, FRACTION, Histories, distance_in_motion
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.case.cost import expected_effort
from tailslap.case.impact import run as whole_impact
from tailslap.case.impact.answers import differences
from tailslap.case.impact.checks import failed_but_mesh
from tailslap.errors import InputError
from tailslap.scene.schema import Plate, Scene
from tailslap.scene.vary import Changes, Source, changed_tables, vary
from tailslap.studies.stability.axes import StudyAxis, axes_of, map_cells

Row = dict[str, Any]

# Kinds of verdicts and what they mean, of the map and of random cells.
RIGHT, FLEXIBLE, REFUSED, CAUGHT, WRONG = "right", "flexible", "refused", "caught", "wrong"
REACTION_ONLY, GOOD, UNJUDGED = "reaction only", "good but failed", "unjudged"
MAP_KINDS = {
    RIGHT: "as the rigid motion",
    FLEXIBLE: "not rigid, confirmed by refinement",
    REFUSED: "wrong input, no run",
    CAUGHT: "failed a check of its own",
    WRONG: "passed every check, and is not right",
}
RANDOM_KINDS = {
    RIGHT: "every check passed, and the five quantities are those of a refined model of the same plate",
    REACTION_ONLY: "right, but the reaction rings, and checks of its history alone say so",
    GOOD: "other checks failed although the five quantities, and the motion before, are right beyond doubt",
    CAUGHT: "a check failed, and the five quantities are off or in doubt",
    REFUSED: "wrong input: a message, and no run",
    UNJUDGED: "no refined model came to a result that can be trusted",
    WRONG: "every check passed, and the five quantities are off",
}

# A verdict. failed: names of the checks that failed; reason: otherwise why the cell is refused, wrong, or
# flexible. difference, reference: largest difference of the five quantities from the rigid motion, of the run
# and of the refined model; distance, allowed: between the two, and how large it may be; error: as the run
# itself estimates it. model, reference_model: elements.
UNKNOWN: Row = {"kind": "", "failed": "", "reason": "", "distance": math.nan, "allowed": math.nan}
UNKNOWN |= {"difference": math.nan, "reference": math.nan, "error": math.nan, "model": ""}
UNKNOWN |= {"reference_model": "", "steps": 0, "seconds": 0.0, "reference_seconds": 0.0}

# Fraction of a difference that refinement may change for it to count as the plate's own.
SURVIVES = 0.5

# Checks that a refined model may fail and still confirm the five quantities: if it is corrupted, it
# disagrees.
BESIDE_THE_POINT = {"reaction against rigid", "friction by ringing"}

# Distance from the reference above which a random cell is wrong: a part of its own, and a fraction of the
# reference's difference from the rigid motion.
WRONG_FROM = (1e-3, 0.25)

# The same for a result that is good beyond doubt: with the factor of safety on an error that two meshes tell
# (Roache 1994, ASME V&V 20) it would still be allowed.
GOOD_TO = (FLOOR / 3.0, FRACTION / 3.0)

# Times as fine as the cell's mesh, both ways, of the first reference and of a second one; elements, and
# expected seconds, of which a reference has no more.
FINER, FINEST, MAX_ELEMENTS, MAX_REFERENCE_S = 1.5, 2.0, 600, 4.0

# Stiffness-proportional damping against flutter, of the reference that is tried last.
FLUTTER_DAMPING = 0.05

# What damping and ringing may change in a reference: a part of its own, and a fraction of its flexibility.
SWAYED = (5e-4, 0.1)

# Checks that a reference must pass; its reaction may ring.
DEMANDED = {
    *("tail-slap reached", "finite numbers", "time step", "energy balance", "momentum balance"),
    *("friction by ringing", "oscillation", "mesh"),
    *("contact work", "friction law", "friction work", "friction takes energy"),
}


class StabilityResult(NamedTuple):
    """Cells by key: what each changes in the base, and its row: its place on the axes or all that was drawn, and the
    verdict. axes: of the map; none where cells are drawn. settings: points and tolerance, or the seed."""

    case: Any
    base: Source
    axes: tuple[StudyAxis, ...]
    settings: Mapping[str, float]
    kinds: Mapping[str, str]
    cells: Mapping[str, Changes]
    rows: Mapping[str, Row]
    seconds: float

    def of_kind(self, *kinds: str) -> dict[str, Row]:
        """The rows with one of these verdicts."""
        return {key: row for key, row in self.rows.items() if row["kind"] in kinds}


def compute(
    case: Any, place: Path, points: int | None, tolerance: Any, count: int | None, seed: int, workers: Any
) -> StabilityResult:
    """The map, or so many random cells; an interrupted campaign of the same scene goes on from its journal."""
    began, scene = time.perf_counter(), case.scene
    base, usual = base_source(scene), (6, 1e-2) if scene.contact else (10, 1e-3)
    if scene.contact and count:
        raise InputError("--random", count, "a whole impact has the map alone; leave it out")
    if count:
        axes: tuple[StudyAxis, ...] = ()
        settings: Row = {"seed": seed}  # their number is left out: more cells go on from those there are
        kinds = RANDOM_KINDS
        verify: Callable[[Any], Row] = against_reference
        cells, places = random_cells(scene, base, seed, count)
    else:
        settings = {"points": points or usual[0], "tolerance": tolerance or usual[1]}
        kinds, verify = MAP_KINDS, partial(against_rigid, tolerance=settings["tolerance"])
        axes = axes_of(scene, settings["points"])
        cells, places = map_cells(scene, axes)
    definition = {"study": "stability", "scene": base.given, **settings}
    parts = {key: (base, changes, verify) for key, changes in cells.items()}
    (found,) = engine.run_study(place, definition, [(judge, parts, f"{len(cells)} cells")], workers)
    rows = {key: places[key] | its for key, its in found.items()}
    return StabilityResult(case, base, axes, settings, kinds, cells, rows, time.perf_counter() - began)


def base_source(scene: Scene) -> Source:
    """Source of the cells: the scene in SI, without its wall, since slides differ."""
    return vary(Source.of(scene), {"wall": None})[1]


def judge(base: Source, changes: Changes, verify: Callable[[Any], Row]) -> Row:
    """The verdict on the scene with these changes: what became of its run, and of what `verify` holds it against."""
    began = time.perf_counter()
    try:
        outcome = case_of(*vary(base, changes)).run()
    except InputError as error:
        return verdict(REFUSED, reason=str(error))
    except Exception as error:  # whatever it is, a program that breaks has not refused
        return verdict(WRONG, reason=f"broke: {type(error).__name__}: {error}")
    seconds = time.perf_counter() - began
    try:
        found = verify(outcome)
    except Exception as error:  # the reference breaks, and with it the program
        found = verdict(WRONG, reason=f"reference broke: {type(error).__name__}: {error}")
    its = {"error": claimed_error(outcome), "model": model_name(outcome), "steps": outcome.run.steps}
    return found | its | {"seconds": seconds}


def verdict(kind: str, **known: Any) -> Row:
    """A verdict; NaN stands for what is not known."""
    return UNKNOWN | {"kind": kind, **known}


def is_impact(outcome: Any) -> bool:
    """True if it is of a whole impact."""
    return outcome.fe_plan.case.scene.contact is not None


def claimed_error(outcome: Any) -> float:
    """The largest error that the run says it has; of a whole impact in impulse and peak."""
    return float(_judged(outcome.mesh_error) if is_impact(outcome) else outcome.error.total)


def model_name(outcome: Any) -> str:
    """Elements of a run, like "quad9 20 x 6"."""
    plate = outcome.fe_plan.plate
    return f"{plate.element} {plate.counts[0]} x {plate.counts[1]}"


def against_rigid(outcome: Any, tolerance: float) -> Row:
    """The verdict; tolerance: difference from the rigid motion up to which the cell is right."""
    impact = is_impact(outcome)
    found = _judged(outcome.difference) if impact else largest(outcome.difference)
    if not outcome.passed:
        return verdict(CAUGHT, failed=", ".join(failed_names(outcome.checks)), difference=found)
    if found <= tolerance and (not impact or _corners_agree(outcome.fe, outcome.rigid)):
        return verdict(RIGHT, difference=found)
    # Statics bounds error and flexibility alike: with a bound that is wide, both are.
    if not impact and not outcome.error.total <= tolerance + SURVIVES * max(found, outcome.error.flexibility):
        why = f"its own numerical error is {outcome.error.total:.1e}"
        return verdict(WRONG, reason=why, difference=found)
    return _confirmed(outcome, found, tolerance)


def _confirmed(outcome: Any, found: float, tolerance: float) -> Row:
    """Flexible if the difference survives refinement, else wrong. A constrained corner tries until a refined model
    confirms it, a whole impact the first that comes to a result."""
    its_verdict = verdict(WRONG, reason="no refined model came to a result", difference=found)
    impact, allowed = is_impact(outcome), tolerance + claimed_error(outcome)
    case = outcome.fe_plan.case if impact else outcome.fe_plan.asked
    for name, changes in refinements(case.scene, outcome.fe_plan.plate).items():
        began, refined = time.perf_counter(), refined_run(case, changes)
        if refined is None:
            continue
        if impact:
            name, same = model_name(refined), _corners_agree(outcome.fe, refined.fe)
            moved = _judged(differences(outcome.fe, refined.fe)) if same else math.inf
            its = _judged(refined.difference)
        else:
            moved, its = distance(outcome.difference, refined.difference), largest(refined.difference)
            allowed = tolerance + SURVIVES * its
        kind, reason = (FLEXIBLE, name) if moved <= allowed else (WRONG, f"{name} changes it by {moved:.1e}")
        sizes = {"distance": moved, "allowed": allowed, "difference": found, "reference": its}
        its_verdict = verdict(kind, reason=reason, reference_model=name if impact else "", **sizes)
        its_verdict["reference_seconds"] = time.perf_counter() - began
        if impact or kind == FLEXIBLE:
            break
    return its_verdict


def refined_run(case: Any, changes: Changes) -> Any:
    """The outcome of a refined model; None where it says nothing."""
    impact = case.scene.contact is not None
    try:
        changed = case.varied(changes)
        refined: Any = whole_impact.attempt(changed) if impact else changed.run()
    except InputError:
        return None
    if impact:
        return None if failed_but_mesh(refined) else refined
    usable = set(failed_names(refined.checks)) <= BESIDE_THE_POINT
    return refined if usable and math.isfinite(largest(refined.difference)) else None


def refinements(scene: Scene, plate: Plate) -> dict[str, Changes]:
    """Models that a difference must survive, by name: twice the elements each way, half the time step, four times the
    corner's spring; with damping enough to keep that from fluttering; quadratic elements. plate: as it was run."""
    (along, across), higher_order = plate.counts, ELEMENT_KINDS[plate.element].higher_order
    finer: Row = {"plate.elements": (2 * along, 2 * across)}
    finer["time.safety_factor"] = 0.5 * scene.time.safety_factor
    if scene.contact:
        richer = {**finer, "plate.elements": plate.counts, "plate.element": higher_order}
        return {"richer": richer if higher_order else finer, "finer": finer}
    corner, ratio = scene.corner, (scene.damping.ratio if scene.damping else None) or 0.0
    finer["plate.element"] = plate.element
    if corner.constraint == "penalty" and not corner.constraint_is_open:
        finer["corner.penalty_scale"] = 4.0 * corner.penalty_scale
    times = 1 if higher_order else 2
    return {
        "finer": finer,
        "finer_and_damped": {"damping.ratio": max(FLUTTER_DAMPING, ratio), **finer},
        "richer": quadratic_and_exact(plate, (times * along, times * across)),
    }


def quadratic_and_exact(plate: Plate, counts: tuple[int, int]) -> Changes:
    """Changes to so many quadratic elements of the plate's kind, and the exact constraint."""
    return {
        **dict.fromkeys(("corner.penalty_scale", "corner.damping_ratio")),
        "corner.constraint": "exact",
        "plate.element": ELEMENT_KINDS[plate.element].higher_order or plate.element,
        "plate.elements": counts,
    }


def _corners_agree(*answers: Any) -> bool:
    """True if the first two strikes are of the same corners, so that all differences are told."""
    ours, its = ([strike.corner for strike in answer.strikes[:2]] for answer in answers)
    return ours == its


def _judged(found: Mapping[str, float]) -> float:
    """Largest difference in impulse and peak force of the first two strikes."""
    judged = [abs(value) for name, value in found.items() if name.endswith(("impulse", "peak_force"))]
    return max(judged, default=math.nan)


def distance(ours: Mapping[str, float], its: Mapping[str, float]) -> float:
    """Largest difference between two sets of quantities."""
    return max(abs(value - its[name]) for name, value in ours.items())


class Reference(NamedTuple):
    """Differences of a trustworthy refined model from the rigid motion; model: which it was; its histories, those of
    the plate and of the rigid body."""

    difference: Mapping[str, float]
    model: str
    seconds: float
    histories: Histories


def against_reference(outcome: CornerOutcome) -> Row:
    """The verdict; without a strike there is nothing to compare. Two references say what is good beyond doubt."""
    cell, plate = outcome.fe_plan.asked.source, outcome.fe_plan.plate
    first, failed = None, failed_names(outcome.checks)
    if outcome.fe:
        first = next(references(cell, plate, FINER), None)
    if first is None:
        return grade(outcome.difference, failed, None, math.nan)
    motion: Row = {"its": first.histories, "rigid": outcome.rigid, "oscillates": not plate.relieved}
    ours = outcome.fe_history, outcome.rigid_history
    found = grade(outcome.difference, failed, first, distance_in_motion(ours, **motion))
    if found["kind"] != GOOD:
        return found
    others = references(cell, plate, FINEST)
    second = next((other for other in others if other.model != first.model), None)
    off = math.inf
    if second:
        off = distance(second.difference, first.difference)
        off = max(distance_in_motion(second.histories, **motion), off)
    return found if off <= _limit(GOOD_TO, largest(first.difference)) else found | {"kind": CAUGHT}


def grade(
    difference: Mapping[str, float], failed: tuple[str, ...], reference: Reference | None, apart: float
) -> Row:
    """The verdict on a result, given as differences from the rigid motion; empty where there was no strike.

    apart: on the way; oscillations that agree at the strike alone are right by chance.
    """
    names, found = ", ".join(failed), largest(difference)
    if not math.isfinite(found):
        return verdict(CAUGHT if failed else WRONG, failed=names)
    if reference is None:
        return verdict(UNJUDGED, failed=names, difference=found)
    its, moved = largest(reference.difference), distance(difference, reference.difference)
    if not failed:
        kind = RIGHT if moved <= _limit(WRONG_FROM, its) else WRONG
    elif max(moved, apart) > _limit(GOOD_TO, its):
        kind = CAUGHT
    else:
        kind = GOOD if set(failed) - checks.reaction_checks() else REACTION_ONLY
    sizes = {"distance": moved, "allowed": _limit(WRONG_FROM, its), "difference": found, "reference": its}
    spent = {"reference_model": reference.model, "reference_seconds": reference.seconds}
    return verdict(kind, failed=names, **sizes, **spent)


def _limit(parts: tuple[float, float], reference: float) -> float:
    return parts[0] + parts[1] * reference


def references(cell: Source, plate: Plate, finest: float) -> Iterator[Reference]:
    """Models that come to a trustworthy result; plate: the cell's own, with what the program chose. Damping in
    proportion to the stiffness would take an unstressed plate's oscillation off."""
    began = time.perf_counter()
    damped = ((FINER, FLUTTER_DAMPING), (0.7, FLUTTER_DAMPING)) if plate.relieved else ()
    for finer, ratio in ((finest, 0.0), (1.0, 0.0), (0.7, 0.0), *damped):
        try:
            case: Any = case_of(*vary(cell, reference_changes(plate, finer, ratio)))
            if expected_effort(case.scene, case.duration).seconds > MAX_REFERENCE_S:
                continue
            outcome = run.judged(run.settled(case))
        except InputError:
            continue
        if trustworthy(outcome):
            name = model_name(outcome) + (", damped" if ratio else "")
            histories = outcome.fe_history, outcome.rigid_history
            yield Reference(outcome.difference, name, time.perf_counter() - began, histories)


def reference_changes(plate: Plate, finer: float, ratio: float = 0.0) -> Changes:
    """Changes that make a cell's scene the refined model, so much finer but of no more than MAX_ELEMENTS; ratio: of its
    damping, 0 to leave it to the program."""
    scale = min(finer, math.sqrt(MAX_ELEMENTS / math.prod(plate.counts)))
    along, across = (max(2, math.ceil(scale * count)) for count in plate.counts)
    return {
        **quadratic_and_exact(plate, (along, across)),
        **dict.fromkeys(("plate.lumping", "plate.distortion", "damping")),
        **({"damping.ratio": ratio} if ratio else {}),
    }


def trustworthy(outcome: CornerOutcome) -> bool:
    """True if the result can be taken for the truth about the plate. What an undamped run may show, an oscillation that
    friction has fed, a reference may not."""
    found, error = largest(outcome.difference), outcome.error
    swayed = not error.damping + outcome.ringing <= _limit(SWAYED, found)
    fed = any(check.name == "oscillation" and check.value > checks.OSCILLATES for check in outcome.checks)
    passed = DEMANDED.isdisjoint(failed_names(outcome.checks))
    return math.isfinite(found) and passed and not swayed and not fed


def random_cells(
    scene: Scene, base: Source, seed: int, count: int
) -> tuple[dict[str, Changes], dict[str, Row]]:
    """Changes of the first so many draws of a seed, and all values of their scenes."""
    cells = {f"{number:04d}": draw(scene, base, seed, number) for number in range(count)}
    tables = {key: changed_tables(base.given, changes)[0] for key, changes in cells.items()}
    return cells, {key: {"number": int(key), **flat(its)} for key, its in tables.items()}


def flat(tables: Mapping[str, Any]) -> Row:
    """Values of a scene by the full names of their keys, sorted."""
    inner = [(name, table) for name, table in tables.items() if isinstance(table, dict)]
    return dict(sorted((f"{name}.{key}", value) for name, table in inner for key, value in table.items()))
