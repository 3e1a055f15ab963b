"""Softest vehicle for which the rigid-body method still holds: plates from stiff to soft, and what follows.

Of a constrained corner three starts and three meshes a plate, the modal model beside them, and at some plates the
thickness in place of the modulus. Of a whole impact both strikes of each plate, and what is measured of them from 2 Hz
to rigid. A difference is known where its numerical error is small against it; then the report says down to which
first frequency it stays below a level. Where levels are crossed, the difference is scanned by further runs, because
it oscillates with the first frequency.
"""

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fem.start.start_kinds import START_KINDS
from postprocess.comparison.quantities import KEYS, largest_relative, relative_difference
from solver.impact import corner_name
from tailslap.campaign import engine, levels
from tailslap.campaign.convergence import Record, convergence_index, three_meshes
from tailslap.campaign.levels import PowerLaw, Reach, Sample
from tailslap.case import case_of, cost, model
from tailslap.case.case import failed_names
from tailslap.case.corner.case import CornerCase
from tailslap.case.corner.model import MIN_STEPS
from tailslap.case.impact.answers import COLUMNS, COMPARED, both_strikes
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.checks import failed_but_mesh
from tailslap.case.impact.run import attempt, corners_of
from tailslap.errors import InputError
from tailslap.modal_model import modal_run
from tailslap.scene import schema
from tailslap.scene.vary import Changes, Source, vary
from tailslap.studies.flexibility.scan import Scan, Series, scanned

# The softest plate of a constrained corner and of a whole impact.
LOWEST, IMPACT_LOWEST = "0.1 Hz", "2 Hz"

# Differences for which the lowest first frequency is sought.
LEVELS, IMPACT_LEVELS = (1e-3, 1e-2, 5e-2, 1e-1), (1e-2, 5e-2, 1e-1)

# The starts that are run, whatever the scene's own; the first with modal model and thicknesses beside it.
STARTS = ("inertia-relief", "inertia-relief-momenta", "unstressed")

# Velocities that a start may keep: of the centre of mass, of rotation, of the corner along the wall.
KEPT = ("v_gx", "v_gy", "omega", "v_p")

# Quantities that are measured of a plate, and their columns.
MEASURED = {name: f"difference_{name}" for name in KEYS}
MEASURED |= {"reaction": "reaction_deviation", "stored": "stored_share"}

# The check that the study makes itself, by its own levels.
JUDGED = "numerical error"

# Length of the corner's patch, or of side that a corner's crush is spread over, over the vehicle's, where the
# scene gives none: a point has no finite compliance, and meshes would not converge.
PATCH = 0.1

# Expected seconds of a time loop above which a run is left out.
TOO_LONG = 120.0

# Function of a study under way from a group of parts to their results.
Results = Callable[[engine.Group], dict[str, Any]]

# Places in the sweep where it is repeated by the thickness, from the stiffest (0) to the softest (1).
THICKNESSES = (1 / 6, 1 / 2, 5 / 6)

# Rows of the history of a start that oscillates, a period of the first frequency: enough to see its largest
# swing.
ROWS_A_PERIOD, MAX_ROWS = 12, 20_000

# Quantities that are compared of a whole impact, as `tailslap.case.impact.answers` names it.
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
    scan : list of dict
        Signed differences of the runs where levels are crossed, as `scan.csv` has them.
    step : float
        Resolution of the scan [Hz].
    """

    case: Any
    rows: list[Record]
    levels: Mapping[str, tuple[Reach, ...]]
    own_frequency: float
    setup: Record
    seconds: float
    others: Mapping[str, tuple[Reach, ...]]
    laws: Mapping[str, PowerLaw | None]
    plates: Sequence[Record] = ()
    scan: Sequence[Record] = ()
    step: float = math.nan

    @property
    def band(self) -> tuple[Reach, ...]:
        """Levels that hold for each of the series of `levels`."""
        return tuple(levels.jointly(each) for each in zip(*self.levels.values(), strict=True))


def compute(
    case: Any, place: Path, points: int, lowest: str | None, highest: str, workers: int | None
) -> Flexibility:
    """The study as the command line asks for it."""
    impact = case.scene.contact is not None
    given = levels.frequencies(lowest or (IMPACT_LOWEST if impact else LOWEST), highest, points)
    return (impact_flexibility if impact else corner_flexibility)(case, given, place, workers)


class Sweep(NamedTuple):
    """Runs of a corner. meshes: coarse to fine, each twice the last; support: how the corner is held."""

    case: CornerCase
    fe_plan: Any
    meshes: tuple[tuple[int, int], ...]
    support: Record

    @property
    def own(self) -> tuple[float, float, float]:
        """Thickness [m], density [kg/m^3] and modulus [Pa] of the scene's own plate."""
        plate = self.fe_plan.plate
        return plate.thickness, model.plate_density(self.case.scene, plate), plate.modulus


