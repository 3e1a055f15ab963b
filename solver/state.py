"""The record of a rigid motion, which the exact solution and the integrated one share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic

from solver.elementary import V

REACTIONS = ("drag", "none", "signed")


@dataclass(frozen=True)
class MotionState(Generic[V]):
    """The vehicle at an instant: floats, or arrays of one shape.

    X runs along the wall, forwards; Y away from it. Every field is signed.

    Attributes
    ----------
    t : float or ndarray
        Time since the start of Stage 2 [s].
    theta : float or ndarray
        Angle between the side and the wall [rad], falling to 0.
    omega : float or ndarray
        Angular velocity [rad/s], positive where theta falls (Eq 68 [1]_).
    v_gx, v_gy : float or ndarray
        Velocity of the centre of mass [m/s] (Eqs 70-71); v_gy < 0 is towards the wall.
    v_p : float or ndarray
        Velocity of the corner along the wall [m/s].
    slide : float or ndarray
        Displacement of the corner along the wall, s [m] (Eq 69).
    reaction_normal : float or ndarray
        Of the wall on the vehicle along Y [N]; negative: it pulls, as it does throughout.
    reaction_tangential : float or ndarray
        The same along X [N].
    kinetic_energy : float or ndarray
        Of translation and rotation [J].
    friction_work : float or ndarray
        Done on the vehicle since the start [J]; kinetic_energy - friction_work is constant.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307.
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
