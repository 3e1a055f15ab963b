"""Contour pictures of fields on the plate where it is, above the wall: PNG files of one or many instants, and GIF.

PyVista draws off the screen, without an X server, in a world whose unit is the pixel. Nothing is lit, so a pixel inside
an element has exactly the colour of its band on the scale. The view takes in the plate at all its instants, and as much
of the wall as fits beside it; a field has one scale of colours for all of them, so that what is seen to change has
changed.
"""

import ctypes
import math
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.fields.series import ELEMENTS, UNITS, FieldSeries
from postprocess.svg.scales import round_step, round_ticks
from postprocess.units import SI, Units

SIZE = (1600, 700)
SIDE, TOP, BOTTOM = 70, 190, 120
"""Pixels around the plate: for the rulers, for title and scale, for the wall."""

BAR = (192, 1408, 540, 563)
"""Ends of the bar of colours along the picture and across it, in pixels."""

INK, WALL, WALL_EDGE = "#1b1f24", "#bfc3c7", "#a9aeb3"
STEPS = 7
"""Steps between labels of the scale, at most."""

UNIFORM, WIDENING = 1e-4, 1e-2
"""Variation, over a field's size, up to which it is drawn as uniform, and the range that it is then shown in."""

FRAME_MS, GIF_SIZE, GIF_COLOURS = 120, (960, 420), 64

Floats = NDArray[np.float64]
Mesh = tuple[Floats, NDArray[Any]]
"""Points, shape (n, 2), and elements, shape (e, k)."""


@dataclass(frozen=True)
class ContourField:
    """A field: part of the file name ("v_gx"), text of the title, unit, values in that unit, "nodal" or "element", and
    value of the centre of mass, that of the field there where it is left out."""

    name: str
    title: str
    unit: str
    values: Floats
    where: Literal["nodal", "element"] = "nodal"
    of_centre: float | None = None


@dataclass(frozen=True)
class Situation:
    """Geometry and texts that all pictures of one instant share.

    plate: deformed nodes [m] and elements; wall: the same, the line Y = 0 without one; corner and centroid: the points
    P and G [m] to mark; time: of the strike [s].
    """

    plate: Mesh
    wall: Mesh | None = None
    corner: Sequence[float] | None = None
    centroid: Sequence[float] | None = None
    scene: str = ""
    time: float | None = None


def draw_contours(
    situation: Situation, fields: Sequence[ContourField], out_dir: Path, units: Units = SI
) -> list[Path]:
    """Write `contour_NAME.png` for each field into out_dir, with what it says in these units; returns the paths."""
    length, length_unit = units.of("m")
    (points, cells), wall = situation.plate, situation.wall
    points, paths = length * points, []
    moment = [] if situation.time is None else [f"tail-slap at t = {situation.time:.4g} s"]
    with closing(Sheet(points)) as sheet:
        sheet.draw_wall(None if wall is None else (length * wall[0], wall[1]), length_unit)
        sheet.write(",  ".join([situation.scene, *moment]), (-24, -44), 20)
        marks = {"P": situation.corner, "G": situation.centroid}
        given = {name: length * np.asarray(at) for name, at in marks.items() if at is not None}
        beside = {name: sheet.draw_dot(at) for name, at in given.items()}
        if "P" in beside:
            sheet.write("P", beside["P"], 24)
        sheet.keep()
        for field in fields:
            factor, unit = units.of(field.unit)
            field = replace(field, unit=unit, values=factor * field.values)
            sheet.draw_field((points, cells), field, colour_scale(field.values))
            if situation.centroid is not None:
                at_centre = value_at(points, field.values, length * np.asarray(situation.centroid))
                value = at_centre if field.of_centre is None else factor * field.of_centre
                text = f"{value:#.5g}".replace("-", "−", 1)
                sheet.write(f"G: {text} {unit}", beside["G"], 24, ground=0.8)
            paths.append(out_dir / f"contour_{field.name}.png")
            sheet.image().save(paths[-1])
    return paths


def draw_instants(
    folder: Path,
    series: FieldSeries,
    name: str,
    magnify: float = 1.0,
    instants: Sequence[int] | None = None,
    units: Units = SI,
) -> list[Path]:
    """Write NAME_0000.png and so on.

    name: of `SCALARS`; magnify: factor on the elastic deformation; instants: by number, all without; units: of what is
    shown.
    """
    chosen = range(len(series.t)) if instants is None else [k % len(series.t) for k in instants]
    paths = [folder / f"{name}_{k:04d}.png" for k in chosen]
    for path, frame in zip(paths, frames(series, name, magnify, chosen, units), strict=True):
        frame.save(path)
    return paths