def define(case: CornerCase) -> Sweep:
    """The sweep of a scene. Raises InputError for keys that make no model."""
    fe_plan = case.plan()
    meshes = three_meshes(fe_plan.case.scene)
    return Sweep(case, fe_plan, meshes, corner_support(case.scene, meshes[0]))


def corner_support(scene: schema.Scene, coarsest: tuple[int, int]) -> Record:
    """The scene's own constraint and patch where it gives them, else the exact one over a patch of whole elements."""
    corner, element = scene.corner, scene.vehicle.length / coarsest[0]
    own = not corner.constraint_is_open
    patch = corner.patch_length or max(1, round(PATCH * scene.vehicle.length / element)) * element
    given = {"own_constraint": own, "own_patch": corner.patch_length is not None}
    return {"constraint": corner.constraint if own else "exact", "patch": patch, **given}


def run_changes(sweep: Sweep, frequency: float, elements: tuple[int, int], start: str = STARTS[0]) -> Changes:
    """Changes that give the scene this first frequency [Hz], mesh and start, and the study's support of the corner."""
    element = sweep.fe_plan.plate.element
    changes: Record = {"plate.youngs_modulus": None, "plate.first_frequency": frequency}
    changes |= {"plate.elements": elements, "plate.element": element, "plate.start": start}
    # Not verified: plates that differ from the rigid body are the subject, and no failure.
    changes |= {"wall": None, "verify": None, "corner.patch_length": sweep.support["patch"]}
    if not sweep.support["own_constraint"]:
        changes["corner.constraint"] = sweep.support["constraint"]
    if not START_KINDS[start].relieved:  # rows that show every swing
        swings = math.ceil(ROWS_A_PERIOD * frequency * sweep.case.motion.strike.t)
        changes["time.rows"] = max(sweep.case.scene.time.rows, min(MAX_ROWS, swings))
    return changes


def mesh_changes(sweep: Sweep, frequency: float, start: str) -> list[Changes | None]:
    """Changes of a start's runs, coarse to fine; None for one that would take too long."""
    found: list[Changes | None] = []
    own = sweep.fe_plan
    for elements in sweep.meshes:
        finer = elements[0] / own.plate.counts[0]
        steps = max(MIN_STEPS, own.expected_steps * finer * frequency / own.first_frequency)
        expected = cost.loop_seconds(sweep.case.scene, own.plate.element, elements, steps)
        found.append(run_changes(sweep, frequency, elements, start) if expected <= TOO_LONG else None)
    return found


def corner_flexibility(case: Any, given: Sequence[float], place: Path, workers: int | None) -> Flexibility:
    """Every plate of a constrained corner. given: first frequencies, falling [Hz]."""
    began, sweep, parts = time.perf_counter(), define(case), {}
    thin = {round(part * (len(given) - 1)) for part in THICKNESSES}
    for number, frequency in enumerate(given):
        starts = {name: mesh_changes(sweep, frequency, name) for name in STARTS}
        modal = {**run_changes(sweep, frequency, sweep.meshes[-1]), "damping": None}
        own, half = sweep.own if number in thin else None, number == len(given) // 2
        parts[f"{frequency!r} Hz"] = (case.source, starts, modal, own, half)
    definition = {"study": "flexibility", "scene": case.scene.model_dump(), "frequencies": given}
    with engine.study(place, definition | {"starts": STARTS}, workers) as results:
        records = results((measure, parts, f"{len(parts)} plates"))
        rows = [
            plate_row(f, record, case.tail_slap) for f, record in zip(given, records.values(), strict=True)
        ]
        scans = {
            start: start_scan(sweep, results, series, start) for start, series in all_series(rows).items()
        }
    return summed_up(sweep, rows, scans, time.perf_counter() - began)


