"""Verify hinges, free flight, conservation and modes of FE trains.

Their limits are those of the masses, and the rigid train, in proportion to 1/E.
"""

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from crushing_plates import corner_strips
from scipy.linalg import eigh, null_space
from test_trains import ANGLE, HITCH, KINGPIN, MU, SPEED, TRACTOR, TRAILER, flown, train_run

from fem.explicit.impact_loop import ImpactMeasures
from fem.laws.friction import Drag
from fem.model.impact_model import build_impact_model
from fem.model.train_model import hinge_weights
from fem.plate.elastic import gap_matrix
from fem.plate.free_modes import free_modes
from fem.plate.properties import (
    ContactProperties,
    Inertia,
    ModelError,
    PlateProperties,
    StepProperties,
    UnitProperties,
)
from fem.run.impact import FirstTouch, ImpactStepper, simulate_impact
from fem.start.equilibrium import elastic_forces
from meshes import plate_mesh
from solver.impact import (
    HitchedVehicle,
    ImpactVehicle,
    first_touch,
    strikes_of,
)

HINGE = (HITCH, KINGPIN)
TOUCH = FirstTouch(ANGLE, SPEED * math.cos(ANGLE), -SPEED * math.sin(ANGLE))
CRUSH: dict[str, Any] = {"stiffness": 2e6, "restitution": 0.22, "plateau_force": 1e9}
"""No force reaches the plateau, with which the compiled loop is that of shipped trains."""
COUNTS = ((8, 4), (16, 4))


def train(
    vehicles=(TRACTOR, TRAILER),
    hinges=(HINGE,),
    counts=COUNTS,
    hitch_length=0.0,
    patch_length=0.0,
    modulus=2e11,
    element="quad4",
):
    """Model of a train and properties of its units."""
    units = []
    for number, (vehicle, count_pair) in enumerate(zip(vehicles, counts, strict=True)):
        hitch, kingpin = hinges[number - 1] if number else (0.0, 0.0)
        places = [kingpin] * (number > 0) + [ahead for ahead, _ in hinges[number : number + 1]]
        mesh = plate_mesh(vehicle.length, vehicle.width, count_pair, hinges=places)
        density = vehicle.mass / (vehicle.length * vehicle.width * 0.05)
        inertia = Inertia(vehicle.front_distance, vehicle.inertia)
        plate = PlateProperties(0.05, density, modulus, 0.3, element=element, inertia=inertia)
        strips = corner_strips(vehicle.length, **CRUSH)
        contact = ContactProperties(Drag(MU), strips=strips, patch_length=patch_length)
        units.append(UnitProperties(mesh, plate, contact, hitch, kingpin, hitch_length))
    return build_impact_model(units, StepProperties()), units


@functools.cache
def struck(until=1.0, **options):
    model, _ = train(**options)
    return model, simulate_impact(model, TOUCH, 2e-4, until)


def corner_strikes(run):
    """Strikes by the number of the corner point."""
    forces = {str(k): run.normal[1:, k] for k in range(run.normal.shape[1]) if run.normal[:, k].any()}
    return strikes_of(run.history["t"], forces)


def test_a_column_of_nodes_moves_onto_each_hinge_and_none_is_a_sliver():
    mesh = plate_mesh(14.6, 2.59, (22, 4), hinges=(0.9, 13.0))
    for hinge in (0.9, 13.0):
        assert (np.abs(mesh.points[:, :2] - (-hinge, 1.295)).max(axis=1) < 1e-12).sum() == 1
    between = 14.6 - 1.5 * 14.6 / 22  # two columns away from each other, and close
    near = (between - 0.01, between + 0.01)
    for hinges in ((0.9, 13.0), (0.01,), (14.6,), (5.0, 5.1), near, (-2.0,), (14.7,)):
        columns = np.unique(plate_mesh(14.6, 2.59, (22, 4), hinges=hinges).points[:, 0])
        widths = np.diff(columns) * 22 / 14.6
        assert (columns.size, columns[0], columns[-1]) == (23, -14.6, 0.0)
        assert (widths.min() > 0.499, widths.max() < 1.501) == (True, True)


