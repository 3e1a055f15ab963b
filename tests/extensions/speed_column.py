"""A column from outside, the speed of the centre of mass."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fem import IMPACT_COLUMNS, HistoryColumn


def speed(history: Mapping[str, np.ndarray], model: Any) -> np.ndarray:
    return np.hypot(history["v_gx"], history["v_gy"])


COLUMN = HistoryColumn("speed", "m/s", speed, meaning="speed of the centre of mass")
IMPACT_COLUMNS.register(COLUMN)
