"""Pictures of the mechanism and the moments of a parapet."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from fem.limit.plate import Floats
from postprocess.fields.contours import dark_form
from postprocess.fields.panels import FieldPanel, draw_panels
from postprocess.report.command_report import Report
from postprocess.report.page import Picture, Section
from tailslap.wall_strength.strength import Computed


def with_pictures(report: Report, rows: list[Computed], folder: Path) -> Report:
    """Return the report with mechanisms and moments of the code's load."""
    pictures = []
    for row in (row for row in rows if row.load_name == "code"):
        if row.lower is None or row.upper is None:
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
    upper, lower, mesh, below = (
        row.bounds.upper,
        row.bounds.lower,
        row.bounds.upper_mesh,
        row.bounds.lower_mesh,
    )
    deflection = upper.deflections[:3].T / np.abs(upper.deflections).max()
    turned = upper.rotations.mean(axis=1)
    largest = np.percentile(np.abs(turned), 98.0) or 1.0  # a short edge may turn far
    turned = np.clip(turned / largest, -1.0, 1.0)
    lines = mesh.p[:, mesh.facets].transpose(2, 1, 0)
    corners, fields = mesh.p[:, mesh.t].transpose(2, 1, 0), below.p[:, below.t].transpose(2, 1, 0)
    none = np.empty((0, 2, 2)), np.empty(0)
    strongest = [float(row.plate.strengths[k : k + 2].max()) for k in (2, 0)]
    assert row.plate.line
    height, start, end = row.plate.line
    panels = [
        FieldPanel(
            "Mechanism: deflection over the largest",
            corners,
            deflection,
            (0.0, 1.0),
            "Greys",
            lines,
            turned,
            np.array([[start, height], [end, height]]),
        )
    ]
    for title, number, strong in (
        ("Upright moment", 1, strongest[0]),
        ("Moment along the wall", 0, strongest[1]),
    ):
        values = lower.moments[..., number] / strong
        title = f"{title} over {strong / 1e3:.3g} kN m/m"
        panels.append(FieldPanel(title, fields, values, (-1.0, 1.0), "RdBu_r", *none))
    panels.append(FieldPanel("Largest moment over strength", fields, lower.use, (0.0, 1.0), "viridis", *none))
    return [_mirrored(panel) for panel in panels] if row.plate.sides["left"] == "symmetric" else panels


def _mirrored(panel: FieldPanel) -> FieldPanel:
    """Return a panel with its mirror image."""
    turn: Floats = np.array([-1.0, 1.0])
    return panel._replace(
        corners=np.concatenate([panel.corners, panel.corners * turn]),
        values=np.concatenate([panel.values, panel.values]),
        lines=np.concatenate([panel.lines, panel.lines * turn]),
        widths=np.concatenate([panel.widths, panel.widths]),
    )
