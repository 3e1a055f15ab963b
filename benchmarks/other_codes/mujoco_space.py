"""Vehicles in space by MuJoCo beside `solver.space`.

    .venv/bin/pip install mujoco==4.0.0; .venv/bin/python benchmarks/other_codes/mujoco_space.py

Three scenes have the same bodies in both: the sprung mass with its product of inertia, free in space, and two axles,
each on a slide joint and a hinge at its roll centre. The force of a wall is the history of an impact of `solver.space`,
half as large and 0.6 s long, applied equally to both without a wall; springs, dampers and tyres are forces of a passive
callback, by MuJoCo's Jacobians of the points that they join. Masses, inertias and loads at rest are computed here from
the records of the vehicle. The largest roll, pitch and yaw are to agree within 1 %.

In a fourth scene the engine computes the contact: a thin box on the sprung mass touches a box that is the wall, by
MuJoCo's soft constraints without friction; in `solver.space` both corners of the box are strips. The laws differ:
MuJoCo's contact is a spring and damper in proportion to the effective mass at a corner, whose force begins with the
velocity of the approach; a strip crushes from zero force and returns a part of its energy. Impulse and angles differ by
that. The engine's force, applied in `solver.space` at its line, confirms it: both motions are then equal.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import command_line

from solver.body import GRAVITY
from solver.space import SpaceAxle, SpaceStrip, SpaceVehicle, SpaceWall, solve_space
from solver.space.columns import AXLE_GYRATION
from tailslap.case.impact.space.input import space_input
from tailslap.scene.read import read_scene

STEP, INTERVAL = 2.5e-4, 5e-4
SCENE, INCH = "impact-tipping-tl4-sut", 0.0254
FAR = SpaceWall(0.02)
"""Wall that no strip reaches: lower than all of them."""
SCENES = {
    "shipped truck, vertical wall of 36 in": (),
    "centre at 1.45 m, New Jersey of 42 in, no plateaus": (
        "body.centre_height=1.45 m", "wall.height=42 in", "wall.profile=new-jersey",
        "strip.0.plateau=", "strip.1.plateau=", "strip.2.plateau=", "strip.3.plateau=",
    ),
    "single slope of 32 in, no side force of tyres, soft springs": (
        "wall.height=32 in", "wall.profile=single-slope", "axle.0.friction=0", "axle.1.friction=0",
        "axle.1.spring=0.25 MN/m",
    ),
}  # fmt: skip
"""Changes of the shipped scene."""
PART, LASTING, LONG = 0.5, 0.6, 2.0
"""Part of the force of an impact that is applied, and for how long [s]: the whole force without the wall overturns the
vehicles; duration of the motions [s]."""
UNTOUCHED = (SpaceStrip((0.0, 0.0), (2.2, 2.4), 1e5),)
"""Strip that touches no wall, because a vehicle has one."""
SOFT = 0.08, 0.5
"""Time constant [s] and damping ratio of the engine's contact."""
RETURNED, CORNER, LEVEL, THICK = 0.16, 2e6, 1.15, 0.05
"""Restitution and stiffness [N/m] of the corners that stand for it, height and thickness of the box [m]."""


@dataclass(frozen=True)
class Angles:
    """Roll, pitch and yaw from the start at every interval [rad]."""

    roll: np.ndarray
    pitch: np.ndarray
    yaw: np.ndarray

    @property
    def largest(self) -> dict[str, float]:
        """The largest of each, with its sign."""
        return {name: float(values[np.abs(values).argmax()]) for name, values in vars(self).items()}


def angles_of(history: dict[str, np.ndarray]) -> Angles:
    """The angles of a motion of `solver.space`."""
    return Angles(history["roll"], history["pitch"], history["yaw"] - history["yaw"][0])


@dataclass(frozen=True)
class Masses:
    """Mass, centre, inertia and axle loads without axles.

    Units are kg, m behind the front and above the ground, kg m^2, N.
    """

    mass: float
    behind: float
    height: float
    inertia: np.ndarray
    loads: np.ndarray


