"""The rigid body that a plate starts from: its motion, its accelerations, and the loads that go with them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fem.laws import friction
from fem.model.plate_model import PlateModel


@dataclass(frozen=True)
class RigidStart:
    """Motion of the rigid body at t = 0.

    Attributes
    ----------
    angle : float
        Of side PE to the wall [rad].
    omega : float
        Spin that closes it [rad/s].
    corner_speed : float
        Of the corner along the wall [m/s].
    """

    angle: float
    omega: float
    corner_speed: float


class RigidAccelerations(NamedTuple):
    """Rigid accelerations: corner [m/s^2], angular [rad/s^2]; reaction, normal and tangential [N]."""

    corner: float
    angular: float
    normal: float
    tangential: float


def to_global(angle: float) -> np.ndarray:
    """Matrix from the body frame to the wall's frame, with the body turned clockwise by `angle`."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, sine], [-sine, cosine]])


def at_corner(model: PlateModel, values: np.ndarray) -> np.ndarray:
    """Value at the corner of a nodal field of shape (2, nodes), shape (2, 1)."""
    corner = model.loop.corner
    return np.asarray(values[:, corner.nodes] @ corner.weights)[:, None]


def corner_gap(model: PlateModel, normal: float) -> float:
    """Deflection [m] of the corner's constraint under this reaction [N]."""
    return -normal / model.loop.corner.stiffness


def inertia_load(model: PlateModel, place: np.ndarray, start: RigidStart) -> tuple[np.ndarray, float]:
    """Inertia and reaction on a plate at these positions about the corner [N], body frame, and the normal reaction."""
    rigid = rigid_accelerations(model, place, start.angle, start.omega, start.corner_speed)
    turn, corner = to_global(start.angle), model.loop.corner
    arm = turn @ place
    acceleration = (
        rigid.angular * np.array([-arm[1], arm[0]]) - start.omega**2 * arm + [[rigid.corner], [0.0]]
    )
    load = -model.loop.mass * acceleration
    load[:, corner.nodes] += np.outer((rigid.tangential, rigid.normal), corner.weights)
    return turn.T @ load, rigid.normal


def rigid_accelerations(
    model: PlateModel, body: np.ndarray, angle: float, omega: float, speed: float
) -> RigidAccelerations:
    """Accelerations of the rigid plate with the model's own masses, its corner kept on the wall.

    With S the first moment and J the second about the corner: R = M a - S_y alpha - omega^2 S_x,
    N = S_x alpha - omega^2 S_y, 0 = J alpha - S_y a, and R = slope N by the friction law with N < 0.
    """
    masses = model.loop.mass
    total, inertia = masses.sum(), masses @ (body**2).sum(axis=0)
    s_x, s_y = to_global(angle) @ (body @ masses)
    slope = friction.friction_slope(model.loop.friction, speed)
    corner = omega**2 * (s_x - slope * s_y) / (total - s_y * (s_y + slope * s_x) / inertia)
    angular = s_y * corner / inertia
    normal = s_x * angular - omega**2 * s_y
    if not normal < 0.0:
        raise ValueError(
            f"the wall's reaction at the start is {normal:g} N, but Stage 2 needs one that pulls"
        )
    return RigidAccelerations(corner, angular, normal, slope * normal)
