"""The strip of positions: outlines of the vehicle along the wall, and where the strikes are."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from postprocess.figures.impact.strikes import StrikeMark
from postprocess.figures.style import Curve, drawn, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

WIDTH, MARGIN, EDGE = 9.6, 0.6, 0.4
"""Width of the figure and height of all but the strip [in]; free space about what is drawn [m]."""

TOP, ROW = 0.9, 0.5
"""Height of the row of instants above the vehicle, and of each strike's row below the wall's face [m]."""

WALL, BODY, PATH = "#8a929b", "#14467c", "#5b6570"


def vehicle_outlines(
    x: Floats, y: Floats, theta: Floats, length: float, width: float, centre: float
) -> Floats:
    """Corners of a rigid vehicle, front and rear of the wall's side first: shape (n, 4, 2) [m].

    x, y: centre of mass [m], theta: angle between side and wall [rad], shape (n,); centre: how far behind the front the
    centre of mass lies [m].
    """
    heading = np.stack([np.cos(theta), -np.sin(theta)], axis=-1)
    left = np.stack([np.sin(theta), np.cos(theta)], axis=-1)
    ends = [centre * heading - 0.5 * width * left, (centre - length) * heading - 0.5 * width * left]
    across = [ends[1] + width * left, ends[0] + width * left]
    return np.asarray(np.stack([x, y], axis=-1)[:, None] + np.stack([*ends, *across], axis=1))


def draw_positions(
    outlines: Floats,
    instants: Sequence[float],
    strikes: Sequence[StrikeMark] = (),
    path: Floats | None = None,
) -> Curve:
    """Outlines at these instants [s], later ones darker, over the wall Y = 0; strikes as bars below its face.

    outlines: shape (k, points, 2) [m]; path: of the centre of mass, shape (n, 2) [m].
    """
    from matplotlib.figure import Figure

    caption = (
        "Positions of the vehicle, later ones darker; below the wall's face what is crushed, and the strikes"
    )
    points = outlines.reshape(-1, 2)
    low, high = points.min(axis=0) - EDGE, points.max(axis=0) + np.array([2.0 * EDGE, TOP])
    rows = low[1] - ROW * np.arange(len(strikes))
    low[1] -= ROW * len(strikes)
    tall = (0.93 * WIDTH) * (high - low)[1] / (high - low)[0]
    with style():
        figure = Figure(figsize=(WIDTH, tall + MARGIN))
        axes = figure.add_axes((0.05, 0.45 / (tall + MARGIN), 0.93, tall / (tall + MARGIN)))
        axes.set(
            xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="X along the wall [m]", ylabel="Y [m]"
        )
        axes.axhspan(low[1], 0.0, color=WALL, alpha=0.35, linewidth=0)
        axes.axhline(0.0, color=WALL, linewidth=1.2)
        if path is not None:
            axes.plot(*path.T, color=PATH, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
        for number, (outline, instant) in enumerate(zip(outlines, instants, strict=True)):
            _draw_outline(axes, outline, instant, (number + 1) / len(outlines))
        for strike, row in zip(strikes, rows, strict=True):
            _draw_strike(axes, strike, row)
        axes.tick_params(length=2.5)
        axes.grid(visible=False)
        return drawn(figure, "positions", caption, "Motion")


def _draw_outline(axes: "Axes", outline: Floats, instant: float, shade: float) -> None:
    """One outline; its instant on top, over the point that lies farthest along the wall."""
    from matplotlib.patches import Polygon

    strength = 0.25 + 0.75 * shade
    edge: dict[str, Any] = {"edgecolor": BODY, "linewidth": 1.1, "alpha": strength, "zorder": 2 + shade}
    axes.add_patch(Polygon(outline, facecolor="none", **edge))
    axes.add_patch(Polygon(outline, facecolor=BODY, alpha=0.035, linewidth=0, zorder=2))
    x, y = outline[outline[:, 0].argmax()]
    top = axes.get_ylim()[1] - 0.5 * TOP
    axes.plot((x, x), (y, top), color=BODY, linewidth=0.6, linestyle=(0, (1, 2)), alpha=strength)
    axes.text(x, top, f"{instant:.2f} s", fontsize=7, ha="center", va="bottom", color=BODY)


def _draw_strike(axes: "Axes", strike: StrikeMark, height: float) -> None:
    axes.plot(strike.places, (height, height), color=strike.colour, linewidth=4.0, solid_capstyle="butt")
    text = f"{strike.corner} {strike.start:.3f} to {strike.end:.3f} s"
    beside: dict[str, Any] = {
        "textcoords": "offset points",
        "fontsize": 7,
        "color": strike.colour,
        "va": "center",
    }
    axes.annotate(text, (max(strike.places), height), (5, 0), **beside)
