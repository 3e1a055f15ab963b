"""Verify masses, frequencies, time step and friction by exact answers."""

import numpy as np
import pytest
import scipy.linalg

from fem.laws.constraints import CornerConstraint, Penalty, add_corner_reaction
from fem.laws.friction import Drag, Signed
from fem.plate.discretisation import discretise
from fem.plate.nodal_masses import exact_inertia_masses, row_sum_masses
from fem.run.corner import Stepper
from fem.start.inertia_relief import RigidStart
from meshes import plate_mesh

DENSITY, THICKNESS = 7800.0, 0.053
MASS = DENSITY * THICKNESS * 10.0 * 2.438


def moments(masses, positions):
    x, y = positions
    return np.array([masses.sum(), masses @ x, masses @ y, masses @ x**2, masses @ y**2, masses @ (x * y)])


EXACT = MASS * np.array([1.0, -5.0, 2.438 / 2, 100.0 / 3, 2.438**2 / 3, -5.0 * 2.438 / 2])


@pytest.mark.parametrize("elements", [(20, 6), (3, 2), (2, 5), None])
def test_masses_have_the_plates_exact_inertia(elements, distorted_mesh):
    d = discretise(plate_mesh(10.0, 2.438, elements) if elements else distorted_mesh, THICKNESS)
    masses = exact_inertia_masses(d.scalar, DENSITY, THICKNESS)
    assert (masses > 0.0).all()
    np.testing.assert_allclose(moments(masses, d.positions), EXACT, rtol=1e-13)


def test_row_sums_overstate_the_rotary_inertia():
    """The excess is (h_x^2 + h_y^2)/6 of mass, 0.78 % here."""
    d = discretise(plate_mesh(10.0, 2.438, (20, 6)), THICKNESS)
    masses = row_sum_masses(d.scalar, DENSITY, THICKNESS)
    excess = (moments(masses, d.positions) - EXACT)[3:5].sum()
    assert excess == pytest.approx(MASS * (0.5**2 + (2.438 / 6) ** 2) / 6, rel=1e-10)
    inertia = MASS * (100.0 + 2.438**2) / 12
    assert excess / inertia == pytest.approx(0.0078, abs=5e-5)


def test_masses_move_by_the_least_relative_change():
    """The relative change has no part in the null space of moments."""
    d = discretise(plate_mesh(10.0, 2.438, (6, 3)), THICKNESS)
    plain, exact = (f(d.scalar, DENSITY, THICKNESS) for f in (row_sum_masses, exact_inertia_masses))
    x, y = d.positions
    constraints = np.array([x * 0 + 1, x, y, x * x, x * y, y * y]) * plain
    free = scipy.linalg.null_space(constraints)
    change = (exact - plain) / plain
    assert np.linalg.norm(change) > 1e-3
    assert np.abs(free.T @ change).max() < 1e-12 * np.linalg.norm(change)


def test_a_mesh_too_coarse_for_the_inertia_is_refused():
    d = discretise(plate_mesh(10.0, 2.438, (1, 1)), THICKNESS)
    with pytest.raises(ValueError, match="mesh"):
        exact_inertia_masses(d.scalar, DENSITY, THICKNESS)


def test_kinetic_energy_of_rigid_motion_is_exact(plate_model):
    model = plate_model()
    stepper = Stepper(model)
    state = stepper.start(RigidStart(0.26, 0.707, 25.053), "unstressed")
    row = stepper.measure(state)._asdict()
    radius, phi = np.hypot(10.0, 2.438) / 2, 0.26 + np.arctan2(2.438, 10.0)
    v_x, v_y = 25.053 - 0.707 * radius * np.sin(phi), -0.707 * radius * np.cos(phi)
    inertia = MASS * (100.0 + 2.438**2) / 12
    expected = 0.5 * MASS * (v_x**2 + v_y**2) + 0.5 * inertia * 0.707**2
    assert row["kinetic_energy"] == pytest.approx(expected, rel=1e-13)
    assert (row["v_gx"], row["v_gy"]) == pytest.approx((v_x, v_y), rel=1e-13)
    assert (row["theta"], row["omega"]) == pytest.approx((0.26, 0.707), rel=1e-13)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1, 0.5])
def test_the_stable_time_step_is_where_it_is_said_to_be(plate_model, damping_ratio):
    """At 0.98 steps a disturbed plate is stable, at 1.02 unstable."""
    ends = []
    for safety_factor in (0.98, 1.02):
        model = plate_model(elements=(6, 3), damping_ratio=damping_ratio, safety_factor=safety_factor)
        stepper = Stepper(model)
        state = stepper.advance(stepper.start(RigidStart(0.26, 0.707, 25.053), "unstressed"), 20_000)
        ends.append(stepper.measure(state).vibration_energy)
    assert ends[0] < 0.02
    assert not ends[1] < 2.0


def test_damped_step_of_a_plate_that_hardly_touches_its_spring(plate_model):
    """Equal damping of all stiffness has a closed form.

    w dt = 2 (sqrt(1 + z^2) - z).
    """
    model = plate_model(elements=(6, 3), corner={"penalty_scale": 1e-9}, damping_ratio=0.3)
    expected = 2.0 * (np.sqrt(1.09) - 0.3) / model.highest_frequency
    assert model.stable_time_step == pytest.approx(expected, rel=1e-5)


def one_node(mass):
    """A corner of one node on a spring of 1e6 N/m."""
    return CornerConstraint(np.array([0]), np.array([1.0]), 1.0 / mass, Penalty(1e6))


def slide(law, speed, normal, steps, time_step=1e-3):
    """Distance and speed of a free mass of 2 kg with friction."""
    corner = one_node(2.0)
    positions, velocities = np.array([[0.0], [-normal / 1e6]]), np.array([[speed], [0.0]])
    for _ in range(steps):
        force = np.zeros((2, 1))
        add_corner_reaction(positions, velocities, np.array([2.0]), time_step, corner, law, force)
        velocities[0] += time_step * force[0] / 2.0
        positions[0] += time_step * velocities[0]
    return positions[0, 0], velocities[0, 0]


@pytest.mark.parametrize("normal", [10.0, -10.0])
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_drag_stops_after_the_known_distance_and_stays(normal, speed):
    """s = v^2 m / (2 mu |N|), whichever the directions."""
    distance, last = slide(Drag(0.5), speed, normal, steps=4000)
    assert distance == pytest.approx(np.sign(speed) * 9.0 * 2.0 / (2.0 * 0.5 * 10.0), rel=1e-3)
    assert last == 0.0


def test_drag_holds_what_pushes_less_than_its_limit():
    force = np.array([[4.0], [0.0]])
    still = np.array([[0.0], [-1e-5]]), np.zeros((2, 1)), np.ones(1), 1e-3
    reaction = add_corner_reaction(*still, one_node(1.0), Drag(0.5), force)
    assert (reaction[:2], force[0, 0]) == (pytest.approx((10.0, -4.0)), 0.0)


def test_signed_friction_drives_on_where_the_wall_pulls():
    _, braked = slide(Signed(0.5), 3.0, 10.0, steps=100)
    _, driven = slide(Signed(0.5), 3.0, -10.0, steps=100)
    assert (braked, driven) == pytest.approx((3.0 - 0.25, 3.0 + 0.25), rel=1e-12)


def test_without_friction_nothing_acts_along_the_wall():
    assert slide(None, 3.0, -10.0, steps=100) == pytest.approx((0.3, 3.0))
