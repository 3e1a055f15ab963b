"""Calibrate force bands of scenes, once on a machine."""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

from machine_code.system import folder
from tailslap import progress
from tailslap.campaign import band_samples
from tailslap.case.case import Case
from tailslap.case.force_band import PERCENTILES, Calibration, ForceBand
from tailslap.validation.tables import SETS, metres_or_newtons, parameters

if TYPE_CHECKING:
    from tailslap.validation.predictions import Row

SOURCES = ("solver", "fem/laws", "postprocess/signals", "tailslap/case/impact", "tailslap/campaign",
           "tailslap/validation")  # fmt: skip
"""Packages on which calibrations depend."""

LARGEST = 2**16
"""Largest number of bytes of the file of calibrations."""


class VehicleClass(NamedTuple):
    """A class of vehicles with its calibration.

    levels: test levels; speeds [m/s], masses [kg]: least and largest of its vehicles; published: see `ForceBand`.
    """

    levels: list[str]
    speeds: list[float]
    masses: list[float]
    calibration: dict[str, Any]
    published: list[dict[str, Any]]


def calibrated_band(case: Case) -> ForceBand:
    """Return the force band of a case with its calibration, if any."""
    band = band_samples.force_band(case)
    if not band.percentiles or case.scene.contact is None:
        return band
    found = class_of(case, classes())
    if found is None:
        return band
    return replace(band, calibration=Calibration(**found.calibration), published=found.published)


def class_of(case: Case, known: Sequence[VehicleClass]) -> VehicleClass | None:
    """Return the class of a case, None without one.

    A scene belongs to a class of its test level whose vehicles have its mass and speed within their ranges.
    """
    impact, mass = case.scene.impact, sum(unit.mass for unit in case.scene.units)
    if impact is None:
        return None
    for one in known:
        if (
            str(impact.test_level) in one.levels
            and one.speeds[0] <= impact.speed <= one.speeds[1]
            and one.masses[0] <= mass <= one.masses[1]
        ):
            return one
    return None


@functools.cache
def classes() -> tuple[VehicleClass, ...]:
    """Return all classes with their calibrations by the second set.

    They are computed once on a machine, and kept beside compiled code under a digest of all that they depend on.
    """
    here = resources.files(__package__)
    texts = [here.joinpath(f"{name}.toml").read_bytes() for name in (SETS[-1], "published")]
    texts.append(str(PERCENTILES).encode())
    digest = hashlib.sha256(folder.own_sources(*SOURCES).encode() + b"".join(texts)).hexdigest()
    path = folder.cache_folder() / f"calibration-{digest[:16]}.json"
    with suppress(ValueError, TypeError):
        return tuple(VehicleClass(*fields) for fields in json.loads(folder.read(path, LARGEST)))
    from tailslap.validation.predictions import FORCES, predicted_rows

    with progress.progress_bar("calibration of the band, once on this machine") as show:
        tables = parameters()
        computed = described(tables, predicted_rows(tables, show, FORCES)[0])
    with suppress(OSError):
        folder.write(path, json.dumps(computed).encode())
    return computed


def described(tables: Mapping[str, Any], rows: Sequence[Row]) -> tuple[VehicleClass, ...]:
    """Return the classes of published.toml with their calibrations by rows."""
    from tailslap.validation.predictions import QUANTITIES, calibrations_of, forces_of

    known = []
    for one, calibration in zip(tables["classes"], calibrations_of(rows, tables), strict=True):
        vehicles = [
            tables["vehicles"].get(name) or tables["space_vehicles"][name] for name in one["vehicles"]
        ]
        levels = sorted({vehicle["scene"]["impact"]["test_level"] for vehicle in vehicles})
        speeds, masses = (_span(vehicles, key) for key in ("impact.speed", "vehicle.mass"))
        published = [row._asdict() | {"label": QUANTITIES[row.quantity][0]} for row in forces_of(rows, one)]
        known.append(VehicleClass(levels, speeds, masses, dict(vars(calibration)), published))
    return tuple(known)


def _span(vehicles: Sequence[Mapping[str, Any]], key: str) -> list[float]:
    """Return the least and largest value of a key of vehicles [SI].

    Masses are those of trains.
    """
    table, name = key.split(".")
    ends = []
    for vehicle in vehicles:
        scene, limits = vehicle["scene"], vehicle["ranges"].get(key)
        texts = limits[:2] if limits else [scene[table][name]]
        trailers = [unit[name] for unit in scene.get("trailer", ())] if name == "mass" else []
        ends += [sum(map(metres_or_newtons, (text, *trailers))) for text in texts]
    return [min(ends), max(ends)]
