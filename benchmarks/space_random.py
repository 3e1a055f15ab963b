"""Outcomes, errors and time of random trucks in space.

    .venv/bin/python benchmarks/space_random.py [--runs 200] [--near 60] [--seed 1] [--keep FILE]

Single-unit trucks with two axles and four strips: front corner, rear wheels, lower edge and rear corner of the box.
Springs, spacing, heights, roll inertia, plateaus, friction and tyres are within the ranges that docs/tipping.md names;
restitution is 0 to 0.5. Half of the trucks crush without a plateau, half slide on tyres without side force, the walls
are 0.5 to 1.2 m high with one of the four named profiles or a random line. Further trucks strike a wall within 2 mm of
the lowest wall that keeps them upright. Strips are cut in 1 to 8 pieces whose stiffness differs by 1e-9: they are not
joined, and have points of their own.

Each motion is computed with step and points that the program chooses. The reference has at most 1/32 of the first step
and 1/8 of the chosen one, whole strips, and at least 8 times the points of many motions. The true error of a quantity
is its distance from the reference, over its size or the least size of `accuracy.COMPARED`; that of the height the
distance from the nearest of the stated heights. The outcome is that of the report, undecided within the error of
the lowest wall; the largest roll is judged where it is decided.

--keep    records of the runs, a line each; those that are there are not made again
"""

from __future__ import annotations

import math
import time
from collections import Counter
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import command_line
import numpy as np
from command_line import add_record, on_all_cores, read_records, row

from machine_code.compiled import ignore_compiling
from solver.space import (
    PROFILES,
    UNDECIDED,
    SpaceAxle,
    SpaceMotion,
    SpaceStrip,
    SpaceUnit,
    SpaceVehicle,
    SpaceWall,
    lowest_wall,
    solve_space,
)
from solver.space.accuracy import COMPARED, TOLERANCE
from solver.space.motion import INTERVAL, PHASE
from solver.space.solve import OUTCOMES, SCAN, highest_centres, searched_walls, steps_of
from solver.space.vehicle import fleet_of

Record = dict[str, Any]
Arguments = tuple[SpaceVehicle, SpaceWall, float, float]
SPREAD = 0.7, 1.3
"""Range of crush stiffness and of the plateaus of wheels and box, over those of the shipped truck."""
NEAR, CUTS, UNEQUAL = 2e-3, 8, 1e-9
"""Largest distance of a wall near the boundary [m], most pieces of a strip, and their difference in stiffness."""
FIRST_STEP, CHOSEN_STEP, POINTS, MOST_POINTS, WALLS = 32, 8, 8, 16, (4, 8)
"""Parts of the first and the chosen step in a reference, its least and most points over those of many motions, and
steps and points of its lowest wall."""
BATCH = 40
"""Motions after which records are kept."""


def drawn(seed: int, number: int) -> Arguments:
    """Draw a truck, a wall, a speed and an angle."""
    random = np.random.default_rng((seed, number))
    size = random.uniform(7.0, 11.0), random.uniform(2.3, 2.6), random.uniform(6e3, 14e3)
    length, width, mass = size
    yaw = mass * (length**2 + width**2) / 12.0
    unit = SpaceUnit(
        length, width, mass, random.uniform(0.45, 0.6) * length, random.uniform(1.2, 1.5),
        mass * random.uniform(0.9, 1.4) ** 2, yaw * random.uniform(0.9, 1.1), yaw,
    )  # fmt: skip
    axles = axles_of(random, length, mass, grip=number % 4 < 2)
    strips = strips_of(random, unit, axles[1].position, crushes=number % 2 == 0)
    wall = SpaceWall(random.uniform(0.5, 1.2), profile_of(random, number), random.uniform(0.2, 0.5))
    return (
        SpaceVehicle((unit,), axles, strips),
        wall,
        random.uniform(12.0, 28.0),
        math.radians(random.uniform(8, 22)),
    )


def axles_of(
    random: np.random.Generator, length: float, mass: float, grip: bool
) -> tuple[SpaceAxle, SpaceAxle]:
    """Draw front and rear axle, with or without side force."""
    track, spacing = random.uniform(1.75, 2.0), random.uniform(0.9, 1.1)
    front, rear = random.uniform(0.1, 0.15) * length, random.uniform(0.7, 0.78) * length
    springs = np.sort(random.uniform(0.15e6, 0.6e6, 2))
    common: dict[str, Any] = {
        "track": track, "radius": 0.5, "spacing": spacing, "damping_ratio": random.uniform(0.05, 0.3),
        "roll_centre": random.uniform(0.5, 0.7), "friction": random.uniform(0.5, 0.8) if grip else 0.0,
    }  # fmt: skip
    return (
        SpaceAxle(
            front, mass=0.04 * mass, spring=float(springs[0]), tyre=random.uniform(0.8e6, 1.2e6), **common
        ),
        SpaceAxle(
            rear, mass=0.07 * mass, spring=float(springs[1]), tyre=random.uniform(1.5e6, 2.2e6), **common
        ),
    )


