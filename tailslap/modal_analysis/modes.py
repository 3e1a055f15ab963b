"""The free modes of a scene's plate, the kind of each, beam theory's answer, and their page."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import repeat
from typing import Any

import numpy as np

import tailslap
from fem.modal.mode_kinds import (
    Beam,
    euler_bernoulli_frequencies,
    longitudinal_frequencies,
    mode_kinds,
    timoshenko_frequencies,
)
from fem.plate.elastic import FreeModes, free_modes, most_modes
from postprocess.figures.plates import draw_mode
from postprocess.report.page import Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table
from postprocess.units import measure, percent
from tailslap.case.corner.plan import CornerPlan
from tailslap.case.model import plate_density
from tailslap.case.report import study_page
from tailslap.errors import InputError

BENDING = ("bending", "shear")
"""Kinds that bend the plate as a beam; they are numbered together, as Timoshenko's frequencies are."""

MAX_PICTURES = 24
"""Modes that are drawn: the lowest."""

COLUMNS = (
    Column("number", "Mode"),
    Column("frequency", "Frequency", "Hz", "#.5g", style="strong"),
    Column("name", "Kind"),
    Column("theory", "Beam theory", "Hz", "#.5g"),
    Column("difference", "Difference", form=percent),
    Column("slender", "Slender beam", "Hz", "#.5g", style="soft"),
)


@dataclass(frozen=True)
class PlateModes:
    """The elastic modes in rising frequency, as dicts, and the beam that they are compared with.

    number from 1; frequency [Hz]; kind, and order: number among its like; symmetric, along, shear: the fractions of
    energy that make it that kind (`mode_kinds`); theory, slender [Hz]: beam theory with shear and rotary inertia, and
    without, for longitudinal modes `theory` is n c / (2 L); None: no beam does that; difference: frequency/theory - 1.
    """

    fe_plan: CornerPlan
    found: FreeModes
    modes: tuple[dict[str, Any], ...]
    beam: Beam


def find_modes(fe_plan: CornerPlan, count: int) -> PlateModes:
    """The lowest `count` elastic modes. Raises InputError for a number that the mesh does not have."""
    model, plate, vehicle = fe_plan.model, fe_plan.plate, fe_plan.case.scene.vehicle
    most = most_modes(model.loop.mass.size)
    if not 1 <= count <= most:
        raise InputError("--count", count, f"allowed with this mesh is a whole number from 1 to {most}")
    found = free_modes(model, count)
    density = plate_density(fe_plan.case.scene, plate)
    beam = Beam(vehicle.length, vehicle.width, plate.modulus, plate.poissons_ratio, density)
    return PlateModes(fe_plan, found, tuple(_modes(fe_plan, found, beam)), beam)


def _modes(fe_plan: CornerPlan, found: FreeModes, beam: Beam) -> Iterator[dict[str, Any]]:
    count = found.frequencies.size
    kinds = mode_kinds(fe_plan.model, found, fe_plan.plate.thickness)
    bent = zip(timoshenko_frequencies(beam, count), euler_bernoulli_frequencies(beam, count), strict=True)
    beams: dict[str, Iterator[Any]] = {
        "beam": bent,
        "longitudinal": zip(longitudinal_frequencies(beam, count), repeat(None)),
    }
    seen = {"beam": 0, "longitudinal": 0, "transverse": 0}
    for i, (frequency, kind) in enumerate(zip(found.frequencies, kinds.names, strict=True)):
        family = "beam" if kind in BENDING else kind
        seen[family] += 1
        theory, slender = (None, None) if family == "transverse" else next(beams[family])
        hertz = float(frequency) / (2.0 * math.pi)
        yield {
            "number": i + 1,
            "frequency": hertz,
            "kind": kind,
            "order": seen[family],
            "symmetric": float(kinds.symmetric[i]),
            "along": float(kinds.along[i]),
            "shear": float(kinds.shear[i]),
            "theory": None if theory is None else float(theory),
            "slender": None if slender is None else float(slender),
            "difference": None if theory is None else hertz / float(theory) - 1.0,
        }


