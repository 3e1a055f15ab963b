"""The time loop of a whole impact: the step of `time_loop`, with a wall that only pushes in place of the corner."""

from typing import Any, NamedTuple

import numpy as np

from fem.explicit.measures import elastic_energies, motion, plate_forces
from fem.explicit.time_loop import advance, react
from fem.laws.hinges import add_impulses, describe_units, join
from fem.laws.wall_contact import (
    BoundaryContact,
    ContactState,
    add_contact,
    approach,
    held_by,
    lost_energy,
    point_mean,
    push_back,
    stored_energy,
    tilted,
)
from fem.machine_code.compiled import compiled, implements
from fem.plate.discretisation import ElementTable


class ImpactLoop(NamedTuple):
    """Everything that stays as it is during a run; as `LoopParameters`, with contact in place of the corner."""

    table: ElementTable
    material: Any
    mass: np.ndarray
    contact: BoundaryContact
    viscosity: Any
    hourglass: Any
    elastic_damping: Any
    time_step: float
    span: float  # [m], by which the origin follows the plate along the wall
    wall: Any  # ElasticWall; None for a rigid one
    hinges: Any = None  # Hinges of a train; None for one plate


class ImpactLoopState(NamedTuple):
    """State of the loop of a whole impact: the plate's motion, and sums so far.

    positions, velocities, origin: as in `State`. sums, shape (3,): friction work and damping work done on the plate
    [J]; moment of the wall's impulse about the wall's frame [N m s]. contact: of each contact point. wall: a
    `WallMotion`; None for a rigid one. hinges: a `HingeState`; None for one plate.
    """

    positions: np.ndarray
    velocities: np.ndarray
    sums: np.ndarray
    origin: np.ndarray
    contact: ContactState
    wall: Any
    hinges: Any = None


class ImpactMeasures(NamedTuple):
    """The compiled record of an instant; a train's is that of all its plates.

    Attributes
    ----------
    x_g, y_g : float
        Centre of mass in the wall's frame [m].
    theta, omega : float
        Angle between side and wall [rad], and spin [rad/s], positive where it closes the angle.
    v_gx, v_gy : float
        Velocity of the centre of mass [m/s].
    kinetic_energy, strain_energy, hourglass_energy : float
        Energies of the plate [J].
    contact_energy, crush_energy : float
        Energy that contact will return, and energy that crush has taken for good [J].
    friction_work, damping_work : float
        Done on the plate since the start [J].
    vibration_energy : float
        Kinetic energy that is not rigid motion's [J].
    normal_impulse, tangential_impulse, moment_impulse : float
        Of the wall on the plate since the start [N s], and about the wall's frame [N m s].
    angular_momentum : float
        Of the plate about the wall's frame [kg m^2/s].
    wall_energy : float
        Kinetic and elastic, of the wall and its foundation [J]; with all below, 0 for a rigid wall.
    wall_deflection, wall_deflection_place : float
        The largest of the wall's face [m], and where along the wall it is [m].
    foundation_impulse : float
        Of the foundation on the wall since the start, towards the plate [N s].
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
    """Arrays for the records, a row an instant: values, shape (rows, fields of `ImpactMeasures`); normal and tangential
    impulse [N s], depth behind the face and place along the wall [m] of each contact point, each of shape (rows,
    points); units, shape (rows, columns): of the plates and hinges of a train, see `fem.laws.hinges`."""

    values: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    depth: np.ndarray
    place: np.ndarray
    units: np.ndarray


@implements(react, ImpactLoop, merged=True)
def _react_by_contact(loop, state, lost, force):
    add_contact(loop, state, state.contact, state.wall, force)
    join(loop.hinges, state.hinges, state.positions, state.velocities, loop.mass, loop.time_step, force)
    add_impulses(loop.hinges, state.hinges, loop.time_step)
    state.sums[1] -= loop.time_step * lost
    return state.positions[0, loop.contact.nodes[0]]


@compiled
def advance_and_record(state, stride, loop, viscosity, hourglass, reference, force, scratch, rows):
    """Advance the state in place, and record every `stride` steps until the rows are full."""
    for row in range(rows.values.shape[0]):
        advance(state, stride, loop, viscosity, hourglass, force, scratch)
        measures = record(state, loop, viscosity, hourglass, reference, force, scratch, rows, row)
        for k in range(len(measures)):
            rows.values[row, k] = measures[k]


@compiled
def record(state, loop, viscosity, hourglass, reference, force, scratch, rows, row):
    """The `ImpactMeasures` of the state at its instant, and the row of its contact points; the state stays as it is."""
    positions, velocities, half = state.positions, state.velocities, 0.5 * loop.time_step
    damping_power = plate_forces(state, loop, viscosity, hourglass, force, scratch)
    contact, kept, wall, moving = loop.contact, state.contact, loop.wall, state.wall
    origin, friction, moment = state.origin[0], state.sums[0], state.sums[2]
    normals = tangentials = stored = lost = 0.0
    push_back(loop, state, kept, moving, force)
    hinged = state.hinges
    join(loop.hinges, hinged, positions, velocities, loop.mass, loop.time_step, force)
    units = rows.units[row]
    describe_units(loop.hinges, hinged, state, force, loop.mass, loop.time_step, reference, units)
    for i in range(contact.mobility.size):
        normal, tangential = kept.pushing[i], kept.sliding[i]
        face, depth, opening, slip = approach(loop, state, i)
        x, y = origin + point_mean(positions[0], contact, i), point_mean(positions[1], contact, i)
        deepest = max(kept.deepest[i], depth)
        before = depth + loop.time_step * opening
        stored += stored_energy(contact.law, i, before, depth, deepest, normal)
        lost += lost_energy(contact.law, i, deepest)
        friction += half * (tangential + tilted(wall, face, normal)) * slip
        moment += half * (x * normal - y * tangential)
        rows.normal[row, i] = kept.normal[i] + half * normal
        rows.tangential[row, i] = kept.tangential[i] + half * tangential
        rows.depth[row, i] = depth
        rows.place[row, i] = x
        normals += rows.normal[row, i]
        tangentials += rows.tangential[row, i]
    theta, omega, v_x, v_y, kinetic, vibration, c_x, c_y = motion(
        positions, velocities, force, loop.mass, loop.time_step, reference
    )
    wall_energy, deflection, place, foundation = held_by(wall, moving, half)
    strain_energy, hourglass_energy = elastic_energies(positions, loop, hourglass)
    return ImpactMeasures(
        x_g=origin + c_x,
        y_g=c_y,
        theta=theta,
        omega=omega,
        v_gx=v_x,
        v_gy=v_y,
        kinetic_energy=kinetic,
        strain_energy=strain_energy,
        hourglass_energy=hourglass_energy,
        contact_energy=stored,
        crush_energy=lost,
        friction_work=friction,
        damping_work=state.sums[1] + half * damping_power,
        vibration_energy=vibration,
        normal_impulse=normals,
        tangential_impulse=tangentials,
        moment_impulse=moment,
        angular_momentum=_angular_momentum(positions, velocities, force, loop, origin),
        wall_energy=wall_energy,
        wall_deflection=deflection,
        wall_deflection_place=place,
        foundation_impulse=foundation,
    )


@compiled
def _angular_momentum(positions, velocities, force, loop, origin):
    mass, half, total = loop.mass, 0.5 * loop.time_step, 0.0
    for i in range(mass.size):
        u_x = velocities[0, i] + half * force[0, i] / mass[i]
        u_y = velocities[1, i] + half * force[1, i] / mass[i]
        total += mass[i] * ((positions[0, i] + origin) * u_y - positions[1, i] * u_x)
    return total
