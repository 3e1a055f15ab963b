"""How the peak force of the tail-slap, or both strikes of a whole impact, spread when the inputs do.

Rows a to f of the paper's Tables 4 and 5 stand beside the second strike in the manner of ASME V&V 20. The comparison
error is E = S - D, simulated less measured; the validation uncertainty u_val = sqrt(u_num^2 + u_input^2 + u_D^2). What
is left of E beyond u_val is the model's. Nothing here is fitted to a row: all ranges were set before, and where a row's
own speed and angle are known it is these that are put in.
"""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from postprocess.units import measure
from solver import RectangularBody, corner_impulse, strike_force, tail_slap
from solver.impact import solve_impacts
from tailslap.campaign import sampling
from tailslap.campaign.sampling import Array, Band, Range
from tailslap.case.corner.case import CornerCase
from tailslap.case.impact.answers import COLUMNS, both_strikes, filtered, peaks_within
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.rigid import AFTER_SECOND, LONGEST, refusals
from tailslap.errors import InputError, Missing, Verbatim
from tailslap.paper.data import ROW_B_ANGLE, ROW_B_GIVEN, ROW_B_SPEED, TABLE_4, TABLE_5, ForceRow
from tailslap.progress import announced, progress_bar
from tailslap.scene.schema import Scene, Start
from tailslap.studies.study import Call

# Combinations by default.
CORNER_SAMPLES, IMPACT_SAMPLES = 100_000, 4_000

STAGE_ONE = ("impact.speed", "impact.angle", "impact.friction", "impact.restitution")
START = ("start.angle", "start.omega", "start.corner_speed")
BODY = ("vehicle.length", "vehicle.width", "vehicle.mass")

# Keys of the scene that the rigid vehicle's impact depends on, and what the solution calls them.
ARGUMENTS = {
    **dict(zip(BODY, ("length", "width", "mass"), strict=True)),
    "vehicle.centre_of_mass": "centre_of_mass",
    "impact.speed": "speed",
    "impact.angle": "angle",
    "contact.stiffness": "stiffness",
    "contact.initial_force": "initial_force",
    "contact.restitution": "restitution",
    "contact.friction": "friction",
}

# Combinations at a time: their intermediate values stay in the processor's cache, their histories small.
CORNER_BLOCK, IMPACT_BLOCK = 2048, 512

# Time between rows of the force histories [s]: peaks of a 50 ms mean are within 1e-4.
INTERVAL = 5e-4

CURVE_POINTS = 25

# The rows of Tables 4 and 5 are of this test level's single-unit truck.
LEVEL = "TL-4"

# What is known of the rows' impacts, SI.
KNOWN = {"b": {"impact.speed": ROW_B_SPEED, "impact.angle": ROW_B_ANGLE}}

# By the quantity of the second strike that stands beside a table: its words, the table.
TAKEN = {"mean_50ms": ("50 ms mean", TABLE_4), "cfc60": ("CFC 60", TABLE_5)}


@dataclass(frozen=True)
class Spread:
    """The finished study of a case.

    Attributes
    ----------
    inputs : dict of ndarray, shape ((inputs + 2) rows,)
        The combinations by key, as of `sampling.sampled`.
    tables : dict of ndarray, shape (inputs + 2, rows)
        What was computed of them, by name; NaN where the theory refuses one, or there is no such strike.
    sources : dict
        By name a row an input, as of `sampling.index_rows`; names without variance are missing.
    own : dict
        What the scene's own values give, by name [SI].
    refusal : str
        Why the theory refused the first combination, or "".
    curves : list of dict
        Of a whole impact, each input varied alone: its key, values, the scene's own, and columns.
    beside : list of dict
        Rows a to f of the paper's Tables 4 and 5; none for a scene of another test level.
    """

    case: Any
    ranges: tuple[Range, ...]
    inputs: Mapping[str, Array]
    tables: Mapping[str, Array]
    sources: Mapping[str, list[dict[str, Any]]]
    own: Mapping[str, float]
    seconds: float
    refusal: str = ""
    curves: tuple[dict[str, Any], ...] = ()
    beside: tuple[dict[str, Any], ...] = ()

    @property
    def rows(self) -> int:
        """Rows of each table."""
        return next(iter(self.tables.values())).shape[1]

    @property
    def computed(self) -> int:
        """Combinations in all, the mixtures for the indices included."""
        return next(iter(self.tables.values())).size

    @property
    def samples(self) -> dict[str, Array]:
        """The combinations of the distribution, inputs and what was computed, shape (2 rows,)."""
        both = {name: table[:2].ravel() for name, table in self.tables.items()}
        return {key: values[: 2 * self.rows] for key, values in self.inputs.items()} | both

    def band(self, name: str) -> Band:
        """How one of the tables spreads."""
        return sampling.band_of(self.tables[name])

    def sources_of(self, name: str) -> list[dict[str, Any]]:
        """Where the variance of a table comes from, the most first; nothing where it has none."""
        return sorted(self.sources.get(name, ()), key=lambda row: -row["total"])


