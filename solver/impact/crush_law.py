"""Contact laws of a vehicle and the wall.

SI units.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from solver import rules
from solver.conditions import Gate, Number, one

LAW = ("stiffness", "initial_force", "plateau_force", "restitution", "unloading_stiffness")
"""Parameters of a crush law, as those of `CrushLaw`."""

DEFAULTS = {"initial_force": 0.0, "plateau_force": math.inf, "restitution": 0.0, "unloading_stiffness": 0.0}
"""Values of omitted parameters."""

SIDE_POINTS = 64  # Gauss points of a layer along each half of a side


def demand_law(
    stiffness: Number, initial_force: Number, plateau: Number, restitution: Number, unloading: Number
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


@dataclass(frozen=True)
class CrushLaw:
    """Force over crush, of a corner or per metre of side.

    Loading follows F0 + k d up to the plateau Fy. From the greatest crush D the force falls along a straight line,
    which reloading follows up to D. The line returns e^2 of the absorbed energy W, and ends at the permanent crush
    D - 2 e^2 W/F(D); with a slope k_u it ends at D - F(D)/k_u, or at 0 if that is negative.

    Parameters
    ----------
    stiffness : float
        k [N/m], or per metre of side [N/m^2].
    initial_force : float
        F0 [N], or per metre of side [N/m].
    restitution : float
        e [-]; 0 beside an unloading stiffness.
    plateau_force : float
        Fy [N], or per metre of side [N/m]; infinite for none.
    unloading_stiffness : float
        k_u [N/m], or per metre of side [N/m^2]; 0: defined by the restitution.

    Raises
    ------
    RigidBodyError
        Unless the stiffness is positive and finite, the initial force 0 or more and finite, the plateau no less than
        it, the restitution from 0 to 1, and the unloading stiffness, if any, no less than the stiffness and beside no
        restitution. With an initial force or a plateau the restitution is at most sqrt(1/2): a line beyond that would
        end in front of the wall.
    """

    stiffness: float
    initial_force: float = 0.0
    restitution: float = 0.0
    plateau_force: float = math.inf
    unloading_stiffness: float = 0.0

    def __post_init__(self) -> None:
        demand_law(*(one(name, getattr(self, name)) for name in LAW))


def unit_laws(units: Sequence[Mapping[str, Any]]) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Return the crush of front and rear corners of each unit.

    units: values of each by the names in `LAW`, and under "rear" those that differ there; None: omitted. Omitted values
    of a trailer are those of the first unit, at its rear those of the first unit's rear. Restitution and unloading
    stiffness replace each other.
    """
    first, *trailers = units
    front = _overlaid(DEFAULTS, first)
    both = [(front, _overlaid(front, first.get("rear")))]
    for unit in trailers:
        before, behind = (_overlaid(law, unit) for law in both[0])
        both.append((before, _overlaid(behind, unit.get("rear"))))
    return both


def _overlaid(law: Mapping[str, Any], changes: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return a law with these values replaced."""
    values = {key: (changes or {}).get(key) for key in LAW}
    values = {key: value for key, value in values.items() if value is not None}
    unloading = set(values) & {"restitution", "unloading_stiffness"}
    cleared = {"restitution": 0.0, "unloading_stiffness": 0.0} if unloading else {}
    return {**law, **cleared, **values}


@dataclass(frozen=True)
class WallContact:
    """Laws of the vehicle's contact with the wall.

    Parameters
    ----------
    crush : CrushLaw
        Crush of each corner.
    friction : float
        Coulomb's coefficient mu [-].
    side : CrushLaw or None
        Crush of a layer along the four sides, per metre of side; None: only the corners touch.
    side_points : int
        Gauss points of the layer along each half of a side.
    rear : CrushLaw or None
        Crush of the rear corners; None: that of the front corners.

    Raises
    ------
    RigidBodyError
        Unless the friction is 0 or more and finite, and there is a point.
    """

    crush: CrushLaw
    friction: float
    side: CrushLaw | None = None
    side_points: int = SIDE_POINTS
    rear: CrushLaw | None = None

    def __post_init__(self) -> None:
        friction = one("friction", self.friction)
        Gate().not_negative(rules.FRICTION, friction)
        Gate().demand(rules.POINTS, self.side_points >= 1, self.side_points)
