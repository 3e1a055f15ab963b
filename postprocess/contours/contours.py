"""Contour pictures of nodal fields on the deformed plate, above the rigid wall: one PNG a field.

Drawn by VTK off the screen, without an X server. Nothing is lit, so a pixel inside an element has exactly the
colour of its band on the scalar bar. The view takes in the plate and as much of the wall as fits beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.contours.canvas import (
    INK,
    Canvas,
    add_disc,
    add_field,
    add_line,
    add_scale,
    add_surface,
    add_text,
    canvas,
)
from postprocess.contours.colour_scale import WIDENING, ColourScale, colour_scale
from postprocess.contours.view import View, round_positions, view_of_plate
from postprocess.report.units import SI, Units

SIZE = (1600, 700)
WALL, WALL_EDGE = "#bfc3c7", "#a9aeb3"

Floats = NDArray[np.float64]
Quads = NDArray[np.integer[Any]]


@dataclass(frozen=True)
class ContourField:
    """A nodal field: part of the file name ("v_gx"), text of the title, unit, values (n,) in that unit."""

    name: str
    title: str
    unit: str
    values: Floats

    def in_units(self, units: Units) -> "ContourField":
        """The same in other units."""
        factor, unit = units.of(self.unit)
        return replace(self, unit=unit, values=factor * self.values)


@dataclass(frozen=True)
class Setting:
    """What all pictures of one instant share.

    points: deformed nodes of the plate [m], shape (n, 2); quads: its elements, shape (e, 4); wall_points and
    wall_quads: the same for the wall, which without them is the line Y = 0; corner and centroid: the points P and G [m]
    to mark; time: of the strike [s]; length_unit: of all lengths, where it is not m.
    """

    points: Floats
    quads: Quads
    wall_points: Floats | None = None
    wall_quads: Quads | None = None
    corner: Sequence[float] | None = None
    centroid: Sequence[float] | None = None
    scene: str = ""
    time: float | None = None
    length_unit: str = "m"

    def in_units(self, units: Units) -> "Setting":
        """The same with its lengths in another unit."""
        factor, unit = units.of(self.length_unit)
        places = {name: getattr(self, name) for name in ("points", "wall_points", "corner", "centroid")}
        scaled: dict[str, Any] = {
            name: factor * np.asarray(given) for name, given in places.items() if given is not None
        }
        return replace(self, length_unit=unit, **scaled)


def draw_contours(
    setting: Setting, fields: Sequence[ContourField], out_dir: Path, units: Units = SI
) -> list[Path]:
    """Write `contour_NAME.png` for each field into out_dir, with what it says in these units; returns the paths."""
    setting, fields = setting.in_units(units), [field.in_units(units) for field in fields]
    moment = [] if setting.time is None else [f"tail-slap at t = {setting.time:.4g} s"]
    view = view_of_plate(setting.points, SIZE)
    with canvas(view) as plotter:
        _add_wall(plotter, setting, view)
        _add_height_ruler(plotter, setting, view)
        add_text(plotter, ",  ".join([setting.scene, *moment]), (SIZE[0] - 24, SIZE[1] - 44), 20, "right")
        return [
            _draw(plotter, setting, field, view, out_dir / f"contour_{field.name}.png") for field in fields
        ]


def range_note(field: ContourField, scale: ColourScale) -> str:
    """The line under the title: smallest and largest nodal value, or that the field as good as does not vary."""
    low, high = float(np.min(field.values)), float(np.max(field.values))
    if not scale.uniform:
        ends = (end if abs(end) > 1e-5 * (high - low) else 0.0 for end in (low, high))
        return "nodal values from {} to {} {}".format(*(_signed(f"{end:.4g}") for end in ends), field.unit)
    share = (high - low) / (max(abs(low), abs(high)) or 1.0)
    return (
        f"uniform to {share:.0e}: {_signed(f'{0.5 * (low + high):.5g}')} {field.unit} at every node; "
        f"the colour range is widened to {100.0 * WIDENING:g} %"
    )


def value_at(points: Floats, values: Floats, place: Sequence[float]) -> float:
    """A nodal field at a point: the mean of the nodes nearest to it, by the inverse of their distance."""
    far = np.hypot(*(points - np.asarray(place, float)).T)
    near = np.argsort(far)[:4]
    weights = 1.0 / np.maximum(far[near], 1e-6 * (far.max() or 1.0))
    return float(np.average(values[near], weights=weights))


def _signed(text: str) -> str:
    return text.replace("-", "−", 1)


def _draw(plotter: Canvas, setting: Setting, field: ContourField, view: View, path: Path) -> Path:
    """Write one field, and take it away again: the wall and the rulers stay for the next."""
    scale = colour_scale(field.values)
    plate = add_field(plotter, setting.points, setting.quads, field.values, scale)
    drawn = [
        plate,
        add_scale(plotter, plate, scale),
        *_add_marks(plotter, setting, field, view),
        add_text(plotter, f"{field.title} [{field.unit}]", (24, SIZE[1] - 46), 28, bold=True),
        add_text(plotter, range_note(field, scale), (24, SIZE[1] - 78), 18),
    ]
    plotter.write(path)
    plotter.remove(*drawn)
    return path


def _add_wall(plotter: Canvas, setting: Setting, view: View) -> None:
    left, right = view.span()
    caption = "wall line, Y = 0"
    if setting.wall_points is not None and setting.wall_quads is not None:
        add_surface(plotter, setting.wall_points, setting.wall_quads, -0.02, WALL, edge=WALL_EDGE)
        left = max(left, float(setting.wall_points[:, 0].min()))
        right = min(right, float(setting.wall_points[:, 0].max()))
        caption = "rigid wall, Y ≤ 0"
    add_line(plotter, np.array([[left, 0.0], [right, 0.0]]))
    _add_ruler(plotter, left, right, view)
    add_text(plotter, caption, (24, 24), 20)
    add_text(plotter, f"X [{setting.length_unit}], driving direction →", (SIZE[0] - 24, 24), 20, "right")


def _add_ruler(plotter: Canvas, left: float, right: float, view: View) -> None:
    """Ticks and X values along the wall line, away from the borders of the picture."""
    margin = 30 * view.pixel_length
    for x in round_positions(left + margin, right - margin):
        column, row = view.pixel(x, 0.0)
        add_line(plotter, np.array([[x, 0.0], [x, -8.0 * view.pixel_length]]))
        add_text(plotter, f"{x:g}", (column, row - 30), 18, "center")


def _add_height_ruler(plotter: Canvas, setting: Setting, view: View) -> None:
    """Ticks and Y values beside the plate, to its left."""
    left, top = (
        float(setting.points[:, 0].min()) - 14.0 * view.pixel_length,
        float(setting.points[:, 1].max()),
    )
    for y in round_positions(0.0, top, 5)[1:]:
        column, row = view.pixel(left, y)
        add_line(plotter, np.array([[left, y], [left + 8.0 * view.pixel_length, y]]))
        add_text(plotter, f"{y:g}", (column - 6, row - 7), 18, "right")
    add_text(plotter, f"Y [{setting.length_unit}]", (24, view.pixel(0.0, top)[1] + 12), 18)


def _add_marks(plotter: Canvas, setting: Setting, field: ContourField, view: View) -> list[Any]:
    """The points P and G, with the field's value at G; returns what was added."""
    added: list[Any] = []
    for name, point in (("P", setting.corner), ("G", setting.centroid)):
        if point is not None:
            value = _signed(f"{value_at(setting.points, field.values, point):.4g}")
            shown = f"G: {value} {field.unit}" if name == "G" else name
            added += _add_mark(plotter, shown, (float(point[0]), float(point[1])), view)
    return added


def _add_mark(plotter: Canvas, name: str, point: tuple[float, float], view: View) -> list[Any]:
    column, row = view.pixel(*point)
    label = add_text(plotter, name, (column + 14, row + 10), 24)
    label.GetTextProperty().SetBackgroundColor(1.0, 1.0, 1.0)
    label.GetTextProperty().SetBackgroundOpacity(0.8)
    return [
        add_disc(plotter, point, 8 * view.pixel_length, INK, 0.02),
        add_disc(plotter, point, 5 * view.pixel_length, "#ffffff", 0.03),
        label,
    ]
