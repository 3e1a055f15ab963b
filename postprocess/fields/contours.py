"""Contour pictures of fields on the plate above the wall.

PNG files of one or many instants, and GIF. The view includes the plate at all its instants, and the adjacent part of
the wall. A field has one scale of colours for all instants, so that visible changes are real.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.fields.canvas import DARK, LIGHT, SIZE, Canvas, Size
from postprocess.fields.colour_scale import (
    ColourScale,
    ContourField,
    Floats,
    colour_scale,
    field_title,
    range_note,
    shown_unit,
)
from postprocess.fields.series import ELEMENTS, UNITS, FieldSeries
from postprocess.svg.scales import round_ticks, tick_texts
from postprocess.units import SI, Units

if TYPE_CHECKING:
    from PIL import Image

FRAME_MS, GIF_SIZE, COLOURS = 120, (960, 420), 128

MODE_SIZE, MODE_DOT, REACH = (1000, 440), 0.8, 0.3
"""Size and point of pictures of modes [pixels], and their largest displacement over the width of the plate."""

SIDE, TOP, BOTTOM = 70, 190, 120
"""Margins for the rulers, for title and scale, and for the wall [points]."""

BAR, THICK = (0.12, 0.88, 160), 23
"""Ends of the bar of colours, over the width, its lower edge from the top, and its thickness [points]."""

EDGES: dict[str, Any] = {"show_edges": True, "edge_color": "black", "edge_opacity": 0.35}
"""Style of mesh lines."""

TITLE, NOTE = 34, 23
"""Sizes of letters [points]."""

HATCH_STEP = 26
"""Distance of the hatching lines of the wall [points]."""

Mesh = tuple[Floats, NDArray[np.integer]]
"""Points, shape (n, 2), and elements, shape (e, 3 or 4)."""


@dataclass(frozen=True)
class Situation:
    """Geometry and texts of pictures of one instant.

    plate: deformed nodes [m] and elements; wall: the same, None for the line Y = 0; corner, centroid: points P and G
    [m] to be marked; time: of the strike [s].
    """

    plate: Mesh
    wall: Mesh | None = None
    corner: Sequence[float] | None = None
    centroid: Sequence[float] | None = None
    scene: str = ""
    time: float | None = None


def draw_contours(
    situation: Situation, fields: Sequence[ContourField], out_dir: Path, units: Units = SI, size: Size = SIZE
) -> list[Path]:
    """Draw fields as `contour_NAME.png` and return the paths.

    Beside each is its dark form. units: of the texts; size: [pixels]. ImportError on a machine that cannot draw.
    """
    length, length_unit = units.of("m")
    (points, cells), wall, paths = situation.plate, situation.wall, []
    points = length * points
    moment = [] if situation.time is None else [f"tail-slap at t = {situation.time:.4g} s"]
    with closing(Canvas(size)) as canvas:
        sheet = Sheet(canvas, points, None if wall is None else length * wall[0], length_unit)
        for field in fields:
            factor, unit = shown_unit(field, units)
            marks = dict[tuple[float, ...], str]()
            field = replace(field, unit=unit, values=factor * field.values)
            if situation.corner is not None:
                marks[tuple(length * np.asarray(situation.corner))] = "P"
            if situation.centroid is not None:
                centre = length * np.asarray(situation.centroid)
                places = points if field.where == "nodal" else points[cells].mean(axis=1)
                at_centre = value_at(places, field.values, centre)
                value = at_centre if field.of_centre is None else factor * field.of_centre
                marks[tuple(centre)] = f"G: {value:#.5g} {unit}"
            texts, scale = ",  ".join([situation.scene, *moment]), colour_scale(field.values)
            paths.append(out_dir / f"contour_{field.name}.png")
            for path in forms(canvas, paths[-1]):
                draw_field(sheet, (points, cells), field, scale, texts, marks)
                save(canvas.image(), path)
    return paths


def dark_form(path: Path) -> Path:
    """Return the path of a picture for dark screens."""
    return path.with_stem(f"{path.stem}-dark")


def forms(canvas: Canvas, path: Path) -> Iterator[Path]:
    """Yield the paths of the light and the dark form, each begun."""
    for form, colours in ((path, LIGHT), (dark_form(path), DARK)):
        canvas.clear(colours)
        yield form


def draw_modes(folder: Path, plate: Mesh, shapes: Mapping[str, tuple[str, Floats]]) -> list[Path]:
    """Draw modes as `NAME.png` and return the paths.

    The plate at rest is grey. Beside each is its dark form. shapes: title, and displacements of largest length one,
    shape (nodes, 2), by name. ImportError on a machine that cannot draw.
    """
    rest, cells = plate
    reach, scale = REACH * np.ptp(rest, axis=0).min(), colour_scale(np.array([0.0, 1.0]))
    rest = rest - rest.min(axis=0) + 1.1 * reach
    with closing(Canvas(MODE_SIZE, MODE_DOT)) as canvas:
        view = view_of_plate(np.array([(0.0, 0.0), rest.max(axis=0) + 1.1 * reach]), canvas.size, canvas.dot)
        for name, (title, shape) in shapes.items():
            field = ContourField(name, title, "-", np.hypot(*shape.T))
            for path in forms(canvas, folder / f"{name}.png"):
                canvas.fill(view.pixel(rest), cells, -1.0, style="wireframe", color="hatch")
                draw_values(canvas, (view.pixel(rest + reach * shape), cells), field, scale)
                canvas.write(title, (0, canvas.size[1]), (24, -50), TITLE, is_bold=True)
                canvas.write("displacement over its largest", (0, canvas.size[1]), (24, -88), NOTE)
                save(canvas.image(), path)
    return [folder / f"{name}.png" for name in shapes]


def draw_instants(
    folder: Path,
    series: FieldSeries,
    name: str,
    magnify: float = 1.0,
    instants: Sequence[int] | None = None,
    units: Units = SI,
    size: Size = SIZE,
    follow: Callable[[], object] = lambda: None,
) -> list[Path]:
    """Draw instants as NAME_0000.png and so on, and return the paths.

    name: of `SCALARS`; magnify: factor of the elastic deformation; instants: numbers, by default all; units: of the
    texts; size: of a picture [pixels]; follow: called after each picture.
    """
    chosen = range(len(series.t)) if instants is None else [k % len(series.t) for k in instants]
    paths = [folder / f"{name}_{k:04d}.png" for k in chosen]
    for path, frame in zip(paths, frames(series, name, magnify, chosen, units, size), strict=True):
        save(frame, path)
        follow()
    return paths


def animate(
    path: Path,
    series: FieldSeries,
    name: str,
    magnify: float = 1.0,
    units: Units = SI,
    size: Size = GIF_SIZE,
    follow: Callable[[], object] = lambda: None,
) -> Path:
    """Write all instants as a repeating GIF.

    follow: called after each instant.
    """
    pictures = []
    for frame in frames(series, name, magnify, range(len(series.t)), units, size):
        pictures.append(frame.quantize(COLOURS))
        follow()
    first, *further = pictures
    first.save(path, save_all=True, append_images=further, duration=FRAME_MS, loop=0)
    return path


def frames(
    series: FieldSeries, name: str, magnify: float, instants: Sequence[int], units: Units, size: Size = SIZE
) -> Iterator[Image.Image]:
    """Yield the chosen instants of a field as images of Pillow.

    name: of `SCALARS`; instants: numbers.
    """
    where: Literal["nodal", "element"] = "element" if name in ELEMENTS else "nodal"
    whole = ContourField(name, field_title(name), UNITS[name], series.scalar(name), where)
    (factor, unit), (length, length_unit) = shown_unit(whole, units), units.of("m")
    values, places = factor * whole.values, length * series.places(magnify)
    scale = colour_scale(values)
    deformed = f",  elastic deformation × {magnify:g}" if magnify != 1.0 else ""
    with closing(Canvas(size)) as canvas:
        sheet = Sheet(canvas, places.reshape(-1, 2), None, length_unit)
        for k in instants:
            field, note = replace(whole, unit=unit, values=values[k]), f"t = {series.t[k]:.4f} s{deformed}"
            canvas.clear()
            draw_field(sheet, (places[k], series.corners), field, scale, note)
            yield canvas.image()


def save(image: Image.Image, path: Path) -> None:
    """Write a PNG of a few colours, which halves its size.

    The colours of bands are exact.
    """
    image.quantize(COLOURS).save(path)


def value_at(points: Floats, values: Floats, place: ArrayLike) -> float:
    """Return a nodal field at a point.

    The mean of the nearest nodes, weighted by the inverse of their distance.
    """
    far = np.hypot(*(points - np.asarray(place, float)).T)
    near = np.argsort(far)[:4]
    weights = 1.0 / np.maximum(far[near], 1e-6 * (far.max() or 1.0))
    return float(np.average(values[near], weights=weights))


class PixelMap(NamedTuple):
    """Transformation from places to pixels.

    origin: pixel of X = Y = 0, from the lower left corner; length: of a pixel.
    """

    origin: tuple[float, float]
    length: float

    def pixel(self, places: ArrayLike) -> Floats:
        """Return the pixels of places, shape (..., 2)."""
        return np.asarray(self.origin) + np.asarray(places, float) / self.length

    def place(self, pixels: ArrayLike) -> Floats:
        """Return the places of pixels, shape (..., 2)."""
        return self.length * (np.asarray(pixels, float) - self.origin)


def view_of_plate(points: Floats, size: Size = SIZE, dot: float = 1.0) -> PixelMap:
    """Return the view that fits plate and wall line into the picture.

    points: shape (n, 2); dot: pixels of a point.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    low[1] = min(low[1], 0.0)
    margins = dot * np.array([[SIDE, BOTTOM], [SIDE, TOP]])
    room = np.array(size) - margins.sum(axis=0)
    length = float(((high - low) / room).max())
    origin = margins[0] + 0.5 * room - 0.5 * (low + high) / length
    return PixelMap((float(origin[0]), float(origin[1])), length)


