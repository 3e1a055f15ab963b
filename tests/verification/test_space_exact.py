"""Verify the vehicle in space by closed forms and independent solutions."""

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from space_motions import energy_error, pushes
from space_vehicles import ANGLE, FAR, MASS, SPEED, YAW, axle, truck, truck_unit

from machine_code.compiled import compiled
from machine_code.object_code import flattened
from solver.body import GRAVITY
from solver.impact import CrushLaw, ImpactVehicle, TyreAxle, WallContact, first_touch, solve_impact
from solver.rotation import sine_and_versine
from solver.space import SpaceStrip, SpaceVehicle, SpaceWall, solve_space
from solver.space import state as columns
from solver.space.dynamics import assemble, begin_step, kick, move
from solver.space.vehicle import fleet_of

LOW = SpaceWall(0.02)
"""A wall that no strip of the tests touches."""


def pushed(vehicle, push, interval, step, end):
    """Return the history of a vehicle at rest under a force."""
    return solve_space(
        vehicle, LOW, 0.0, 1e-12, interval=interval, step=step, end=end, push=np.atleast_2d(push)
    ).history


@compiled
def fly(units, axles, axle_unit, bodies, joints, h, steps, spins):
    """Follow free bodies, and store the spin of the first.

    The spin after each step is in the body's own axes.
    """
    for k in range(steps):
        begin_step(bodies, joints, h if k > 0 else 0.0)
        assemble(units, axles, axle_unit, bodies, joints)
        kick(axle_unit, bodies, joints, h if k > 0 else 0.5 * h)
        for j in range(3):
            spins[k, j] = bodies[0, 31 + j]
        move(bodies, joints, h)
    begin_step(bodies, joints, h)


def flown(inertias, spin, h, duration):
    """Return rotation matrices, spins and velocities of a free body without axles."""
    units = np.zeros((1, 17))
    units[0, columns.MASS] = 1000.0
    units[0, columns.I_X : columns.I_Z + 1] = inertias
    bodies, steps = np.zeros((1, columns.BODY_STATE)), round(duration / h)
    bodies[0, columns.TURN], bodies[0, columns.SPIN : columns.SPIN + 3] = 1.0, spin
    spins, none = np.zeros((steps, 3)), np.zeros((0, columns.AXLE_STATE))
    fly(units, np.zeros((0, 14)), np.zeros(0, dtype=np.int64), bodies, none, h, steps, spins)
    return bodies[0, :9].reshape(3, 3), spins, bodies[0, columns.NOW + 3 : columns.NOW + 6]


def test_free_body_with_three_unequal_inertias():
    """Energy and angular momentum are constant while the spin tumbles."""
    inertias, spin = np.array([1000.0, 2000.0, 2700.0]), np.array([0.1, 0.6, 0.05])
    rotation, spins, last = flown(inertias, spin, 1e-5, 10.0)
    energy = (inertias * spins**2).sum(axis=1)
    assert np.abs(energy / (inertias @ spin**2) - 1.0).max() < 1e-9
    momentum = inertias * spin
    assert np.abs(rotation @ (inertias * last) - momentum).max() < 1e-9 * np.linalg.norm(momentum)
    assert np.ptp(spins[:, 0]) > 0.1


def test_symmetric_top_precesses():
    """The spin rotates in the body at (I3/I1 - 1) w3."""
    across, along, rate = 1000.0, 1600.0, 1.5
    inertias, spin, h, duration = (across, across, along), np.array([0.3, 0.0, rate]), 1e-4, 10.0
    _, spins, _ = flown(inertias, spin, h, duration)
    angle = np.unwrap(np.arctan2(spins[:, 1], spins[:, 0]))
    t = h * np.arange(len(angle))
    assert np.polyfit(t, angle, 1)[0] == pytest.approx((along / across - 1.0) * rate, rel=1e-6)


