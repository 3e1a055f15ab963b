"""A scene with its calculations.

`Case`, `FePlan` and `Outcome` are the parts that both kinds of case, `corner` and `impact`, have in common.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison.quantities import Compared
from postprocess.signals.design_forces import MASH, design_forces
from postprocess.units import force, measure
from tailslap.case import plate_input, resources
from tailslap.case.check import FINER, Check, Evaluation
from tailslap.case.force_band import ForceBand
from tailslap.case.plate_input import Decision
from tailslap.errors import InputError
from tailslap.scene import write
from tailslap.scene.model_tables import Plate
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, Source, changes_of, vary

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.run.corner import Run
    from fem.run.impact import ImpactRun
    from postprocess.report.page import Headline
    from postprocess.svg.chart import Chart

CaseT = TypeVar("CaseT", bound="Case")
OutcomeT = TypeVar("OutcomeT", bound="Outcome")

NO_BAND = ForceBand()
"""Record of a force without a band."""

MOST_ELEMENTS = 20_000
"""Largest number of elements of a mesh that is refined to meet a tolerance."""

CORNER, WHOLE_IMPACT = "a constrained corner", "a whole impact"
"""Names of the two kinds of case in messages."""


@dataclass(frozen=True)
class FePlan:
    """Finite-element model of a run and its scene.

    Attributes
    ----------
    case : Case
        Case of the scene that is run.
    plate : Plate
        The plate of the scene with its number of elements and Young's modulus.
    decisions : tuple of Decision
        Values that the program chose, with reasons.
    model : PlateModel
        Mesh, masses, stiffness and parameters of the time loop.
    """

    case: Case
    plate: Plate
    decisions: tuple[Decision, ...]
    model: PlateModel

    @property
    def finer(self) -> str:
        """Advice for a finer mesh, by the keys of the scene."""
        chosen = any(decision.key == "plate.elements" for decision in self.decisions)
        return "specify plate.elements, more than the automatic ones" if chosen else FINER

    @property
    def expected_steps(self) -> int:
        """Number of time steps to the end of the rigid motion."""
        return math.ceil(self.case.duration / self.model.parameters.time_step)

    @property
    def expected_seconds(self) -> float:
        """Expected time of the time loop [s]."""
        plate = self.plate
        return resources.loop_seconds(self.case.scene, plate.element, plate.counts, self.expected_steps)

    @cached_property
    def first_frequency(self) -> float:
        """First elastic frequency of the free plate in its plane [Hz].

        It takes 2 ms for 147 nodes and 0.7 s for 20 000.
        """
        from fem.plate.free_modes import lowest_frequency

        return lowest_frequency(self.model.elastic)


@dataclass(frozen=True)
class Outcome(ABC):
    """A finished run with its comparison and checks.

    Attributes
    ----------
    fe_plan : FePlan
        The model that was integrated.
    run : Run or ImpactRun
        Histories, number of steps and times.
    difference : dict of str to float
        FE/rigid - 1 of the compared quantities; empty without a result.
    checks : tuple of Check
        Checks in the order of the report.
    setup_s : float
        Time for model and compilation [s].
    """

    fe_plan: FePlan
    run: Run | ImpactRun
    difference: dict[str, float]
    checks: tuple[Check, ...]
    setup_s: float

    @property
    @abstractmethod
    def mean_force(self) -> float:
        """Largest 50 ms mean of the lateral force [N].

        It is compared with design forces, NaN without a result.
        """

    @property
    @abstractmethod
    def stated_error(self) -> float:
        """Largest relative error that the run states, NaN without any."""

    @property
    def passed(self) -> bool:
        """True if every check passed."""
        return all(check.passed for check in self.checks)

    def with_tolerance(self, error: float, tolerance: float) -> Self:
        """Return the outcome with a check of its error against a tolerance."""
        along, across = self.fe_plan.plate.counts
        meaning = f"stated error of the run on {along} x {across} elements; limit: --tolerance"
        remedy = "a larger --tolerance, or --allow-large"
        check = Check.at_most("tolerance", error, tolerance, meaning, remedy)
        return replace(self, checks=(*self.checks, check))


@dataclass(frozen=True)
class Case(ABC):
    """A scene with its calculation.

    The constructor solves the rigid body, and raises InputError where that has no solution.

    Attributes
    ----------
    scene : Scene
        The scene in SI.
    source : Source
        Its tables as written, its file and its changed keys.
    """

    scene: Scene
    source: Source

    name: ClassVar[str]
    """The kind of case in messages."""

    compared: ClassVar[Compared]
    """Quantities of FE model and rigid vehicle in pictures and pages of many runs."""

    force_words: ClassVar[str]
    """Name of the force of the answer."""

    force_column: ClassVar[str]
    """Column of that force in the table of a sweep, after the name of the model."""

    least_tolerance: ClassVar[float]
    """Least tolerance that a run can meet."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """Time that a run integrates [s]."""

    def varied(self, changes: Changes) -> Self:
        """Return the case of the changed scene. Raises InputError."""
        return type(self)(*vary(self.source, changes))

    @property
    def changes(self) -> tuple[str, ...]:
        """Texts KEY=VALUE of the keys changed since the file was read."""
        return tuple(changes_of(self.source))

    def quantity(self, key: str) -> str:
        """Return a quantity of the scene in the unit of its file."""
        return write.in_scene_unit(self.source, key)

    @property
    def subject(self) -> str:
        """Vehicle, speed and angle in the scene's units."""
        keys = (
            ("start.corner_speed", "start.angle")
            if self.scene.starts_later
            else ("impact.speed", "impact.angle")
        )
        trailers = "".join(
            f" with a {self.quantity(f'trailer.{k}.mass')} trailer" for k in range(len(self.scene.trailer))
        )
        vehicle = "tractor" if trailers else "vehicle"
        speed_and_angle = ", ".join(map(self.quantity, keys))
        return f"{self.quantity('vehicle.mass')} {vehicle}{trailers} at {speed_and_angle}"

    @property
    def set_up(self) -> str:
        """Subject, dimensions and details in the scene's units."""
        units = ["vehicle", *(f"trailer.{k}" for k in range(len(self.scene.trailer)))]
        sides = [
            f"{name} {' and '.join(dict.fromkeys(self.quantity(f'{unit}.{name}') for unit in units))}"
            for name in ("length", "width")
        ]
        return f"{self.scene.name}: {self.subject}; {', '.join([*sides, *self.details()])}."

    @abstractmethod
    def details(self) -> list[str]:
        """Return the set-up beyond vehicle, speed and angle, in parts."""

    def drawing_words(self, angle: float) -> dict[str, str]:
        """Return the texts of the set-up's drawing.

        angle: at first touch [rad].
        """
        keys = {"length": "vehicle.length", "width": "vehicle.width"}
        keys |= {} if self.scene.starts_later else {"speed": "impact.speed"}
        words = {"first": "first touch", "angle": measure(angle, "rad")}
        return words | {name: self.quantity(key) for name, key in keys.items()}

    @abstractmethod
    def headline(self, band: ForceBand = NO_BAND) -> Headline:
        """Return the result of the rigid vehicle with its set-up.

        band: of its force over varied inputs.
        """

    @abstractmethod
    def drawing(self) -> Chart:
        """Draw the set-up from above."""

    def design_ratio(self, mean: float, ends: Sequence[float] = ()) -> str:
        """Return a 50 ms mean as a multiple of a design force.

        mean [N]; ends: lower and upper end of its band [N]; the force is the first one of MASH. Empty for scenes
        without a test level, and for levels that have only loads of lighter vehicles.
        """
        level = self.scene.impact and self.scene.impact.test_level
        if level is None or level not in MASH:
            return ""
        first = design_forces(level)[0]
        value, *span = (f"{of / first.force:#.2g}".rstrip(".") for of in (mean, *ends))
        multiple = f"{value} ({' to '.join(span)})" if span else value
        return f", {multiple} times {first.name}, {level} ({force(first.force)})"

    @property
    def inertial(self) -> dict[str, Any] | None:
        """Inertial estimate of the largest 50 ms mean, None without one."""
        return None

    @abstractmethod
    def rigid_numbers(self) -> dict[str, Any]:
        """Return the numbers of `tailslap rigid`, SI."""

    @abstractmethod
    def rigid_text(self, units: str = "si") -> list[str]:
        """Return the lines of `tailslap rigid`.

        units: "si", or "us" for ft, mph and kip.
        """

    @abstractmethod
    def rigid_history(self) -> dict[str, NDArray[np.float64]]:
        """Return the rigid motion as columns by name, SI, shape (rows,)."""

    @abstractmethod
    def plan(self, more_damping: float = 1.0) -> FePlan:
        """Decide open keys, and make the model of a run. Raises InputError.

        more_damping: factor on the damping that the program chooses [-].
        """

    @abstractmethod
    def check_lines(self, fe_plan: Any | None) -> dict[str, list[str]]:
        """Return the texts of `tailslap check` by label.

        fe_plan: None for a scene without [plate].
        """

    def check_text(self, allow_large: bool = False) -> tuple[Headline, dict[str, list[str]]]:
        """Return the headline of `tailslap check` and its texts by label.

        A mesh that is too large to be made is estimated. Raises InputError.
        """
        if not allow_large:
            resources.demand_affordable(self.scene, self.duration)
        if resources.is_large(self.scene):
            lines = resources.estimate_lines(self.scene, self.duration)
        else:
            lines = self.check_lines(self.plan() if self.scene.plate else None)
        rigid = self.headline()
        answer = "The scene is valid for `tailslap rigid`; a run needs the table [plate]."
        if self.scene.plate:
            answer = f"The scene is valid; a run takes {lines['steps'][0]}."
        return replace(rigid, answer=answer, certainty=f"Rigid-body method: {rigid.answer}"), lines

    @abstractmethod
    def run(self, tolerance: float | None = None) -> Outcome:
        """Run the plate and check it, see `within_tolerance`. Raises InputError."""

    @abstractmethod
    def report(self, outcome: Any, band: ForceBand = NO_BAND) -> Any:
        """Return the report of a run, a `FeReport`.

        band: of the force over varied inputs.
        """

    @staticmethod
    @abstractmethod
    def columns(scene: Scene) -> dict[str, type]:
        """Return the columns of a sweep and their types, without checks.

        Raises InputError for a scene that cannot be swept.
        """

    @abstractmethod
    def row(self, outcome: Any | None) -> dict[str, Any]:
        """Return a run as a sweep's row, SI.

        Without an outcome the rigid vehicle alone. Raises InputError for a scene whose kind of case needs a plate.
        """


