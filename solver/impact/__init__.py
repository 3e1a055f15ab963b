"""Whole impacts of rigid vehicles on a wall.

The wall only pushes; the impact includes all strikes, with crush law and friction.

The vehicle is a rectangle with its centre of mass on the long axis; the wall is the line Y = 0. Its corners, or
its strips in their place, follow a crush law (`CrushLaw`) and Coulomb's friction. One compiled scheme of second order
(`step`) serves `solve_impact` for one impact, `solve_impacts` for many, and `solve_trains` for vehicles joined by
hinges; each states its error. Signs are those of `solver.MotionState`; SI units and radians.
"""

from solver.impact.crush_law import CrushLaw
from solver.impact.many import Impacts, solve_impacts
from solver.impact.solve import ImpactMotion, solve_impact
from solver.impact.strikes import Strike, strikes_of
from solver.impact.strips import Strip, WallContact, awaited, group_names, outermost
from solver.impact.train import (
    HitchedVehicle,
    ImpactState,
    ImpactVehicle,
    Train,
    first_touch,
    stiffness_of_duration,
    train_of,
)
from solver.impact.trajectories import TOLERANCE, Trajectories, solve_trains
from solver.impact.tyres import TyreAxle

__all__ = [
    "TOLERANCE", "CrushLaw", "HitchedVehicle", "ImpactMotion", "ImpactState", "ImpactVehicle", "Impacts", "Strike",
    "Strip", "Train", "Trajectories", "TyreAxle", "WallContact", "awaited", "first_touch", "group_names", "outermost",
    "solve_impact", "solve_impacts", "solve_trains", "stiffness_of_duration", "strikes_of", "train_of",
]  # fmt: skip
