"""Rigid vehicle of a whole impact, and the texts of `tailslap rigid`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.cache import cached
from postprocess.comparison import quantities
from postprocess.report.page import Headline
from postprocess.signals.filters import LABELS, force_curves
from postprocess.units import SYSTEMS, force, measure, percent_up
from solver import impact
from solver.impact.solve import loads_at_rest
from tailslap import progress
from tailslap.case.case import NO_BAND, WHOLE_IMPACT, Case
from tailslap.case.force_band import ForceBand
from tailslap.case.impact import answers, strike_columns
from tailslap.case.impact.paper_method import DIGITS, paper_lines, paper_method
from tailslap.case.impact.rigid_input import (
    ARGUMENTS,
    OF_CORNERS,
    at_table,
    refusals,
    rigid_vehicle,
    sensor_position,
    touching,
    wall_contact,
)
from tailslap.errors import InputError, Missing
from tailslap.scene.schema import value_at
from tailslap.scene.units import shown, value_line

if TYPE_CHECKING:
    from postprocess.svg.chart import Chart
    from tailslap.case.impact.space import SpaceAnswer, SpaceInput

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

EQUAL, OF_SCENE = ", equal to its assumed plateau", "This scene: "
"""Words behind a force that equals its plateau, and before the force of a scene beside a band."""

ROUNDING = 2e-3
"""Relative difference from a plateau of a force that equals it."""

OF_CRUSH = {
    "initial_force": "initial crush force",
    "patch_length": "forces over",
    "plateau_force": "plateau",
    "hardening": "hardening",
    "unloading_stiffness": "unloading stiffness",
}
"""Quantities of [contact] beside the stiffness, in words."""

SENSOR = "sensor_velocity"
"""Column of a history with the velocity of the sensor away from the wall."""

INTERVAL = 5e-4
"""Time between rows of the forces of many impacts [s]: peaks of a 50 ms mean are within 1e-4."""

STRIKES = 32
"""Strikes of each of many impacts for which there is room at first."""

ENDS = {
    "t": ("time", "s"),
    "theta": ("angle", "rad"),
    "omega": ("angular velocity", "rad/s"),
    "v_gx": ("v_GX", "m/s"),
    "v_gy": ("v_GY", "m/s"),
}
"""Labels and units of the end."""


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
class RigidImpact(Case):
    """Rigid vehicle of a scene with [contact].

    Its motion is that in space with [body]. `motion` is then its companion in the plane, of plates and studies.
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
        with refusals(self.scene):
            return rigid_vehicle(self.scene.vehicle)

    @cached_property
    def trailers(self) -> tuple[impact.HitchedVehicle, ...]:
        """Rigid trailers behind the vehicle."""
        trailers = list[impact.HitchedVehicle]()
        for number, unit in enumerate(self.scene.trailer):
            with refusals(self.scene, f"trailer.{number}"):
                trailers.append(impact.HitchedVehicle(rigid_vehicle(unit), unit.hitch, unit.kingpin))
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
        with refusals(self.scene):
            return wall_contact(self.scene)

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
        """Axles whose tyres have friction."""
        axles = (axle for axle in self.scene.axle if axle.friction)
        return tuple(
            impact.TyreAxle(axle.position, axle.friction, axle.cornering, axle.unit - 1) for axle in axles
        )

    @property
    def loads(self) -> tuple[float, ...]:
        """Load of each of the `axles` at rest [N]."""
        with refusals(self.scene):
            return loads_at_rest(self.vehicle, self.contact, self.trailers, self.axles)

    @cached_property
    def touch(self) -> impact.ImpactState:
        """State at first touch."""
        table = self.scene.impact
        assert self.contact
        assert table
        with refusals(self.scene):
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
        with refusals(self.scene):
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
        numbers, laws = range(len(self.trailers)), [*touching(self.scene)]
        keys = dict.fromkeys(ARGUMENTS)
        keys |= dict.fromkeys(f"trailer.{number}.{key}" for number in numbers for key in OF_A_TRAILER)
        keys |= dict.fromkeys(key.partition("@")[0] for part in laws for key in part.keys.values())
        unused = {
            key
            for key in keys
            if value_at(self.scene, key) is None and key.startswith(("contact.", "strip."))
        }
        if not self.scene.of_corners:
            unused |= {key for key in OF_CORNERS if key != "contact.restitution"}
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
        arguments = at_table(values, ("impact", "vehicle"))
        if (inertia := self.scene.vehicle.yaw_inertia) is not None and "vehicle.yaw_inertia" not in inputs:
            arguments["yaw_inertia"] = inertia / self.vehicle.mass * np.asarray(values["vehicle.mass"])
        trailers = []
        for number, trailer in enumerate(self.trailers):
            unit = at_table(values, (f"trailer.{number}",))
            unit["yaw_inertia"] = unit["yaw_inertia"] * np.asarray(unit["mass"]) / trailer.vehicle.mass
            trailers.append(unit)
        axles = [
            {**at_table(values, (f"axle.{number}",)), "unit": axle.unit - 1}
            for number, axle in enumerate(self.scene.axle)
        ]
        with refusals(self.scene):
            return impact.solve_impacts(
                **arguments, contact=wall_contact(self.scene, inputs), trailers=trailers, axles=axles, longest=LONGEST,
                **until,
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
        position, speed = float(sensor_position(self.scene, {})), self._sensor_velocity(self.in_plane)
        force = self.vehicle.mass * np.diff(speed) / self.in_plane.interval
        mean = float(force_curves(force, self.in_plane.interval, ("mean_50ms",))["mean_50ms"].max())
        return {"mean_50ms": mean, "position": position, "assumed": not is_placed}

    def _sensor_velocity(self, answer: answers.ImpactAnswer) -> np.ndarray:
        """Return the velocity of the sensor away from the wall [m/s]."""
        h = answer.history
        if answer.in_space:
            return h[SENSOR]
        arm = self.vehicle.front_distance - float(sensor_position(self.scene, {}))
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

    @property
    def inertial_sentence(self) -> str:
        """Inertial estimate in words, empty of trains."""
        if self.inertial is None:
            return ""
        height = (
            f" at a height of {measure(self.inertial['height'], 'm', '.2f')}"
            if "height" in self.inertial
            else ""
        )
        where = f"{measure(self.inertial['position'], 'm', '.2f')} behind the front{height}"
        assumed = ", an assumed place" if self.inertial["assumed"] else ""
        return (
            f"Inertial estimate, as crash tests publish it: {force(self.inertial['mean_50ms'])}, mass times the 50 ms "
            f"mean of the lateral acceleration {where}{assumed}."
        )

    def details(self) -> list[str]:
        """List the properties of the contact."""
        contact, wall = self.scene.needed_contact, self.scene.meshed_wall
        law = "penalty contact" if contact.enforcement == "penalty" else "exact contact"
        if contact.strike_duration is not None:
            law = f"crush stiffness of a rear strike of {self.quantity('contact.strike_duration')}"
        elif contact.of_corners:
            law = f"crush stiffness {self.quantity('contact.stiffness')} a corner"
        elif self.scene.strip:
            law = f"{len(self.scene.strip)} strips that crush"
        there = (key for key in OF_CRUSH if getattr(contact, key))
        parts = [law, *(f"{OF_CRUSH[key]} {self.quantity(f'contact.{key}')}" for key in there)]
        if contact.restitution is not None:
            parts.append(f"restitution {contact.restitution:g}")
        if contact.of_corners and self.scene.strip:
            parts.append(f"{len(self.scene.strip)} strips of other units")
        if self.axles:
            parts.append(f"tyres of {len(self.axles)} axles")
        return [*parts, f"friction {contact.friction:g}", *(["deformable wall"] if wall else [])]

    @cached_property
    def space_input(self) -> SpaceInput | None:
        """Vehicle in space, None without [body]. Raises InputError for impossible values."""
        if self.scene.body is None:
            return None
        from tailslap.case.impact import space

        with refusals(self.scene):
            return space.space_input(self.scene)

    @cached_property
    def space(self) -> SpaceAnswer | None:
        """Motion of the vehicle in space, None without [body]."""
        if self.space_input is None:
            return None
        from tailslap.case.impact import space

        with refusals(self.scene):
            return space.solve(self.space_input)

    def force_sentence(
        self, answer: answers.ImpactAnswer, reliable: bool = True, band: ForceBand = NO_BAND
    ) -> str:
        """Return sentences on the largest 50 ms mean and the roll.

        With a band its median comes first; the force of the scene follows.
        """
        if not self.space and not answer.strikes:
            return "The vehicle does not strike the wall."
        name = self.force_words if reliable or self.space else f"{self.force_words}, not reliable"
        mean, where = self.scene_force(answer)
        paper = self.paper_method
        further = [self.space.verdict] if self.space else []
        further += [f"Paper's method: {force(paper['mean_50ms'])}."] if paper else []
        if not band.percentiles:
            ratio = "" if where.endswith(EQUAL) else self.design_ratio(mean)
            return " ".join([f"{name}: {where}{ratio}.", *further])
        lower, median, upper = band.limits
        ratio = self.design_ratio(median, (lower, upper))
        first = f"{name}: {band.interval}{ratio}. {OF_SCENE}{where}."
        return " ".join([first, *further])

    def scene_force(self, answer: answers.ImpactAnswer) -> tuple[float, str]:
        """Return the largest 50 ms mean [N], and in words.

        They say so if it equals a plateau.
        """
        if self.space:
            mean = float(self.space.motion.answers.mean_50ms)
            return mean, f"{force(mean)} at a height of {self.space.heights}{self._equal(mean)}"
        mean, least = answer.peaks["mean_50ms"], "at least " if answer.cut else ""
        number = int(np.argmax([answers.mean_peak(answer, strike) for strike in answer.strikes]))
        strike = answer.strikes[number]
        where = f"strike {number + 1} ({strike.part}, from {strike.start:.3f} s)"
        return mean, f"{least}{force(mean)} in {where}{self._equal(mean)}"

    def _equal(self, mean: float) -> str:
        """Return words where a force [N] equals a plateau, or ""."""
        return EQUAL if any(abs(mean / plateau - 1.0) <= ROUNDING for plateau in self.plateaus) else ""

    @property
    def plateaus(self) -> list[float]:
        """Plateau of each contact in the plane [N], infinite without one."""
        lengths = (
            float(strip.at[1] - strip.at[0]) if strip.is_line else 1.0 for strip in self.contact.strips
        )
        laws = [strip.law for strip in self.contact.strips]
        plateaus = [float(law.plateau_force) * length for law, length in zip(laws, lengths, strict=True)]
        return [*plateaus, *([float(self.contact.crush.plateau_force)] if self.contact.crush else [])]

    @cached_property
    def paper_method(self) -> dict[str, Any] | None:
        """Results of the paper's method, see `paper_method`."""
        return paper_method(self.scene, self.answer)

    def headline(self, band: ForceBand = NO_BAND) -> Headline:
        """Return the rigid vehicle's largest 50 ms mean."""
        error = (
            self.space.accuracy
            if self.space
            else f"error by the time step at most {percent_up(self.motion.error)}"
        )
        return Headline(
            f"Impact force: {self.subject}",
            self.force_sentence(self.answer, band=band),
            self.set_up,
            f"Rigid vehicle{' in space' if self.space else ''}; {error}.",
            band.sentence,
        )

    def drawing(self) -> Chart:
        """Draw the vehicle at first touch and at its second strike.

        For a train it is the strike of its last rear; without one, the end. In space it is parallel to the wall.
        """
        from postprocess.figures import positions

        if self.space:
            h = self.answer.history
            row = int(np.argmax(h["theta"] <= 0.0)) or -1
            event, last = "end" if row < 0 else "parallel to the wall", float(h["t"][row])
            places = {name: values[[0, row]] for name, values in h.items()}
        else:
            strike = answers.last_awaited(self.motion.strikes, self.awaited)
            last = strike.start if strike else self.motion.t_end
            places = vars(self.motion.at([0.0, last]))
            which = "strike" if self.trailers else "second strike"
            event = f"{which} ({strike.part})" if strike else "end"
        units = [positions.Unit(*place) for place in answers.places(places, self.vehicles)]
        words = self.drawing_words(float(places["theta"][0]))
        words |= {"second": f"{event}, after {measure(last, 's', '.3g')}"}
        caption = (
            f"Set-up from above, to scale: {self.subject}; corner P touches the wall first; "
            f"second position: {words['second']}; G: centre of mass."
        )
        return positions.draw_set_up(units, words, caption)

    def rigid_history(self) -> dict[str, np.ndarray]:
        """Return columns of the impact by name, SI."""
        return self.recorded(self.answer)

    def rigid_numbers(self) -> dict[str, Any]:
        """Return strikes, peaks and end state, SI."""
        numbers = self.answer.numbers()
        if self.space:
            numbers |= {"space": self.space.numbers(), "strikes": self.space.strikes}
        elif self.trailers:
            numbers["error"] = self.motion.error
        numbers["impact_severity"] = self.impact_severity
        numbers["remarks"] = answers.remarks(self.answer)
        return {
            "scene": self.scene.name,
            **numbers,
            "inertial": self.inertial,
            "paper_method": self.paper_method,
        }

    def rigid_text(self, units: str = "si") -> list[str]:
        """Return the lines for a terminal.

        units: "si", or "us" for ft, mph and kip.
        """
        lines = ["US customary units; 1 kip = 1000 lbf", ""] if units == "us" else []
        lines += self._strike_lines(units) + self._hinge_lines(units)
        lines += ["", *self.space.text(units)] if self.space else self._plane_text(units)
        lines += ["", SYSTEMS[units].rendered(self.inertial_sentence)] if self.inertial else []
        severity = shown(self.impact_severity, "J", units, digits=DIGITS)
        lines += ["", f"Impact severity m (v sin(theta))^2/2: {severity}"]
        if remarks := answers.remarks(self.answer):
            lines += ["", *remarks]
        return lines + paper_lines(self.paper_method, units)

    def _strike_lines(self, units: str) -> list[str]:
        """Return the lines on strikes, of light ones their number."""
        answer = self.answer
        lines = ["Strikes"] if answer.strikes else ["no strike"]
        errors = [strike["error"] for strike in self.space.strikes] if self.space else []
        heavy = answers.heavy(answer.strikes)
        for strike, error in zip_longest(answer.strikes, errors):
            if strike not in heavy:
                continue
            peak, impulse = (
                shown(value, unit, units, digits=DIGITS)
                for value, unit in ((strike.peak_force, "N"), (strike.impulse, "N s"))
            )
            least = "at least " if strike.cut else ""
            when = f"from {strike.start:.4f} s for {least}{strike.duration:.4f} s"
            lines.append(f"  {strike.corner:<16} {when}: peak {least}{peak}, impulse {least}{impulse}")
            if error:
                stated = (f"{name.partition('_')[0]} {percent_up(value)}" for name, value in error.items())
                lines.append(f"{'':<18} error at most: {', '.join(stated)}")
        if light := len(answer.strikes) - len(heavy):
            limit = 100 * answers.WEIGHT
            lines.append(f"  {light} lighter, below {limit:g} % of the largest impulse: --json")
        return lines

    def _hinge_lines(self, units: str) -> list[str]:
        """Return the lines on hinges."""
        lines = ["", "Hinges, horizontal force"] if self.trailers else []
        for number, hinge in enumerate(self.answer.hinges, 1):
            peak, mean = (
                shown(hinge[name], "N", units, digits=DIGITS) for name in ("peak_force", "mean_50ms")
            )
            angle = f"largest articulation angle {math.degrees(hinge['largest_angle']):.4g} deg"
            lines.append(f"  hinge {number}: peak force {peak}, 50 ms mean {mean}, {angle}")
        return lines

    def _plane_text(self, units: str) -> list[str]:
        """Return the lines on forces, end and tyres."""
        answer, lines = self.answer, ["", "Lateral force on the wall, peak"]
        lines += [value_line(label, answer.peaks[name], "N", units, DIGITS) for name, label in LABELS.items()]
        lines += ["", "At the end, of the first unit" if self.trailers else "At the end"]
        lines += [
            value_line(label, answer.end[name], unit, units, DIGITS) for name, (label, unit) in ENDS.items()
        ]
        if "tyre_work" in answer.history:
            lines += ["", "Tyres"]
            lines += [
                value_line(f"load of axle {number}", load, "N", units, DIGITS)
                for number, load in enumerate(self.loads, 1)
            ]
            lines.append(value_line("work", float(answer.history["tyre_work"][-1]), "J", units, DIGITS))
        return lines