@pytest.mark.parametrize("length", [0.0, 1.0, 4.0])
@pytest.mark.parametrize("place", [0.9, 0.01, 14.6, 7.123, -3.0, 14.7, 18.0])
@pytest.mark.parametrize(("counts", "element"), [((22, 4), "quad4"), ((21, 3), "quad4"), ((12, 3), "quad9")])
def test_the_mean_of_a_hinge_is_the_hinge_in_every_rigid_motion(counts, element, place, length):
    vehicle = replace(TRAILER, width=2.44)
    model, _ = train((vehicle, TRACTOR), ((1.0, 1.0),), (counts, (8, 4)), element=element)
    positions = model.discretisation.positions[:, model.parameters.hinges.unit == 0]
    if length and length < 14.6 / counts[0] * 1.5:
        length = 1.5
    nodes, weights = hinge_weights(positions, place, length)
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    assert positions[:, nodes] @ weights == pytest.approx((-place, 1.22), abs=1e-10)


def test_a_hinge_on_a_node_has_that_node_alone():
    hinges = train()[0].parameters.hinges
    assert (hinges.first.tolist(), hinges.weights.tolist()) == ([0, 2], [1.0, -1.0])
    positions = train()[0].discretisation.positions[:, hinges.nodes]
    assert positions[:, 0] == pytest.approx(positions[:, 1], abs=1e-12)


def test_a_hinge_longer_than_a_unit_or_shorter_than_an_element_is_refused():
    for length in (0.2, 7.0):
        with pytest.raises(ModelError, match="does not lie between") as caught:
            train(hitch_length=length)
        assert caught.value.wrong == "trailer.0.hitch_length"


def spinning(model, spins, hinges=(HINGE,)):
    """A straight train, each unit rotating about its front hinge.

    It is far from the wall; spins are in order of the units.
    """
    stepper = ImpactStepper(model)
    state = stepper.at_touch(FirstTouch(0.0, 3.0, 1.0))
    state.positions[1] += 50.0
    x, v_y, velocities = -hinges[0][0], 1.0, state.velocities
    y = 0.5 * (state.positions[1].min() + state.positions[1].max())
    for number, spin in enumerate(spins):
        members = model.parameters.hinges.unit == number
        arm = state.positions[:, members] - [[x], [y]]
        velocities[0, members], velocities[1, members] = 3.0 - spin * arm[1], v_y + spin * arm[0]
        if 0 < number < len(hinges):
            v_y -= spin * (hinges[number][0] - hinges[number - 1][1])
            x -= hinges[number][0] - hinges[number - 1][1]
    return stepper, state


def test_a_trailer_that_is_wider_and_close_touches_first():
    """Its deepest corner is on the wall as the rigid train touches."""
    wide, hinge = replace(TRAILER, width=6.0), (1.0, 0.9)
    first = first_touch(TRACTOR, ANGLE, SPEED, (HitchedVehicle(wide, *hinge),))
    height = first.y_g - TRACTOR.front_distance * math.sin(ANGLE) - 0.5 * TRACTOR.width * math.cos(ANGLE)
    model, _ = train((TRACTOR, wide), (hinge,))
    state = ImpactStepper(model).at_touch(replace(TOUCH, height=height))
    corners = model.parameters.contact.nodes
    assert height > 0.1
    assert state.positions[1, corners].min() == state.positions[1].min() == pytest.approx(0.0, abs=1e-12)
    assert model.parameters.hinges.unit[corners[state.positions[1, corners].argmin()]] == 1


def test_the_hinge_is_a_node_that_carries_both_masses():
    """Against central differences with one unknown for both nodes, written out."""
    model, _ = train(counts=((4, 2), (16, 2)))
    stepper, state = spinning(model, (0.4, -0.3))
    front, rear = model.parameters.hinges.nodes
    mass, dt = model.parameters.mass.copy(), model.parameters.time_step
    mass[[front, rear]] = mass[front] + mass[rear]
    x, v = state.positions.copy(), state.velocities.copy()
    v[:, rear] = v[:, front]
    for _ in range(200):
        force = -elastic_forces(model.parameters)(x)
        force[:, [front, rear]] = (force[:, front] + force[:, rear])[:, None]
        v += dt * force / mass
        x += dt * v
    later = stepper.record(state, 200, 1).state
    shift = later.origin[0]
    assert later.positions[0] + shift == pytest.approx(x[0], abs=1e-11)
    assert later.positions[1] == pytest.approx(x[1], abs=1e-11)


