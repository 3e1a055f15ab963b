"""Pictures of the mechanism and the moments of a parapet."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from postprocess.fields.contours import dark_form
from postprocess.fields.panels import FieldPanel, draw_panels
from postprocess.report.command_report import Report
from postprocess.report.page import Picture, Section
from tailslap.wall_strength.strength import Computed

ROTATION = 98.0
"""Percentile of the rotations that is drawn as the largest: a short edge may turn far [%]."""


def with_pictures(report: Report, rows: list[Computed], folder: Path) -> Report:
    """Return the report with mechanisms and moments of the code's load."""
    pictures = []
    for row in rows:
        if row.load_name != "code" or row.lower is None or row.upper is None:
            continue
        try:
            path = draw_panels(folder / f"parapet-{row.place}.png", _panels(row))
        except ImportError as error:
            warnings.warn(f"no pictures are drawn: {error}", stacklevel=2)
            return report
        caption = (
            f"{row.where.capitalize()}, seen from the traffic, the load in green: mechanism of the upper bound "
            "with its yield lines, red with tension on the traffic face, blue on the back; moments of the lower bound, "
            "upright and along the wall, positive with tension on the traffic face; largest moment over strength."
        )
        pictures.append(Picture(path, caption, dark_form(path)))
    sections = [*report.page.sections]
    sections.insert(1, Section("Mechanism and moments", figures=pictures, layout="tall"))
    return replace(report, page=replace(report.page, sections=sections))


def _panels(row: Computed) -> list[FieldPanel]:
    """Return the panels of a strength, mirrored at an axis of symmetry."""
    lower, mesh, upper, upper_mesh, plate = row.bounds
    assert plate.line
    height, start, end = plate.line
    rotations = upper.rotations.mean(axis=1)
    mechanism = FieldPanel(
        "Mechanism: deflection over the largest",
        upper_mesh.p[:, upper_mesh.t].transpose(2, 1, 0),
        upper.deflections[:3].T / np.abs(upper.deflections).max(),
        (0.0, 1.0),
        "Greys",
        upper_mesh.p[:, upper_mesh.facets].transpose(2, 1, 0),
        np.clip(rotations / (np.percentile(np.abs(rotations), ROTATION) or 1.0), -1.0, 1.0),
        np.array([[start, height], [end, height]]),
    )
    panels, corners = [mechanism], mesh.p[:, mesh.t].transpose(2, 1, 0)
    for title, number, strengths in (
        ("Upright moment", 1, plate.strengths[2:]),
        ("Moment along the wall", 0, plate.strengths[:2]),
    ):
        largest = float(strengths.max())
        title = f"{title} over {largest / 1e3:.3g} kN m/m"
        values = lower.moments[..., number] / largest
        panels.append(FieldPanel(title, corners, values, (-1.0, 1.0), "RdBu_r"))
    panels.append(FieldPanel("Largest moment over strength", corners, lower.use, (0.0, 1.0), "viridis"))
    return [_mirrored(panel) for panel in panels] if plate.sides["left"] == "symmetric" else panels


def _mirrored(panel: FieldPanel) -> FieldPanel:
    """Return a panel with its mirror image."""
    turn = np.array([-1.0, 1.0])
    return panel._replace(
        corners=np.concatenate([panel.corners, panel.corners * turn]),
        values=np.tile(panel.values, (2, 1)),
        lines=np.concatenate([panel.lines, panel.lines * turn]),
        widths=np.tile(panel.widths, 2),
    )