def all_series(rows: Sequence[Record]) -> dict[str, dict[str, list[Sample]]]:
    """Return the samples whose levels are sought, by start: v_GY of each, of the first the others too."""
    series = {start: {"v_gy": start_samples(rows, start)} for start in STARTS}
    series[STARTS[0]] |= {name: samples_of(rows, name) for name in MEASURED if name not in ("v_gy", "stored")}
    return series


def start_scan(sweep: Sweep, results: Results, series: Series, start: str) -> Scan:
    """A start's differences where they cross the levels, on the finest mesh."""
    case = sweep.case

    def differences(frequencies: Sequence[float]) -> dict[float, Record]:
        parts = {
            f"scan {start} {f!r} Hz": (case.source, scan_changes(mesh_changes(sweep, f, start)[-1]))
            for f in frequencies
        }
        records = results((one_run, parts, f"scan of {start}"))
        rows = [scan_row(record, case.tail_slap) for record in records.values()]
        return dict(zip(frequencies, rows, strict=True))

    return scanned(series, LEVELS, 1.0 / case.motion.strike.t, differences)


def scan_changes(changes: Changes | None) -> Changes | None:
    """The changes of a run without companions."""
    if changes is None:
        return None
    return {name: value for name, value in changes.items() if name != "verify"} | {
        "verify.tolerance": None,
        "verify.companion": False,
    }


def scan_row(record: Record, rigid: Mapping[str, float]) -> Record:
    """Differences of a run by name, NaN where a check failed; of v_GY the largest."""
    if not _passed(record):
        return dict.fromkeys(MEASURED, math.nan)
    return {**_differences(record, rigid), "v_gy": record["largest"], "reaction": record["reaction"]}


def summed_up(sweep: Sweep, rows: list[Record], scans: Mapping[str, Scan], seconds: float) -> Flexibility:
    """Levels and power laws of these plates; scans: by start."""
    starts = {name: levels.reaches(scan.samples["v_gy"], LEVELS) for name, scan in scans.items()}
    first = scans[STARTS[0]].samples
    others = {name: levels.reaches(samples, LEVELS) for name, samples in first.items() if name != "v_gy"}
    laws = {name: levels.power_law(samples_of(rows, name)) for name in MEASURED}
    setup, own = {"corner": sweep.support, "meshes": sweep.meshes}, sweep.fe_plan.first_frequency
    scan_rows = [row for start, scan in scans.items() for row in listed_scan(scan, first, start=start)]
    step = scans[STARTS[0]].step
    return Flexibility(sweep.case, rows, starts, own, setup, seconds, others, laws, scan=scan_rows, step=step)


def listed_scan(scan: Scan, names: Iterable[str], **head: str) -> list[Record]:
    """Return the rows of a scan for `scan.csv`, with the same columns for every start."""
    return [
        {**head, "first_frequency": frequency, **{f"difference_{name}": row[name] for name in names}}
        for frequency, row in scan.differences.items()
    ]


def samples_of(rows: Sequence[Record], name: str) -> list[Sample]:
    """The plates of one of `MEASURED`, at the strike of the first start, as levels and power law take them."""
    column, error = MEASURED[name], f"error_{name}"
    return [Sample(row["first_frequency"], abs(row[column]), row[error], row["passed"]) for row in rows]


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


