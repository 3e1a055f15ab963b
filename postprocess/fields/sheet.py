"""A sheet: the plate and its wall above a ruler, drawn off the screen, with texts set as in tables.

PyVista draws surfaces and lines, without an X server, in a world whose unit is the pixel; Pillow writes on what it
drew. Nothing is lit, so a pixel inside an element has exactly the colour of its band on the scale.
"""

import ctypes
import math
import os
import sys
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.report.page import printed_numbers
from postprocess.svg.marks import SUBSCRIPT
from postprocess.svg.scales import round_step, round_ticks, tick_texts

SIZE = (1600, 700)
"""Pixels of a picture. In one of another size letters, lines and margins are in proportion."""

SIDE, TOP, BOTTOM = 70, 190, 120
"""Pixels around the plate: for the rulers, for title and scale, for the wall."""

BAR = (0.12, 0.88, 160, 137)
"""Ends of the bar of colours, over the width, and pixels from the top to its lower and upper edge."""

TITLE, TEXT, NOTE = 34, 26, 23
"""Letters [pixels]; in a picture 16 cm wide in print 26 pixels are 7 points."""

INK, WALL, HATCH = "#1b1f24", "#e9ebee", "#8d959e"
HATCH_STEP = 26
"""Pixels between the lines that tell the wall from the vehicle."""

STEPS = 7
"""Steps between labels of the scale, at most."""

UNIFORM, WIDENING = 1e-4, 1e-2
"""Variation, over a field's size, up to which it is drawn as uniform, and the range that it is then shown in."""

Floats = NDArray[np.float64]
Mesh = tuple[Floats, NDArray[Any]]
"""Points, shape (n, 2), and elements, shape (e, k)."""

Size = tuple[int, int]
"""Width and height of a picture [pixels]."""


class View(NamedTuple):
    """Pixel of X = Y = 0, from the lower left corner of the picture, and length of a pixel."""

    origin: tuple[float, float]
    length: float

    def pixel(self, places: ArrayLike) -> Floats:
        """Pixels of places, shape (..., 2)."""
        return np.asarray(self.origin) + np.asarray(places, float) / self.length


def proportion(size: Size) -> float:
    """Letters, lines and margins of a picture of this size over those of `SIZE`."""
    return min(size[0] / SIZE[0], size[1] / SIZE[1])


def view_of_plate(points: Floats, size: Size = SIZE) -> View:
    """The view in which the plate (points (n, 2)) and the wall line below it fill the picture."""
    low, high = points.min(axis=0), points.max(axis=0)
    low[1] = min(low[1], 0.0)
    margins = proportion(size) * np.array([[SIDE, BOTTOM], [SIDE, TOP]])
    room = np.array(size) - margins.sum(axis=0)
    length = float(((high - low) / room).max())
    origin = margins[0] + 0.5 * room - 0.5 * (low + high) / length
    return View((float(origin[0]), float(origin[1])), length)


def round_between(low: float, high: float, most: int) -> list[float]:
    """About `most` round numbers, multiples of 1, 2 or 5 times a power of ten, between low and high."""
    return round_ticks(low, high, most) if low < high else []


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


@cache
def load_pyvista() -> Any:
    """PyVista. It imports pyplot for charts of its own, which takes 0.1 s: here it gets it when it first uses it."""
    name = "matplotlib.pyplot"
    if name in sys.modules:
        return import_module("pyvista")
    later = ModuleType(name)

    def attribute(asked: str) -> Any:
        if sys.modules.get(name) is later:  # asked by the import itself, as hooks of notebooks do
            del sys.modules[name]
        return getattr(import_module(name), asked)

    later.__getattr__ = attribute  # type: ignore[method-assign]
    sys.modules[name] = later
    try:
        import_module("pyvista.plotting")
    finally:
        if sys.modules.get(name) is later:
            del sys.modules[name]
    return sys.modules["pyvista"]


@cache
def font(size: int, is_bold: bool) -> Any:
    """DejaVu, which has Greek letters and arrows, as matplotlib brings it."""
    import matplotlib as mpl
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if is_bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)


class Lettering(NamedTuple):
    """A text at a pixel from the lower left corner: where it starts or ends, or its middle, and its base line."""

    text: str
    pixel: tuple[float, float]
    size: float
    justify: str
    is_bold: bool
    ground: float


def typeset(text: str) -> list[tuple[str, bool]]:
    """Pieces of a text set as in tables, with a true minus and powers of ten, and which of them are indices."""
    parts = SUBSCRIPT.split(printed_numbers(text))
    return [(part, number % 3 == 2) for number, part in enumerate(parts) if part]