def study_spread(call: Call, samples: int | None, ranges: tuple[str, ...], fixed: tuple[str, ...]) -> Spread:
    """The study as the command line asks for it."""
    case = call.plan
    if case.scene.contact is None:
        return corner_spread(case, corner_ranges(case, ranges, fixed), samples or CORNER_SAMPLES)
    demand_corners(case)
    return impact_spread(case, impact_ranges(case, ranges, fixed), samples or IMPACT_SAMPLES)


def corner_ranges(
    case: CornerCase, ranges: tuple[str, ...] = (), fixed: tuple[str, ...] = ()
) -> tuple[Range, ...]:
    """The ranges for a scene with a constrained corner, in the order of the scene. Raises InputError."""
    limits = sampling.default_limits(case.scene)
    return sampling.ranges_of(case, used_keys(case.scene), limits, ranges, fixed)


def used_keys(scene: Scene) -> tuple[str, ...]:
    """The keys that the peak force of this scene's tail-slap depends on."""
    start = {key for key in START if scene.start and getattr(scene.start, key[6:]) is not None}
    overridden = {"start.omega", "start.corner_speed"} <= start
    unused = set(STAGE_ONE) if overridden or not scene.impact else set()
    if scene.impact and "start.angle" not in start:
        unused.discard("impact.angle")
    if scene.impact and scene.corner.friction is None and not scene.corner.frictionless:
        unused.discard("impact.friction")
    if scene.corner.frictionless:
        unused.add("corner.friction")
    keys = (*BODY, *STAGE_ONE, *START, "corner.friction", "strike.duration")
    return tuple(key for key in keys if key not in unused)


def corner_spread(case: CornerCase, ranges: tuple[Range, ...], at_least: int) -> Spread:
    """Run the study. Raises InputError where the theory refuses (nearly) all combinations."""
    importlib.import_module("scipy.stats")  # takes longer than the study
    began = time.perf_counter()
    with progress_bar("combinations") as progress:
        inputs, tables = sampling.sampled(
            ranges, at_least, lambda given: {"peak_force": peak_forces(case.scene, given, progress)}
        )
    forces = tables["peak_force"]
    refusal = _first_refusal(case, inputs, forces.ravel())
    if np.count_nonzero(np.isfinite(forces).all(axis=0)) < sampling.MIN_ROWS:
        raise InputError(
            "--range", Verbatim("these ranges"), f"the theory refuses nearly all of them, like {refusal}"
        )
    band = sampling.band_of(forces)
    if not band.standard_deviation > 1e-12 * band.mean:
        raise InputError("--range", Verbatim("these ranges"), "the peak force is the same all over them")
    with announced("Resampling for the confidence intervals ..."):
        sources = {"peak_force": sampling.index_rows(ranges, forces)}
    own = {"peak_force": float(case.force.peak_force)}
    return Spread(case, ranges, inputs, tables, sources, own, time.perf_counter() - began, refusal)


def peak_forces(
    scene: Scene, inputs: Mapping[str, Array], progress: Callable[[float], None] = lambda fraction: None
) -> Array:
    """Peak force [N] of each combination, by Stages 1 to 3; NaN where the theory refuses it.

    inputs: by key of the scene, SI, all of one shape (n,); the other keys have the scene's values.
    """
    size, blocks = next(iter(inputs.values())).size, []
    for first in range(0, size, CORNER_BLOCK):
        progress(first / size)
        rows = slice(first, first + CORNER_BLOCK)
        blocks.append(_peak_forces(scene, {key: values[rows] for key, values in inputs.items()}))
    return np.concatenate(blocks)