def modes_report(found: PlateModes) -> Report:
    """Page, summary, and what the terminal says."""
    plan, first = found.fe_plan.case, found.modes[0]
    table = Table(COLUMNS, [mode | {"name": _name(mode)} for mode in found.modes])
    said = (
        f"The first elastic mode of the free plate in its plane is {_name(first)}, "
        f"at {first['frequency']:.4g} Hz."
    )
    page = study_page(
        plan,
        "Natural frequencies of the free plate in its plane",
        said,
        (
            Section("Frequencies, beside those of a free beam", tables=(table,)),
            _shapes(found),
            Section("What was computed, and what it means", sentences=_sentences(found)),
        ),
        "summary.json, these numbers and the shares of energy behind the kinds",
    )
    return Report(page, _summary(found), (f"{plan.scene.name}: {said}", table))


def _name(mode: dict[str, Any]) -> str:
    return f"{mode['kind']} {mode['order']}"


def _summary(found: PlateModes) -> dict[str, Any]:
    """The numbers, SI; frequencies in Hz."""
    plan, plate, model = found.fe_plan.case, found.fe_plan.plate, found.fe_plan.model
    return {
        "scene": plan.scene.name,
        "version": tailslap.__version__,
        "modes": found.modes,
        "rigid_frequencies": found.found.rigid_frequencies / (2.0 * math.pi),
        "plate": {
            "youngs_modulus": plate.youngs_modulus,
            "first_frequency": found.modes[0]["frequency"],
            "mass": model.mass,
            "elements": int(model.loop.table.connectivity.shape[1]),
            "nodes": int(model.loop.mass.size),
        },
    }


def _shapes(found: PlateModes) -> Section:
    """Pictures of the lowest modes: displacements of the elements' corner nodes, the largest of length one."""
    discretisation = found.fe_plan.model.discretisation
    cells = discretisation.cells
    corners = int(cells.max()) + 1
    pictures = []
    for mode, shape in zip(found.modes[:MAX_PICTURES], found.found.shapes, strict=False):
        moved = shape[:, :corners].T
        caption = f"{mode['number']}: {_name(mode)}, {mode['frequency']:.4g} Hz"
        places = discretisation.positions[:, :corners].T
        pictures.append(
            draw_mode(f"mode-{mode['number']}", caption, places, cells, moved / np.hypot(*moved.T).max())
        )
    drawn = "Grey: the plate at rest. The largest displacement is drawn as three tenths of the width."
    if len(found.modes) > MAX_PICTURES:
        drawn += f" Drawn are the first {MAX_PICTURES} modes."
    return Section("Shapes", drawn, pictures)


def _sentences(found: PlateModes) -> tuple[str, ...]:
    """Sentences on the computation and how to read it."""
    plate, model, beam = found.fe_plan.plate, found.fe_plan.model, found.beam
    rigid = ", ".join(f"{frequency:.0e}" for frequency in found.found.rigid_frequencies / (2.0 * math.pi))
    return (
        f"The plate is free: no wall, no corner. {model.loop.table.connectivity.shape[1]} elements ({plate.element}), "
        f"{plate.lumping} masses, the stiffness that the run has; its three rigid modes come out at {rigid} Hz.",
        "Kinds: longitudinal and transverse modes are symmetric about the long middle line, by more than half of their "
        "kinetic energy; longitudinal ones move along the length with more than half of it. The others bend the plate: "
        "shear where more than half of the strain energy is that of shear strain, else bending; both are numbered "
        "together.",
        f"Beam theory: a free beam of length {measure(beam.length, 'm', 'g')} and depth "
        f"{measure(beam.depth, 'm', 'g')}. For bending it is "
        "Timoshenko's, with shear and rotary inertia; the slender beam is Euler and Bernoulli's, without them. For "
        f"longitudinal modes it is n c / (2 L) with c = {measure(beam.wave_speed, 'm/s', '.5g')}, "
        "which leaves out that the plate "
        "grows thinner where it is stretched. A plate this deep leaves both with the higher modes.",
    )
