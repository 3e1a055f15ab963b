"""Strikes as figures mark them: shaded times, named above the plot."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#e2574c", "#14467c")
OTHER = "#5b6570"


@dataclass(frozen=True)
class StrikeMark:
    """A strike: its corner, "front" or "rear", instants [s], and where along the wall it begins and ends [m]."""

    corner: str
    start: float
    end: float
    places: tuple[float, float] = (0.0, 0.0)

    @property
    def colour(self) -> str:
        """Of everything that shows this corner."""
        return corner_colour(self.corner)


def corner_colour(corner: str) -> str:
    """One colour for each of the two corners, grey for what is none."""
    return dict(zip(("front", "rear"), COLOURS, strict=True)).get(corner, OTHER)


def shade_strikes(axes: "Axes", strikes: Sequence[StrikeMark]) -> None:
    """Their times as bands behind the plot, each with its corner's name on top."""
    for strike in strikes:
        axes.axvspan(strike.start, strike.end, color=strike.colour, alpha=0.09, linewidth=0, zorder=0)
        axes.annotate(
            strike.corner,
            (0.5 * (strike.start + strike.end), 1.0),
            (0, 2),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            color=strike.colour,
            fontsize=7.5,
            ha="center",
            va="bottom",
        )
