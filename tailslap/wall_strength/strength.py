"""Bounds of the strength of a wall.

The wall is a plate that is fixed at the deck."""

from __future__ import annotations

import math
from typing import NamedTuple

from fem.limit.bounds import Bounds, collapse_load
from fem.limit.plate import Floats, Indices, PlasticPlate
from meshes.bands import banded_rectangle
from postprocess.units import measure
from solver.parapet import Resistance, Strengths

TOLERANCE, MOST_TRIANGLES = 0.01, 6000
"""Difference of the bounds that is aimed at [-], and the size of mesh from which on none is refined."""

FINE, COARSE, CORNER = 0.25, 0.5, 0.06
"""Sizes of the first triangles at the load, elsewhere and at the foot of a free end, in heights of the wall [-].

A fan of curvature begins at that foot.
"""

STRETCHES, FAR = (1.0, 2.0, 4.0, 8.0), 0.15
"""Factors on the modelled length, and the difference of the bounds on the first mesh from which on more is modelled."""

MARGIN = 2.0
"""Length of a long wall that is modelled beyond the mechanism of A13.3.1, in its heights [-]."""


class Load(NamedTuple):
    """Uniform line load on a wall.

    length, height [m]; end_distance: from the end of the wall to the beginning of the load [m], None in the middle.
    """

    length: float
    height: float
    end_distance: float | None


class Computed(NamedTuple):
    """Strength of a wall under a load.

    load_name: of the load; place: "interior", "end", or "impact" at a given distance; bounds: proven; formula: A13.3.1.
    """

    load_name: str
    place: str
    load: Load
    bounds: Bounds
    formula: Resistance

    @property
    def where(self) -> str:
        """Place in words."""
        at = self.load.end_distance
        return f"{measure(at, 'm', '.3g')} from the end" if at and self.place == "impact" else self.place

    @property
    def lower(self) -> float | None:
        """Lower bound [N], None without proof."""
        return self.bounds.lower.value or None

    @property
    def upper(self) -> float | None:
        """Upper bound [N], None without proof."""
        return self.bounds.upper.value if math.isfinite(self.bounds.upper.value) else None


def wall_plate(
    strengths: Strengths, load: Load, length: float = math.inf, stretch: float = 1.0
) -> PlasticPlate:
    """Return the plate of a wall.

    length: of the wall [m]. Of a load in the middle it is the half on one side of the axis of symmetry. A wall that is
    longer than the mechanism needs is cut; stretch: factor on the modelled length [-]. ValueError for a load beyond it.
    """
    reach = strengths.resistance(load.length, "interior").critical_length + 2.0 * MARGIN * strengths.height
    start, end = -0.5 * load.length, 0.5 * load.length
    whole, nearest = 0.5 * length, "symmetric"
    if load.end_distance is not None:
        start, end = load.end_distance, load.end_distance + load.length
        whole, nearest = length, "free"
    if end > whole:
        raise ValueError(f"the load ends at {end:g} m, beyond the wall of {whole:g} m")
    modelled = 0.5 * (max(start, 0.0) + end + stretch * reach)
    sides = {
        "left": nearest,
        "right": "free" if whole <= modelled else "cut",
        "bottom": "clamped",
        "top": "free",
    }
    line = (load.height, start, end)
    size = min(whole, modelled), strengths.height
    return PlasticPlate(*size, sides, strengths.levels, strengths.moments, line, beam=strengths.beam)


def bounds_of(
    strengths: Strengths,
    load: Load,
    length: float = math.inf,
    tolerance: float = TOLERANCE,
    most: int = MOST_TRIANGLES,
) -> Bounds:
    """Return bounds of the strength of a wall [N].

    tolerance, most: see `collapse_load`. More of a long wall is modelled while its end alone keeps the bounds apart.
    """
    for stretch in STRETCHES:
        plate = wall_plate(strengths, load, length, stretch)
        ends = plate.sides["right"] == "free" or stretch == STRETCHES[-1]
        bounds = collapse_load(plate, *_first_mesh(plate), tolerance, most, math.inf if ends else FAR)
        if ends or bounds.width < FAR:
            break
    return bounds


def _first_mesh(plate: PlasticPlate) -> tuple[Floats, Indices]:
    """Return nodes and triangles, graded at the load and free ends."""
    assert plate.line
    height, start, end = plate.line
    margin = 0.5 * plate.height

    def size(x: float, y: float) -> float:
        if x == y == 0.0 and plate.sides["left"] == "free":
            return plate.height * CORNER
        return plate.height * (FINE if start - margin <= x <= end + margin else COARSE)

    return banded_rectangle(
        plate.length,
        sorted({*plate.levels.tolist(), height}),
        {height: [x for x in (start, end) if 0.0 < x < plate.length]},
        size,
    )
