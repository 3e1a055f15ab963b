"""Outcomes, errors and time of random trucks in space.

    .venv/bin/python benchmarks/space_random.py [--runs 500] [--seed 1] [--finer 8] [--keep FILE]

Single-unit trucks with two axles and four strips: front corner, rear wheels, lower edge and rear corner of the box.
Springs, spacing, heights, roll inertia, plateaus, friction and tyres are within the ranges that docs/tipping.md names;
restitution is 0 to 0.5. Half of the trucks crush without a plateau, half slide on tyres without side force, the walls
are 0.5 to 1.2 m high with one of the four named profiles or a random line.

Each motion is computed with the step that the program chooses, and with a finer one as the reference. The true error
of a quantity is its distance from the reference, over its size or the least size of `solver.space.solve.COMPARED`.

--finer   steps of the reference in one chosen step
--keep    records of the runs, a line each; those that are there are not made again
"""

from __future__ import annotations

import math
import time
from collections import Counter
from functools import partial
from pathlib import Path
from typing import Any

import command_line
import numpy as np
from command_line import add_record, on_all_cores, read_records, row

from solver.space import PROFILES, SpaceAxle, SpaceMotion, SpaceStrip, SpaceUnit, SpaceVehicle, SpaceWall
from solver.space.solve import COMPARED, TOLERANCE, solve_space

Record = dict[str, Any]
Arguments = tuple[SpaceVehicle, SpaceWall, float, float]
SPREAD = 0.7, 1.3
"""Range of crush stiffness and of the plateaus of wheels and box, over those of the shipped truck."""
NEAR = math.radians(45.0)
"""Roll from which a vehicle that remains upright is near to tipping [rad]."""
BATCH = 100
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


def values(motion: SpaceMotion) -> dict[str, float]:
    """The quantities by which the program judges a motion."""
    return {name: float(getattr(motion.answers, name)) for name in COMPARED}


def solved(seed: int, finer: int, number: int) -> Record:
    """The motion of the program, and true errors of its quantities."""
    arguments = drawn(seed, number)
    start = time.process_time()
    motion = solve_space(*arguments)
    spent = time.process_time() - start
    reference = solve_space(*arguments, step=motion.step / finer)
    computed, true = values(motion), values(reference)
    errors = {
        name: abs(computed[name] - true[name]) / max(abs(true[name]), least)
        for name, least in COMPARED.items()
    }
    return {
        "number": number, "seed": seed, "seconds": spent, "stated": motion.error, "step": motion.step,
        "outcome": motion.outcome, "reference": reference.outcome, "reference_error": reference.error,
        "roll": max(abs(computed["largest_roll"]), abs(true["largest_roll"])),
        "values": computed, "true": errors,
    }  # fmt: skip


def made(file: Path | None, seed: int, runs: int, finer: int) -> list[Record]:
    """Return the records of all runs, read or computed."""
    records = {record["number"]: record for record in read_records(file) if record["seed"] == seed}
    missing = [number for number in range(runs) if number not in records]
    for first in range(0, len(missing), BATCH):
        for record in on_all_cores(partial(solved, seed, finer), missing[first : first + BATCH]):
            records[record["number"]] = record
            add_record(file, record)
    return [records[number] for number in range(runs)]


def kind(record: Record) -> str:
    """Name the crush, tyres and profile of a truck, and its risk."""
    number = record["number"]
    _, wall, _, _ = drawn(record["seed"], number)
    profile = wall.profile if isinstance(wall.profile, str) else "line"
    crush, grip = "plateau" if number % 2 == 0 else "no plateau", "tyres" if number % 4 < 2 else "no tyres"
    return f"{crush}, {grip}, {profile}{', near to tipping' if record['roll'] > NEAR else ''}"


def tell(records: list[Record]) -> None:
    """Print outcomes, and true beside stated errors."""
    row(
        f"{len(records)} trucks",
        "",
        ", ".join(f"{n} {name}" for name, n in Counter(r["outcome"] for r in records).items()),
    )
    wrong = [record for record in records if record["outcome"] != record["reference"]]
    row("other outcome with the finer step", "0", f"{len(wrong)}")
    for record in wrong:
        names = f"{record['outcome']}, finer {record['reference']}"
        print(f"    {record['number']}: {names}, stated {record['stated']:.1e}; {kind(record)}")
    unsettled = [record for record in records if record["stated"] > TOLERANCE]
    row(
        "stated error above the tolerance of 1e-3",
        "",
        f"{len(unsettled)} {[r['number'] for r in unsettled] or ''}",
    )
    same = [record for record in records if record["outcome"] == record["reference"]]
    for name in COMPARED:
        bounded = [record["true"][name] <= record["stated"] for record in same]
        row(f"{name}: true error at most the stated one", "99 %", f"{100.0 * np.mean(bounded):.1f} %")
    tell_beyond(same)
    stated, true = (np.array([record[key] for record in same]) for key in ("stated", "largest"))
    row("stated error: median, most", "1e-3", f"{np.median(stated):.1e}, {stated.max():.1e}")
    row(
        "true error: median, 99 %, most",
        "1e-3",
        f"{np.median(true):.1e}, {np.quantile(true, 0.99):.1e}, {true.max():.1e}",
    )
    row(
        "processor time of one, mean",
        "",
        f"{1e3 * np.mean([record['seconds'] for record in records]):.0f} ms",
    )


def tell_beyond(records: list[Record]) -> None:
    """Print trucks with true errors beyond the stated ones."""
    for record in records:
        record["largest"] = max(record["true"].values())
        record["ratio"] = max(error / max(record["stated"], 1e-12) for error in record["true"].values())
    beyond = sorted((r for r in records if r["ratio"] > 1.0), key=lambda record: -record["largest"])
    row("largest true over stated error", "1.5", f"{max(record['ratio'] for record in records):.2f}")
    row(
        "the same where the true error is beyond 1e-3",
        "1.5",
        f"{max((r['ratio'] for r in records if r['largest'] > 1e-3), default=0.0):.2f}",
    )
    for record in beyond:
        name = max(COMPARED, key=lambda name: record["true"][name])
        print(
            f"    {record['number']} {name}: {record['largest']:.1e}, stated {record['stated']:.1e}; {kind(record)}"
        )


def main() -> None:
    """Compute the motions, and print their errors."""
    options = command_line.options(__doc__, runs=500, seed=1, finer=8, keep=Path)
    tell(made(options.keep, options.seed, options.runs, options.finer))


if __name__ == "__main__":
    main()
