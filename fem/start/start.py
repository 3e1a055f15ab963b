"""The state a run starts from: which quantities of the rigid body it keeps is part of the answer of a soft plate.

`inertia-relief`: the quasi-static elastic state that belongs to the plate's rigid acceleration, with the corner's
spring already carrying the reaction, and the slow change of both in the velocity. Keeps the spin and the corner's
speed; the centre, which the deformation has moved, begins with another momentum than the rigid body's.
`inertia-relief-momenta`: the same state with the rigid body's linear momentum, along and across the wall; spin and
speed of the corner follow, since it stays on the wall.
`unstressed`: the unstrained plate with a rigid-body velocity. Keeps all of them, and rings: the reaction, to several
times its size.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fem.contact.corner import Drag, Exact, Signed
from fem.discretisation.model import PlateModel
from fem.start.elastic import elastic_solver, rigid_motions


class TooSoftError(ValueError):
    """The plate has no quasi-static elastic state: it finds no equilibrium under its reaction."""


@dataclass(frozen=True)
class RigidStart:
    """Angle of side PE to the wall [rad], spin [rad/s] closing it, speed of the corner along the wall [m/s]."""

    angle: float
    omega: float
    corner_speed: float


SMALL = 1e-5
"""Elastic displacement over the plate's length below which what is not linear in it is rounding."""

FOLLOWS = 0.1
"""Lag by damping over the elastic displacement up to which the plate is taken to follow its loads with that lag."""

CORRECTIONS = 2
"""Times that the elastic state is found for the spin that the momentum asks for; each leaves the give's share."""


class ElasticFields(NamedTuple):
    """A start by inertia relief beside the corner's rigid motion: elastic displacement [m] and its rate [m/s] in the
    body frame, shape (2, nodes), both zero at the corner; the corner's gap [m] and its rate [m/s]."""

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
    return _placed(KINDS[kind](model, start, body), start, body)