@pytest.mark.parametrize("hitch_length", [0.0, 2.0])
def test_free_flight_of_three_units(hitch_length):
    """Momentum and energy are constant, and hinge forces accelerate the units."""
    vehicles, hinges = (TRACTOR, TRAILER, TRAILER), (HINGE, (13.0, 1.2))
    model, _ = train(vehicles, hinges, ((8, 4), (16, 4), (16, 4)), hitch_length)
    stepper, state = spinning(model, (0.4, -0.3, 0.2), hinges)
    interval = 40 * model.parameters.time_step
    end = stepper.record(state, 40, 500)
    values, *_, units, _ = stepper.parts(end.rows)
    fields = dict(zip(ImpactMeasures._fields, values.T, strict=True))
    for name in ("v_gx", "v_gy", "angular_momentum"):
        assert fields[name] == pytest.approx(np.full(500, fields[name][0]), rel=1e-11)
    energy = fields["kinetic_energy"] + fields["strain_energy"]
    assert energy == pytest.approx(np.full(500, energy[0]), rel=1e-5)
    ties = model.parameters.hinges
    gaps = np.add.reduceat(ties.weights * end.state.positions[:, ties.nodes], ties.first[:-1], axis=1)
    assert np.abs(gaps).max() < 1e-11
    motions, impulses = units[:, :18].reshape(-1, 3, 6), units[:, 18:].reshape(-1, 2, 2)
    gains = np.diff(motions[:, :, 4:], axis=0) * [[v.mass] for v in vehicles]
    pushes = np.diff(impulses, axis=0)
    scale = np.abs(pushes).max()
    for number, push in enumerate((pushes[:, 0], pushes[:, 1] - pushes[:, 0], -pushes[:, 1])):
        assert gains[:, number] == pytest.approx(push, abs=1e-9 * scale)
    reduced = TRACTOR.mass * 2.0 * TRAILER.mass / (TRACTOR.mass + 2.0 * TRAILER.mass)
    behind = motions[:, 1:, 4:].mean(axis=1)
    relative = np.diff(motions[:, 0, 4:] - behind, axis=0) / interval
    assert pushes[:, 0] / interval == pytest.approx(reduced * relative, abs=1e-9 * scale / interval)


def test_a_stiff_train_spins_as_the_rigid_one():
    """Angles after 0.5 s of free flight, in proportion to 1/E."""
    expected = flown(0.4, -0.3, end=0.5, step=1e-4)[3].state[0, :, 2]
    errors = []
    for modulus in (2e9, 2e10):
        model, _ = train(modulus=modulus, counts=((4, 2), (8, 2)))
        stepper, start = spinning(model, (0.4, -0.3))
        steps = round(0.5 / model.parameters.time_step)
        *_, units, _ = stepper.parts(stepper.record(start, steps, 1).rows)
        ratio = steps * model.parameters.time_step / 0.5
        errors.append(np.abs(units[0].reshape(-1)[[2, 8]] / ratio - expected).max())
    assert errors[1] < 2e-4
    assert errors[1] < 0.2 * errors[0]


@pytest.mark.parametrize("hitch_length", [0.0, 2.0])
def test_momentum_energy_and_no_pull_of_a_train(hitch_length):
    model, run = struck(hitch_length=hitch_length)
    h, scale = run.history, model.mass * SPEED
    assert np.abs(model.mass * (h["v_gx"] - TOUCH.v_x) - h["tangential_impulse"]).max() < 1e-12 * scale
    assert np.abs(model.mass * (h["v_gy"] - TOUCH.v_y) - h["normal_impulse"]).max() < 1e-12 * scale
    spin = h["angular_momentum"] - h["moment_impulse"]
    assert np.abs(spin - spin[0]).max() < 1e-12 * np.abs(h["angular_momentum"]).max()
    energy = sum(h[name] for name in ("kinetic_energy", "strain_energy", "contact_energy", "crush_energy"))
    balance = energy - h["friction_work"]
    assert np.abs(balance / balance[0] - 1.0).max() < 1e-5
    assert run.normal.min() >= 0.0
    masses = np.array([TRACTOR.mass, TRAILER.mass])
    both = np.array([unit["v_gy"] for unit in run.units])
    assert masses @ both / model.mass == pytest.approx(h["v_gy"], abs=1e-12 * SPEED)


