"""A plate on another mesh, or of higher-order elements, by which the error of a run is estimated."""

from __future__ import annotations

import math
from collections.abc import Callable

from fem.plate import kinds
from tailslap.scene.schema import Plate

HIGHER_ORDER_UP_TO = 20_000
"""Elements above which statics judges the mesh by a coarser one, of at most so many."""

FINER_UP_TO = 400
"""Elements up to which a second run has the finer mesh; above, one of about as many nodes as the first."""


def refined(
    plate: Plate,
    factor: float = 2.0,
    element: str | None = None,
    least: int = 1,
    whole: Callable[[float], int] = math.floor,
) -> Plate:
    """The plate with `factor` times the elements each way, at least `least`, of another kind where one is given.

    whole: how their number is rounded.
    """
    along, across = (max(least, whole(factor * count)) for count in plate.counts)
    other = {} if element is None else {"element": element}
    return plate.model_copy(update={"elements": (along, across), **other})


def comparable_plate(plate: Plate) -> Plate:
    """The plate by which statics judges the mesh: higher-order elements, of a large mesh a coarser one."""
    if math.prod(plate.counts) > HIGHER_ORDER_UP_TO:
        while math.prod(plate.counts) > HIGHER_ORDER_UP_TO:
            plate = refined(plate, 0.5)
        return plate
    if higher := kinds.ELEMENT_KINDS[plate.element].higher_order:
        # Row sums give the corners of quadratic triangles no mass.
        return plate.model_copy(update={"element": higher, "lumping": "exact"})
    return refined(plate)


def second_plates(plate: Plate) -> tuple[Plate, Plate]:
    """Plates of a second run, to try in turn: quadratic elements where the run has linear ones, for a mesh that locks
    may agree with one that locks a little less; else another number of elements."""
    few, higher = math.prod(plate.counts) <= FINER_UP_TO, kinds.ELEMENT_KINDS[plate.element].higher_order
    factors = (1.0, 2.0) if few and higher else (2.0, 0.5) if few else (0.5, 2.0)
    first, second = (refined(plate, factor, higher or plate.element) for factor in factors)
    return first, second


def higher_order_plates(plate: Plate) -> list[Plate]:
    """Plates by which a whole impact judges the mesh, to try in turn: elements of twice the order, half as many each
    way where that can be; else twice as many."""
    higher = kinds.ELEMENT_KINDS[plate.element].higher_order
    if not higher:
        return [refined(plate)]
    return [refined(plate, 0.5 if min(plate.counts) > 3 else 1.0, higher), refined(plate)]
