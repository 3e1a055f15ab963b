"""Validate the program by published cases of other programs.

They are Code_Aster's SDND100 and SSNV128, NAFEMS' CGS-4 and FV32, and Cook's membrane. Body forces and loads act in the
tests only; docs/reference-cases.md lists the results.
"""

import math

import numpy as np
import pytest
from scipy.sparse import diags
from scipy.sparse.linalg import eigsh, spsolve

from fem.laws.friction import Drag
from fem.model.impact_model import build_impact_model
from fem.model.plate_model import unit_plate
from fem.plate.properties import ContactProperties, PlateProperties, StepProperties, UnitProperties
from fem.run.impact import FirstTouch, ImpactStepper
from meshes import plate_mesh

GRAVITY = 10.0  # [m/s^2], as SDND100 has it
DAMPED = 0.1
"""Part of the velocity relative to the centre that a block loses in each step."""


class PressedBlock:
    """A stiff block of 1 kg at rest on the wall.

    across: body force across the wall over the weight. Friction lets a block without damping flutter.
    """

    def __init__(self, friction, across=1.0):
        plate = PlateProperties(0.01, 1.0 / (1.0 * 0.1 * 0.01), 1e8, 0.0)
        unit = UnitProperties(
            plate_mesh(1.0, 0.1, (8, 2)), plate, ContactProperties(Drag(friction), "penalty")
        )
        self.model = build_impact_model([unit], StepProperties())
        self.stepper, self.across = ImpactStepper(self.model), across
        self.mass, self.time_step = self.model.parameters.mass, self.model.parameters.time_step
        self.state = self.stepper.at_touch(FirstTouch(0.0, 0.0, 0.0))
        for _ in range(2000):
            self.state.velocities[:] *= 0.98
            self.step(0.0)
        self.state.velocities[:] = 0.0
        self.start = float(self.mass @ self.state.positions[0]) + self.state.origin[0]

    def step(self, along):
        """Advance one step under a body force along the wall [m/s^2]."""
        centre = self.state.velocities @ self.mass
        self.state.velocities[:] -= DAMPED * (self.state.velocities - centre[:, None])
        self.state.velocities[0] += self.time_step * along
        self.state.velocities[1] -= self.time_step * GRAVITY * self.across
        self.state = self.stepper.record(self.state, 1, 1).state

    @property
    def place(self):
        """Displacement of the centre along the wall [m]."""
        return float(self.mass @ self.state.positions[0]) + self.state.origin[0] - self.start

    @property
    def speed(self):
        """Velocity of the centre along the wall [m/s]."""
        return float(self.mass @ self.state.velocities[0])


def test_sdnd100_released_friction_pad():
    """Half periods of a pad on a spring decrease by 0.2 mm.

    m = 1 kg, k = 1e4 N/m, mu = 0.1, released at 0.85 mm.
    """
    pad = PressedBlock(0.1)
    times: list[float] = []
    places: list[float] = []
    while len(times) * pad.time_step < 0.2:
        times.append(len(times) * pad.time_step)
        places.append(0.85e-3 + pad.place)
        pad.step(-1e4 * places[-1])
    ends = 1e3 * np.interp(np.arange(1, 7) * math.pi / 100.0, times, places)
    assert ends[:4] == pytest.approx([-0.65, 0.45, -0.25, 0.05], abs=1e-3)
    assert ends[4:] == pytest.approx([0.05, 0.05], abs=1e-3)


def test_cgs_4_sliding_wedge():
    """It slides from a horizontal force of 0.412371 weights.

    This is (tan a + mu)/(1 - mu tan a) for tan a = 0.1 and mu = 0.3.
    """

    mu, angle, reference = 0.3, math.atan(0.1), 0.412371

    def places(force):
        """Instants [s] and positions [m] along the slope under this force."""
        wedge, rows = PressedBlock(mu, force * math.sin(angle) + math.cos(angle)), []
        along = force * math.cos(angle) - math.sin(angle)
        for n in range(round(0.2 / wedge.time_step)):
            wedge.step(GRAVITY * along * min(1.0, n * wedge.time_step / 0.05))
            rows.append((n * wedge.time_step, wedge.place))
        t, place = np.array(rows).T
        return t[t > 0.06], place[t > 0.06]

    t, place = places(0.999 * reference)
    assert np.ptp(place[t > 0.15]) < 1e-12
    forces = np.array([1.02, 1.04]) * reference
    motions = [places(force) for force in forces]
    rates = np.array([2.0 * np.polyfit(t, place, 2)[0] for t, place in motions])
    threshold = forces[0] - rates[0] * np.diff(forces)[0] / np.diff(rates)[0]
    assert threshold == pytest.approx(reference, abs=1e-6)


def edge_loads(place, side, traction):
    """Nodal forces of a traction on a side [N/m], shape of place."""
    nodes = np.flatnonzero(side)
    nodes, loads = nodes[np.argsort(place[nodes])], np.zeros(place.size)
    lengths = np.diff(place[nodes])
    loads[nodes[:-1]] += 0.5 * traction * lengths
    loads[nodes[1:]] += 0.5 * traction * lengths
    return loads


