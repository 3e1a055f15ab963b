"""Animated GIF of a whole impact.

Above the vehicle beside the wall in one or more views, below the force.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from postprocess.figures import histories
from postprocess.figures.positions import EDGE
from postprocess.svg.motion import SLOWER
from postprocess.svg.scales import Floats, even_rows
from postprocess.units import SI, Units

if TYPE_CHECKING:
    from PIL import Image

BODY, WALL = "#14467c", "#8a929b"

SIZE, DPI = (720, 378), 90
"""Size of the animation and its resolution; letters and lines scale with the size [pixels]."""

MAX_FRAMES = 120
"""Largest number of frames. A frame of a GIF lasts whole hundredths of a second, two at least."""

COLOURS = 64
"""Colours of all frames, chosen from the last."""

LEFT, RIGHT, BETWEEN = 0.08, 0.97, 0.09
"""Ends of the views and the gap between them, over the width."""

TOP, LABEL = 0.92, 0.06
"""Upper end of the views, and room of the label of a first axis, over the height."""


class View(NamedTuple):
    """Closed polygons in motion beside the wall.

    outlines: of shape (n, points, 2) each [m]; face: line of the wall's face upwards, points (k, 2) [m], behind which
    it extends to the edge of the view, for a single point downwards; names: of both axes; is_mirrored: True if the
    first axis increases to the left; fill: opacity of the polygons.
    """

    outlines: tuple[Floats, ...]
    face: Floats
    names: tuple[str, str]
    is_mirrored: bool = False
    fill: float = 0.35


def from_above(outlines: Floats) -> View:
    """Return the view of an outline beside the wall Y <= 0.

    outlines: shape (n, points, 2) [m].
    """
    return View((outlines,), np.zeros((1, 2)), ("", "Y"))


def write_animation(
    path: Path,
    t: Floats,
    views: Sequence[View],
    force: Floats,
    units: Units = SI,
    size: tuple[int, int] = SIZE,
) -> Path:
    """Write the GIF of an impact and return its path.

    It is about `SLOWER` times slower than the impact. t: even instants [s], shape (n,), n >= 2; views: side by side;
    force on the wall [N], shape (n,); units: of the axes; size: [pixels].
    """
    chosen = even_rows(t, MAX_FRAMES)
    pause = 10 * max(2, round(100.0 * SLOWER * (t[-1] - t[0]) / (chosen.size - 1)))
    with histories.style():
        first, *further = _frames(chosen, t, views, force, units, size)
    first.save(path, save_all=True, append_images=further, duration=pause, loop=0)
    return path


def _frames(
    chosen: NDArray[np.intp],
    t: Floats,
    views: Sequence[View],
    force: Floats,
    units: Units,
    size: tuple[int, int],
) -> list[Image.Image]:
    """Return Pillow images of the chosen instants.

    All but the bodies, the force up to now and the time is drawn once.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    load, load_unit = units.of("N")
    force = load * force
    dpi = DPI * min(size[0] / SIZE[0], size[1] / SIZE[1])
    figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
    canvas = FigureCanvasAgg(figure)
    bodies = _draw_views(figure, views, units)
    lower = figure.add_axes((LEFT, 0.12, RIGHT - LEFT, 0.26))
    lower.plot(t, force, color=WALL, linewidth=0.8)
    lower.set(xlim=(t[0], t[-1]), xlabel="t [s]")
    lower.set_ylabel(f"force [{load_unit}]")
    (so_far,) = lower.plot([], [], color=BODY, linewidth=1.4, animated=True)
    first: Any = figure.axes[0]
    clock = first.set_title("", fontsize=9, loc="left", animated=True)
    canvas.draw()
    background, images = canvas.copy_from_bbox(figure.bbox), []
    for number in chosen:
        canvas.restore_region(background)
        for body, outline in bodies:
            body.set_xy(outline[number])
            body.axes.draw_artist(body)
        so_far.set_data(t[: number + 1], force[: number + 1])
        clock.set_text(f"{t[number]:.3f} s")
        lower.draw_artist(so_far)
        first.draw_artist(clock)
        images.append(Image.fromarray(np.array(canvas.buffer_rgba())).convert("RGB"))
    palette = images[-1].quantize(COLOURS)
    return [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]


def _draw_views(figure: Any, views: Sequence[View], units: Units) -> list[tuple[Any, Floats]]:
    """Draw walls and axes of views side by side.

    Returns polygons with their outlines.
    """
    from matplotlib.colors import to_rgba
    from matplotlib.patches import Polygon

    length, unit = units.of("m")
    bodies, spans = list[tuple[Any, Floats]](), [frame_of(view) for view in views]
    shares = np.array([max(high[0] - low[0], 1e-9) for low, high in spans])
    wide = (RIGHT - LEFT - BETWEEN * (len(views) - 1)) * shares / shares.sum()
    for number, (view, (low, high)) in enumerate(zip(views, length * np.array(spans), strict=True)):
        start = LEFT + float(wide[:number].sum()) + BETWEEN * number
        bottom = 0.46 + LABEL * bool(view.names[0])
        axes = figure.add_axes((start, bottom, float(wide[number]), TOP - bottom))
        across = (high[0], low[0]) if view.is_mirrored else (low[0], high[0])
        axes.set(xlim=across, ylim=(low[1], high[1]), aspect="equal")
        axes.set_ylabel(f"{view.names[1]} [{unit}]")
        if view.names[0]:
            axes.set_xlabel(f"{view.names[0]} [{unit}]")
        axes.grid(visible=False)
        axes.add_patch(
            Polygon(wall_outline(length * view.face, low, high), color=WALL, alpha=0.6, linewidth=0)
        )
        for outline in view.outlines:
            faint, edge = to_rgba(BODY, view.fill), to_rgba(BODY, 0.7)
            corners = length * outline[0]
            body = Polygon(corners, animated=True, facecolor=faint, edgecolor=edge, linewidth=0.7)
            axes.add_patch(body)
            bodies.append((body, length * outline))
    return bodies


def frame_of(view: View) -> tuple[Floats, Floats]:
    """Return the lower and upper corners [m]."""
    points = np.concatenate([outline.reshape(-1, 2) for outline in view.outlines])
    low, high = points.min(axis=0), points.max(axis=0)
    if len(view.face) > 1:
        low, high = np.minimum(low, view.face.min(axis=0)), np.maximum(high, view.face.max(axis=0))
    return low - EDGE, high + EDGE


def wall_outline(face: Floats, low: Floats, high: Floats) -> Floats:
    """Return the outline of the wall behind its face within a view."""
    if len(face) > 1:
        return np.array([*face, (low[0], face[-1, 1]), (low[0], face[0, 1])])
    level = face[0, 1]
    return np.array([(low[0], low[1]), (high[0], low[1]), (high[0], level), (low[0], level)])