def _peak_forces(scene: Any, inputs: Mapping[str, Array]) -> Array:
    """Of a table of scenes: one with columns in place of numbers, not validated."""
    for key, value in inputs.items():
        table, _, name = key.partition(".")
        changed = (getattr(scene, table) or Start()).model_copy(update={name: value})
        scene = scene.model_copy(update={table: changed})
    vehicle, corner, impact, start = scene.vehicle, scene.corner, scene.impact, scene.start or Start()
    body = RectangularBody(vehicle.length, vehicle.width, vehicle.mass)
    begin: list[Any] = [start.angle, start.omega, start.corner_speed]
    if impact is not None:
        given = (impact.speed, impact.angle, impact.friction, impact.restitution, impact.convention)
        stage_1 = corner_impulse(body, *given, invalid="nan")
        computed = (impact.angle, stage_1.omega, stage_1.corner_speed)
        begin = [own if value is None else value for value, own in zip(begin, computed, strict=True)]
    friction = 0.0 if corner.frictionless else corner.friction
    friction = impact.friction if friction is None else friction
    angle, omega, corner_speed = begin
    state = tail_slap(body, angle, omega, corner_speed, friction, corner.rigid_reaction, invalid="nan")
    speed = np.asarray(state.v_gy)
    known = np.isfinite(speed)
    force = strike_force(vehicle.mass, np.where(known, speed, 0.0), scene.strike.duration).peak_force
    return np.broadcast_to(np.where(known, force, np.nan), next(iter(inputs.values())).shape)


def _first_refusal(case: CornerCase, inputs: Mapping[str, Array], forces: Array) -> str:
    """Why the first combination that is refused is."""
    for number in np.flatnonzero(np.isnan(forces))[:1]:
        try:
            case.varied({key: float(values[number]) for key, values in inputs.items()})
        except InputError as error:
            return str(error)
    return ""


def demand_corners(case: ImpactCase) -> None:
    """Raise InputError unless the corners alone touch, and crush."""
    contact = case.scene.contact
    if contact is None or contact.stiffness is None:
        why = "`tailslap study uncertainty` varies the crush law: give it one"
        raise InputError("contact.stiffness", Missing, why)
    if contact.side_stiffness:
        allowed = "the impacts of `tailslap study uncertainty` are of the corners alone; leave it out"
        raise InputError("contact.side_stiffness", contact.side_stiffness, allowed)


def scene_values(case: ImpactCase) -> dict[str, float]:
    """The scene's own number of each key of `ARGUMENTS`."""
    own = {key: getattr(getattr(case.scene, key.split(".")[0]), key.split(".")[1]) for key in ARGUMENTS}
    own["contact.restitution"] = own["contact.restitution"] or 0.0
    return own | {"vehicle.centre_of_mass": case.vehicle.front_distance}


def impact_ranges(
    case: ImpactCase, ranges: tuple[str, ...] = (), fixed: tuple[str, ...] = ()
) -> tuple[Range, ...]:
    """The ranges for a whole impact: by default MASH's tolerances where they are known, the others assumed."""
    own, known = scene_values(case), sampling.default_limits(case.scene)
    stiffness, mass, length = (own[key] for key in ("contact.stiffness", "vehicle.mass", "vehicle.length"))
    mass_limits = sampling.about(mass, 0.05 * mass, "± 5 %, assumed")
    limits = {
        "contact.stiffness": sampling.about(stiffness, 0.5 * stiffness, "± 50 %, assumed"),
        "contact.restitution": (0.0, 0.4, sampling.ASSUMED),
        "contact.friction": (0.3, 0.6, sampling.ASSUMED),
        "vehicle.mass": known.get("vehicle.mass", mass_limits),
        "impact.speed": known["impact.speed"],
        "impact.angle": known["impact.angle"],
        "vehicle.centre_of_mass": (0.45 * length, 0.55 * length, "± 5 % of the length, assumed"),
    }
    found = sampling.ranges_of(case, tuple(ARGUMENTS), limits, ranges, fixed)
    for item in found:
        if item.key == "impact.angle" and not 0.0 < item.lower < item.upper < 0.5 * math.pi:
            raise InputError(item.key, f"{item.lower}:{item.upper}", "allowed is above 0 and below 90 deg")
    return tuple(replace(item, given=own[item.key]) for item in found)