def within_tolerance(case: CaseT, run: Callable[[CaseT], OutcomeT], tolerance: float | None) -> OutcomeT:
    """Run a case on finer meshes until its error meets a tolerance.

    Each mesh has twice as many elements along both sides. The last one meets the tolerance, or the next would be too
    large; a check states which. Without a tolerance the case is run once. case: of the first mesh; run: returns the
    outcome of a case; tolerance: largest relative error [-]. Raises InputError for a tolerance that cannot be judged,
    and keys that make no model.
    """
    if tolerance is None:
        return run(case)
    if not case.least_tolerance <= tolerance < 1.0:
        allowed = f"allowed is from {case.least_tolerance:g} to below 1"
        raise InputError("--tolerance", tolerance, allowed)
    if not case.scene.verify.companion:
        allowed = "it requires the stated error of a run; remove verify.companion"
        raise InputError("--tolerance", tolerance, allowed)
    while True:
        outcome = run(case)
        error, finer = outcome.stated_error, plate_input.refined(outcome.fe_plan.plate).counts
        if not error > tolerance or math.prod(finer) > MOST_ELEMENTS:
            break
        chosen = {
            d.key: d.value for d in outcome.fe_plan.decisions if d.key.endswith(("_length", "plate.element"))
        }
        case = case.varied({**chosen, "plate.elements": finer})
        if not resources.affordable(case.scene, case.duration):
            break
    return outcome.with_tolerance(error, tolerance)


def time_step(outcome: Outcome) -> Evaluation:
    """Compare the time step of a run with the stable one."""
    model, run = outcome.fe_plan.model, outcome.run
    step = model.parameters.time_step
    ratio = step / model.stable_time_step * run.highest_frequency / model.highest_frequency
    meaning = "time step over the stable one at the highest frequency of the deformed plate"
    return Evaluation(ratio, 1.0, meaning)
