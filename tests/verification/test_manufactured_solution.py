"""Verify the rotating plate by a manufactured solution.

x(X, t) = shift + R(omega t) (X + s(t) w(X)), s = AMPLITUDE sin(RATE t), with a smooth field w that is not zero on the
boundary. The nodal loads are its virtual work, of inertia and of the first Piola-Kirchhoff stress, so that the free
edges need no tractions. R rotates the stress, and the stress is a polynomial of third degree in s: the loads are
a few vectors, integrated once and to high order.
"""

import math

import numpy as np
import pytest
import skfem
from crushing_plates import corner_strips

from fem.laws.friction import Drag
from fem.model.impact_model import build_impact_model
from fem.plate.kinds import ELEMENT_KINDS
from fem.plate.properties import ContactProperties, PlateProperties, StepProperties, UnitProperties
from fem.run.impact import FirstTouch, ImpactStepper
from meshes import plate_mesh

LENGTH, WIDTH, THICKNESS = 2.0, 1.0, 0.1
DENSITY, MODULUS, RATIO = 1.0, 100.0, 0.3
OMEGA, RATE, AMPLITUDE, END = 1.0, 2.0, 0.02, 1.2
SHIFT = np.array([[0.0], [10.0]])
"""Away from the wall, which the plate does not touch."""

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])


def field(x):
    """w [m], shape of x."""
    a, b = 1.1 * x[0], 1.7 * x[1]
    return np.array([np.sin(a + 0.3) * np.cos(b), 0.7 * np.cos(a - 0.5) * np.sin(b + 0.2)])


def field_gradient(x):
    """dw_i/dX_k, shape (2, 2, ...)."""
    a, b = 1.1 * x[0], 1.7 * x[1]
    first = [1.1 * np.cos(a + 0.3) * np.cos(b), -1.7 * np.sin(a + 0.3) * np.sin(b)]
    second = [-0.77 * np.sin(a - 0.5) * np.sin(b + 0.2), 1.19 * np.cos(a - 0.5) * np.cos(b + 0.2)]
    return np.array([first, second])


def stress_terms(x):
    """Coefficients of the powers of s in the stress.

    P = s P_1 + s^2 P_2 + s^3 P_3 is the unrotated stress [Pa], each term has the shape (2, 2, ...).
    """
    g = field_gradient(x)

    def second_piola(e):
        """Plane stress of a symmetric strain."""
        trace, plane = e[0, 0] + e[1, 1], MODULUS / (1.0 + RATIO)
        return plane * (e + RATIO / (1.0 - RATIO) * trace * np.eye(2).reshape(2, 2, *(1,) * (e.ndim - 2)))

    def product(a, b):
        return np.einsum("ik...,kl...->il...", a, b)

    linear = second_piola(0.5 * (g + g.swapaxes(0, 1)))
    quadratic = second_piola(0.5 * np.einsum("ki...,kl...->il...", g, g))
    return linear, quadratic + product(g, linear), product(g, quadratic)


def rotation(t):
    """R(omega t)."""
    c, s = math.cos(OMEGA * t), math.sin(OMEGA * t)
    return np.array([[c, -s], [s, c]])


def exact(x, t):
    """Positions and velocities, shape of x each."""
    place = x + AMPLITUDE * math.sin(RATE * t) * field(x)
    velocity = AMPLITUDE * RATE * math.cos(RATE * t) * field(x) + OMEGA * np.tensordot(QUARTER, place, 1)
    place, velocity = (np.tensordot(rotation(t), values, 1) for values in (place, velocity))
    return place + SHIFT.reshape(2, *(1,) * (x.ndim - 1)), velocity


