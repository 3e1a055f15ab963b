"""The record of a rigid motion, which the exact solution and the integrated one share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic

from solver.elementary import V

REACTIONS = ("drag", "none", "signed")


@dataclass(frozen=True)
class MotionState(Generic[V]):
    """The vehicle at an instant: floats, or arrays of one shape. SI, radians.

    X runs along the wall, forwards; Y away from it. Every field is signed.

    t: since the start of Stage 2 [s]. theta: between the side and the wall [rad], falling to 0.
    omega: angular velocity [rad/s], positive where theta falls (Eq 68).
    v_gx, v_gy: of the centre of mass [m/s] (Eqs 70-71); v_gy < 0 is towards the wall.
    v_p: of the corner along the wall [m/s]; slide: its displacement, s [m] (Eq 69).
    reaction_normal: of the wall on the vehicle along Y [N]; negative: it pulls, as it does throughout.
    reaction_tangential: the same along X [N].
    kinetic_energy: of translation and rotation [J].
    friction_work: done on the vehicle since the start [J]; kinetic_energy - friction_work is constant.
    """

    t: V
    theta: V
    omega: V
    v_gx: V
    v_gy: V
    v_p: V
    slide: V
    reaction_normal: V
    reaction_tangential: V
    kinetic_energy: V
    friction_work: V