def measure(base: Source, starts: Record, modal: Changes, own: Any, half: bool) -> Record:
    """The record of a plate.

    Parameters
    ----------
    base : Source
        Of the scene.
    starts : dict
        Changes of each start's runs, coarse to fine; None for one that is left out.
    modal : dict
        Changes of the modal model.
    own : tuple of float, optional
        The scene's section; the first start's middle mesh is then run once more by its thickness.
    half : bool
        True if the finest mesh is run once more, held over half the length.
    """
    runs = {name: [one_run(base, changes) for changes in meshes] for name, meshes in starts.items()}
    record: Record = {"starts": runs, "modal": one_run(base, modal, modal_record)}
    _, middle, finest = starts[STARTS[0]]
    if half and finest is not None:
        patch = 0.5 * finest["corner.patch_length"]
        record["half_patch"] = one_run(base, {**finest, "corner.patch_length": patch})
    modulus = runs[STARTS[0]][1].get("youngs_modulus")
    if own and middle and modulus:
        record["thickness"] = one_run(base, thickness_changes(middle, modulus, own))
    return record


def thickness_changes(changes: Changes, modulus: float, own: tuple[float, float, float]) -> Changes:
    """Changes to the plate whose modulus is this [Pa], with the scene's own modulus and the thickness for it.

    E t stays, and so does density times thickness, which is the mass.
    """
    thickness, density, youngs_modulus = own
    ratio = modulus / youngs_modulus
    section = {"plate.thickness": thickness * ratio, "plate.density": density / ratio}
    return {**changes, "plate.first_frequency": None, **section, "plate.youngs_modulus": youngs_modulus}


def fe_record(case: CornerCase) -> Record:
    """Values, failed checks, reaction, stored energy of a run. Its error is no failure: levels are held to it."""
    outcome = case.run()
    fe_plan, error, fe, rigid = outcome.fe_plan, outcome.error, outcome.fe_history, outcome.rigid_history
    known = np.isfinite(rigid["reaction_normal"])
    ours, theirs = (history["reaction_normal"][known] for history in (fe, rigid))
    with np.errstate(all="ignore"):
        reaction = float(np.abs(ours - theirs).max() / np.abs(theirs).max())
    return {
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
        "unseen": error.damping + outcome.ringing,
        "steps": outcome.run.steps,
    }


def largest_difference(outcome: Any) -> float:
    """Largest difference of v_GY from the rigid body, at the strike and at any instant before it, over v_GY at the
    strike: an oscillating plate may strike in any phase. NaN without a strike."""
    if not outcome.fe:
        return math.nan
    ours, rigid = outcome.fe_history["v_gy"], outcome.rigid_history["v_gy"]
    before = np.nanmax(np.abs(ours - rigid)) / abs(outcome.rigid["v_gy"])
    return max(float(before), abs(outcome.difference["v_gy"]))


def one_run(base: Source, changes: Changes | None, take: Callable[[Any], Record] = fe_record) -> Record:
    """Record that `take` makes of the changed case; `refused` says why there is none."""
    if changes is None:
        return {"refused": "omitted: the estimated time exceeds the limit"}
    try:
        return take(case_of(*vary(base, changes)))
    except InputError as error:
        return {"refused": str(error)}
    except Exception as error:  # one plate must not end the study; it is shown as failed
        return {"refused": f"broke: {type(error).__name__}: {error}"}


def modal_record(case: CornerCase) -> Record:
    """The plate by its lowest modes: values, the model's own estimate of its error, failed checks."""
    found = modal_run(case.plan(), tolerance=1.0)
    failed = failed_names(found.checks)
    return {"values": found.values, "estimate": found.estimate.total, "failed": list(failed)}


