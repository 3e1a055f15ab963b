"""Rigid-body theory of vehicles that strike a wall.

Impulse, sliding rotation and tail-slap after B. Chuong and R. B. Malla, Infrastructures 2025, 10(11), 307; equation
numbers are the paper's. SI units and radians. NumPy alone is imported; `integrate_odes` imports SciPy when it is
called.
"""

from solver.body import REACTIONS, MotionState, RectangularBody
from solver.conditions import RigidBodyError
from solver.motion import PlaneMotion, plane_motion, tail_slap
from solver.odes import OdeMotion, integrate_odes
from solver.stage_1 import CONVENTIONS, ImpulseResult, corner_impulse
from solver.stage_3 import (
    OlsonForce,
    RitterForce,
    StrikeForce,
    hirsch_force,
    olson_force,
    ritter_force,
    strike_force,
    triangle_mean,
)

__all__ = [
    "CONVENTIONS", "REACTIONS", "ImpulseResult", "MotionState", "OdeMotion", "OlsonForce", "PlaneMotion",
    "RectangularBody", "RigidBodyError", "RitterForce", "StrikeForce", "corner_impulse", "hirsch_force",
    "integrate_odes", "olson_force", "plane_motion", "ritter_force", "strike_force", "tail_slap",
    "triangle_mean",
]  # fmt: skip
