"""Case: a scene, and all that the program does with it, whichever of its two kinds it is; its plan and outcome.

Checks: a kind is registered once with its name, judgement and advice; a check is its outcome for a run.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from postprocess.comparison.quantities import Compared
from postprocess.signals.design_forces import design_forces
from postprocess.units import SI, Units, force, measure, percent_up, shown
from tailslap.case import plate_input, resources
from tailslap.case.plate_input import Decision
from tailslap.errors import InputError
from tailslap.scene import write
from tailslap.scene.schema import Plate, Scene
from tailslap.scene.vary import Changes, Source, vary

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from postprocess.report.command_report import Report
    from postprocess.report.page import Headline
    from postprocess.svg.chart import Chart


LABEL = 13
"""Columns of a label of `tailslap check`."""

MOST_ELEMENTS = 20_000
"""Most elements of a mesh with which a tolerance is sought."""

CORNER, WHOLE_IMPACT = "a constrained corner", "a whole impact"
"""Names of the two kinds, for messages."""


@dataclass(frozen=True)
class FePlan:
    """Model of a run, and the scene that it is of.

    Attributes
    ----------
    case : Case
        Of the scene that is run.
    plate : Plate
        The scene's, with elements, and with the modulus that its first frequency asks for where it gives that.
    decisions : tuple of Decision
        What the program filled in, and why.
    model : PlateModel
        Mesh, masses, stiffness, parameters of the time loop.
    """

    case: Any
    plate: Plate
    decisions: tuple[Decision, ...]
    model: PlateModel

    @property
    def expected_steps(self) -> int:
        """Steps to the end of the rigid motion."""
        return math.ceil(self.case.duration / self.model.loop.time_step)

    @property
    def expected_seconds(self) -> float:
        """Time of the loop [s]."""
        plate = self.plate
        return resources.loop_seconds(self.case.scene, plate.element, plate.counts, self.expected_steps)

    @cached_property
    def first_frequency(self) -> float:
        """First elastic frequency of the free plate in its plane [Hz]: 2 ms for 147 nodes, 0.7 s for 20 000."""
        from fem.plate.free_modes import lowest_frequency

        return lowest_frequency(self.model.elastic)


@dataclass(frozen=True)
class Outcome(ABC):
    """A finished run: what was computed, compared and checked.

    Attributes
    ----------
    fe_plan : FePlan
        What was integrated.
    run : Run or ImpactRun
        Its histories, steps and times.
    difference : dict of str to float
        FE/rigid - 1 of the quantities that are compared; empty where there is nothing to compare.
    checks : tuple of Check
        In the order of the report.
    setup_s : float
        Time that model and compilation took [s].
    """

    fe_plan: Any
    run: Any
    difference: dict[str, float]
    checks: tuple[Check, ...]
    setup_s: float

    @property
    @abstractmethod
    def lateral_force(self) -> float:
        """That force [N]; NaN where there is none."""

    @property
    def passed(self) -> bool:
        """True where every check passed."""
        return all(check.passed for check in self.checks)

    def with_tolerance(self, error: float, tolerance: float) -> Self:
        """The outcome with a check of its error against the tolerance that was asked for."""

        along, across = self.fe_plan.plate.counts
        mesh = f"{along} x {across} elements"
        meaning = f"stated error of the run on {mesh}; limit: --tolerance"
        check = Check.at_most(
            "tolerance", error, tolerance, meaning, "a larger --tolerance, or --allow-large"
        )
        return replace(self, checks=(*self.checks, check))


@dataclass(frozen=True)
class Case(ABC):
    """A scene with its calculation. Making one solves the rigid body, and raises InputError where that has no answer.

    Attributes
    ----------
    scene : Scene
        As read, SI.
    source : Source
        Where it came from.
    """

    scene: Scene
    source: Source

    name: ClassVar[str]
    """Its kind, for messages."""

    compared: ClassVar[Compared]
    """Quantities of FE and rigid vehicle that pictures and pages of many runs show."""

    force_words: ClassVar[str]
    """Name of the force of the answer."""

    force_name: ClassVar[str]
    """Its short name, beside design forces."""

    force_column: ClassVar[str]
    """Its column in the table of a sweep, after the name of the model."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """Time that the motion lasts which a run integrates [s]."""

    def varied(self, changes: Changes) -> Self:
        """The case of the scene with these changes, noted in its source. Raises InputError."""
        return type(self)(*vary(self.source, changes))

    def given(self, key: str) -> str:
        """A quantity of the scene in its own unit."""
        return write.as_given(self.source, key)

    @property
    def subject(self) -> str:
        """The vehicle, its speed and angle, in the units of the scene."""
        keys = (
            ("start.corner_speed", "start.angle")
            if self.scene.starts_later
            else ("impact.speed", "impact.angle")
        )
        trailers = "".join(
            f" with a {self.given(f'trailer.{k}.mass')} trailer" for k in range(len(self.scene.trailer))
        )
        what = "tractor" if trailers else "vehicle"
        return f"{self.given('vehicle.mass')} {what}{trailers} at {', '.join(map(self.given, keys))}"

    @property
    def set_up(self) -> str:
        """Subject, dimensions and details in the units of the scene."""
        units = ["vehicle", *(f"trailer.{k}" for k in range(len(self.scene.trailer)))]
        sides = [
            f"{name} {' and '.join(dict.fromkeys(self.given(f'{unit}.{name}') for unit in units))}"
            for name in ("length", "width")
        ]
        return f"{self.scene.name}: {self.subject}; {', '.join([*sides, *self.details()])}."

    @abstractmethod
    def details(self) -> list[str]:
        """Parts of the set-up beside vehicle, speed and angle."""

    def drawing_words(self, angle: float) -> dict[str, str]:
        """Texts of the drawing of the set-up; angle: at first touch [rad]."""
        keys = {"length": "vehicle.length", "width": "vehicle.width"}
        keys |= {} if self.scene.starts_later else {"speed": "impact.speed"}
        words = {"first": "first touch", "angle": measure(angle, "rad")}
        return words | {name: self.given(key) for name, key in keys.items()}

    @abstractmethod
    def headline(self) -> Headline:
        """Result of the rigid vehicle, and the set-up."""

    @abstractmethod
    def drawing(self) -> Chart:
        """Drawing of the set-up, from above."""

    def design_ratio(self, peak: float) -> str:
        """Ratio of a force [N] to the first design force of the scene's test level; empty without a test level."""
        level = self.scene.impact and self.scene.impact.test_level
        if not level:
            return ""
        first = design_forces(level)[0]
        return f", {peak / first.force:.2g} times {first.name} {level} ({force(first.force)})"

    @abstractmethod
    def rigid_numbers(self) -> dict[str, Any]:
        """Numbers of `tailslap rigid`, SI."""

    @abstractmethod
    def rigid_text(self, units: str = "si") -> list[str]:
        """Lines of `tailslap rigid`, in SI or, with units "us", in ft, mph and kip."""

    @abstractmethod
    def rigid_history(self) -> dict[str, np.ndarray]:
        """Columns of the rigid motion by name, SI."""

    @abstractmethod
    def plan(self, more_damping: float = 1.0) -> Any:
        """Make the model of a run, and decide what the scene leaves open. Raises InputError for keys that make none."""

    def check_text(self, allow_large: bool = False) -> tuple[Headline, list[str]]:
        """Headline and labelled lines of `tailslap check`; of a large mesh an estimate. Raises InputError."""
        if not allow_large:
            resources.demand_affordable(self.scene, self.duration)
        if resources.is_large(self.scene):
            lines = resources.estimate_text(self.scene, self.duration)
        else:
            lines = self.pages().check_text(self, self.plan() if self.scene.plate else None)
        steps = next((line[LABEL:] for line in lines if line.startswith("steps ")), "")
        answer = f"The scene is valid; a run takes {steps}."
        rigid = self.headline()
        if not steps:
            answer = "The scene is valid for `tailslap rigid`; a run needs the table [plate]."
        return replace(rigid, answer=answer, certainty=f"Rigid-body method: {rigid.answer}"), lines

    def run(self, tolerance: float | None = None) -> Any:
        """Run the plate and check it. Writes nothing.

        With a tolerance, on meshes twice as fine each time until the error that the run states meets it, or the next
        mesh would be too large; a check says whether it does. Raises InputError for keys that make no model.
        """
        if tolerance is None:
            return self._run()
        if not self.least_tolerance <= tolerance < 1.0:
            allowed = f"allowed is from {self.least_tolerance:g} to below 1"
            raise InputError("--tolerance", tolerance, allowed)
        if not self.scene.verify.companion:
            allowed = "it requires the stated error of a run; remove verify.companion"
            raise InputError("--tolerance", tolerance, allowed)
        case = self
        while True:
            outcome = case._run()
            error, finer = case.stated_error(outcome), plate_input.refined(outcome.fe_plan.plate).counts
            if not error > tolerance or math.prod(finer) > MOST_ELEMENTS:
                break
            kept = {d.key: d.value for d in outcome.fe_plan.decisions if d.key.endswith("_length")}
            case = case.varied({**kept, "plate.elements": finer})
            if not resources.affordable(case.scene, case.duration):
                break
        return outcome.with_tolerance(error, tolerance)

    least_tolerance: ClassVar[float]
    """Least tolerance that a run can be held to."""

    @abstractmethod
    def _run(self) -> Any:
        """Run the plate on the scene's own mesh."""

    @staticmethod
    @abstractmethod
    def stated_error(outcome: Any) -> float:
        """The relative error that a run states of itself; NaN where it states none."""

    @staticmethod
    @abstractmethod
    def pages() -> ModuleType:
        """Import the texts of this kind: `check_text`, `summary`, `histories` and `filled_report`."""

    def summary(self, outcome: Any, pictures: bool) -> dict[str, Any]:
        """Numbers of a run, SI, as `summary.json` holds them; pictures: whether they were asked for."""
        return dict(self.pages().summary(outcome, pictures))

    def histories(self, outcome: Any) -> dict[str, dict[str, np.ndarray]]:
        """Histories of FE and rigid vehicle: columns by the names of their files."""
        return dict(self.pages().histories(outcome))

    def report(
        self,
        outcome: Any,
        folder: Path,
        pictures: bool,
        units: Units = SI,
        size: tuple[int, int] | None = None,
    ) -> Report:
        """Report of a run; its fields and pictures, in these units and of this size [pixels], go into the folder."""
        made: Report = self.pages().filled_report(outcome, folder, pictures, units, size)
        return made

    @staticmethod
    @abstractmethod
    def columns(scene: Scene) -> dict[str, type]:
        """Columns that the table of a sweep has whatever its rows, checks beside, and the type of their values.

        Raises InputError for a scene that cannot be swept.
        """

    @abstractmethod
    def row(self, outcome: Any | None) -> dict[str, Any]:
        """A run as columns of that table, SI; without an outcome, of a scene without [plate], the rigid vehicle alone.

        Raises InputError for a scene whose kind needs a plate.
        """


