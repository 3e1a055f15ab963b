"""Strikes as figures mark them: shaded times with their names."""

from collections.abc import Sequence
from dataclasses import dataclass

from postprocess.svg.marks import Span

COLOURS = {"front": "red", "rear": "fe"}


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
    return COLOURS.get(corner, "soft")


def shaded(strikes: Sequence[StrikeMark]) -> tuple[Span, ...]:
    """Their times as bands behind the plot, each with its corner's name on top."""
    return tuple(Span(strike.corner, strike.start, strike.end, strike.colour) for strike in strikes)