def test_one_sample_and_many_have_one_kernel():
    """Wall, speed and angle as numbers or arrays, read-only ones among them."""
    heights = np.full(3, LOW.height), np.broadcast_to(LOW.height, 3)
    walls = [LOW, *(replace(LOW, height=height) for height in heights)]
    fleets = [fleet_of(truck(), wall, speed, 0.1) for wall in walls for speed in (SPEED, np.full(3, SPEED))]
    assert len({flattened((fleet,))[0] for fleet in fleets}) == 1


def test_free_vehicle_conserves_angular_momentum():
    """Body and axles in free fall, about their centre of mass."""
    vehicle = truck(friction=0.0)
    fleet = fleet_of(vehicle, LOW, 0.0, 0.1)
    units, axles = fleet.units[0], fleet.axles[0]
    bodies, joints = np.zeros((1, columns.BODY_STATE)), np.zeros((2, columns.AXLE_STATE))
    steps, h = 2000, 1e-4
    bodies[0, columns.TURN], bodies[0, columns.SPIN : columns.SPIN + 3] = 1.0, (0.5, 0.3, 0.4)
    joints[:, columns.JOINT_SPEED : columns.JOINT_SPEED + 2] = ((0.1, 0.3), (-0.2, 0.2))
    spins = np.zeros((steps, 3))

    def momentum():
        b, total, first, mass = bodies[0], np.zeros(3), np.zeros(3), units[0, columns.MASS]
        rotation, now = b[:9].reshape(3, 3), b[columns.NOW :]
        ix, iy, iz, xz = units[0, columns.I_X : columns.I_XZ + 1]
        tensor = np.array([[ix, 0.0, -xz], [0.0, iy, 0.0], [-xz, 0.0, iz]])
        speed = now[:3]
        parts = [(mass, np.zeros(3), speed, rotation @ tensor @ now[3:6])]
        for row, q in zip(axles, joints, strict=True):
            roll, roll_rate = q[columns.JOINT + 1], q[columns.JOINT_NOW + 1]
            rod = np.array([0.0, math.cos(roll), math.sin(roll)])
            below = row[columns.BELOW] * np.array([0.0, math.sin(roll), -math.cos(roll)])
            place = np.array([row[columns.PLACE], 0.0, row[columns.CENTRE] + q[columns.JOINT]]) + below
            relative = np.array([0.0, 0.0, q[columns.JOINT_NOW]]) + np.cross([roll_rate, 0.0, 0.0], below)
            velocity = speed + rotation @ (np.cross(now[3:6], place) + relative)
            turning = now[3:6] + np.array([roll_rate, 0.0, 0.0])
            inertia = row[columns.AXLE_INERTIA] * (turning - rod * (rod @ turning))
            parts.append((row[columns.AXLE_MASS], rotation @ place, velocity, rotation @ inertia))
        masses = np.array([part[0] for part in parts])
        centre = sum(m * place for m, place, _, _ in parts) / masses.sum()
        drift = sum(m * velocity for m, _, velocity, _ in parts) / masses.sum()
        for m, place, velocity, inner in parts:
            total += inner + np.cross(place - centre, m * (velocity - drift))
            first += m * velocity
        return total, drift

    begin_step(bodies, joints, 0.0)
    before, start = momentum()
    fly(units, axles, fleet.axle_unit, bodies, joints, h, steps, spins)
    after, drift = momentum()
    assert np.abs(after - before).max() < 1e-6 * np.linalg.norm(before)
    assert drift[2] - start[2] == pytest.approx(-GRAVITY * steps * h, rel=1e-9)
    assert abs(joints[0, columns.JOINT]) > 0.01


def test_vehicle_at_rest_stands_on_its_axles():
    """Axle loads follow from levers, and nothing changes for 2 s."""
    vehicle = truck()
    h = solve_space(vehicle, SpaceWall(0.9), 0.0, 0.3, end=2.0, step=1e-3).history
    rear = MASS * GRAVITY * (5.0 - 1.2) / 6.0
    for side in ("left", "right"):
        assert h[f"load_{side}_2"] == pytest.approx(0.5 * rear, rel=1e-9)
        assert h[f"load_{side}_1"] == pytest.approx(0.5 * (MASS * GRAVITY - rear), rel=1e-9)
    assert np.ptp(h["z_g"]) < 1e-9
    assert np.abs(h["roll"]).max() < 1e-9
    assert np.abs(h["pitch"]).max() < 1e-9


