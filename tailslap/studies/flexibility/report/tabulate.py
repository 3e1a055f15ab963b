"""The study's tables."""

from __future__ import annotations

import math
from collections.abc import Iterable

from postprocess.pages.study_page import StudyTable
from tailslap.planning.rigid import COMPARED
from tailslap.studies.flexibility.levels import Level
from tailslap.studies.flexibility.points import Point, Start
from tailslap.studies.flexibility.report.words import (
    NAMES,
    START_NAMES,
    hertz,
    law_words,
    level_words,
    per_cent,
    why_words,
)
from tailslap.studies.flexibility.survey import LEVELS, Survey
from tailslap.studies.flexibility.sweep import STARTS

OTHERS = tuple(name for name in COMPARED if name != "v_gy")
LEVEL_COLUMNS = tuple(map(per_cent, LEVELS))


def start_level_table(found: Survey) -> StudyTable:
    """The lowest first frequency for each level of v_GY, from each start and from any of them."""
    rows = [_levels(f"v_GY, {START_NAMES[name]}", levels) for name, levels in found.starts.items()]
    rows.append(_levels("v_GY, any of the three", found.band))
    note = (
        "Interpolated between plates whose runs passed their checks; <: the softest of them is still good. Not known: "
        "the numerical error is not below a third of the level. Held to the largest difference until the strike. The "
        "peak force of Stage 3 is in proportion to v_GY."
    )
    marked = frozenset({len(rows) - 1})
    return StudyTable(
        ("at most off by", *LEVEL_COLUMNS), tuple(rows), marked=marked, title="Good down to", note=note
    )


def _levels(title: str, levels: Iterable[Level]) -> tuple[str, ...]:
    return (title, *map(level_words, levels))


def level_table(found: Survey) -> StudyTable:
    """The same of the other quantities at the strike, with inertia relief, and every quantity's power law."""
    rows = [(*_levels(NAMES[name], levels), *_law(found, name)) for name, levels in found.others.items()]
    rows.append(("v_GY", *("" for _ in LEVELS), *_law(found, "v_gy")))
    columns = ("at most off by", *LEVEL_COLUMNS, "exponent of f1", "which holds from")
    title = f"The other quantities at the strike, {START_NAMES[STARTS[0]]}"
    return StudyTable(columns, tuple(rows), title=title)


def _law(found: Survey, name: str) -> tuple[str, str]:
    return law_words(found.laws[name])


def start_table(found: Survey) -> StudyTable:
    """v_GY of each start: at the strike, at most until then, and its error."""
    rows = tuple(
        (hertz(p.frequency), *(cell for name in STARTS for cell in _start_cells(p.starts[name])))
        for p in found.points
    )
    columns = ("f1", *(cell for name in STARTS for cell in (START_NAMES[name], "largest", "±")))
    note = (
        "v_GY flexible over rigid, less 1: at the strike, and the largest until then. –: that start has no run that "
        "passed its checks."
    )
    return StudyTable(columns, rows, title="v_GY from each start", note=note)


def _start_cells(start: Start) -> tuple[str, str, str]:
    if not start.passed:
        return ("–", "–", "–")
    return signed(start.difference), f"{start.largest:.2e}", size(start.error)


def kept_table(found: Survey) -> StudyTable:
    """How far each start departs from the rigid body at t = 0."""
    relief, momenta = STARTS[:2]
    shown = (
        *((name, "v_gy") for name in STARTS),
        *((relief, name) for name in ("v_gx", "omega", "v_p")),
        *((momenta, name) for name in ("omega", "v_p")),
    )
    rows = tuple(
        (hertz(p.frequency), *(departure(p.starts[start].departure[name]) for start, name in shown))
        for p in found.points
    )
    names = NAMES | {"v_p": "v_P"}
    columns = ("f1", *(f"{names[name]}, {START_NAMES[start]}" for start, name in shown))
    note = "Relative, at t = 0, on the finest mesh. 0: less than 1e-9, which is what the time step leaves."
    return StudyTable(columns, rows, title="What each start departs from", note=note)


def departure(value: float) -> str:
    """A relative departure at t = 0."""
    return "0" if abs(value) < 1e-9 else signed(value)


def point_table(found: Survey) -> StudyTable:
    """Each plate with v_GY, reaction and stored energy, each with its numerical error."""
    rows = tuple(
        (
            hertz(p.frequency),
            why_words(p),
            _modulus(p.youngs_modulus),
            f"{p.damping:.3g}" if p.damping else "–",
            *_pair(p, "v_gy"),
            *_pair(p, "reaction"),
            *_pair(p, "stored"),
        )
        for p in found.points
    )
    columns = ("f1", "checks", "E", "damping [1/s]", "v_GY", "±", "reaction", "±", "stored energy", "±")
    note = (
        "v_GY: flexible over rigid, less 1. Reaction: largest deviation from the rigid one over the largest rigid one. "
        "Stored energy: largest elastic energy over the kinetic energy at the start. ±: numerical error."
    )
    title = f"v_GY at the strike, reaction, energy: {START_NAMES[STARTS[0]]}"
    return StudyTable(columns, rows, texts=2, marked=_failed(found), title=title, note=note)


def motion_table(found: Survey) -> StudyTable:
    """Each plate with the other four quantities."""
    rows = tuple(
        (hertz(p.frequency), *(cell for name in OTHERS for cell in _pair(p, name))) for p in found.points
    )
    columns = ("f1", *(cell for name in OTHERS for cell in (NAMES[name], "±")))
    return StudyTable(columns, rows, marked=_failed(found), title="The other quantities")


def modal_table(found: Survey) -> StudyTable:
    """The modal model beside."""
    rows = tuple(
        (
            hertz(p.frequency),
            p.modal_why[:90] or "passed",
            signed(p.modal["v_gy"]),
            signed(p.difference["v_gy"]),
            size(p.modal_apart),
            size(p.modal_estimate),
        )
        for p in found.points
    )
    columns = ("f1", "modal checks", "v_GY modal", "v_GY FE", "apart, largest of five", "modal estimate")
    note = (
        "The modal model keeps four modes of the finest mesh, and has no damping. Its checks allow an estimated error "
        "of 1."
    )
    return StudyTable(columns, rows, texts=2, note=note)


def thickness_table(found: Survey) -> StudyTable:
    """The points that were repeated by the thickness."""
    rows = tuple(
        (hertz(p.frequency), f"{1e3 * p.thickness.thickness:.3g} mm", size(p.thickness.apart))
        for p in found.points
        if p.thickness
    )
    columns = ("f1", "thickness with the scene's E", "apart, largest of five")
    return StudyTable(columns, rows, title="Thickness at constant mass in place of E")


def signed(value: float) -> str:
    """A relative difference."""
    return f"{value:+.2e}" if math.isfinite(value) else "–"


def size(value: float) -> str:
    """An error or a distance."""
    return f"{value:.0e}" if math.isfinite(value) else "–"


def _pair(point: Point, name: str) -> tuple[str, str]:
    if name in COMPARED:
        return signed(point.difference[name]), size(point.errors[name])
    value = point.size(name)
    return (f"{value:.2e}" if math.isfinite(value) else "–"), size(point.errors[name])


def _modulus(value: float) -> str:
    for factor, unit in ((1e12, "TPa"), (1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa")):
        if value >= factor:
            return f"{value / factor:.3g} {unit}"
    return f"{value:.3g} Pa" if math.isfinite(value) else "–"


def _failed(found: Survey) -> frozenset[int]:
    return frozenset(i for i, point in enumerate(found.points) if not point.passed)