FINER = "refine plate.elements, or remove plate.elements and plate.element"
STEP = "a smaller time.safety_factor"
"""Advice of checks of both kinds of case."""


@dataclass(frozen=True)
class Check:
    """The outcome of a check: its value, its limit, whether it passed, what it guards against, what to change in a
    scene whose run fails it, separated by semicolons, and whether value and limit are shown in per cent."""

    name: str
    value: float
    limit: float
    passed: bool
    meaning: str = ""
    advice: str = ""
    in_percent: bool = False

    @classmethod
    def at_most(
        cls, name: str, value: float, limit: float, meaning: str, advice: str = "", in_percent: bool = False
    ) -> Check:
        """A check that passes where the value is a finite number and not above the limit."""
        passed = bool(math.isfinite(value) and value <= limit)
        return cls(name, float(value), limit, passed, meaning, advice, in_percent)


def as_read(check: Mapping[str, Any]) -> dict[str, Any]:
    """A check, as in a summary, with value and limit as text."""
    value, limit = check["value"], check["limit"]
    if not check.get("in_percent"):
        return {**check, "value": shown(value, ".3g"), "limit": shown(limit, ".3g")}
    return {
        **check,
        "value": percent_up(math.nan if value is None else value),
        "limit": f"{100.0 * limit:g} %",
    }


