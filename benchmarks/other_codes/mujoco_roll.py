"""Roll over a wall by MuJoCo: a three-dimensional rigid body beside `solver.tipping`.

    .venv/bin/pip install mujoco==4.0.0; .venv/bin/python benchmarks/other_codes/mujoco_roll.py

Five scenes have the wall's force and the springs of four wheels, two axles, applied as forces to a free body in six
degrees of freedom: the largest roll is to agree within 1 %. A sixth leaves the contact of wheels and road, and of wall
and side, to the engine: two bodies of boxes, which touch by MuJoCo's own soft constraints; what differs is printed.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass

import mujoco
import numpy as np

from solver import tipping
from solver.impact import CrushLaw, ImpactVehicle, WallContact, first_touch, solve_impact

MASS, LENGTH, WIDTH, TRACK, AXLE = 9979.0, 10.0, 2.438, 1.85, 3.0
SPRING, INERTIA, STEP = 1.2e6, 9979.0 * 1.1**2, 1e-4
YAW = MASS * (LENGTH**2 + WIDTH**2) / 12.0


@dataclass(frozen=True)
class Case:
    """Heights of centre and wall [m], crush stiffness [N/m], damping ratio of the suspension, angle of impact [deg]."""

    centre: float
    wall: float
    stiffness: float = 2e6
    damping: float = 0.15
    angle: float = 15.0


CASES = {
    "paper's truck, 32 in": Case(1.35, 0.81), "high centre, 36 in": Case(1.45, 0.91),
    "undamped": Case(1.35, 0.81, damping=0.0), "soft crush, 27 in": Case(1.25, 0.69, 1e6),
    "20 deg, 42 in": Case(1.45, 1.07, angle=20.0),
}  # fmt: skip


def push(case: Case) -> np.ndarray:
    """Mean forces of the rigid vehicle's impact in each step [N]."""
    vehicle = ImpactVehicle(LENGTH, WIDTH, MASS)
    start = first_touch(vehicle, math.radians(case.angle), 56 * 0.44704)
    motion = solve_impact(vehicle, WallContact(CrushLaw(case.stiffness, 0.0, 0.22), 0.47), start, end=0.8)
    return np.diff(motion.at(np.linspace(0.0, 0.8, round(0.8 / STEP) + 1)).impulse_normal) / STEP


