"""Verify small motions and static tilt of a vehicle in space."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import root
from space_motions import pushes
from space_vehicles import FAR, MASS, axle, truck, truck_unit
from test_space_exact import pushed

from solver.body import GRAVITY
from solver.space import SpaceVehicle
from solver.space.columns import AXLE_GYRATION


def axle_weights(vehicle):
    """Return the loads of two axles by levers [N]."""
    unit, (front, rear) = vehicle.units[0], vehicle.axles
    behind = unit.mass * GRAVITY * (unit.centre_of_mass - front.position) / (rear.position - front.position)
    return unit.mass * GRAVITY - behind, behind


class TenDegrees:
    """A truck with two axles in ten coordinates, independent of the solver.

    Coordinates: position of the sprung centre, three angles, and heave and roll of the axles relative to the body.
    """

    def __init__(self, vehicle):
        unit, self.axles = vehicle.units[0], vehicle.axles
        self.sprung = unit.mass - sum(a.mass for a in self.axles)
        self.x = (
            -unit.mass * unit.centre_of_mass + sum(a.mass * a.position for a in self.axles)
        ) / self.sprung
        self.z = (unit.mass * unit.centre_height - sum(a.mass * a.radius for a in self.axles)) / self.sprung
        self.loads = axle_weights(vehicle)
        self.rods = [a.mass * (AXLE_GYRATION * a.track) ** 2 for a in self.axles]
        places = [
            np.array([self.x, 0.0, self.z]),
            *(np.array([-a.position, 0.0, a.radius]) for a in self.axles),
        ]
        arms = [place - np.array([-unit.centre_of_mass, 0.0, unit.centre_height]) for place in places]
        self.tensor = np.diag([unit.roll_inertia, unit.pitch_inertia, unit.yaw_inertia])
        for m, r in zip((self.sprung, *(a.mass for a in self.axles)), arms, strict=True):
            self.tensor -= m * (r @ r * np.eye(3) - np.outer(r, r))
        self.tensor -= np.diag([sum(self.rods), 0.0, sum(self.rods)])

    def place(self, c, at, number=None):
        """Return the position of a point of body or axle."""
        at = np.array(at, dtype=float)
        if number is not None:
            centre = np.array([0.0, 0.0, self.axles[number].roll_centre])
            a = c[7 + 2 * number]
            tilt = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
            at = tilt @ (at - centre) + centre + np.array([0.0, 0.0, c[6 + 2 * number]])
        centre = np.array([self.x, 0.0, self.z])
        return centre + c[:3] + rotation_of(c[3:6]) @ (at - centre)

    def potential(self, c):
        """Return the energy of gravity, springs and tyres [J]."""
        total = self.sprung * GRAVITY * c[2]
        for number, (a, load) in enumerate(zip(self.axles, self.loads, strict=True)):
            total += a.mass * GRAVITY * self.place(c, (-a.position, 0.0, a.radius), number)[2]
            for side in (-0.5, 0.5):
                closing = c[6 + 2 * number] + side * a.spacing * math.sin(c[7 + 2 * number])
                total += 0.5 * a.spring * closing**2 + 0.5 * (load - a.mass * GRAVITY) * closing
                lowest = (-a.position, side * a.track, -0.5 * load / a.tyre)
                total += 0.5 * a.tyre * max(-self.place(c, lowest, number)[2], 0.0) ** 2
        return total

    def stiffness(self):
        """Return the second derivatives of the potential at rest."""
        step, size = 1e-4, 10
        shifts = step * np.eye(size)
        matrix = np.zeros((size, size))
        for i in range(size):
            for j in range(i + 1):
                signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
                values = [a * b * self.potential(a * shifts[i] + b * shifts[j]) for a, b in signs]
                matrix[i, j] = matrix[j, i] = math.fsum(values) / (4.0 * step**2)
        return matrix

    def jacobian(self, at, number=None):
        """Return the derivatives of a point by the coordinates, shape (3, 10)."""
        shifts = 1e-5 * np.eye(10)
        return np.array([(self.place(d, at, number) - self.place(-d, at, number)) / 2e-5 for d in shifts]).T

    def mass(self):
        """Return the mass matrix at rest."""
        rows = self.jacobian((self.x, 0.0, self.z))
        matrix = self.sprung * rows.T @ rows
        matrix[3:6, 3:6] += self.tensor
        for number, (a, rod) in enumerate(zip(self.axles, self.rods, strict=True)):
            rows = self.jacobian((-a.position, 0.0, a.radius), number)
            matrix += a.mass * rows.T @ rows
            turning = np.zeros((2, 10))
            turning[0, 3] = turning[0, 7 + 2 * number] = turning[1, 5] = 1.0
            matrix += rod * turning.T @ turning
        return matrix


def rotation_of(angles):
    """Return the rotation by roll, pitch and yaw."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    roll = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    pitch = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    yaw = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return yaw @ pitch @ roll


