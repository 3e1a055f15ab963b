"""Inertia relief: the quasi-static elastic state that belongs to the plate's rigid acceleration, with the corner's
constraint already carrying the reaction, and the slow change of both; and what it says by statics alone: deflection,
lag by damping, energy.

Before it the rigid body that a plate starts from: its motion, its accelerations, and the loads that go with them.

Where displacements are no longer small, the elastic state is in equilibrium on the deformed plate: Newton's method on
the forces of the time loop itself, from the linear state, with the tangent stiffness of the St. Venant-Kirchhoff
material, which all materials have at small strain.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from fem.explicit import internal_force
from fem.laws import friction
from fem.model.plate_model import PlateModel
from fem.plate import elastic
from fem.plate.discretisation import hourglass_matrix
from fem.plate.elastic import without_rigid_motion
from fem.plate.properties import RigidStart


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
    acceleration = rigid.angular * np.array([-arm[1], arm[0]]) - start.omega**2 * arm
    acceleration += [[rigid.corner], [0.0]]
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
        why = f"the initial reaction of the wall is {normal:g} N; Stage 2 requires tension (a negative reaction)"
        raise ValueError(why)
    return RigidAccelerations(corner, angular, normal, slope * normal)


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


def relieved_fields(model: PlateModel, start: RigidStart) -> ElasticFields:
    """The start by inertia relief in the body frame: linear, so that the change of the load gives the rate."""
    body = model.discretisation.positions - at_corner(model, model.discretisation.positions)

    def load_at(now: RigidStart) -> tuple[np.ndarray, float]:
        return inertia_load(model, body, now)

    (load, normal), (rate, normal_rate) = _and_rate(model, start, body, load_at)
    elastic, changing = (_displaced(model, each) for each in (load, rate))
    return ElasticFields(elastic, changing, corner_gap(model, normal), corner_gap(model, normal_rate))


def relieved_displacement(model: PlateModel, start: RigidStart) -> tuple[np.ndarray, float]:
    """Elastic displacement and the corner's gap of `relieved_fields` [m], without their rates."""
    body = model.discretisation.positions - at_corner(model, model.discretisation.positions)
    load, normal = inertia_load(model, body, start)
    return _displaced(model, load), corner_gap(model, normal)


def relieved(model: PlateModel, start: RigidStart, body: np.ndarray) -> ElasticFields:
    """The fields of inertia relief; of a plate that deforms visibly, in equilibrium on its deformed shape."""
    fields = linear = relieved_fields(model, start)

    def at(now: RigidStart) -> tuple[np.ndarray, float]:
        return _in_equilibrium(model, body, linear, now)

    if np.abs(linear.elastic).max() >= SMALL * np.ptp(body):
        (elastic, gap), (rate, gap_rate) = _and_rate(model, start, body, at)
        fields = ElasticFields(elastic, rate, gap, gap_rate)
    behind = lag_by_damping(model, fields.rate)
    behind = behind - at_corner(model, behind)
    if np.abs(behind).max() > FOLLOWS * np.abs(fields.elastic).max():
        return fields  # it is damped too strongly to follow its loads
    return fields._replace(elastic=fields.elastic + behind)


