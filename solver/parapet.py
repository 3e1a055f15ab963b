"""Strength of a concrete parapet by formulas.

AASHTO LRFD A13.3.1 is the load of one yield-line mechanism, a V of lines that meet at the base, with one strength for
both signs: an upper bound of the flexural strength of the plate. Strengths of a section follow from the rectangular
stress block, without steel in compression. Moments are positive with tension on the traffic face.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver.conditions import RigidBodyError

__all__ = [
    "Resistance",
    "Strengths",
    "overhang_tension",
    "punching",
    "section_strengths",
    "yield_line_resistance",
]

Floats = NDArray[np.float64]

LINES = {"interior": 8.0, "end": 1.0}
"""Factor of M_b and M_w by the place of the load [-]."""

PUNCHING = (0.0633, 0.1265)
"""Factors of the shear strength of concrete on a perimeter, with forces in kip and lengths in inches."""

PSI_1000 = 6894757.293168
"""1 ksi [Pa]."""


class Resistance(NamedTuple):
    """Resistance of A13.3.1.

    critical_length: of the mechanism, L_c [m]. force: R_w [N].
    """

    critical_length: float
    force: float


class Strengths(NamedTuple):
    """Strengths of a wall, linear between levels.

    Attributes
    ----------
    levels : ndarray, shape (k,)
        Heights from the base to the top [m].
    moments : ndarray, shape (4, k)
        Along the wall with tension on the traffic face and on the back, then upright with both [N m/m].
    beam : float
        Strength of a beam along the top, M_b [N m].
    """

    levels: Floats
    moments: Floats
    beam: float = 0.0

    @property
    def height(self) -> float:
        """Height of the wall [m]."""
        return float(self.levels[-1])

    @property
    def wall(self) -> float:
        """M_w over the height, mean of both signs [N m]."""
        return float(np.trapezoid(self.moments[:2].mean(axis=0), self.levels))

    @property
    def base(self) -> float:
        """M_c with tension on the traffic face, mean over height [N m/m]."""
        return float(np.trapezoid(self.moments[2], self.levels)) / self.height

    def resistance(self, load_length: float, place: str) -> Resistance:
        """Return the resistance of A13.3.1, see `yield_line_resistance`."""
        return yield_line_resistance(self.height, self.beam, self.wall, self.base, load_length, place)


def yield_line_resistance(
    height: float, beam: float, wall: float, base: float, load_length: float, place: str
) -> Resistance:
    """Return critical length and resistance of a parapet.

    Parameters
    ----------
    height : float
        H of the wall [m].
    beam, wall : float
        M_b of a beam at the top beside the wall, and M_w about the vertical axis over the whole height [N m].
    base : float
        M_c about the longitudinal axis, mean over the height [N m/m].
    load_length : float
        L_t of the load at the top [m].
    place : str
        "interior", or "end" for the end of a wall or a joint.

    Returns
    -------
    Resistance
        L_c and R_w [1]_: L_c = L_t/2 + sqrt((L_t/2)^2 + k H (M_b + M_w)/M_c) and
        R_w = 2/(2 L_c - L_t) (k M_b + k M_w + M_c L_c^2/H), with k = 8 in the interior and 1 at an end.

    References
    ----------
    .. [1] AASHTO LRFD Bridge Design Specifications, Eqs A13.3.1-1 to A13.3.1-4.
    """
    lines = LINES[place] * (beam + wall)
    critical = 0.5 * load_length + math.sqrt(0.25 * load_length**2 + height * lines / base)
    return Resistance(critical, 2.0 / (2.0 * critical - load_length) * (lines + base * critical**2 / height))


def section_strengths(
    thickness: Sequence[tuple[float, float]],
    concrete: float,
    steel: float,
    cover: float,
    upright: tuple[float, float],
    along: tuple[float, float],
) -> Strengths:
    """Return the strengths of a reinforced section.

    Parameters
    ----------
    thickness : sequence of tuple
        Heights from the base to the top, and thicknesses there [m].
    concrete, steel : float
        Compressive strength of concrete and yield strength of steel [Pa].
    cover : float
        Distance of the bars' axes from their face [m].
    upright, along : tuple of float
        Areas of upright and of longitudinal bars per length, on the traffic face and on the back [m^2/m].

    Returns
    -------
    Strengths
        A f_y (d - a/2) with a = A f_y/(0.85 f_c), which is linear in the thickness.

    Raises
    ------
    RigidBodyError
        For a face without bars, and a section that is too thin for them.
    """
    levels, sizes = np.array(thickness, dtype=float).T
    rows = []
    for name, areas in (("horizontal_bars", along), ("vertical_bars", upright)):
        for area in areas:
            depth, block = sizes - cover, area * steel / (0.85 * concrete)
            if not 0.0 < block < depth.min():
                why = f"its stress block of {1e3 * block:.3g} mm is to end before the bars"
                allowed = f"positive areas with a block below the effective depth, {1e3 * depth.min():.3g} mm"
                raise RigidBodyError(name, f"{1e6 * area:g} mm^2/m", why, allowed)
            rows.append(area * steel * (depth - 0.5 * block))
    return Strengths(levels, np.array(rows))


def punching(concrete: float, depth: float, load_length: float, patch_height: float) -> float:
    """Return the punching strength at the top of a wall [N].

    Parameters
    ----------
    concrete : float
        Compressive strength [Pa].
    depth : float
        Effective depth at the load [m].
    load_length, patch_height : float
        Sides of the loaded patch [m].

    Returns
    -------
    float
        v_c b_0 d on three sides, b_0 = L_t + d + 2 (h + d/2), with v_c = (0.0633 + 0.1265/beta) sqrt(f_c), at most
        0.1265 sqrt(f_c) [ksi] [1]_.

    References
    ----------
    .. [1] AASHTO LRFD Bridge Design Specifications, Eq. A13.4.3.2-3, of posts on decks; Article 5.12.8.6.3 states the
       same for two-way action of footings, with the factors 0.063 and 0.126.
    """
    perimeter = load_length + depth + 2.0 * (patch_height + 0.5 * depth)
    ratio = max(load_length, patch_height) / min(load_length, patch_height)
    factor = min(PUNCHING[0] + PUNCHING[1] / ratio, PUNCHING[1])
    return factor * math.sqrt(concrete / PSI_1000) * PSI_1000 * perimeter * depth


def overhang_tension(force: float, critical_length: float, height: float) -> float:
    """Return the tension of the deck overhang per length [N/m].

    Parameters
    ----------
    force : float
        Resistance of the parapet, R_w [N].
    critical_length, height : float
        L_c of its mechanism, and H [m].

    Returns
    -------
    float
        T = R_w/(L_c + 2 H) [1]_, with the moment M_c at the base.

    References
    ----------
    .. [1] AASHTO LRFD Bridge Design Specifications, Eq. A13.4.2-1.
    """
    return force / (critical_length + 2.0 * height)