def animate(path: Path, series: FieldSeries, name: str, magnify: float = 1.0, units: Units = SI) -> Path:
    """Write all instants as a GIF that repeats."""
    drawn = frames(series, name, magnify, range(len(series.t)), units)
    first, *others = (frame.resize(GIF_SIZE).quantize(GIF_COLOURS) for frame in drawn)
    first.save(path, save_all=True, append_images=others, duration=FRAME_MS, loop=0)
    return path


def frames(
    series: FieldSeries, name: str, magnify: float, instants: Sequence[int], units: Units
) -> Iterator[Any]:
    """Draw the chosen instants, by number, of a field of `SCALARS`, one after the other, as images of Pillow."""
    (factor, unit), (length, length_unit) = units.of(UNITS[name]), units.of("m")
    values, places = factor * series.scalar(name), length * series.places(magnify)
    scale = colour_scale(values)
    deformed = f",  elastic deformation × {magnify:g}" if magnify != 1.0 else ""
    with closing(Sheet(places.reshape(-1, 2))) as sheet:
        sheet.draw_wall(None, length_unit)
        sheet.keep()
        for k in instants:
            field = ContourField(name, name, unit, values[k], "element" if name in ELEMENTS else "nodal")
            sheet.draw_field((places[k], series.corners), field, scale)
            sheet.write(f"t = {series.t[k]:.4f} s{deformed}", (-24, -44), 20)
            yield sheet.image()


class View(NamedTuple):
    """Pixel of X = Y = 0, from the lower left corner of the picture, and length of a pixel."""

    origin: tuple[float, float]
    length: float

    def pixel(self, places: ArrayLike) -> Floats:
        """Pixels of places, shape (..., 2)."""
        return np.asarray(self.origin) + np.asarray(places, float) / self.length


def view_of_plate(points: Floats) -> View:
    """The view in which the plate (points (n, 2)) and the wall line below it fill the picture."""
    low, high = points.min(axis=0), points.max(axis=0)
    low[1] = min(low[1], 0.0)
    room = np.array([SIZE[0] - 2 * SIDE, SIZE[1] - TOP - BOTTOM])
    length = float(((high - low) / room).max())
    origin = (SIDE, BOTTOM) + 0.5 * room - 0.5 * (low + high) / length
    return View((float(origin[0]), float(origin[1])), length)


@dataclass(frozen=True)
class ColourScale:
    """Ends of the colour range, its labels, low to high, and whether the field is as good as uniform."""

    low: float
    high: float
    labels: list[str]
    uniform: bool

    @property
    def bands(self) -> int:
        """Number of colours: two between labels; one about the value of a uniform field."""
        return 5 if self.uniform else 2 * (len(self.labels) - 1)


def colour_scale(values: Floats) -> ColourScale:
    """The scale for values of any shape, with labels at round values.

    A field that varies by less than 1e-4 of its size would make a drama of next to nothing. Its range is widened to
    1e-2 of its size about the mean (1e-2 of the unit for zero), so that it is drawn in one colour.
    """
    if not np.all(np.isfinite(values)):
        raise ValueError("a contour field has values that are not finite")
    low, high = float(np.min(values)), float(np.max(values))
    size = max(abs(low), abs(high))
    uniform = high - low <= UNIFORM * size or size == 0.0
    if uniform:
        middle, half, steps = 0.5 * (low + high), 0.5 * WIDENING * (size or 1.0), 2
        low, high = middle - half, middle + half
    else:
        step = round_step(high - low, STEPS)
        first, last = math.floor(low / step + 1e-6), math.ceil(high / step - 1e-6)
        low, high, steps = first * step, last * step, last - first
    return ColourScale(low, high, _labels(low, high, steps), uniform)


def _labels(low: float, high: float, steps: int) -> list[str]:
    """Texts of even values: neighbours differ, the largest has two digits, minus is true, and zero has no sign."""
    size = max(abs(low), abs(high))
    power = math.floor(math.log10(size))
    decimals = max(-math.floor(math.log10((high - low) / steps * (1.0 + 1e-9))), 1 - power)
    form = f".{max(decimals, 0)}f" if 1e-3 <= size < 1e6 else f".{decimals + power}e"
    texts = (format(value, form) for value in np.linspace(low, high, steps + 1))
    return [text.replace("-", "−", 1) if float(text) else text.lstrip("-") for text in texts]


