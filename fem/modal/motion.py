"""Accelerations of the modal model, and what is read off its state; compiled. Symbols and equations: docs/modal.md.

A place is x and y of the corner as the kept modes alone put it [m], the frame's turn [rad], which is minus the angle
to the wall, and the modes' coordinates q [sqrt(kg) m]: shape (3 + modes,). A speed is its rate. In the code w is the
spin, a suffix `dot` a rate, and `_k` a number of mode k.

Steps of the modal model: two-stage Gauss collocation, as long as the motion allows; compiled.

The rule is of order four, A-stable, and keeps what a linear system keeps. Stiff are the modes and the corner's
spring: Newton's matrix is that of a diagonal and a column, and is inverted by hand, so that a step costs of the order
of modes squared. The two stages part by the two conjugate eigenvalues of the rule; one complex solution serves both.
"""

import math
from typing import NamedTuple

import numpy as np

from fem.laws.friction import FRICTION_LAWS
from fem.machine_code.compiled import by_law, compiled


class ModalMeasures(NamedTuple):
    """Measures of a state, SI: as in `fem.explicit.columns`; energy: kinetic and elastic."""

    theta: float
    omega: float
    v_gx: float
    v_gy: float
    slide: float
    reaction_normal: float
    energy: float


MEASURED = ModalMeasures._fields
"""Columns that `measure_rows` fills in."""


class Reaction(NamedTuple):
    """The wall's reaction, and the flexibility it follows from, turned to the wall's frame.

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
    """The `Reaction`: N is what keeps the corner, moved by it and the spin, on the wall or its spring."""
    cosine, sine, z = math.cos(place[2]), math.sin(place[2]), model.flexibility
    # Z and d of the modes left out in the wall's frame: A Z A^T and A d
    z_xx = cosine * cosine * z[0, 0] - 2.0 * cosine * sine * z[0, 1] + sine * sine * z[1, 1]
    z_yy = sine * sine * z[0, 0] + 2.0 * cosine * sine * z[0, 1] + cosine * cosine * z[1, 1]
    z_xy = cosine * sine * (z[0, 0] - z[1, 1]) + (cosine * cosine - sine * sine) * z[0, 1]
    d_x, d_y = cosine * z[0, 2] - sine * z[1, 2], sine * z[0, 2] + cosine * z[1, 2]
    # N = -(y + w^2 d_y) / (1/k + Z_yy + sigma Z_xy)
    gap = place[1] + speed[2] * speed[2] * d_y
    sigma = friction_slope(model.friction, -gap, speed[0])
    compliance = model.compliance + z_yy + sigma * z_xy
    return Reaction(-gap / compliance, sigma, compliance, z_xx, z_xy, z_yy, d_x, d_y)


@compiled
def accelerate(place, speed, model, workspace, result):
    """Fill `result` with the accelerations, shape (3 + modes,); workspace: shape (2, modes)."""
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
        for other in range(model.squares.size):
            gq_k += model.turning[k, other] * place[3 + other]
            gqdot_k += model.turning[k, other] * speed[3 + other]
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

    # a = A (s_P + phi_P q), and with the modes left out a + Z F + w^2 d
    a_x, a_y = cosine * s_x - sine * s_y, sine * s_x + cosine * s_y
    full_x = a_x + wall.z_xx * r + wall.z_xy * n + ww * wall.d_x
    full_y = a_y + wall.z_xy * r + wall.z_yy * n + ww * wall.d_y

    # They add 2 (d.F + w^2 kappa) to J, where d.F = N (d_y + sigma d_x); to J' with N' from the rate of the gap, and
    # what of that goes with w' to the factor of w'
    d_n, d_t = wall.d_y + wall.sigma * wall.d_x, wall.d_x - wall.sigma * wall.d_y
    turned = w * (2.0 * wall.z_xy + wall.sigma * (wall.z_xx - wall.z_yy))
    ndot = -(speed[1] + ww * w * wall.d_x + n * turned) / wall.compliance
    j += 2.0 * (d_n * n + ww * kappa)
    jdot += 2.0 * (d_n * ndot + w * d_t * n)
    j_wdot = 4.0 * ww * (kappa - d_n * wall.d_y / wall.compliance)

    # (J - |G q|^2) w' = a x F - w J' + (G q).Q
    torque = full_x * n - full_y * r - w * jdot + gq_load
    wdot = torque / (j + j_wdot - gq_gq)

    # q_k'' = Q_k + w' (G q)_k, and what it moves at the corner: phi_P q'' + 2 w z x phi_P q'
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


@compiled
def measure_state(place, speed, model):
    """The `ModalMeasures` of a state."""
    phi, kappa = model.corner, model.flexibility[2, 2]
    wall, w = reaction(place, speed, model), speed[2]
    n, r = wall.normal, wall.sigma * wall.normal
    cosine, sine, ww = math.cos(place[2]), math.sin(place[2]), w * w

    # s_P + phi_P q and its rate, J, q.G q', and (q'.q' + sum W_k^2 q_k^2) / 2
    s_x, s_y, sdot_x, sdot_y = model.arm[0], model.arm[1], 0.0, 0.0
    j, q_gqdot, energy = model.inertia, 0.0, 0.0
    for k in range(model.squares.size):
        q_k, qdot_k = place[3 + k], speed[3 + k]
        for other in range(model.squares.size):
            q_gqdot += q_k * model.turning[k, other] * speed[3 + other]
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

    # The angular momentum J w + q.G q', over J with the modes left out, is the spin that fits best
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
    """Fill `result`, shape (rows, MEASURED), from the times, places and speeds of `table`."""
    modes = model.squares.size
    for row in range(table.shape[0]):
        measures = measure_state(table[row, 1 : 4 + modes], table[row, 4 + modes :], model)
        for i in range(len(measures)):
            result[row, i] = measures[i]


NODE = 0.5 - math.sqrt(3.0) / 6.0
"""The first instant of a step, as a fraction of it; the second is as far from its end."""

STAGES = np.array([[0.25, NODE - 0.25], [0.75 - NODE, 0.25]])
TWICE = STAGES @ STAGES
_values, _vectors = np.linalg.eig(STAGES)
ROOT, BACK, THERE = complex(_values[0] ** 2), _vectors[:, 0].copy(), np.linalg.inv(_vectors)[0].copy()
"""An eigenvalue of TWICE, the column that brings its part of the stages back, the row that takes it there."""

TOLERANCE = 1e-13
"""Change of the corner's acceleration, over the centripetal, at which Newton's method has converged."""

STAGNATION = 1e-9
"""Change of the corner's acceleration at which it has converged where rounding keeps it from falling further."""

