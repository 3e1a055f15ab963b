"""The study `stability`: where the program is right, refuses, or catches itself.

A map varies two axes at a time and judges each cell against the rigid motion; where the two differ, a refined model
must differ likewise. A cell whose run would take too long is left out, and counted. With --random every quantity and
choice of the scene is drawn at once, and a cell is judged by a refined model of the same plate; of a whole impact every
quantity of each unit, about the scene's own, and a cell is judged as on the map.
"""

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from tailslap.case.corner.plan import CornerPlan
from tailslap.case.cost import expected_effort
from tailslap.case.impact import run as whole_impact
from tailslap.case.impact.answers import ImpactAnswer, differences
from tailslap.case.impact.checks import failed_but_mesh
from tailslap.case.impact.error import weighed
from tailslap.errors import InputError
from tailslap.scene.schema import Plate, Scene
from tailslap.scene.vary import Changes, Source, changed_tables, vary
from tailslap.studies.stability.axes import StudyAxis, axes_of, map_cells

Row = dict[str, Any]

# Kinds of verdicts and what they mean, of the map and of random cells.
RIGHT, FLEXIBLE, REFUSED, CAUGHT, WRONG = "right", "flexible", "refused", "caught", "wrong"
REACTION_ONLY, GOOD, UNJUDGED = "reaction only", "good but failed", "unjudged"
MAP_KINDS = {
    RIGHT: "agrees with the rigid motion",
    FLEXIBLE: "flexibility effect, confirmed by refinement",
    REFUSED: "invalid input",
    CAUGHT: "rejected by a check",
    UNJUDGED: "omitted: estimated run time above limit",
    WRONG: "undetected error: passed every check",
}
RANDOM_KINDS = {
    RIGHT: "passed every check; the five quantities agree with a refined model",
    REACTION_ONLY: "correct, but the reaction rings and fails checks of its history",
    GOOD: "failed a check, although the five quantities and the motion are correct",
    CAUGHT: "failed a check; the five quantities are incorrect or uncertain",
    REFUSED: "invalid input",
    UNJUDGED: "no reliable refined model",
    WRONG: "undetected error: passed every check",
}

# A verdict. failed: names of the checks that failed; reason: otherwise why the cell is refused, left out, wrong,
# or flexible. difference, reference: largest difference of the five quantities from the rigid motion, of the run
# and of the refined model; distance, allowed: between the two, and how large it may be; error: as the run
# itself estimates it. model, reference_model: elements. processor_seconds: of the run, its reference and the planning.
UNKNOWN: Row = {"kind": "", "failed": "", "reason": "", "distance": math.nan, "allowed": math.nan}
UNKNOWN |= {"difference": math.nan, "reference": math.nan, "error": math.nan, "model": ""}
UNKNOWN |= {"reference_model": "", "steps": 0, "seconds": 0.0, "reference_seconds": 0.0}
UNKNOWN |= {"processor_seconds": 0.0}

# Fraction of a difference that refinement may change for it to count as the plate's own.
SURVIVES = 0.5

# Distance from the reference above which a random cell is wrong: a part of its own, and a fraction of the
# reference's difference from the rigid motion.
WRONG_FROM = (1e-3, 0.25)

# The same for a result that is good beyond doubt: with the factor of safety on an error that two meshes tell
# (Roache 1994, ASME V&V 20) it would still be allowed.
GOOD_TO = (FLOOR / 3.0, FRACTION / 3.0)

# Times as fine as the cell's mesh, both ways, of models that are tried in turn: as the first reference of a random
# cell, as a second one, and to confirm a cell of the map.
FIRST, SECOND, CONFIRMING = (1.5, 1.0, 0.7), (2.0, 1.0, 0.7), (2.0, 1.5)

# Elements of which a reference has no more; expected seconds of the time loop, at most: of a random cell's reference,
# and of any run of the map.
MAX_ELEMENTS, MAX_REFERENCE_S, LONGEST_S = 600, 4.0, 100.0

