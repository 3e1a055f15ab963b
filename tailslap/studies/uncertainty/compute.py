"""Spread of the peak force of the tail-slap, or of both strikes of a whole impact, when the inputs vary.

Rows a to f of the paper's Tables 4 and 5 stand beside the second strike in the manner of ASME V&V 20. The comparison
error is E = S - D, simulated less measured; the validation uncertainty u_val = sqrt(u_num^2 + u_input^2 + u_D^2). What
is left of E beyond u_val is the model's. Nothing here is fitted to a row: all ranges were set before, and where a row's
own speed and angle are known it is these that are put in.
"""

import importlib
import math
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from postprocess.units import measure
from tailslap import progress
from tailslap.campaign import sampling
from tailslap.campaign.sampling import Array, Band, Range
from tailslap.case import cost
from tailslap.case.case import Case
from tailslap.case.corner.case import CornerCase
from tailslap.case.impact import answers
from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError, Missing, Verbatim
from tailslap.replication import paper_values
from tailslap.scene.schema import Scene

# Combinations by default.
CORNER_SAMPLES, IMPACT_SAMPLES = 100_000, 4_000

STAGE_ONE = ("impact.speed", "impact.angle", "impact.friction", "impact.restitution")
START = ("start.angle", "start.omega", "start.corner_speed")
BODY = ("vehicle.length", "vehicle.width", "vehicle.mass")

# Combinations at a time: their intermediate values stay in the processor's cache, their histories small.
CORNER_BLOCK, IMPACT_BLOCK = 2048, 512

CURVE_POINTS = 25

# The default range of a hitch [m].
HITCH = 0.3

# The rows of Tables 4 and 5 are of this test level's single-unit truck.
LEVEL = "TL-4"

# What is known of the rows' impacts, SI.
KNOWN = {"b": {"impact.speed": paper_values.ROW_B_SPEED, "impact.angle": paper_values.ROW_B_ANGLE}}

# By the quantity of the second strike that stands beside a table: its words, the table.
TAKEN = {"mean_50ms": ("50 ms mean", paper_values.TABLE_4), "cfc60": ("CFC 60", paper_values.TABLE_5)}


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
        By name a row an input, as of `sampling.index_rows`, none where refused; names without variance are missing.
    refused_sources : dict
        By name why its indices are refused.
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
    refused_sources: Mapping[str, str]
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
    def refused(self) -> tuple[int, int]:
        """Number of combinations that the theory refuses, and of rows that have one."""
        refused = np.isnan(self.tables["peak_force"])
        return int(np.count_nonzero(refused)), int(np.count_nonzero(refused.any(axis=0)))

    @property
    def samples(self) -> dict[str, Array]:
        """The combinations of the distribution, inputs and what was computed, shape (2 rows,)."""
        both = {name: table[:2].ravel() for name, table in self.tables.items()}
        return {key: values[: 2 * self.rows] for key, values in self.inputs.items()} | both

    def band(self, name: str) -> Band:
        """Spread of one of the tables."""
        return sampling.band_of(self.tables[name])

    def sources_of(self, name: str) -> list[dict[str, Any]]:
        """Inputs that the variance of a table comes from, the most first; none without variance, or where refused."""
        return sorted(self.sources.get(name, ()), key=lambda row: -row["total"])


def compute(
    case: Any, place: Path, samples: int | None, ranges: tuple[str, ...], fixed: tuple[str, ...]
) -> Spread:
    """The study as the command line asks for it; it keeps no journal at its place."""
    if case.scene.contact is None:
        return spread(case, corner_ranges(case, ranges, fixed), samples or CORNER_SAMPLES)
    demand_corners(case)
    return spread(case, impact_ranges(case, ranges, fixed), samples or IMPACT_SAMPLES)