class Manufactured:
    """The plate and the vectors of its loads."""

    def __init__(self, kind, elements):
        plate = PlateProperties(THICKNESS, DENSITY, MODULUS, RATIO, element=kind)
        mesh = plate_mesh(LENGTH, WIDTH, elements, ELEMENT_KINDS[kind].cells)
        unit = UnitProperties(mesh, plate, ContactProperties(Drag(0.0), "crush", corner_strips(LENGTH, 1.0)))
        self.model = build_impact_model([unit], StepProperties())
        scalar = self.model.discretisation.scalar
        self.fine = skfem.CellBasis(scalar.mesh, scalar.elem, intorder=8)
        area = DENSITY * THICKNESS
        self.place = self._assembled(lambda v, w, i: area * w.x[i] * v)
        self.weight = self._assembled(lambda v, w, i: area * field(w.x)[i] * v)
        term = lambda k: (  # noqa: E731
            lambda v, w, i: THICKNESS * np.einsum("k...,k...->...", stress_terms(w.x)[k][i], v.grad)
        )
        self.stress = [self._assembled(term(k)) for k in range(3)]

    def _assembled(self, form):
        """Vectors along X and Y, shape (2, nodes)."""
        return np.array(
            [skfem.LinearForm(lambda v, w, i=i: form(v, w, i)).assemble(self.fine) for i in range(2)]
        )

    def loads(self, t):
        """Nodal forces [N], shape (2, nodes)."""
        s, rate = AMPLITUDE * math.sin(RATE * t), AMPLITUDE * RATE * math.cos(RATE * t)
        inertia = -(RATE**2 + OMEGA**2) * s * self.weight - OMEGA**2 * self.place
        inertia += 2.0 * OMEGA * rate * QUARTER @ self.weight
        return rotation(t) @ (inertia + sum(s ** (k + 1) * vector for k, vector in enumerate(self.stress)))

    def run(self, longest):
        """Positions at END with steps of bounded length [m], shape (2, nodes)."""
        stepper, body = ImpactStepper(self.model), self.model.discretisation.positions
        mass = self.model.parameters.mass
        steps = math.ceil(END / min(longest, self.model.parameters.time_step))
        dt = END / steps
        stepper.parameters = stepper.parameters._replace(time_step=dt)
        state = stepper.at_touch(FirstTouch(0.0, 0.0, 0.0))
        state.positions[:], state.velocities[:] = exact(body, 0.0)
        kick = stepper.record(state, 1, 1).state.velocities - state.velocities + dt * self.loads(0.0) / mass
        state.velocities[:] -= 0.5 * kick  # half a step back by the accelerations of the model
        for n in range(steps):
            state.velocities[:] += dt * self.loads(n * dt) / mass
            state = stepper.record(state, 1, 1).state
        assert state.contact.normal.max() == 0.0
        return state.positions + np.array([[state.origin[0]], [0.0]])

    def error(self, positions):
        """L2 norm of the error of the positions [m]."""
        expected = exact(np.asarray(self.fine.global_coordinates()), END)[0]
        fields = [np.asarray(self.fine.interpolate(component)) for component in positions]
        off = np.array(fields) - expected
        return math.sqrt(float(np.sum(off**2 * self.fine.dx)) / (LENGTH * WIDTH))


LINEAR, QUADRATIC = (2.0, (12, 24), 5e-4, 5e-5), (3.0, (6, 12), 2e-4, 2e-7)
"""Order, elements across, longest step [s], and limit of the error on the finest mesh [m]."""


@pytest.mark.parametrize(("kind", "expected"), [
    ("quad4", LINEAR), ("quad9", QUADRATIC), pytest.param("quad4-reduced", LINEAR, marks=pytest.mark.long),
    pytest.param("tri3", LINEAR, marks=pytest.mark.long),
])  # fmt: skip
def test_order_in_space(kind, expected):
    """Short steps have an error far below that in space."""
    order, meshes, longest, limit = expected
    errors = []
    for across in meshes:
        plate = Manufactured(kind, (2 * across, across))
        errors.append(plate.error(plate.run(longest)))
    observed = math.log2(errors[0] / errors[1])
    assert observed == pytest.approx(order, abs=0.1), errors
    assert errors[1] < limit


@pytest.mark.parametrize("kind", ["quad4", pytest.param("quad9", marks=pytest.mark.long)])
def test_order_in_time(kind):
    """On one mesh, against steps eight times as short."""
    plate = Manufactured(kind, (8, 4))
    longest = plate.model.parameters.time_step
    *coarse, reference = (plate.run(longest / k) for k in (4, 8, 16, 128))
    errors = [float(np.sqrt(np.mean((positions - reference) ** 2))) for positions in coarse]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders == pytest.approx(2.0, abs=0.1), (errors, orders)
