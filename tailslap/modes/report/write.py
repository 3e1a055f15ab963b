"""Writes the result folder of `tailslap modes`: page and summary."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tailslap
from postprocess.figures.mode_plots import draw_mode
from postprocess.files.summary import write_summary
from postprocess.pages.mode_page import ModeRow, ModesContent, write_modes_page
from tailslap.modes.answer import ModesAnswer, drawn_shape
from tailslap.modes.report.words import difference, headline, name, number, statements

MOST_PICTURES = 24
"""Modes that are drawn: the lowest."""


def write_modes(answer: ModesAnswer, folder: Path) -> None:
    """Fill the folder: `report.html`, `summary.json`."""
    write_modes_page(folder / "report.html", _content(answer))
    write_summary(folder / "summary.json", summary(answer))


def summary(answer: ModesAnswer) -> dict[str, Any]:
    """The numbers, SI; frequencies in Hz."""
    plan, plate, model = answer.fe_plan.plan, answer.fe_plan.plate, answer.fe_plan.model
    return {
        "scene": plan.scene.name,
        "version": tailslap.__version__,
        "modes": [asdict(mode) | {"difference": mode.difference} for mode in answer.modes],
        "rigid_frequencies": answer.found.rigid_frequencies / (2.0 * math.pi),
        "plate": {
            "youngs_modulus": plate.youngs_modulus,
            "first_frequency": answer.modes[0].frequency,
            "mass": model.mass,
            "elements": int(model.loop.table.connectivity.shape[1]),
            "nodes": int(model.loop.mass.size),
        },
    }


def _content(answer: ModesAnswer) -> ModesContent:
    plan, discretisation = answer.fe_plan.plan, answer.fe_plan.model.discretisation
    cells = discretisation.cells
    positions = discretisation.positions[:, : cells.max() + 1].T
    rows = tuple(
        ModeRow(
            str(mode.number),
            number(mode.frequency),
            name(mode),
            number(mode.theory),
            difference(mode),
            number(mode.slender),
        )
        for mode in answer.modes
    )
    pictures = tuple(
        draw_mode(
            f"mode-{mode.number}",
            f"{mode.number}: {name(mode)}, {mode.frequency:.4g} Hz",
            positions,
            cells,
            drawn_shape(answer, mode),
        )
        for mode in answer.modes[:MOST_PICTURES]
    )
    return ModesContent(
        scene=plan.scene.name,
        version=tailslap.__version__,
        headline=headline(answer),
        modes=rows,
        pictures=pictures,
        statements=statements(answer),
        scene_text=plan.source.text,
    )