def relieved_with_momenta(model: PlateModel, start: RigidStart, body: np.ndarray) -> Any:
    """The fields of inertia relief, and the spin [rad/s] and corner speed [m/s] that give the rigid body's momentum.

    The elastic state goes with the spin that it is to have, and is found again for it.
    """
    fraction, turn = model.loop.mass / model.mass, to_global(start.angle)
    arm = turn @ (body @ fraction)
    wanted = np.array([start.corner_speed - start.omega * arm[1], start.omega * arm[0]])
    kept = start
    for _ in range(CORRECTIONS):
        fields = relieved(model, kept, body)
        elastic, rate, _, gap_rate = fields
        arm, drift = turn @ ((body + elastic) @ fraction), turn @ (rate @ fraction)
        spin = (wanted[1] - drift[1] - gap_rate) / arm[0]
        kept = RigidStart(start.angle, float(spin), float(wanted[0] - drift[0] + spin * arm[1]))
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
    start: RigidStart,
    body: np.ndarray,
    at: Callable[[RigidStart], tuple[np.ndarray, float]],
) -> tuple[tuple[np.ndarray, float], tuple[np.ndarray, float]]:
    """Values of `at` for the start, an array and a number, and the rates of both as the rigid body moves on."""
    now = rigid_accelerations(model, body, start.angle, start.omega, start.corner_speed)
    span = 1e-3 * start.angle / start.omega  # a thousandth of the motion: its change is linear over that

    def after(time: float) -> tuple[np.ndarray, float]:
        angle = start.angle - start.omega * time - 0.5 * now.angular * time**2
        return at(RigidStart(angle, start.omega + now.angular * time, start.corner_speed))

    first, (late, later), (early, earlier) = after(0.0), after(span), after(-span)
    return first, ((late - early) / (2.0 * span), (later - earlier) / (2.0 * span))


def _displaced(model: PlateModel, load: np.ndarray) -> np.ndarray:
    """Elastic displacement relative to the corner [m], body frame, under this load [N], shape (2, nodes); linear."""
    displacement = model.elastic(load.ravel()).reshape(2, -1)
    return np.asarray(displacement - at_corner(model, displacement))


def _in_equilibrium(
    model: PlateModel, body: np.ndarray, linear: ElasticFields, start: RigidStart
) -> tuple[np.ndarray, float]:
    """Elastic displacement and gap in equilibrium on the deformed shape, without best rigid rotation. Raises
    TooSoftError."""

    def load_at(place: np.ndarray) -> np.ndarray:
        return inertia_load(model, place - at_corner(model, place), start)[0]

    try:
        place = equilibrium(model, body + linear.elastic, load_at)
    except ValueError as error:  # Newton's method fails, or on its way the wall's reaction pushes
        raise TooSoftError(str(error)) from None
    place = _unturned(model, body, place - at_corner(model, place))
    return place - body, corner_gap(model, inertia_load(model, place, start)[1])


def _unturned(model: PlateModel, body: np.ndarray, place: np.ndarray) -> np.ndarray:
    """The positions turned about the corner so that the body fits them best without a rotation."""
    fraction = model.loop.mass / model.mass
    x, y = place - (place @ fraction)[:, None]
    r_x, r_y = (body - (body @ fraction)[:, None]) * fraction
    turned = np.arctan2((r_x * y - r_y * x).sum(), (r_x * x + r_y * y).sum())
    return to_global(float(turned)) @ place


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


def statics(model: PlateModel, start: RigidStart) -> Statics:
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
    moved = (to_global(start.angle) @ elastic)[1] + gap
    return Statics(-float(model.loop.mass @ moved / model.mass), gap)


def damping_lag(model: PlateModel, start: RigidStart) -> float:
    """Distance [m] by which the damping of elastic velocities holds back the corner in the slow change of the state."""
    behind = lag_by_damping(model, relieved_fields(model, start).rate)
    return float(np.abs(at_corner(model, behind)).max())


def elastic_energy(model: PlateModel, start: RigidStart) -> float:
    """Energy [J] of the elastic state at the start by inertia relief, that of the corner's constraint included."""
    elastic, gap = relieved_displacement(model, start)
    displacement = elastic.ravel()
    spring = model.loop.corner.spring
    return float(0.5 * (displacement @ (model.stiffness @ displacement) + spring * gap**2))


MAX_STEPS, TOLERANCE, GOOD = 15, 1e-10, 1e-3
"""Newton steps; the residual over the largest load at which they end; and the one from which on they end where rounding
no longer lets it fall."""


