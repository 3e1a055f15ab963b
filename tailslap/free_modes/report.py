"""What `tailslap modes` reports."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import tailslap
from postprocess.figures.mode_plots import draw_mode
from postprocess.figures.svg.chart import Chart
from postprocess.report.numbers import percent
from postprocess.report.page import Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table
from tailslap.free_modes.plate_modes import PlateModes, drawn_shape
from tailslap.report.common import study_page

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


def modes_report(found: PlateModes) -> Report:
    """Page, summary, and what the terminal says."""
    plan, table, said = found.fe_plan.plan, modes_table(found), headline(found)
    page = study_page(
        plan,
        "Natural frequencies of the free plate in its plane",
        said,
        (
            Section("Frequencies, beside those of a free beam", tables=(table,)),
            Section("Shapes", _drawing(found), _pictures(found)),
            Section("What was computed, and what it means", sentences=_sentences(found)),
        ),
        "summary.json, these numbers and the shares of energy behind the kinds",
    )
    return Report(page, summary(found), (f"{plan.scene.name}: {said}", table))


def modes_table(found: PlateModes) -> Table:
    """Frequencies beside beam theory's."""
    return Table(COLUMNS, found.modes)


def headline(found: PlateModes) -> str:
    """The first mode, in a sentence."""
    first = found.modes[0]
    return (
        f"The first elastic mode of the free plate in its plane is {first.name}, at {first.frequency:.4g} Hz."
    )


def summary(found: PlateModes) -> dict[str, Any]:
    """The numbers, SI; frequencies in Hz."""
    plan, plate, model = found.fe_plan.plan, found.fe_plan.plate, found.fe_plan.model
    return {
        "scene": plan.scene.name,
        "version": tailslap.__version__,
        "modes": [asdict(mode) | {"difference": mode.difference} for mode in found.modes],
        "rigid_frequencies": found.found.rigid_frequencies / (2.0 * math.pi),
        "plate": {
            "youngs_modulus": plate.youngs_modulus,
            "first_frequency": found.modes[0].frequency,
            "mass": model.mass,
            "elements": int(model.loop.table.connectivity.shape[1]),
            "nodes": int(model.loop.mass.size),
        },
    }


def _pictures(found: PlateModes) -> list[Chart]:
    discretisation = found.fe_plan.model.discretisation
    cells = discretisation.cells
    positions = discretisation.positions[:, : cells.max() + 1].T
    captions = [f"{mode.number}: {mode.name}, {mode.frequency:.4g} Hz" for mode in found.modes]
    return [
        draw_mode(f"mode-{mode.number}", caption, positions, cells, drawn_shape(found, mode))
        for mode, caption in zip(found.modes[:MAX_PICTURES], captions, strict=False)
    ]


def _drawing(found: PlateModes) -> str:
    drawn = "Grey: the plate at rest. The largest displacement is drawn as three tenths of the width."
    many = len(found.modes) > MAX_PICTURES
    return f"{drawn} Drawn are the first {MAX_PICTURES} modes." if many else drawn


def _sentences(found: PlateModes) -> tuple[str, ...]:
    """What was computed and how to read it."""
    plate, model, beam = found.fe_plan.plate, found.fe_plan.model, found.beam
    rigid = ", ".join(f"{frequency:.0e}" for frequency in found.found.rigid_frequencies / (2.0 * math.pi))
    return (
        f"The plate is free: no wall, no corner. {model.loop.table.connectivity.shape[1]} elements ({plate.element}), "
        f"{plate.lumping} masses, the stiffness that the run has; its three rigid modes come out at {rigid} Hz.",
        "Kinds: longitudinal and transverse modes are symmetric about the long middle line, by more than half of their "
        "kinetic energy; longitudinal ones move along the length with more than half of it. The others bend the plate: "
        "shear where more than half of the strain energy is that of shear strain, else bending; both are numbered "
        "together.",
        f"Beam theory: a free beam of length {beam.length:g} m and depth {beam.depth:g} m. For bending it is "
        "Timoshenko's, with shear and rotary inertia; the slender beam is Euler and Bernoulli's, without them. For "
        f"longitudinal modes it is n c / (2 L) with c = {beam.wave_speed:.5g} m/s, which leaves out that the plate "
        "grows thinner where it is stretched. A plate this deep leaves both with the higher modes.",
    )