class Sheet(NamedTuple):
    """Plate at all drawn instants and wall above a canvas.

    plates, wall: points, shape (n, 2), no wall for the line Y = 0; unit: of all lengths.
    """

    canvas: Canvas
    plates: Floats
    wall: Floats | None
    unit: str


def draw_field(
    sheet: Sheet,
    plate: Mesh,
    field: ContourField,
    scale: ColourScale,
    note: str,
    marks: Mapping[tuple[float, ...], str] | None = None,
) -> None:
    """Draw a field on the plate, with its title, range and scale.

    note: at the upper right; marks: texts beside points. ValueError for another number of values.
    """
    canvas, (wide, high) = sheet.canvas, sheet.canvas.size
    view = view_of_plate(sheet.plates, canvas.size, canvas.dot)
    _draw_wall(sheet, view)
    draw_values(canvas, (view.pixel(plate[0]), plate[1]), field, scale)
    for place, text in (marks or {}).items():
        canvas.dots(view.pixel(place), 8.0)
        canvas.write(text, view.pixel(place), (18, 14), ground=0.8)
    canvas.write(f"{field.title} [{field.unit}]", (0, high), (24, -50), TITLE, is_bold=True)
    canvas.write(range_note(field, scale), (0, high), (24, -88), NOTE)
    canvas.write(note, (wide, high), (-24, -50), align="right")