def range_note(field: ContourField, scale: ColourScale) -> str:
    """The line under the title: smallest and largest value, or that the field as good as does not vary."""
    low, high = float(np.min(field.values)), float(np.max(field.values))
    if scale.uniform:
        spread = (high - low) / (max(abs(low), abs(high)) or 1.0)
        at = "node" if field.where == "nodal" else "element"
        middle = f"{0.5 * (low + high):.5g}".replace("-", "−", 1)
        widened = f"the colour range is widened to {100.0 * WIDENING:g} %"
        return f"uniform to {spread:.0e}: {middle} {field.unit} at every {at}; {widened}"
    ends = (end if abs(end) > 1e-5 * (high - low) else 0.0 for end in (low, high))
    least, most = (f"{end:.4g}".replace("-", "−", 1) for end in ends)
    return f"{field.where} values from {least} to {most} {field.unit}"


def value_at(points: Floats, values: Floats, place: ArrayLike) -> float:
    """A nodal field at a point: the mean of the nodes nearest to it, by the inverse of their distance."""
    far = np.hypot(*(points - np.asarray(place, float)).T)
    near = np.argsort(far)[:4]
    weights = 1.0 / np.maximum(far[near], 1e-6 * (far.max() or 1.0))
    return float(np.average(values[near], weights=weights))


def choose_window() -> None:
    """Without a display, has VTK open an EGL window at once; raises where there is no EGL library."""
    if sys.platform != "linux" or os.environ.get("DISPLAY"):
        return
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        why = "pictures need a display or the library libEGL.so.1 (Debian and Ubuntu: package libegl1)"
        raise RuntimeError(why) from None
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    os.environ.setdefault("ALLOW_PLOTTING", "true")  # PyVista would look for an X server


