"""A column from outside, the mean height above the wall."""

from typing import Any

from fem import COLUMNS, HistoryColumn


def height(measures: Any, state: Any, model: Any) -> float:
    return float(state.positions[1].mean())


COLUMN = HistoryColumn("height", "m", height, symbol="y", caption="Mean height of the nodes above the wall")
COLUMNS.register(COLUMN)
