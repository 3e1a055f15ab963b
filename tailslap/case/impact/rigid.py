"""Results of the rigid vehicle of a whole impact in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.report.page import Headline
from postprocess.signals.filters import LABELS
from postprocess.units import SYSTEMS, force, measure, percent_up
from tailslap.case.case import NO_BAND
from tailslap.case.force_band import ForceBand
from tailslap.case.impact import answers
from tailslap.case.impact.paper_method import DIGITS, paper_lines
from tailslap.case.impact.rigid_motion import RigidMotion
from tailslap.scene.units import shown, value_line

if TYPE_CHECKING:
    from postprocess.svg.chart import Chart

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

ENDS = {
    "t": ("time", "s"),
    "theta": ("angle", "rad"),
    "omega": ("angular velocity", "rad/s"),
    "v_gx": ("v_GX", "m/s"),
    "v_gy": ("v_GY", "m/s"),
}
"""Labels and units of the end."""


@dataclass(frozen=True)
class RigidImpact(RigidMotion):
    """Rigid vehicle of a scene with [contact], with its results in words."""

    @property
    def inertial_sentence(self) -> str:
        """Inertial estimate in words, empty of trains."""
        if self.inertial is None:
            return ""
        height = ""
        if "height" in self.inertial:
            height = f" at a height of {measure(self.inertial['height'], 'm', '.2f')}"
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
