"""Many impacts by values of the law of the corners."""

from typing import Any

from solver.impact import CrushLaw, Impacts, WallContact, solve_impacts
from solver.impact.crush_law import LAW


def sampled_impacts(friction: Any, **values: Any) -> Impacts:
    """Return impacts by keys of `LAW`, which are those of all corners."""
    law = {key: values.pop(key) for key in LAW if key in values}
    return solve_impacts(contact=WallContact(CrushLaw(**law), friction), **values)


def corner_tables(
    length: float, front: dict[str, Any], rear: dict[str, Any], unit: int = 1
) -> list[dict[str, Any]]:
    """Return [[strip]] tables of the corners of a unit."""
    return [{"at": at, "unit": unit, **law} for at, law in ((0.0, front), (length, rear))]