def around(mass: float, place: np.ndarray) -> np.ndarray:
    """Inertia of a point mass about the origin."""
    return mass * (place @ place * np.eye(3) - np.outer(place, place))


def masses_of(unit: Any, axles: Any) -> Masses:
    """Subtract the axles from the whole vehicle.

    Its values are floats; places are relative to its centre.
    """
    places = [np.array([unit.centre_of_mass - a.position, 0.0, a.radius - unit.centre_height]) for a in axles]
    mass = unit.mass - sum(a.mass for a in axles)
    centre = -sum(a.mass * place for a, place in zip(axles, places, strict=True)) / mass
    inertia = np.diag([unit.roll_inertia, unit.pitch_inertia, unit.yaw_inertia]) - around(mass, centre)
    for axle, place in zip(axles, places, strict=True):
        inertia -= around(axle.mass, place) + np.diag([1.0, 0.0, 1.0]) * rod(axle)
    levers = np.array([[1.0, 1.0], [place[0] for place in places]])
    loads = np.linalg.solve(levers, [unit.mass * GRAVITY, 0.0])
    return Masses(mass, unit.centre_of_mass - centre[0], unit.centre_height + centre[2], inertia, loads)


def rod(axle: SpaceAxle) -> float:
    """Inertia of an axle in roll and yaw [kg m^2]."""
    return float(axle.mass * (AXLE_GYRATION * axle.track) ** 2)


