"""Work-precision diagrams as SVG text: error against run time on logarithmic axes, a colour and mark a group."""

from collections.abc import Mapping, Sequence

import numpy as np

from postprocess.curves import Curve
from postprocess.figures import style, svg_text

SIZE = (7.4, 4.9)
MARKS = "oosDv^<>pPX*hd8s"
COLOURS = (
    "#14467c", "#dd8a1d", "#2a9d63", "#e2574c", "#8d6bb5", "#17a2b8", "#8c6d31", "#d6459b",
    "#5b6570", "#7fb800", "#0072bd", "#a2142f", "#4dbeee", "#edb120", "#77ac30", "#000000",
)  # fmt: skip

Points = Sequence[tuple[float, float, float]]


def draw_precision(
    name: str,
    groups: Mapping[str, Points],
    front: Sequence[tuple[float, float]],
    error_label: str,
    caption: str,
) -> Curve:
    """Each group's points (time [s], median time [s], error), joined in their order; front: the Pareto front's."""
    from matplotlib.figure import Figure

    with style(name):
        figure = Figure(figsize=SIZE)
        axes = figure.add_axes((0.1, 0.11, 0.64, 0.86))
        axes.set_xscale("log")
        axes.set_yscale("log")
        if front:
            times, errors = np.array(front).T
            axes.step(
                times, errors, where="post", color="#c9ced4", linewidth=7, solid_capstyle="round", zorder=1
            )
        for number, (group, points) in enumerate(groups.items()):
            colour, mark = COLOURS[number % len(COLOURS)], MARKS[number % len(MARKS)]
            times, medians, errors = np.array(points).T
            axes.hlines(errors, times, medians, color=colour, linewidth=0.8, alpha=0.6)
            axes.plot(
                times, errors, color=colour, marker=mark, markersize=4.5, linewidth=0.9, label=group, zorder=3
            )
        axes.margins(x=0.06, y=0.05)
        axes.set_xlabel(
            "time to the answer [s]: fastest of several, the line to its right ends at the median"
        )
        axes.set_ylabel(error_label)
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8, frameon=False)
        return Curve(name, "Work and precision", caption, svg_text(figure, name, caption))