@pytest.mark.parametrize("law", ["exact", "penalty"])
def test_ssnv128_plate_with_friction_on_a_rigid_plane(law):
    """A square of 40 mm is pressed from above and the side.

    mu = 1, plane strain; both halves are modelled, with damping.
    """
    size, modulus, ratio, density = 0.04, 1.3e11, 0.2, 7800.0
    plate = PlateProperties(1.0, density, modulus / (1.0 - ratio**2), ratio / (1.0 - ratio))
    mesh, contact = plate_mesh(2.0 * size, size, (64, 32)), ContactProperties(Drag(1.0), law)
    model = build_impact_model([UnitProperties(mesh, plate, contact)], StepProperties())
    stepper, (x, y) = ImpactStepper(model), model.discretisation.positions
    at_left, at_right, top = np.isclose(x, -2.0 * size), np.isclose(x, 0.0), np.isclose(y, size)
    along = edge_loads(y, at_left, 15e7) - edge_loads(y, at_right, 15e7)
    loads = np.array([along, edge_loads(x, top, -5e7)])
    dt, period = model.parameters.time_step, 4.0 * size / math.sqrt(plate.youngs_modulus / density)
    state, ramp = stepper.at_touch(FirstTouch(0.0, 0.0, 0.0)), 30.0 * period
    start = state.positions[0] - x
    for n in range(round(1.3 * ramp / dt)):
        state.velocities[:] *= 1.0 - 4.0 * dt / period
        state.velocities[:] += dt * min(1.0, n * dt / ramp) * loads / model.parameters.mass
        state = stepper.record(state, 1, 1).state
    slide = state.positions[0] + state.origin[0] - x - start
    face = np.flatnonzero(np.isclose(y, 0.0))
    face = face[np.argsort(x[face])]
    symmetric = 0.5 * (slide[face] - slide[face][::-1])
    displacements = np.interp([0.0, 1.25e-3, 5e-3, 7.5e-3, 11.25e-3], x[face] + 2.0 * size, symmetric)
    assert displacements == pytest.approx([2.86e-5, 2.72e-5, 2.28e-5, 1.98e-5, 1.50e-5], rel=0.05)


def tapered(length, root, tip, elements, rise=0.0):
    """Mesh of a trapezoid from x = -length to x = 0.

    root and tip are its heights there, rise that of the middle line.
    """
    mesh = plate_mesh(length, 1.0, elements)
    along = 1.0 + mesh.points[:, 0] / length
    mesh.points[:, 1] = (mesh.points[:, 1] - 0.5) * (root + (tip - root) * along) + rise * along
    return mesh


def clamped(unit):
    """Stiffness over the modulus without the left end, and its unknowns."""
    x = unit.discretisation.positions[0]
    free = np.flatnonzero(np.tile(~np.isclose(x, x.min()), 2))
    return unit.inverse.stiffness.tocsc()[free][:, free], free


CASES = [("quad9", (8, 4), 3.7e-3), ("quad9", (16, 8), 4e-4), ("quad4", (32, 16), 3.7e-3)]


@pytest.mark.parametrize(("kind", "elements", "tolerance"), CASES)
def test_fv32_tapered_membrane(kind, elements, tolerance):
    """Frequencies of NAFEMS, which ABAQUS's CPS8R has within 0.37 %."""
    plate = PlateProperties(0.05, 8000.0, 1.0, 0.3, element=kind)
    unit = unit_plate(tapered(10.0, 5.0, 1.0, elements), plate)
    stiffness, free = clamped(unit)
    root = diags(np.tile(unit.masses, 2)[free] ** -0.5)
    scaled = (200e9 * root @ stiffness @ root).tocsc()
    squares = np.sort(eigsh(scaled, 6, sigma=0.0, return_eigenvectors=False))
    reference = [44.623, 130.03, 162.70, 246.05, 379.90, 391.44]
    assert np.sqrt(squares) / (2.0 * math.pi) == pytest.approx(reference, rel=tolerance)


@pytest.mark.parametrize(("elements", "tolerance"), [(8, 2e-3), (32, 5e-4)])
def test_cook_s_membrane(elements, tolerance):
    """A unit shear force raises the middle of the end by 23.97.

    E = 1 and Poisson's ratio is 1/3.
    """
    plate = PlateProperties(1.0, 1.0, 1.0, 1.0 / 3.0, element="quad9")
    unit = unit_plate(tapered(48.0, 44.0, 16.0, (elements, elements), 30.0), plate)
    x, y = unit.discretisation.positions
    edge = np.flatnonzero(np.isclose(x, 0.0))
    edge, loads = edge[np.argsort(y[edge])], np.zeros((2, x.size))
    weights = np.where(np.arange(edge.size) % 2, 4.0, 2.0)  # Simpson's rule
    weights[[0, -1]] = 1.0
    loads[1, edge] = weights / weights.sum()
    stiffness, free = clamped(unit)
    displacement = np.zeros(2 * x.size)
    displacement[free] = spsolve(stiffness, loads.ravel()[free])
    middle = edge[edge.size // 2]
    assert (x[middle], y[middle]) == pytest.approx((0.0, 30.0))
    assert displacement[x.size + middle] == pytest.approx(23.97, rel=tolerance)
