"""Inertia relief: the quasi-static elastic state that belongs to the plate's rigid acceleration, with the corner's
constraint already carrying the reaction, and the slow change of both; and what it says by statics alone: deflection,
lag by damping, energy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fem.model.plate_model import PlateModel
from fem.plate.elastic import without_rigid_motion
from fem.start import rigid_state


class TooSoftError(ValueError):
    """The plate has no quasi-static elastic state: it finds no equilibrium under its reaction."""


SMALL = 1e-5
"""Elastic displacement over the plate's length below which what is not linear in it is rounding."""

FOLLOWS = 0.1
"""Lag by damping over the elastic displacement up to which the plate is taken to follow its loads with that lag."""

CORRECTIONS = 2
"""Times that the elastic state is found for the spin that the momentum asks for; each leaves the deflection ratio of
its error."""


class ElasticFields(NamedTuple):
    """A start by inertia relief beside the corner's rigid motion: elastic displacement [m] and its rate [m/s] in the
    body frame, shape (2, nodes), both zero at the corner; the corner's gap [m] and its rate [m/s]."""

    elastic: np.ndarray
    rate: np.ndarray
    gap: float
    gap_rate: float


def relieved_fields(model: PlateModel, start: rigid_state.RigidStart) -> ElasticFields:
    """The start by inertia relief in the body frame: linear, so that the change of the load gives the rate."""
    body = model.discretisation.positions - rigid_state.at_corner(model, model.discretisation.positions)

    def load_at(now: rigid_state.RigidStart) -> tuple[np.ndarray, float]:
        return rigid_state.inertia_load(model, body, now)

    (load, normal), (rate, normal_rate) = _and_rate(model, start, body, load_at)
    elastic, changing = (_displaced(model, each) for each in (load, rate))
    return ElasticFields(
        elastic, changing, rigid_state.corner_gap(model, normal), rigid_state.corner_gap(model, normal_rate)
    )


def relieved_displacement(model: PlateModel, start: rigid_state.RigidStart) -> tuple[np.ndarray, float]:
    """Elastic displacement and the corner's gap of `relieved_fields` [m], without their rates."""
    body = model.discretisation.positions - rigid_state.at_corner(model, model.discretisation.positions)
    load, normal = rigid_state.inertia_load(model, body, start)
    return _displaced(model, load), rigid_state.corner_gap(model, normal)


def relieved(model: PlateModel, start: rigid_state.RigidStart, body: np.ndarray) -> ElasticFields:
    """The fields of inertia relief; of a plate that deforms visibly, in equilibrium on its deformed shape."""
    fields = linear = relieved_fields(model, start)

    def at(now: rigid_state.RigidStart) -> tuple[np.ndarray, float]:
        return _in_equilibrium(model, body, linear, now)

    if np.abs(linear.elastic).max() >= SMALL * np.ptp(body):
        (elastic, gap), (rate, gap_rate) = _and_rate(model, start, body, at)
        fields = ElasticFields(elastic, rate, gap, gap_rate)
    behind = lag_by_damping(model, fields.rate)
    behind = behind - rigid_state.at_corner(model, behind)
    if np.abs(behind).max() > FOLLOWS * np.abs(fields.elastic).max():
        return fields  # it is damped too strongly to follow its loads
    return fields._replace(elastic=fields.elastic + behind)


def relieved_with_momenta(model: PlateModel, start: rigid_state.RigidStart, body: np.ndarray) -> Any:
    """The fields of inertia relief, and the spin [rad/s] and corner speed [m/s] that give the rigid body's momentum.

    The elastic state goes with the spin that it is to have, and is found again for it.
    """
    fraction, turn = model.loop.mass / model.mass, rigid_state.to_global(start.angle)
    arm = turn @ (body @ fraction)
    wanted = np.array([start.corner_speed - start.omega * arm[1], start.omega * arm[0]])
    kept = start
    for _ in range(CORRECTIONS):
        fields = relieved(model, kept, body)
        elastic, rate, _, gap_rate = fields
        arm, drift = turn @ ((body + elastic) @ fraction), turn @ (rate @ fraction)
        spin = (wanted[1] - drift[1] - gap_rate) / arm[0]
        kept = rigid_state.RigidStart(start.angle, float(spin), float(wanted[0] - drift[0] + spin * arm[1]))
    return (*fields, kept.omega, kept.corner_speed)


def lag_by_damping(model: PlateModel, rate: np.ndarray) -> np.ndarray:
    """Displacement [m] by which the damping of elastic velocities makes the elastic state lag behind, free of rigid
    motion, shape (2, nodes); rate: of the elastic state [m/s], body frame."""
    damping = model.loop.elastic_damping
    if damping is None:
        return np.zeros_like(rate)
    masses, positions = model.loop.mass, model.discretisation.positions
    elastic = without_rigid_motion(rate.ravel(), masses, positions)
    return model.elastic(-damping.rate * np.tile(masses, 2) * elastic).reshape(2, -1)