class Sheet:
    """An off-screen plotter of the plate at some instants (points (n, 2)): what is kept stays, a field and what is
    drawn after it go with the next field."""

    def __init__(self, points: Floats) -> None:
        choose_window()
        import matplotlib as mpl
        import pyvista

        self.view = view_of_plate(points)
        self.ends = points.min(axis=0), points.max(axis=0)
        # VTK's own fonts have no Greek letters and no arrows
        self.fonts = Path(mpl.get_data_path()) / "fonts" / "ttf"
        self.plotter = pyvista.Plotter(
            off_screen=True, window_size=list(SIZE), lighting="none", theme=pyvista.themes.DocumentTheme()
        )
        self.plotter.enable_anti_aliasing("msaa", multi_samples=4)
        camera, middle = self.plotter.camera, (0.5 * SIZE[0], 0.5 * SIZE[1])
        camera.focal_point, camera.position, camera.up = (*middle, 0.0), (*middle, 10.0), (0.0, 1.0, 0.0)
        camera.parallel_projection, camera.parallel_scale = True, middle[1]
        camera.clipping_range = (1.0, 20.0)
        self.passing: list[Any] = []

    def close(self) -> None:
        """Give the window back."""
        self.plotter.close()

    def keep(self) -> None:
        """Let what is drawn so far stay."""
        self.passing.clear()

    def image(self) -> Any:
        """The picture as it is now, an image of Pillow."""
        from PIL import Image

        self.plotter.render()
        return Image.fromarray(np.asarray(self.plotter.screenshot(return_img=True)))

    def draw_wall(self, wall: Mesh | None, unit: str) -> None:
        """Draw the wall, or its line, with a ruler along it and one beside the plate."""
        import pyvista

        (left, right), caption = (0.0, SIZE[0]), "wall line, Y = 0"
        if wall is not None:
            places, caption = self.view.pixel(wall[0]), "rigid wall, Y ≤ 0"
            self._surface((places, wall[1]), -2.0, color=WALL, show_edges=True, edge_color=WALL_EDGE)
            left, right = max(left, places[:, 0].min()), min(right, places[:, 0].max())
        (origin_x, zero), length = self.view
        (beside, _), (_, top) = self.view.pixel(self.ends)
        lines = [[(left, zero), (right, zero)]]
        low, high = (length * (end - origin_x) for end in (left + 30.0, right - 30.0))
        for x in round_between(low, high, 12):
            column = origin_x + x / length
            lines.append([(column, zero), (column, zero - 8.0)])
            self.write(f"{x:g}".replace("-", "−"), (column, zero - 30.0), 18, "center")
        for y in round_between(0.0, self.ends[1][1], 5)[1:]:
            lines.append([(beside - 14.0, zero + y / length), (beside - 6.0, zero + y / length)])
            self.write(f"{y:g}", (beside - 20.0, zero + y / length - 7.0), 18, "right")
        ends = np.array(lines).reshape(-1, 2)
        lifted = np.column_stack([ends, np.ones(len(ends))])
        self._add(pyvista.line_segments_from_points(lifted), color=INK, line_width=2)
        self.write(f"Y [{unit}]", (24.0, top + 20.0), 18)
        self.write(caption, (24, 24), 20)
        self.write(f"X [{unit}], driving direction →", (-24, 24), 20)

    def draw_field(self, plate: Mesh, field: ContourField, scale: ColourScale) -> None:
        """Draw nodal values in bands, or a value an element, with mesh lines, title and scale. ValueError for another
        number of values."""
        while self.passing:
            self.plotter.remove_actor(self.passing.pop(), reset_camera=False, render=False)
        (points, cells), count = plate, len(field.values)
        preference, expected = ("point", len(points)) if field.where == "nodal" else ("cell", len(cells))
        if count != expected:
            raise ValueError(f"{count} values for {expected} {preference}s")
        style = {"cmap": "viridis", "n_colors": scale.bands, "clim": (scale.low, scale.high)}
        style |= {"interpolate_before_map": True, "show_scalar_bar": False}
        edges = {"show_edges": True, "edge_color": "black", "edge_opacity": 0.35, "line_width": 1}
        shown = {"scalars": field.values, "preference": preference, **style, **edges}
        self._surface((self.view.pixel(points), cells), 0.0, **shown)
        left, right, bottom, top = BAR
        places = np.linspace(left, right, scale.bands + 1)
        strip = np.column_stack([np.repeat(places, 2), np.tile([bottom, top], scale.bands + 1)])
        quads = 2 * np.arange(scale.bands)[:, None] + [0, 2, 3, 1]
        middles = np.linspace(scale.low, scale.high, 2 * scale.bands + 1)[1::2]
        self._surface((strip, quads), 0.0, scalars=middles, preference="cell", **style)
        for k, place in enumerate(np.linspace(left, right, len(scale.labels))):
            self.write(scale.labels[k], (place, top + 7), 21, "center")
        self.write(f"{field.title} [{field.unit}]", (24, -46), 28, bold=True)
        self.write(range_note(field, scale), (24, -78), 18)

    def draw_dot(self, place: ArrayLike) -> tuple[float, float]:
        """Draw a dot at a point; returns the pixel where a text beside it starts."""
        x, y = self.view.pixel(place)
        angles = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
        circle, disc = np.column_stack([np.cos(angles), np.sin(angles)]), np.arange(32)[None, :]
        self._surface(((x, y) + 8.0 * circle, disc), 2.0, color=INK)
        self._surface(((x, y) + 5.0 * circle, disc), 3.0, color="white")
        return x + 14, y + 10

    def write(
        self,
        text: str,
        pixel: tuple[float, float],
        size: int,
        justify: str = "left",
        *,
        bold: bool = False,
        ground: float = 0.0,
    ) -> None:
        """Write a text of this size [pixels] that starts, ends ("right") or is centred at a pixel.

        Negative pixels are counted from the right, where the text then ends, and from the top; ground: opacity of the
        white behind it.
        """
        import pyvista

        x, y = pixel
        words = pyvista.Text(text, position=(x % SIZE[0], y % SIZE[1]))
        words.prop.color, words.prop.font_size = INK, size
        words.prop.set_font_file(str(self.fonts / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")))
        words.prop.justification_horizontal = "right" if x < 0 else justify
        words.prop.background_color, words.prop.background_opacity = "white", ground
        self.plotter.add_actor(words, reset_camera=False, render=False, pickable=False)
        self.passing.append(words)

    def _surface(self, mesh: Mesh, height: float, **style: Any) -> None:
        import pyvista

        points = np.column_stack([mesh[0], np.full(len(mesh[0]), height)])
        self._add(pyvista.PolyData.from_regular_faces(points, mesh[1]), **style)

    def _add(self, data: Any, **style: Any) -> None:
        given = {"lighting": False, "reset_camera": False, "render": False, "pickable": False, **style}
        self.passing.append(self.plotter.add_mesh(data, **given))


def round_between(low: float, high: float, most: int) -> list[float]:
    """About `most` round numbers, multiples of 1, 2 or 5 times a power of ten, between low and high."""
    return round_ticks(low, high, most) if low < high else []
