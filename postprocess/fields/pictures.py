"""Pictures of fields on the plate where it is: one an instant as PNG, or all instants as an animation, GIF.

One scale of colours and one frame for all instants of a field, so that what is seen to change has changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.fields.series import ELEMENTS, NODES, UNITS, FieldSeries
from postprocess.figures.style import style
from postprocess.report.units import Units

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DRAWN = (*(f"{name}_{axis}" for name in NODES for axis in "xy"), *NODES, *ELEMENTS)
"""What can be drawn: components along and across the wall, sizes of vectors, and fields of elements."""

SIZE, DOTS = (8.0, 4.2), 120
"""Of a picture [inches], and dots an inch."""

COLOURS, FRAME_MS, MARGIN = "viridis", 120, 0.05

AS_STORED = Units("as stored", {})
"""SI, without any prefix."""


def element_values(series: FieldSeries, name: str) -> np.ndarray:
    """The field as a value an element, the mean of its nodes', shape (instants, elements).

    Raises KeyError for a name that is not in `DRAWN`.
    """
    if name in ELEMENTS:
        return series.elemental[name]
    vector, _, axis = name.rpartition("_")
    if name not in NODES and (vector not in NODES or axis not in ("x", "y")):
        raise KeyError(name)
    nodal = np.linalg.norm(series.nodal[name], axis=-1) if name in NODES else _component(series, vector, axis)
    return np.asarray(nodal[:, series.cells].mean(axis=-1))


def _component(series: FieldSeries, vector: str, axis: str) -> np.ndarray:
    return series.nodal[vector][:, :, "xy".index(axis)]


def field_unit(name: str) -> str:
    """Unit of what is drawn under this name."""
    return UNITS.get(name) or UNITS[name.rpartition("_")[0]]


def draw_instants(
    folder: Path,
    series: FieldSeries,
    name: str,
    magnify: float = 1.0,
    instants: Sequence[int] | None = None,
    units: Units = AS_STORED,
) -> list[Path]:
    """Write NAME_0000.png and so on, of these instants by number, or of all; magnify: of the elastic deformation;
    units: of what is shown."""
    chosen = range(len(series.t)) if instants is None else instants
    from PIL import Image

    drawing = Drawing(series, name, magnify, units)
    paths = []
    for k in chosen:
        path = folder / f"{name}_{k % len(series.t):04d}.png"
        Image.fromarray(drawing.pixels(k)).save(path, dpi=(DOTS, DOTS))
        paths.append(path)
    return paths


def animate(
    path: Path, series: FieldSeries, name: str, magnify: float = 1.0, units: Units = AS_STORED
) -> Path:
    """Write all instants as a GIF that repeats."""
    from PIL import Image

    drawing = Drawing(series, name, magnify, units)
    frames = [Image.fromarray(drawing.pixels(k)).quantize(64) for k in range(len(series.t))]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=FRAME_MS, loop=0)
    return path


class Drawing:
    """A figure of one field, whose polygons, colours and title are those of the instant that is asked for."""

    def __init__(self, series: FieldSeries, name: str, magnify: float, units: Units = AS_STORED) -> None:
        from matplotlib.collections import PolyCollection
        from matplotlib.figure import Figure

        self._series, self._name, self._magnify = series, name, magnify
        (factor, unit), (self._length, length_unit) = units.of(field_unit(name)), units.of("m")
        self._values = factor * element_values(series, name)
        with style():
            self._figure = Figure(figsize=SIZE, dpi=DOTS, layout="constrained")
            self._axes = self._figure.subplots()
        self._plate = PolyCollection([], edgecolors="face", linewidths=0.4, cmap=COLOURS)
        self._plate.set_clim(float(self._values.min()), float(self._values.max()))
        self._axes.add_collection(self._plate, autolim=False)
        self._figure.colorbar(
            self._plate, ax=self._axes, label=f"{name} [{unit}]", location="bottom", aspect=40
        )
        self._frame(length_unit)
        self.at(0).draw_without_rendering()
        self._figure.set_layout_engine("none")  # that of the first instant is all the others'

    def at(self, k: int) -> Figure:
        """The figure at this instant."""
        self._plate.set_verts(self._places(k))
        self._plate.set_array(self._values[k])
        deformed = f", elastic deformation × {self._magnify:g}" if self._magnify != 1.0 else ""
        self._axes.set_title(f"t = {self._series.t[k]:.4f} s{deformed}", fontsize=10)
        return self._figure

    def pixels(self, k: int) -> np.ndarray:
        """The same as colours, shape (rows, columns, 3)."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        canvas = FigureCanvasAgg(self.at(k))
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()

    def _places(self, k: int) -> Any:
        """Corners of the elements, shape (elements, corners, 2)."""
        s = self._series
        more = (self._magnify - 1.0) * s.nodal["elastic_displacement"][k]
        corners = 3 if s.cell_type.startswith("triangle") else 4
        return self._length * (s.points + s.nodal["displacement"][k] + more)[s.cells[:, :corners]]

    def _frame(self, unit: str) -> None:
        """Equal scales, the wall, and room for all instants."""
        ends = np.concatenate([self._places(k).reshape(-1, 2) for k in range(len(self._series.t))])
        low, high = ends.min(axis=0), ends.max(axis=0)
        room = MARGIN * (high - low).max()
        self._axes.set(xlim=(low[0] - room, high[0] + room), ylim=(min(low[1], 0.0) - room, high[1] + room))
        self._axes.set(aspect="equal", xlabel=f"X along the wall [{unit}]", ylabel=f"Y [{unit}]")
        self._axes.axhline(0.0, color="#1b1f24", linewidth=1.2)