def strips_of(
    random: np.random.Generator, unit: SpaceUnit, rear: Any, crushes: bool
) -> tuple[SpaceStrip, ...]:
    """Draw the strips, with or without a plateau.

    The front corner has 200 to 500 kN, other strips in proportion.
    """
    stiffness, plateau, bed = (
        random.uniform(*SPREAD, 4),
        random.uniform(200e3, 500e3),
        random.uniform(1.1, 1.3),
    )
    length, top = float(unit.length), min(2.6, 1.99 * float(unit.centre_height))
    factors_of_plateau, restitution = random.uniform(*SPREAD, 3), random.uniform(0.0, 0.5)
    places = (
        (0.0, 0.0, 0.45, 0.9, 4e6, plateau / 0.45, -1),
        (rear, rear, 0.05, 1.0, 2.1e6, plateau * factors_of_plateau[0] / 0.95, 1),
        (0.26 * length, length, bed, bed, 1e6, plateau * factors_of_plateau[1] / 8.0, -1),
        (length, length, bed, top, 1.5e6, plateau * factors_of_plateau[2] / 1.6, -1),
    )
    return tuple(
        SpaceStrip(
            (start, end), (low, high), slope * factor, plateau=most if crushes else math.inf,
            restitution=restitution, axle=axle,
        )
        for (start, end, low, high, slope, most, axle), factor in zip(places, stiffness, strict=True)
    )  # fmt: skip


def profile_of(random: np.random.Generator, number: int) -> Any:
    """Draw a named profile, or a line of two to four parts."""
    kind = int(random.integers(len(PROFILES) + 1))
    if kind < len(PROFILES):
        return tuple(PROFILES)[kind]
    parts = int(random.integers(2, 5))
    heights = np.cumsum(random.uniform(0.1, 0.4, parts))
    places = -np.cumsum(heights / parts * random.uniform(0.0, 0.6, parts))
    return [[0.0, 0.0], *([float(y), float(z)] for y, z in zip(places, heights, strict=True))]


def cut(vehicle: SpaceVehicle, pieces: int) -> SpaceVehicle:
    """Cut each strip in pieces of almost equal stiffness."""
    strips = []
    for strip in vehicle.strips:
        along, up = (np.linspace(*ends, pieces + 1).tolist() for ends in (strip.at, strip.height))
        for k in range(pieces):
            law: dict[str, Any] = {"at": along[k : k + 2], "height": up[k : k + 2]}
            law = {name: tuple(ends) for name, ends in law.items()}
            law["stiffness"] = strip.stiffness * (1.0 + UNEQUAL * (k % 2))
            strips.append(replace(strip, **law))
    return replace(vehicle, strips=tuple(strips))


def values(motion: SpaceMotion) -> dict[str, float]:
    """Return the quantities by which the program judges a motion."""
    rolls = {"largest_roll": abs(float(motion.answers.largest_roll))}
    return {name: float(getattr(motion.answers, name)) for name in COMPARED} | rolls


def solved(seed: int, runs: int, number: int) -> Record:
    """Return the motion of the program, and true errors of its quantities."""
    vehicle, wall, *approach = drawn(seed, number)
    random, pieces = np.random.default_rng((seed, number, 1)), 1 + number % CUTS
    fleet = fleet_of(vehicle, wall, *approach)
    boundary = float(searched_walls(fleet, SCAN, *WALLS, ignore_compiling)[0, 0])
    boundary = boundary if boundary <= highest_centres(fleet)[0] else math.nan
    if number >= runs:
        if math.isnan(boundary):
            return {"number": number, "seed": seed, "skipped": True}
        wall = replace(wall, height=boundary + random.uniform(-NEAR, NEAR))
    start = time.process_time()
    motion = solve_space(cut(vehicle, pieces), wall, *approach)
    lowest, lowest_error = lowest_wall(cut(vehicle, pieces), wall, *approach)
    spent = time.process_time() - start
    first = INTERVAL / int(steps_of(fleet, INTERVAL, PHASE, None)[0])
    step = min(motion.step / CHOSEN_STEP, first / FIRST_STEP)
    reference = solve_space(
        vehicle, wall, *approach, step=step, points=min(max(2 * motion.points, POINTS), MOST_POINTS)
    )
    computed, true = values(motion), values(reference)
    errors = {
        name: abs(computed[name] - true[name]) / max(abs(true[name]), least)
        for name, least in COMPARED.items()
    }
    outcome = UNDECIDED if abs(float(wall.height) - lowest) <= lowest_error else motion.outcome
    height = true["height"]
    errors["height"] = min(abs(resultant - height) for resultant in motion.heights) / max(
        height, COMPARED["height"]
    )
    return {
        "number": number, "seed": seed, "seconds": spent, "stated": motion.error, "step": motion.step,
        "points": motion.points, "parts": [motion.step_error, motion.strip_error, motion.other_error],
        "outcome": outcome, "reference": OUTCOMES[int(reference.answers.outcome)],
        "raw": OUTCOMES[int(motion.answers.outcome)], "heights": motion.heights, "values": computed,
        "references": true, "true": errors, "wall": wall.height, "lowest": lowest, "lowest_error": lowest_error,
        "boundary": boundary,
    }  # fmt: skip


