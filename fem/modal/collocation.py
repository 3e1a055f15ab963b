"""Steps of the modal model by two-stage Gauss collocation, compiled.

The rule is of order four, A-stable, and conserves the quadratic invariants of a linear system. The modes and the
corner's spring are stiff. Newton's matrix is the sum of a diagonal and a column, and is inverted analytically, so that
the cost of a step is of the order of modes squared. The two stages are decoupled by the two conjugate eigenvalues of
the rule, and one complex solution serves both.
"""

import math

import numpy as np

from fem.modal.motion import accelerate, reaction
from machine_code.compiled import compiled

NODE = 0.5 - math.sqrt(3.0) / 6.0
"""First instant of a step as a fraction; the second has the same distance from its end."""

STAGES = np.array([[0.25, NODE - 0.25], [0.75 - NODE, 0.25]])
"""Weights of the stages in the velocities at both instants."""

SQUARED_STAGES = STAGES @ STAGES
"""Weights of the stages in the positions at both instants."""

_values, _vectors = np.linalg.eig(STAGES)

ROOT, FROM_COMPLEX, TO_COMPLEX = (
    complex(_values[0] ** 2),
    _vectors[:, 0].copy(),
    np.linalg.inv(_vectors)[0].copy(),
)
"""An eigenvalue of SQUARED_STAGES, with the column and the row of its eigenvectors.

The row transforms the stages to the complex unknown, the column transforms them back.
"""

TOLERANCE = 1e-13
"""Change of the corner's acceleration, over the centripetal one, at which Newton's method ends."""

STAGNATION = 1e-9
"""Change of the corner's acceleration at which stagnation by rounding is accepted."""

MAX_ITERATIONS = 30
"""Largest number of Newton iterations in a step, of which three to six are usual."""

REACHED, STOPPED, DIVERGED, TIMED_OUT = 0, 1, 2, 3
"""Ends of a run: at angle zero; with the corner at rest; without convergence; after the last row."""


@compiled
def stiff_part(place, speed, model, column, shapes):
    """Compute Newton's matrix at a place, and return its spring [N/m].

    `column` receives the accelerations by a unit of N with its friction, shape (3 + modes,), and `shapes` the modes'
    shapes at the corner in the wall's frame, shape (2, modes).
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
    """Replace `vector` by (1 + factor K)^-1 vector, complex.

    K is the matrix of `stiff_part`.
    """
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
    """Fill `vector` with the residual of the stages' accelerations.

    It is the part of the residual that belongs to ROOT.
    """
    at, rate, result, sweep = workspace[0], workspace[1], workspace[2], workspace[3:, 3:]
    vector[:] = 0.0
    for stage in range(2):
        along = step * (NODE if stage == 0 else 1.0 - NODE)
        for i in range(place.size):
            first, second = stages[0, i], stages[1, i]
            bend = SQUARED_STAGES[stage, 0] * first + SQUARED_STAGES[stage, 1] * second
            at[i] = place[i] + along * speed[i] + step * step * bend
            rate[i] = speed[i] + step * (STAGES[stage, 0] * first + STAGES[stage, 1] * second)
        accelerate(at, rate, model, sweep, result)
        for i in range(place.size):
            vector[i] += TO_COMPLEX[stage] * (result[i] - stages[stage, i])


@compiled
def gauss_step(place, speed, stages, step, model, workspace, vector):
    """Advance place and speed in place by one step [s].

    stages: guess of the accelerations at the step's two instants, shape (2, 3 + modes), replaced by their solution.
    workspace: shape (8, 3 + modes); vector: complex workspace, shape (3 + modes,). Returns the number of iterations,
    or 0 if they did not converge; place and speed are then unchanged.
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
                stages[stage, i] += 2.0 * (FROM_COMPLEX[stage] * vector[i]).real
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
    """Fill `table` with all steps up to angle zero.

    table: time, place and speed, shape (rows, 1 + 2 (3 + modes)); its first row is the start. workspace: shape (14, 3
    + modes); vector: complex, shape (3 + modes,). The length of the last step is adjusted to end at angle zero.
    Returns the end of the run, the number of rows filled, and the iterations of all steps.
    """
    half = 1 + table.shape[1] // 2
    stages, guess, place, speed = workspace[8:10], workspace[10:12], workspace[12], workspace[13]
    _copy(table[0, 1:half], place)
    _copy(table[0, half:], speed)
    accelerate(place, speed, model, workspace[3:, 3:], stages[0])
    _copy(stages[0], guess[0])
    _copy(stages[0], guess[1])
    iterations = 0
    for row in range(1, table.shape[0]):
        length = step
        for _ in range(MAX_ITERATIONS):
            _copy(guess[0], stages[0])
            _copy(guess[1], stages[1])
            count = gauss_step(place, speed, stages, length, model, workspace, vector)
            iterations += count
            if not count:
                return DIVERGED, row, iterations
            if place[2] <= 0.0 and length == step:
                break
            miss = place[2] / speed[2]
            if abs(miss) <= 1e-14 * step:
                break
            length -= miss
            _copy(table[row - 1, 1:half], place)
            _copy(table[row - 1, half:], speed)
        table[row, 0] = table[row - 1, 0] + length
        _copy(place, table[row, 1:half])
        _copy(speed, table[row, half:])
        if not speed[0] > 0.0:
            return STOPPED, row + 1, iterations
        if length != step:
            return REACHED, row + 1, iterations
        for i in range(place.size):  # linear extrapolation to the stages of the next step
            slope = (stages[1, i] - stages[0, i]) / (1.0 - 2.0 * NODE)
            guess[0, i], guess[1, i] = stages[0, i] + slope, stages[1, i] + slope
    return TIMED_OUT, table.shape[0], iterations


@compiled
def _copy(values, target):
    """Copy a vector."""
    for i in range(target.size):
        target[i] = values[i]
