"""Drawing of a field on the plate above its wall.

The plate has the flat colours of the bands of its scale, without shading. Letters, lines and margins are in proportion
to the size of the picture: a point is a pixel of a picture of `SIZE`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from postprocess.figures import histories
from postprocess.report.prose import printed_numbers
from postprocess.svg.scales import round_step, round_ticks, tick_texts, viridis
from postprocess.units import SUBSCRIPT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from PIL import Image

SIZE = (1600, 700)
"""Size of a picture [pixels]."""

SIDE, TOP, BOTTOM = 70, 190, 120
"""Margins for the rulers, for title and scale, and for the wall [points]."""

BAR, THICK = (0.12, 0.88, 160), 23
"""Ends of the bar of colours, over the width, its lower edge from the top, and its thickness [points]."""

TITLE, TEXT, NOTE = 34, 26, 23
"""Sizes of letters; 26 are 7 points in a print 16 cm wide [points]."""

INK, WALL, HATCH = "#1b1f24", "#e9ebee", "#8d959e"
EDGE = (0.0, 0.0, 0.0, 0.2)
"""Colour of the mesh lines; those between two elements are drawn twice."""

HATCH_STEP = 26
"""Distance of the hatching lines of the wall [points]."""

STEPS = 7
"""Largest number of steps between labels of the scale."""

UNIFORM, WIDENING = 1e-4, 1e-2
"""Variation over the size of a field up to which it is uniform, and the range shown for it."""

Floats = NDArray[np.float64]
Mesh = tuple[Floats, NDArray[np.integer]]
"""Points, shape (n, 2), and elements, shape (e, 3 or 4)."""

Size = tuple[int, int]
"""Width and height of a picture [pixels]."""


@dataclass(frozen=True)
class ContourField:
    """Field to be drawn.

    name: in file names ("v_gx"); title, unit; values in that unit, "nodal" or "element"; of_centre: value of the
    centre of mass, by default that of the field there.
    """

    name: str
    title: str
    unit: str
    values: Floats
    where: Literal["nodal", "element"] = "nodal"
    of_centre: float | None = None


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


def proportion(size: Size) -> float:
    """Return the pixels of a point in a picture of this size."""
    return min(size[0] / SIZE[0], size[1] / SIZE[1])


def view_of_plate(points: Floats, size: Size = SIZE) -> PixelMap:
    """Return the view that fits plate and wall line into the picture.

    points: shape (n, 2).
    """
    low, high = points.min(axis=0), points.max(axis=0)
    low[1] = min(low[1], 0.0)
    margins = proportion(size) * np.array([[SIDE, BOTTOM], [SIDE, TOP]])
    room = np.array(size) - margins.sum(axis=0)
    length = float(((high - low) / room).max())
    origin = margins[0] + 0.5 * room - 0.5 * (low + high) / length
    return PixelMap((float(origin[0]), float(origin[1])), length)


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

    @property
    def edges(self) -> Floats:
        """Values between the colours, shape (bands + 1,)."""
        return np.linspace(self.low, self.high, self.bands + 1)


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


class Sheet(NamedTuple):
    """Plate at all drawn instants, wall and size of its pictures.

    plates: points of the plate at all instants, shape (n, 2); wall: points of its mesh, None for the line Y = 0; unit:
    of all lengths; size [pixels].
    """

    plates: Floats
    wall: Floats | None
    unit: str
    size: Size = SIZE


def draw_field(
    sheet: Sheet,
    plate: Mesh,
    field: ContourField,
    scale: ColourScale,
    note: str,
    marks: Mapping[tuple[float, ...], str] | None = None,
) -> Figure:
    """Draw a field on the plate, with its title, range and scale.

    note: at the upper right; marks: texts beside points. ValueError for another number of values.
    """
    from matplotlib.figure import Figure

    dot, view = proportion(sheet.size), view_of_plate(sheet.plates, sheet.size)
    size = (np.array(sheet.size) + 0.01) / (72.0 * dot)  # whole pixels in spite of rounding
    with histories.style():
        figure = Figure((float(size[0]), float(size[1])), dpi=72.0 * dot)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        across, up = view.place([(0.0, 0.0), sheet.size]).T
        axes.set(xlim=across, ylim=up, axisbelow=False)
        axes.grid(visible=False)
        _draw_wall(axes, sheet, dot * view.length)
        _draw_values(axes, plate, field, scale)
        _draw_scale(figure, scale, dot / sheet.size[1])
        for place, text in (marks or {}).items():
            axes.plot(*place, "o", ms=13, mfc="white", mec=INK, mew=3, zorder=5)
            _write(axes, text, (place[0], place[1]), (18, 14), xycoords="data", ground=0.8)
        _write(axes, f"{field.title} [{field.unit}]", (0, 1), (24, -50), TITLE, weight="bold")
        _write(axes, range_note(field, scale), (0, 1), (24, -88), NOTE)
        _write(axes, note, (1, 1), (-24, -50), ha="right")
    return figure


def _draw_wall(axes: Axes, sheet: Sheet, point: float) -> None:
    """Draw the hatched wall or line, with rulers.

    One ruler is along the wall, one beside the plate. point: its length in the drawing.
    """
    from matplotlib.collections import LineCollection

    (start, end), bottom, caption = axes.get_xlim(), axes.get_ylim()[0], "wall line, Y = 0"
    (beside, _), (_, top) = sheet.plates.min(axis=0), sheet.plates.max(axis=0)
    if sheet.wall is not None:
        low, high, caption = sheet.wall.min(axis=0), sheet.wall.max(axis=0), "rigid wall, Y ≤ 0"
        start, end, bottom = max(start, low[0]), min(end, high[0]), max(bottom, low[1])
        (face,) = axes.fill((start, end, end, start), (bottom, bottom, 0.0, 0.0), WALL)
        face.set_visible(start < end)
        feet = np.arange(start + bottom, end, HATCH_STEP * point)
        lines = [[(foot, bottom), (foot - bottom, 0.0)] for foot in feet]
        axes.add_collection(LineCollection(lines, colors=HATCH, linewidths=1.5, clip_path=face))
    axes.spines[["left", "top", "right"]].set_visible(False)
    axes.spines["left"].set_position(("data", beside - 6.0 * point))
    axes.spines["bottom"].set(position=("data", 0.0), bounds=(start, end), color=INK, linewidth=2.0)
    along, up = _round_between(start + 30 * point, end - 30 * point, 12), _round_between(0.0, top, 5)[1:]
    axes.set_xticks(along, tick_texts(along), bbox=_ground(0.8, 1.0))
    axes.set_yticks(up, tick_texts(up))
    axes.tick_params(labelsize=TEXT, length=8, width=2, pad=7, color=INK, labelcolor=INK)
    _write(axes, f"Y [{sheet.unit}]", (axes.get_xlim()[0], top), (24, 20), xycoords="data")
    _write(axes, caption, (0, 0), (24, 24), ground=0.8)
    _write(axes, f"X [{sheet.unit}], driving direction →", (1, 0), (-24, 24), ground=0.8, ha="right")


def _round_between(low: float, high: float, most: int) -> list[float]:
    """Return up to about `most` round numbers, none in an empty range."""
    return round_ticks(low, high, most) if low < high else []


def _draw_values(axes: Axes, plate: Mesh, field: ContourField, scale: ColourScale) -> None:
    """Draw nodal or element values with mesh lines."""
    from matplotlib.collections import PolyCollection
    from matplotlib.tri import Triangulation

    (points, cells), colours = plate, viridis(scale.bands)
    filled: str | Floats = "none"
    expected = len(points if field.where == "nodal" else cells)
    if len(field.values) != expected:
        raise ValueError(f"{len(field.values)} values for {expected} {field.where} values of the plate")
    if field.where == "nodal":
        triangles = np.concatenate([cells[:, [0, k - 1, k]] for k in range(2, cells.shape[1])])
        net = Triangulation(points[:, 0], points[:, 1], triangles)
        axes.tricontourf(net, field.values, levels=scale.edges, colors=colours)
    else:
        filled = colours[np.clip(np.searchsorted(scale.edges, field.values) - 1, 0, scale.bands - 1)]
    lines = PolyCollection(list(points[cells]), facecolors=filled, edgecolors=EDGE, linewidths=1.0)
    axes.add_collection(lines, autolim=False)


def _draw_scale(figure: Figure, scale: ColourScale, point: float) -> None:
    """Draw the bar of colours with its labels.

    point: its fraction of the height.
    """
    start, end, down = BAR
    bar = figure.add_axes((start, 1.0 - down * point, end - start, THICK * point), frameon=False)
    bar.imshow(viridis(scale.bands)[None], aspect="auto", extent=(0, 1, 0, 1), interpolation="nearest")
    bar.set_xticks(np.linspace(0.0, 1.0, len(scale.labels)), scale.labels)
    bar.set_yticks([])
    bar.grid(visible=False)
    bar.tick_params(top=True, labeltop=True, bottom=False, labelbottom=False, length=0, labelsize=TEXT, pad=8)


def _write(
    axes: Axes,
    text: str,
    place: tuple[float, float],
    shift: Size,
    size: int = TEXT,
    ground: float = 0.0,
    **style: Any,
) -> None:
    """Write a text at a distance from a place or corner [points].

    ground: opacity of the white behind it.
    """
    where: dict[str, Any] = {
        "xycoords": "figure fraction",
        "textcoords": "offset points",
        "color": INK,
        "zorder": 6,
        **style,
    }
    axes.annotate(typeset(text), place, shift, fontsize=size, bbox=_ground(ground, 5.0), **where)


def _ground(opacity: float, margin: float) -> dict[str, Any]:
    """Return the style of the white behind a text."""
    return {"facecolor": "white", "alpha": opacity, "linewidth": 0.0, "pad": margin}


def typeset(text: str) -> str:
    """Return a text with indices and numbers as in print."""
    return SUBSCRIPT.sub(r"\1$_\\mathregular{\2}$", printed_numbers(text).replace("$", r"\$"))


def range_note(field: ContourField, scale: ColourScale) -> str:
    """Return the line below the title with the range of a field.

    It states whether the field is almost uniform.
    """
    low, high = float(np.min(field.values)), float(np.max(field.values))
    if scale.uniform:
        spread = (high - low) / (max(abs(low), abs(high)) or 1.0)
        at = "node" if field.where == "nodal" else "element"
        middle = f"{0.5 * (low + high):.5g}"
        widened = f"the colour range is widened to {100.0 * WIDENING:g} %"
        return f"uniform to {spread:.0e}: {middle} {field.unit} at every {at}; {widened}"
    ends = (end if abs(end) > 1e-5 * (high - low) else 0.0 for end in (low, high))
    least, most = (f"{end:.4g}" for end in ends)
    return f"{field.where} values from {least} to {most} {field.unit}"


def image_of(figure: Figure) -> Image.Image:
    """Return a figure as an image of Pillow."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas = FigureCanvasAgg(figure)
    with histories.style():
        canvas.draw()
    return Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
