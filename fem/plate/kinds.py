"""Kinds of elements and of mass lumping.

Each is one object, registered here or in any file outside. scikit-fem supplies shape functions and quadrature, and the
same compiled kernels serve all elements.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fem.plate.nodal_masses import exact_inertia_masses, row_sum_masses
from fem.registry import Registry

if TYPE_CHECKING:
    from skfem import CellBasis

ELEMENT_KINDS: Registry[ElementKind] = Registry("element")
"""Kinds of elements by their names in a scene."""

LUMPINGS: Registry[Lumping] = Registry("mass lumping")
"""Kinds of mass lumping by their names in a scene."""


@dataclass(frozen=True)
class ElementKind:
    """A kind of element with its cost.

    Attributes
    ----------
    name : str
        In a scene.
    element : str
        Class of scikit-fem.
    order : int
        Polynomial order that the quadrature integrates exactly; 0 for the one point in the middle, which scikit-fem
        has no order for.
    cells : str
        Cells of the mesh.
    hourglass : bool
        True if it needs hourglass control.
    higher_order : str
        Kind of twice the order on the same mesh, "" where this one is of second order.
    row_sums : bool
        True if row sums of its mass matrix are positive.
    nanoseconds : float
        Time of a quadrilateral of the mesh, or the triangles in its place, per step on one core [ns], measured by
        `benchmarks/speed.py`.
    distorted : float
        Ratio of this time on a distorted mesh [-].
    points : int
        Quadrature points of a cell of the mesh, at each of which a stress is computed.
    steps_per_crossing : float
        Steps in which a wave crosses an element's short side [-], measured on 20 x 6 and 8 x 10 elements.
    draw_weight : int
        Weight of the kind among those of random scenes; 0 if it is never drawn.
    cell_type : str
        Name of its cells in other programs, where the nodes are in the same order; "" exports the corner nodes alone.
    """

    name: str
    element: str
    order: int
    cells: str
    hourglass: bool = False
    higher_order: str = ""
    row_sums: bool = True
    nanoseconds: float = 75.0
    distorted: float = 1.0
    points: int = 9
    steps_per_crossing: float = 4.0
    draw_weight: int = 0
    cell_type: str = ""


for _kind in (
    ElementKind(
        "quad4", "ElementQuad1", order=2, cells="quad", higher_order="quad9", cell_type="quad",
        nanoseconds=9.0, distorted=1.7, points=4, steps_per_crossing=1.2, draw_weight=1,
    ),
    ElementKind(
        "quad4-reduced", "ElementQuad1", order=0, cells="quad", higher_order="quad9", cell_type="quad",
        nanoseconds=7.5, distorted=1.1, points=1, steps_per_crossing=1.2, draw_weight=1, hourglass=True,
    ),
    ElementKind(
        "quad9", "ElementQuad2", order=4, cells="quad", cell_type="quad9",
        nanoseconds=39.0, distorted=1.6, points=9, steps_per_crossing=3.0, draw_weight=1,
    ),
    ElementKind(
        "tri3", "ElementTriP1", order=1, cells="triangle", higher_order="tri6", cell_type="triangle",
        nanoseconds=33.0, points=2, steps_per_crossing=1.5, draw_weight=1,
    ),
    ElementKind(
        "tri6", "ElementTriP2", order=2, cells="triangle", cell_type="triangle6", row_sums=False,
        nanoseconds=65.0, points=6, steps_per_crossing=3.5, draw_weight=1,
    ),
):  # fmt: skip
    ELEMENT_KINDS.register(_kind)


@dataclass(frozen=True)
class Lumping:
    """A kind of mass lumping.

    Attributes
    ----------
    name : str
        In a scene.
    masses : callable
        Takes the scalar basis of scikit-fem, density [kg/m^3] and thickness [m]; returns nodal masses [kg], shape
        (nodes,).
    fault : str
        Its error in the rotary inertia for reports, "" where that is exact.
    row_sums : bool
        True if it needs elements whose mass matrix has positive row sums.
    """

    name: str
    masses: Callable[[CellBasis, float, float], np.ndarray]
    fault: str = ""
    row_sums: bool = False


for _lumping in (
    Lumping("exact", exact_inertia_masses),
    Lumping("row-sum", row_sum_masses, fault="the rotary inertia is overstated", row_sums=True),
):
    LUMPINGS.register(_lumping)
