"""Stages 1 to 3 of the rigid body and their texts.

Stage 1 is the impulse at the front corner, Stage 2 the motion with the corner on the wall, Stage 3 the tail-slap.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

import solver
from fem.cache import cached
from fem.explicit import columns
from fem.plate.properties import RigidStart
from postprocess.comparison import quantities
from postprocess.report.page import Headline
from postprocess.units import force, measure, percent
from tailslap.case import case, case_of
from tailslap.case.force_band import ForceBand
from tailslap.case.plate_input import Decision
from tailslap.errors import InputError, Verbatim
from tailslap.scene import schema, vary
from tailslap.scene.read import read_scene, shipped_scenes
from tailslap.scene.units import value_line
from tailslap.scene.vehicle_tables import StartTable

if TYPE_CHECKING:
    from postprocess.figures.positions import Unit
    from postprocess.svg.chart import Chart

ROWS = 401
"""Number of instants of a history of the rigid motion."""

MEAN_WINDOW = 0.05
"""Window of the mean that is compared with design forces [s]."""

STAGE_3 = ("impulse", "duration", "peak_force")
LABELS = {
    "angle": ("angle", "rad"),
    "omega": ("angular velocity", "rad/s"),
    "corner_speed": ("corner speed", "m/s"),
    "impulse": ("impulse", "N s"),
    "t": ("time", "s"),
    "v_gx": ("v_GX", "m/s"),
    "v_gy": ("v_GY", "m/s"),
    "slide": ("slide", "m"),
    "duration": ("duration", "s"),
    "peak_force": ("peak force", "N"),
}
"""Labels and units of the stages' numbers."""

START = {"angle": "angle", "omega": "angular velocity", "corner_speed": "corner speed"}
CONVENTIONS = {"paper": "the paper's convention (1 - e)", "newton": "Newton's convention (1 + e)"}
"""Names of the start of Stage 2 and of the conventions of restitution."""