def made(file: Path | None, seed: int, runs: int, near: int) -> list[Record]:
    """Return the records of all runs, read or computed."""
    records = {record["number"]: record for record in read_records(file) if record["seed"] == seed}
    number = 0
    while sum("skipped" not in record for record in records.values()) < runs + near or number < runs:
        missing = [k for k in range(number, number + BATCH) if k not in records]
        for record in on_all_cores(partial(solved, seed, runs), missing):
            records[record["number"]] = record
            add_record(file, record)
        number += BATCH
    used = [record for _, record in sorted(records.items()) if "skipped" not in record]
    return used[: runs + near]


def kind(record: Record) -> str:
    """Name the crush, tyres and profile of a truck."""
    number = record["number"]
    _, wall, _, _ = drawn(record["seed"], number)
    profile = wall.profile if isinstance(wall.profile, str) else "line"
    crush, grip = "plateau" if number % 2 == 0 else "no plateau", "tyres" if number % 4 < 2 else "no tyres"
    return f"{crush}, {grip}, {profile}"


def tell(title: str, records: list[Record]) -> None:
    """Print outcomes, and true over stated errors."""
    row(title, "", ", ".join(f"{n} {name}" for name, n in Counter(r["outcome"] for r in records).items()))
    wrong = [r for r in records if r["outcome"] not in (UNDECIDED, r["reference"])]
    row("decided outcomes that are wrong", "0", f"{len(wrong)}")
    for record in wrong:
        print(f"    {record['number']}: {record['outcome']}, reference {record['reference']}; {kind(record)}")
    unsettled = [record for record in records if record["stated"] > TOLERANCE]
    row("stated error above the tolerance of 1e-3", "", f"{len(unsettled)}")
    decided = [record for record in records if record["outcome"] == record["reference"]]
    ratios = {
        name: [ratio_of(record, name) for record in (decided if name == "largest_roll" else records)]
        for name in COMPARED
    }
    ratios["lowest wall"] = [lowest_ratio(record) for record in records]
    for name, of in ((name, of) for name, of in ratios.items() if of):
        quantiles = ", ".join(f"{value:.2g}" for value in np.quantile(of, (0.5, 0.9, 0.99, 1.0)))
        row(
            f"{name}: true over stated error at most 1",
            "99 %",
            f"{100.0 * np.mean(np.array(of) <= 1.0):.1f} %",
        )
        row("    quantiles of 50, 90, 99, 100 %", "", quantiles)
    for record in records:
        beyond = {name: ratio_of(record, name) for name in COMPARED}
        if record["outcome"] == UNDECIDED:
            del beyond["largest_roll"]
        beyond |= {"lowest wall": lowest_ratio(record)}
        for name in (name for name, ratio in beyond.items() if ratio > 1.0):
            true = record["true"].get(name, abs(record["lowest"] - record["boundary"]))
            stated = record["lowest_error"] if name == "lowest wall" else record["stated"]
            print(f"    {record['number']} {name}: {true:.1e}, stated {stated:.1e}; {kind(record)}")
    stated = [record["stated"] for record in records]
    row(
        "stated error: median, 90 %, most",
        "",
        ", ".join(f"{v:.1e}" for v in np.quantile(stated, (0.5, 0.9, 1.0))),
    )
    stated = [record["lowest_error"] for record in records if math.isfinite(record["lowest_error"])]
    row(
        "stated error of the lowest wall [m]: the same",
        "",
        ", ".join(f"{v:.1e}" for v in np.quantile(stated, (0.5, 0.9, 1.0))),
    )
    row(
        "processor time of one with its lowest wall, mean",
        "",
        f"{1e3 * np.mean([r['seconds'] for r in records]):.0f} ms",
    )


def ratio_of(record: Record, name: str) -> float:
    """Return true over stated error of a quantity."""
    return float(record["true"][name] / record["stated"])


def lowest_ratio(record: Record) -> float:
    """Return true over stated error of the lowest wall."""
    stated, lowest, boundary = record["lowest_error"], record["lowest"], record["boundary"]
    if math.isinf(stated) or (math.isnan(lowest) and math.isnan(boundary)):
        return 0.0
    if math.isnan(lowest) or math.isnan(boundary):  # one of both has a wall that suffices
        return math.inf
    return float(abs(lowest - boundary) / stated)


def main() -> None:
    """Compute the motions, and print their errors."""
    options = command_line.options(__doc__, runs=200, near=60, seed=1, keep=Path)
    records = made(options.keep, options.seed, options.runs, options.near)
    tell(f"{options.runs} trucks", records[: options.runs])
    if options.near:
        tell(f"{options.near} trucks within 2 mm of the boundary", records[options.runs :])


if __name__ == "__main__":
    main()