MAX_ITERATIONS = 30
"""Iterations of Newton's method in one step: it takes three to six."""

REACHED, STOPPED, DIVERGED, LATE = 0, 1, 2, 3
"""Ends of a run: at angle zero; with the corner at rest; without convergence; after the last row."""


@compiled
def stiff_part(place, speed, model, column, shapes):
    """Newton's matrix at a place: the corner's spring [N/m], and what a unit of its force accelerates.

    Fills `column` with the accelerations by a unit of N with its friction, shape (3 + modes,), and `shapes` with the
    modes' shapes at the corner in the wall's frame, shape (2, modes). Returns the spring.
    """
    wall = reaction(place, speed, model)
    cosine, sine = math.cos(place[2]), math.sin(place[2])
    a_x = cosine * model.arm[0] - sine * model.arm[1]
    a_y = sine * model.arm[0] + cosine * model.arm[1]
    angular = (a_x - wall.sigma * a_y) / model.inertia
    column[0] = wall.sigma / model.mass - angular * a_y
    column[1] = 1.0 / model.mass + angular * a_x
    column[2] = angular
    for k in range(model.squares.size):
        shapes[0, k] = cosine * model.corner[0, k] - sine * model.corner[1, k]
        shapes[1, k] = sine * model.corner[0, k] + cosine * model.corner[1, k]
        column[3 + k] = wall.sigma * shapes[0, k] + shapes[1, k]
        column[0] += shapes[0, k] * column[3 + k]
        column[1] += shapes[1, k] * column[3 + k]
    return 1.0 / wall.compliance


@compiled
def solve_stiff(factor, spring, column, shapes, squares, vector):
    """Replace `vector` by (1 + factor K)^-1 vector, K being what `stiff_part` describes; complex."""
    pivot, gap = 1.0 + factor * spring * column[1], vector[1]
    for k in range(squares.size):
        flexed = factor * squares[k] / (1.0 + factor * squares[k]) * shapes[1, k]
        gap -= flexed * vector[3 + k]
        pivot -= flexed * factor * spring * column[3 + k]
    gap /= pivot
    pushed = factor * spring * gap
    vector[0] -= column[0] * pushed
    vector[1] = gap
    vector[2] -= column[2] * pushed
    for k in range(squares.size):
        vector[3 + k] = (vector[3 + k] - pushed * column[3 + k]) / (1.0 + factor * squares[k])
        vector[0] -= factor * squares[k] * shapes[0, k] * vector[3 + k]