def failed_sentence(checks: Iterable[Check]) -> str:
    """Names, values and limits of the checks that failed, and their remedy; empty if none failed."""
    failed = [as_read(vars(check)) for check in checks if not check.passed]
    if not failed:
        return ""
    named = ", ".join(f"{check['name']} {check['value']} (limit {check['limit']})" for check in failed)
    return f"Failed: {named}. Remedy: {advice(check['advice'] for check in failed)}. "


def unreliable(sentence: str) -> str:
    """A sentence on a result, which it calls not reliable."""
    return sentence.replace(":", ", not reliable:", 1)


def failed_names(checks: Iterable[Check]) -> tuple[str, ...]:
    """Names of the checks that failed."""
    return tuple(check.name for check in checks if not check.passed)


def check_columns(checks: Iterable[Check]) -> dict[str, Any]:
    """Columns of a sweep's table on a run's checks: whether all passed, those that failed, and the values of all."""
    failed = failed_names(checks)
    values = {re.sub("[ -]", "_", f"check.{check.name}"): float(check.value) for check in checks}
    return {"status": "failed" if failed else "passed", "reason": ", ".join(failed), **values}


class Evaluation(NamedTuple):
    """Value, the limit that it may reach, what both are, and advice on their cause where that is known."""

    value: float
    limit: float
    meaning: str
    advice: str = ""


