"""Motion of a vehicle in space with its numbers and sentences."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from postprocess.report.page import Section
from postprocess.report.tables import Column, Table
from postprocess.signals import filters
from postprocess.units import INCH, SYSTEMS, measure, percent_up
from solver import space
from solver.space.strips import LONGEST_UPRIGHT
from tailslap import progress
from tailslap.case.impact.answers import ImpactAnswer, heavy, strike_numbers
from tailslap.case.impact.space import design, figures
from tailslap.case.impact.space.input import SpaceInput
from tailslap.case.report_parts import strikes_table

TITLE = "Vehicle in space"

LIMITS = (
    ("torsion of the frame", "the box rolls more than the axles, which lift one after the other", "+"),
    ("loose cargo", "displaces the centre of mass towards the wall", "+"),
    ("box that tears off", "the box rolls more, the chassis less", "±"),
    ("bump stops and play of the springs", "further roll of the body on its axles", "+"),
    ("deformable wall", "lowers the force, and the wall's top yields", "±"),
    ("steering and wheels damaged by the impact", "tyres no longer steer the vehicle", "±"),
    ("wall of finite thickness", "a vehicle on its top falls behind it", "+"),
)
"""Omitted parts of the model, their effects, and the sign of the change of roll."""

LIMIT_COLUMNS = (Column("0", "Omitted"), Column("1", "Effect"), Column("2", "Roll"))

SHORTEST_LIFT = 0.05
"""Shortest time off the ground that the text names [s]."""

SAMPLE = 5e-4
"""Time between rows of filtered forces [s]: above the requirement of CFC 180."""


@dataclass(frozen=True)
class SpaceAnswer:
    """Motion of a vehicle in space, and its lowest wall.

    Attributes
    ----------
    inputs : SpaceInput
        Of the motion.
    motion : SpaceMotion
        With its history.
    lowest_wall, lowest_wall_error : float
        Lowest wall above which the vehicle remains upright and its error [m], see `solver.space.lowest_wall`.
    """

    inputs: SpaceInput
    motion: space.SpaceMotion
    lowest_wall: float
    lowest_wall_error: float

    @property
    def outcome(self) -> str:
        """Outcome, undecided on a wall within the error of the lowest one."""
        is_near = abs(float(self.inputs.wall.height) - self.lowest_wall) <= self.lowest_wall_error
        return space.UNDECIDED if is_near else self.motion.outcome

    @property
    def heights(self) -> str:
        """Heights of the resultant in words."""
        *lower, last = sorted({round(height, 2) for height in self.motion.heights})
        return " or ".join((*(measure(h, "m", ".2f", named=False) for h in lower), measure(last, "m", ".2f")))

    @cached_property
    def answer(self) -> ImpactAnswer:
        """Motion with the columns of one in the plane besides, every `SAMPLE`.

        The steps are at most those of the motion.
        """
        step, points = self.motion.step, self.motion.points
        motion = space.solve_space(*self.inputs, interval=SAMPLE, step=step, points=points)
        h = motion.history
        ends = ("", *(f"_{unit}" for unit in range(2, 1 + len(self.inputs.vehicle.units))))
        for end in ends:
            h |= {f"theta{end}": -h[f"yaw{end}"], f"omega{end}": h[f"omega_z{end}"]}
        angles = [h[f"theta{end}"] for end in ends]
        h |= {f"articulation_{k}": angles[k] - angles[k - 1] for k in range(1, len(ends))}
        return ImpactAnswer(motion.strikes, h, len(ends))

    @cached_property
    def strikes(self) -> list[dict[str, Any]]:
        """Return strikes with stated errors of heavy ones, SI."""
        strikes = self.answer.strikes
        errors, weighty = self.motion.strike_errors(strikes), heavy(strikes)
        return [
            strike_numbers(strike) | {"error": error if strike in weighty else None}
            for strike, error in zip(strikes, errors, strict=True)
        ]

    @property
    def curves(self) -> dict[str, dict[str, np.ndarray]]:
        """Force on the wall by component and filter [N], shape (rows,)."""
        answer = self.answer
        vertical = filters.force_curves(answer.history["force_vertical"][1:], answer.interval)
        return {"lateral": answer.lateral, "longitudinal": answer.longitudinal, "vertical": vertical}

    @property
    def energy_error(self) -> float:
        """Largest error of the energy balance over the initial energy [-]."""
        h = self.motion.history
        energy = h["kinetic_energy"] + h["gravity_energy"] + h["spring_energy"] + h["tyre_energy"]
        works = h["wall_work"] + h["friction_work"] + h["tyre_work"] + h["damping_work"]
        return float(np.abs(energy - energy[0] - works).max() / h["kinetic_energy"][0])

    @property
    def lifted(self) -> list[dict[str, Any]]:
        """Intervals with wheels off the ground, in order of time.

        Each has axle, side, start and duration [s].
        """
        t, intervals = self.motion.history["t"], []
        for axle in range(1, len(self.inputs.vehicle.axles) + 1):
            for side in ("right", "left"):
                off = self.motion.history[f"load_{side}_{axle}"] <= 0.0
                edges = np.flatnonzero(np.diff(np.concatenate([[0], off, [0]]))).reshape(-1, 2)
                intervals += [
                    {"axle": axle, "side": side, "start": t[k], "duration": t[min(n, len(t) - 1)] - t[k]}
                    for k, n in edges.tolist()
                ]
        return sorted(intervals, key=lambda interval: float(interval["start"]))

    def numbers(self) -> dict[str, Any]:
        """Return the part `space` of results, SI.

        Forces are those on the wall, the vertical one downwards. Those beside the 50 ms mean of the lateral force are
        at the same instant.
        """
        result, history = self.motion.answers, self.motion.history
        peaks = {name: float(curve.max()) for name, curve in self.curves["lateral"].items()}
        works = ("wall_work", "friction_work", "tyre_work", "damping_work", "kinetic_energy")
        return {
            "outcome": self.outcome,
            "largest_roll": float(result.largest_roll),
            "roll_time": float(result.roll_time),
            "largest_pitch": float(result.largest_pitch),
            "pitch_time": float(result.pitch_time),
            "unit_rolls": result.unit_rolls.tolist(),
            "lowest_wall": self.lowest_wall,
            "lowest_wall_error": self.lowest_wall_error,
            "force": {
                **peaks,
                "mean_50ms": float(result.mean_50ms),
                "t": float(result.mean_time),
                "longitudinal": -float(result.longitudinal),
                "vertical": float(result.vertical),
                "height": float(result.height),
                "heights": list(self.motion.heights),
                "length": float(result.length),
            },
            **design.numbers(self.inputs.vehicle, self.inputs.wall, self.motion, self.outcome),
            "exit": {
                "t": float(result.last_contact),
                "speed": float(result.exit_speed),
                "direction": float(result.exit_direction),
                "yaw": float(result.exit_yaw),
            },
            "strikes": self.strikes,
            "end": float(result.end),
            "lifted": self.lifted,
            "energy": {name: float(history[name][-1]) for name in works},
            "step": self.motion.step,
            "step_error": self.motion.step_error,
            "strip_error": self.motion.strip_error,
            "error": self.motion.error,
        }

    @property
    def verdict(self) -> str:
        """Sentence on the outcome."""
        wall = f"a wall of {_height(float(self.inputs.wall.height))}"
        roll = measure(abs(float(self.motion.answers.largest_roll)), "rad", ".1f")
        return {
            "upright": f"The vehicle remains upright on {wall} with a roll of {roll}.",
            "on its side": f"The vehicle rolls on its side on {wall}.",
            "over the wall": f"The vehicle rolls over {wall}.",
            space.UNDECIDED: f"It is undecided whether the vehicle remains upright on {wall}: within the numerical "
            "error the outcome differs, or a slightly different wall is the lowest one.",
        }[self.outcome]

    @property
    def lowest(self) -> str:
        """Sentence on the lowest wall that keeps the vehicle upright."""
        centre = _height(max(float(unit.centre_height) for unit in self.inputs.vehicle.units))
        if math.isinf(self.lowest_wall_error):
            return f"It is undecided whether a wall as high as the centre of mass, {centre}, keeps the vehicle upright."
        if math.isnan(self.lowest_wall):
            return (
                f"A wall as high as the centre of mass, {centre}, does not keep the vehicle upright; lower ones may. A "
                "lowest wall is not stated."
            )
        error = f"{1e3 * self.lowest_wall_error:.0f} mm"
        height, is_above = _height(self.lowest_wall), float(self.inputs.wall.height) > self.lowest_wall
        exception = ""
        if self.outcome != space.UNDECIDED and is_above != (self.outcome == "upright"):
            exception = (
                " The wall of the scene is an exception: between the heights that are tried, or beyond them."
            )
        return (
            f"Lowest wall for these inputs: {height}, error at most {error}; over varied inputs: `tailslap study "
            f"tipping`.{exception}"
        )

    @property
    def accuracy(self) -> str:
        """Stated error of roll, force and height by its parts."""
        motion = self.motion
        what = (
            "force, height and moment"
            if self.outcome == space.UNDECIDED
            else "roll, force, height and moment"
        )
        step, strip = (percent_up(error) for error in (motion.step_error, motion.strip_error))
        other = (
            f", {percent_up(motion.other_error)} with other ones than halves" if motion.other_error else ""
        )
        return f"error of {what} at most {percent_up(motion.error)}: {step} by the step, {strip} by the points{other}"

    @property
    def sentences(self) -> tuple[str, ...]:
        """Sentences on angles, wheels, force and exit."""
        result = self.motion.answers
        roll, pitch = (
            measure(float(angle), "rad", ".1f") for angle in (result.largest_roll, result.largest_pitch)
        )
        lifts = [
            f"{lift['side']} of axle {lift['axle']} from {lift['start']:.2f} s for {lift['duration']:.2f} s"
            for lift in self.lifted
            if lift["duration"] >= SHORTEST_LIFT
        ]
        direction, yaw = (
            measure(float(angle), "rad", ".1f") for angle in (result.exit_direction, result.exit_yaw)
        )
        speed = measure(float(result.exit_speed), "m/s", ".1f")
        return (
            self.lowest,
            f"Largest roll {roll} at {result.roll_time:.2f} s, positive towards the wall; largest pitch {pitch} at "
            f"{result.pitch_time:.2f} s, positive nose down.",
            f"Wheels off the ground: {'; '.join(lifts) or 'none'}.",
            f"Last contact at {result.last_contact:.2f} s: speed {speed}, direction {direction} and heading {yaw} away "
            "from the wall.",
            f"Time step {self.motion.step:.1e} s, points of upright strips at most "
            f"{measure(1e3 * LONGEST_UPRIGHT / self.motion.points, 'mm', '.1f')} apart; {self.accuracy}.",
        )

    def text(self, units: str) -> list[str]:
        """Return lines for a terminal."""
        system = SYSTEMS[units]
        sentences = *self.sentences, *design.sentences(self.numbers())
        lines = [TITLE, *(f"  {system.rendered(sentence)}" for sentence in sentences)]
        for row in self.force_rows:
            parts = ", ".join(
                f"{name} {system.rendered(measure(row[name], 'N', '.0f'))}"
                for name in ("lateral", "longitudinal", "vertical")
            )
            lines.append(f"  {row['name']}: {parts}")
        return lines

    @property
    def force_rows(self) -> list[dict[str, Any]]:
        """Peaks of the components of the wall force by filter."""
        curves = self.curves
        return [
            {"name": label} | {name: float(curve[key].max()) for name, curve in curves.items()}
            for key, label in filters.LABELS.items()
        ]


def _height(height: float) -> str:
    """Return a height with inches."""
    return f"{measure(height, 'm', '.3f')} ({height / INCH:.1f} in)"


def solve(inputs: SpaceInput) -> SpaceAnswer:
    """Solve the motion of a vehicle.

    Raises RigidBodyError for steps that are too short.
    """
    motion = space.solve_space(*inputs, on_compile=progress.compiling)
    return SpaceAnswer(inputs, motion, *space.lowest_wall(*inputs, on_compile=progress.compiling))


def section(answer: SpaceAnswer) -> Section:
    """Return the section of a page."""
    charts = figures.charts(answer.inputs.vehicle, answer.inputs.wall, answer.motion, answer.lifted)
    return Section(
        TITLE,
        "",
        charts,
        [strikes_table({"in space": answer.strikes}), Table(LIMIT_COLUMNS, LIMITS)],
        answer.sentences,
        "wide",
    )
