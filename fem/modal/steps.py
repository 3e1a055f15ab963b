"""Steps of the modal model: two-stage Gauss collocation, as long as the motion allows; compiled.

The rule is of order four, A-stable, and keeps what a linear system keeps. Stiff are the modes and the corner's
spring: Newton's matrix is that of a diagonal and a column, and is inverted by hand, so that a step costs of the order
of modes squared. The two stages part by the two conjugate eigenvalues of the rule; one complex solution serves both.
"""

from __future__ import annotations

import math

import numpy as np

from fem.machine_code.compiled import compiled
from fem.modal.motion import accelerate, reaction

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
def _copy(source, target):
    for i in range(source.size):
        target[i] = source[i]


@compiled
def _read_row(row, place, speed):
    for i in range(place.size):
        place[i], speed[i] = row[1 + i], row[1 + place.size + i]


@compiled
def run_to_strike(step, model, table, workspace, vector):
    """Fill `table`, shape (rows, 1 + 2 (3 + modes)), with time, place and speed at each step, up to angle zero.

    workspace: shape (14, 3 + modes); vector: complex, shape (3 + modes,). The table's first row is the start. The last
    step is as long as it takes to end at angle zero. Returns how the run ended, the number of rows filled, and the
    iterations of all steps.
    """
    size = table.shape[1] // 2
    stages, guess, place, speed = workspace[8:10], workspace[10:12], workspace[12], workspace[13]
    _read_row(table[0], place, speed)
    accelerate(place, speed, model, workspace[3:, 3:], stages[0])
    _copy(stages[0], guess[0])
    _copy(stages[0], guess[1])
    iterations = 0
    for row in range(1, table.shape[0]):
        length = step
        for _ in range(MAX_ITERATIONS):
            _copy(guess[0], stages[0])
            _copy(guess[1], stages[1])
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
            _read_row(table[row - 1], place, speed)
        table[row, 0] = table[row - 1, 0] + length
        for i in range(size):
            table[row, 1 + i], table[row, 1 + size + i] = place[i], speed[i]
        if not speed[0] > 0.0:
            return STOPPED, row + 1, iterations
        if length != step:
            return REACHED, row + 1, iterations
        for i in range(size):  # the next step's stages lie near the straight line through these
            slope = (stages[1, i] - stages[0, i]) / (1.0 - 2.0 * NODE)
            guess[0, i], guess[1, i] = stages[0, i] + slope, stages[1, i] + slope
    return LATE, table.shape[0], iterations
