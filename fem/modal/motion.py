"""Accelerations and measures of the modal model, compiled.

Symbols and equations are those of docs/modal.md. A place is x and y of the corner by the retained modes alone [m],
the rotation of the frame [rad], which is minus the angle to the wall, and the modes' coordinates q [sqrt(kg) m]:
shape (3 + modes,). A speed is its rate. In the code w is the spin, a suffix `dot` a rate, and `_k` a number of mode
k.
"""

import math
from typing import NamedTuple

from fem.laws.friction import FRICTION_LAWS
from machine_code.compiled import by_law, compiled, reordered


class ModalMeasures(NamedTuple):
    """Measures of a state in SI units.

    They are those of `fem.explicit.columns`; the energy is kinetic and elastic.
    """

    theta: float
    omega: float
    v_gx: float
    v_gy: float
    slide: float
    reaction_normal: float
    energy: float


class Reaction(NamedTuple):
    """Reaction of the wall with the flexibility in the wall's frame.

    normal: N [N]; sigma: R over N; compliance: 1/k + Z_yy + sigma Z_xy, by which N closes the gap [m/N]. z_xx, z_xy,
    z_yy: Z, displacement of the corner by a force on it [m/N]; d_x, d_y: d, the same by the squared spin [m s^2].
    """

    normal: float
    sigma: float
    compliance: float
    z_xx: float
    z_xy: float
    z_yy: float
    d_x: float
    d_y: float


friction_slope = by_law(FRICTION_LAWS, "slope")


@compiled
def reaction(place, speed, model):
    """Return the `Reaction` that keeps the corner on the wall.

    With a spring it is kept on the spring. The corner is displaced by the reaction and by the spin.
    """
    cosine, sine, z = math.cos(place[2]), math.sin(place[2]), model.flexibility
    # Z and d of the omitted modes in the wall's frame: A Z A^T and A d
    z_xx = cosine * cosine * z[0, 0] - 2.0 * cosine * sine * z[0, 1] + sine * sine * z[1, 1]
    z_yy = sine * sine * z[0, 0] + 2.0 * cosine * sine * z[0, 1] + cosine * cosine * z[1, 1]
    z_xy = cosine * sine * (z[0, 0] - z[1, 1]) + (cosine * cosine - sine * sine) * z[0, 1]
    d_x, d_y = cosine * z[0, 2] - sine * z[1, 2], sine * z[0, 2] + cosine * z[1, 2]
    # N = -(y + w^2 d_y) / (1/k + Z_yy + sigma Z_xy)
    gap = place[1] + speed[2] * speed[2] * d_y
    sigma = friction_slope(model.friction, -gap, speed[0])
    compliance = model.compliance + z_yy + sigma * z_xy
    return Reaction(-gap / compliance, sigma, compliance, z_xx, z_xy, z_yy, d_x, d_y)


@reordered
def accelerate(place, speed, model, workspace, result):
    """Fill `result` with the accelerations, shape (3 + modes,).

    workspace: shape (2, modes).
    """
    phi, kappa = model.corner, model.flexibility[2, 2]
    wall, w = reaction(place, speed, model), speed[2]
    n, r, ww = wall.normal, wall.sigma * wall.normal, w * w
    cosine, sine = math.cos(place[2]), math.sin(place[2])
    f_x, f_y = cosine * r + sine * n, cosine * n - sine * r  # A^T F

    # s_P + phi_P q and its rate; J = J_0 + 2 b.q + q.q and J' = 2 (b + q).q'; per mode (G q)_k, and q_k'' but for w':
    # Q_k = phi_Pk . A^T F - W_k^2 q_k + w^2 (b_k + q_k) + 2 w (G q')_k
    s_x, s_y, sdot_x, sdot_y = model.arm[0], model.arm[1], 0.0, 0.0
    j, jdot, gq_load, gq_gq = model.inertia, 0.0, 0.0, 0.0
    for k in range(model.squares.size):
        q_k, qdot_k, gq_k, gqdot_k = place[3 + k], speed[3 + k], 0.0, 0.0
        for m in range(model.squares.size):
            gq_k += model.turning[k, m] * place[3 + m]
            gqdot_k += model.turning[k, m] * speed[3 + m]
        s_x += phi[0, k] * q_k
        s_y += phi[1, k] * q_k
        sdot_x += phi[0, k] * qdot_k
        sdot_y += phi[1, k] * qdot_k
        load_k = phi[0, k] * f_x + phi[1, k] * f_y - model.squares[k] * q_k
        load_k += ww * (model.growth[k] + q_k) + 2.0 * w * gqdot_k
        workspace[0, k], workspace[1, k] = gq_k, load_k
        j += (2.0 * model.growth[k] + q_k) * q_k
        jdot += 2.0 * (model.growth[k] + q_k) * qdot_k
        gq_load += gq_k * load_k
        gq_gq += gq_k * gq_k

    # a = A (s_P + phi_P q), and with the omitted modes a + Z F + w^2 d
    a_x, a_y = cosine * s_x - sine * s_y, sine * s_x + cosine * s_y
    full_x = a_x + wall.z_xx * r + wall.z_xy * n + ww * wall.d_x
    full_y = a_y + wall.z_xy * r + wall.z_yy * n + ww * wall.d_y

    # They add 2 (d.F + w^2 kappa) to J, where d.F = N (d_y + sigma d_x), and to J' with N' from the rate of the gap.
    # The terms of N' with w' are added to the factor of w'
    d_n, d_t = wall.d_y + wall.sigma * wall.d_x, wall.d_x - wall.sigma * wall.d_y
    turned = w * (2.0 * wall.z_xy + wall.sigma * (wall.z_xx - wall.z_yy))
    ndot = -(speed[1] + ww * w * wall.d_x + n * turned) / wall.compliance
    j += 2.0 * (d_n * n + ww * kappa)
    jdot += 2.0 * (d_n * ndot + w * d_t * n)
    j_wdot = 4.0 * ww * (kappa - d_n * wall.d_y / wall.compliance)

    # (J - |G q|^2) w' = a x F - w J' + (G q).Q
    torque = full_x * n - full_y * r - w * jdot + gq_load
    wdot = torque / (j + j_wdot - gq_gq)

    # q_k'' = Q_k + w' (G q)_k, and the corner's acceleration by it: phi_P q'' + 2 w z x phi_P q'
    bend_x = bend_y = 0.0
    for k in range(model.squares.size):
        result[3 + k] = workspace[1, k] + wdot * workspace[0, k]
        bend_x += phi[0, k] * result[3 + k]
        bend_y += phi[1, k] * result[3 + k]
    bend_x -= 2.0 * w * sdot_y
    bend_y += 2.0 * w * sdot_x

    # M c'' = F, and the corner at c + a: F / M + w' z x a - w^2 a + A (phi_P q'' + 2 w z x phi_P q')
    result[0] = r / model.mass - wdot * a_y - ww * a_x + cosine * bend_x - sine * bend_y
    result[1] = n / model.mass + wdot * a_x - ww * a_y + sine * bend_x + cosine * bend_y
    result[2] = wdot


