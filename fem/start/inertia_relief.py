"""Inertia relief, the quasi-static elastic state of the plate's rigid acceleration.

The corner's constraint carries the reaction from the start, and both change slowly. Statics of that state yield the
deflection, the lag by damping, and the elastic energy. Where displacements are large, the state is in equilibrium on
the deformed plate (`equilibrium`), starting from the linear state.
"""

from collections.abc import Callable
from typing import NamedTuple, cast

import numpy as np

from fem.laws import friction
from fem.model.plate_model import PlateModel
from fem.plate.elastic import Solve, without_rigid_motion
from fem.plate.multigrid import TOLERANCE
from fem.plate.properties import RigidStart
from fem.start.equilibrium import equilibrium, has_inverted_elements

LINEAR_LIMIT, LARGE = 1e-5, 0.01
"""Elastic displacements over the plate's length below which nonlinear terms are rounding, and no element inverts."""

LARGEST_LAG = 0.1
"""Lag by damping over the elastic displacement up to which the lag is applied.

With a larger one the plate cannot follow its loads.
"""

RATE_TOLERANCE = 1e-7
"""Residual over the load of rate and lag in multigrid.

Both are corrections: the oscillation by an error of the rate is smaller by the ratio of the oscillation's period and
the motion, that by an error of the lag by at least ten.
"""

CORRECTIONS = 2
"""Number of corrections of the elastic state for the spin that conserves momentum.

Each reduces the error by the deflection ratio.
"""


class TooSoftError(ValueError):
    """The plate has no quasi-static elastic state in equilibrium with its reaction."""


class ElasticFields(NamedTuple):
    """Elastic fields of a start by inertia relief.

    elastic, rate: elastic displacement [m] and its rate [m/s] in the body frame, shape (2, nodes), both zero at the
    corner. gap, gap_rate: of the corner [m] and its rate [m/s].
    """

    elastic: np.ndarray
    rate: np.ndarray
    gap: float
    gap_rate: float


def relieved_fields(model: PlateModel, start: RigidStart) -> ElasticFields:
    """Return the linear fields of inertia relief in the body frame.

    The change of the load determines the rate.
    """
    body = model.discretisation.positions - at_corner(model, model.discretisation.positions)

    def load_at(now: RigidStart) -> tuple[np.ndarray, float]:
        return inertia_load(model, body, now)

    (load, normal), (rate, normal_rate) = _and_rate(model, start, body, load_at)
    elastic, elastic_rate = _displaced(model, load), _displaced(model, rate, RATE_TOLERANCE)
    return ElasticFields(elastic, elastic_rate, corner_gap(model, normal), corner_gap(model, normal_rate))


def relieved_displacement(model: PlateModel, start: RigidStart) -> tuple[np.ndarray, float]:
    """Return displacement and gap of `relieved_fields` [m] without rates."""
    body = model.discretisation.positions - at_corner(model, model.discretisation.positions)
    load, normal = inertia_load(model, body, start)
    return _displaced(model, load), corner_gap(model, normal)


def relieved(
    model: PlateModel, start: RigidStart, body: np.ndarray, near: ElasticFields | None = None
) -> ElasticFields:
    """Return the fields of inertia relief.

    They are in equilibrium on the deformed shape where the displacement is not small. near: fields of a similar start,
    with which the search for equilibrium begins; those of the undeformed shape where it is None.
    """
    fields = relieved_fields(model, start)
    (elastic, rate, *_), solve = near or fields, cast(Solve, model.elastic)

    def at(now: RigidStart) -> tuple[np.ndarray, float]:
        nonlocal elastic, rate, solve
        time = (start.angle - now.angle) / start.omega
        displacement, gap, solve = _in_equilibrium(model, body, elastic + time * rate, now, solve)
        if time == 0.0:
            elastic = displacement
        else:
            rate = (displacement - elastic) / time
        return displacement, gap

    if np.abs(fields.elastic).max() >= LINEAR_LIMIT * np.ptp(body):
        (displacement, gap), (rate, gap_rate) = _and_rate(model, start, body, at)
        is_large = np.abs(displacement).max() > LARGE * np.ptp(body)
        if is_large and has_inverted_elements(model, body + displacement):
            raise TooSoftError("elements are turned inside out")
        fields = ElasticFields(displacement, rate, gap, gap_rate)
    lag = lag_by_damping(model, fields.rate)
    lag = lag - at_corner(model, lag)
    if np.abs(lag).max() > LARGEST_LAG * np.abs(fields.elastic).max():
        return fields  # too strongly damped to follow its loads
    return fields._replace(elastic=fields.elastic + lag)