def plate_row(frequency: float, record: Record, rigid: Mapping[str, float]) -> Record:
    """A plate as `points.csv` and the summary have it; its numbers are of the first start's finest mesh.

    record: of `measure`; rigid: the five quantities. What is not known is NaN, or None where it was not run.
    """
    meshes, modal, nan = record["starts"][STARTS[0]], record["modal"], math.nan
    fine, half, thick = meshes[-1], record.get("half_patch", {}), record.get("thickness", {})
    half = half if half.get("values") and not half["failed"] else {}
    row: Record = {"first_frequency": frequency, "youngs_modulus": fine.get("youngs_modulus", nan)}
    row |= {"passed": _passed(fine), "why": _why(fine)}
    row |= {f"difference_{name}": value for name, value in _differences(fine, rigid).items()}
    row |= {"reaction_deviation": fine.get("reaction", nan), "stored_share": fine.get("stored", nan)}
    row |= {f"error_{name}": mesh_error(meshes, name) for name in MEASURED}
    row |= {f"modal_{name}": value for name, value in _differences(modal, rigid).items()}
    row |= {"modal_estimate": modal.get("estimate", nan)}
    row |= {"modal_apart": largest_relative(modal.get("values", {}), fine.get("values", {}))}
    row |= {"modal_why": _why(modal), "damping_rate": fine.get("damping", 0.0)}
    row |= {"deflection_ratio": fine.get("deflection_ratio", nan), "steps": fine.get("steps", 0)}
    row |= {"half_patch_v_gy": _differences(half, rigid)["v_gy"], "thickness": thick.get("thickness")}
    apart = largest_relative(thick["values"], meshes[1]["values"]) if "thickness" in thick else None
    row |= {"thickness_apart": apart}
    for start, runs in record["starts"].items():
        row |= {f"{start}:{name}": value for name, value in _start_row(runs, rigid).items()}
    return row


def _start_row(runs: list[Record], rigid: Mapping[str, float]) -> Record:
    """A start of a plate: v_GY's difference at the strike, its largest until then, the error of that, t = 0."""
    fine = runs[-1]
    departure = fine.get("departure", dict.fromkeys(KEPT, math.nan))
    error = mesh_error(runs, "largest") if len(runs) > 1 else fine.get("error", math.nan)
    row = {"v_gy": _differences(fine, rigid)["v_gy"], "v_gy_largest": fine.get("largest", math.nan)}
    row |= {"v_gy_error": error, **{f"{name}_at_start": departure[name] for name in KEPT}}
    return row | {"damping_rate": fine.get("damping", 0.0), "passed": _passed(fine), "why": _why(fine)}


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
    index = convergence_index(*reversed(values))
    return float(index * (1.0 if name in KEYS else abs(values[-1])) + meshes[-1]["unseen"])


def impact_flexibility(case: Any, given: Sequence[float], place: Path, workers: int | None) -> Flexibility:
    """Every plate of a whole impact. given: first frequencies, falling [Hz]."""
    began, own, patch = time.perf_counter(), case.plan(), patch_length(case)
    along, across = own.plate.counts
    fixed: Changes = {"plate.youngs_modulus": None, "contact.patch_length": patch}

    def plate(frequency: float, finer: int = 1, **more: Any) -> Changes:
        elements = (finer * along, finer * across)
        return {**fixed, "plate.elements": elements, "plate.first_frequency": frequency, **more}

    end = {"time.end": LONGER * case.duration}
    sweep = {f"{f!r} Hz": (case.source, plate(f), strike_record) for f in given}
    plates = {f"plate {f!r} Hz": (case.source, f, *(plate(f, n, **end) for n in (1, 2))) for f in PLATES}
    definition = {"study": "flexibility", "scene": case.scene.model_dump(), "frequencies": given}

    def differences(frequencies: Sequence[float]) -> dict[float, Record]:
        parts = {
            f"scan {f!r} Hz": (case.source, plate(f, **{"verify.companion": False}), strike_record)
            for f in frequencies
        }
        records = results((one_run, parts, "scan")).values()
        return {f: strike_differences(record) for f, record in zip(frequencies, records, strict=True)}

    with engine.study(place, definition, workers) as results:
        records = results((one_run, sweep, f"{len(sweep)} plates"))
        soft = results((measure_plate, plates, "from 2 Hz to rigid"))
        rows = [impact_row(f, record) for f, record in zip(given, records.values(), strict=True)]
        series = {name: impact_samples(rows, name) for name in NAMES}
        scan = scanned(series, IMPACT_LEVELS, 1.0 / second_end(case), differences)
    reached = {name: levels.reaches(samples, IMPACT_LEVELS) for name, samples in scan.samples.items()}
    rigid, seconds = plate_record(math.inf, both_strikes(case.answer), {}, ()), time.perf_counter() - began
    setup, measured = {"patch_length": patch}, [*soft.values(), rigid]
    return Flexibility(
        *(case, rows, reached, own.first_frequency, setup, seconds, {}, {}, measured),
        scan=listed_scan(scan, scan.samples),
        step=scan.step,
    )


