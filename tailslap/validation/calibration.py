"""Calibrations of the force band of a scene, computed once on a machine."""

import functools
import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib import resources
from typing import Any

from machine_code.system import folder
from tailslap import progress
from tailslap.campaign import band_samples
from tailslap.case.case import Case
from tailslap.case.force_band import Calibration, ForceBand
from tailslap.scene.units import to_si
from tailslap.validation.predictions import FORCES, calibrations_of, predicted_rows
from tailslap.validation.samples import SETS, parameters

SOURCES = ("solver", "fem/laws", "machine_code", "postprocess/signals", "tailslap/case", "tailslap/campaign",
           "tailslap/scene", "tailslap/validation")  # fmt: skip
"""Packages on which calibrations depend."""

LARGEST = 2**16
"""Largest number of bytes of the file of calibrations."""


def calibrated_band(case: Case) -> ForceBand:
    """Return the force band of a case with its calibration, if any."""
    band = band_samples.force_band(case)
    place = class_of(case, parameters(SETS[-1])) if band.percentiles and case.scene.contact else None
    return band if place is None else replace(band, calibration=calibrations()[place])


def class_of(case: Case, tables: Mapping[str, Any]) -> int | None:
    """Return the number of the class of a case, None without one.

    A scene belongs to a class of its test level whose vehicles have its mass and speed within their ranges.
    """
    impact, mass = case.scene.impact, sum(unit.mass for unit in case.scene.units)
    for number, one in enumerate(tables["classes"]):
        vehicles = [
            tables["vehicles"].get(name) or tables["space_vehicles"][name] for name in one["vehicles"]
        ]
        levels = {vehicle["scene"]["impact"]["test_level"] for vehicle in vehicles}
        speeds, masses = (_span(vehicles, key) for key in ("impact.speed", "vehicle.mass"))
        if impact and impact.test_level in levels and speeds[0] <= impact.speed <= speeds[1]:
            return number if masses[0] <= mass <= masses[1] else None
    return None


def _span(vehicles: Sequence[Mapping[str, Any]], key: str) -> tuple[float, float]:
    """Return the least and largest value of a key of vehicles [SI]."""
    table, name = key.split(".")
    ends = []
    for vehicle in vehicles:
        scene, limits = vehicle["scene"], vehicle["ranges"].get(key)
        texts = limits[:2] if limits else [scene[table][name]]
        trailers = [unit[name] for unit in scene.get("trailer", ())] if name == "mass" else []
        ends += [sum(map(_si, (text, *trailers))) for text in texts]
    return min(ends), max(ends)


def _si(text: str) -> float:
    """Return a quantity with its unit [SI]."""
    number, unit = text.split(" ", 1)
    return float(number) * to_si(unit)[0]


@functools.cache
def calibrations() -> tuple[Calibration, ...]:
    """Return the calibrations of all classes by the second set.

    They are computed once on a machine, and kept beside compiled code under a digest of all that they depend on.
    """
    here = resources.files(__package__)
    texts = [here.joinpath(f"{name}.toml").read_bytes() for name in (SETS[-1], "published")]
    digest = hashlib.sha256(folder.own_sources(*SOURCES).encode() + b"".join(texts)).hexdigest()
    path = folder.cache_folder() / f"calibration-{digest[:16]}.json"
    with suppress(ValueError, TypeError):
        return tuple(Calibration(**fields) for fields in json.loads(folder.read(path, LARGEST)))
    with progress.progress_bar("calibration of the band, once on this machine") as show:
        tables = parameters(SETS[-1])
        computed = calibrations_of(predicted_rows(tables, show, FORCES)[0], tables)
    with suppress(OSError):
        folder.write(path, json.dumps([vars(one) for one in computed]).encode())
    return computed