def body(case: Case, geoms: str = "") -> mujoco.MjModel:
    """A free body: x along the wall, y away from it, z up."""
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco><option timestep="{STEP}" gravity="0 0 -{tipping.GRAVITY}" integrator="RK4" cone="elliptic"/>
    <worldbody>{geoms.split("|")[0]}<body pos="0 0 {case.centre}"><freejoint/>
    <inertial pos="0 0 0" mass="{MASS}" diaginertia="{INERTIA} {YAW} {YAW}"/>{geoms.partition("|")[2]}</body>
    </worldbody></mujoco>""")


def vehicle(case: Case) -> tipping.RollingVehicle:
    """The vehicle of `solver.tipping`."""
    return tipping.RollingVehicle(MASS, case.centre, INERTIA, TRACK, SPRING, case.damping)


def rolling(data: mujoco.MjData) -> float:
    """Roll towards the wall [rad]."""
    return math.atan2(*data.xmat[1].reshape(3, 3)[2, 1:])


def carried(case: Case, data: mujoco.MjData, rest: float) -> None:
    """Apply the loads of four wheels: the springs of both sides, half on each axle."""
    turn, centre = data.xmat[1].reshape(3, 3), data.xipos[1]
    slope = 2.0 * case.damping * math.sqrt(2.0 * SPRING / MASS) / tipping.GRAVITY
    spin, total, moment = turn @ data.qvel[3:], np.zeros(3), np.zeros(3)
    for x in (-AXLE, AXLE):
        for y in (-0.5 * TRACK, 0.5 * TRACK):
            arm = turn @ (x, y, -case.centre)
            rate = data.qvel[2] + np.cross(spin, arm)[2]
            load = 0.5 * SPRING * max(rest - centre[2] - arm[2], 0.0) * max(1.0 - slope * rate, 0.0)
            total[2] += load
            moment += np.cross(arm, [0.0, 0.0, load])
    data.qfrc_applied[:3], data.qfrc_applied[3:] = total, turn.T @ moment


def rolled(case: Case, force: np.ndarray) -> float:
    """Largest roll [rad] with force and springs applied; the roll is about x, positive towards the wall."""
    model = body(case)
    data, rest = mujoco.MjData(model), MASS * tipping.GRAVITY / (2.0 * SPRING)
    largest, falling, now = 0.0, False, 0.0

    def apply(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        carried(case, data, rest)
        moment = np.cross([0.0, 0.0, case.wall - data.xipos[1][2]], [0.0, now, 0.0])
        data.qfrc_applied[:3] += 0.0, now, 0.0
        data.qfrc_applied[3:] += data.xmat[1].reshape(3, 3).T @ moment

    mujoco.set_mjcb_passive(apply)
    for k in range(round(4.0 / STEP)):
        now = force[k] if k < force.size else 0.0
        mujoco.mj_step(model, data)
        roll = rolling(data)
        largest = max(largest, roll)
        falling = falling or (k > force.size and roll < 0.5 * largest)
        if falling or roll > 1.2:
            break
    mujoco.set_mjcb_passive(None)
    return largest if roll < 1.2 else tipping.TIPPED


WALL = '<geom type="box" size="100 1 {half}" pos="0 -1 {half}" condim="1" solref="0.03 0.5"/>|'
SIDES = '<geom type="box" size="{length} {half} {high}" pos="0 0 0" condim="1" solref="0.03 0.5"/>'


def struck(case: Case) -> tuple[float, np.ndarray, float, float]:
    """Simulate a box that strikes a box-shaped wall by the engine's contact without friction.

    Returns the largest roll [rad], the force across the wall in each step [N], the upward part of the impulse over the
    whole, and the mean height of the force [m].
    """
    sides = SIDES.format(length=0.5 * LENGTH, half=0.5 * WIDTH, high=case.centre - 0.3)
    model = body(case, WALL.format(half=0.5 * case.wall) + sides)
    data, rest = mujoco.MjData(model), MASS * tipping.GRAVITY / (2.0 * SPRING)
    theta, speed = math.radians(case.angle), 56 * 0.44704
    data.qpos[1] = 0.5 * LENGTH * math.sin(theta) + 0.5 * WIDTH * math.cos(theta)
    data.qpos[3:] = math.cos(0.5 * theta), 0.0, 0.0, -math.sin(0.5 * theta)
    data.qvel[:2] = speed * math.cos(theta), -speed * math.sin(theta)
    mujoco.set_mjcb_passive(lambda model, data: carried(case, data, rest))
    largest, forces, upwards, height, found = 0.0, [], 0.0, 0.0, np.zeros(6)
    for _ in range(round(2.0 / STEP)):
        mujoco.mj_step(model, data)
        across = 0.0
        for number in range(data.ncon):
            mujoco.mj_contactForce(model, data, number, found)
            push = found[0] * data.contact[number].frame[:3]
            push = push if push[1] > 0.0 else -push
            across, upwards = across + push[1], upwards + push[2]
            height += push[1] * data.contact[number].pos[2]
        forces.append(across)
        roll = rolling(data)
        largest = max(largest, roll)
        if roll > 1.2:
            largest = tipping.TIPPED
            break
    mujoco.set_mjcb_passive(None)
    return largest, np.array(forces), upwards / sum(forces), height / sum(forces)


def leaning(case: Case, force: np.ndarray) -> float:
    """Largest roll [rad] in the plane by a force that is square to the body's side, as contact without friction is: its
    part across the wall is given, F tan(roll) points upwards."""
    slope = 2.0 * case.damping * math.sqrt(2.0 * SPRING / MASS) / tipping.GRAVITY
    rest, z, roll, v, w, largest = 0.5 * MASS * tipping.GRAVITY / SPRING, case.centre, 0.0, 0.0, 0.0, 0.0
    for push in force:
        z, roll = z + 0.5 * STEP * v, roll + 0.5 * STEP * w
        s, c, lever = math.sin(roll), math.cos(roll), z - case.wall
        rise, arm = push * s / c, -(0.5 * WIDTH - lever * s) / c
        turning = push * lever + rise * arm
        for side in (-0.5 * TRACK, 0.5 * TRACK):
            place = side * c + case.centre * s
            depth = rest - (z + side * s - case.centre * c)
            load = SPRING * max(depth, 0.0) * max(1.0 - slope * (v + place * w), 0.0)
            rise, turning = rise + load, turning + load * place
        v, w = v + STEP * (rise / MASS - tipping.GRAVITY), w + STEP * turning / INERTIA
        z, roll = z + 0.5 * STEP * v, roll + 0.5 * STEP * w
        largest = max(largest, roll)
    return largest


def main() -> None:
    """Print both rolls of each scene with their difference, and one with the engine's contact."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    print("| scene | solver.tipping [deg] | MuJoCo [deg] | difference |\n|---|---|---|---|")
    for name, case in CASES.items():
        force = push(case)
        ours = tipping.solve_roll(vehicle(case), case.wall, force, STEP).largest_roll
        theirs = rolled(case, force)
        rolls = f"{math.degrees(ours):.3f} | {math.degrees(theirs):.3f} | {theirs / ours - 1.0:+.1e}"
        print(f"| {name} | {rolls} |", flush=True)
    case = CASES["paper's truck, 32 in"]
    theirs, force, upwards, height = struck(case)
    both = (tipping.solve_roll(vehicle(case), h, force, STEP).largest_roll for h in (case.wall, height))
    ours, lower = map(math.degrees, both)
    print(f"contact in MuJoCo: {math.degrees(theirs):.3f} deg, impulse {1e-3 * STEP * force.sum():.2f} kN s")
    print(f"of which {upwards:+.3f} points upwards, at a mean height of {height:.3f} m")
    print(f"solver.tipping by that force, horizontal: {ours:.3f} deg; at that height {lower:.3f} deg")
    square = math.degrees(leaning(case, force))
    print(f"in the plane by that force, square to the body's side: {square:.3f} deg")


if __name__ == "__main__":
    main()