def corners(x, y, initial_force=0.0, hardening=0.0, restitution=0.225):
    """Return two corners as strips of 0.1 m and 2 MN/m."""
    law = {"plateau": 3.5e6, "restitution": restitution, "initial_force": 10.0 * initial_force}
    law["hardening"] = 10.0 * hardening
    return tuple(SpaceStrip((at, at), (0.5, 0.6), 2e7, **law) for at in (x, y))


HELD = 1e14
"""Inertia that holds roll and pitch [kg m^2]."""


def held(strips, friction=0.0, tyre=1e10):
    """Return the truck without roll and pitch, on stiff tyres."""
    unit = truck_unit(roll_inertia=HELD, pitch_inertia=HELD)
    axles = (axle(at, tyre=tyre, friction=friction, roll_centre=0.5) for at in (1.2, 7.2))
    return SpaceVehicle((unit,), tuple(axles), strips)


@pytest.mark.parametrize(
    ("initial_force", "hardening", "restitution", "friction"),
    [
        (0.0, 0.0, 0.225, 0.0),
        (1.5e5, 0.0, 0.225, 0.0),
        (0.0, 4e5, 0.225, 0.0),
        (0.0, 0.0, 0.225, 0.65),
        (1.5e5, 0.0, 0.0, 0.65),
    ],
)
def test_held_vehicle_is_the_planar_one(initial_force, hardening, restitution, friction):
    """With roll and pitch fixed, strikes are those in the plane."""
    vehicle = held(corners(0.0, 10.0, initial_force, hardening, restitution), friction)
    step = 1e-5
    wall = SpaceWall(1.0, friction=0.35)
    motion = solve_space(vehicle, wall, SPEED, ANGLE, interval=2e-5, step=step, end=0.52)
    body = ImpactVehicle(10.0, 2.438, MASS)
    law = WallContact(CrushLaw(2e6, initial_force, restitution, 3.5e5, hardening=hardening), 0.35)
    tyres = [TyreAxle(a.position, a.friction, a.cornering) for a in vehicle.axles if friction]
    plane = solve_impact(body, law, first_touch(body, ANGLE, SPEED), end=0.52, step=step, axles=tyres)
    h = motion.history
    names = [strike.corner for strike in plane.strikes]
    assert [strike.corner for strike in motion.strikes] == names
    assert names[:2] == ["front", "rear"]
    for one, strike in zip(motion.strikes[:2], plane.strikes, strict=False):
        assert one.impulse == pytest.approx(strike.impulse, rel=1e-6)
        assert one.peak_force == pytest.approx(strike.peak_force, rel=1e-6)
        assert (one.start, one.end) == pytest.approx((strike.start, strike.end), abs=4e-5)
    at = plane.at(0.5)
    k = round(0.5 / 2e-5)
    for name, value in (("v_gx", at.v_gx), ("v_gy", at.v_gy), ("omega_z", at.omega), ("yaw", -at.theta)):
        assert h[name][k] == pytest.approx(value, rel=1e-5, abs=1e-6), name


@pytest.mark.parametrize("height", [3.0, 0.81, 0.7])
def test_strips_on_body_and_axle_stop_with_second_order(height):
    """Energy of a rolling truck without restitution.

    Its strips also lie on the top of a low wall.
    """
    ahead, wheels = (replace(strip, restitution=0.0) for strip in truck().strips[:2])
    vehicle, errors = replace(truck(), strips=(ahead, wheels)), list[Any]()
    for step in (5e-4, 2.5e-4, 1.25e-4):
        for speed in (21.0, 23.0, 25.0):
            options: dict[str, Any] = {"interval": 2e-3, "step": step, "points": 1e-3, "end": 1.0}
            h = solve_space(vehicle, SpaceWall(height), speed, ANGLE, **options).history
            errors.append(np.abs(energy_error(h)).max() / h["kinetic_energy"][0])
    means = np.sqrt(np.mean(np.reshape(errors, (3, 3)) ** 2, axis=1))
    assert (np.log2(means[:-1] / means[1:]) > 1.8).all()
    assert means[-1] < 3e-6


