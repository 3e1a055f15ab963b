"""Motion of the rigid vehicle of a whole impact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.cache import cached
from postprocess.comparison import quantities
from postprocess.signals.filters import force_curves
from solver import impact
from solver.impact.solve import loads_at_rest
from tailslap import progress
from tailslap.case.case import WHOLE_IMPACT, Case
from tailslap.case.impact import answers, rigid_input, strike_columns
from tailslap.case.impact.paper_method import paper_method
from tailslap.errors import InputError, Missing
from tailslap.scene.schema import value_at

if TYPE_CHECKING:
    from tailslap.case.impact.space.answer import SpaceAnswer
    from tailslap.case.impact.space.input import SpaceInput

AFTER_SECOND = 0.1
"""Time [s] from the second strike to the end of an impact without time.end."""

LONGEST = 5.0
"""Time [s] after which an impact without a second strike ends."""

SAMPLE = 2e-4
"""Longest time between rows [s]: 5 kHz, above the requirement of CFC 180."""

ROWS_A_STRIKE, MOST_ROWS = 200, 200_000
"""Rows in the shorter of the rigid vehicle's first two strikes; most rows of a history."""

TRAIN_TOLERANCE = 1e-4
"""Error by which the step of a train is chosen; the actual error is a hundredth of that."""

OF_A_TRAILER = ("centre_of_mass", "yaw_inertia", "hitch", "kingpin", "mass", "length", "width")
"""Keys of a trailer that it depends on; the first two have computed values where the scene omits them."""

OF_AN_AXLE = ("position", "friction", "cornering")
"""Keys of an axle that it depends on."""

SENSOR = "sensor_velocity"
"""Column of a history with the velocity of the sensor away from the wall."""

INTERVAL = 5e-4
"""Time between rows of the forces of many impacts [s]: peaks of a 50 ms mean are within 1e-4."""

STRIKES = 32
"""Strikes of each of many impacts for which there is room at first."""


def row_interval(shortest: float, end: float) -> float:
    """Return the time between rows [s].

    shortest, end: duration of the shortest strike, and end of the motion [s].
    """
    return min(SAMPLE, max(shortest / ROWS_A_STRIKE, end / MOST_ROWS))


@cached
def _solved(case: tuple[Any, ...], end: float | None, tolerance: float) -> impact.ImpactMotion:
    """Return the impact of a vehicle, contact, touch, trailers and axles.

    Plates of one vehicle differ in stiffness and mesh, and have it in common.
    """
    vehicle, contact, touch, trailers, axles = case
    times = end, AFTER_SECOND, LONGEST
    options: dict[str, Any] = {"tolerance": tolerance, "trailers": trailers, "axles": axles}
    return impact.solve_impact(vehicle, contact, touch, *times, on_compile=progress.compiling, **options)


