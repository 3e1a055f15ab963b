"""Kinds of elements and of mass lumping.

Each is one object; adding one is adding it here, or in any file that registers it.

scikit-fem supplies shape functions and quadrature; all elements go through the same compiled kernel. Nodal masses are
row sums, moved by the least relative change to the exact rigid-body inertia.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fem.plate.properties import Inertia, ModelError
from fem.registry import Registry


@dataclass(frozen=True)
class ElementKind:
    """A kind of element.

    Attributes
    ----------
    name : str
        In a scene.
    element : str
        scikit-fem's.
    order : int
        That the quadrature integrates; 0 stands for the one point in the middle, which scikit-fem does not choose by
        itself.
    cells : str
        That it sits on.
    hourglass : bool
        True if it needs hourglass control.
    higher_order : str
        Kind of twice the order on the same mesh, "" where this one is of second order.
    row_sums : bool
        True if row sums of its mass matrix are positive.
    """

    name: str
    element: str
    order: int
    cells: str
    hourglass: bool = False
    higher_order: str = ""
    row_sums: bool = True


ELEMENT_KINDS: Registry[ElementKind] = Registry("element")
"""Kinds of elements by their names in a scene."""

for _kind in (
    ElementKind("quad4", "ElementQuad1", 2, "quad", higher_order="quad9"),
    ElementKind("quad4-reduced", "ElementQuad1", 0, "quad", hourglass=True, higher_order="quad9"),
    ElementKind("quad9", "ElementQuad2", 4, "quad"),
    ElementKind("tri3", "ElementTriP1", 1, "triangle", higher_order="tri6"),
    ElementKind("tri6", "ElementTriP2", 2, "triangle", row_sums=False),
):
    ELEMENT_KINDS.register(_kind)


def row_sum_masses(scalar: Any, density: float, thickness: float) -> np.ndarray:
    """Row sums of the consistent mass matrix [kg], shape (nodes,)."""
    import skfem

    return density * thickness * skfem.LinearForm(lambda v, w: v).assemble(scalar)


def scaled_diagonal_masses(scalar: Any, density: float, thickness: float) -> np.ndarray:
    """Diagonal of the consistent mass matrix, scaled to the plate's mass (Hinton, Rock and Zienkiewicz) [kg]."""
    import skfem

    diagonal = skfem.BilinearForm(lambda u, v, w: u * v).assemble(scalar).diagonal()
    return np.asarray(diagonal * (density * thickness * scalar.dx.sum() / diagonal.sum()))


def exact_inertia_masses(scalar: Any, density: float, thickness: float) -> np.ndarray:
    """Masses [kg] with the exact mass, centre and second moments of the meshed body, shape (nodes,).

    Row sums overstate the rotary inertia by the order of the squared element size. Of all corrections that
    make the six moments exact, this has the least sum of squared relative changes: m = m_0 + m_0^2 A^T z.
    Elements with row sums that are not positive (tri6) start from the scaled diagonal instead.
    Raises ModelError if a mass would not stay positive (a mesh too coarse to carry the moments).
    """
    masses = row_sum_masses(scalar, density, thickness)
    if masses.min() < 1e-3 * masses.mean():
        masses = scaled_diagonal_masses(scalar, density, thickness)
    middle, size = _frame(scalar)
    moments = np.array(_moments(*((scalar.doflocs - middle[:, None]) / size[:, None])))
    exact = _exact_moments(scalar) * density * thickness
    weighted = moments * masses**2
    multipliers = np.linalg.lstsq(weighted @ moments.T, exact - moments @ masses, rcond=None)[0]
    masses = masses + masses**2 * (multipliers @ moments)
    if not (masses > 0.0).all():
        coarse = "the mesh is too coarse for the exact inertia with positive nodal masses"
        raise ModelError("elements", coarse)
    if not np.allclose(moments @ masses, exact, rtol=1e-12, atol=1e-12 * exact[0]):
        raise ModelError("elements", "the mesh has too few nodes for the exact inertia")
    return masses


def given_inertia_masses(positions: np.ndarray, masses: np.ndarray, inertia: Inertia) -> np.ndarray:
    """Masses [kg] with their own sum, and this centre and yaw inertia, shape (nodes,); corner P is the origin.

    Of all such masses those of the greatest entropy beside the given ones, m exp(z . moments): they are positive, and
    there are some wherever any positive masses have that inertia. Raises ModelError where there are none.
    """
    total, size = masses.sum(), np.ptp(positions, axis=1)
    x = (positions[0] + inertia.centre) / size[0]
    y = (positions[1] - 0.5 * size[1]) / size[0]
    moments = np.array([np.ones_like(x), x, y, x * x + y * y])
    wanted = np.array([1.0, 0.0, 0.0, inertia.yaw_inertia / (total * size[0] ** 2)])
    multipliers = np.zeros(4)
    for _ in range(NEWTON_STEPS):
        tilted = masses / total * np.exp(multipliers @ moments)
        excess = moments @ tilted - wanted
        if np.abs(excess).max() < 1e-15 * len(masses):
            break
        step = np.linalg.lstsq((moments * tilted) @ moments.T, excess, rcond=None)[0]
        multipliers -= step / max(1.0, np.abs(step).max() / 2.0)
    tilted = total * tilted
    if not np.allclose(moments @ tilted, total * wanted, rtol=0.0, atol=1e-11 * total) or tilted.min() <= 0.0:
        raise ModelError("inertia", "no positive nodal masses have this centre of mass and yaw inertia")
    return tilted


NEWTON_STEPS = 200
"""For the masses of a given inertia; ten are enough but near the limit of what any masses can have."""


def _frame(scalar: Any) -> tuple[np.ndarray, np.ndarray]:
    """Middle and size of the mesh: moments in these coordinates are of order one."""
    low, high = scalar.doflocs.min(axis=1), scalar.doflocs.max(axis=1)
    return (low + high) / 2.0, high - low


def _moments(x: np.ndarray, y: np.ndarray) -> list[np.ndarray]:
    """Mass, first and second moments, as functions of position."""
    return [np.ones_like(x), x, y, x * x, x * y, y * y]


def _exact_moments(scalar: Any) -> np.ndarray:
    from skfem.quadrature import get_quadrature

    middle, size = _frame(scalar)
    points, weights = get_quadrature(scalar.elem, 4)
    volumes = np.abs(scalar.mapping.detDF(points)) * weights
    x = (np.asarray(scalar.mapping.F(points)) - middle[:, None, None]) / size[:, None, None]
    return np.array([np.sum(moment * volumes) for moment in _moments(*x)])


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

for _lumping in (
    Lumping("exact", exact_inertia_masses),
    Lumping("row-sum", row_sum_masses, fault="the rotary inertia is overstated", row_sums=True),
):
    LUMPINGS.register(_lumping)
