"""Animated marks of a plot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from postprocess.svg.marks import Mark, coloured, path
from postprocess.svg.scales import Floats, Scale, even_rows

SLOWER, MAX_FRAMES, HOLD = 10.0, 101, 0.12
"""Slowdown of an animation, most frames, and fraction of its duration on the last one."""

MOTION = (
    f"@keyframes motion{{from{{transform:none}}{100.0 * (1.0 - HOLD):g}%,to{{transform:translateX(var(--shift))}}}}"
    ".moving{transform:translateX(var(--shift));animation:motion var(--time) infinite}"
    "@media print,(prefers-reduced-motion:reduce){.moving{animation:none}}"
)
"""Style of a chart with animated marks."""


def animated(elements: str, travel: float, t: Floats) -> str:
    """Return elements with a repeated motion along x by `MOTION`.

    travel: distance [pixels], in one step for each frame; t: instants [s]. Without animation the elements are at the
    end, as on paper and for readers who prefer reduced motion. Pages can pause it.
    """
    variables = f"--shift:{travel:.2f}px;--time:{SLOWER * float(np.ptp(t)) / (1.0 - HOLD):.3g}s"
    steps = f"animation-timing-function:steps({len(even_rows(t, MAX_FRAMES)) - 1})"
    return f'<g class="moving" style="{variables};{steps}">{elements}</g>'


@dataclass(frozen=True)
class Moving(Mark):
    """Closed polygon, of which an animation shows one instant at a time.

    t: even instants [s], shape (n,); x, y: corners, shape (n, points). The instants stand side by side, and pass behind
    the plot as behind a window.
    """

    label: str
    t: Floats
    x: Floats
    y: Floats
    colour: str = "fe"
    fill: float = 0.45

    def draw(self, x: Scale, y: Scale) -> str:
        """Return the chosen instants in a window."""
        wide, rows = x.end - x.start, even_rows(self.t, MAX_FRAMES)
        places = np.stack([x.at(self.x[rows]) - x.start, y.at(self.y[rows]) - y.end], axis=-1)
        places[..., 0] += wide * np.arange(rows.size)[:, None]
        edges = path(np.pad(places, ((0, 0), (0, 1), (0, 0)), constant_values=np.nan).reshape(-1, 2), end="Z")
        shapes = f'<path d="{edges}" fill-opacity="{self.fill:g}" stroke="currentColor" stroke-width="1.2"/>'
        window = f'x="{x.start:.2f}" y="{y.end:.2f}" width="{wide:.2f}" height="{y.start - y.end:.2f}"'
        film = animated(shapes, wide * (1 - rows.size), self.t)
        return coloured(f"<svg {window}>{film}</svg>", self.colour)


@dataclass(frozen=True)
class Cursor(Mark):
    """Line at the current instant of an animation, across a plot.

    The animation is that of `Moving` marks of the same instants.
    """

    ACROSS = ("t",)
    UP = ()
    label: str
    t: Floats
    colour: str = "ink"

    def draw(self, x: Scale, y: Scale) -> str:
        """Return the line."""
        start, end = x.at(self.t[[0, -1]])
        line = f'<path d="M{start:.2f} {y.end:.2f}V{y.start:.2f}" stroke="currentColor" stroke-width="1.5"/>'
        return coloured(animated(line, end - start, self.t), self.colour)
