"""Impulses of rigid trains beside those of Exudyn."""

import math
import sys
from typing import Any

import command_line
import numpy as np

from solver.impact import (
    CrushLaw,
    HitchedVehicle,
    ImpactVehicle,
    Strip,
    WallContact,
    first_touch,
    group_names,
    solve_impact,
)
from solver.impact.train import distances, lined_up
from solver.impact.train import train_of as solver_train

LIMIT, RESTITUTION, ANGLE, END = 1e-3, 0.22, math.radians(15.0), 1.0
TRACTOR = ImpactVehicle(6.9, 2.44, 8200.0, 2.9, 34621.0)
VAN, TANK = ImpactVehicle(14.6, 2.59, 27770.0, 8.0, 497057.0), ImpactVehicle(12.8, 2.59, 28082.0, 6.6)
DOLLY = ImpactVehicle(8.5, 2.5, 12000.0)
TRAINS = {  # of each trailer the body, crush [N/m], hitch and kingpin [m]
    "tractor and van": (2e6, [(VAN, 2e6, 5.6, 0.9)]),
    "tractor and soft tank": (2e6, [(TANK, 1e6, 5.6, 0.9)]),
    "tractor and two trailers": (1e6, [(DOLLY, 1.5e6, 5.6, 0.9), (DOLLY, 1e6, 8.3, -1.5)]),
}
SPEED = 22.35


def train_of(name: str, friction: float) -> tuple[ImpactVehicle, WallContact, list[HitchedVehicle]]:
    """A train of `TRAINS` as the program takes it."""
    stiffness, behind = TRAINS[name]
    strips = tuple(
        Strip((at, at), CrushLaw(k, 0.0, RESTITUTION), unit=unit)
        for unit, (body, k, *_) in enumerate(behind, 1)
        for at in (0.0, body.length)
    )
    contact = WallContact(CrushLaw(stiffness, 0.0, RESTITUTION), friction, strips)
    return TRACTOR, contact, [HitchedVehicle(body, *hinge) for body, _, *hinge in behind]


def own_impulses(name: str, friction: float) -> dict[str, float]:
    """Impulse of each corner by the program [N s]."""
    vehicle, law, trailers = train_of(name, friction)
    state = first_touch(vehicle, ANGLE, SPEED, trailers)
    impulses: dict[str, float] = {}
    for strike in solve_impact(vehicle, law, state, END, tolerance=1e-6, trailers=trailers).strikes:
        impulses[strike.corner] = impulses.get(strike.corner, 0.0) + strike.impulse
    return impulses


class Corner:
    """Corner on the bilinear crush law, its permanent crush and its impulse."""

    def __init__(self, exu: Any, body: int, place: list[float], stiffness: float, friction: float) -> None:
        self.exu, self.body, self.place, self.stiffness, self.friction = exu, body, place, stiffness, friction
        self.deepest = self.force = self.impulse = 0.0

    def output(self, mbs: Any, kind: Any) -> Any:
        """Position or velocity now."""
        return mbs.GetObjectOutputBody(self.body, kind, self.place, self.exu.ConfigurationType.Current)

    def normal(self, depth: float) -> float:
        """Return the force along the lines of loading and unloading.

        Loading has the slope k; unloading returns e^2 of the energy.
        """
        deepest = max(self.deepest, depth)
        if deepest <= 0.0:
            return 0.0
        fraction = max(0.0, 1.0 - (deepest - depth) / (RESTITUTION**2 * deepest))
        return self.stiffness * deepest * fraction

    def load(self, mbs: Any, t: float, _: Any) -> list[float]:
        """Force of the wall on the corner."""
        kinds = self.exu.OutputVariableType
        push = self.normal(-float(self.output(mbs, kinds.Position)[1]))
        if push == 0.0:
            return [0.0, 0.0, 0.0]
        slip = float(self.output(mbs, kinds.Velocity)[0])
        return [-self.friction * push * math.tanh(slip / 1e-3), push, 0.0]

    def keep(self, mbs: Any, step: float) -> None:
        """Keep the deepest crush, and add the impulse of a step."""
        depth = -float(self.output(mbs, self.exu.OutputVariableType.Position)[1])
        self.deepest, force = max(self.deepest, depth), self.normal(depth)
        self.impulse += 0.5 * (force + self.force) * step
        self.force = force


def exudyn_impulses(name: str, friction: float, step: float) -> dict[str, float]:
    """Impulse of each corner by Exudyn [N s]."""
    import exudyn as exu
    import exudyn.itemInterface as items  # noqa: N813

    vehicle, law, trailers = train_of(name, friction)
    bodies = [vehicle, *(trailer.vehicle for trailer in trailers)]
    train = solver_train(bodies, law, [(trailer.hitch, trailer.kingpin) for trailer in trailers])
    names = group_names(law, [body.length for body in bodies])
    first = first_touch(vehicle, ANGLE, SPEED, trailers)
    state = (first.x_g, first.y_g, first.theta, first.v_gx, first.v_gy, first.omega)
    container = exu.SystemContainer()
    mbs, corners, numbers = container.AddSystem(), dict[str, Corner](), []
    states = lined_up(state, distances(vehicle, trailers))
    for unit, (body, initial) in enumerate(zip(bodies, states, strict=True)):
        x, y, theta, u, v, w = initial.tolist()
        node = items.NodeRigidBody2D(referenceCoordinates=[x, y, -theta], initialVelocities=[u, v, w])
        inertia = {"mass": body.mass, "inertia": body.inertia}
        numbers.append(mbs.AddObject(items.ObjectRigidBody2D(nodeNumber=mbs.AddNode(node), **inertia)))
        for point in np.flatnonzero(train.unit == unit):
            place = [float(train.along[point, 0]), float(train.across[point, 0]), 0.0]
            spring_corner = Corner(exu, numbers[-1], place, float(train.stiffness[point, 0]), friction)
            marker = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=numbers[-1], localPosition=place))
            mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVectorUserFunction=spring_corner.load))
            corners[names[train.group[point]]] = spring_corner
    for unit, trailer in enumerate(trailers):
        ends = (bodies[unit].front_distance - trailer.hitch, trailer.vehicle.front_distance - trailer.kingpin)
        places = [
            {"bodyNumber": numbers[unit + k], "localPosition": [x, 0.0, 0.0]} for k, x in enumerate(ends)
        ]
        markers = [mbs.AddMarker(items.MarkerBodyPosition(**place)) for place in places]
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))

    def keep(mbs: Any, t: float) -> bool:
        for corner in corners.values():
            corner.keep(mbs, step)
        return True

    mbs.SetPreStepUserFunction(keep)
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = round(END / step), END
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2)
    keep(mbs, END)
    return {name: corner.impulse for name, corner in corners.items() if corner.impulse > 0.0}


def main() -> int:
    """Print the table."""
    step, worst = command_line.options(__doc__, step=5e-5).step, 0.0
    for name in TRAINS:
        for friction in (0.0, 0.47):
            ours, other = own_impulses(name, friction), exudyn_impulses(name, friction, step)
            largest = max(ours.values())
            print(f"{name}, friction {friction:g}")
            for corner in sorted({*ours, *other}):
                one, two = ours.get(corner, 0.0), other.get(corner, 0.0)
                off = (one - two) / largest
                worst = max(worst, abs(off))
                print(f"  {corner:<22}{one / 1e3:10.4f}{two / 1e3:10.4f} kN s  {off:+.1e}")
    print(f"largest difference, of the largest impulse: {worst:.1e} (limit {LIMIT:g})")
    return int(not np.isfinite(worst) or worst > LIMIT)


if __name__ == "__main__":
    sys.exit(main())