def impact_spread(case: ImpactCase, ranges: tuple[Range, ...], at_least: int) -> Spread:
    """Run the study. Raises InputError where most impacts have no second strike."""
    with progress_bar(f"{case.scene.name}: impacts") as progress:
        for name in ("scipy.stats", "scipy.signal"):  # slow to import
            importlib.import_module(name)
        began = time.perf_counter()
        curves = input_curves(case)
        inputs, tables = sampling.sampled(ranges, at_least, lambda given: measured(case, given, progress))
        second = np.isfinite(tables["strike_2.impulse"]).all(axis=0)
        if np.count_nonzero(second) < sampling.MIN_ROWS:
            why = "hardly any of these impacts has a second strike; allowed are others"
            raise InputError("--range", Verbatim("these ranges"), why)
        sources = {}
        for name, table in tables.items():
            known = table[:2, np.isfinite(table).all(axis=0)]
            if known.std() > 1e-9 * abs(known.mean()):
                sources[name] = sampling.index_rows(ranges, table)
        found = Spread(case, ranges, inputs, tables, sources, both_strikes(case.answer), 0.0)
        beside = rows_beside(found)
    return replace(found, curves=curves, beside=beside, seconds=time.perf_counter() - began)


def measured(
    case: ImpactCase,
    inputs: Mapping[str, Array],
    progress: Callable[[float], None] = lambda fraction: None,
) -> dict[str, Array]:
    """The columns of `COLUMNS` [SI], shape (n,), of n impacts; NaN where there is no such strike.

    Parameters
    ----------
    case : ImpactCase
        Gives what is not among the inputs; its yaw inertia, where the scene gives one, in proportion to the mass.
    inputs : dict of ndarray, shape (n,)
        By key of `ARGUMENTS` [SI].
    progress : callable
        Called with the fraction that is done.

    Raises
    ------
    InputError
        Where the theory refuses one of them.
    """
    size = next(iter(inputs.values())).size
    restitution = inputs.get("contact.restitution", np.zeros(size))
    order = np.argsort(restitution, kind="stable")  # a block has like steps
    out = {name: np.empty(size) for name in COLUMNS}
    for first in range(0, size, IMPACT_BLOCK):
        progress(first / size)
        rows = order[first : first + IMPACT_BLOCK]
        with refusals(case.scene):
            block = _columns(case, {key: given[rows] for key, given in inputs.items()})
        for name, values in block.items():
            out[name][rows] = values
    return out


def _columns(case: ImpactCase, inputs: Mapping[str, Array]) -> dict[str, Array]:
    values: dict[str, Array | float] = {**scene_values(case), **inputs}
    if case.scene.vehicle.centre_of_mass is None and "vehicle.centre_of_mass" not in inputs:
        values["vehicle.centre_of_mass"] = 0.5 * np.asarray(values["vehicle.length"])
    given: dict[str, Any] = {name: values[key] for key, name in ARGUMENTS.items()}
    if (inertia := case.scene.vehicle.yaw_inertia) is not None:
        given["yaw_inertia"] = inertia / case.vehicle.mass * np.asarray(values["vehicle.mass"])
    found = solve_impacts(**given, after_second=AFTER_SECOND, longest=LONGEST, interval=INTERVAL)
    starts, ends = found.start, found.start + found.duration
    columns: dict[str, Array] = {}
    for k in (0, 1):
        known = np.isfinite(starts[k])
        columns[f"strike_{k + 1}.raw"] = np.where(known, found.peak_force[k], np.nan)
        columns[f"strike_{k + 1}.impulse"] = np.where(known, found.impulse[k], np.nan)
        columns[f"strike_{k + 1}.duration"] = found.duration[k]
        columns |= {f"strike_{k + 1}.{name}": np.empty(known.size) for name in ("mean_50ms", "cfc60")}
    for number, force in enumerate(found.mean_force.T):
        last = int(np.ceil((np.nanmax(ends[:, number]) + AFTER_SECOND) / INTERVAL))
        curves = filtered(force[:last], INTERVAL)
        for k in (0, 1):
            peaks = peaks_within(curves, INTERVAL, float(starts[k, number]), float(ends[k, number]))
            for name, value in peaks.items():
                columns[f"strike_{k + 1}.{name}"][number] = value
    return columns