def test_units_have_the_masses_centres_and_inertias_that_are_given():
    model, _ = train()
    for number, vehicle in enumerate((TRACTOR, TRAILER)):
        members = model.parameters.hinges.unit == number
        masses, (x, y) = model.parameters.mass[members], model.discretisation.positions[:, members]
        front = 0.0 if number == 0 else HINGE[1] - HINGE[0]
        assert masses.sum() == pytest.approx(vehicle.mass, rel=1e-12)
        assert masses @ x / vehicle.mass == pytest.approx(front - vehicle.front_distance, rel=1e-10)
        assert masses @ y / vehicle.mass == pytest.approx(1.22, rel=1e-10)
        about = (x - front + vehicle.front_distance) ** 2 + (y - 1.22) ** 2
        assert masses @ about == pytest.approx(vehicle.inertia, rel=1e-9)


def rigid_strikes(until):
    """Rows of unit and corner, start, end, peak, impulse."""
    rows = train_run([TRACTOR, TRAILER], [HINGE], 2e6, end=until, strikes=8, step=2e-5).strikes[0]
    return rows[np.argsort(rows[:, 1])]


def impulse_errors(modulus, until, count, counts=COUNTS):
    """Relative errors of the first impulses against the rigid train."""
    rigid = rigid_strikes(until)[:count]
    strikes = corner_strikes(struck(until, modulus=modulus, counts=counts)[1])[:count]
    assert [float(strike.corner) for strike in strikes] == rigid[:, 0].tolist()
    return np.array([strike.impulse for strike in strikes]) / rigid[:, 4] - 1.0


def test_a_train_comes_to_the_rigid_one():
    """The error of two strikes is in proportion to 1/E."""
    soft, stiff = (impulse_errors(modulus, 0.35, 2) for modulus in (2e11, 8e11))
    assert np.abs(soft).max() < 8e-3
    assert stiff / soft == pytest.approx(np.full(2, 0.25), rel=0.2)
    assert np.abs((4.0 * stiff - soft) / 3.0).max() < 3e-4


@pytest.mark.long
def test_five_strikes_at_20_gpa_200_gpa_and_2_tpa():
    errors = np.array(
        [impulse_errors(modulus, 0.95, 5, ((16, 6), (34, 6))) for modulus in (2e10, 2e11, 2e12)]
    )
    assert (np.abs(errors[1:]) < 0.3 * np.abs(errors[:-1])).all()
    assert np.abs((10.0 * errors[2] - errors[1]) / 9.0).max() < 5e-4


def test_a_trailer_without_mass_changes_nothing():
    """The error goes with the mass, and with it to nothing.

    The hinge is at a column of nodes of the tractor alone.
    """
    mesh, column = plate_mesh(6.9, 2.44, (8, 4)), 6.9 * 6 / 8
    density = TRACTOR.mass / (6.9 * 2.44 * 0.05)
    plate = PlateProperties(0.05, density, 2e11, 0.3, inertia=Inertia(2.9, 34621.0))
    strips = corner_strips(6.9, **CRUSH | {"plateau_force": math.inf})
    contact = ContactProperties(Drag(MU), strips=strips)
    single = build_impact_model([UnitProperties(mesh, plate, contact)], StepProperties(longest=1e-5))
    expected = corner_strikes(simulate_impact(single, TOUCH, 2e-4, 0.1))[0].impulse
    errors = []
    for mass in (82.0, 8.2):
        light = ImpactVehicle(14.6, 2.44, mass, 8.0, mass * 17.9)
        run = struck(0.1, vehicles=(TRACTOR, light), hinges=((column, 0.9),))[1]
        impulse = corner_strikes(run)[0].impulse
        errors.append(impulse / expected - 1.0)
    assert errors[1] == pytest.approx(0.1 * errors[0], rel=0.05)
    assert abs(errors[1]) < 1e-3


def test_a_hinge_at_the_trailers_centre_makes_it_a_point_mass():
    """Its inertia has no effect until contact, up to flexibility."""
    box = [ImpactVehicle(4.0, 0.5, 27770.0, 2.0, inertia) for inertia in (3e4, 5e4)]
    runs = [
        struck(0.1, vehicles=(TRACTOR, trailer), hinges=((5.6, 2.0),), counts=((8, 4), (8, 2)), modulus=2e12)
        for trailer in box
    ]
    impulses = [corner_strikes(run)[0].impulse for _, run in runs]
    assert impulses[0] == pytest.approx(impulses[1], rel=1e-4)
    for _, run in runs:
        assert np.abs(run.units[1]["omega"]).max() < 1e-3 * np.abs(run.units[0]["omega"]).max()


