"""Accelerations of the rigid body and their loads on the plate."""

from typing import NamedTuple

import numpy as np

from fem.laws import friction
from fem.model.plate_model import PlateModel
from fem.plate.properties import RigidStart


class RigidAccelerations(NamedTuple):
    """Accelerations of the rigid plate, and the reaction of the wall.

    corner [m/s^2], angular [rad/s^2]; normal and tangential reaction [N].
    """

    corner: float
    angular: float
    normal: float
    tangential: float


def to_global(angle: float) -> np.ndarray:
    """Return the matrix from the body frame to the wall's frame.

    The body is rotated clockwise by `angle` [rad].
    """
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, sine], [-sine, cosine]])


def at_corner(model: PlateModel, values: np.ndarray) -> np.ndarray:
    """Return the value of a nodal field at the corner.

    values: shape (2, nodes); the result has shape (2, 1).
    """
    corner = model.parameters.corner
    return np.asarray(values[:, corner.nodes] @ corner.weights)[:, None]


def corner_gap(model: PlateModel, normal: float) -> float:
    """Return the deflection [m] of the corner's constraint under a reaction [N]."""
    return -normal / model.parameters.corner.stiffness


def inertia_load(model: PlateModel, place: np.ndarray, start: RigidStart) -> tuple[np.ndarray, float]:
    """Return the loads of inertia and reaction [N], and the normal reaction.

    place: positions about the corner. The loads are in the body frame.
    """
    rigid = rigid_accelerations(model, place, start.angle, start.omega, start.corner_speed)
    turn, corner = to_global(start.angle), model.parameters.corner
    arm = turn @ place
    acceleration = rigid.angular * np.array([-arm[1], arm[0]]) - start.omega**2 * arm
    acceleration += [[rigid.corner], [0.0]]
    load = -model.parameters.mass * acceleration
    load[:, corner.nodes] += np.outer((rigid.tangential, rigid.normal), corner.weights)
    return turn.T @ load, rigid.normal


def rigid_accelerations(
    model: PlateModel, body: np.ndarray, angle: float, omega: float, speed: float
) -> RigidAccelerations:
    """Return the accelerations of the rigid plate on the wall.

    The masses are the model's own. With S the first moment and J the second about the corner: R = M a - S_y alpha -
    omega^2 S_x, N = S_x alpha - omega^2 S_y, 0 = J alpha - S_y a, and R = slope N by the friction law with N < 0.
    """
    masses = model.parameters.mass
    total, inertia = masses.sum(), masses @ (body**2).sum(axis=0)
    s_x, s_y = to_global(angle) @ (body @ masses)
    slope = friction.friction_slope(model.parameters.friction, speed)
    corner = omega**2 * (s_x - slope * s_y) / (total - s_y * (s_y + slope * s_x) / inertia)
    angular = s_y * corner / inertia
    normal = s_x * angular - omega**2 * s_y
    if not normal < 0.0:
        why = f"the initial reaction of the wall is {normal:g} N; Stage 2 requires tension (a negative reaction)"
        raise ValueError(why)
    return RigidAccelerations(corner, angular, normal, slope * normal)