# Processor time of a cell whatever its steps [s]; time of all its loops, a companion's and those of the start included,
# over the estimate for its run. Measured on cells of paper-table-3 that were drawn at random.
CELL_S, LOOPS = 0.2, 2.0

# Width over length below which the program takes quadratic elements in bending, on the map of paper-table-3.
SLENDER = 0.05

# Steps with a penalty over those without, by the root of its scale; measured at scales of 46 to 10 000.
PENALTY_STEPS = 0.5

# Stiffness-proportional damping against flutter, of the reference that is tried last.
FLUTTER_DAMPING = 0.05

# What damping and ringing may change in a reference: a part of its own, and a fraction of its flexibility.
SWAYED = (5e-4, 0.1)

# Checks that a reference must pass; its reaction may ring.
DEMANDED = {
    *("tail-slap reached", "finite numbers", "time step", "energy balance", "momentum balance"),
    *("friction by ringing", "oscillation"),
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
    limit: Row = {"tolerance": tolerance or usual[1]}
    kinds, verify = MAP_KINDS, partial[Row](against_rigid, **limit)
    if count and not scene.contact:
        kinds, verify, limit = RANDOM_KINDS, partial(against_reference), {}
    axes: tuple[StudyAxis, ...] = ()
    if count:
        settings: Row = {"seed": seed, **limit}  # without their number: more cells go on from those there are
        cells, places = random_cells(scene, base, seed, count)
    else:
        settings = {"points": points or usual[0], **limit}
        axes = axes_of(scene, settings["points"])
        cells, places = map_cells(scene, axes)
    definition = {"study": "stability", "scene": base.given, **settings}
    parts = {key: (base, changes, verify) for key, changes in cells.items()}
    expected = {} if count else expected_seconds(case, base, cells)
    (found,) = engine.run_study(place, definition, [(judge, parts, f"{len(cells)} cells")], workers, expected)
    rows = {key: places[key] | its for key, its in found.items()}
    return StabilityResult(case, base, axes, settings, kinds, cells, rows, time.perf_counter() - began)


def base_source(scene: Scene) -> Source:
    """Source of the cells: the scene in SI, without its wall, since slides differ."""
    return vary(Source.of(scene), {"wall": None})[1]


def expected_seconds(case: Any, base: Source, cells: Mapping[str, Changes]) -> dict[str, float]:
    """Return the estimated processor time of every cell of a map, without a plan [s]."""
    return {key: CELL_S + _loop_seconds(case, base, changes) for key, changes in cells.items()}


def _loop_seconds(usual: Any, base: Source, changes: Changes) -> float:
    """Return the estimated time of a cell's loop, 0 where it is refused or left out [s]."""
    try:
        scene, source = vary(base, changes)
        plate = scene.needed_plate
        duration = _impact_duration(usual, scene) if scene.contact else case_of(scene, source).duration
    except Exception:  # judged with its cell, and what breaks the program too
        return 0.0
    if "element" not in plate.model_fields_set:
        slender = scene.vehicle.width < SLENDER * scene.vehicle.length
        plate = plate.model_copy(update={"element": "quad9" if slender else "quad4"})
    effort = expected_effort(scene.model_copy(update={"plate": plate}), duration)
    penalty = (scene.contact or scene.corner).penalty_scale or 0.0
    seconds = effort.seconds * max(1.0, PENALTY_STEPS * math.sqrt(penalty))
    return LOOPS * seconds if seconds <= LONGEST_S else 0.0


def _impact_duration(usual: Any, scene: Scene) -> float:
    """Return about the duration of a whole impact, in proportion to the usual one [s]; its run would take longer."""
    return float(usual.duration * usual.scene.impact.speed / scene.impact.speed) if scene.impact else 0.0


def judge(base: Source, changes: Changes, verify: Callable[[Any], Row]) -> Row:
    """The verdict on the scene with these changes, and the processor time that it took."""
    began = time.process_time()
    row = _judged_cell(base, changes, verify)
    return row | {"processor_seconds": time.process_time() - began}


def _judged_cell(base: Source, changes: Changes, verify: Callable[[Any], Row]) -> Row:
    """The verdict: what became of the cell's run, and of what `verify` holds it against."""
    began = time.perf_counter()
    try:
        case: Any = case_of(*vary(base, changes))
        if (expected := case.plan().expected_seconds) > LONGEST_S:
            return verdict(UNJUDGED, reason=f"estimated time of the time loop {expected:.0f} s")
        outcome = case.run()
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
    return float(_largest(outcome.mesh_error) if is_impact(outcome) else outcome.error.total)


def model_name(outcome: Any) -> str:
    """Elements of a run, like "quad9 20 x 6"."""
    plate = outcome.fe_plan.plate
    return f"{plate.element} {plate.counts[0]} x {plate.counts[1]}"


def against_rigid(outcome: Any, tolerance: float) -> Row:
    """The verdict; tolerance: difference from the rigid motion up to which the cell is right."""
    impact = is_impact(outcome)
    found = _judged(outcome.difference, outcome.fe) if impact else largest(outcome.difference)
    if not outcome.passed:
        return verdict(CAUGHT, failed=", ".join(failed_names(outcome.checks)), difference=found)
    if found <= tolerance and (not impact or _corners_agree(outcome.fe, outcome.rigid)):
        return verdict(RIGHT, difference=found)
    # What bounds the error bounds the flexibility alike: with a bound that is wide, both are.
    if not impact and not outcome.error.total <= tolerance + SURVIVES * max(found, outcome.error.flexibility):
        why = f"the numerical error is {outcome.error.total:.1e}"
        return verdict(WRONG, reason=why, difference=found)
    return (_impact_confirmed if impact else _confirmed)(outcome, found, tolerance)


def _confirmed(outcome: CornerOutcome, found: float, tolerance: float) -> Row:
    """Flexible if the difference survives refinement, else wrong."""
    reference = next(references(outcome.fe_plan, CONFIRMING, LONGEST_S), None)
    if reference is None:
        return verdict(WRONG, reason="no refined model has a result", difference=found)
    its = largest(reference.difference)
    moved, allowed = distance(outcome.difference, reference.difference), tolerance + SURVIVES * its
    spent = {"reference_model": reference.model, "reference_seconds": reference.seconds}
    return _survived(moved, allowed, reference.model) | {"difference": found, "reference": its, **spent}


def _impact_confirmed(outcome: Any, found: float, tolerance: float) -> Row:
    """Flexible if the first refined model of a whole impact that comes to a result differs likewise, else wrong."""
    began, case, plate = time.perf_counter(), outcome.fe_plan.case, outcome.fe_plan.plate
    models = (refined_impact(case, changes) for changes in refinements(case.scene, plate))
    refined = next(filter(None, models), None)
    if refined is None:
        return verdict(WRONG, reason="no refined model has a result", difference=found)
    name, same = model_name(refined), _corners_agree(outcome.fe, refined.fe)
    moved = _judged(differences(outcome.fe, refined.fe), outcome.fe) if same else math.inf
    spent = {"reference_model": name, "reference_seconds": time.perf_counter() - began}
    its_verdict = _survived(moved, tolerance + claimed_error(outcome), name)
    return its_verdict | {"difference": found, "reference": _judged(refined.difference, refined.fe), **spent}


def _survived(moved: float, allowed: float, model: str) -> Row:
    """Flexible if refinement moves a cell by no more than is allowed, else wrong; model: the refined one."""
    kind, reason = (FLEXIBLE, model) if moved <= allowed else (WRONG, f"{model} differs by {moved:.1e}")
    return verdict(kind, reason=reason, distance=moved, allowed=allowed)


def refined_impact(case: Any, changes: Changes) -> Any:
    """The outcome of a refined model of a whole impact; None where it says nothing."""
    try:
        refined = whole_impact.attempt(case.varied(changes))
    except InputError:
        return None
    return None if failed_but_mesh(refined) else refined


def refinements(scene: Scene, plate: Plate) -> list[Changes]:
    """Refined models of a whole impact, of half the time step: quadratic elements in place of linear ones; twice the
    elements each way. plate: as it was run."""
    (along, across), higher_order = plate.counts, ELEMENT_KINDS[plate.element].higher_order
    step = {"time.safety_factor": 0.5 * scene.time.safety_factor}
    richer = {"plate.elements": plate.counts, "plate.element": higher_order, **step}
    finer = {"plate.elements": (2 * along, 2 * across), **step}
    return [richer, finer] if higher_order else [finer]


def _corners_agree(*answers: Any) -> bool:
    """True if the first two strikes are of the same corners, so that all differences are told."""
    ours, its = ([strike.corner for strike in answer.strikes[:2]] for answer in answers)
    return ours == its


def _judged(found: Mapping[str, float], answer: ImpactAnswer) -> float:
    """Largest difference in impulse and peak force of the strikes whose error is stated."""
    stated = {f"strike_{1 + answer.strikes.index(strike)}" for strike in weighed(answer.strikes)}
    return _largest({name: each for name, each in found.items() if name.partition(".")[0] in stated})


def _largest(found: Mapping[str, float]) -> float:
    """Largest of impulse and peak force."""
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
    fe_plan = outcome.fe_plan
    first, failed = None, failed_names(outcome.checks)
    if outcome.fe:
        first = next(references(fe_plan, FIRST), None)
    if first is None:
        return grade(outcome.difference, failed, None, math.nan)
    motion: Row = {"its": first.histories, "rigid": outcome.rigid, "oscillates": not fe_plan.plate.relieved}
    ours = outcome.fe_history, outcome.rigid_history
    found = grade(outcome.difference, failed, first, distance_in_motion(ours, **motion))
    if found["kind"] != GOOD:
        return found
    others = references(fe_plan, SECOND)
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


def references(
    cell: CornerPlan, factors: Sequence[float], longest: float = MAX_REFERENCE_S
) -> Iterator[Reference]:
    """Models that come to a trustworthy result, in no more than `longest` expected seconds each.

    factors: times as fine as the cell. Damping in proportion to the stiffness comes last, and would take an unstressed
    plate's oscillation off.
    """
    began = time.perf_counter()
    models = [(factor, 0.0) for factor in factors]
    if cell.plate.relieved:
        models += [(factor, FLUTTER_DAMPING) for factor in dict.fromkeys((FIRST[0], factors[-1]))]
    for finer, ratio in models:
        try:
            case = cell.asked.varied(reference_changes(cell.asked.scene, cell.plate, finer, ratio))
            if expected_effort(case.scene, case.duration).seconds > longest:
                continue
            outcome = run.judged(run.settled(case))
        except InputError:
            continue
        if trustworthy(outcome):
            name = model_name(outcome) + (", damped" if ratio else "")
            histories = outcome.fe_history, outcome.rigid_history
            yield Reference(outcome.difference, name, time.perf_counter() - began, histories)


def reference_changes(scene: Scene, plate: Plate, finer: float, ratio: float = 0.0) -> Changes:
    """Changes that make a cell's scene the refined model, so much finer but of no more than MAX_ELEMENTS.

    A constraint that the scene gives becomes the exact one: an open one stays open, for some plates flutter with the
    exact one. plate: as it was run; ratio: of its damping, 0 to leave it to the program.
    """
    scale = min(finer, math.sqrt(MAX_ELEMENTS / math.prod(plate.counts)))
    along, across = (max(2, math.ceil(scale * count)) for count in plate.counts)
    changes: Row = dict.fromkeys(("plate.lumping", "plate.distortion", "damping"))
    changes["plate.element"] = ELEMENT_KINDS[plate.element].higher_order or plate.element
    changes["plate.elements"] = along, across
    if not scene.corner.constraint_is_open:
        changes |= dict.fromkeys(("corner.penalty_scale", "corner.damping_ratio"))
        changes["corner.constraint"] = "exact"
    return changes | ({"damping.ratio": ratio} if ratio else {})


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
    inner += [(f"trailer.{number}", table) for number, table in enumerate(tables.get("trailer", ()))]
    return dict(sorted((f"{name}.{key}", value) for name, table in inner for key, value in table.items()))
