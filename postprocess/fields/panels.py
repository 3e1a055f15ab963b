"""Fields on triangles as panels of one picture."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.fields.canvas import TEXT, Canvas
from postprocess.fields.contours import forms, save

Floats = NDArray[np.float64]

WIDTH, ROOM = 1200, 110
"""Width of a picture, and height of a panel beyond that of its field [pixels]."""

LEFT, PART = 40.0, 0.78
"""Place of a field from the left [pixels], and its largest part of the width."""

BANDS, SCALE_WIDTH, LABELS = 12, 44.0, 5
"""Bands of colour, width of their scale [pixels], and number of its labels."""

BLUE, RED, GREEN = "#2563eb", "#c2410c", "#16a34a"
THIN, THICK = 0.3, 0.7
"""Least widths of lines that are drawn, and of those that are drawn thick, over the largest."""


class FieldPanel(NamedTuple):
    """Field of values at the corners of triangles, and lines.

    corners: x, y by triangle, shape (t, 3, 2) [m]; values: shape (t, 3); limits: of colours; lines: pairs of ends,
    shape (n, 2, 2) [m], with their widths over the largest, negative in another colour, shape (n,); load: ends of a
    loaded line, shape (2, 2) [m], None without one.
    """

    title: str
    corners: Floats
    values: Floats
    limits: tuple[float, float]
    colours: str
    lines: Floats = np.empty((0, 2, 2))
    widths: Floats = np.empty(0)
    load: Floats | None = None


def draw_panels(path: Path, panels: Sequence[FieldPanel]) -> Path:
    """Draw panels one below the other, in light and dark form.

    ImportError on a machine that cannot draw.
    """
    spans = [np.ptp(panel.corners.reshape(-1, 2), axis=0) for panel in panels]
    heights = [int(ROOM + PART * WIDTH * y / x) for x, y in spans]
    with closing(Canvas((WIDTH, sum(heights)), dot=1.0)) as canvas:
        for form in forms(canvas, path):
            top = float(canvas.size[1])
            for panel, height in zip(panels, heights, strict=True):
                _draw(canvas, panel, top, height)
                top -= height
            save(canvas.image(), form)
    return path


def _draw(canvas: Canvas, panel: FieldPanel, top: float, height: int) -> None:
    """Draw a panel below the pixel `top`."""
    low, span = panel.corners.reshape(-1, 2).min(axis=0), np.ptp(panel.corners.reshape(-1, 2), axis=0)
    corner, factor = np.array([LEFT, top - height + 0.25 * ROOM]), PART * WIDTH / span[0]

    def pixel(places: ArrayLike) -> Floats:
        result: Floats = corner + factor * (np.asarray(places) - low)
        return result

    style: dict[str, Any] = {"clim": panel.limits, "cmap": panel.colours, "n_colors": BANDS}
    triangles = np.arange(panel.values.size).reshape(-1, 3)
    canvas.fill(pixel(panel.corners.reshape(-1, 2)), triangles, scalars=panel.values.ravel(), **style)
    right, upper = low + span
    frame = [(tuple(low), (right, low[1])), ((right, low[1]), (right, upper)), ((right, upper), (low[0], upper)),
             ((low[0], upper), tuple(low))]  # fmt: skip
    canvas.lines(pixel(frame), 1.5, "ink", 1.0)
    for sign, colour in ((1.0, RED), (-1.0, BLUE)):
        for least, most, width in ((THIN, THICK, 2.0), (THICK, np.inf, 5.0)):
            chosen = (sign * panel.widths >= least) & (sign * panel.widths < most)
            canvas.lines(pixel(panel.lines[chosen]), width, colour, 2.0)
    if panel.load is not None:
        canvas.lines(pixel(panel.load), 9.0, GREEN, 3.0)
    _draw_scale(canvas, panel, style, corner + np.array([PART * WIDTH + 70.0, 0.0]), factor * span[1])
    canvas.write(panel.title, (LEFT, top), (0.0, -1.7 * TEXT), is_bold=True)


def _draw_scale(
    canvas: Canvas, panel: FieldPanel, style: dict[str, Any], corner: Floats, height: float
) -> None:
    """Draw the colours with their values beside a field."""
    ends = corner[1] + height * np.linspace(0.0, 1.0, BANDS + 1)
    points = [(corner[0] + side * SCALE_WIDTH, end) for end in ends for side in (0.0, 1.0)]
    cells = [(2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2) for k in range(BANDS)]
    low, high = panel.limits
    canvas.fill(points, cells, scalars=low + (high - low) * (np.arange(BANDS) + 0.5) / BANDS, **style)
    for part in np.linspace(0.0, 1.0, LABELS):
        place = (corner[0] + SCALE_WIDTH, corner[1] + height * part)
        canvas.write(f"{low + (high - low) * part:g}", place, (10.0, -0.35 * TEXT), 0.8 * TEXT)
