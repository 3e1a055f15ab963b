"""The impact as an animated GIF: the vehicle along the wall, and the force below it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from postprocess.figures import histories, impact
from postprocess.svg.drawing import Floats
from postprocess.units import SI, Units

BODY, WALL = "#14467c", "#8a929b"
SIZE, DPI = (8.0, 4.2), 90
MAX_FRAMES = 120
"""More instants are thinned to as many. A frame of a GIF lasts whole hundredths of a second, from two on."""


def write_animation(
    path: Path, t: Floats, outlines: Floats, force: Floats, slower: float = 10.0, units: Units = SI
) -> Path:
    """Write the GIF and return its path; it runs about `slower` times slower than the impact.

    t [s], shape (n,), even, n >= 2; outlines [m], shape (n, points, 2); force on the wall [N], shape (n,); units: of
    its axes.
    """
    chosen = np.unique(np.linspace(0, t.size - 1, min(t.size, MAX_FRAMES)).astype(int))
    pause = 10 * max(2, round(100.0 * slower * (t[-1] - t[0]) / (chosen.size - 1)))
    with histories.style():
        first, *others = _frames(chosen, t, outlines, force, units)
    first.save(path, save_all=True, append_images=others, duration=pause, loop=0)
    return path


def _frames(chosen: np.ndarray, t: Floats, outlines: Floats, force: Floats, units: Units) -> list[Any]:
    """Pillow images of the chosen instants; all but body, force so far and time is drawn once."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Polygon
    from PIL import Image

    (length, length_unit), (load, load_unit) = units.of("m"), units.of("N")
    outlines, force, edge = length * outlines, load * force, length * impact.EDGE
    low, high = outlines.min(axis=(0, 1)) - edge, outlines.max(axis=(0, 1)) + edge
    figure = Figure(figsize=SIZE, dpi=DPI)
    canvas: Any = FigureCanvasAgg(figure)
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
    still, found = canvas.copy_from_bbox(figure.bbox), []
    for number in chosen:
        canvas.restore_region(still)
        body.set_xy(outlines[number])
        so_far.set_data(t[: number + 1], force[: number + 1])
        clock.set_text(f"{t[number]:.3f} s")
        upper.draw_artist(body)
        lower.draw_artist(so_far)
        upper.draw_artist(clock)
        found.append(Image.fromarray(np.array(canvas.buffer_rgba())).convert("P", dither=Image.Dither.NONE))
    return found