def _draw_wall(sheet: Sheet, view: PixelMap) -> None:
    """Draw the hatched wall or line, with rulers.

    One ruler is along the wall, one beside the plate.
    """
    canvas, dot, (wide, _), caption = sheet.canvas, sheet.canvas.dot, sheet.canvas.size, "wall line, Y = 0"
    (start, bottom), (end, _) = view.place([(0, 0), (wide, 0)])
    (beside, _), (_, top) = sheet.plates.min(axis=0), sheet.plates.max(axis=0)
    if sheet.wall is not None:
        low, high, caption = sheet.wall.min(axis=0), sheet.wall.max(axis=0), "rigid wall, Y ≤ 0"
        start, end, bottom = max(start, low[0]), min(end, high[0]), max(bottom, low[1])
        if start < end:
            box = [(start, bottom), (end, bottom), (end, 0), (start, 0)]
            canvas.fill(view.pixel(box), [[0, 1, 2, 3]], -2.0, color="wall")
            feet = np.arange(start + bottom, end, HATCH_STEP * dot * view.length)[:, None]
            across = np.clip(feet + np.array([0.0, -bottom]), start, end)
            canvas.lines(view.pixel(np.stack([across, across - feet + bottom], -1)), 1.5, "hatch", -1.0)
    margin = 30 * dot * view.length
    along, up = round_between(start + margin, end - margin, 12), round_between(0.0, top, 5)[1:]
    feet = view.pixel([(x, 0.0) for x in along] or np.empty((0, 2)))
    beams = view.pixel([(beside, y) for y in up] or np.empty((0, 2)))
    lines = [foot - dot * np.array([(0, 0), (0, 8)]) for foot in feet]
    lines += [beam - dot * np.array([(14, 0), (6, 0)]) for beam in beams]
    canvas.lines([view.pixel([(start, 0), (max(start, end), 0)]), *lines], 2.0, "ink", 1.0)
    for text, foot in zip(tick_texts(along), feet, strict=True):
        canvas.write(text, foot, (0, -36), align="middle", ground=0.8)
    for text, beam in zip(tick_texts(up), beams, strict=True):
        canvas.write(text, beam, (-20, -9), align="right")
    canvas.write(f"Y [{sheet.unit}]", (0, view.pixel((0, top))[1]), (24, 20))
    canvas.write(caption, (0, 0), (24, 24), ground=0.8)
    canvas.write(f"X [{sheet.unit}], driving direction →", (wide, 0), (-24, 24), align="right", ground=0.8)


