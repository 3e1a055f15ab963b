"""Fields on triangles as panels of one picture."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

WIDTH, ROOM = 1400, 110
"""Width of a picture, and height of a panel beyond that of its field [pixels]."""

BLUE, RED = "#2563eb", "#c2410c"


class FieldPanel(NamedTuple):
    """Field of values at the corners of triangles, and lines.

    corners: x, y by triangle, shape (t, 3, 2) [m]; values: shape (t, 3); limits: of colours; lines: pairs of ends,
    shape (n, 2, 2) [m], with their widths, negative in another colour, shape (n,).
    """

    title: str
    corners: Floats
    values: Floats
    limits: tuple[float, float]
    colours: str
    lines: Floats
    widths: Floats


def draw_panels(path: Path, panels: Sequence[FieldPanel]) -> Path:
    """Draw panels one below the other as a PNG."""
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")  # needs no display
    import pyvista

    spans = [np.ptp(panel.corners.reshape(-1, 2), axis=0) for panel in panels]
    height = int(max(ROOM + 0.78 * WIDTH * y / x for x, y in spans))
    plotter = pyvista.Plotter(
        off_screen=True, shape=(len(panels), 1), border=False, window_size=(WIDTH, height * len(panels))
    )
    plotter.set_background("white")
    for row, panel in enumerate(panels):
        plotter.subplot(row, 0)
        points = np.pad(panel.corners.reshape(-1, 2), ((0, 0), (0, 1)))
        cells = np.arange(len(points)).reshape(-1, 3)
        surface = pyvista.PolyData(points, np.pad(cells, ((0, 0), (1, 0)), constant_values=3))
        surface[f"values {row}"] = panel.values.ravel()
        bar = {"title": " " * (row + 1), "vertical": True, "color": "black", "n_labels": 5, "fmt": "%.2g"}
        bar |= {"position_x": 0.91, "position_y": 0.15, "height": 0.7, "width": 0.04, "label_font_size": 22}
        plotter.add_mesh(
            surface,
            scalars=f"values {row}",
            clim=panel.limits,
            cmap=panel.colours,
            n_colors=12,
            lighting=False,
            scalar_bar_args=bar,
        )
        for of_sign, colour in ((panel.widths > 0.0, RED), (panel.widths < 0.0, BLUE)):
            for level in (0.3, 0.7):
                chosen = of_sign & (np.abs(panel.widths) >= level)
                if chosen.any():
                    ends = np.pad(panel.lines[chosen].reshape(-1, 2), ((0, 0), (0, 1)), constant_values=1e-3)
                    plotter.add_mesh(
                        pyvista.line_segments_from_points(ends), color=colour, line_width=7.0 * level
                    )
        plotter.add_text(panel.title, position=(12, height - 36), font_size=11, color="black")
        (x, y), low = spans[row], panel.corners.reshape(-1, 2).min(axis=0)
        scale = x / (0.78 * WIDTH)
        centre = low + 0.5 * np.array([x, y]) + scale * np.array([0.04 * WIDTH, 0.15 * ROOM])
        plotter.camera_position = [(*centre, 10.0), (*centre, 0.0), (0.0, 1.0, 0.0)]
        plotter.camera.parallel_projection = True
        plotter.camera.parallel_scale = 0.5 * scale * height
    plotter.screenshot(str(path))
    plotter.close()
    return path