def equilibrium(
    model: PlateModel, place: np.ndarray, load_at: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Positions [m], shape (2, nodes), at which the internal forces balance the load, from positions near to them.

    load_at: load [N] for positions, in equilibrium there, shape (2, nodes). What is rigid in each step is left out.
    Raises ValueError if the steps do not converge.
    """
    before = np.inf
    for _ in range(MAX_STEPS):
        load = load_at(place)
        residual = load - internal_forces(model, place)
        size = float(np.abs(residual).max() / np.abs(load).max())
        if size <= TOLERANCE or (before < GOOD and size > 0.5 * before):
            return place
        if not np.isfinite(size):
            break
        solve = elastic.elastic_solver(tangent_matrix(model, place), model.loop.mass, place)
        place, before = place + solve(residual.ravel()).reshape(2, -1), size
    raise ValueError(
        "the plate is too soft for a start by inertia relief: no equilibrium exists under the reaction"
    )


def internal_forces(model: PlateModel, place: np.ndarray) -> np.ndarray:
    """Nodal forces [N] that hold the plate at these positions, shape (2, nodes)."""
    loop, force, place = model.loop, np.zeros(place.shape), np.ascontiguousarray(place)
    scratch = internal_force.scratch_for(loop.table, loop.hourglass)
    internal_force.subtract_internal_forces(
        place, np.zeros(place.shape), None, loop.hourglass, force, loop.table, loop.material, scratch
    )
    return -force


def tangent_matrix(model: PlateModel, place: np.ndarray) -> sp.csr_matrix:
    """Stiffness [N/m] about these positions, numbered as `stiffness_matrix`; symmetric, shape (2 nodes, 2 nodes)."""
    import skfem

    d = model.discretisation
    gradient = np.array([d.scalar.interpolate(component).grad for component in place])
    moduli = model.tangent_moduli
    stress = _stress(gradient, moduli)

    def block(i: int, j: int) -> sp.csr_matrix:
        tensor = _tangent(gradient[i], gradient[j], moduli) + (stress if i == j else 0.0)

        def form(u: Any, v: Any, w: Any) -> Any:
            return np.einsum("kl...,k...,l...->...", tensor, v.grad, u.grad)

        return skfem.BilinearForm(form).assemble(d.scalar)

    coupling = block(0, 1)
    matrix = sp.csr_matrix(model.thickness * sp.bmat([[block(0, 0), coupling], [coupling.T, block(1, 1)]]))
    if model.loop.hourglass is not None:
        matrix = matrix + hourglass_matrix(d.table, model.loop.hourglass, model.loop.mass.size)
    return matrix


def _stress(gradient: np.ndarray, moduli: Any) -> np.ndarray:
    """Second Piola-Kirchhoff stress, shape (2, 2, ...), of deformation gradients of that shape."""
    strain = 0.5 * (np.einsum("ik...,il...->kl...", gradient, gradient))
    strain[0, 0] -= 0.5
    strain[1, 1] -= 0.5
    stress = np.empty_like(strain)
    stress[0, 0] = moduli.c_11 * strain[0, 0] + moduli.c_12 * strain[1, 1]
    stress[1, 1] = moduli.c_12 * strain[0, 0] + moduli.c_11 * strain[1, 1]
    stress[0, 1] = stress[1, 0] = 2.0 * moduli.c_33 * strain[0, 1]
    return stress


def _tangent(f_i: np.ndarray, f_j: np.ndarray, moduli: Any) -> np.ndarray:
    """C_KMLN F_iM F_jN, shape (2, 2, ...), of the rows i and j of the deformation gradient."""
    first, second = f_i[0] * f_j[0], f_i[1] * f_j[1]
    mixed, crossed = f_i[0] * f_j[1], f_i[1] * f_j[0]
    return np.array(
        [
            [moduli.c_11 * first + moduli.c_33 * second, moduli.c_12 * mixed + moduli.c_33 * crossed],
            [moduli.c_12 * crossed + moduli.c_33 * mixed, moduli.c_11 * second + moduli.c_33 * first],
        ]
    )