def _placed(fields: tuple[Any, ...], start: RigidStart, body: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities in the wall's frame of a plate with these fields beside the rigid motion."""
    elastic, rate, gap, gap_rate = fields[:4]
    spin, speed = fields[4:] or (start.omega, start.corner_speed)
    turn = to_global(start.angle)
    arm = turn @ (body + elastic)
    positions = arm + np.array([[0.0], [gap]])
    velocities = turn @ rate + spin * np.array([-arm[1], arm[0]])
    velocities += np.array([[speed], [gap_rate]])
    return positions, velocities


def elastic_give(model: PlateModel, start: RigidStart) -> float:
    """How far [m] the reaction at the start moves the centre of mass towards the wall, by the plate's flexibility."""
    fields = relieved_fields(model, start)
    moved = (to_global(start.angle) @ fields.elastic)[1] + fields.gap
    return -float(model.loop.mass @ moved / model.mass)


def damping_lag(model: PlateModel, start: RigidStart) -> float:
    """How far [m] the damping of elastic velocities holds back the corner in the slow change of the elastic state."""
    behind = _held_back(model, relieved_fields(model, start).rate)
    return float(np.abs(_at_corner(model, behind)).max())


def elastic_energy(model: PlateModel, start: RigidStart) -> float:
    """Energy [J] of the elastic state at the start by inertia relief, the corner's spring included."""
    fields = relieved_fields(model, start)
    displacement = fields.elastic.ravel()
    spring = getattr(model.loop.corner.hold, "stiffness", 0.0)
    return float(0.5 * (displacement @ (model.stiffness @ displacement) + spring * fields.gap**2))


def relieved_fields(model: PlateModel, start: RigidStart) -> ElasticFields:
    """The start by inertia relief in the body frame."""
    body = model.discretisation.positions - _at_corner(model, model.discretisation.positions)
    solve = elastic_solver(model.stiffness, model.loop.mass, body)
    return _changing(model, start, body, lambda *now: _elastic(model, solve, body, *now))


def to_global(angle: float) -> np.ndarray:
    """Matrix from the body frame to the wall's frame, with the body turned clockwise by `angle`."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, sine], [-sine, cosine]])


def _unstressed(model: PlateModel, start: RigidStart, body: np.ndarray) -> Any:
    return np.zeros_like(body), np.zeros_like(body), 0.0, 0.0


def _relieved(model: PlateModel, start: RigidStart, body: np.ndarray) -> ElasticFields:
    """The fields of inertia relief; of a plate that gives visibly, in equilibrium on its deformed shape."""
    fields = linear = relieved_fields(model, start)

    def at(angle: float, omega: float, speed: float) -> tuple[np.ndarray, float]:
        return _in_equilibrium(model, body, linear, RigidStart(angle, omega, speed))

    if np.abs(linear.elastic).max() >= SMALL * np.ptp(body):
        fields = _changing(model, start, body, at)
    behind = _held_back(model, fields.rate)
    behind = behind - _at_corner(model, behind)
    if np.abs(behind).max() > FOLLOWS * np.abs(fields.elastic).max():
        return fields  # it is damped too strongly to follow its loads
    return fields._replace(elastic=fields.elastic + behind)


def _held_back(model: PlateModel, rate: np.ndarray) -> np.ndarray:
    """Displacement [m] by which the damping of elastic velocities makes the elastic state lag behind, free of rigid
    motion, shape (2, nodes); rate: of the elastic state [m/s], body frame."""
    damping = model.loop.elastic_damping
    if damping is None:
        return np.zeros_like(rate)
    masses, positions = model.loop.mass, model.discretisation.positions
    rigid = rigid_motions(positions - (positions @ masses / masses.sum())[:, None])
    weighted = rigid * np.tile(masses, 2)[:, None]
    elastic = rate.ravel() - rigid @ np.linalg.solve(rigid.T @ weighted, weighted.T @ rate.ravel())
    load = -damping.rate * np.tile(masses, 2) * elastic
    return elastic_solver(model.stiffness, masses, positions)(load).reshape(2, -1)


def _changing(
    model: PlateModel,
    start: RigidStart,
    body: np.ndarray,
    at: Callable[[float, float, float], tuple[np.ndarray, float]],
) -> ElasticFields:
    """The fields of a state that follows angle, spin and corner speed: `at` gives displacement and gap for them."""
    now = _rigid_accelerations(model, body, start.angle, start.omega, start.corner_speed)
    span = 1e-3 * start.angle / start.omega  # a thousandth of the motion: its change is linear over that

    def after(time: float) -> tuple[np.ndarray, float]:
        angle = start.angle - start.omega * time - 0.5 * now.angular * time**2
        return at(angle, start.omega + now.angular * time, start.corner_speed)

    (elastic, gap), (late, late_gap), (early, early_gap) = after(0.0), after(span), after(-span)
    return ElasticFields(elastic, (late - early) / (2.0 * span), gap, (late_gap - early_gap) / (2.0 * span))


def _relieved_with_momenta(model: PlateModel, start: RigidStart, body: np.ndarray) -> Any:
    """The fields of inertia relief, and the spin [rad/s] and corner speed [m/s] that give the rigid body's momentum.

    The elastic state goes with the spin that it is to have, and is found again for it.
    """
    share, turn = model.loop.mass / model.mass, to_global(start.angle)
    arm = turn @ (body @ share)
    wanted = np.array([start.corner_speed - start.omega * arm[1], start.omega * arm[0]])
    kept = start
    for _ in range(CORRECTIONS):
        fields = _relieved(model, kept, body)
        elastic, rate, _, gap_rate = fields
        arm, drift = turn @ ((body + elastic) @ share), turn @ (rate @ share)
        spin = (wanted[1] - drift[1] - gap_rate) / arm[0]
        kept = RigidStart(start.angle, float(spin), float(wanted[0] - drift[0] + spin * arm[1]))
    return (*fields, kept.omega, kept.corner_speed)


KINDS: dict[str, Callable[..., Any]] = {
    "inertia-relief": _relieved,
    "inertia-relief-momenta": _relieved_with_momenta,
    "unstressed": _unstressed,
}
"""Kinds of start, by name."""


def _elastic(
    model: PlateModel, solve: Any, body: np.ndarray, angle: float, omega: float, speed: float
) -> tuple[np.ndarray, float]:
    """Elastic displacement relative to the corner [m], body frame, and the corner's gap [m]; linear."""
    load, normal = _load(model, body, RigidStart(angle, omega, speed))
    displacement = solve(load.ravel()).reshape(2, -1)
    return displacement - _at_corner(model, displacement), _gap(model, normal)


def _in_equilibrium(
    model: PlateModel, body: np.ndarray, linear: ElasticFields, start: RigidStart
) -> tuple[np.ndarray, float]:
    """The same in equilibrium on the deformed shape, its best rigid rotation none. Raises TooSoftError."""
    from fem.start.finite_strain import equilibrium

    def load_at(place: np.ndarray) -> np.ndarray:
        return _load(model, place - _at_corner(model, place), start)[0]

    try:
        place = equilibrium(model, body + linear.elastic, load_at)
    except ValueError as error:  # Newton's method fails, or on its way the wall's reaction pushes
        raise TooSoftError(str(error)) from None
    place = _unturned(model, body, place - _at_corner(model, place))
    return place - body, _gap(model, _load(model, place, start)[1])


def _unturned(model: PlateModel, body: np.ndarray, place: np.ndarray) -> np.ndarray:
    """The positions turned about the corner so that the body fits them best without a rotation."""
    share = model.loop.mass / model.mass
    x, y = place - (place @ share)[:, None]
    r_x, r_y = (body - (body @ share)[:, None]) * share
    turned = np.arctan2((r_x * y - r_y * x).sum(), (r_x * x + r_y * y).sum())
    return to_global(float(turned)) @ place


def _load(model: PlateModel, place: np.ndarray, start: RigidStart) -> tuple[np.ndarray, float]:
    """Inertia and reaction on a plate at these positions about the corner [N], body frame, and the normal reaction."""
    rigid = _rigid_accelerations(model, place, start.angle, start.omega, start.corner_speed)
    turn, corner = to_global(start.angle), model.loop.corner
    arm = turn @ place
    acceleration = (
        rigid.angular * np.array([-arm[1], arm[0]]) - start.omega**2 * arm + [[rigid.corner], [0.0]]
    )
    load = -model.loop.mass * acceleration
    load[:, corner.nodes] += np.outer((rigid.tangential, rigid.normal), corner.weights)
    return turn.T @ load, rigid.normal


def _gap(model: PlateModel, normal: float) -> float:
    """Deflection [m] of the corner's hold under this reaction [N]."""
    hold = model.loop.corner.hold
    return 0.0 if isinstance(hold, Exact) else -normal / hold.stiffness


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