def stopped(angle, inertia=YAW):
    """Return the velocities after a front strike without restitution, by SciPy.

    The corner crushes with sliding friction until its velocity into the wall is zero.
    """

    def arms(theta):
        c, s = math.cos(theta), math.sin(theta)
        return 5.0 * c - 1.219 * s, -5.0 * s - 1.219 * c

    def rates(_, state):
        (x, y), (v, w) = arms(state[1]), state[3:]
        push = min(2e6 * max(-state[0] - y, 0.0), 3.5e5)
        return [v, -w, -0.35 * push / MASS, push / MASS, (x + 0.35 * y) * push / inertia]

    def turns(_, state):
        return state[3] + state[4] * arms(state[1])[0]

    event: Any = turns
    event.terminal, event.direction = True, 1.0
    start = [-arms(angle)[1], angle, SPEED * math.cos(angle), -SPEED * math.sin(angle), 0.0]
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12, "max_step": 1e-3, "events": event}
    return solve_ivp(rates, (0.0, 0.2), start, **options).y_events[0][0][2:]


def test_no_restitution_is_of_second_order():
    """Velocities after the strike of a corner, mean of five angles."""
    steps, errors = (2e-3, 1e-3, 5e-4, 2.5e-4), list[Any]()
    for angle in np.radians([12.0, 13.0, 15.0, 17.0, 18.0]):
        exact = stopped(angle)
        for step in steps:
            vehicle = held(corners(0.0, 10.0, restitution=0.0), tyre=1e6)
            wall = SpaceWall(1.0, friction=0.35)
            h = solve_space(vehicle, wall, SPEED, angle, interval=2e-3, step=step, end=0.2).history
            errors.append([h[name][-1] for name in ("v_gx", "v_gy", "omega_z")] - exact)
    means = np.sqrt(np.mean(np.reshape(errors, (5, len(steps), 3)) ** 2, axis=(0, 2)))
    assert np.polyfit(np.log(steps), np.log(means), 1)[0] == pytest.approx(2.0, abs=0.2)
    assert means[-1] < 2e-6


def test_pushed_vehicle_without_restitution_rests_on_the_wall():
    """The wall's force is that of the push, without creep."""
    push = pushes(400, across=-1e5)
    vehicle = held(corners(0.0, 10.0, restitution=0.0), tyre=1e6)
    h = solve_space(vehicle, SpaceWall(1.0), 0.0, 1e-9, interval=5e-3, step=1e-3, end=2.0, push=push).history
    assert h["force_normal"][-50:-1] == pytest.approx(1e5, rel=1e-6)
    assert np.ptp(h["y_g"][-50:]) < 1e-9