def write_words(image: Any, words: Lettering) -> None:
    """Write a text into an image of Pillow."""
    from PIL import ImageDraw

    pieces = []
    for piece, is_index in typeset(words.text):
        its = font(round((0.72 if is_index else 1.0) * words.size), words.is_bold)
        pieces.append((piece, its, 0.2 * words.size * is_index, its.getlength(piece)))
    wide = sum(length for *_, length in pieces)
    x = words.pixel[0] - {"left": 0.0, "center": 0.5, "right": 1.0}[words.justify] * wide
    y = image.height - words.pixel[1]
    canvas = ImageDraw.Draw(image, "RGBA")
    if words.ground:
        edge = 0.2 * words.size
        box = (x - edge, y - words.size, x + wide + edge, y + 0.3 * words.size)
        canvas.rectangle(box, fill=(255, 255, 255, round(255 * words.ground)))
    for piece, its, lowered, length in pieces:
        canvas.text((x, y + lowered), piece, INK, its, anchor="ls")
        x += length


class Sheet:
    """An off-screen plotter of the plate at some instants (points (n, 2)): what is kept stays, a field and what is
    drawn after it go with the next field."""

    def __init__(self, points: Floats, size: Size = SIZE) -> None:
        choose_window()
        pyvista = load_pyvista()
        self.size, self.view, self.dot = size, view_of_plate(points, size), proportion(size)
        self.ends = points.min(axis=0), points.max(axis=0)
        self.plotter = pyvista.Plotter(
            off_screen=True, window_size=list(size), lighting="none", theme=pyvista.themes.DocumentTheme()
        )
        self.plotter.enable_anti_aliasing("msaa", multi_samples=4)
        camera, middle = self.plotter.camera, (0.5 * size[0], 0.5 * size[1])
        camera.focal_point, camera.position, camera.up = (*middle, 0.0), (*middle, 10.0), (0.0, 1.0, 0.0)
        camera.parallel_projection, camera.parallel_scale = True, middle[1]
        camera.clipping_range = (1.0, 20.0)
        self.passing: list[Any] = []
        self.kept_words: list[Lettering] = []
        self.words: list[Lettering] = []

    def close(self) -> None:
        """Give the window back."""
        self.plotter.close()

    def keep(self) -> None:
        """Let what is drawn so far stay."""
        self.passing.clear()
        self.kept_words += self.words
        self.words.clear()

    def image(self) -> Any:
        """The picture as it is now, an image of Pillow."""
        from PIL import Image

        self.plotter.render()
        image = Image.fromarray(np.asarray(self.plotter.screenshot(return_img=True)))
        for words in (*self.kept_words, *self.words):
            write_words(image, words)
        return image

    def draw_wall(self, wall: Mesh | None, unit: str) -> None:
        """Draw the wall, hatched, or its line, with a ruler along it and one beside the plate."""
        dot, (origin_x, zero), length = self.dot, *self.view
        (left, right), caption = (0.0, float(self.size[0])), "wall line, Y = 0"
        if wall is not None:
            places, caption = self.view.pixel(wall[0]), "rigid wall, Y ≤ 0"
            left, right = max(left, places[:, 0].min()), min(right, places[:, 0].max())
            self._hatch(left, right, max(0.0, places[:, 1].min()), zero)
        (beside, _), (_, top) = self.view.pixel(self.ends)
        lines = [[(left, zero), (right, zero)]]
        low, high = (length * (end - origin_x) for end in (left + 30.0 * dot, right - 30.0 * dot))
        along = round_between(low, high, 12)
        for x, text in zip(along, tick_texts(along), strict=True):
            column = origin_x + x / length
            lines.append([(column, zero), (column, zero - 8.0 * dot)])
            self.write(text, (column, zero - 36.0 * dot), justify="center", ground=0.8)
        up = round_between(0.0, self.ends[1][1], 5)
        for y, text in list(zip(up, tick_texts(up), strict=True))[1:]:
            height = zero + y / length
            lines.append([(beside - 14.0 * dot, height), (beside - 6.0 * dot, height)])
            self.write(text, (beside - 20.0 * dot, height - 9.0 * dot), justify="right")
        self._lines(np.array(lines), 1.0, INK, 2.0 * dot)
        self.write(f"Y [{unit}]", (24.0 * dot, top + 20.0 * dot))
        self.write_at_edge(caption, (24, 24), ground=0.8)
        self.write_at_edge(f"X [{unit}], driving direction →", (-24, 24), ground=0.8)

    def _hatch(self, left: float, right: float, bottom: float, top: float) -> None:
        """Fill a box of pixels with lines at 45 degrees on a pale ground; none where it is out of sight."""
        if left >= right or bottom >= top:
            return
        box = np.array([(left, bottom), (right, bottom), (right, top), (left, top)])
        self._surface((box, np.arange(4)[None, :]), -2.0, color=WALL)
        starts = np.arange(left - (top - bottom), right, HATCH_STEP * self.dot)
        ends = np.clip(np.stack([starts, starts + top - bottom], axis=-1), left, right)
        self._lines(np.stack([ends, bottom + ends - starts[:, None]], axis=-1), -1.0, HATCH, 1.5 * self.dot)

    def draw_values(
        self, plate: Mesh, values: Floats, where: Literal["nodal", "element"], scale: ColourScale
    ) -> None:
        """Draw nodal values in bands, or a value an element, with mesh lines and scale, in the place of those drawn
        before. ValueError for another number of values."""
        while self.passing:
            self.plotter.remove_actor(self.passing.pop(), reset_camera=False, render=False)
        self.words.clear()
        (points, cells), count = plate, len(values)
        preference, expected = ("point", len(points)) if where == "nodal" else ("cell", len(cells))
        if count != expected:
            raise ValueError(f"{count} values for {expected} {preference}s")
        style = {"cmap": "viridis", "n_colors": scale.bands, "clim": (scale.low, scale.high)}
        style |= {"interpolate_before_map": True, "show_scalar_bar": False}
        edges = {"show_edges": True, "edge_color": "black", "edge_opacity": 0.35, "line_width": self.dot}
        shown = {"scalars": values, "preference": preference, **style, **edges}
        self._surface((self.view.pixel(points), cells), 0.0, **shown)
        (wide, high), dot = self.size, self.dot
        left, right, bottom, top = BAR[0] * wide, BAR[1] * wide, high - BAR[2] * dot, high - BAR[3] * dot
        places = np.linspace(left, right, scale.bands + 1)
        strip = np.column_stack([np.repeat(places, 2), np.tile([bottom, top], scale.bands + 1)])
        quads = 2 * np.arange(scale.bands)[:, None] + [0, 2, 3, 1]
        middles = np.linspace(scale.low, scale.high, 2 * scale.bands + 1)[1::2]
        self._surface((strip, quads), 0.0, scalars=middles, preference="cell", **style)
        for k, place in enumerate(np.linspace(left, right, len(scale.labels))):
            self.write(scale.labels[k], (place, top + 10 * dot), justify="center")

    def write_title(self, title: str, note: str) -> None:
        """Write what is shown into the upper left corner."""
        self.write_at_edge(title, (24, -50), TITLE, bold=True)
        self.write_at_edge(note, (24, -88), NOTE)

    def draw_dot(self, place: ArrayLike) -> tuple[float, float]:
        """Draw a dot at a point; returns the pixel where a text beside it starts."""
        x, y = self.view.pixel(place)
        angles = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
        circle, disc = np.column_stack([np.cos(angles), np.sin(angles)]), np.arange(32)[None, :]
        self._surface(((x, y) + 8.0 * self.dot * circle, disc), 2.0, color=INK)
        self._surface(((x, y) + 5.0 * self.dot * circle, disc), 3.0, color="white")
        return x + 18 * self.dot, y + 14 * self.dot

    def write(
        self,
        text: str,
        pixel: tuple[float, float],
        size: int = TEXT,
        justify: str = "left",
        *,
        bold: bool = False,
        ground: float = 0.0,
    ) -> None:
        """Write a text of this size [pixels of `SIZE`] that starts, ends ("right") or is centred at a pixel of its base
        line; ground: opacity of the white behind it."""
        self.words.append(Lettering(text, pixel, size * self.dot, justify, bold, ground))

    def write_at_edge(self, text: str, away: tuple[float, float], size: int = TEXT, **more: Any) -> None:
        """Write a text so many pixels of `SIZE` away from the left and lower edge; negative ones are counted from the
        right, where the text then ends, and from the top."""
        x, y = (
            self.dot * part + (extent if part < 0 else 0)
            for part, extent in zip(away, self.size, strict=True)
        )
        self.write(text, (x, y), size, "right" if away[0] < 0 else "left", **more)

    def _lines(self, ends: Floats, height: float, colour: str, width: float) -> None:
        """Draw lines between pairs of pixels, shape (n, 2, 2)."""
        flat = ends.reshape(-1, 2)
        lifted = np.column_stack([flat, np.full(len(flat), height)])
        self._add(load_pyvista().line_segments_from_points(lifted), color=colour, line_width=width)

    def _surface(self, mesh: Mesh, height: float, **style: Any) -> None:
        points = np.column_stack([mesh[0], np.full(len(mesh[0]), height)])
        self._add(load_pyvista().PolyData.from_regular_faces(points, mesh[1]), **style)

    def _add(self, data: Any, **style: Any) -> None:
        given = {"lighting": False, "reset_camera": False, "render": False, "pickable": False, **style}
        self.passing.append(self.plotter.add_mesh(data, **given))
