"""The plate as a rigid body in Exudyn."""

from __future__ import annotations

import json
import sys
import time

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    MarkerBodyRigid,
    NodeRigidBody2D,
    ObjectGround,
    ObjectJointPrismatic2D,
    ObjectRigidBody2D,
    SensorNode,
)
from other_codes.jobs import at_zero
from other_codes.plate import Plate, from_argument

STEPS = 460
"""Steps of a millisecond, if the angle is the paper's: their error is then far below what flexibility changes."""
LONGER = 1.2
"""End of the motion over the time that the tail-slap is expected at."""


class ExudynBody:
    """The body, the joint, and sensors of coordinates and velocities."""

    def __init__(self, plate: Plate) -> None:
        self.plate, self.container = plate, exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.arm = np.array([-0.5 * plate.length, 0.5 * plate.width])
        self.centre = turn(plate.angle) @ self.arm
        node = self.system.AddNode(self._node())
        mass = plate.density * plate.thickness * plate.length * plate.width
        inertia = mass * (plate.length**2 + plate.width**2) / 12.0
        body = self.system.AddObject(ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))
        self._slide(body)
        kinds = ("Coordinates", "Coordinates_t")
        self.sensors = [self.system.AddSensor(sensor(node, kind)) for kind in kinds]
        self.system.Assemble()

    def _node(self) -> NodeRigidBody2D:
        plate, (x, y) = self.plate, self.centre
        velocity = [float(v) for v in (plate.speed - plate.omega * y, plate.omega * x, plate.omega)]
        return NodeRigidBody2D(referenceCoordinates=[x, y, -plate.angle], initialVelocities=velocity)

    def _slide(self, body: int) -> None:
        """Join the corner to the wall, whose normal has the second marker."""
        wall = self.system.AddObject(ObjectGround())
        corner = [*(-self.arm), 0.0]
        markers = [
            self.system.AddMarker(MarkerBodyRigid(bodyNumber=number, localPosition=place))
            for number, place in ((body, corner), (wall, [0.0, 0.0, 0.0]))
        ]
        joint = ObjectJointPrismatic2D(markerNumbers=markers, constrainRotation=False)
        self.system.AddObject(joint)

    def run(self, end: float) -> np.ndarray:
        """The `QUANTITIES` and the angle at each instant, shape (instants, 6)."""
        settings = exu.SimulationSettings()
        settings.timeIntegration.endTime = end
        settings.timeIntegration.numberOfSteps = STEPS
        settings.timeIntegration.verboseMode = 0
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = end / STEPS
        self.system.SolveDynamic(settings)
        places, rates = (self.system.GetSensorStoredData(number) for number in self.sensors)
        angle = self.plate.angle - places[:, 3]
        slide = self.centre[0] + places[:, 1] - (np.cos(angle) * self.arm[0] + np.sin(angle) * self.arm[1])
        return np.column_stack([places[:, 0], rates[:, 1:], slide, angle])


def sensor(node: int, kind: str) -> SensorNode:
    """Of a node, kept in memory."""
    variable = getattr(exu.OutputVariableType, kind)
    return SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=variable)


def turn(angle: float) -> np.ndarray:
    """From the body's frame to the wall's."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def main() -> None:
    """Run the event and report."""
    began = time.perf_counter()
    body = ExudynBody(from_argument())
    ready = time.perf_counter()
    rows = body.run(LONGER * float(sys.argv[3]))
    first = int(np.argmax(rows[:, 5] <= 0.0))
    near = rows[first - 2 : first + 2]
    values = (at_zero(near[:, 5].tolist()) @ near[:, :5]).tolist()
    spent = time.perf_counter() - ready
    result = {"values": values, "loop_s": spent, "ran_s": spent}
    print(json.dumps({"version": exu.__version__, "setup_s": ready - began, **result}), flush=True)


if __name__ == "__main__":
    main()
