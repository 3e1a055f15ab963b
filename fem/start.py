"""The state a run starts from.

`sudden`: the unstrained plate with a rigid-body velocity. The reaction then rings to several times its size.
`quiet`: the quasi-static elastic state that belongs to the plate's rigid acceleration (inertia relief), with
the corner's spring already carrying the reaction, and the slow change of both in the velocity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fem.corner import Drag, Exact, Signed
from fem.elastic import elastic_solver
from fem.model import PlateModel


@dataclass(frozen=True)
class RigidStart:
    """Angle of side PE to the wall [rad], spin [rad/s] closing it, speed of the corner along the wall [m/s]."""

    angle: float
    omega: float
    corner_speed: float


class QuietFields(NamedTuple):
    """A quiet start beside the corner's rigid motion: elastic displacement [m] and its rate [m/s] in the body frame,
    shape (2, nodes), both zero at the corner; the corner's gap [m] and its rate [m/s]."""

    elastic: np.ndarray
    rate: np.ndarray
    gap: float
    gap_rate: float


class _Rigid(NamedTuple):
    """Rigid accelerations: corner [m/s^2], angular [rad/s^2]; reaction, normal and tangential [N]."""

    corner: float
    angular: float
    normal: float
    tangential: float


def start_fields(model: PlateModel, start: RigidStart, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m] and velocities [m/s] at t = 0, both of shape (2, nodes)."""
    body = model.discretisation.positions - _at_corner(model, model.discretisation.positions)
    elastic, rate, gap, gap_rate = KINDS[kind](model, start, body)
    turn = to_global(start.angle)
    arm = turn @ (body + elastic)
    positions = arm + np.array([[0.0], [gap]])
    velocities = turn @ rate + start.omega * np.array([-arm[1], arm[0]])
    velocities += np.array([[start.corner_speed], [gap_rate]])
    return positions, velocities


def elastic_give(model: PlateModel, start: RigidStart) -> float:
    """How far [m] the reaction at the start moves the centre of mass towards the wall, by the plate's flexibility."""
    quiet, sudden = (start_fields(model, start, kind)[0] for kind in ("quiet", "sudden"))
    return float(model.loop.mass @ (sudden - quiet)[1] / model.mass)


def quiet_fields(model: PlateModel, start: RigidStart) -> QuietFields:
    """The quiet start in the body frame."""
    body = model.discretisation.positions - _at_corner(model, model.discretisation.positions)
    return QuietFields(*_quiet(model, start, body))


def to_global(angle: float) -> np.ndarray:
    """Matrix from the body frame to the wall's frame, with the body turned clockwise by `angle`."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, sine], [-sine, cosine]])


def _sudden(model: PlateModel, start: RigidStart, body: np.ndarray) -> Any:
    return np.zeros_like(body), np.zeros_like(body), 0.0, 0.0


def _quiet(model: PlateModel, start: RigidStart, body: np.ndarray) -> Any:
    solve = elastic_solver(model.stiffness, model.loop.mass, body)
    now = _rigid_accelerations(model, body, start.angle, start.omega, start.corner_speed)
    span = 1e-3 * start.angle / start.omega  # a thousandth of the motion: its change is linear over that

    def at(time: float) -> tuple[np.ndarray, float]:
        angle = start.angle - start.omega * time - 0.5 * now.angular * time**2
        return _elastic(model, solve, body, angle, start.omega + now.angular * time, start.corner_speed)

    (elastic, gap), (late, late_gap), (early, early_gap) = at(0.0), at(span), at(-span)
    return elastic, (late - early) / (2.0 * span), gap, (late_gap - early_gap) / (2.0 * span)


KINDS: dict[str, Callable[..., Any]] = {"quiet": _quiet, "sudden": _sudden}
"""Kinds of start, by name."""


def _elastic(
    model: PlateModel, solve: Any, body: np.ndarray, angle: float, omega: float, speed: float
) -> tuple[np.ndarray, float]:
    """Elastic displacement relative to the corner [m], body frame, and the corner's gap [m]."""
    rigid = _rigid_accelerations(model, body, angle, omega, speed)
    turn, corner = to_global(angle), model.loop.corner
    arm = turn @ body
    acceleration = rigid.angular * np.array([-arm[1], arm[0]]) - omega**2 * arm + [[rigid.corner], [0.0]]
    load = -model.loop.mass * acceleration
    load[:, corner.nodes] += np.outer((rigid.tangential, rigid.normal), corner.weights)
    displacement = solve((turn.T @ load).ravel()).reshape(2, -1)
    gap = 0.0 if isinstance(corner.hold, Exact) else -rigid.normal / corner.hold.stiffness
    return displacement - _at_corner(model, displacement), gap


def _at_corner(model: PlateModel, values: np.ndarray) -> np.ndarray:
    """Value at the corner of a nodal field of shape (2, nodes), shape (2, 1)."""
    corner = model.loop.corner
    return np.asarray(values[:, corner.nodes] @ corner.weights)[:, None]


def _rigid_accelerations(
    model: PlateModel, body: np.ndarray, angle: float, omega: float, speed: float
) -> _Rigid:
    """Accelerations of the rigid plate with the model's own masses, its corner held on the wall.

    With S the first moment and J the second about the corner: R = M a - S_y alpha - omega^2 S_x,
    N = S_x alpha - omega^2 S_y, 0 = J alpha - S_y a, and R = slope N by the friction law with N < 0.
    """
    masses = model.loop.mass
    total, inertia = masses.sum(), masses @ (body**2).sum(axis=0)
    s_x, s_y = to_global(angle) @ (body @ masses)
    slope = friction_slope(model.loop.friction, speed)
    corner = omega**2 * (s_x - slope * s_y) / (total - s_y * (s_y + slope * s_x) / inertia)
    angular = s_y * corner / inertia
    normal = s_x * angular - omega**2 * s_y
    if not normal < 0.0:
        raise ValueError(
            f"the wall's reaction at the start is {normal:g} N, but Stage 2 needs one that pulls"
        )
    return _Rigid(corner, angular, normal, slope * normal)


def friction_slope(friction: Any, speed: float) -> float:
    """Tangential force per normal force while the reaction pulls."""
    if isinstance(friction, Drag):
        return friction.coefficient * np.sign(speed)
    if isinstance(friction, Signed):
        return -friction.coefficient * np.sign(speed)
    return 0.0