def _and_rate(
    model: PlateModel,
    start: rigid_state.RigidStart,
    body: np.ndarray,
    at: Callable[[rigid_state.RigidStart], tuple[np.ndarray, float]],
) -> tuple[tuple[np.ndarray, float], tuple[np.ndarray, float]]:
    """Values of `at` for the start, an array and a number, and the rates of both as the rigid body moves on."""
    now = rigid_state.rigid_accelerations(model, body, start.angle, start.omega, start.corner_speed)
    span = 1e-3 * start.angle / start.omega  # a thousandth of the motion: its change is linear over that

    def after(time: float) -> tuple[np.ndarray, float]:
        angle = start.angle - start.omega * time - 0.5 * now.angular * time**2
        return at(rigid_state.RigidStart(angle, start.omega + now.angular * time, start.corner_speed))

    first, (late, later), (early, earlier) = after(0.0), after(span), after(-span)
    return first, ((late - early) / (2.0 * span), (later - earlier) / (2.0 * span))


def _displaced(model: PlateModel, load: np.ndarray) -> np.ndarray:
    """Elastic displacement relative to the corner [m], body frame, under this load [N], shape (2, nodes); linear."""
    displacement = model.elastic(load.ravel()).reshape(2, -1)
    return np.asarray(displacement - rigid_state.at_corner(model, displacement))


def _in_equilibrium(
    model: PlateModel, body: np.ndarray, linear: ElasticFields, start: rigid_state.RigidStart
) -> tuple[np.ndarray, float]:
    """Elastic displacement and gap in equilibrium on the deformed shape, without best rigid rotation. Raises
    TooSoftError."""
    from fem.start.equilibrium import equilibrium

    def load_at(place: np.ndarray) -> np.ndarray:
        return rigid_state.inertia_load(model, place - rigid_state.at_corner(model, place), start)[0]

    try:
        place = equilibrium(model, body + linear.elastic, load_at)
    except ValueError as error:  # Newton's method fails, or on its way the wall's reaction pushes
        raise TooSoftError(str(error)) from None
    place = _unturned(model, body, place - rigid_state.at_corner(model, place))
    return place - body, rigid_state.corner_gap(model, rigid_state.inertia_load(model, place, start)[1])


def _unturned(model: PlateModel, body: np.ndarray, place: np.ndarray) -> np.ndarray:
    """The positions turned about the corner so that the body fits them best without a rotation."""
    fraction = model.loop.mass / model.mass
    x, y = place - (place @ fraction)[:, None]
    r_x, r_y = (body - (body @ fraction)[:, None]) * fraction
    turned = np.arctan2((r_x * y - r_y * x).sum(), (r_x * x + r_y * y).sum())
    return rigid_state.to_global(float(turned)) @ place


class Statics(NamedTuple):
    """Effect of the reaction at the start on the plate.

    Attributes
    ----------
    deflection : float
        Of the centre of mass towards the wall, by the plate's flexibility [m].
    gap : float
        At the corner's constraint [m].
    """

    deflection: float
    gap: float


def statics(model: PlateModel, start: rigid_state.RigidStart) -> Statics:
    """Effect of the reaction at the start on the plate.

    Parameters
    ----------
    model : PlateModel
        The plate.
    start : RigidStart
        Motion of the rigid body.

    Returns
    -------
    Statics
        Deflection and gap [m].
    """
    elastic, gap = relieved_displacement(model, start)
    moved = (rigid_state.to_global(start.angle) @ elastic)[1] + gap
    return Statics(-float(model.loop.mass @ moved / model.mass), gap)


def static_deflection(model: PlateModel, start: rigid_state.RigidStart) -> float:
    """Displacement [m] of the centre of mass towards the wall by the reaction at the start."""
    return statics(model, start).deflection


def damping_lag(model: PlateModel, start: rigid_state.RigidStart) -> float:
    """Distance [m] by which the damping of elastic velocities holds back the corner in the slow change of the state."""
    behind = lag_by_damping(model, relieved_fields(model, start).rate)
    return float(np.abs(rigid_state.at_corner(model, behind)).max())


def elastic_energy(model: PlateModel, start: rigid_state.RigidStart) -> float:
    """Energy [J] of the elastic state at the start by inertia relief, that of the corner's constraint included."""
    elastic, gap = relieved_displacement(model, start)
    displacement = elastic.ravel()
    spring = model.loop.corner.spring
    return float(0.5 * (displacement @ (model.stiffness @ displacement) + spring * gap**2))