@dataclass(frozen=True)
class RigidMotion(Case):
    """Motion of the rigid vehicle of a scene with [contact].

    It is that in space with [body]. `motion` is then its companion in the plane, of plates and studies.
    """

    name = WHOLE_IMPACT
    compared = quantities.STRIKES
    force_words = "Largest 50 ms mean of the lateral force"
    force_column = "peaks.mean_50ms"

    def __post_init__(self) -> None:
        """Raise InputError for an impossible vehicle, or without an impact."""
        if self.scene.impact is None or self.scene.contact is None:
            raise InputError("contact", Missing, "a whole impact needs this table and [impact]")
        _ = self.touch
        assert self.space_input or self.motion.strikes or self.scene.time.end

    @cached_property
    def vehicle(self) -> impact.ImpactVehicle:
        """The rigid vehicle."""
        with rigid_input.refusals(self.scene):
            return rigid_input.rigid_vehicle(self.scene.vehicle)

    @cached_property
    def trailers(self) -> tuple[impact.HitchedVehicle, ...]:
        """Rigid trailers behind the vehicle."""
        trailers = list[impact.HitchedVehicle]()
        for number, unit in enumerate(self.scene.trailer):
            with rigid_input.refusals(self.scene, f"trailer.{number}"):
                trailers.append(
                    impact.HitchedVehicle(rigid_input.rigid_vehicle(unit), unit.hitch, unit.kingpin)
                )
        return tuple(trailers)

    @property
    def vehicles(self) -> tuple[impact.ImpactVehicle, ...]:
        """Vehicle and trailers."""
        return self.vehicle, *(trailer.vehicle for trailer in self.trailers)

    @property
    def lengths(self) -> tuple[float, ...]:
        """Lengths of the units [m]."""
        return tuple(unit.length for unit in self.scene.units)

    @cached_property
    def contact(self) -> impact.WallContact:
        """What touches the wall, with its laws."""
        with rigid_input.refusals(self.scene):
            return rigid_input.wall_contact(self.scene)

    @property
    def awaited(self) -> str | None:
        """Contact whose strike is awaited, None for the second strike."""
        group = impact.awaited(self.contact, self.lengths)
        return None if group < 0 else self.names[group]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of what touches the wall, by group."""
        return impact.group_names(self.contact, self.lengths)

    @property
    def axles(self) -> tuple[impact.TyreAxle, ...]:
        """Axles, or none where no tyre has friction.

        One without friction carries its load.
        """
        axles = self.scene.axle if any(axle.friction for axle in self.scene.axle) else ()
        return tuple(
            impact.TyreAxle(axle.position, axle.friction, axle.cornering, axle.unit - 1) for axle in axles
        )

    @property
    def loads(self) -> tuple[float, ...]:
        """Load of each of the `axles` at rest [N]."""
        with rigid_input.refusals(self.scene):
            return loads_at_rest(self.vehicle, self.contact, self.trailers, self.axles)

    @cached_property
    def touch(self) -> impact.ImpactState:
        """State at first touch."""
        table = self.scene.impact
        assert self.contact
        assert table
        with rigid_input.refusals(self.scene):
            return impact.first_touch(self.vehicle, table.angle, table.speed, self.trailers, self.contact)

    @cached_property
    def motion(self) -> impact.ImpactMotion:
        """Impact in the plane to the scene's end."""
        return self.motion_until(self.scene.time.end)

    def motion_until(self, end: float | None) -> impact.ImpactMotion:
        """Return the impact in the plane to another end [s].

        None: `AFTER_SECOND` after the second strike, for a train after that of the last rear, or when a strike then in
        progress is over.
        """
        with rigid_input.refusals(self.scene):
            case = self.vehicle, self.contact, self.touch, self.trailers, self.axles
            return _solved(case, end, TRAIN_TOLERANCE if self.trailers else impact.TOLERANCE)

    @property
    def impact_severity(self) -> float:
        """Impact severity m (v sin(theta))^2/2 [J], m of the whole train."""
        table = self.scene.impact
        assert table
        mass = sum(unit.mass for unit in self.vehicles)
        return float(0.5 * mass * (table.speed * math.sin(table.angle)) ** 2)

    @property
    def duration(self) -> float:
        """End of the impact [s], with [plate] in the plane."""
        is_planar = self.scene.plate or not self.space
        return self.motion.t_end if is_planar else float(self.answer.history["t"][-1])

    @cached_property
    def sample(self) -> float:
        """Time between rows [s] that resolves both strikes."""
        motion = self.motion
        counted = motion.strikes[: answers.counted(len(self.vehicles))]
        shortest = min((strike.duration for strike in counted), default=SAMPLE * ROWS_A_STRIKE)
        return row_interval(shortest, motion.t_end)

    @cached_property
    def in_plane(self) -> answers.ImpactAnswer:
        """Sampled impact in the plane."""
        rows = max(2, int(np.ceil(self.motion.t_end / self.sample)))
        return answers.rigid_answer(self.motion, np.linspace(0.0, self.motion.t_end, rows + 1))

    @property
    def answer(self) -> answers.ImpactAnswer:
        """Sampled impact of the rigid vehicle, with [body] in space."""
        return self.space.answer if self.space else self.in_plane

    @property
    def arguments(self) -> tuple[str, ...]:
        """Keys of the scene that the impact depends on."""
        numbers, laws = range(len(self.trailers)), [*rigid_input.touching(self.scene)]
        keys = dict.fromkeys(rigid_input.ARGUMENTS)
        keys |= dict.fromkeys(f"trailer.{number}.{key}" for number in numbers for key in OF_A_TRAILER)
        keys |= dict.fromkeys(key.partition("@")[0] for part in laws for key in part.keys.values())
        unused = {
            key
            for key in keys
            if value_at(self.scene, key) is None and key.startswith(("contact.", "strip."))
        }
        if not self.scene.of_corners:
            unused |= {key for key in rigid_input.OF_CORNERS if key != "contact.restitution"}
        axles = (f"axle.{number}.{key}" for number in range(len(self.scene.axle)) for key in OF_AN_AXLE)
        inertia = ("vehicle.yaw_inertia",) if self.scene.vehicle.yaw_inertia is not None else ()
        return (*(key for key in keys if key not in unused), *inertia, *axles)

    @property
    def inputs(self) -> dict[str, float]:
        """Values of `arguments` in the scene."""
        values = {key: value_at(self.scene, key) or 0.0 for key in self.arguments}
        for number, trailer in enumerate(self.trailers):
            body = trailer.vehicle
            computed = zip(OF_A_TRAILER, (body.front_distance, body.inertia), strict=False)
            values |= {f"trailer.{number}.{key}": value for key, value in computed}
        return values | {"vehicle.centre_of_mass": self.vehicle.front_distance}

    def impacts(self, inputs: Mapping[str, np.ndarray], **until: Any) -> impact.Impacts:
        """Return the impacts of n vehicles.

        inputs: as of `many`; until: options of `solve_impacts`.
        """
        middle = self.scene.vehicle.centre_of_mass  # None: at half the length of each
        values: dict[str, Any] = {**self.inputs, "vehicle.centre_of_mass": middle, **inputs}
        arguments = rigid_input.at_table(values, ("impact", "vehicle"))
        if (inertia := self.scene.vehicle.yaw_inertia) is not None and "vehicle.yaw_inertia" not in inputs:
            arguments["yaw_inertia"] = inertia / self.vehicle.mass * np.asarray(values["vehicle.mass"])
        trailers = []
        for number, trailer in enumerate(self.trailers):
            unit = rigid_input.at_table(values, (f"trailer.{number}",))
            unit["yaw_inertia"] = unit["yaw_inertia"] * np.asarray(unit["mass"]) / trailer.vehicle.mass
            trailers.append(unit)
        axles = [
            {**rigid_input.at_table(values, (f"axle.{number}",)), "unit": axle.unit - 1}
            for number, axle in enumerate(self.scene.axle)
        ]
        with rigid_input.refusals(self.scene):
            return impact.solve_impacts(
                **arguments, contact=rigid_input.wall_contact(self.scene, inputs), trailers=trailers, axles=axles,
                longest=LONGEST, **until,
            )  # fmt: skip

    def many(self, inputs: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return both strikes of n impacts.

        inputs: shape (n,), by key of `arguments`, or of the law of a corner, see `touching` [SI]; the others are those
        of the scene. The yaw inertia is in proportion to the mass. Returns columns as of
        `both_strikes` [SI], NaN where there is no such strike. Raises InputError where the theory refuses one of them.
        """
        impacts = self.impacts(inputs, after_second=AFTER_SECOND, interval=INTERVAL, strikes=STRIKES)
        return strike_columns.columns_of_many(impacts, INTERVAL, impact.outermost(self.contact, self.lengths))

    def largest_means(self, inputs: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the largest 50 ms means of n impacts [N], see `many`."""
        impacts = self.impacts(inputs, after_second=AFTER_SECOND, interval=INTERVAL, strikes=STRIKES)
        means = force_curves(impacts.mean_force.T, INTERVAL, ("mean_50ms",))["mean_50ms"]
        return {strike_columns.LARGEST: means.max(axis=-1)}

    @cached_property
    def inertial(self) -> dict[str, Any] | None:
        """Inertial estimate of the largest 50 ms mean, None of trains.

        Mass times acceleration of the sensor away from the wall [N], its place behind the front and with [body] its
        height [m], and whether they are assumed.
        """
        if self.trailers:
            return None
        sensor = self.scene.sensor
        is_placed = sensor is not None and (sensor.position is not None or sensor.behind_centre is not None)
        if self.space and self.space_input and self.space_input.vehicle.sensor:
            position, height = map(float, self.space_input.vehicle.sensor)
            is_assumed = not is_placed or sensor is None or sensor.height is None
            mean = float(self.space.motion.answers.inertial_50ms)
            return {"mean_50ms": mean, "position": position, "height": height, "assumed": is_assumed}
        position = float(rigid_input.sensor_position(self.scene, {}))
        force = self.vehicle.mass * np.diff(self._sensor_velocity(self.in_plane)) / self.in_plane.interval
        mean = float(force_curves(force, self.in_plane.interval, ("mean_50ms",))["mean_50ms"].max())
        return {"mean_50ms": mean, "position": position, "assumed": not is_placed}

    def _sensor_velocity(self, answer: answers.ImpactAnswer) -> np.ndarray:
        """Return the velocity of the sensor away from the wall [m/s]."""
        h = answer.history
        if answer.in_space:
            return h[SENSOR]
        arm = self.vehicle.front_distance - float(rigid_input.sensor_position(self.scene, {}))
        speed: np.ndarray = h["v_gy"] + h["omega"] * arm * np.cos(h["theta"])
        return speed

    def recorded(self, answer: answers.ImpactAnswer) -> dict[str, np.ndarray]:
        """Return the columns of a file, with [sensor] also its own.

        Its acceleration [m/s^2] is the mean since the row before, 0 in the first row.
        """
        columns = {name: column for name, column in answer.columns.items() if name != SENSOR}
        if self.scene.sensor is None:
            return columns
        speed = self._sensor_velocity(answer)
        acceleration = np.diff(speed, prepend=speed[:1]) / answer.interval
        return columns | {SENSOR: speed, "sensor_acceleration": acceleration}

    @cached_property
    def space_input(self) -> SpaceInput | None:
        """Vehicle in space, None without [body]. Raises InputError for impossible values."""
        if self.scene.body is None:
            return None
        from tailslap.case.impact.space.input import space_input

        with rigid_input.refusals(self.scene):
            return space_input(self.scene)

    @cached_property
    def space(self) -> SpaceAnswer | None:
        """Motion of the vehicle in space, None without [body]."""
        if self.space_input is None:
            return None
        from tailslap.case.impact.space.answer import solve

        with rigid_input.refusals(self.scene):
            return solve(self.space_input)

    @property
    def plateaus(self) -> list[float]:
        """Plateau of each contact in the plane [N], infinite without one."""
        if self.contact.crush:
            return [float(self.contact.crush.plateau_force)]
        return [
            float(strip.law.plateau_force) * (float(strip.at[1] - strip.at[0]) if strip.is_line else 1.0)
            for strip in self.contact.strips
        ]

    @cached_property
    def paper_method(self) -> dict[str, Any] | None:
        """Results of the paper's method, see `paper_method`."""
        return paper_method(self.scene, self.answer)

    def rigid_history(self) -> dict[str, np.ndarray]:
        """Return columns of the impact by name, SI."""
        return self.recorded(self.answer)
