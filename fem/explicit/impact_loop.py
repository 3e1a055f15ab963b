"""Time loop of a whole impact.

The step is that of `time_loop`, with unilateral contact in place of the constrained corner.
"""

from typing import NamedTuple

import numpy as np

from fem.explicit.elastic_damping import ElasticDamping
from fem.explicit.internal_force import Viscosity
from fem.explicit.measures import motion
from fem.explicit.time_loop import HOURGLASS, STRAIN, WORK, add_reaction, advance_to_row, describe_forces
from fem.laws.hinges import Hinges, HingeState, add_impulses, describe_units, join
from fem.laws.tyres import Axles, AxleState, end_tyre_step, record_tyres, steer
from fem.laws.wall_contact import (
    BoundaryContact,
    ContactState,
    ElasticWall,
    WallMotion,
    add_contact,
    approach,
    describe_wall,
    lost_energy,
    point_mean,
    push_back,
    stored_energy,
    tilted,
)
from fem.plate.discretisation import ElementTable, Hourglass
from machine_code.compiled import compiled, implements


class ImpactLoopParameters(NamedTuple):
    """Constants of a run of a whole impact.

    As `LoopParameters`, with contact in place of the corner. span: distance [m] in which the origin follows the plate
    along the wall. wall: an `ElasticWall`, None for a rigid wall. hinges: `Hinges` of a train, None for one plate.
    """

    table: ElementTable
    material: tuple[float, ...]
    mass: np.ndarray
    contact: BoundaryContact
    viscosity: Viscosity | None
    hourglass: Hourglass | None
    elastic_damping: ElasticDamping | None
    time_step: float
    span: float
    wall: ElasticWall | None
    hinges: Hinges | None = None
    axles: Axles | None = None


class ImpactLoopState(NamedTuple):
    """State of the loop of a whole impact.

    positions, velocities, origin: as in `State`. sums, shape (3,): friction work and damping work on the plate [J];
    moment of the wall's impulse about the wall's frame [N m s]. contact: of each contact point. wall: a `WallMotion`,
    None for a rigid wall. hinges: a `HingeState`, None for one plate. axles: an `AxleState`, None without axles.
    """

    positions: np.ndarray
    velocities: np.ndarray
    sums: np.ndarray
    origin: np.ndarray
    contact: ContactState
    wall: WallMotion | None
    hinges: HingeState | None = None
    axles: AxleState | None = None


class ImpactMeasures(NamedTuple):
    """Measures of a whole impact at an instant.

    Those of a train are of all its plates.

    Attributes
    ----------
    x_g, y_g : float
        Centre of mass in the wall's frame [m].
    theta, omega : float
        Angle between side and wall [rad], and spin [rad/s], positive as the rear rotates towards the wall.
    v_gx, v_gy : float
        Velocity of the centre of mass [m/s].
    kinetic_energy, strain_energy, hourglass_energy : float
        Energies of the plate [J].
    contact_energy, crush_energy : float
        Recoverable energy of the contact, and energy dissipated by crush [J].
    friction_work, damping_work : float
        Work on the plate since the start [J].
    vibration_energy : float
        Kinetic energy of the deviation from rigid motion [J].
    normal_impulse, tangential_impulse, moment_impulse : float
        Impulse of the wall on the plate since the start [N s], and its moment about the wall's frame [N m s].
    angular_momentum : float
        Angular momentum of the plate about the wall's frame [kg m^2/s].
    wall_energy : float
        Kinetic and elastic energy of the wall and its foundation [J]; 0 for a rigid wall, as are all below.
    wall_deflection, wall_deflection_place : float
        The largest deflection of the wall's face [m], and its place along the wall [m].
    foundation_impulse : float
        Impulse of the foundation on the wall since the start, towards the plate [N s].
    """

    x_g: float
    y_g: float
    theta: float
    omega: float
    v_gx: float
    v_gy: float
    kinetic_energy: float
    strain_energy: float
    hourglass_energy: float
    contact_energy: float
    crush_energy: float
    friction_work: float
    damping_work: float
    vibration_energy: float
    normal_impulse: float
    tangential_impulse: float
    moment_impulse: float
    angular_momentum: float
    wall_energy: float
    wall_deflection: float
    wall_deflection_place: float
    foundation_impulse: float


class Rows(NamedTuple):
    """Arrays with one row per instant.

    values, shape (rows, fields of `ImpactMeasures`). normal and tangential impulse [N s], depth behind the face and
    place along the wall [m] of each contact point, shape (rows, points) each. units, shape (rows, columns): of the
    plates and hinges of a train, see `fem.laws.hinges`. tyres, shape (rows, columns): of `fem.laws.tyres.SUMS`.
    """

    values: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    depth: np.ndarray
    place: np.ndarray
    units: np.ndarray
    tyres: np.ndarray


