"""Flexibility of plates with a constrained corner.

Each plate is run with three starts on three meshes. A difference is known where its numerical error is small compared
to it. Where levels are crossed, further runs scan the difference, which oscillates over the first frequency.
"""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.start.start_kinds import START_KINDS
from postprocess.comparison.grid_convergence import convergence_index
from postprocess.comparison.quantities import KEYS, relative_difference
from tailslap.campaign import engine, levels
from tailslap.campaign.levels import Sample
from tailslap.campaign.records import Record
from tailslap.case import resources
from tailslap.case.check import failed_names
from tailslap.case.corner import corner_run
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.case.corner.static_models import MIN_STEPS
from tailslap.case.plate_input import three_meshes
from tailslap.scene import schema
from tailslap.scene.vary import Changes, Source
from tailslap.studies.flexibility import plate_runs
from tailslap.studies.flexibility.flexibility_scan import Scan, Series, scanned
from tailslap.studies.flexibility.plate_runs import Flexibility, one_run

LEVELS = (1e-3, 1e-2, 5e-2, 1e-1)
"""Differences for which the lowest first frequency is sought."""


STARTS = ("inertia-relief", "inertia-relief-momenta", "unstressed")
"""Starts of all plates."""

CONSERVED = ("v_gx", "v_gy", "omega", "v_p")
"""Velocities that a start may conserve, of centre of mass, rotation and corner."""

MEASURED = {name: f"difference_{name}" for name in KEYS}
"""Columns of the measured quantities."""
MEASURED |= {"reaction": "reaction_deviation", "stored": "stored_share"}

REPLACED_CHECK = "numerical error"
"""Check that is replaced by the levels of the study."""


TOO_LONG = 120.0
"""Expected time of a time loop above which a run is omitted [s]."""


ROWS, ROWS_A_PERIOD, MAX_ROWS = 200, 12, 20_000
"""Least rows of history, rows per period of the first frequency of an oscillation, and most rows."""


class Sweep(NamedTuple):
    """Runs of a constrained corner.

    The meshes are ordered from coarse to fine, each twice as fine. `support` is the support of the corner.
    """

    case: CornerCase
    fe_plan: CornerPlan
    meshes: tuple[tuple[int, int], ...]
    support: Record


def define(case: CornerCase) -> Sweep:
    """Plan the runs of a scene.

    Raises InputError for invalid keys.
    """
    fe_plan = case.plan()
    meshes = three_meshes(fe_plan.case.scene)
    return Sweep(case, fe_plan, meshes, corner_support(case.scene, meshes[0]))


def corner_support(scene: schema.Scene, coarsest: tuple[int, int]) -> Record:
    """Return constraint and patch of the corner.

    They are those of the scene where it has them, otherwise the exact constraint over a patch of whole elements.
    """
    corner, element = scene.corner, scene.vehicle.length / coarsest[0]
    from_scene = not corner.constraint_is_open
    patch = corner.patch_length or max(1, round(plate_runs.PATCH * scene.vehicle.length / element)) * element
    origins = {"own_constraint": from_scene, "own_patch": corner.patch_length is not None}
    return {"constraint": corner.constraint if from_scene else "exact", "patch": patch, **origins}


def run_changes(sweep: Sweep, frequency: float, elements: tuple[int, int], start: str = STARTS[0]) -> Changes:
    """Return the changes of a run.

    They set first frequency [Hz], mesh, start and support of the corner.
    """
    element = sweep.fe_plan.plate.element
    changes: Record = {"plate.youngs_modulus": None, "plate.first_frequency": frequency}
    changes |= {"plate.elements": elements, "plate.element": element, "plate.start": start}
    # Differences from the rigid body are the subject and no failure.
    changes |= {"wall": None, "verify": None, "corner.patch_length": sweep.support["patch"]}
    if not sweep.support["own_constraint"]:
        changes["corner.constraint"] = sweep.support["constraint"]
    periods = 0.0 if START_KINDS[start].relieved else frequency * sweep.case.motion.strike.t
    return changes | {"time.rows": max(ROWS, min(MAX_ROWS, math.ceil(ROWS_A_PERIOD * periods)))}


def mesh_changes(sweep: Sweep, frequency: float, start: str) -> list[Changes | None]:
    """Return the changes of each mesh.

    They are None for a run that would take too long.
    """
    mesh_runs: list[Changes | None] = []
    fe_plan = sweep.fe_plan
    for elements in sweep.meshes:
        finer = elements[0] / fe_plan.plate.counts[0]
        steps = max(MIN_STEPS, fe_plan.expected_steps * finer * frequency / fe_plan.first_frequency)
        expected = resources.loop_seconds(sweep.case.scene, fe_plan.plate.element, elements, steps)
        mesh_runs.append(run_changes(sweep, frequency, elements, start) if expected <= TOO_LONG else None)
    return mesh_runs