@pytest.mark.parametrize("vehicles", [(TRACTOR, TRAILER), (TRACTOR, TRAILER, TRAILER)], ids=len)
def test_hinges_and_inertia_hold_each_unit_under_any_load(vehicles):
    """Hinges are closed, and no other force acts."""
    model, _ = train(vehicles, (HINGE,) * (len(vehicles) - 1), (*COUNTS, COUNTS[1])[: len(vehicles)])
    inverse, ties = model.elastic.inverse, gap_matrix(model.parameters.hinges).toarray()
    load = np.random.default_rng(4).normal(size=2 * model.parameters.mass.size)
    displacement = inverse(load)
    momenta = np.tile(inverse.masses, 2)[:, None] * inverse.rigid
    forces = np.hstack([ties.T, momenta])
    rest = load - inverse.stiffness @ displacement
    assert rest - forces @ np.linalg.lstsq(forces, rest, rcond=None)[0] == pytest.approx(
        0.0 * load, abs=1e-10
    )
    assert np.abs(ties @ displacement).max() < 1e-11 * np.abs(displacement).max()
    assert np.abs(momenta.T @ displacement).max() < 1e-9 * np.abs(momenta.T @ np.abs(displacement)).max()
    assert inverse.rigid.shape[1] == 2 + len(vehicles)


@pytest.mark.parametrize("hitch_length", [0.0, 2.0])
def test_free_modes_of_a_train_are_those_of_its_matrices_with_closed_hinges(hitch_length):
    """Compare with a dense solution in the null space of the hinges.

    Four motions are rigid, one of them of the hinge.
    """
    model, _ = train(hitch_length=hitch_length, counts=((6, 2), (12, 2)))
    modes = free_modes(model, 6)
    closed = null_space(gap_matrix(model.parameters.hinges).toarray())
    mass = np.tile(model.parameters.mass, 2)
    squares = eigh(
        closed.T @ model.stiffness @ closed, closed.T @ (mass[:, None] * closed), eigvals_only=True
    )
    assert modes.frequencies == pytest.approx(np.sqrt(squares[4:10]), rel=1e-9)
    assert modes.rigid_frequencies.shape == (4,)
    assert modes.rigid_frequencies.max() < 1e-5 * modes.frequencies[0]
    shapes = np.concatenate([modes.rigid, modes.shapes]).reshape(10, -1)
    assert shapes * mass @ shapes.T == pytest.approx(np.eye(10), abs=1e-9)
    assert np.abs(gap_matrix(model.parameters.hinges) @ shapes.T).max() < 1e-12 * np.abs(shapes).max()


@pytest.mark.long
def test_a_soft_train_converges_where_its_corners_and_its_hinge_are_spread():
    """Meshes of one to four times the elements converge.

    The train has 20 GPa and patches of 2 m. Orders are 3.2 of the peaks, 1.9 of the impulses, 1.2 of the angle, and 2.3
    of the hinge's force, which has no limit at one node.
    """
    results = []
    for n in (1, 2, 4):
        counts = tuple((n * along, n * across) for along, across in COUNTS)
        _, run = struck(0.95, modulus=2e10, counts=counts, hitch_length=2.0, patch_length=2.0)
        strikes, (ahead, behind) = corner_strikes(run)[:5], run.units
        results.append([
            [strike.peak_force for strike in strikes],
            [strike.impulse for strike in strikes],
            [np.abs(behind["theta"] - ahead["theta"]).max()] * 5,
            [np.hypot(*run.hinges[0]).max()] * 5,
        ])  # fmt: skip
    coarse, middle, fine = np.array(results)
    steps = [
        np.abs(coarser / finer - 1.0).max(axis=1) for coarser, finer in ((coarse, middle), (middle, fine))
    ]
    assert (np.log2(steps[0] / steps[1]) > 1.1).all()
    assert (steps[1] < (1e-3, 3e-3, 3e-4, 5e-3)).all()
