"""Off-screen drawing of the plate and its wall above a ruler.

PyVista draws surfaces and lines, without an X server, in a world whose unit is the pixel; Pillow adds the texts.
There is no lighting, so a pixel inside an element has exactly the colour of its band on the scale.
"""

from __future__ import annotations

import ctypes
import math
import os
import sys
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.report.prose import printed_numbers
from postprocess.svg.marks import SUBSCRIPT
from postprocess.svg.scales import round_step, round_ticks, tick_texts

if TYPE_CHECKING:
    import pyvista
    from PIL import Image, ImageFont

SIZE = (1600, 700)
"""Size of a picture; letters, lines and margins scale with it [pixels]."""

SIDE, TOP, BOTTOM = 70, 190, 120
"""Margins for the rulers, for title and scale, and for the wall [pixels]."""

BAR = (0.12, 0.88, 160, 137)
"""Ends of the bar of colours, over the width, and its lower and upper edge from the top [pixels]."""

TITLE, TEXT, NOTE = 34, 26, 23
"""Sizes of letters; 26 pixels are 7 points in a print 16 cm wide [pixels]."""

INK, WALL, HATCH = "#1b1f24", "#e9ebee", "#8d959e"
HATCH_STEP = 26
"""Distance of the hatching lines of the wall [pixels]."""

STEPS = 7
"""Largest number of steps between labels of the scale."""

UNIFORM, WIDENING = 1e-4, 1e-2
"""Variation over the size of a field up to which it is uniform, and the range shown for it."""

Floats = NDArray[np.float64]
Mesh = tuple[Floats, NDArray[np.integer]]
"""Points, shape (n, 2), and elements, shape (e, k)."""

Size = tuple[int, int]
"""Width and height of a picture [pixels]."""


class View(NamedTuple):
    """Transformation from places to pixels.

    origin: pixel of X = Y = 0, from the lower left corner; length: of a pixel.
    """

    origin: tuple[float, float]
    length: float

    def pixel(self, places: ArrayLike) -> Floats:
        """Return the pixels of places, shape (..., 2)."""
        return np.asarray(self.origin) + np.asarray(places, float) / self.length


def proportion(size: Size) -> float:
    """Return the scale of letters, lines and margins for this size."""
    return min(size[0] / SIZE[0], size[1] / SIZE[1])


def view_of_plate(points: Floats, size: Size = SIZE) -> View:
    """Return the view that fits plate and wall line into the picture.

    points: shape (n, 2).
    """
    low, high = points.min(axis=0), points.max(axis=0)
    low[1] = min(low[1], 0.0)
    margins = proportion(size) * np.array([[SIDE, BOTTOM], [SIDE, TOP]])
    room = np.array(size) - margins.sum(axis=0)
    length = float(((high - low) / room).max())
    origin = margins[0] + 0.5 * room - 0.5 * (low + high) / length
    return View((float(origin[0]), float(origin[1])), length)


def round_between(low: float, high: float, most: int) -> list[float]:
    """Return up to about `most` round numbers.

    They are multiples of 1, 2 or 5 times a power of ten.
    """
    return round_ticks(low, high, most) if low < high else []


@dataclass(frozen=True)
class ColourScale:
    """Range of colours with labels, low to high.

    uniform: whether the field is almost constant.
    """

    low: float
    high: float
    labels: list[str]
    uniform: bool

    @property
    def bands(self) -> int:
        """Number of colours, two between labels.

        A uniform field has five.
        """
        return 5 if self.uniform else 2 * (len(self.labels) - 1)


