"""Contour pictures of nodal fields on the deformed plate, above the rigid wall: one PNG a field.

Drawn by VTK off the screen, without an X server. Nothing is lit, so a pixel inside an element has exactly the
colour of its band on the scalar bar. The view takes in the plate and as much of the wall as fits beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.contours.canvas import INK, add_disc, add_line, add_text, canvas, style_text, surface
from postprocess.contours.colour_scale import WIDENING, ColourScale, colour_scale
from postprocess.contours.view import View, round_positions, view_of_plate

SIZE = (1600, 700)
COLOUR_MAP = "viridis"
WALL, WALL_EDGE, OUTLINE = "#bfc3c7", "#a9aeb3", "#d1495b"

Floats = NDArray[np.float64]
Quads = NDArray[np.integer[Any]]


@dataclass(frozen=True)
class ContourField:
    """A nodal field: part of the file name ("v_gx"), text of the title, unit, values (n,) in that unit."""

    name: str
    title: str
    unit: str
    values: Floats


@dataclass(frozen=True)
class Setting:
    """What all pictures of one instant share; see `draw_contours` for shapes and units."""

    points: Floats
    quads: Quads
    wall_points: Floats | None
    wall_quads: Quads | None
    outline: Floats | None
    corner: Sequence[float] | None
    centroid: Sequence[float] | None
    caption: str


def draw_contours(
    points: Floats,
    quads: Quads,
    fields: Sequence[ContourField],
    out_dir: Path,
    *,
    wall_points: Floats | None = None,
    wall_quads: Quads | None = None,
    outline: Floats | None = None,
    corner: Sequence[float] | None = None,
    centroid: Sequence[float] | None = None,
    scene: str = "",
    time: float | None = None,
) -> list[Path]:
    """Writes `contour_NAME.png` for each field into out_dir and returns the paths.

    points: deformed nodes of the plate [m], shape (n, 2); quads: its elements, shape (e, 4); wall_points and
    wall_quads: the same for the wall, which without them is the line Y = 0; outline: closed reference
    polygon [m], shape (k, 2); corner and centroid: the points P and G [m] to mark; time: of the strike [s].
    """
    moment = [] if time is None else [f"tail-slap at t = {time:.4g} s"]
    caption = ",  ".join([scene, *moment])
    setting = Setting(points, quads, wall_points, wall_quads, outline, corner, centroid, caption)
    return [_draw(setting, field, out_dir / f"contour_{field.name}.png") for field in fields]


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


def _draw(setting: Setting, field: ContourField, path: Path) -> Path:
    view, scale = view_of_plate(setting.points, SIZE), colour_scale(field.values)
    with canvas(view) as plotter:
        _add_wall(plotter, setting, view)
        _add_plate(plotter, setting, field, scale)
        _add_height_ruler(plotter, setting, view)
        _add_marks(plotter, setting, field, view)
        add_text(plotter, f"{field.title} [{field.unit}]", (24, SIZE[1] - 46), 28, bold=True)
        add_text(plotter, setting.caption, (SIZE[0] - 24, SIZE[1] - 44), 20, "right")
        add_text(plotter, range_note(field, scale), (24, SIZE[1] - 78), 18)
        plotter.screenshot(path)
    return path


def _add_plate(plotter: Any, setting: Setting, field: ContourField, scale: ColourScale) -> None:
    plate = surface(setting.points, setting.quads, 0.0)
    plate.point_data[field.name] = field.values
    colours = {"cmap": COLOUR_MAP, "clim": (scale.low, scale.high), "n_colors": scale.bands}
    style = {"show_edges": True, "edge_opacity": 0.35, "line_width": 1, "lighting": False}
    plotter.add_mesh(plate, scalars=field.name, show_scalar_bar=False, reset_camera=False, **colours, **style)
    place = {"position_x": 0.12, "position_y": 0.77, "width": 0.76, "height": 0.09}
    bar = plotter.add_scalar_bar(
        title="", mapper=plotter.mapper, n_labels=scale.labels, fmt=scale.format, **place
    )
    bar.UnconstrainedFontSizeOn()
    style_text(bar.GetLabelTextProperty(), 21)


def _add_wall(plotter: Any, setting: Setting, view: View) -> None:
    left, right = view.span()
    caption = "wall line, Y = 0"
    if setting.wall_points is not None and setting.wall_quads is not None:
        wall = surface(setting.wall_points, setting.wall_quads, -0.02)
        edges = {"show_edges": True, "edge_color": WALL_EDGE, "line_width": 1}
        plotter.add_mesh(wall, color=WALL, lighting=False, reset_camera=False, **edges)
        left = max(left, float(setting.wall_points[:, 0].min()))
        right = min(right, float(setting.wall_points[:, 0].max()))
        caption = "rigid wall, Y ≤ 0"
    add_line(plotter, np.array([[left, 0.0], [right, 0.0]]))
    _add_ruler(plotter, left, right, view)
    add_text(plotter, caption, (24, 24), 20)
    add_text(plotter, "X [m], driving direction →", (SIZE[0] - 24, 24), 20, "right")


def _add_ruler(plotter: Any, left: float, right: float, view: View) -> None:
    """Ticks and X values [m] along the wall line, away from the borders of the picture."""
    margin = 30 * view.pixel_length
    for x in round_positions(left + margin, right - margin):
        column, row = view.pixel(x, 0.0)
        add_line(plotter, np.array([[x, 0.0], [x, -8.0 * view.pixel_length]]))
        add_text(plotter, f"{x:g}", (column, row - 30), 18, "center")


def _add_height_ruler(plotter: Any, setting: Setting, view: View) -> None:
    """Ticks and Y values [m] beside the plate, to its left."""
    left, top = (
        float(setting.points[:, 0].min()) - 14.0 * view.pixel_length,
        float(setting.points[:, 1].max()),
    )
    for y in round_positions(0.0, top, 5)[1:]:
        column, row = view.pixel(left, y)
        add_line(plotter, np.array([[left, y], [left + 8.0 * view.pixel_length, y]]))
        add_text(plotter, f"{y:g}", (column - 6, row - 7), 18, "right")
    add_text(plotter, "Y [m]", (24, view.pixel(0.0, top)[1] + 12), 18)


def _add_marks(plotter: Any, setting: Setting, field: ContourField, view: View) -> None:
    if setting.outline is not None:
        add_line(plotter, np.vstack([setting.outline, setting.outline[:1]]), OUTLINE)
        add_text(plotter, "red outline: reference", (SIZE[0] / 2, 24), 20, "center")
    for name, point in (("P", setting.corner), ("G", setting.centroid)):
        if point is not None:
            value = _signed(f"{value_at(setting.points, field.values, point):.4g}")
            shown = f"G: {value} {field.unit}" if name == "G" else name
            _add_mark(plotter, shown, (float(point[0]), float(point[1])), view)


def _add_mark(plotter: Any, name: str, point: tuple[float, float], view: View) -> None:
    add_disc(plotter, point, 8 * view.pixel_length, INK, 0.02)
    add_disc(plotter, point, 5 * view.pixel_length, "white", 0.03)
    column, row = view.pixel(*point)
    label = add_text(plotter, name, (column + 14, row + 10), 24)
    label.prop.background_color = "white"
    label.prop.background_opacity = 0.8
