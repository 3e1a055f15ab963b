"""The impact as an animated GIF: the vehicle along the wall, and the force below it."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.impact.positions import EDGE
from postprocess.figures.style import style
from postprocess.report.units import SI, Units

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

BODY, WALL = "#14467c", "#8a929b"
SIZE, DPI = (8.0, 4.2), 90
MAX_FRAMES = 120
"""More instants are thinned to as many. A frame of a GIF lasts whole hundredths of a second, from two on."""


@dataclass(frozen=True)
class Stage:
    """What stands still in all frames, and the artists that do not: body, force so far, time."""

    figure: "Figure"
    body: Any
    so_far: Any
    clock: Any

    def name_axes(self, length_unit: str, force_unit: str) -> None:
        """Labels with units."""
        self.body.axes.set_ylabel(f"Y [{length_unit}]")
        self.so_far.axes.set_ylabel(f"force [{force_unit}]")


def write_animation(
    path: Path, t: Floats, outlines: Floats, force: Floats, slower: float = 10.0, units: Units = SI
) -> Path:
    """Write the GIF and return its path; it runs about `slower` times slower than the impact.

    t [s], shape (n,), even, n >= 2; outlines [m], shape (n, points, 2); force on the wall [N], shape (n,); units: of
    its axes.
    """
    frames = np.unique(np.linspace(0, t.size - 1, min(t.size, MAX_FRAMES)).astype(int))
    pause = 10 * max(2, round(100.0 * slower * (t[-1] - t[0]) / (frames.size - 1)))
    with style():
        (length, length_unit), (load, load_unit) = units.of("m"), units.of("N")
        outlines, force = length * outlines, load * force
        stage = _make_stage(t, outlines, force, length * EDGE)
        stage.name_axes(length_unit, load_unit)
        first, *others = _frames(stage, frames, t, outlines, force)
    first.save(path, save_all=True, append_images=others, duration=pause, loop=0)
    return path


def _make_stage(t: Floats, outlines: Floats, force: Floats, edge: float) -> Stage:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Polygon

    low, high = outlines.min(axis=(0, 1)) - edge, outlines.max(axis=(0, 1)) + edge
    figure = Figure(figsize=SIZE, dpi=DPI)
    FigureCanvasAgg(figure)
    upper, lower = figure.add_axes((0.08, 0.46, 0.89, 0.46)), figure.add_axes((0.08, 0.12, 0.89, 0.26))
    upper.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    upper.axhspan(low[1], 0.0, color=WALL, alpha=0.6, linewidth=0)
    upper.grid(visible=False)
    lower.plot(t, force, color=WALL, linewidth=0.8)
    lower.set(xlim=(t[0], t[-1]), xlabel="t [s]")
    body = Polygon(outlines[0], facecolor=BODY, edgecolor=BODY, alpha=0.35, animated=True)
    (so_far,) = lower.plot([], [], color=BODY, linewidth=1.4, animated=True)
    clock = upper.set_title("", fontsize=9, loc="left", animated=True)
    return Stage(figure, upper.add_patch(body), so_far, clock)


def _frames(stage: Stage, frames: NDArray[np.int_], t: Floats, outlines: Floats, force: Floats) -> list[Any]:
    """Pillow images; all but the three artists is drawn once."""
    from PIL import Image

    canvas: Any = stage.figure.canvas
    canvas.draw()
    still, found = canvas.copy_from_bbox(stage.figure.bbox), []
    for frame in frames:
        canvas.restore_region(still)
        stage.body.set_xy(outlines[frame])
        stage.so_far.set_data(t[: frame + 1], force[: frame + 1])
        stage.clock.set_text(f"{t[frame]:.3f} s")
        for artist in (stage.body, stage.so_far, stage.clock):
            artist.axes.draw_artist(artist)
        found.append(Image.fromarray(np.array(canvas.buffer_rgba())).convert("P", dither=Image.Dither.NONE))
    return found
