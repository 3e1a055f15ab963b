"""Flexibility of plates in a whole impact.

Both strikes of each plate are compared with those of the rigid vehicle. Forces are measured on plates from 2 Hz to
rigid.
"""

import math
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tailslap.campaign import engine, levels
from tailslap.campaign.levels import Sample
from tailslap.campaign.records import Record
from tailslap.case.case import Case
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact.answers import COMPARED
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.checks import failed_but_mesh
from tailslap.case.impact.plan import ImpactPlan, chosen_lengths
from tailslap.case.impact.rigid import RigidImpact
from tailslap.case.impact.run import attempt
from tailslap.case.impact.strike_columns import COLUMNS, both_strikes
from tailslap.scene.vary import Changes, Source
from tailslap.studies.flexibility import plate_runs
from tailslap.studies.flexibility.corner_flexibility import corner_flexibility
from tailslap.studies.flexibility.flexibility_scan import scanned
from tailslap.studies.flexibility.plate_runs import Flexibility, one_run

LOWEST, IMPACT_LOWEST = "0.1 Hz", "2 Hz"
"""Lowest first frequencies of a constrained corner and of a whole impact."""
IMPACT_LEVELS = (1e-2, 5e-2, 1e-1)
"""Differences for which the lowest first frequency is sought."""
NAMES = tuple(f"strike_{k}.{name}" for k in (1, 2) for name in COMPARED)
"""Compared quantities of both strikes."""
PLATES = (2.0, 4.0, 8.0, 16.0, 32.0)
"""First frequencies of the plates whose strikes are measured [Hz]."""
LONGER, WORST = 2.0, 0.05
"""Time of their runs over that of the rigid impact, and largest difference of reliable meshes."""


def impact_flexibility(
    case: ImpactCase, frequencies: Sequence[float], place: Path, workers: int | None
) -> Flexibility:
    """Run plates of these first frequencies, falling [Hz]."""
    began, fe_plan = time.perf_counter(), case.plan()
    (along, across), mesh = fe_plan.plate.counts, mesh_changes(fe_plan)

    def plate(frequency: float, finer: int = 1, **more: Any) -> Changes:
        elements = (finer * along, finer * across)
        return {**mesh, "plate.elements": elements, "plate.first_frequency": frequency, **more}

    end = {"time.end": LONGER * case.duration}
    sweep = {f"{f!r} Hz": (case.source, plate(f), strike_record) for f in frequencies}
    plates = {f"plate {f!r} Hz": (case.source, f, *(plate(f, n, **end) for n in (1, 2))) for f in PLATES}
    definition = {"study": "flexibility", "scene": case.scene.model_dump(), "frequencies": frequencies}

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
        rows = [impact_row(f, record) for f, record in zip(frequencies, records.values(), strict=True)]
        series = {name: impact_samples(rows, name) for name in NAMES}
        scan = scanned(series, IMPACT_LEVELS, 1.0 / second_end(case), differences)
    reaches = {name: levels.reaches(samples, IMPACT_LEVELS) for name, samples in scan.samples.items()}
    rigid, seconds = plate_record(math.inf, both_strikes(case.in_plane), {}, ()), time.perf_counter() - began
    setup, measured = {"patch_length": patch_length(case)}, [*soft.values(), rigid]
    return Flexibility(
        *(case, rows, reaches, fe_plan.first_frequency, setup, seconds, {}, measured),
        scan=plate_runs.listed_scan(scan, scan.samples),
        step=scan.step,
    )


def mesh_changes(fe_plan: ImpactPlan) -> Changes:
    """Return the mesh of a plan as changes, without a modulus.

    Forces of corners are spread over `patch_length`, those of hinges as on this mesh.
    """
    plate, case = fe_plan.plate, fe_plan.case
    changes = {"plate.elements": plate.counts, "plate.element": plate.element, "plate.youngs_modulus": None}
    return {**changes, **chosen_lengths(case.scene), "contact.patch_length": patch_length(case)}