@pytest.mark.parametrize("force", [{"across": 0.1}, {"up": 0.3, "ahead": 2.0}])
def test_small_motions_are_those_of_ten_linear_degrees(force):
    """Heave, pitch and roll under a force follow from ten eigenmodes."""
    nominal = truck(friction=0.0, damping_ratio=0.0)
    heavy = replace(nominal.axles[0], mass=1500.0)  # then the sprung mass has a product of inertia
    undamped = replace(nominal, axles=(heavy, nominal.axles[1]))
    model = TenDegrees(undamped)
    squares, modes = eigh(model.stiffness(), model.mass())
    interval, end = 5e-3, 2.0
    h = pushed(undamped, pushes(round(end / interval), height=1.35, **force), interval, 5e-5, end)
    at = np.array([-5.0 + force.get("ahead", 0.0), 0.0, 1.35])
    load = np.array([0.0, force.get("across", 0.0), force.get("up", 0.0)])
    t, response = h["t"], np.zeros((h["t"].size, 10))
    for square, mode, amount in zip(squares, modes.T, modes.T @ model.jacobian(at).T @ load, strict=True):
        rate = math.sqrt(abs(square))
        factor = 0.5 * t**2 if rate < 0.05 else (1.0 - np.cos(rate * t)) / square
        response += np.outer(amount * factor, mode)
    vertical = {"pitch": 4, "heave_1": 6, "heave_2": 8}
    names = vertical if "up" in force else {"roll": 3, "axle_roll_1": 7, "axle_roll_2": 9}
    for name, column in names.items():
        scale = np.abs(response[:, column]).max()
        assert scale > 1e-9
        assert np.abs(h[name] - response[:, column]).max() < 1e-5 * scale, name


TILTED = SpaceVehicle(
    (truck_unit(),), (axle(2.0, friction=3.0, roll_centre=0.6), axle(8.0, friction=3.0, roll_centre=0.6)), FAR
)
"""A truck with equal axles, whose tilt is a plane problem."""