def colour_scale(values: Floats) -> ColourScale:
    """Return the scale for values of any shape, with round labels.

    The range of a field that varies by less than 1e-4 of its size is widened to 1e-2 of its size about the mean (1e-2
    of the unit for zero), so that it has one colour and tiny variations are not exaggerated.
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
    """Return the texts of even values.

    Neighbours differ, the largest has two digits, the minus sign is a true one, and zero has no sign.
    """
    size = max(abs(low), abs(high))
    power = math.floor(math.log10(size))
    decimals = max(-math.floor(math.log10((high - low) / steps * (1.0 + 1e-9))), 1 - power)
    form = f".{max(decimals, 0)}f" if 1e-3 <= size < 1e6 else f".{decimals + power}e"
    texts = (format(value, form) for value in np.linspace(low, high, steps + 1))
    return [text.replace("-", "−", 1) if float(text) else text.lstrip("-") for text in texts]


def choose_window() -> None:
    """Select EGL windows for VTK without a display.

    Raises RuntimeError without an EGL library.
    """
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
def load_pyvista() -> ModuleType:
    """Import PyVista.

    Its import of pyplot, which takes 0.1 s, is deferred to the first use.
    """
    name = "matplotlib.pyplot"
    if name in sys.modules:
        return import_module("pyvista")
    later = ModuleType(name)

    def attribute(key: str) -> object:
        if sys.modules.get(name) is later:  # hooks of notebooks ask during the import
            del sys.modules[name]
        return getattr(import_module(name), key)

    later.__getattr__ = attribute  # type: ignore[method-assign]
    sys.modules[name] = later
    try:
        import_module("pyvista.plotting")
    finally:
        if sys.modules.get(name) is later:
            del sys.modules[name]
    return sys.modules["pyvista"]


class Sheet:
    """Off-screen plotter of the plate at several instants, points (n, 2).

    What `keep` fixes remains; a field, and what is drawn after it, is replaced by the next field.
    """

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
        self.passing: list[object] = []
        self.kept_words: list[Lettering] = []
        self.words: list[Lettering] = []

    def close(self) -> None:
        """Close the window."""
        self.plotter.close()

    def keep(self) -> None:
        """Fix what is drawn so far."""
        self.passing.clear()
        self.kept_words += self.words
        self.words.clear()

    def image(self) -> Image.Image:
        """Return the current picture as a Pillow image."""
        from PIL import Image

        self.plotter.render()
        image = Image.fromarray(np.asarray(self.plotter.screenshot(return_img=True)))
        for words in (*self.kept_words, *self.words):
            write_words(image, words)
        return image

    def draw_wall(self, wall: Mesh | None, unit: str) -> None:
        """Draw the hatched wall or line, with rulers.

        One ruler is along the wall, one beside the plate.
        """
        dot, (origin_x, zero), length = self.dot, *self.view
        (start, end), caption = (0.0, float(self.size[0])), "wall line, Y = 0"
        if wall is not None:
            places, caption = self.view.pixel(wall[0]), "rigid wall, Y ≤ 0"
            start, end = max(start, places[:, 0].min()), min(end, places[:, 0].max())
            self._hatch(start, end, max(0.0, places[:, 1].min()), zero)
        (beside, _), (_, top) = self.view.pixel(self.ends)
        lines = [[(start, zero), (end, zero)]]
        low, high = (length * (end - origin_x) for end in (start + 30.0 * dot, end - 30.0 * dot))
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

    def _hatch(self, start: float, end: float, bottom: float, top: float) -> None:
        """Fill a box of pixels with lines at 45 degrees.

        It is empty outside the picture.
        """
        if start >= end or bottom >= top:
            return
        box = np.array([(start, bottom), (end, bottom), (end, top), (start, top)])
        self._surface((box, np.arange(4)[None, :]), -2.0, color=WALL)
        starts = np.arange(start - (top - bottom), end, HATCH_STEP * self.dot)
        ends = np.clip(np.stack([starts, starts + top - bottom], axis=-1), start, end)
        self._lines(np.stack([ends, bottom + ends - starts[:, None]], axis=-1), -1.0, HATCH, 1.5 * self.dot)

    def draw_values(
        self, plate: Mesh, values: Floats, where: Literal["nodal", "element"], scale: ColourScale
    ) -> None:
        """Draw nodal or element values with mesh lines and scale.

        They replace the values drawn before. ValueError for another number of values.
        """
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
        options = {"scalars": values, "preference": preference, **style, **edges}
        self._surface((self.view.pixel(points), cells), 0.0, **options)
        (wide, high), dot = self.size, self.dot
        start, end, bottom, top = BAR[0] * wide, BAR[1] * wide, high - BAR[2] * dot, high - BAR[3] * dot
        places = np.linspace(start, end, scale.bands + 1)
        strip = np.column_stack([np.repeat(places, 2), np.tile([bottom, top], scale.bands + 1)])
        quads = 2 * np.arange(scale.bands)[:, None] + np.array([0, 2, 3, 1])
        middles = np.linspace(scale.low, scale.high, 2 * scale.bands + 1)[1::2]
        self._surface((strip, quads), 0.0, scalars=middles, preference="cell", **style)
        for k, place in enumerate(np.linspace(start, end, len(scale.labels))):
            self.write(scale.labels[k], (place, top + 10 * dot), justify="center")

    def write_title(self, title: str, note: str) -> None:
        """Write title and note at the upper left."""
        self.write_at_edge(title, (24, -50), TITLE, bold=True)
        self.write_at_edge(note, (24, -88), NOTE)

    def draw_dot(self, place: ArrayLike) -> tuple[float, float]:
        """Draw a dot at a point.

        Returns the pixel where a text beside it starts.
        """
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
        """Write a text at a pixel of its base line.

        size: [pixels of `SIZE`]; justify: "left", "center" or "right" of the pixel; ground: opacity of the white
        behind it.
        """
        self.words.append(Lettering(text, pixel, size * self.dot, justify, bold, ground))

    def write_at_edge(
        self, text: str, away: tuple[float, float], size: int = TEXT, bold: bool = False, ground: float = 0.0
    ) -> None:
        """Write a text at a distance from two edges [pixels of `SIZE`].

        Distances are from the left and lower edge, negative ones from the right, where the text ends, and from the
        top.
        """
        x, y = (
            self.dot * part + (extent if part < 0 else 0)
            for part, extent in zip(away, self.size, strict=True)
        )
        self.write(text, (x, y), size, "right" if away[0] < 0 else "left", bold=bold, ground=ground)

    def _lines(self, ends: Floats, height: float, colour: str, width: float) -> None:
        """Draw lines between pairs of pixels, shape (n, 2, 2)."""
        flat = ends.reshape(-1, 2)
        lifted = np.column_stack([flat, np.full(len(flat), height)])
        self._add(load_pyvista().line_segments_from_points(lifted), color=colour, line_width=width)

    def _surface(self, mesh: Mesh, height: float, **style: object) -> None:
        points = np.column_stack([mesh[0], np.full(len(mesh[0]), height)])
        self._add(load_pyvista().PolyData.from_regular_faces(points, mesh[1]), **style)

    def _add(self, data: pyvista.PolyData, **style: object) -> None:
        options = {"lighting": False, "reset_camera": False, "render": False, "pickable": False, **style}
        self.passing.append(self.plotter.add_mesh(data, **options))


@cache
def font(size: int, is_bold: bool) -> ImageFont.FreeTypeFont:
    """Return DejaVu of this size from matplotlib.

    It has Greek letters and arrows.
    """
    import matplotlib as mpl
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if is_bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)


class Lettering(NamedTuple):
    """Text at a pixel of its base line.

    pixel: from the lower left corner; justify: position of the pixel; ground: opacity of the white behind it.
    """

    text: str
    pixel: tuple[float, float]
    size: float
    justify: str
    is_bold: bool
    ground: float


def typeset(text: str) -> list[tuple[str, bool]]:
    """Return the pieces of a text, and which of them are indices.

    Minus signs and powers of ten are set as in print.
    """
    parts = SUBSCRIPT.split(printed_numbers(text))
    return [(part, number % 3 == 2) for number, part in enumerate(parts) if part]


def write_words(image: Image.Image, words: Lettering) -> None:
    """Write a text into an image of Pillow."""
    from PIL import ImageDraw

    pieces = []
    for piece, is_index in typeset(words.text):
        typeface = font(round((0.72 if is_index else 1.0) * words.size), words.is_bold)
        pieces.append((piece, typeface, 0.2 * words.size * is_index, typeface.getlength(piece)))
    wide = sum(length for *_, length in pieces)
    x = words.pixel[0] - {"left": 0.0, "center": 0.5, "right": 1.0}[words.justify] * wide
    y = image.height - words.pixel[1]
    canvas = ImageDraw.Draw(image, "RGBA")
    if words.ground:
        edge = 0.2 * words.size
        box = (x - edge, y - words.size, x + wide + edge, y + 0.3 * words.size)
        canvas.rectangle(box, fill=(255, 255, 255, round(255 * words.ground)))
    for piece, typeface, lowered, length in pieces:
        canvas.text((x, y + lowered), piece, INK, typeface, anchor="ls")
        x += length
