"""Momenta, rotation, reactions and energies of the plate at an instant, compiled.

Velocities at instant n are the mean of those half a step before and after. With a kinetic energy of m v_before .
v_after / 2 and works by the trapezoidal rule, central differences conserve the energy of a linear model to rounding.
The energy balance then shows errors of the model, not of the bookkeeping.
"""

import math

from fem.explicit.columns import Measures
from fem.explicit.time_loop import HOURGLASS, STRAIN, WORK, advance_to_row, copy_nodal, describe_forces
from fem.laws.constraints import add_corner_reaction, constraint_energy, weighted
from machine_code.compiled import compiled, reordered


@compiled
def measure(state, parameters, reference, force, scratch, last):
    """Return the `Measures` of a state, which is left unchanged.

    reference: positions in the body frame [m], shape (2, nodes). The plate's angle is that of the rigid rotation that
    carries them onto the positions with the least mass-weighted square of distance.
    """
    describe_forces(state, parameters, force, scratch, last)
    return measures_of(state, parameters, reference, force, last)


@compiled
def measures_of(state, parameters, reference, force, last):
    """Return the `Measures` of a state, and add reactions to the force.

    force: of the plate [N]; last: a `LastRow` of this state.
    """
    positions, velocities, sums, origin = state
    mass, time_step, half = parameters.mass, parameters.time_step, 0.5 * parameters.time_step
    normal, tangential, slip, later_slip, _ = add_corner_reaction(
        positions, velocities, mass, time_step, parameters.corner, parameters.friction, force
    )
    theta, omega, v_x, v_y, kinetic, vibration, _, _ = motion(
        positions, velocities, force, mass, time_step, reference
    )
    gap = weighted(positions[1], parameters.corner)
    return Measures(
        theta=theta,
        omega=omega,
        v_gx=v_x,
        v_gy=v_y,
        slide=origin[0] + weighted(positions[0], parameters.corner),
        v_p=0.5 * (slip + later_slip),
        reaction_normal=normal,
        reaction_tangential=tangential,
        kinetic_energy=kinetic,
        strain_energy=last.values[STRAIN],
        contact_energy=constraint_energy(parameters.corner.constraint, gap),
        friction_work=sums[0] + half * tangential * slip,
        damping_work=sums[1] - 0.5 * last.values[WORK],
        vibration_energy=vibration,
        normal_impulse=sums[2] + half * normal,
        normal_impulse_magnitude=sums[3] + half * abs(normal),
        gap=gap,
        hourglass_energy=last.values[HOURGLASS],
    )


@reordered
def motion(positions, velocities, force, mass, time_step, reference):
    """Return rigid motion and kinetic energies of the plate.

    They are the angle [rad], the spin [rad/s], the velocity of the centre of mass [m/s], the kinetic energy of the
    energy balance and that of the deviation from rigid motion [J], and the centre of mass [m].
    """
    x, y, v_x, v_y, f_x, f_y = positions[0], positions[1], velocities[0], velocities[1], force[0], force[1]
    r_x, r_y, half = reference[0], reference[1], 0.5 * time_step
    total = c_x = c_y = b_x = b_y = c_u = c_v = kinetic = 0.0
    for i in range(mass.size):
        m = mass[i]
        d_u, d_v = half * f_x[i] / m, half * f_y[i] / m
        u, v = v_x[i] + d_u, v_y[i] + d_v
        total += m
        c_x += m * x[i]
        c_y += m * y[i]
        b_x += m * r_x[i]
        b_y += m * r_y[i]
        c_u += m * u
        c_v += m * v
        kinetic += 0.5 * m * (u * u + v * v - d_u * d_u - d_v * d_v)
    c_x, c_y, b_x, b_y = c_x / total, c_y / total, b_x / total, b_y / total
    c_u, c_v = c_u / total, c_v / total
    cosine = sine = spin = inertia = 0.0
    for i in range(mass.size):
        m, s, t, p, q = mass[i], x[i] - c_x, y[i] - c_y, r_x[i] - b_x, r_y[i] - b_y
        u, v = v_x[i] + half * f_x[i] / m - c_u, v_y[i] + half * f_y[i] / m - c_v
        cosine += m * (p * s + q * t)
        sine += m * (p * t - q * s)
        spin += m * (s * v - t * u)
        inertia += m * (s * s + t * t)
    omega, vibration = spin / inertia, 0.0
    for i in range(mass.size):
        u = v_x[i] + half * f_x[i] / mass[i] - c_u + omega * (y[i] - c_y)
        v = v_y[i] + half * f_y[i] / mass[i] - c_v - omega * (x[i] - c_x)
        vibration += 0.5 * mass[i] * (u * u + v * v)
    return -math.atan2(sine, cosine), omega, c_u, c_v, kinetic, vibration, c_x, c_y


@compiled
def advance_and_measure(state, before, stride, parameters, reference, force, scratch, last, rows):
    """Advance the state in place and write its `Measures` row by row.

    stride: steps between rows. Ends after a row with an angle that is not positive, or with a number that is not
    finite; `before` is then the state of the previous row. Returns the number of rows. Other arguments: as `measure`.
    """
    describe_forces(state, parameters, force, scratch, last)
    for row in range(rows.shape[0]):
        copy_state(state, before)
        advance_to_row(state, stride, parameters, force, scratch, last)
        measures = measures_of(state, parameters, reference, force, last)
        finite = True
        for column in range(rows.shape[1]):
            rows[row, column] = measures[column]
            finite = finite and math.isfinite(rows[row, column])
        if not (finite and measures.theta > 0.0):
            return row + 1
    return rows.shape[0]


@compiled
def copy_state(state, target):
    """Copy the arrays of a state into another."""
    copy_nodal(state.positions, target.positions)
    copy_nodal(state.velocities, target.velocities)
    for k in range(state.sums.size):
        target.sums[k] = state.sums[k]
    target.origin[0] = state.origin[0]


def lagrange_weight(nodes, begin, end, k, at):
    """Return the weight of value k in the interpolating polynomial.

    nodes: places of the values, of which those from `begin` to before `end` count; at: place of the interpolation.
    """
    weight = 1.0
    for i in range(begin, end):
        if i != k:
            weight *= (at - nodes[i]) / (nodes[k] - nodes[i])
    return weight