def spread(case: Case, ranges: tuple[Range, ...], at_least: int) -> Spread:
    """The study of at least so many combinations.

    Raises InputError where the theory refuses (nearly) all of them, hardly any has a second strike, or nothing varies.
    """
    impact = case.scene.contact is not None
    importlib.import_module("scipy.stats")  # takes longer than the study
    began = time.perf_counter()
    with progress.progress_bar(f"{case.scene.name}: impacts" if impact else "combinations") as show:
        curves = input_curves(case) if isinstance(case, ImpactCase) else ()
        inputs, tables = sampling.sampled(ranges, at_least, lambda given: solved(case, given, show))
    main = tables["strike_2.impulse" if impact else "peak_force"]
    refusal = "" if impact else _first_refusal(case, inputs, main.ravel())
    if np.count_nonzero(np.isfinite(main).all(axis=0)) < sampling.MIN_ROWS:
        few = "too few of these impacts have a second strike"
        why = few if impact else f"too few samples have a solution; first reason: {refusal}"
        raise InputError("--range", Verbatim("these ranges"), why)
    rated = {name: sampling.index_rows(ranges, table) for name, table in tables.items() if _varies(table)}
    if not rated:
        raise InputError(
            "--range", Verbatim("these ranges"), "the peak force is constant within these ranges"
        )
    sources = {name: rows for name, (rows, _) in rated.items()}
    refused = {name: why for name, (_, why) in rated.items() if why}
    found = Spread(case, ranges, inputs, tables, sources, refused, own_columns(case), 0.0, refusal, curves)
    beside = rows_beside(found) if impact else ()
    return replace(found, beside=beside, seconds=time.perf_counter() - began)


def _varies(table: Array) -> bool:
    known = table[:2, np.isfinite(table).all(axis=0)]
    return bool(known.std() > 1e-9 * abs(known.mean()))


def own_columns(case: Any) -> dict[str, float]:
    """The columns of `solved` that the scene's own values give [SI]."""
    if case.scene.contact is None:
        return {"peak_force": float(case.force.peak_force)}
    return answers.both_strikes(case.answer)


def solved(
    case: Any, inputs: Mapping[str, Array], show: Callable[[float], None] = lambda fraction: None
) -> dict[str, Array]:
    """Peak force of each combination, or both strikes of each impact, block after block.

    Parameters
    ----------
    case : CornerCase or ImpactCase
        Gives what is not among the inputs; its yaw inertia, where the scene gives one, in proportion to the mass.
    inputs : dict of ndarray, shape (n,)
        By key of the scene [SI].
    show : callable
        Called with the fraction that is done.

    Returns
    -------
    dict of ndarray, shape (n,)
        "peak_force" [N] or the columns of `COLUMNS` [SI]; NaN where the theory refuses a tail-slap, or there is no
        such strike.

    Raises
    ------
    InputError
        Where the theory refuses an impact.
    """
    size, out = next(iter(inputs.values())).size, dict[str, Array]()
    block = CORNER_BLOCK if case.scene.contact is None else IMPACT_BLOCK
    blocks = [slice(first, first + block) for first in range(0, size, block)]
    threads = ThreadPoolExecutor(cost.available_cores())  # compiled code runs beside other threads

    def of_block(rows: slice) -> Mapping[str, Array]:
        found: Mapping[str, Array] = case.many({key: given[rows] for key, given in inputs.items()})
        return found

    def of_blocks() -> Iterator[Mapping[str, Array]]:
        yield of_block(blocks[0])  # alone, for it may compile
        yield from threads.map(of_block, blocks[1:])

    try:
        for number, (rows, found) in enumerate(zip(blocks, of_blocks(), strict=True), 1):
            for name, values in found.items():
                out.setdefault(name, np.empty(size))[rows] = values
            show(number / len(blocks))
    finally:
        threads.shutdown(cancel_futures=True)
    return out


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


def _first_refusal(case: Case, inputs: Mapping[str, Array], forces: Array) -> str:
    """Reason why the theory refuses the first combination that it refuses."""
    for number in np.flatnonzero(np.isnan(forces))[:1]:
        try:
            case.varied({key: float(values[number]) for key, values in inputs.items()})
        except InputError as error:
            return str(error)
    return ""


def demand_corners(case: ImpactCase) -> None:
    """Raise InputError unless the corners alone touch, and crush."""
    contact = case.scene.needed_contact
    if contact.stiffness is None:
        why = "`tailslap study uncertainty` requires a crush law"
        raise InputError("contact.stiffness", Missing, why)
    if contact.side_stiffness:
        allowed = "`tailslap study uncertainty` models contact at the corners only; remove this key"
        raise InputError("contact.side_stiffness", contact.side_stiffness, allowed)


