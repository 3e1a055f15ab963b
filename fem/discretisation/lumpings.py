"""Kinds of mass lumping. Each is one object; adding one is adding it here, or in any file that registers it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fem.discretisation.mass import exact_inertia_masses, row_sum_masses
from fem.registry import Registry


@dataclass(frozen=True)
class Lumping:
    """A kind of mass lumping.

    Attributes
    ----------
    name : str
        In a scene.
    masses : callable
        Takes scikit-fem's scalar basis, density [kg/m^3] and thickness [m]; returns nodal masses [kg], shape (nodes,).
    fault : str
        For reports: what it does to the rotary inertia, "" where that is exact.
    row_sums : bool
        Whether it needs elements whose mass matrix has positive row sums.
    """

    name: str
    masses: Callable[[Any, float, float], np.ndarray]
    fault: str = ""
    row_sums: bool = False


LUMPINGS: Registry[Lumping] = Registry("mass lumping")
"""Kinds of mass lumping by their names in a scene."""

for _kind in (
    Lumping("exact", exact_inertia_masses),
    Lumping("row-sum", row_sum_masses, fault="the rotary inertia is overstated", row_sums=True),
):
    LUMPINGS.register(_kind)