class Truck:
    """A truck with two axles in MuJoCo, at rest on the ground.

    Parameters
    ----------
    geoms : tuple of str
        XML of geoms of the world and of the sprung mass.
    """

    def __init__(
        self, vehicle: SpaceVehicle, speed: float, angle: float, geoms: tuple[str, str] = ("", "")
    ) -> None:
        (self.unit,), self.axles = vehicle.units, vehicle.axles
        self.masses = masses_of(self.unit, self.axles)
        self.model = mujoco.MjModel.from_xml_string(self._xml(*geoms))
        self.data = mujoco.MjData(self.model)
        self.push = np.zeros(5)
        self.data.qpos[3:7] = math.cos(0.5 * angle), 0.0, 0.0, -math.sin(0.5 * angle)
        self.data.qvel[:2] = speed * math.cos(angle), -speed * math.sin(angle)

    def _xml(self, world: str, body: str) -> str:
        """Return the model."""
        m, axles = self.masses, ""
        for axle in self.axles:
            place = f"{m.behind - axle.position} 0 {axle.roll_centre - m.height}"
            axles += f"""<body pos="{place}"><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="1 0 0"/>
            <inertial pos="0 0 {axle.radius - axle.roll_centre}" mass="{axle.mass}"
            diaginertia="{rod(axle)} 1e-6 {rod(axle)}"/></body>"""
        entries = [m.inertia[place] for place in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        return f"""<mujoco><compiler autolimits="true"/>
        <option timestep="{STEP}" gravity="0 0 -{GRAVITY}" integrator="RK4" cone="elliptic"/>
        <worldbody>{world}<body pos="0 0 {m.height}"><freejoint/>
        <inertial pos="0 0 0" mass="{m.mass}" fullinertia="{" ".join(map(str, entries))}"/>{body}{axles}</body>
        </worldbody></mujoco>"""

    @property
    def whole(self) -> np.ndarray:
        """Centre of the whole mass, axles at rest [m]."""
        turn = self.data.xmat[1].reshape(3, 3)
        ahead = self.masses.behind - self.unit.centre_of_mass
        return np.asarray(
            self.data.xpos[1] + turn @ (ahead, 0.0, self.unit.centre_height - self.masses.height)
        )

    def forces(self, model: Any, data: Any) -> None:
        """Add springs, dampers, tyres and the push to the passive forces."""
        for number, (axle, load) in enumerate(zip(self.axles, self.masses.loads, strict=True)):
            self._spring(data, 6 + 2 * number, axle, 0.5 * (load - GRAVITY * axle.mass))
            self._tyres(model, data, 2 + number, axle, 0.5 * load)
        point = self.whole + np.array([self.push[3], 0.0, 0.0])
        point[2] = self.push[4]
        mujoco.mj_applyFT(model, data, self.push[:3], np.zeros(3), point, 1, data.qfrc_passive)

    def _spring(self, data: Any, joint: int, axle: SpaceAxle, load: float) -> None:
        """Add both springs of an axle with their dampers."""
        damper = 2.0 * axle.damping_ratio * math.sqrt(axle.spring * load / GRAVITY)
        heave, roll = data.qpos[joint + 1 : joint + 3]
        for arm in (-0.5 * axle.spacing, 0.5 * axle.spacing):
            rate = np.array([1.0, arm * math.cos(roll)])
            force = (
                -load
                - axle.spring * (heave + arm * math.sin(roll))
                - damper * rate @ data.qvel[joint : joint + 2]
            )
            data.qfrc_passive[joint : joint + 2] += force * rate

    def _tyres(self, model: Any, data: Any, body: int, axle: SpaceAxle, load: float) -> None:
        """Add loads and side forces of both tyres of an axle."""
        turn, ahead = data.xmat[body].reshape(3, 3), data.xmat[1].reshape(3, 3)[:2, 0]
        ahead = np.array([*(ahead / np.hypot(*ahead)), 0.0])
        across, jacobian = np.array([-ahead[1], ahead[0], 0.0]), np.empty((3, model.nv))
        for side in (-0.5, 0.5):
            point = data.xpos[body] + turn @ (0.0, side * axle.track, -axle.roll_centre - load / axle.tyre)
            normal = axle.tyre * max(-point[2], 0.0)
            point[2] = max(point[2], 0.0)
            mujoco.mj_jac(model, data, jacobian, None, point, body)
            velocity = jacobian @ data.qvel
            force = np.array([0.0, 0.0, normal])
            if normal > 0.0 and axle.friction > 0.0:
                slip = math.atan2(velocity @ across, max(abs(velocity @ ahead), 1.0))
                force -= axle.friction * normal * math.tanh(axle.cornering * slip / axle.friction) * across
            data.qfrc_passive += jacobian.T @ force

    def follow(self, rows: int, push: np.ndarray) -> tuple[Angles, np.ndarray]:
        """Return angles and mean contact forces of every interval."""
        parts, poses, contacts = round(INTERVAL / STEP), [], np.zeros((rows, 5))
        mujoco.set_mjcb_passive(self.forces)
        for row in range(rows):
            mujoco.mj_forward(self.model, self.data)
            poses.append(self.data.xmat[1].copy())
            self.push = push[row] if row < len(push) else np.zeros(5)
            wrench = np.zeros(6)
            for _ in range(parts):
                mujoco.mj_step(self.model, self.data)
                wrench += self._touched() / parts
            contacts[row] = as_push(wrench, self.whole[2])
        mujoco.set_mjcb_passive(None)
        turns = np.array(poses)
        yaw = np.arctan2(turns[:, 3], turns[:, 0])
        return Angles(np.arctan2(turns[:, 7], turns[:, 8]), -np.arcsin(turns[:, 6]), yaw - yaw[0]), contacts

    def _touched(self) -> np.ndarray:
        """Force of contacts on the truck, and moment about its centre."""
        total, one = np.zeros(6), np.zeros(6)
        for number in range(self.data.ncon):
            contact = self.data.contact[number]
            mujoco.mj_contactForce(self.model, self.data, number, one)
            force = one[0] * contact.frame[:3]
            force = force if force[1] > 0.0 else -force
            total += *force, *np.cross(contact.pos - self.whole, force)
        return total


def as_push(wrench: np.ndarray, height: float) -> np.ndarray:
    """Return the push of a force and moment at a height."""
    if wrench[1] <= 0.0:
        return np.zeros(5)
    return np.array([*wrench[:3], wrench[5] / wrench[1], height - wrench[3] / wrench[1]])


def applied(history: dict[str, np.ndarray]) -> np.ndarray:
    """The push of each interval by the history of an impact."""
    rows = np.column_stack([history[name] for name in ("force_tangential", "force_normal", "force_vertical")])
    with np.errstate(invalid="ignore", divide="ignore"):
        places = [history[name] / history["force_normal"] for name in ("moment_station", "moment_height")]
    push = np.column_stack([PART * rows, *places])
    push[history["force_normal"] <= 0.0] = 0.0
    return push[1 : 1 + round(LASTING / INTERVAL)]


def tell(name: str, ours: Angles, theirs: Angles, required: str = "1 %") -> None:
    """Print the largest angles of both with their difference."""
    command_line.row(name, "", "")
    for angle, largest in ours.largest.items():
        in_mujoco = theirs.largest[angle]
        both = f"{math.degrees(largest):8.4f} {math.degrees(in_mujoco):8.4f} deg  {in_mujoco / largest - 1.0:+.1e}"
        command_line.row(f"  largest {angle}: solver.space, MuJoCo, difference", required, both)


def compare(name: str, changes: tuple[str, ...]) -> None:
    """Compare both under the force of an impact."""
    inputs = space_input(read_scene(SCENE, changes)[0])
    vehicle, _, speed, angle = inputs
    push = applied(solve_space(*inputs, interval=INTERVAL).history)
    free = replace(vehicle, strips=UNTOUCHED)
    ours = solve_space(free, FAR, speed, angle, interval=INTERVAL, end=LONG, push=push)
    theirs, _ = Truck(vehicle, speed, angle).follow(len(ours.history["t"]), push)
    tell(f"{name}; error stated {ours.error:.0e}", angles_of(ours.history), theirs)


def engine() -> None:
    """Compare a contact in the engine with strips, and its force."""
    inputs = space_input(read_scene(SCENE, ())[0])
    vehicle, _, speed, angle = inputs
    (unit,) = vehicle.units
    masses, slope = masses_of(unit, vehicle.axles), CORNER / THICK
    soft = f'condim="1" solref="{SOFT[0]} {SOFT[1]}"'
    place = f"{masses.behind - 0.5 * unit.length} 0 {LEVEL - masses.height}"
    size = f"{0.5 * unit.length} {0.5 * unit.width} {0.5 * THICK}"
    box = f'<geom type="box" size="{size}" pos="{place}" mass="0" {soft}/>'
    wall = f'<geom type="box" size="200 2 1" pos="0 -2 1" {soft}/>'
    truck = Truck(vehicle, speed, angle, (wall, box))
    truck.data.qpos[1] = masses.behind * math.sin(angle) + 0.5 * unit.width * math.cos(angle)
    rows = round(1.5 / INTERVAL)
    theirs, contacts = truck.follow(rows, np.zeros((0, 5)))
    levels = LEVEL - 0.5 * THICK, LEVEL + 0.5 * THICK
    corners = tuple(SpaceStrip((at, at), levels, slope, restitution=RETURNED) for at in (0.0, unit.length))
    end = INTERVAL * (rows - 1)
    strips_motion = solve_space(
        replace(vehicle, strips=corners), SpaceWall(2.0), speed, angle, interval=INTERVAL, end=end
    )
    tell("contact in MuJoCo, strips in solver.space", angles_of(strips_motion.history), theirs, "explained")
    impulses = (
        INTERVAL * float(force.sum()) for force in (strips_motion.history["force_normal"], contacts[:, 1])
    )
    command_line.row(
        "  impulse: solver.space, MuJoCo", "", ", ".join(f"{1e-3 * part:.2f} kN s" for part in impulses)
    )
    free = replace(vehicle, strips=UNTOUCHED)
    pushed = solve_space(free, FAR, speed, angle, interval=INTERVAL, end=end, push=contacts)
    tell("contact in MuJoCo, its force applied in solver.space", angles_of(pushed.history), theirs)


def main() -> None:
    """Print the largest angles of each scene in both."""
    command_line.options(__doc__)
    for name, changes in SCENES.items():
        compare(name, changes)
    engine()


if __name__ == "__main__":
    main()
