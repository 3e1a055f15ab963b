"""Vehicles in space that strike a wall, with roll and pitch."""

from solver.space.motion import UNDECIDED, SpaceMotion, lowest_wall, solve_space
from solver.space.solve import OUTCOMES, SpaceAnswers, solve_spaces
from solver.space.vehicle import SpaceAxle, SpaceStrip, SpaceUnit, SpaceVehicle, SpaceWall
from solver.space.wall import PROFILES, profile_points

__all__ = [
    "OUTCOMES",
    "PROFILES",
    "UNDECIDED",
    "SpaceAnswers",
    "SpaceAxle",
    "SpaceMotion",
    "SpaceStrip",
    "SpaceUnit",
    "SpaceVehicle",
    "SpaceWall",
    "lowest_wall",
    "profile_points",
    "solve_space",
    "solve_spaces",
]  # fmt: skip
