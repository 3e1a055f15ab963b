"""Animated GIF of a whole impact.

Above the vehicle beside the wall, below the force.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from postprocess.figures import histories
from postprocess.figures.positions import EDGE, SLOWER
from postprocess.svg.scales import Floats
from postprocess.units import SI, Units

if TYPE_CHECKING:
    from PIL import Image

BODY, WALL = "#14467c", "#8a929b"

SIZE, DPI = (720, 378), 90
"""Size of the animation and its resolution; letters and lines scale with the size [pixels]."""

MAX_FRAMES = 120
"""Largest number of frames. A frame of a GIF lasts whole hundredths of a second, two at least."""


def write_animation(
    path: Path, t: Floats, outlines: Floats, force: Floats, units: Units = SI, size: tuple[int, int] = SIZE
) -> Path:
    """Write the GIF of an impact and return its path.

    It is about `SLOWER` times slower than the impact. t: even instants [s], shape (n,), n >= 2; outlines [m], shape
    (n, points, 2); force on the wall [N], shape (n,); units: of its axes; size: [pixels].
    """
    chosen = np.unique(np.linspace(0, t.size - 1, min(t.size, MAX_FRAMES)).astype(int))
    pause = 10 * max(2, round(100.0 * SLOWER * (t[-1] - t[0]) / (chosen.size - 1)))
    with histories.style():
        first, *further = _frames(chosen, t, outlines, force, units, size)
    first.save(path, save_all=True, append_images=further, duration=pause, loop=0)
    return path


def _frames(
    chosen: NDArray[np.intp], t: Floats, outlines: Floats, force: Floats, units: Units, size: tuple[int, int]
) -> list[Image.Image]:
    """Return Pillow images of the chosen instants.

    All but the body, the force up to now and the time is drawn once.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Polygon
    from PIL import Image

    (length, length_unit), (load, load_unit) = units.of("m"), units.of("N")
    outlines, force, edge = length * outlines, load * force, length * EDGE
    low, high = outlines.min(axis=(0, 1)) - edge, outlines.max(axis=(0, 1)) + edge
    dpi = DPI * min(size[0] / SIZE[0], size[1] / SIZE[1])
    figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
    canvas = FigureCanvasAgg(figure)
    upper, lower = figure.add_axes((0.08, 0.46, 0.89, 0.46)), figure.add_axes((0.08, 0.12, 0.89, 0.26))
    upper.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    upper.set_ylabel(f"Y [{length_unit}]")
    upper.axhspan(low[1], 0.0, color=WALL, alpha=0.6, linewidth=0)
    upper.grid(visible=False)
    lower.plot(t, force, color=WALL, linewidth=0.8)
    lower.set(xlim=(t[0], t[-1]), xlabel="t [s]")
    lower.set_ylabel(f"force [{load_unit}]")
    body = Polygon(outlines[0], facecolor=BODY, edgecolor=BODY, alpha=0.35, animated=True)
    upper.add_patch(body)
    (so_far,) = lower.plot([], [], color=BODY, linewidth=1.4, animated=True)
    clock = upper.set_title("", fontsize=9, loc="left", animated=True)
    canvas.draw()
    background, images = canvas.copy_from_bbox(figure.bbox), []
    for number in chosen:
        canvas.restore_region(background)
        body.set_xy(outlines[number])
        so_far.set_data(t[: number + 1], force[: number + 1])
        clock.set_text(f"{t[number]:.3f} s")
        upper.draw_artist(body)
        lower.draw_artist(so_far)
        upper.draw_artist(clock)
        images.append(Image.fromarray(np.array(canvas.buffer_rgba())).convert("P", dither=Image.Dither.NONE))
    return images
