"""The study's tables."""

from __future__ import annotations

import math

from postprocess.study_page import StudyTable
from tailslap.rigid import COMPARED
from tailslap.studies.flexibility.survey import LEVELS, Point, Survey
from tailslap.studies.flexibility.words import NAMES, hertz, law_words, level_words, per_cent, why_words

OTHERS = tuple(name for name in COMPARED if name != "v_gy")


def level_table(found: Survey) -> StudyTable:
    """The lowest first frequency for each level, and the power law, of each quantity."""
    rows = []
    for name, levels in found.levels.items():
        title = "v_GY, peak force" if name == "v_gy" else NAMES[name]
        rows.append((title, *map(level_words, levels), *law_words(found.laws[name])))
    columns = (
        "at most off by",
        *(per_cent(level) for level in LEVELS),
        "exponent of f1",
        "which holds from",
    )
    note = (
        "Interpolated between plates whose runs passed their checks; <: the softest of them is still good. Not "
        "known: the discretisation error is not below a third of the level. The peak force of Stage 3 is in proportion "
        "to v_GY."
    )
    marked = frozenset(i for i, name in enumerate(found.levels) if name == "v_gy")
    return StudyTable(columns, tuple(rows), marked=marked, title="Good down to", note=note)


def point_table(found: Survey) -> StudyTable:
    """Each plate with v_GY, reaction and stored energy, each with its discretisation error."""
    rows = tuple(
        (
            hertz(p.frequency),
            why_words(p),
            _modulus(p.youngs_modulus),
            f"{p.damping:g}" if p.damping else "–",
            *_pair(p, "v_gy"),
            *_pair(p, "reaction"),
            *_pair(p, "stored"),
        )
        for p in found.points
    )
    columns = ("f1", "checks", "E", "damping", "v_GY", "±", "reaction", "±", "stored energy", "±")
    note = (
        "v_GY: flexible over rigid, less 1. Reaction: largest deviation from the rigid one over the largest rigid one. "
        "Stored energy: largest elastic energy over the kinetic energy at the start. ±: discretisation error."
    )
    return StudyTable(
        columns, rows, texts=2, marked=_failed(found), title="v_GY, reaction, energy", note=note
    )


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
