"""How soft a vehicle may be for the rigid-body method still to hold: plates from stiff to soft, and what follows.

Of a constrained corner three starts and three meshes a plate, the modal model beside them, and at some plates the
thickness in place of the modulus. Of a whole impact both strikes of each plate, and what is measured of them from 2 Hz
to rigid. A difference is known where its numerical error is small against it; then it is told down to which first
frequency it stays below a level.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.start.start_kinds import START_KINDS
from postprocess.comparison.metrics import SAFETY_FACTOR, grid_convergence
from postprocess.comparison.quantities import KEYS, largest_relative, relative_difference
from solver.impact import CORNERS
from tailslap.campaign.engine import run_parts
from tailslap.campaign.levels import PowerLaw, Reach, Sample, jointly, lowest_frequency, power_law
from tailslap.campaign.records import Journal
from tailslap.case.case import Case
from tailslap.case.checks import failed_names
from tailslap.case.corner.case import CornerCase
from tailslap.case.corner.model import MIN_STEPS
from tailslap.case.cost import loop_seconds
from tailslap.case.impact.answers import COLUMNS, COMPARED, both_strikes, nearest_corner
from tailslap.case.impact.case import ImpactCase
from tailslap.case.model import plate_density
from tailslap.errors import InputError
from tailslap.scene.schema import Scene
from tailslap.scene.units import Quantity
from tailslap.scene.vary import Changes, Source, vary

if TYPE_CHECKING:
    from tailslap.case.corner.plan import CornerPlan
    from tailslap.case.corner.run import CornerOutcome
    from tailslap.case.impact.run import ImpactOutcome

Record = dict[str, Any]

# What --lowest and --highest may be.
HERTZ = Quantity("a frequency in cycles a second", "Hz", '"8 Hz"', least=0.01, most=1e5)

# The softest plate of a constrained corner and of a whole impact.
LOWEST, IMPACT_LOWEST = "0.1 Hz", "2 Hz"

# Differences for which the lowest first frequency is sought.
LEVELS, IMPACT_LEVELS = (1e-3, 1e-2, 5e-2, 1e-1), (1e-2, 5e-2, 1e-1)

# The starts that are run, whatever the scene's own; the first with modal model and thicknesses beside it.
STARTS = ("inertia-relief", "inertia-relief-momenta", "unstressed")

# Velocities that a start may keep: of the centre of mass, of rotation, of the corner along the wall.
KEPT = ("v_gx", "v_gy", "omega", "v_p")

# What is measured of a plate, and its column.
MEASURED = {name: f"difference_{name}" for name in KEYS}
MEASURED |= {"reaction": "reaction_deviation", "stored": "stored_share"}

# The check that the study makes itself, by its own levels.
JUDGED = "numerical error"

# Length of the corner's patch, or of side that a corner's crush is spread over, over the vehicle's, where the
# scene gives none: a point has no finite compliance, and meshes would not converge.
PATCH = 0.1

# Elements along and across that the coarsest mesh keeps at least; otherwise the scene's own is the coarsest.
MIN_HALVED = (4, 2)

# Expected seconds of a time loop above which a run is left out.
TOO_LONG = 120.0

# Places in the sweep where it is repeated by the thickness, from the stiffest (0) to the softest (1).
THICKNESSES = (1 / 6, 1 / 2, 5 / 6)

# Rows of the history of a start that oscillates, a period of the first frequency: enough to see its largest
# swing.
ROWS_A_PERIOD, MAX_ROWS = 12, 20_000

# Order of convergence of linear elements and central differences.
MAX_ORDER = 2.0

# What is compared of a whole impact, as `tailslap.case.impact.answers` names it.
NAMES = tuple(f"strike_{k}.{name}" for k in (1, 2) for name in COMPARED)

# First frequencies of the plates whose strikes are measured [Hz].
PLATES = (2.0, 4.0, 8.0, 16.0, 32.0)

# Time of such a plate's run over that of the rigid vehicle's impact; difference between both meshes above
# which it is not to be relied on.
LONGER, WORST = 2.0, 0.05


@dataclass(frozen=True)
class Flexibility:
    """The finished study.

    Attributes
    ----------
    rows : list of dict
        The plates from stiff to soft, as `points.csv` has them.
    levels : dict of tuple of Reach
        Of a whole impact by `NAMES`; of a corner v_GY's largest difference by start.
    own_frequency : float
        Of the scene's own plate [Hz].
    setup : dict
        How the corner is held, and on which meshes; the length that a corner's crush is spread over.
    others, laws : dict
        Of a corner's first start, levels and power laws of the quantities at the strike.
    plates : list of dict
        Of a whole impact, both strikes from 2 Hz to rigid, as of `measure_plate`, softest first.
    """

    case: Case
    rows: list[Record]
    levels: Mapping[str, tuple[Reach, ...]]
    own_frequency: float
    setup: Record
    seconds: float
    others: Mapping[str, tuple[Reach, ...]]
    laws: Mapping[str, PowerLaw | None]
    plates: Sequence[Record] = ()

    @property
    def band(self) -> tuple[Reach, ...]:
        """What holds for each of the series of `levels`."""
        return tuple(jointly(each) for each in zip(*self.levels.values(), strict=True))


def compute(
    case: Any, place: Path, points: int, lowest: str | None, highest: str, workers: int | None
) -> Flexibility:
    """The study as the command line asks for it."""
    if case.scene.contact is not None:
        given = frequencies(lowest or IMPACT_LOWEST, highest, points)
        return impact_flexibility(case, given, place, workers)
    return corner_flexibility(case, frequencies(lowest or LOWEST, highest, points), place, workers)


def frequencies(lowest: str, highest: str, points: int) -> tuple[float, ...]:
    """First frequencies [Hz] from the highest to the lowest, at even ratios. Raises InputError."""
    ends = []
    for option, given in (("--lowest", lowest), ("--highest", highest)):
        value: float | str = given
        with suppress(ValueError):
            value = float(given)
        try:
            ends.append(HERTZ.parse(value))
        except ValueError as error:
            raise InputError(option, given, str(error)) from None
    if not ends[0] < ends[1]:
        raise InputError("--lowest", lowest, f'allowed is less than --highest, which is "{highest}"')
    return tuple(np.geomspace(ends[1], ends[0], points).tolist())


@dataclass(frozen=True)
class Sweep:
    """What is run of a corner. meshes: coarse to fine, each twice the last; support: how the corner is held; own:
    thickness [m], density [kg/m^3] and modulus [Pa] of the scene's own plate."""

    case: CornerCase
    fe_plan: CornerPlan
    meshes: tuple[tuple[int, int], ...]
    support: Record
    own: tuple[float, float, float]