@reordered
def measure_state(place, speed, model):
    """Return the `ModalMeasures` of a state."""
    phi, kappa = model.corner, model.flexibility[2, 2]
    wall, w = reaction(place, speed, model), speed[2]
    n, r = wall.normal, wall.sigma * wall.normal
    cosine, sine, ww = math.cos(place[2]), math.sin(place[2]), w * w

    # s_P + phi_P q and its rate, J, q.G q', and (q'.q' + sum W_k^2 q_k^2) / 2
    s_x, s_y, sdot_x, sdot_y = model.arm[0], model.arm[1], 0.0, 0.0
    j, q_gqdot, energy = model.inertia, 0.0, 0.0
    for k in range(model.squares.size):
        q_k, qdot_k = place[3 + k], speed[3 + k]
        for m in range(model.squares.size):
            q_gqdot += q_k * model.turning[k, m] * speed[3 + m]
        s_x += phi[0, k] * q_k
        s_y += phi[1, k] * q_k
        sdot_x += phi[0, k] * qdot_k
        sdot_y += phi[1, k] * qdot_k
        j += (2.0 * model.growth[k] + q_k) * q_k
        energy += 0.5 * (qdot_k * qdot_k + model.squares[k] * q_k * q_k)

    # c' = corner's speed - A (phi_P q' + w z x (s_P + phi_P q))
    sdot_x, sdot_y = sdot_x - w * s_y, sdot_y + w * s_x
    v_x, v_y = speed[0] - cosine * sdot_x + sine * sdot_y, speed[1] - sine * sdot_x - cosine * sdot_y

    # E = T + sum W^2 q^2 / 2 + F.Z F / 2 + 2 w^2 d.F + 3/2 w^4 kappa + N^2 / (2 k)
    energy += 0.5 * (model.mass * (v_x * v_x + v_y * v_y) + j * ww) + w * q_gqdot
    zf_x = wall.z_xx * r + wall.z_xy * n
    zf_y = wall.z_xy * r + wall.z_yy * n
    energy += 0.5 * (zf_x * r + zf_y * n + model.compliance * n * n)
    df = wall.d_x * r + wall.d_y * n
    energy += ww * (2.0 * df + 1.5 * ww * kappa)

    # The angular momentum J w + q.G q', over J with the omitted modes, is the best-fitting spin
    j += 2.0 * (df + ww * kappa)
    return ModalMeasures(
        theta=-place[2],
        omega=w + q_gqdot / j,
        v_gx=v_x,
        v_gy=v_y,
        slide=place[0] + zf_x + ww * wall.d_x,
        reaction_normal=n,
        energy=energy,
    )


@compiled
def measure_rows(table, model, result):
    """Fill `result` with the measures of all rows of `table`.

    result: shape (rows, fields of `ModalMeasures`). table: times, places and speeds.
    """
    modes = model.squares.size
    for row in range(table.shape[0]):
        measures = measure_state(table[row, 1 : 4 + modes], table[row, 4 + modes :], model)
        for i in range(len(measures)):
            result[row, i] = measures[i]