def relieved_with_momenta(
    model: PlateModel, start: RigidStart, body: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float, float, float, float]:
    """Return the fields of inertia relief with the rigid body's momentum.

    Spin [rad/s] and corner speed [m/s] follow from the momentum. The elastic state depends on the spin,
    and is computed again for it.
    """
    fraction, turn = model.parameters.mass / model.mass, to_global(start.angle)
    arm = turn @ (body @ fraction)
    target = np.array([start.corner_speed - start.omega * arm[1], start.omega * arm[0]])
    corrected, fields = start, relieved_fields(model, start)
    for _ in range(CORRECTIONS):
        fields = relieved(model, corrected, body, fields)
        elastic, rate, _, gap_rate = fields
        arm, drift = turn @ ((body + elastic) @ fraction), turn @ (rate @ fraction)
        spin = (target[1] - drift[1] - gap_rate) / arm[0]
        corrected = RigidStart(start.angle, float(spin), float(target[0] - drift[0] + spin * arm[1]))
    return (*fields, corrected.omega, corrected.corner_speed)


def lag_by_damping(model: PlateModel, rate: np.ndarray) -> np.ndarray:
    """Return the displacement [m] by which damping delays the elastic state.

    rate: of the elastic state [m/s], body frame. The result has no rigid motion, shape (2, nodes).
    """
    damping = model.parameters.elastic_damping
    if damping is None:
        return np.zeros_like(rate)
    masses, positions = model.parameters.mass, model.discretisation.positions
    elastic = without_rigid_motion(rate.ravel(), masses, positions)
    load = -damping.rate * np.tile(masses, 2) * elastic
    return model.elastic(load, RATE_TOLERANCE).reshape(2, -1)


def _and_rate(
    model: PlateModel,
    start: RigidStart,
    body: np.ndarray,
    at: Callable[[RigidStart], tuple[np.ndarray, float]],
) -> tuple[tuple[np.ndarray, float], tuple[np.ndarray, float]]:
    """Return an array and a number by `at`, and their rates.

    The rates are those along the motion of the rigid body.
    """
    acceleration = rigid_accelerations(model, body, start.angle, start.omega, start.corner_speed)
    span = 1e-3 * start.angle / start.omega  # a thousandth of the motion, over which its change is linear

    def after(time: float) -> tuple[np.ndarray, float]:
        angle = start.angle - start.omega * time - 0.5 * acceleration.angular * time**2
        return at(RigidStart(angle, start.omega + acceleration.angular * time, start.corner_speed))

    first, (late, later), (early, earlier) = after(0.0), after(span), after(-span)
    return first, ((late - early) / (2.0 * span), (later - earlier) / (2.0 * span))


def _displaced(model: PlateModel, load: np.ndarray, tolerance: float = TOLERANCE) -> np.ndarray:
    """Return the linear elastic displacement [m] relative to the corner.

    load: [N], body frame. Shape (2, nodes).
    """
    displacement = model.elastic(load.ravel(), tolerance).reshape(2, -1)
    return np.asarray(displacement - at_corner(model, displacement))


def _in_equilibrium(
    model: PlateModel, body: np.ndarray, elastic: np.ndarray, start: RigidStart, solve: Solve
) -> tuple[np.ndarray, float, Solve]:
    """Return elastic displacement and gap in equilibrium on the deformed shape.

    The best rigid rotation is removed. elastic, solve: displacement [m] of a similar state and a solver, see
    `equilibrium`. Both serve the next state. Raises TooSoftError.
    """

    def load_at(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        place = _unturned(model, body, place - at_corner(model, place))
        return place, inertia_load(model, place, start)[0]

    try:
        place, solve = equilibrium(model, body + elastic, load_at, solve)
    except ValueError as error:  # the steps diverge, or the reaction becomes compressive
        raise TooSoftError(str(error)) from None
    return place - body, corner_gap(model, inertia_load(model, place, start)[1]), solve


def _unturned(model: PlateModel, body: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Rotate positions about the corner to fit the body.

    The result has no rigid rotation in the mass-weighted sense.
    """
    fraction = model.parameters.mass / model.mass
    x, y = place - (place @ fraction)[:, None]
    r_x, r_y = (body - (body @ fraction)[:, None]) * fraction
    turned = np.arctan2((r_x * y - r_y * x).sum(), (r_x * x + r_y * y).sum())
    return to_global(float(turned)) @ place


class Statics(NamedTuple):
    """Effect of the reaction at the start on the plate.

    Attributes
    ----------
    deflection : float
        Deflection of the centre of mass towards the wall, by the plate's flexibility [m].
    gap : float
        Gap at the corner's constraint [m].
    """

    deflection: float
    gap: float


def statics(model: PlateModel, start: RigidStart) -> Statics:
    """Return the effect of the reaction at the start on the plate.

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
    moved = (to_global(start.angle) @ elastic)[1] + gap
    return Statics(-float(model.parameters.mass @ moved / model.mass), gap)


def damping_lag(model: PlateModel, start: RigidStart) -> float:
    """Return the distance [m] by which damping delays the corner.

    It is that of the slow change of the elastic state.
    """
    lag = lag_by_damping(model, relieved_fields(model, start).rate)
    return float(np.abs(at_corner(model, lag)).max())


def elastic_energy(model: PlateModel, start: RigidStart) -> float:
    """Return the energy [J] of the elastic state at the start.

    The corner's constraint is included.
    """
    elastic, gap = relieved_displacement(model, start)
    displacement = elastic.ravel()
    spring = model.parameters.corner.spring
    return float(0.5 * (displacement @ (model.stiffness @ displacement) + spring * gap**2))


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