def tilt(c, force):
    """Return the residual forces and moments under a side force.

    c: height of the centre less that at rest, roll of the body, heave and roll of both axles. Written by moments.
    """
    unit, a = TILTED.units[0], TILTED.axles[0]
    weight, load = MASS * GRAVITY, 0.5 * MASS * GRAVITY
    sprung, below = MASS - 2.0 * a.mass, a.roll_centre - a.radius
    height = (MASS * unit.centre_height - 2.0 * a.mass * a.radius) / sprung
    lift, roll, heave, joint = c
    up, across = np.array([-math.sin(roll), math.cos(roll)]), np.array([math.cos(roll), math.sin(roll)])
    centre = np.array([0.0, height + lift])
    pivot = centre + (a.roll_centre - height + heave) * up
    turned = np.array([[math.cos(joint), -math.sin(joint)], [math.sin(joint), math.cos(joint)]])
    basis = np.array([across, up]).T
    axle_centre = pivot + basis @ turned @ [0.0, -below]
    point = centre + (unit.centre_height - height) * up  # of the force, fixed to the body
    loads, feet = [], []
    for side in (-0.5, 0.5):
        foot = pivot + basis @ turned @ [side * a.track, -a.roll_centre - 0.5 * load / a.tyre]
        loads.append(-2.0 * a.tyre * foot[1])
        feet.append(foot[0])
    preload = load - a.mass * GRAVITY
    springs = [
        0.5 * preload + a.spring * (heave + side * a.spacing * math.sin(joint)) for side in (-0.5, 0.5)
    ]
    # Both axles together; the ground pushes up by the loads, and to the side by the force.
    upward = sum(loads) - weight
    of_axles = (2.0 * a.mass * np.array([0.0, -GRAVITY]) + np.array([-force, sum(loads)])) @ up - 2.0 * sum(
        springs
    )
    about = -force * point[1] + sum(n * (x - point[0]) for n, x in zip(loads, feet, strict=True))
    about -= GRAVITY * (sprung * (centre[0] - point[0]) + 2.0 * a.mass * (axle_centre[0] - point[0]))
    about_pivot = sum(n * (x - pivot[0]) for n, x in zip(loads, feet, strict=True)) - force * pivot[1]
    about_pivot -= 2.0 * a.mass * GRAVITY * (axle_centre[0] - pivot[0])
    about_pivot -= 2.0 * sum(
        n * side * a.spacing * math.cos(joint) for n, side in zip(springs, (-0.5, 0.5), strict=True)
    )
    return [upward, of_axles, about, about_pivot], loads


def balanced(function, guess):
    """Return where a function vanishes."""
    solution = root(function, guess, tol=1e-13).x
    assert np.abs(function(solution)).max() < 1e-4
    return solution


@pytest.fixture(scope="module")
def lifting():
    """Return the force that unloads the right wheels, and its equilibrium."""
    rest = np.array([0.0, -1e-3, 0.0, -1e-3])

    def unloaded(values):
        balance, loads = tilt(values[:4], 1e4 * values[4])
        return [*balance, loads[0]]

    for force in np.arange(1e3, 4e4, 1e3):
        rest = balanced(lambda c, f=force: tilt(c, f)[0], rest)
    return 1e4 * balanced(unloaded, [*rest, 4.0])[4], rest


def tilted(force):
    """Return the history under a side force that increases slowly."""
    grown = np.clip((np.arange(4000) + 0.5) / 3000.0, 0.0, 1.0)
    rise = grown**3 * (10.0 - 15.0 * grown + 6.0 * grown**2)
    push = pushes(4000, across=force * rise)
    damped = replace(TILTED, axles=tuple(replace(a, damping_ratio=0.6) for a in TILTED.axles))
    return pushed(damped, push, 2e-2, 1e-3, 80.0)


@pytest.mark.parametrize("part", [0.5, 0.9])
def test_tilt_by_a_side_force(lifting, part):
    """Static roll by springs and tyres in series, with the lean."""
    limit, rest = lifting
    assert 0.6 < limit / (MASS * GRAVITY * 0.5 * 1.85 / 1.35) < 0.95  # the body's lean takes the rest
    expected = balanced(lambda c: tilt(c, part * limit)[0], rest)
    h = tilted(part * limit)
    assert h["roll"][-1] == pytest.approx(expected[1], rel=1e-4)
    assert h["axle_roll_1"][-1] == pytest.approx(expected[3], rel=1e-4)
    assert h["load_left_1"][-1] == pytest.approx(0.5 * tilt(expected, part * limit)[1][1], rel=1e-4)


def test_wheels_lift_at_the_force_of_equilibrium(lifting):
    """The load of the right wheels vanishes within 1e-4 of that force."""
    limit, _ = lifting
    assert tilted((1.0 - 1e-4) * limit)["load_right_1"].min() > 0.0
    assert tilted((1.0 + 1e-4) * limit)["load_right_1"].min() == 0.0