@dataclass(frozen=True)
class RigidStages(case.Case):
    """A scene with a constrained corner and its rigid body.

    The constructor solves Stages 1 to 3. The finite-element model is in `CornerCase`, since plans and runs use this
    class.
    """

    name = case.CORNER
    compared = quantities.TAIL_SLAP
    force_words = "Peak lateral force at the tail-slap"
    force_column = "peak_force"

    def __post_init__(self) -> None:
        """Solve the stages. Raises InputError where they have no solution."""
        if self.scene.contact is not None:
            allowed = (
                "this command or study requires a constrained corner; for a whole impact use run, rigid, check, sweep, "
                "modes, or study uncertainty, flexibility, cost, stability"
            )
            raise InputError("contact", "a table", allowed)
        _ = self.force

    @cached_property
    def body(self) -> solver.RectangularBody[float]:
        """The vehicle as a rectangle."""
        vehicle = self.scene.vehicle
        with _refusals(self.scene, "vehicle"):
            return solver.RectangularBody(vehicle.length, vehicle.width, vehicle.mass)

    @cached_property
    def stage1(self) -> solver.ImpulseResult[float] | None:
        """Result of Stage 1, None without [impact]."""
        impact = self.scene.impact
        if impact is None or impact.friction is None or impact.restitution is None:
            return None
        values = (impact.speed, impact.angle, impact.friction, impact.restitution)
        with _refusals(self.scene, "impact"):
            return solver.corner_impulse(self.body, *values, convention=impact.convention)

    @cached_property
    def start(self) -> RigidStart:
        """State at the start of Stage 2."""
        specified: dict[str, float | None] = self.scene.start.model_dump() if self.scene.start else {}
        state: dict[str, float] = {}
        if self.stage1 is not None and self.scene.impact is not None:
            state = {"angle": self.scene.impact.angle, "omega": self.stage1.omega}
            state["corner_speed"] = self.stage1.corner_speed
        return RigidStart(**state | {key: value for key, value in specified.items() if value is not None})

    @cached_property
    def motion(self) -> solver.PlaneMotion:
        """Exact solution of Stage 2."""
        return self.motion_of_mass(self.body.mass)

    @cached_property
    def force(self) -> solver.StrikeForce[float]:
        """Result of Stage 3."""
        speed, duration = self.motion.strike.v_gy, self.scene.strike.duration
        with _refusals(self.scene, "strike"):
            return solver.strike_force(self.scene.vehicle.mass, speed, duration)

    def peak_force(self, v_gy: float) -> float:
        """Return a lateral speed's peak force [N].

        v_gy: at the tail-slap [m/s].
        """
        return float(
            solver.strike_force(self.scene.vehicle.mass, v_gy, self.scene.strike.duration).peak_force
        )

    def mean_force(self, peak: float) -> float:
        """Return the 50 ms mean of a pulse with this peak [N]."""
        return solver.triangle_mean(peak, self.scene.strike.duration, MEAN_WINDOW)

    def many(self, inputs: Mapping[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
        """Return the peak force of n combinations of inputs [N].

        inputs: by key of the scene, shape (n,) [SI], which are not validated; other keys are those of the scene. The
        force is in column "peak_force", NaN where the theory has no solution.
        """
        scene: Any = self.scene
        for key, value in inputs.items():
            table, _, name = key.partition(".")
            changed = (getattr(scene, table) or StartTable()).model_copy(update={name: value})
            scene = scene.model_copy(update={table: changed})
        vehicle, impact, start = scene.vehicle, scene.impact, scene.start or StartTable()
        body = solver.RectangularBody(vehicle.length, vehicle.width, vehicle.mass)
        begin: tuple[Any, Any, Any] = (start.angle, start.omega, start.corner_speed)
        if impact is not None:
            values = (impact.speed, impact.angle, impact.friction, impact.restitution, impact.convention)
            stage_1 = solver.corner_impulse(body, *values, invalid="nan")
            computed = (impact.angle, stage_1.omega, stage_1.corner_speed)
            begin = tuple(new if value is None else value for value, new in zip(begin, computed, strict=True))
        state = solver.tail_slap(
            body, *begin, scene.corner_friction, scene.corner.rigid_reaction, invalid="nan"
        )
        speed = np.asarray(state.v_gy)
        valid = np.isfinite(speed)
        force = solver.strike_force(vehicle.mass, np.where(valid, speed, 0.0), scene.strike.duration)
        return {"peak_force": np.where(valid, force.peak_force, np.nan)}

    @property
    def duration(self) -> float:
        """Time to the tail-slap [s]."""
        return self.motion.strike.t

    @property
    def tail_slap(self) -> dict[str, float]:
        """State at the tail-slap by the names of `summary.json`, SI."""
        return {name: float(getattr(self.motion.strike, name)) for name in quantities.KEYS}

    def motion_of_mass(self, mass: float) -> solver.PlaneMotion:
        """Solve Stage 2 of a body of another mass [kg].

        Only forces and energies depend on it.
        """
        scene, start, body = self.scene, self.start, replace(self.body, mass=mass)
        values = (start.angle, start.omega, start.corner_speed, scene.corner_friction)
        with _refusals(scene, "start"):
            motion: solver.PlaneMotion = _solved_motion(body, *values, scene.corner.rigid_reaction)
        return motion

    def with_changes(self, changes: vary.Changes) -> Self:
        """Return the case with changes that do not affect the rigid motion.

        They are valid. The source remains that of the scene.
        """
        changed = copy(self)
        object.__setattr__(changed, "scene", vary.with_values(self.scene, changes))
        return changed

    def decided(self, decisions: Iterable[Decision]) -> Self:
        """Return the case with the program's decisions."""
        changes = {decision.key: decision.value for decision in decisions}
        return self.with_changes(changes) if changes else self

    def other_convention(self) -> tuple[str, Self] | None:
        """Return the other convention of restitution and its case.

        None where Stage 1 does not compute the start, or has no solution with it.
        """
        impact, start = self.scene.impact, self.scene.start
        if impact is None or (start and start.omega is not None):
            return None
        (convention,) = (name for name in solver.CONVENTIONS if name != impact.convention)
        try:
            return convention, replace(self, scene=vary.varied(self.scene, {"impact.convention": convention}))
        except InputError:
            return None

    def details(self) -> list[str]:
        """Return the specified start of Stage 2, friction and restitution."""
        scene, start = self.scene, self.source.tables.get("start", {})
        words = {"omega": "angular velocity"} if scene.starts_later else START
        parts = [f"{name} {self.quantity(f'start.{key}')}" for key, name in words.items() if key in start]
        if parts:
            parts[0] = f"start of Stage 2: {parts[0]}"
        law = "" if scene.corner.reaction in ("drag", "none") else f' ("{scene.corner.reaction}")'
        parts.append(f"friction {scene.corner_friction:g}{law}")
        if scene.impact and "omega" not in start:
            parts.append(
                f"restitution {scene.impact.restitution:g} by {CONVENTIONS[scene.impact.convention]}"
            )
        return parts

    def force_sentence(self, peak: float, reliable: bool = True, band: ForceBand = case.NO_BAND) -> str:
        """Return sentences on a peak force.

        peak: of the tail-slap [N], beside its 50 ms mean.
        """
        pulse = f"triangular pulse of {1e3 * self.scene.strike.duration:g} ms, assumed"
        name = self.force_words if reliable else f"{self.force_words}, not reliable"
        interval = f"{band.interval}; " if band.interval else ""
        mean = self.mean_force(peak)
        first = (
            f"{name}: {force(peak)} ({interval}{pulse}); 50 ms mean {force(mean)}{self.design_ratio(mean)}."
        )
        return f"{first}{self._whole_impact()}"

    def _whole_impact(self) -> str:
        """State the force of a shipped vehicle's whole impact, if any."""
        name = f"impact-{self.scene.name}"
        if name not in shipped_scenes() or self.changes:
            return ""
        whole: Any = case_of(*read_scene(name))
        _, where = whole.scene_force(whole.answer)
        return f" Whole impact of this vehicle, with crush and tyres: {where} (`tailslap rigid {name}`)."

    def headline(self, band: ForceBand = case.NO_BAND) -> Headline:
        """Return the peak force of the tail-slap with the set-up."""
        sentence = self.force_sentence(self.force.peak_force, band=band)
        certainty = f"Exact solution of the rigid-body equations.{self.other_force()}{self.pull()}"
        return Headline(f"Tail-slap force: {self.subject}", sentence, self.set_up, certainty, band.sentence)

    def pull(self) -> str:
        """Return the sentence on a wall that pulls, or ""."""
        reaction = self.rigid_history()["reaction_normal"]
        if not reaction.min() < 0.0:
            return ""
        ends = [measure(-float(reaction[row]), "N", ".3g") for row in (0, -1)]
        return (
            f" The constraint makes the wall pull the vehicle, first with {ends[0]}, at the end with {ends[1]}; a real "
            "wall cannot, see a scene with [contact]."
        )

    def other_force(self) -> str:
        """Return the peak force by the other convention as a sentence.

        Empty where Stage 1 does not compute the start.
        """
        alternative = self.other_convention()
        if alternative is None:
            return ""
        convention, peak = CONVENTIONS[alternative[0]], alternative[1].force.peak_force
        return f" With {convention} {force(peak)} ({percent(peak / self.force.peak_force - 1.0, 0)})."

    @property
    def unit(self) -> Unit:
        """The vehicle at the start of Stage 2 and at the tail-slap."""
        from postprocess.figures.positions import Unit

        body, at = self.body, self.motion.at(np.array([0.0, self.duration]))
        phi, radius = at.theta + body.corner_angle, body.corner_radius
        place = at.slide - radius * np.cos(phi), radius * np.sin(phi)
        return Unit(*place, at.theta, body.length, body.width, 0.5 * body.length)

    def drawing(self) -> Chart:
        """Draw the vehicle at first touch and at the tail-slap."""
        from postprocess.figures import positions

        strike = self.motion.strike
        slide, after = measure(strike.slide, "m", ".3g"), measure(strike.t, "s", ".3g")
        words = {"speed": f"v_P = {measure(self.start.corner_speed, 'm/s')}"}
        words |= self.drawing_words(self.start.angle)
        words |= {"second": f"tail-slap, after {after}"}
        caption = (
            f"Set-up from above, to scale: {self.subject}; corner P touches the wall and slides {slide} along it until "
            f"the side PE strikes the wall (tail-slap); G: centre of mass."
        )
        return positions.draw_set_up([self.unit], words, caption)

    def rigid_history(self) -> dict[str, NDArray[np.float64]]:
        """Return the rigid motion by column of `history.csv`, SI, shape (rows,)."""
        state = self.motion.at(np.linspace(0.0, self.duration, ROWS))
        return {name: getattr(state, name) for name in ("t", *columns.COLUMNS) if hasattr(state, name)}

    def rigid_numbers(self) -> dict[str, Any]:
        """Return the results by both conventions of restitution, SI."""
        alternative = self.other_convention()
        return {
            "scene": self.scene.name,
            "stage1": self.stage1 and _numbers(self.stage1, "omega", "corner_speed", "impulse"),
            "start": vars(self.start) | _numbers(self.start, "omega", "corner_speed"),
            "stage2": self.tail_slap,
            "stage3": _numbers(self.force, *STAGE_3),
            "other_convention": alternative
            and {"convention": alternative[0], **_numbers(alternative[1].start, "omega")}
            | {"stage3": _numbers(alternative[1].force, *STAGE_3)},
        }

    def rigid_text(self, units: str = "si") -> list[str]:
        """Return the results of Stages 1 to 3 as lines of text.

        units: "si", or "us" for ft, mph and kip.
        """
        stages = self.rigid_numbers()

        def rows(numbers: Mapping[str, float]) -> list[str]:
            labelled = [(*LABELS[name], value) for name, value in numbers.items()]
            return [value_line(label, value, unit, units) for label, unit, value in labelled]

        lines = ["US customary units; 1 kip = 1000 lbf", ""] if units == "us" else []
        if stages["stage1"]:
            lines += ["Stage 1, impulse at the front corner", *rows(stages["stage1"])]
        lines += ["Stage 2, from", *rows(stages["start"]), "to the tail-slap", *rows(stages["stage2"])]
        return [*lines, "Stage 3, tail-slap", *rows(stages["stage3"])]


@cached
def _solved_motion(body: solver.RectangularBody[float], *start: Any) -> solver.PlaneMotion:
    return solver.plane_motion(body, *start)


@contextmanager
def _refusals(scene: schema.Scene, table: str) -> Iterator[None]:
    """Convert errors of the theory into errors of keys of the scene.

    table: of the inputs of the theory.
    """
    try:
        yield
    except solver.RigidBodyError as error:
        key, allowed = _key(scene, table, error.key), f"{error.why}; allowed: {error.allowed}"
        if key == "impact.restitution" and scene.impact:  # the theory refuses an angular velocity of zero
            raise InputError(key, scene.impact.restitution, f"{error.why}; allowed: less than 1") from None
        value = str(error.value)
        if key.endswith(".angle"):
            value = f"{value} rad ({math.degrees(schema.value_at(scene, key)):.4g} deg)"
        raise InputError(key, Verbatim(value), allowed) from None


def _key(scene: schema.Scene, table: str, name: str) -> str:
    """Return the key of the scene behind an input of the theory."""
    if table != "start":
        return f"{table}.{name}"
    if name == "friction":
        return "corner.friction" if scene.corner.friction is not None else "impact.friction"
    if name == "reaction":
        return "corner.reaction"
    if scene.start and getattr(scene.start, name, None) is not None:
        return f"start.{name}"
    return "impact.restitution" if name == "omega" else f"impact.{'angle' if name == 'angle' else 'speed'}"


def _numbers(result: object, *names: str) -> dict[str, float]:
    return {name: float(getattr(result, name)) for name in names}