def corner_flexibility(
    case: CornerCase, frequencies: Sequence[float], place: Path, workers: int | None
) -> Flexibility:
    """Run plates of these first frequencies, falling [Hz]."""
    began, sweep, parts = time.perf_counter(), define(case), {}
    for frequency in frequencies:
        starts = {name: mesh_changes(sweep, frequency, name) for name in STARTS}
        parts[f"{frequency!r} Hz"] = (case.source, starts)
    definition = {"study": "flexibility", "scene": case.scene.model_dump(), "frequencies": frequencies}
    with engine.study(place, definition | {"starts": STARTS}, workers) as results:
        records = results((measure, parts, f"{len(parts)} plates"))
        rows = [
            plate_row(f, record, case.tail_slap)
            for f, record in zip(frequencies, records.values(), strict=True)
        ]
        scans = {
            start: start_scan(sweep, results, series, start) for start, series in all_series(rows).items()
        }
    return corner_result(sweep, rows, scans, time.perf_counter() - began)


def all_series(rows: Sequence[Record]) -> dict[str, dict[str, list[Sample]]]:
    """Return the samples by start and quantity.

    Of all starts, this is v_GY, of the first also the other quantities.
    """
    series = {start: {"v_gy": start_samples(rows, start)} for start in STARTS}
    series[STARTS[0]] |= {name: samples_of(rows, name) for name in MEASURED if name not in ("v_gy", "stored")}
    return series


def start_scan(sweep: Sweep, results: plate_runs.Results, series: Series, start: str) -> Scan:
    """Scan the differences of a start on the finest mesh."""
    case = sweep.case

    def differences(frequencies: Sequence[float]) -> dict[float, Record]:
        changes = [scan_changes(mesh_changes(sweep, f, start)[-1]) for f in frequencies]
        names = [f"scan {start} {f!r} Hz" for f in frequencies]
        parts = {name: (case.source, run, fe_record) for name, run in zip(names, changes, strict=True)}
        records = results((one_run, parts, f"scan of {start}"))
        rows = [scan_row(record, case.tail_slap) for record in records.values()]
        return dict(zip(frequencies, rows, strict=True))

    return scanned(series, LEVELS, 1.0 / case.motion.strike.t, differences)


def scan_changes(changes: Changes | None) -> Changes | None:
    """Return the changes of a run without companions."""
    if changes is None:
        return None
    return {name: value for name, value in changes.items() if name != "verify"} | {
        "verify.tolerance": None,
        "verify.companion": False,
    }


def scan_row(record: Record, rigid: Mapping[str, float]) -> Record:
    """Return the differences of a run by quantity.

    They are NaN where a check failed. The difference of v_GY is the largest.
    """
    if not plate_runs.run_passed(record):
        return dict.fromkeys(MEASURED, math.nan)
    return {**_differences(record, rigid), "v_gy": record["largest"], "reaction": record["reaction"]}


def corner_result(sweep: Sweep, rows: list[Record], scans: Mapping[str, Scan], seconds: float) -> Flexibility:
    """Return the result with levels."""
    starts = {name: levels.reaches(scan.samples["v_gy"], LEVELS) for name, scan in scans.items()}
    first = scans[STARTS[0]].samples
    names = [name for name in first if name != "v_gy"]
    other_levels = {name: levels.reaches(first[name], LEVELS) for name in names}
    setup, nominal = {"corner": sweep.support, "meshes": sweep.meshes}, sweep.fe_plan.first_frequency
    listed = [plate_runs.listed_scan(scan, first, start=start) for start, scan in scans.items()]
    result = Flexibility(sweep.case, rows, starts, nominal, setup, seconds, other_levels)
    return replace(result, scan=[*chain(*listed)], step=scans[STARTS[0]].step)


def samples_of(rows: Sequence[Record], name: str) -> list[Sample]:
    """Return the samples of one of `MEASURED` with inertia relief."""
    column, error = MEASURED[name], f"error_{name}"
    return [Sample(row["first_frequency"], abs(row[column]), row[error], row["passed"]) for row in rows]


def start_samples(rows: Sequence[Record], start: str) -> list[Sample]:
    """Return a start's largest differences of v_GY.

    A difference is not less than that of a stiffer plate, since it is small only locally where its sign changes.
    """
    samples, largest = [], 0.0
    for row in rows:
        size, error, passed = (row[f"{start}:{name}"] for name in ("v_gy_largest", "v_gy_error", "passed"))
        largest = max(largest, size) if passed else largest
        samples.append(Sample(row["first_frequency"], largest, error, passed))
    return samples


def measure(base: Source, starts: Record) -> Record:
    """Return the records of a plate by start.

    base: source of the scene; starts: changes of each start from coarse to fine, None for an omitted run.
    """
    return {name: mesh_records(base, meshes) for name, meshes in starts.items()}


def mesh_records(base: Source, meshes: Sequence[Changes | None]) -> list[Record]:
    """Return the records of runs on meshes, each twice as fine.

    The other meshes are the companions of each run.
    """
    runs = [one_run(base, changes, corner_run.damped_run) for changes in meshes]

    def record(number: int, run: CornerOutcome) -> Record:
        companions = tuple(
            corner_run.compared(run, companion, 2.0 ** (place - number))
            for place, companion in enumerate(runs)
            if run.fe and place != number and isinstance(companion, CornerOutcome)
        )
        return outcome_record(corner_run.checked(replace(run, companions=companions)))

    return [
        plate_runs.or_refused(partial(record, number, run)) if isinstance(run, CornerOutcome) else run
        for number, run in enumerate(runs)
    ]


