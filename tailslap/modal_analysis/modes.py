"""The free modes of a scene's plate, the kind of each, beam theory's answer, and their page."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import repeat
from typing import Any

import numpy as np

import tailslap
from fem.modal import mode_kinds
from fem.model.plate_model import PlateModel
from fem.plate import elastic
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


def modes_report(fe_plan: CornerPlan, count: int) -> Report:
    """Find the lowest `count` elastic modes: page, summary, and text for the terminal.

    Raises InputError for a number that the mesh does not have.
    """
    model, plate, case = fe_plan.model, fe_plan.plate, fe_plan.case
    most = elastic.most_modes(model.loop.mass.size)
    if not 1 <= count <= most:
        raise InputError("--count", count, f"allowed with this mesh is a whole number from 1 to {most}")
    found, vehicle = elastic.free_modes(model, count), case.scene.vehicle
    density = plate_density(case.scene, plate)
    beam = mode_kinds.Beam(vehicle.length, vehicle.width, plate.modulus, plate.poissons_ratio, density)
    modes = [*_modes(fe_plan, found, beam)]
    table = Table(COLUMNS, [mode | {"name": _name(mode)} for mode in modes])
    at = f"at {modes[0]['frequency']:.4g} Hz"
    said = f"The first elastic mode of the free plate in its plane is {_name(modes[0])}, {at}."
    rigid = found.rigid_frequencies / (2.0 * math.pi)
    sections = (
        Section("Frequencies, beside those of a free beam", tables=(table,)),
        _shapes(model, modes, found.shapes),
        Section("What was computed, and what it means", sentences=_sentences(fe_plan, rigid, beam)),
    )
    files = "summary.json, these numbers and the shares of energy behind the kinds"
    page = study_page(case, "Natural frequencies of the free plate in its plane", said, sections, files)
    summary = {
        "scene": case.scene.name,
        "version": tailslap.__version__,
        "modes": modes,
        "rigid_frequencies": rigid,
        "plate": {
            "youngs_modulus": plate.youngs_modulus,
            "first_frequency": modes[0]["frequency"],
            "mass": model.mass,
            "elements": int(model.loop.table.connectivity.shape[1]),
            "nodes": int(model.loop.mass.size),
        },
    }
    return Report(page, summary, (f"{case.scene.name}: {said}", table))


def _modes(fe_plan: CornerPlan, found: elastic.FreeModes, beam: mode_kinds.Beam) -> Iterator[dict[str, Any]]:
    """Yield the elastic modes in rising frequency, as dicts, each beside the beam's.

    number from 1; frequency [Hz]; kind, and order: number among its like; symmetric, along, shear: the fractions of
    energy that make it that kind (`mode_kinds`); theory, slender [Hz]: beam theory with shear and rotary inertia, and
    without, for longitudinal modes `theory` is n c / (2 L); None: no beam does that; difference: frequency/theory - 1.
    """
    count = found.frequencies.size
    kinds = mode_kinds.mode_kinds(fe_plan.model, found, fe_plan.plate.thickness)
    bent = (mode_kinds.timoshenko_frequencies, mode_kinds.euler_bernoulli_frequencies)
    theories: dict[str, Iterator[Any]] = {
        "beam": zip(*(of(beam, count).tolist() for of in bent), strict=True),
        "longitudinal": zip(mode_kinds.longitudinal_frequencies(beam, count).tolist(), repeat(None)),
        "transverse": repeat((None, None)),
    }
    seen = dict.fromkeys(theories, 0)
    for i, (frequency, kind) in enumerate(zip(found.frequencies, kinds.names, strict=True)):
        family = "beam" if kind in BENDING else kind
        seen[family] += 1
        theory, slender = next(theories[family])
        hertz = float(frequency) / (2.0 * math.pi)
        yield {
            "number": i + 1,
            "frequency": hertz,
            "kind": kind,
            "order": seen[family],
            **{name: float(getattr(kinds, name)[i]) for name in ("symmetric", "along", "shear")},
            "theory": theory,
            "slender": slender,
            "difference": None if theory is None else hertz / theory - 1.0,
        }


def _name(mode: dict[str, Any]) -> str:
    return f"{mode['kind']} {mode['order']}"


def _shapes(model: PlateModel, modes: list[dict[str, Any]], shapes: Any) -> Section:
    """Draw the lowest modes: displacements of the elements' corner nodes, the largest of length one."""
    cells, pictures = model.discretisation.cells, []
    corners = int(cells.max()) + 1
    places = model.discretisation.positions[:, :corners].T
    for mode, shape in zip(modes[:MAX_PICTURES], shapes, strict=False):
        moved = shape[:, :corners].T
        moved = moved / np.hypot(*moved.T).max()
        caption = f"{mode['number']}: {_name(mode)}, {mode['frequency']:.4g} Hz"
        pictures.append(draw_mode(f"mode-{mode['number']}", caption, places, cells, moved))
    drawn = "Grey: the plate at rest. The largest displacement is drawn as three tenths of the width."
    if len(modes) > MAX_PICTURES:
        drawn += f" Drawn are the first {MAX_PICTURES} modes."
    return Section("Shapes", drawn, pictures)


def _sentences(fe_plan: CornerPlan, frequencies: Any, beam: mode_kinds.Beam) -> tuple[str, ...]:
    """Say how it was computed and how to read it; frequencies [Hz]: of the rigid modes."""
    plate, model = fe_plan.plate, fe_plan.model
    rigid = ", ".join(f"{frequency:.0e}" for frequency in frequencies)
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