def second_end(case: ImpactCase) -> float:
    """End of the rigid vehicle's second strike, or of its motion without one [s]."""
    return float(case.motion.strikes[1].end if len(case.motion.strikes) > 1 else case.duration)


def strike_differences(record: Record) -> Record:
    """Differences of a run by name, NaN where a check failed or other corners strike."""
    known = record["difference"] if _passed(record) else {}
    return {name: known.get(name, math.nan) for name in NAMES}


def patch_length(case: ImpactCase) -> float:
    """Length of side that a corner's crush is spread over [m]: the scene's, or the study's."""
    return case.scene.needed_contact.patch_length or PATCH * case.scene.vehicle.length


def impact_row(frequency: float, record: Record) -> Record:
    """A plate as `points.csv` and the summary have it: FE/rigid - 1 and mesh error by `NAMES`, NaN where other corners
    strike; failed: the checks that did, or what refused it."""
    row: Record = {"frequency": frequency}
    for group in ("difference", "error"):
        row |= {f"{group}.{name}": record.get(group, {}).get(name, math.nan) for name in NAMES}
    return row | {"failed": _why(record)}


def impact_samples(rows: Sequence[Record], name: str) -> list[Sample]:
    """The plates of one of `NAMES`, as the levels take them."""
    found = []
    for row in rows:
        size, error = abs(row[f"difference.{name}"]), abs(row[f"error.{name}"])
        found.append(Sample(row["frequency"], size, error, not row["failed"] and math.isfinite(size)))
    return found


def strike_record(case: ImpactCase) -> Record:
    """A plate's run beside the rigid vehicle's impact. Its mesh error is no failure: levels are held to it."""
    outcome = case.run()
    found = {"difference": outcome.difference, "error": outcome.mesh_error}
    return found | {"failed": list(failed_but_mesh(outcome))}


def measure_plate(source: Source, frequency: float, coarse: Changes, fine: Changes) -> Record:
    """Both strikes of a plate of this first frequency [Hz], as `COLUMNS` names them, on two meshes.

    errors: finer mesh over the coarser one, less one; failed: checks that did, or what refused the run.
    """
    rough, found = (one_run(source, each, both_record) for each in (coarse, fine))
    if refused := rough.get("refused") or found.get("refused"):
        return plate_record(frequency, {}, {}, (refused,))
    values = found["values"]
    errors = {name: values[name] / rough["values"][name] - 1.0 for name in COLUMNS}
    return plate_record(frequency, values, errors, found["failed"])


def both_record(case: ImpactCase) -> Record:
    """Values and failed checks of a single run; the filters take the force of the points nearest to each corner."""
    outcome = attempt(case)
    corner, push = corners_of(outcome.fe_plan, outcome.run), outcome.run.normal
    forces = {corner_name(*divmod(int(n), 4)): push[:, corner == n].sum(axis=1) for n in np.unique(corner)}
    return {"values": both_strikes(outcome.fe, forces), "failed": failed_but_mesh(outcome)}


def plate_record(
    frequency: float, values: Mapping[str, float], errors: Mapping[str, float], failed: Sequence[str]
) -> Record:
    """A plate as the summary has it; an infinite frequency is the rigid vehicle's. It passed where every check did, and
    both meshes agree."""
    sizes = [abs(value) for value in errors.values()]
    error = max(sizes) if sizes and all(map(math.isfinite, sizes)) else math.nan
    passed = not failed and (math.isinf(frequency) or error <= WORST)
    record: Record = {"frequency": frequency if math.isfinite(frequency) else None, "values": dict(values)}
    return record | {"errors": dict(errors), "failed": list(failed), "error": error, "passed": passed}
