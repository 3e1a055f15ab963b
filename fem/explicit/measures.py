"""What is read off the plate at an instant: momenta, rotation, reactions, energies; compiled.

Velocities at instant n are the mean of those half a step before and after; with the kinetic energy as
m v_before . v_after / 2 and works by the trapezoidal rule, central differences keep the energy of a linear model
to rounding, so that what the ledger shows is the model's error and not the bookkeeping's.
"""

from __future__ import annotations

import math

from fem.compiled import compiled
from fem.constitutive.strain import deformation_gradient, green_strain
from fem.constitutive.stress import energy_density
from fem.contact.corner import add_corner_reaction, constraint_energy, weighted
from fem.explicit.columns import Measures
from fem.explicit.elastic_damping import damp
from fem.explicit.internal_force import subtract_internal_forces


@compiled
def measure(state, loop, viscosity, hourglass, reference, force, scratch):
    """The `Measures` of the state at its instant; the state is left as it is.

    reference: positions in the body frame [m], shape (2, nodes); the plate's angle is that of the rigid
    rotation that carries them onto the positions with the least mass-weighted square of distance.
    """
    positions, velocities, sums, origin = state
    half = 0.5 * loop.time_step
    force[:] = 0.0
    subtract_internal_forces(
        positions, velocities, viscosity, hourglass, force, loop.table, loop.material, scratch
    )
    damping_power = damp(
        loop.elastic_damping, positions, velocities, loop.mass, loop.time_step, scratch.motion, force
    )
    normal, tangential, slip, later_slip, _ = add_corner_reaction(
        positions, velocities, loop.mass, loop.time_step, loop.corner, loop.friction, force
    )
    theta, omega, v_x, v_y, kinetic, vibration, _, _ = motion(positions, velocities, force, loop, reference)
    gap, hourglass_energy = weighted(positions[1], loop.corner), 0.0
    if hourglass is not None:
        hourglass_energy = energy_of_hourglass(positions, loop.table, hourglass)
    return Measures(
        theta=theta,
        omega=omega,
        v_gx=v_x,
        v_gy=v_y,
        slide=origin[0] + weighted(positions[0], loop.corner),
        v_p=0.5 * (slip + later_slip),
        reaction_normal=normal,
        reaction_tangential=tangential,
        kinetic_energy=kinetic,
        strain_energy=energy_of_strain(positions, loop.table, loop.material),
        contact_energy=constraint_energy(loop.corner.constraint, gap),
        friction_work=sums[0] + half * tangential * slip,
        damping_work=sums[1] + half * damping_power,
        vibration_energy=vibration,
        normal_impulse=sums[2] + half * normal,
        normal_impulse_magnitude=sums[3] + half * abs(normal),
        gap=gap,
        hourglass_energy=hourglass_energy,
    )


@compiled
def motion(positions, velocities, force, loop, reference):
    """Angle, spin, centre's velocity, kinetic energy of the ledger, kinetic energy beside the rigid motion, centre."""
    mass, half = loop.mass, 0.5 * loop.time_step
    total = c_x = c_y = b_x = b_y = v_x = v_y = kinetic = 0.0
    for i in range(mass.size):
        m = mass[i]
        d_x, d_y = half * force[0, i] / m, half * force[1, i] / m
        u_x, u_y = velocities[0, i] + d_x, velocities[1, i] + d_y
        total += m
        c_x += m * positions[0, i]
        c_y += m * positions[1, i]
        b_x += m * reference[0, i]
        b_y += m * reference[1, i]
        v_x += m * u_x
        v_y += m * u_y
        kinetic += 0.5 * m * (u_x * u_x + u_y * u_y - d_x * d_x - d_y * d_y)
    c_x, c_y, b_x, b_y = c_x / total, c_y / total, b_x / total, b_y / total
    v_x, v_y = v_x / total, v_y / total
    cosine = sine = spin = inertia = 0.0
    for i in range(mass.size):
        m = mass[i]
        x, y = positions[0, i] - c_x, positions[1, i] - c_y
        r_x, r_y = reference[0, i] - b_x, reference[1, i] - b_y
        u_x = velocities[0, i] + half * force[0, i] / m - v_x
        u_y = velocities[1, i] + half * force[1, i] / m - v_y
        cosine += m * (r_x * x + r_y * y)
        sine += m * (r_x * y - r_y * x)
        spin += m * (x * u_y - y * u_x)
        inertia += m * (x * x + y * y)
    omega, vibration = spin / inertia, 0.0
    for i in range(mass.size):
        u_x = velocities[0, i] + half * force[0, i] / mass[i] - v_x + omega * (positions[1, i] - c_y)
        u_y = velocities[1, i] + half * force[1, i] / mass[i] - v_y - omega * (positions[0, i] - c_x)
        vibration += 0.5 * mass[i] * (u_x * u_x + u_y * u_y)
    return -math.atan2(sine, cosine), omega, v_x, v_y, kinetic, vibration, c_x, c_y


@compiled
def energy_of_strain(positions, table, material):
    congruent = table.weights.shape[1] == 1
    energy = 0.0
    for element in range(table.connectivity.shape[1]):
        column = 0 if congruent else element
        for point in range(table.weights.shape[0]):
            f_11, f_12, f_21, f_22 = deformation_gradient(positions, table, point, element)
            e_11, e_22, g_12 = green_strain(f_11, f_12, f_21, f_22)
            energy += table.weights[point, column] * energy_density(material, e_11, e_22, g_12)
    return energy


@compiled
def energy_of_hourglass(positions, table, hourglass):
    energy = 0.0
    for element in range(table.connectivity.shape[1]):
        column = 0 if hourglass.vectors.shape[1] == 1 else element
        f_11, f_12, f_21, f_22 = deformation_gradient(positions, table, 0, element)
        q_1 = q_2 = 0.0
        for a in range(len(table.per_element)):
            node = table.connectivity[a, element]
            q_1 += hourglass.vectors[a, column] * positions[0, node]
            q_2 += hourglass.vectors[a, column] * positions[1, node]
        p_1, p_2 = f_11 * q_1 + f_21 * q_2, f_12 * q_1 + f_22 * q_2
        k_11, k_22, k_12 = hourglass.stiffness[:, column]
        energy += 0.5 * (k_11 * p_1 * p_1 + k_22 * p_2 * p_2) + k_12 * p_1 * p_2
    return energy
