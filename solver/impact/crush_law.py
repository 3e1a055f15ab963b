"""Crush law of a vehicle at the wall.

SI units.
"""

import math
from dataclasses import dataclass

from solver import rules
from solver.conditions import Gate, Number, number

LAW = ("stiffness", "initial_force", "plateau_force", "restitution", "unloading_stiffness", "hardening")
"""Parameters of a crush law, as those of `CrushLaw`."""


def demand_law(
    stiffness: Number,
    initial_force: Number,
    plateau: Number,
    restitution: Number,
    unloading: Number,
    hardening: Number,
) -> None:
    """Require possible values of crush laws."""
    gate, e = Gate(), restitution
    gate.positive(rules.STIFFNESS, stiffness)
    gate.not_negative(rules.INITIAL_FORCE, initial_force)
    gate.demand(rules.PLATEAU, (plateau > 0.0) & (plateau >= initial_force), plateau, initial=initial_force)
    gate.demand(rules.RETURNED, (e >= 0.0) & (e <= 1.0), e)
    bilinear = (initial_force == 0.0) & (plateau == math.inf)
    gate.demand(rules.LINE, bilinear | (2.0 * e * e <= 1.0 + 1e-12), e)
    steep = (unloading == 0.0) | ((unloading >= stiffness) & (unloading < math.inf))
    gate.demand(rules.UNLOADING, steep, unloading, stiffness=stiffness)
    gate.demand(rules.ONE_UNLOADING, (unloading == 0.0) | (e == 0.0), unloading)
    rising = (hardening == 0.0) | ((hardening > 0.0) & (hardening <= stiffness) & (plateau < math.inf))
    gate.demand(rules.HARDENING, rising, hardening, stiffness=stiffness)


@dataclass(frozen=True)
class CrushLaw:
    """Force over crush, of a point or per metre of a line.

    Loading follows F0 + k d up to the plateau Fy, then Fy + k2 (d - (Fy - F0)/k). From the greatest crush D the force
    falls along a straight line, which reloading follows up to D. The line returns e^2 of the absorbed energy W, and
    ends at the permanent crush D - 2 e^2 W/F(D); with a slope k_u it ends at D - F(D)/k_u, or at 0 if that is negative.

    Parameters
    ----------
    stiffness : float or ndarray
        k [N/m], or per metre of line [N/m^2].
    initial_force : float or ndarray
        F0 [N], or per metre of line [N/m].
    restitution : float or ndarray
        e [-]; 0 beside an unloading stiffness.
    plateau_force : float or ndarray
        Fy [N], or per metre of line [N/m]; infinite for none.
    unloading_stiffness : float or ndarray
        k_u [N/m], or per metre of line [N/m^2]; 0: defined by the restitution.
    hardening : float or ndarray
        k2 [N/m], or per metre of line [N/m^2]; 0: the plateau is level.

    Raises
    ------
    RigidBodyError
        Unless the stiffness is positive and finite, the initial force 0 or more and finite, the plateau no less than
        it, the restitution from 0 to 1, the unloading stiffness, if any, no less than the stiffness and beside no
        restitution, and the hardening from 0 to the stiffness, beside a plateau. With an initial force or a plateau the
        restitution is at most sqrt(1/2): a line beyond that would end in front of the wall.
    """

    stiffness: Number
    initial_force: Number = 0.0
    restitution: Number = 0.0
    plateau_force: Number = math.inf
    unloading_stiffness: Number = 0.0
    hardening: Number = 0.0

    def __post_init__(self) -> None:
        demand_law(*(number(name, getattr(self, name)) for name in LAW))