@dataclass(frozen=True)
class CheckKind:
    """A check.

    evaluate: value and limit by the evidence, of a whole impact its outcome; None where it does not apply. advice: what
    could be changed in a scene whose run fails it. shows_ringing: whether a run that rings fails it. of_reaction:
    whether a reaction that rings can fail it while the five quantities are right. in_percent: whether its value and
    limit are shown so.
    """

    name: str
    evaluate: Callable[[Any], Evaluation | None]
    advice: str
    shows_ringing: bool = False
    of_reaction: bool = False
    in_percent: bool = False

    def outcome(self, evidence: Any) -> Check | None:
        """The check of this run, or None where it does not apply."""
        found = self.evaluate(evidence)
        return found and Check.at_most(self.name, *found[:3], found.advice or self.advice, self.in_percent)


@np.errstate(all="ignore")  # a run that diverged is judged, not warned about
def evaluated(kinds: Iterable[CheckKind], evidence: Any) -> tuple[Check, ...]:
    """The checks that apply, in their order."""
    return tuple(check for kind in kinds if (check := kind.outcome(evidence)))


def advice(texts: Iterable[str]) -> str:
    """Join the advice of several checks, each thing once, in their order."""
    return "; ".join(dict.fromkeys(part for text in texts for part in text.split("; ") if part))


def energy_surplus(history: Mapping[str, np.ndarray], stored: Iterable[str]) -> np.ndarray:
    """Error of the energy balance [J] at each instant, shape (rows,); stored: columns of stored energy."""
    held = np.sum([history[name] for name in stored], axis=0)
    balance = held - history["friction_work"] - history["damping_work"]
    return np.asarray(balance - balance[0])


def time_step(given: Any) -> Evaluation:
    """The time step of a run over the stable one."""
    model, run = given.fe_plan.model, given.run
    ratio = model.loop.time_step / model.stable_time_step * run.highest_frequency / model.highest_frequency
    meaning = "time step over the stable one at the highest frequency of the deformed plate"
    return Evaluation(ratio, 1.0, meaning)