def impact_ranges(
    case: ImpactCase, ranges: tuple[str, ...] = (), fixed: tuple[str, ...] = ()
) -> tuple[Range, ...]:
    """The ranges for a whole impact: by default MASH's tolerances where they are known, the others assumed."""
    own, known = case.inputs, sampling.default_limits(case.scene)
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
    if case.scene.vehicle.centre_of_mass is not None:
        centre = own["vehicle.centre_of_mass"]
        limits["vehicle.centre_of_mass"] = sampling.about(
            centre, 0.05 * length, "± 5 % of the length, assumed"
        )
    for number, (ahead, unit) in enumerate(zip(case.scene.units, case.trailers, strict=False)):
        key, body = f"trailer.{number}.", unit.vehicle
        crush, centre = unit.contact.crush.stiffness, body.front_distance
        ends = max(0.0, unit.hitch - HITCH), min(ahead.length, unit.hitch + HITCH)
        limits |= {
            f"{key}stiffness": sampling.about(crush, 0.5 * crush, "± 50 %, assumed"),
            f"{key}centre_of_mass": sampling.about(
                centre, 0.05 * body.length, "± 5 % of the length, assumed"
            ),
            f"{key}yaw_inertia": sampling.about(body.inertia, 0.2 * body.inertia, "± 20 %, assumed"),
            f"{key}hitch": (*ends, f"± {HITCH:g} m, assumed"),
        }
    found = sampling.ranges_of(case, case.arguments, limits, ranges, fixed)
    for item in found:
        if item.key == "impact.angle" and not 0.0 < item.lower < item.upper < 0.5 * math.pi:
            raise InputError(
                item.key, f"{item.lower}:{item.upper}", "allowed are angles above 0 and below 90 deg"
            )
    return tuple(replace(item, given=own[item.key]) for item in found)


def input_curves(case: ImpactCase) -> tuple[dict[str, Any], ...]:
    """Each input varied alone over a wide range, the others as in the scene."""
    own = case.inputs
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
    for number, unit in enumerate(case.trailers):
        crush, inertia = unit.contact.crush.stiffness, unit.vehicle.inertia
        wide |= {
            f"trailer.{number}.stiffness": (min(0.3e6, 0.5 * crush), max(5e6, 2.0 * crush)),
            f"trailer.{number}.yaw_inertia": (0.6 * inertia, 1.3 * inertia),
        }
    curves = []
    for key, ends in wide.items():
        spaced = np.geomspace if key.endswith("stiffness") else np.linspace
        values = spaced(*ends, CURVE_POINTS)
        columns = solved(case, {key: values})
        curves.append({"key": key, "values": values, "own": own[key], "columns": columns})
    return tuple(curves)


def rows_beside(found: Spread) -> tuple[dict[str, Any], ...]:
    """All rows of Tables 4 and 5 beside the second strike; none for a scene of another test level."""
    if found.case.scene.impact.test_level != LEVEL:
        return ()
    simulated = {row: _simulated(found, known) for row, known in {"": {}, **KNOWN}.items()}
    return tuple(
        beside(row, kind, *simulated[row.row if row.row in KNOWN else ""][f"strike_2.{name}"])
        for name, (kind, table) in TAKEN.items()
        for row in table
    )


def _simulated(found: Spread, known: Mapping[str, float]) -> dict[str, tuple[float, float, Band]]:
    """S by the solution at a smaller step, u_num, its distance from that of many impacts, and the band of S, by column.

    known: what is known of a row's impact, by key of the scene.
    """
    case, samples = found.case.varied(known) if known else found.case, found.samples
    exact = own_columns(case)
    many = solved(case, {"contact.stiffness": np.array([case.inputs["contact.stiffness"]])})
    if known:
        inputs = {item.key: samples[item.key] for item in found.ranges}
        samples = solved(found.case, inputs | {key: np.full(2 * found.rows, x) for key, x in known.items()})
    off = {name: abs(float(many[name][0]) - exact[name]) for name in answers.COLUMNS}
    return {name: (exact[name], off[name], sampling.band_of(samples[name])) for name in answers.COLUMNS}


def beside(
    printed: paper_values.ForceRow, kind: str, simulated: float, u_num: float, band: Band
) -> dict[str, Any]:
    """A measured force D beside the simulated S [N]: E = S - D, and u_val without u_D, which nobody gives."""
    u_input, error = band.standard_deviation, simulated - printed.measured
    u_known = math.hypot(u_num, u_input)
    needed = math.sqrt(max(0.0, error**2 - u_known**2))
    within = abs(error) <= u_known
    verdict = "within u_val" if within else f"within u_val for u_D of at least {measure(needed, 'N', '.0f')}"
    known = paper_values.ROW_B_GIVEN if printed.row in KNOWN else ""
    row: dict[str, Any] = {"row": printed.row, "source": printed.source, "kind": kind}
    row |= {"measured": printed.measured, "projected": printed.projected, "known": known}
    row |= {"simulated": simulated, "u_num": u_num, "u_input": u_input, "error": error, "within": within}
    row |= {"u_d_needed": needed, "verdict": verdict, "share_below": band.fraction_below(printed.measured)}
    return row | {"u_d": None, "band": band.percentiles}