@implements(add_reaction, ImpactLoopParameters, merged=True)
def _add_contact_reaction(parameters, state, damping_work, force):
    """Add the forces of tyres, contact and hinges."""
    hinges, mass, time_step = parameters.hinges, parameters.mass, parameters.time_step
    axles, axle_state = parameters.axles, state.axles
    steer(axles, axle_state, state.positions, state.velocities, mass, time_step, force)
    add_contact(parameters, state, force)
    join(hinges, state.hinges, state.positions, state.velocities, mass, time_step, force)
    end_tyre_step(axles, axle_state, state, mass, time_step, force)
    add_impulses(hinges, state.hinges, time_step)
    state.sums[1] -= damping_work
    return state.positions[0, parameters.contact.nodes[0]]


@compiled
def advance_and_record(state, stride, parameters, reference, force, scratch, last, rows):
    """Advance the state in place and record each row.

    stride: steps between rows.
    """
    describe_forces(state, parameters, force, scratch, last)
    for row in range(rows.values.shape[0]):
        advance_to_row(state, stride, parameters, force, scratch, last)
        measures = record(state, parameters, reference, force, last, rows, row)
        for k in range(len(measures)):
            rows.values[row, k] = measures[k]


@compiled
def record(state, parameters, reference, force, last, rows, row):
    """Return the `ImpactMeasures` of a state, which is left unchanged.

    Adds reactions to `force`, the plate's forces [N], and fills a row of all arrays of `rows`. last: a
    `LastRow` of this state.
    """
    positions, velocities, half_step = state.positions, state.velocities, 0.5 * parameters.time_step
    contact, contact_state, wall, wall_motion = parameters.contact, state.contact, parameters.wall, state.wall
    origin, friction, moment = state.origin[0], state.sums[0], state.sums[2]
    normals = tangentials = stored = crushed = 0.0
    mass, time_step = parameters.mass, parameters.time_step
    axles, axle_state = parameters.axles, state.axles
    steer(axles, axle_state, positions, velocities, mass, time_step, force)
    push_back(parameters, state, force)
    hinges, hinge_state = parameters.hinges, state.hinges
    join(hinges, hinge_state, positions, velocities, mass, time_step, force)
    units = rows.units[row]
    describe_units(hinges, hinge_state, state, force, mass, time_step, reference, units)
    record_tyres(axles, axle_state, state, mass, time_step, force, rows.tyres[row])
    for i in range(contact.mobility.size):
        normal, tangential = contact_state.pushing[i], contact_state.sliding[i]
        face, depth, opening, slip = approach(parameters, state, i)
        x, y = origin + point_mean(positions[0], contact, i), point_mean(positions[1], contact, i)
        deepest = max(contact_state.deepest[i], depth)
        before = depth + time_step * opening
        stored += stored_energy(contact.law, i, before, depth, deepest, normal)
        crushed += lost_energy(contact.law, i, deepest)
        friction += half_step * (tangential + tilted(wall, face, normal)) * slip
        moment += half_step * (x * normal - y * tangential)
        rows.normal[row, i] = contact_state.normal[i] + half_step * normal
        rows.tangential[row, i] = contact_state.tangential[i] + half_step * tangential
        rows.depth[row, i] = depth
        rows.place[row, i] = x
        normals += rows.normal[row, i]
        tangentials += rows.tangential[row, i]
    theta, omega, v_x, v_y, kinetic, vibration, c_x, c_y = motion(
        positions, velocities, force, mass, time_step, reference
    )
    wall_energy, deflection, place, foundation = describe_wall(wall, wall_motion, half_step)
    return ImpactMeasures(
        x_g=origin + c_x,
        y_g=c_y,
        theta=theta,
        omega=omega,
        v_gx=v_x,
        v_gy=v_y,
        kinetic_energy=kinetic,
        strain_energy=last.values[STRAIN],
        hourglass_energy=last.values[HOURGLASS],
        contact_energy=stored,
        crush_energy=crushed,
        friction_work=friction,
        damping_work=state.sums[1] - 0.5 * last.values[WORK],
        vibration_energy=vibration,
        normal_impulse=normals,
        tangential_impulse=tangentials,
        moment_impulse=moment,
        angular_momentum=_angular_momentum(positions, velocities, force, parameters, origin),
        wall_energy=wall_energy,
        wall_deflection=deflection,
        wall_deflection_place=place,
        foundation_impulse=foundation,
    )


@compiled
def _angular_momentum(positions, velocities, force, parameters, origin):
    """Return the plate's angular momentum [kg m^2/s].

    It is about the origin of the wall's frame.
    """
    mass, half, total = parameters.mass, 0.5 * parameters.time_step, 0.0
    for i in range(mass.size):
        u_x = velocities[0, i] + half * force[0, i] / mass[i]
        u_y = velocities[1, i] + half * force[1, i] / mass[i]
        total += mass[i] * ((positions[0, i] + origin) * u_y - positions[1, i] * u_x)
    return total