def define(case: CornerCase) -> Sweep:
    """The sweep of a scene. Raises InputError for keys that make no model."""
    fe_plan = case.plan()
    plate, meshes = fe_plan.plate, three_meshes(fe_plan.case.scene)
    own = (plate.thickness, plate_density(case.scene, plate), plate.modulus)
    return Sweep(case, fe_plan, meshes, corner_support(case.scene, meshes[0]), own)


def three_meshes(scene: Scene) -> tuple[tuple[int, int], ...]:
    """The scene's mesh halved, itself, doubled; or where it cannot be halved, itself, doubled, and doubled again.

    scene: one whose elements are decided.
    """
    along, across = scene.needed_plate.counts
    patch, length = scene.corner.patch_length, scene.vehicle.length
    halves = along % 2 == 0 and across % 2 == 0 and along // 2 >= MIN_HALVED[0]
    halves = halves and across // 2 >= MIN_HALVED[1] and (patch is None or patch * (along // 2) >= length)
    coarse = (along // 2, across // 2) if halves else (along, across)
    return tuple((n * coarse[0], n * coarse[1]) for n in (1, 2, 4))


def corner_support(scene: Scene, coarsest: tuple[int, int]) -> Record:
    """The scene's own constraint and patch where it gives them, else the exact one over a patch of whole elements."""
    corner, element = scene.corner, scene.vehicle.length / coarsest[0]
    own = bool(corner.model_fields_set & {"constraint", "penalty_scale", "damping_ratio"})
    patch = corner.patch_length or max(1, round(PATCH * scene.vehicle.length / element)) * element
    given = {"own_constraint": own, "own_patch": corner.patch_length is not None}
    return {"constraint": corner.constraint if own else "exact", "patch": patch, **given}


def run_changes(sweep: Sweep, frequency: float, elements: tuple[int, int], start: str = STARTS[0]) -> Changes:
    """What gives the scene this first frequency [Hz], mesh and start, its corner supported as in the study."""
    changes: dict[str, Any] = {
        "wall": None,
        "verify": None,  # plates that differ from the rigid body are the subject, and no failure
        "plate.youngs_modulus": None,
        "plate.first_frequency": frequency,
        "plate.elements": elements,
        "plate.element": sweep.fe_plan.plate.element,
        "plate.start": start,
        "corner.patch_length": sweep.support["patch"],
    }
    if not sweep.support["own_constraint"]:
        changes["corner.constraint"] = sweep.support["constraint"]
    if not START_KINDS[start].relieved:  # rows that show every swing
        swings = math.ceil(ROWS_A_PERIOD * frequency * sweep.case.motion.strike.t)
        changes["time.rows"] = max(sweep.case.scene.time.rows, min(MAX_ROWS, swings))
    return changes


def mesh_changes(sweep: Sweep, frequency: float, start: str) -> list[Changes | None]:
    """What a start's runs change, coarse to fine; None for one that would take too long."""
    found: list[Changes | None] = []
    for elements in sweep.meshes:
        finer = elements[0] / sweep.fe_plan.plate.counts[0]
        steps = sweep.fe_plan.expected_steps * finer * frequency / sweep.fe_plan.first_frequency
        element = sweep.fe_plan.plate.element
        expected = loop_seconds(sweep.case.scene, element, elements, max(MIN_STEPS, steps))
        found.append(run_changes(sweep, frequency, elements, start) if expected <= TOO_LONG else None)
    return found


def corner_flexibility(
    case: CornerCase, given: tuple[float, ...], place: Path, workers: int | None
) -> Flexibility:
    """Run every plate; an interrupted study of the same scene goes on from its journal. given: falling [Hz]."""
    began, sweep = time.perf_counter(), define(case)
    last = len(given) - 1
    thin, parts = {round(place * last) for place in THICKNESSES}, {}
    for number, frequency in enumerate(given):
        starts = {name: mesh_changes(sweep, frequency, name) for name in STARTS}
        modal = {**run_changes(sweep, frequency, sweep.meshes[-1]), "damping": None}
        own, half = sweep.own if number in thin else None, number == len(given) // 2
        parts[f"{frequency!r} Hz"] = (case.source, starts, modal, own, half)
    definition = {"scene": case.scene.model_dump(), "frequencies": given, "starts": STARTS}
    with Journal(place, {"study": "flexibility", **definition}) as journal:
        run_parts(measure, parts, journal, f"{case.scene.name}: {len(parts)} plates", workers)
        records = [journal.records[key] for key in parts]
    rows = [plate_row(f, record, case.tail_slap) for f, record in zip(given, records, strict=True)]
    return summed_up(sweep, rows, time.perf_counter() - began)


def summed_up(sweep: Sweep, rows: list[Record], seconds: float) -> Flexibility:
    """Levels and power laws of these plates."""
    starts = {name: _levels(start_samples(rows, name)) for name in STARTS}
    others = {name: _levels(samples_of(rows, name)) for name in MEASURED if name not in ("v_gy", "stored")}
    laws = {name: power_law(samples_of(rows, name)) for name in MEASURED}
    setup = {"corner": sweep.support, "meshes": sweep.meshes}
    own = sweep.fe_plan.first_frequency
    return Flexibility(sweep.case, rows, starts, own, setup, seconds, others, laws)


def _levels(samples: list[Sample], levels: tuple[float, ...] = LEVELS) -> tuple[Reach, ...]:
    return tuple(lowest_frequency(samples, level) for level in levels)


def samples_of(rows: Sequence[Record], name: str) -> list[Sample]:
    """The plates of one of `MEASURED`, at the strike of the first start, as levels and power law take them."""
    return [
        Sample(row["first_frequency"], abs(row[MEASURED[name]]), row[f"error_{name}"], row["passed"])
        for row in rows
    ]


def start_samples(rows: Sequence[Record], start: str) -> list[Sample]:
    """The largest difference of v_GY of one start, whatever the phase in which it strikes.

    Never less than that of a stiffer plate: where it changes its sign it is small for no reason that holds nearby.
    """
    found, largest = [], 0.0
    for row in rows:
        size, error, passed = (row[f"{start}:{name}"] for name in ("v_gy_largest", "v_gy_error", "passed"))
        largest = max(largest, size) if passed else largest
        found.append(Sample(row["first_frequency"], largest, error, passed))
    return found


def measure(
    base: Source,
    starts: dict[str, list[Changes | None]],
    modal: Changes,
    own: tuple[float, float, float] | None,
    half: bool,
) -> Record:
    """The record of a plate; starts: by name what its runs change, coarse to fine, None for one that is left out.

    modal: of the modal model; own: the scene's section where the first start's middle mesh is run once more by its
    thickness; half: whether the finest mesh is run once more, held over half the length.
    """
    runs = {name: [one_run(base, changes) for changes in meshes] for name, meshes in starts.items()}
    record: Record = {"starts": runs, "modal": modal_opinion(base, modal)}
    _, changes, finest = starts[STARTS[0]]
    if half and finest is not None:
        patch = 0.5 * finest["corner.patch_length"]
        record["half_patch"] = one_run(base, {**finest, "corner.patch_length": patch})
    middle = runs[STARTS[0]][1]
    if own is not None and changes is not None and "refused" not in middle:
        record["thickness"] = one_run(base, thickness_changes(changes, middle["youngs_modulus"], own))
    return record


def thickness_changes(changes: Changes, modulus: float, own: tuple[float, float, float]) -> Changes:
    """The plate of these changes, whose modulus is this [Pa], with the scene's own modulus and the thickness for it.

    E t stays, and so does density times thickness, which is the mass.
    """
    thickness, density, youngs_modulus = own
    ratio = modulus / youngs_modulus
    plate = {"thickness": thickness * ratio, "density": density / ratio, "youngs_modulus": youngs_modulus}
    return {
        **changes,
        "plate.first_frequency": None,
        **{f"plate.{key}": value for key, value in plate.items()},
    }


def one_run(base: Source, changes: Changes | None) -> Record:
    """Values, failed checks, reaction and stored energy of a finite-element run; `refused` says why there is none."""
    if changes is None:
        return {"refused": "left out: its time loop would take too long"}
    began = time.perf_counter()
    try:
        outcome = CornerCase(*vary(base, changes)).run()
    except InputError as error:
        return {"refused": str(error)}
    except Exception as error:  # one plate must not end the study; it is shown as failed
        return {"refused": f"broke: {type(error).__name__}: {error}"}
    return _record(outcome) | {"seconds": time.perf_counter() - began}


def _record(outcome: CornerOutcome) -> Record:
    """What the study takes from a run. Its numerical error is kept and no failure: each level is held to it."""
    fe_plan, error = outcome.fe_plan, outcome.error
    fe, rigid = outcome.fe_history, outcome.rigid_history
    known = np.isfinite(rigid["reaction_normal"])
    ours, theirs = (history["reaction_normal"][known] for history in (fe, rigid))
    with np.errstate(all="ignore"):
        reaction = float(np.abs(ours - theirs).max() / np.abs(theirs).max())
    return {
        "elements": list(fe_plan.plate.elements or ()),
        "youngs_modulus": fe_plan.plate.youngs_modulus,
        "thickness": fe_plan.plate.thickness,
        "damping": getattr(fe_plan.model.loop.elastic_damping, "rate", 0.0),
        "values": outcome.fe,
        "failed": [name for name in failed_names(outcome.checks) if name != JUDGED],
        "departure": {name: float(fe[name][0] / rigid[name][0] - 1.0) for name in KEPT},
        "largest": largest_difference(outcome),
        "reaction": reaction,
        "stored": float(fe["strain_energy"].max() / fe["kinetic_energy"][0]),
        "deflection_ratio": fe_plan.deflection_ratio,
        "error": error.total,
        "unseen": error.damping + error.ringing,
        "steps": outcome.run.steps,
    }


def largest_difference(outcome: CornerOutcome) -> float:
    """Largest difference of v_GY from the rigid body, at the strike and at any instant before it, over v_GY at the
    strike: an oscillating plate may strike in any phase. NaN without a strike."""
    if not outcome.fe:
        return math.nan
    ours, rigid = outcome.fe_history["v_gy"], outcome.rigid_history["v_gy"]
    before = np.nanmax(np.abs(ours - rigid)) / abs(outcome.rigid["v_gy"])
    return max(float(before), abs(outcome.difference["v_gy"]))


def modal_opinion(base: Source, changes: Changes) -> Record:
    """The same plate by its lowest modes: values, the model's own estimate of its error, failed checks."""
    from tailslap.modal_analysis.run import modal_run

    try:
        found = modal_run(CornerCase(*vary(base, changes)).plan(), tolerance=1.0)
    except InputError as error:
        return {"refused": str(error)}
    except Exception as error:  # as above
        return {"refused": f"broke: {type(error).__name__}: {error}"}
    failed = list(failed_names(found.checks))
    return {"values": found.values, "estimate": found.estimate.total, "failed": failed}


def plate_row(frequency: float, record: Record, rigid: Mapping[str, float]) -> Record:
    """A plate as `points.csv` and the summary have it; its numbers are of the first start's finest mesh.

    record: of `measure`; rigid: the five quantities. What is not known is NaN, or None where it was not run.
    """
    meshes, modal = record["starts"][STARTS[0]], record["modal"]
    fine, half, thick = meshes[-1], record.get("half_patch", {}), record.get("thickness", {})
    thick = thick if "thickness" in thick else None
    half = half if half.get("values") and not half["failed"] else {}
    return {
        "first_frequency": frequency,
        "youngs_modulus": fine.get("youngs_modulus", math.nan),
        "passed": _passed(fine),
        "why": _why(fine),
        **{f"difference_{name}": value for name, value in _differences(fine, rigid).items()},
        "reaction_deviation": fine.get("reaction", math.nan),
        "stored_share": fine.get("stored", math.nan),
        **{f"error_{name}": mesh_error(meshes, name) for name in MEASURED},
        **{f"modal_{name}": value for name, value in _differences(modal, rigid).items()},
        "modal_estimate": modal.get("estimate", math.nan),
        "modal_apart": largest_relative(modal.get("values", {}), fine.get("values", {})),
        "modal_why": _why(modal),
        "damping_rate": fine.get("damping", 0.0),
        "deflection_ratio": fine.get("deflection_ratio", math.nan),
        "steps": fine.get("steps", 0),
        "half_patch_v_gy": _differences(half, rigid)["v_gy"],
        "thickness": thick and thick["thickness"],
        "thickness_apart": thick and largest_relative(thick["values"], meshes[1]["values"]),
        **{
            f"{start}:{name}": value
            for start, runs in record["starts"].items()
            for name, value in _start_row(runs, rigid).items()
        },
    }


def _start_row(runs: list[Record], rigid: Mapping[str, float]) -> Record:
    """A start of a plate: v_GY's difference at the strike, its largest until then, the error of that, t = 0."""
    fine = runs[-1]
    departure = fine.get("departure", dict.fromkeys(KEPT, math.nan))
    return {
        "v_gy": _differences(fine, rigid)["v_gy"],
        "v_gy_largest": fine.get("largest", math.nan),
        "v_gy_error": mesh_error(runs, "largest") if len(runs) > 1 else fine.get("error", math.nan),
        **{f"{name}_at_start": departure[name] for name in KEPT},
        "damping_rate": fine.get("damping", 0.0),
        "passed": _passed(fine),
        "why": _why(fine),
    }


def _differences(run: Record, rigid: Mapping[str, float]) -> dict[str, float]:
    values = run.get("values", {})
    return relative_difference(values, rigid) if values else dict.fromkeys(KEYS, math.nan)


def _passed(run: Record) -> bool:
    return "refused" not in run and not run["failed"]


def _why(run: Record) -> str:
    return str(run.get("refused", ", ".join(run.get("failed", []))))


def mesh_error(meshes: list[Record], name: str) -> float:
    """Numerical error of the finest mesh: its grid convergence index, and what damping and ringing add on every mesh.

    Of the five quantities it is relative, as their differences are; the others are ratios already.
    """
    values = [(mesh.get("values", {}) if name in KEYS else mesh).get(name, math.nan) for mesh in meshes]
    if not all(map(math.isfinite, values)) or 0.0 in values:
        return math.nan
    coarse, medium, fine = values
    index = convergence_index(fine, medium, coarse)
    return float(index * (1.0 if name in KEYS else abs(fine)) + meshes[-1]["unseen"])


def convergence_index(fine: float, medium: float, coarse: float) -> float:
    """Grid convergence index of the fine mesh; an observed order above that of the elements is luck, and not used."""
    found = grid_convergence((fine, medium, coarse), (2.0, 2.0))
    if found.behaviour != "converging" or found.order <= MAX_ORDER:
        return found.gci_fine
    return SAFETY_FACTOR * abs((fine - medium) / fine) / (2.0**MAX_ORDER - 1.0)


def impact_flexibility(
    case: ImpactCase, given: tuple[float, ...], place: Path, workers: int | None
) -> Flexibility:
    """Run every plate; an interrupted study of the same scene goes on from its journal. given: falling [Hz]."""
    began, own = time.perf_counter(), case.plan()
    patch = patch_length(case)
    along, across = own.plate.counts
    fixed: Changes = {"plate.youngs_modulus": None, "contact.patch_length": patch}
    sweep = {
        f"{f!r} Hz": (case.source, {**fixed, "plate.elements": (along, across), "plate.first_frequency": f})
        for f in given
    }
    fixed = {**fixed, "time.end": LONGER * case.duration}
    plates = {
        f"plate {f!r} Hz": (
            *(case.source, f),
            *(
                {**fixed, "plate.first_frequency": f, "plate.elements": (n * along, n * across)}
                for n in (1, 2)
            ),
        )
        for f in PLATES
    }
    definition = {"study": "flexibility", "scene": case.scene.model_dump(), "frequencies": given}
    with Journal(place, definition) as journal:
        run_parts(measure_impact, sweep, journal, f"{case.scene.name}: {len(sweep)} plates", workers)
        run_parts(measure_plate, plates, journal, f"{case.scene.name}: from 2 Hz to rigid", workers)
        rows = [impact_row(f, journal.records[key]) for f, key in zip(given, sweep, strict=True)]
        soft = [journal.records[key] for key in plates]
    levels = {name: _levels(impact_samples(rows, name), IMPACT_LEVELS) for name in NAMES}
    rigid = plate_record(math.inf, both_strikes(case.answer), {}, ())
    seconds = time.perf_counter() - began
    setup = {"patch_length": patch}
    return Flexibility(case, rows, levels, own.first_frequency, setup, seconds, {}, {}, [*soft, rigid])


def patch_length(case: ImpactCase) -> float:
    """Length of side that a corner's crush is spread over [m]: the scene's, or the study's."""
    return case.scene.needed_contact.patch_length or PATCH * case.scene.vehicle.length


def impact_row(frequency: float, record: Record) -> Record:
    """A plate as `points.csv` and the summary have it: FE/rigid - 1 and mesh error by `NAMES`, NaN where other corners
    strike; failed: the checks that did, or what refused it."""
    groups = {f"{group}.{name}": record[group][name] for group in ("difference", "error") for name in NAMES}
    return {"frequency": frequency, **groups, "failed": record["why"]}


def impact_samples(rows: Sequence[Record], name: str) -> list[Sample]:
    """The plates of one of `NAMES`, as the levels take them."""
    found = []
    for row in rows:
        size, error = abs(row[f"difference.{name}"]), abs(row[f"error.{name}"])
        found.append(Sample(row["frequency"], size, error, not row["failed"] and math.isfinite(size)))
    return found


def measure_impact(source: Source, changes: Changes) -> Record:
    """A plate's run beside the rigid vehicle's impact."""
    nothing = dict.fromkeys(NAMES, math.nan)
    try:
        outcome = ImpactCase(*vary(source, changes)).run()
    except InputError as error:
        return {"difference": nothing, "error": nothing, "why": str(error)}
    return {
        "difference": nothing | outcome.difference,
        "error": nothing | outcome.mesh_error,
        "why": ", ".join(_failed(outcome)),
    }


def measure_plate(source: Source, frequency: float, coarse: Changes, fine: Changes) -> Record:
    """Both strikes of a plate of this first frequency [Hz], as `COLUMNS` names them, on two meshes.

    errors: finer mesh over the coarser one, less one; failed: checks that did, or what refused the run.
    """
    try:
        rough, (values, failed) = (_strikes(ImpactCase(*vary(source, each))) for each in (coarse, fine))
    except InputError as error:
        return plate_record(frequency, {}, {}, (str(error),))
    return plate_record(frequency, values, {n: values[n] / rough[0][n] - 1.0 for n in COLUMNS}, failed)


def plate_record(
    frequency: float, values: Mapping[str, float], errors: Mapping[str, float], failed: tuple[str, ...]
) -> Record:
    """A plate as the summary has it; an infinite frequency is the rigid vehicle's. It passed where every check did, and
    both meshes agree."""
    sizes = [abs(value) for value in errors.values()]
    error = max(sizes) if sizes and all(map(math.isfinite, sizes)) else math.nan
    passed = not failed and (math.isinf(frequency) or error <= WORST)
    record: Record = {"frequency": frequency if math.isfinite(frequency) else None, "values": dict(values)}
    return record | {"errors": dict(errors), "failed": list(failed), "error": error, "passed": passed}


def _strikes(case: ImpactCase) -> tuple[dict[str, float], tuple[str, ...]]:
    """Values and failed checks of a single run; the filters take the force of the points nearest to each corner."""
    from tailslap.case.impact.run import attempt

    outcome = attempt(case)
    corner = nearest_corner(outcome.run.points, case.scene.vehicle.length)
    forces = {name: outcome.run.normal[:, corner == n].sum(axis=1) for n, name in enumerate(CORNERS)}
    return both_strikes(outcome.fe, forces), _failed(outcome)


def _failed(outcome: ImpactOutcome) -> tuple[str, ...]:
    from tailslap.case.impact.checks import failed_but_mesh

    return failed_but_mesh(outcome)