def fe_record(case: CornerCase) -> Record:
    """Return the record of a finite-element run."""
    return outcome_record(case.run())


def outcome_record(outcome: CornerOutcome) -> Record:
    """Return the record of an outcome.

    Its numerical error is compared with the levels and is no failure.
    """
    fe_plan, fe, rigid = outcome.fe_plan, outcome.fe_history, outcome.rigid_history
    finite = np.isfinite(rigid["reaction_normal"])
    fe_reaction, rigid_reaction = (history["reaction_normal"][finite] for history in (fe, rigid))
    with np.errstate(all="ignore"):
        reaction = float(np.abs(fe_reaction - rigid_reaction).max() / np.abs(rigid_reaction).max())
    return {
        "youngs_modulus": fe_plan.plate.youngs_modulus,
        "damping": getattr(fe_plan.model.parameters.elastic_damping, "rate", 0.0),
        "values": outcome.fe,
        "failed": [name for name in failed_names(outcome.checks) if name != REPLACED_CHECK],
        "departure": {name: float(fe[name][0] / rigid[name][0] - 1.0) for name in CONSERVED},
        "largest": largest_difference(outcome),
        "reaction": reaction,
        "stored": float(fe["strain_energy"].max() / fe["kinetic_energy"][0]),
        "deflection_ratio": fe_plan.deflection_ratio,
        "unresolved": outcome.error.damping + outcome.ringing,
        "steps": outcome.run.steps,
    }


def largest_difference(outcome: CornerOutcome) -> float:
    """Return the largest difference of v_GY up to the tail-slap.

    It is relative to v_GY at the tail-slap, since an oscillating plate may strike in any phase. It is NaN without a
    tail-slap.
    """
    if not outcome.fe:
        return math.nan
    fe, rigid = outcome.fe_history["v_gy"], outcome.rigid_history["v_gy"]
    before = np.nanmax(np.abs(fe - rigid)) / abs(outcome.rigid["v_gy"])
    return max(float(before), abs(outcome.difference["v_gy"]))


def plate_row(frequency: float, record: Record, rigid: Mapping[str, float]) -> Record:
    """Return a plate as in `points.csv` and the summary.

    Numbers are of the finest mesh of the first start, NaN where unknown and None where not run. frequency: first one
    [Hz]; record: of `measure`; rigid: the five quantities of the rigid body.
    """
    meshes, nan = record[STARTS[0]], math.nan
    fine = meshes[-1]
    row: Record = {"first_frequency": frequency, "youngs_modulus": fine.get("youngs_modulus", nan)}
    row |= {"passed": plate_runs.run_passed(fine), "why": plate_runs.failure_text(fine)}
    row |= {f"difference_{name}": value for name, value in _differences(fine, rigid).items()}
    row |= {"reaction_deviation": fine.get("reaction", nan), "stored_share": fine.get("stored", nan)}
    row |= {f"error_{name}": mesh_error(meshes, name) for name in MEASURED}
    row |= {"damping_rate": fine.get("damping", 0.0), "steps": fine.get("steps", 0)}
    row |= {"deflection_ratio": fine.get("deflection_ratio", nan)}
    for start, runs in record.items():
        row |= {f"{start}:{name}": value for name, value in _start_row(runs, rigid).items()}
    return row


def _start_row(runs: list[Record], rigid: Mapping[str, float]) -> Record:
    """Return the differences of v_GY and velocities of a start."""
    fine = runs[-1]
    departure = fine.get("departure", dict.fromkeys(CONSERVED, math.nan))
    error = mesh_error(runs, "largest")
    row = {"v_gy": _differences(fine, rigid)["v_gy"], "v_gy_largest": fine.get("largest", math.nan)}
    row |= {"v_gy_error": error, **{f"{name}_at_start": departure[name] for name in CONSERVED}}
    row |= {"damping_rate": fine.get("damping", 0.0), "passed": plate_runs.run_passed(fine)}
    return row | {"why": plate_runs.failure_text(fine)}


def _differences(run: Record, rigid: Mapping[str, float]) -> dict[str, float]:
    """Return the differences of a run, NaN without values."""
    values = run.get("values", {})
    return relative_difference(values, rigid) if values else dict.fromkeys(KEYS, math.nan)


def mesh_error(meshes: list[Record], name: str) -> float:
    """Return the numerical error of the finest mesh.

    It is the grid convergence index plus the effects of damping and ringing, which are present on every mesh. Of the
    five quantities it is relative. The others are ratios already.
    """
    values = [(mesh.get("values", {}) if name in KEYS else mesh).get(name, math.nan) for mesh in meshes]
    if not all(map(math.isfinite, values)) or 0.0 in values:
        return math.nan
    index = convergence_index(*reversed(values))
    return float(index * (1.0 if name in KEYS else abs(values[-1])) + meshes[-1]["unresolved"])