def round_between(low: float, high: float, most: int) -> list[float]:
    """Return up to about `most` round numbers, none in an empty range."""
    return round_ticks(low, high, most) if low < high else []


def draw_values(canvas: Canvas, plate: Mesh, field: ContourField, scale: ColourScale) -> None:
    """Draw nodal or element values with mesh lines, and the scale.

    plate: points [pixels] and elements. ValueError for another number of values.
    """
    (points, cells), is_nodal, (wide, high) = plate, field.where == "nodal", canvas.size
    if len(field.values) != (expected := len(points if is_nodal else cells)):
        raise ValueError(f"{len(field.values)} values for {expected} {field.where} values of the plate")
    style: dict[str, Any] = {"cmap": "viridis", "n_colors": scale.bands, "clim": (scale.low, scale.high)}
    preference = "point" if is_nodal else "cell"
    canvas.fill(points, cells, scalars=field.values, preference=preference, **style, **EDGES)
    lower, upper = (high - canvas.dot * down for down in (BAR[2], BAR[2] - THICK))
    places = wide * np.linspace(*BAR[:2], scale.bands + 1)
    strip = np.column_stack([np.repeat(places, 2), np.tile([lower, upper], scale.bands + 1)])
    quads = 2 * np.arange(scale.bands)[:, None] + np.array([0, 2, 3, 1])
    middles = np.linspace(scale.low, scale.high, 2 * scale.bands + 1)[1::2]
    canvas.fill(strip, quads, scalars=middles, preference="cell", **style)
    for label, place in zip(scale.labels, np.linspace(places[0], places[-1], len(scale.labels)), strict=True):
        canvas.write(label, (place, upper), (0, 10), align="middle")
