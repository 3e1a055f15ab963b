"""The study `stability`: where the program is right, refuses, or catches itself.

A map varies two axes at a time and judges each cell against the rigid motion; where the two differ, a refined model
must differ likewise. With --random every quantity and choice of the scene is drawn at once, and a cell is judged by a
refined model of the same plate. What the machine code of a run depends on is drawn together there, as one of
`COMBINATIONS`, and quantities apart from it: most kinds of model then serve many cells, where each would be compiled
for one or two.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fem.plate.kinds import ELEMENT_KINDS
from postprocess.comparison.quantities import largest
from tailslap.campaign import engine, records
from tailslap.case import case_of
from tailslap.case.case import failed_names
from tailslap.case.corner import checks, run
from tailslap.case.corner.error import FLOOR, FRACTION, Histories, distance_in_motion
from tailslap.case.cost import beam_frequency, expected_effort
from tailslap.case.impact import run as whole_impact
from tailslap.case.impact.answers import differences
from tailslap.case.impact.checks import failed_but_mesh
from tailslap.errors import InputError
from tailslap.scene.schema import Plate, Scene
from tailslap.scene.vary import Changes, Source, changed_tables, vary

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

# Combinations of choices in a campaign: nearly any two choices meet in one of them. Prime, so that what goes
# by the number of a cell, like its start, is not the same in all cells of a combination.
COMBINATIONS = 97

ELEMENTS = ("quad4", "quad4-reduced", "quad9", "tri3", "tri6")
OPEN = 0.3  # fraction of the cells that leave a choice to the program

# Steps, and seconds of its time loop, that a random cell may be expected to take; scenes drawn for one cell
# until one is possible and affordable, about one in three is; and quantities drawn for a combination before
# another is.
MAX_STEPS, MAX_SECONDS, MAX_TRIES, TRIES = 400_000, 0.5, 1000, 50


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
    with records.Journal(place, {"study": "stability", "scene": base.given, **settings}) as journal:
        parts = {key: (base, changes, verify) for key, changes in cells.items()}
        engine.run_parts(judge, parts, journal, f"{scene.name}: {len(cells)} cells", workers)
        rows = {key: places[key] | journal.records[key] for key in cells}
    return StabilityResult(case, base, axes, settings, kinds, cells, rows, time.perf_counter() - began)


def base_source(scene: Scene) -> Source:
    """Source of the cells: the scene in SI, without its wall, since slides differ."""
    return vary(Source.of(scene), {"wall": None})[1]


class StudyAxis(NamedTuple):
    """A quantity that varies: name, what its numbers mean, values, what a value changes in a scene."""

    name: str
    meaning: str
    values: tuple[float, ...]
    changes: Callable[[Scene, float], Changes]


def axes_of(scene: Scene, n: int) -> tuple[StudyAxis, ...]:
    """The axes that mean something for this scene, each with n values."""
    contact, corner = scene.contact, scene.corner
    if contact is None:
        absent = {"friction"} if corner.frictionless else set()
        absent |= {"penalty"} if corner.constraint == "exact" else set()
    else:
        absent = {"penalty"} if contact.crushes else {"contact stiffness", "restitution"}
        absent |= {"penalty"} if contact.enforcement == "exact" else set()
    return tuple(
        StudyAxis(name, meaning, tuple(spaced(low, high, n).tolist()), changes)
        for name, meaning, spaced, low, high, changes in (IMPACT_AXES if contact else CORNER_AXES)
        if name not in absent
    )


def _zero_and_ratios(low: float, high: float, n: int) -> np.ndarray:
    return np.append(0.0, np.geomspace(low, high, n - 1))


def _of(key: str) -> Callable[[Scene, float], Changes]:
    return lambda scene, value: {key: value}


def _stiffness(scene: Scene, factor: float) -> Changes:
    """Young's modulus, or what the first frequency makes it, over the scene's."""
    plate = scene.needed_plate
    if plate.first_frequency is not None:
        return {"plate.first_frequency": plate.first_frequency * math.sqrt(factor)}
    return {"plate.youngs_modulus": plate.modulus * factor}


def _speed(scene: Scene, factor: float) -> Changes:
    given = _given(scene, "impact.speed", "start.omega", "start.corner_speed")
    return {key: value * factor for key, value in given.items()}


def _angle(scene: Scene, degrees: float) -> Changes:
    return dict.fromkeys(_given(scene, "impact.angle", "start.angle"), math.radians(degrees))


def _given(scene: Scene, *keys: str) -> dict[str, float]:
    """Values of these keys that the scene gives."""
    paths = {key: key.split(".") for key in keys}
    found = {key: getattr(getattr(scene, table), name, None) for key, (table, name) in paths.items()}
    return {key: value for key, value in found.items() if value is not None}


def _slenderness(scene: Scene, ratio: float) -> Changes:
    return {"vehicle.width": ratio * scene.vehicle.length}


def _damping(scene: Scene, ratio: float) -> Changes:
    if ratio > 0.0:
        return {"damping.ratio": ratio}
    alone = scene.damping is not None and scene.damping.model_fields_set == {"ratio"}
    return {"damping" if alone else "damping.ratio": None}


# Name, what its numbers mean, how its values lie between which ends, and what a value changes.
CORNER_AXES: tuple[tuple[str, str, Any, float, float, Any], ...] = (
    ("stiffness", "E over the scene's", np.geomspace, 1e-4, 1e4, _stiffness),
    ("penalty", "corner.penalty_scale", np.geomspace, 1e-3, 1e4, _of("corner.penalty_scale")),
    ("friction", "corner.friction", np.linspace, 0.0, 2.0, _of("corner.friction")),
    ("speed", "speeds over the scene's", np.geomspace, 1e-2, 1e1, _speed),
    ("angle", "angle [deg]", np.geomspace, 1.0, 80.0, _angle),
    ("slenderness", "width over length", np.geomspace, 0.01, 1.0, _slenderness),
    ("time step", "time.safety_factor", np.linspace, 0.5, 1.2, _of("time.safety_factor")),
    ("damping", "damping.ratio", _zero_and_ratios, 3e-3, 1.0, _damping),
)
IMPACT_AXES: tuple[tuple[str, str, Any, float, float, Any], ...] = (
    ("contact stiffness", "contact.stiffness [N/m]", np.geomspace, 1e4, 1e9, _of("contact.stiffness")),
    ("restitution", "contact.restitution", np.linspace, 0.0, 1.0, _of("contact.restitution")),
    ("penalty", "contact.penalty_scale", np.geomspace, 1e-2, 1e3, _of("contact.penalty_scale")),
    ("friction", "contact.friction", np.linspace, 0.0, 2.0, _of("contact.friction")),
    ("angle", "angle [deg]", np.geomspace, 1.0, 85.0, _angle),
    ("speed", "speed over the scene's", np.geomspace, 0.1, 3.0, _speed),
    ("modulus", "E over the scene's", np.geomspace, 1e-4, 1e2, _stiffness),
    ("time step", "time.safety_factor", np.linspace, 0.5, 1.2, _of("time.safety_factor")),
    ("slenderness", "width over length", np.geomspace, 0.05, 1.0, _slenderness),
)


def map_cells(scene: Scene, axes: Sequence[StudyAxis]) -> tuple[dict[str, Changes], dict[str, Row]]:
    """Changes of every cell of the map, and its place: each pair of axes, each pair of their values."""
    cells: dict[str, Changes] = {}
    places: dict[str, Row] = {}
    for first, second in combinations(axes, 2):
        for x, y in product(first.values, second.values):
            key = cell_key({first.name: x, second.name: y})
            cells[key] = {**first.changes(scene, x), **second.changes(scene, y)}
            places[key] = {"first": first.name, "first_value": x, "second": second.name, "second_value": y}
    return cells, places


def cell_key(point: Mapping[str, float]) -> str:
    """Key of the cell where the axes have these values."""
    return " ".join(f"{name}={value!r}" for name, value in point.items())


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


def against_reference(outcome: checks.CornerOutcome) -> Row:
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


def trustworthy(outcome: checks.CornerOutcome) -> bool:
    """True if the result can be taken for the truth about the plate. What an undamped run may show, an oscillation that
    friction has fed, a reference may not."""
    found, error = largest(outcome.difference), outcome.error
    swayed = not error.damping + outcome.ringing <= _limit(SWAYED, found)
    fed = any(check.name == "oscillation" and check.value > checks.OSCILLATES for check in outcome.checks)
    passed = DEMANDED.isdisjoint(failed_names(outcome.checks))
    return math.isfinite(found) and passed and not swayed and not fed


class Dice:
    """Random numbers of one draw."""

    def __init__(self, *seeds: int) -> None:
        self._random = np.random.default_rng(seeds)

    def even(self, low: float, high: float) -> float:
        return float(self._random.uniform(low, high))

    def ratio(self, low: float, high: float) -> float:
        return math.exp(self.even(math.log(low), math.log(high)))

    def happens(self, fraction: float) -> bool:
        return self.even(0.0, 1.0) < fraction

    def one_of(self, values: Sequence[str], fractions: Sequence[float] | None = None) -> str:
        return values[int(self._random.choice(len(values), p=fractions))]


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


def choices_of(seed: int, combination: int, attempt: int) -> Row:
    """Choices of a combination that the machine code of a run depends on, "open" left to the program; attempt: number
    of those before it that were not possible."""
    dice = Dice(seed, combination, attempt)
    return {
        "reaction": dice.one_of(("drag", "none", "signed"), (0.6, 0.2, 0.2)),
        "frictionless": dice.happens(0.1),
        "element": "open" if dice.happens(OPEN) else dice.one_of(ELEMENTS),
        "row_sum": dice.happens(0.1),
        "distorted": dice.happens(0.3),
        "constraint": dice.one_of(("open", "penalty", "exact", "dashpot"), (0.4, 0.2, 0.2, 0.2)),
        "patch": dice.happens(0.5),
        "damping": dice.one_of(("open", "ratio", "bulk", "none"), (0.6, 0.15, 0.1, 0.15)),
        "neo_hookean": dice.happens(0.5),
    }


def draw(scene: Scene, base: Source, seed: int, number: int) -> Changes:
    """Changes of a random cell, known by seed and number, in the base.

    Raises InputError where the scene allows no possible and affordable one.
    """
    dice = Dice(seed, COMBINATIONS + number)
    for attempt in range(MAX_TRIES):
        choices = choices_of(seed, number % COMBINATIONS, attempt // TRIES)
        changes = _drawn(scene, choices, dice, number)
        try:
            case: Any = case_of(*vary(base, changes))
            effort = expected_effort(case.scene, case.duration)
        except InputError:
            continue
        if effort.steps <= MAX_STEPS and effort.seconds <= MAX_SECONDS:
            return changes
    none = f"none of {MAX_TRIES} draws of this scene is possible and affordable"
    raise InputError("--random", number, none)


def _drawn(scene: Scene, choices: Row, dice: Dice, number: int) -> Changes:
    """All that is drawn, in this order: each takes its random numbers from the same sequence."""
    length = dice.even(3.0, 20.0)
    width = length * dice.ratio(0.05, 1.0)
    changes: Row = dict.fromkeys(("verify", "wall", "damping", "material"))
    changes |= {"vehicle.length": length, "vehicle.width": width}
    changes |= _motion(scene, choices, dice)
    changes |= _plate(scene, choices, dice, number, length, width)
    changes |= _corner(choices, dice, length, changes["plate.elements"] or (10, 1))
    if choices["damping"] == "ratio":
        changes["damping.ratio"] = dice.ratio(0.005, 0.3)
    elif choices["damping"] != "open":
        bulk = choices["damping"] == "bulk"
        changes |= {"damping.bulk_viscosity": 0.06} if bulk else {"damping.kind": "none"}
    if choices["neo_hookean"]:
        changes["material.law"] = "neo-hookean"
    return changes | {"name": f"cell-{number:04d}"}


def _motion(scene: Scene, choices: Row, dice: Dice) -> Changes:
    """Stage 1 where the scene has it, for Stage 2 to follow; else the start, the spin in proportion to the speed."""
    speed, angle = dice.ratio(1.0, 40.0), math.radians(dice.even(2.0, 60.0))
    restitution, friction = dice.even(0.0, 0.8), dice.even(0.0, 1.2)
    if choices["frictionless"]:
        friction = 0.0
    changes: Row = {"corner": None, "corner.reaction": choices["reaction"], "start": None}
    if scene.impact:
        drawn = {"speed": speed, "angle": angle, "restitution": restitution, "friction": friction}
        return changes | {f"impact.{key}": value for key, value in drawn.items()}
    start: Any = scene.start
    spin = start.omega / start.corner_speed
    changes |= {"start.angle": angle, "start.corner_speed": speed, "start.omega": spin * speed}
    return changes | ({"corner.friction": friction} if choices["reaction"] != "none" else {})


def _plate(scene: Scene, choices: Row, dice: Dice, number: int, length: float, width: float) -> Changes:
    """A modulus from 1e-4 to 1e4 times the scene's, for a third of the cells by the frequency that it gives a beam."""
    plate, factor = scene.needed_plate, dice.ratio(1e-4, 1e4)
    element, relieved = choices["element"], ("inertia-relief", "inertia-relief-momenta")
    changes: Row = {"plate.elements": None, "plate.element": None if element == "open" else element}
    changes |= {"plate.lumping": "row-sum" if choices["row_sum"] else None, "plate.distortion": None}
    changes["plate.start"] = relieved[number // 3 % 2] if number % 3 else "unstressed"
    changes |= _stiffness(scene, factor)
    if plate.first_frequency is None and dice.happens(1.0 / 3.0):
        frequency = beam_frequency(scene, length, width, plate.modulus * factor)
        changes |= {"plate.youngs_modulus": None, "plate.first_frequency": frequency}
    if not dice.happens(OPEN):
        changes["plate.elements"] = (round(dice.ratio(4.0, 40.0)), round(dice.ratio(2.0, 12.0)))
    if choices["distorted"]:
        changes["plate.distortion"] = dice.even(0.0, 0.2)
    return changes


def _corner(choices: Row, dice: Dice, length: float, elements: tuple[int, int]) -> Changes:
    changes: Row = {}
    if choices["constraint"] == "exact":
        changes["corner.constraint"] = "exact"
    elif choices["constraint"] != "open":
        changes |= {"corner.constraint": "penalty", "corner.penalty_scale": dice.ratio(0.1, 10.0**1.5)}
    if choices["constraint"] == "dashpot":
        changes["corner.damping_ratio"] = dice.ratio(0.01, 1.0)
    if choices["patch"]:
        changes["corner.patch_length"] = max(dice.even(0.1, 0.3) * length, 1.2 * length / elements[0])
    return changes