def test_stiff_springs_roll_as_heave_and_roll_of_one_body():
    """Rigid springs leave heave and roll on unilateral tyres, by SciPy."""
    height, stiffness, half = 0.81, 1.2e6, 0.925
    unit = truck_unit(pitch_inertia=HELD)
    axles = tuple(
        axle(at, 800.0, 1e11, 0.5 * stiffness, roll_centre=0.5, damping_ratio=0.0, spacing=2.0)
        for at in (2.0, 8.0)
    )
    vehicle = SpaceVehicle((unit,), axles, FAR)
    end, interval = 1.2, 5e-3
    times = interval * (np.arange(round(end / interval)) + 0.5)
    pulse = lambda t: 2.2e5 * math.sin(math.pi * min(t / 0.3, 1.0)) ** 2  # noqa: E731
    push = pushes(times.size, across=[-pulse(t) for t in times], height=height)
    h = solve_space(vehicle, LOW, 0.0, 1e-9, interval=interval, step=2e-6, end=end, push=push).history

    def rates(t, state):
        z, roll, v, w = state
        force = push[min(int(t / interval), len(push) - 1), 1]
        total, moment = -MASS * GRAVITY, -force * (height - z)
        for side in (-half, half):
            arm = side * math.cos(roll) + (1.35 + 0.25 * MASS * GRAVITY / (0.5 * stiffness)) * math.sin(roll)
            depth = -(z + side * math.sin(roll) - (1.35 + 0.5 * MASS * GRAVITY / stiffness) * math.cos(roll))
            load = stiffness * max(depth, 0.0)
            total, moment = total + load, moment + load * arm
        return [v, w, total / MASS, moment / 12070.0]

    state, rolls = [1.35, 0.0, 0.0, 0.0], [0.0]
    options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12, "max_step": 1e-3}
    for k in range(len(push)):
        interval_k = (k * interval, (k + 1 - 1e-9) * interval)
        state = solve_ivp(rates, interval_k, state, **options).y[:, -1]
        rolls.append(state[1])
    assert max(map(abs, rolls)) > 0.1
    assert np.abs(h["roll"] - rolls).max() < 1e-4 * max(map(abs, rolls))


@pytest.mark.parametrize("profile", ["vertical", "new-jersey"])
def test_energy_balance(profile):
    """Kinetic, potential and elastic energy equal the works of all forces."""
    motion = solve_space(truck(), SpaceWall(0.81, profile, 0.35), SPEED, ANGLE, step=2e-5)
    h = motion.history
    assert np.abs(energy_error(h)).max() < 1e-6 * h["kinetic_energy"][0]
    for name in ("friction_work", "tyre_work", "damping_work"):
        assert h[name][-1] < -1e3
        assert np.diff(h[name]).max() <= 1e-6


def test_momentum_is_that_of_the_forces():
    """Without tyres the impulse of the wall is the change of momentum."""
    h = solve_space(truck(friction=0.0), SpaceWall(0.9, friction=0.35), SPEED, ANGLE, step=2e-4).history
    for force, speed in (("force_normal", "v_gy"), ("force_tangential", "v_gx")):
        impulse = 1e-3 * np.cumsum(h[force])
        error = np.abs(impulse - MASS * (h[speed] - h[speed][0])).max()
        assert error < 1e-3 * abs(impulse[-1]) + 1.0


def test_second_order_by_a_smooth_force():
    """Errors of roll and yaw decrease with the squared step."""
    vehicle, interval, end = truck(), 8e-3, 0.8
    times = interval * (np.arange(round(end / interval)) + 0.5)
    push = pushes(times.size, across=6e4 * np.sin(math.pi * times / end) ** 2, ahead=1.0, height=1.0)
    ends = []
    for step in (1e-3, 5e-4, 2.5e-4, 1.25e-4, 4e-6):
        h = solve_space(vehicle, LOW, SPEED, 0.01, interval=interval, step=step, end=end, push=push).history
        ends.append([h["roll"][-1], h["yaw"][-1], h["pitch"][-1]])
    errors = np.abs(np.array(ends[:-1]) - ends[-1])
    for column in errors.T:
        assert np.polyfit(np.log([1, 2, 4, 8]), -np.log(column), 1)[0] == pytest.approx(2.0, abs=0.1)
    assert errors[-1].max() < 1e-5


@pytest.mark.parametrize("angle", [1e-9, 1e-3, 0.0316, 0.0317, 0.5, 3.0])
def test_sines_of_a_rotation(angle):
    """Series and functions agree with exact fractions of a long series."""
    square, terms = Fraction(angle) ** 2, range(24)
    sine = sum((-square) ** n / math.factorial(2 * n + 1) for n in terms)
    versine = 2 * sum((-square) ** n / math.factorial(2 * n + 2) for n in terms)
    assert _sines(float(square)) == pytest.approx((float(sine), float(versine)), rel=4e-16, abs=0.0)
    assert _sines(0.0) == (1.0, 1.0)


@compiled
def _sines(square):
    return sine_and_versine(square)
