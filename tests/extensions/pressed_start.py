"""A start from outside, unstrained with the corner pressed into its constraint."""

from typing import Any

import numpy as np

from fem import START_KINDS, StartKind
from fem.start.inertia_relief import statics


def fields(model: Any, start: Any, body: np.ndarray) -> Any:
    return np.zeros_like(body), np.zeros_like(body), statics(model, start).gap, 0.0


START = StartKind("pressed", fields, "unstrained, its corner pressed into the constraint", relieved=False)
START_KINDS.register(START)