def second_end(case: ImpactCase) -> float:
    """Return the end of the rigid second strike [s].

    Without a second strike, it is the end of its motion.
    """
    return float(case.motion.strikes[1].end if len(case.motion.strikes) > 1 else case.duration)


def strike_differences(record: Record) -> Record:
    """Return the differences of a run by quantity.

    They are NaN where a check failed or other corners strike.
    """
    differences = record["difference"] if plate_runs.run_passed(record) else {}
    return {name: differences.get(name, math.nan) for name in NAMES}


def patch_length(case: RigidImpact) -> float:
    """Return the length of the crushed side [m].

    It is that of the scene, or of the study.
    """
    return case.scene.needed_contact.patch_length or plate_runs.PATCH * case.scene.vehicle.length


def impact_row(frequency: float, record: Record) -> Record:
    """Return a plate as in `points.csv` and the summary.

    Differences FE/rigid - 1 and mesh errors are by `NAMES`, NaN where other corners strike. `failed` lists the failed
    checks, or the reason without a result.
    """
    row: Record = {"frequency": frequency}
    for group in ("difference", "error"):
        row |= {f"{group}.{name}": record.get(group, {}).get(name, math.nan) for name in NAMES}
    return row | {"failed": plate_runs.failure_text(record)}


def impact_samples(rows: Sequence[Record], name: str) -> list[Sample]:
    """Return the samples of one of `NAMES`."""
    samples = []
    for row in rows:
        size, error = abs(row[f"difference.{name}"]), abs(row[f"error.{name}"])
        samples.append(Sample(row["frequency"], size, error, not row["failed"] and math.isfinite(size)))
    return samples


def strike_record(case: ImpactCase) -> Record:
    """Return the differences and mesh errors of a run.

    Mesh errors are compared with the levels and are no failure.
    """
    outcome = case.run()
    record = {"difference": outcome.difference, "error": outcome.mesh_error}
    return record | {"failed": list(failed_but_mesh(outcome))}


def measure_plate(source: Source, frequency: float, coarse: Changes, fine: Changes) -> Record:
    """Return both strikes of a plate on two meshes.

    frequency: first one [Hz]; coarse, fine: changes of both meshes. `values` are by `COLUMNS`, `errors` are the ratios
    of finer and coarser mesh minus one.
    """
    coarse_record, fine_record = (one_run(source, changes, both_record) for changes in (coarse, fine))
    if refused := coarse_record.get("refused") or fine_record.get("refused"):
        return plate_record(frequency, {}, {}, (refused,))
    values = fine_record["values"]
    errors = {name: values[name] / coarse_record["values"][name] - 1.0 for name in COLUMNS}
    return plate_record(frequency, values, errors, fine_record["failed"])


def both_record(case: ImpactCase) -> Record:
    """Return values and failed checks of a single run."""
    outcome = attempt(case)
    return {"values": both_strikes(outcome.fe), "failed": failed_but_mesh(outcome)}


def plate_record(
    frequency: float, values: Mapping[str, float], errors: Mapping[str, float], failed: Sequence[str]
) -> Record:
    """Return a plate as in the summary.

    An infinite frequency is that of the rigid vehicle. The plate passed if all checks passed and both meshes agree.
    """
    sizes = [abs(value) for value in errors.values()]
    error = max(sizes) if sizes and all(map(math.isfinite, sizes)) else math.nan
    passed = not failed and (math.isinf(frequency) or error <= WORST)
    record: Record = {"frequency": frequency if math.isfinite(frequency) else None, "values": dict(values)}
    return record | {"errors": dict(errors), "failed": list(failed), "error": error, "passed": passed}


def compute(
    case: Case, place: Path, points: int, lowest: str | None, highest: str, workers: int | None
) -> Flexibility:
    """Run plates from stiff to soft."""
    if isinstance(case, ImpactCase):
        frequencies = levels.frequencies(lowest or IMPACT_LOWEST, highest, points)
        return impact_flexibility(case, frequencies, place, workers)
    assert isinstance(case, CornerCase)
    return corner_flexibility(case, levels.frequencies(lowest or LOWEST, highest, points), place, workers)
