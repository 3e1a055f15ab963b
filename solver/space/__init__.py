"""Vehicles in space that strike a wall, with roll and pitch."""

from solver.space.solve import (
    OUTCOMES,
    SpaceAnswers,
    SpaceMotion,
    lowest_walls,
    solve_space,
    solve_spaces,
)
from solver.space.vehicle import SpaceAxle, SpaceStrip, SpaceUnit, SpaceVehicle, SpaceWall
from solver.space.wall import PROFILES, profile_points

__all__ = [
    "OUTCOMES",
    "PROFILES",
    "SpaceAnswers",
    "SpaceAxle",
    "SpaceMotion",
    "SpaceStrip",
    "SpaceUnit",
    "SpaceVehicle",
    "SpaceWall",
    "lowest_walls",
    "profile_points",
    "solve_space",
    "solve_spaces",
]  # fmt: skip