def input_curves(case: ImpactCase) -> tuple[dict[str, Any], ...]:
    """Each input varied alone over a wide range, the others as in the scene."""
    own = scene_values(case)
    stiffness, angle = own["contact.stiffness"], own["impact.angle"]
    length, mass, speed = (own[key] for key in ("vehicle.length", "vehicle.mass", "impact.speed"))
    wide = {
        "contact.stiffness": (min(0.3e6, 0.5 * stiffness), max(5e6, 2.0 * stiffness)),
        "contact.restitution": (0.0, 0.6),
        "contact.friction": (0.1, 0.8),
        "vehicle.mass": (0.75 * mass, 1.25 * mass),
        "impact.speed": (0.75 * speed, 1.25 * speed),
        "impact.angle": (0.5 * angle, min(1.6 * angle, 0.5 * (angle + 0.5 * math.pi))),
        "vehicle.centre_of_mass": (0.4 * length, 0.6 * length),
    }
    curves = []
    for key, ends in wide.items():
        spaced = np.geomspace if key == "contact.stiffness" else np.linspace
        values = spaced(*ends, CURVE_POINTS)
        found = measured(case, {key: values})
        curves.append({"key": key, "values": values, "own": own[key], "columns": found})
    return tuple(curves)


def rows_beside(found: Spread) -> tuple[dict[str, Any], ...]:
    """All rows of Tables 4 and 5 beside the second strike; none for a scene of another test level."""
    impact = found.case.scene.impact
    if impact is None or impact.test_level != LEVEL:
        return ()
    cases = {row: _simulated(found, known) for row, known in {"": {}, **KNOWN}.items()}
    rows = []
    for name, (kind, table) in TAKEN.items():
        for printed in table:
            row = printed.row if printed.row in KNOWN else ""
            rows.append(beside(printed, kind, ROW_B_GIVEN if row else "", *cases[row][f"strike_2.{name}"]))
    return tuple(rows)


def _simulated(found: Spread, known: Mapping[str, float]) -> dict[str, tuple[float, float, Band]]:
    """By column S by the solution at a smaller step, u_num, how far the many impacts' solution is from it, and the
    band of S, with what is known of a row's impact."""
    case = found.case.varied(known) if known else found.case
    exact, samples = both_strikes(case.answer), found.samples
    many = measured(case, {"contact.stiffness": np.array([scene_values(case)["contact.stiffness"]])})
    if known:
        inputs = {item.key: samples[item.key] for item in found.ranges}
        inputs |= {key: np.full(2 * found.rows, value) for key, value in known.items()}
        samples = measured(found.case, inputs)
    return {
        name: (exact[name], abs(float(many[name][0]) - exact[name]), sampling.band_of(samples[name]))
        for name in COLUMNS
    }


def beside(
    printed: ForceRow, kind: str, known: str, simulated: float, u_num: float, band: Band
) -> dict[str, Any]:
    """A measured force D beside the simulated S [N]: E = S - D, and u_val without u_D, which nobody gives."""
    u_input, error = band.standard_deviation, simulated - printed.measured
    u_known = math.hypot(u_num, u_input)
    needed = math.sqrt(max(0.0, error**2 - u_known**2))
    within = abs(error) <= u_known
    return {
        **{name: getattr(printed, name) for name in ("row", "source")},
        "kind": kind,
        "measured": printed.measured,
        "projected": printed.projected,
        "known": known,
        "simulated": simulated,
        "u_num": u_num,
        "u_input": u_input,
        "error": error,
        "within": within,
        "u_d_needed": needed,
        "verdict": "within u_val" if within else f"beyond, unless u_D is {measure(needed, 'N', '.0f')}",
        "share_below": band.fraction_below(printed.measured),
        "u_d": None,
        "band": band.percentiles,
    }