@compiled
def step_residual(place, speed, stages, step, model, workspace, vector):
    """Fill `vector` with what the stages' accelerations lack, in the part that belongs to ROOT."""
    at, rate, result, sweep = workspace[0], workspace[1], workspace[2], workspace[3:, 3:]
    vector[:] = 0.0
    for stage in range(2):
        along = step * (NODE if stage == 0 else 1.0 - NODE)
        for i in range(place.size):
            first, second = stages[0, i], stages[1, i]
            bend = TWICE[stage, 0] * first + TWICE[stage, 1] * second
            at[i] = place[i] + along * speed[i] + step * step * bend
            rate[i] = speed[i] + step * (STAGES[stage, 0] * first + STAGES[stage, 1] * second)
        accelerate(at, rate, model, sweep, result)
        for i in range(place.size):
            vector[i] += THERE[stage] * (result[i] - stages[stage, i])


@compiled
def gauss_step(place, speed, stages, step, model, workspace, vector):
    """Advance place and speed in place by one step [s].

    stages: guess of the accelerations at the step's two instants, shape (2, 3 + modes); replaced by what they were.
    workspace: shape (8, 3 + modes); vector: complex workspace, shape (3 + modes,). Returns the number of iterations, or
    0 if they did not converge; place and speed are then as they were.
    """
    at, column, shapes = workspace[0], workspace[5], workspace[6:, 3:]
    for i in range(place.size):
        at[i] = place[i] + 0.5 * step * speed[i]
    spring = stiff_part(at, speed, model, column, shapes)
    radius = math.hypot(model.arm[0], model.arm[1])
    scale, before, count = speed[2] * speed[2] * radius, math.inf, 0
    while True:
        step_residual(place, speed, stages, step, model, workspace, vector)
        solve_stiff(step * step * ROOT, spring, column, shapes, model.squares, vector)
        change = abs(vector[0]) + abs(vector[1]) + radius * abs(vector[2])
        for i in range(3, place.size):
            change += abs(vector[i]) * math.hypot(model.corner[0, i - 3], model.corner[1, i - 3])
        for stage in range(2):
            for i in range(place.size):
                stages[stage, i] += 2.0 * (BACK[stage] * vector[i]).real
        count += 1
        if change <= TOLERANCE * scale or (change <= STAGNATION * scale and change > 0.3 * before):
            break
        if not change < math.inf or count == MAX_ITERATIONS:
            return 0
        before = change
    for i in range(place.size):
        first, second = stages[0, i], stages[1, i]
        place[i] += step * speed[i] + 0.5 * step * step * ((1.0 - NODE) * first + NODE * second)
        speed[i] += 0.5 * step * (first + second)
    return count


@compiled
def run_to_strike(step, model, table, workspace, vector):
    """Fill `table`, shape (rows, 1 + 2 (3 + modes)), with time, place and speed at each step, up to angle zero.

    workspace: shape (14, 3 + modes); vector: complex, shape (3 + modes,). The table's first row is the start. The last
    step is as long as it takes to end at angle zero. Returns how the run ended, the number of rows filled, and the
    iterations of all steps.
    """
    half = 1 + table.shape[1] // 2
    stages, guess, place, speed = workspace[8:10], workspace[10:12], workspace[12], workspace[13]
    place[:], speed[:] = table[0, 1:half], table[0, half:]
    accelerate(place, speed, model, workspace[3:, 3:], stages[0])
    guess[0], guess[1] = stages[0], stages[0]
    iterations = 0
    for row in range(1, table.shape[0]):
        length = step
        for _ in range(MAX_ITERATIONS):
            stages[:] = guess
            taken = gauss_step(place, speed, stages, length, model, workspace, vector)
            iterations += taken
            if not taken:
                return DIVERGED, row, iterations
            if place[2] <= 0.0 and length == step:
                break
            miss = place[2] / speed[2]
            if abs(miss) <= 1e-14 * step:
                break
            length -= miss
            place[:], speed[:] = table[row - 1, 1:half], table[row - 1, half:]
        table[row, 0] = table[row - 1, 0] + length
        table[row, 1:half], table[row, half:] = place, speed
        if not speed[0] > 0.0:
            return STOPPED, row + 1, iterations
        if length != step:
            return REACHED, row + 1, iterations
        for i in range(place.size):  # the next step's stages lie near the straight line through these
            slope = (stages[1, i] - stages[0, i]) / (1.0 - 2.0 * NODE)
            guess[0, i], guess[1, i] = stages[0, i] + slope, stages[1, i] + slope
    return LATE, table.shape[0], iterations
