"""The whole impact of a rigid vehicle on a wall that only pushes: crush law, friction, all strikes.

The vehicle is a rectangle with its centre of mass on the long axis; the wall is the line Y = 0. Its corners, and a
layer along its sides, follow a crush law (`CrushLaw`) and Coulomb's friction with true stick and slip. `solve_impact`
integrates one impact from event to event, `solve_impacts` many at once with a fixed step. Signs are those of
`solver.MotionState`; SI units and radians.
"""

from solver.impact.contact import CORNERS, ContactPoints, WallContact, contact_points
from solver.impact.crush_law import CrushLaw
from solver.impact.many import Impacts, solve_impacts
from solver.impact.motion import ImpactMotion, solve_impact
from solver.impact.record import ImpactRecord, PointRecord
from solver.impact.strike import Strike, strikes_of
from solver.impact.vehicle import ImpactState, ImpactVehicle, first_touch

__all__ = [
    "CORNERS",
    "ContactPoints",
    "CrushLaw",
    "ImpactMotion",
    "ImpactRecord",
    "ImpactState",
    "ImpactVehicle",
    "Impacts",
    "PointRecord",
    "Strike",
    "WallContact",
    "contact_points",
    "first_touch",
    "solve_impact",
    "solve_impacts",
    "strikes_of",
]
