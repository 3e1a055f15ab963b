"""Verdicts over pairs of axes as small maps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from postprocess.svg import chart, scales
from postprocess.svg.areas import Boxes
from postprocess.svg.marks import Swatch
from postprocess.svg.scales import Floats, cells_about

VERDICTS = {"right": "green", "flexible": "steel", "refused": "grid"}
"""Colours of the verdicts."""
VERDICTS |= {"caught": "rigid", "unjudged": "grey", "wrong": "red"}
"""Colours of the verdicts; all else is an error."""

MAP_WIDTH, HEIGHT, TICKS = 252.0, 190.0, 5


@dataclass(frozen=True)
class MapAxis:
    """Axis of a map with label and values.

    Values are evenly spaced, at even ratios, or 0 and then at even ratios.
    """

    label: str
    values: Sequence[float]

    @property
    def is_even(self) -> bool:
        """True if the values have even steps.

        Two values have, unless a decade or more lies between them.
        """
        steps = np.diff(self.values)
        if len(self.values) == 2:
            return bool(self.values[0] == 0.0 or self.values[1] < 10.0 * self.values[0])
        return bool(np.ptp(steps) < 1e-6 * abs(steps[0]))

    @property
    def places(self) -> Floats:
        """Places of the values on the axis scale.

        On a logarithmic one 0 lies one ratio below the next value.
        """
        places = np.array(self.values, float)
        if not self.is_even and places[0] == 0.0:
            places[0] = places[1] ** 2 / places[2]
        return places

    @property
    def axis(self) -> chart.Axis:
        """Axis with ticks at round values."""
        cells = cells_about(self.places, not self.is_even)
        low, high = float(cells.min()), float(cells.max())
        ticks = scales.Scale(low, high, is_log=not self.is_even).ticks(TICKS)
        named = list(zip(ticks, scales.tick_texts(ticks, not self.is_even), strict=True))
        if self.places[0] != self.values[0]:
            first = float(self.places[0])
            named = [(first, "0"), *(tick for tick in named if tick[0] > 2.0 * first)]
        return chart.Axis(self.label, low, high, not self.is_even, named=tuple(named))


def draw_map(
    name: str, across: MapAxis, up: MapAxis, verdicts: Sequence[Sequence[str]], caption: str
) -> chart.Chart:
    """Draw verdicts as cells of equal size.

    verdicts[row][column]: rows go up, columns across; pages show the values of each.
    """
    x, y = (places.ravel() for places in np.meshgrid(across.places, up.places))
    kinds = [kind for row in verdicts for kind in row]
    at = [f"{_rounded(a)}; {_rounded(b)}" for b in up.values for a in across.values]
    ends = cells_about(x, not across.is_even), cells_about(y, not up.is_even)
    cells = Boxes("verdict", *ends, [VERDICTS[kind] for kind in kinds], kinds, at)
    plot = chart.Plot((cells,), up.axis, HEIGHT, nearest="xy", has_grid=False)
    return chart.Chart(name, caption, (plot,), across.axis, "Maps", MAP_WIDTH)


def _rounded(value: float) -> str:
    return scales.power_text(float(f"{value:.3g}"))


def draw_meanings(meanings: Mapping[str, str], caption: str) -> chart.Chart:
    """Draw the meaning of every colour of maps."""
    keys = [Swatch(f"{kind}: {meaning}", VERDICTS[kind]) for kind, meaning in meanings.items()]
    return chart.draw_legend("map-legend", caption, keys, "Maps")
