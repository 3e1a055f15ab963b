"""Failures, errors and time of random whole impacts.

    .venv/bin/python benchmarks/impacts_random.py [--runs 200] [--seed 1] [--meshes default quad4:6 ...]
        [--crush | --both] [--trains] [--units N] [--restitution LEAST MOST] [--rigid] [--references [MESH ...]]
        [--largest N] [--every N] [--keep FILE]

Vehicles are cars, pickups, trucks and tractors with their trailer as one body, of ordinary size and mass, as a plate of
200 GPa and half to twice the thickness that steel would have, their crush within the values that docs/impact.md names.

--crush        the same vehicles with a plateau, rear corners of their own, half of which unload by their slope, and two
               axles with tyres
--both         four of eight so
--trains       tractors with one to three trailers instead, each unit with a centre of mass and a yaw inertia of its
               own; in a third of them the hinges are spread over 1.5 m
--units        trains of at most N units only
--restitution  range of the restitution of the front; below 0.1 it strikes several times at short intervals, and short
               strikes differ from mesh to mesh
--rigid        rigid vehicles alone, each beside the same at a quarter of its step
--meshes       "default", or a kind of element and the number across the vehicle, which are square
--references   each impact also on finer meshes of two kinds of element, still finer ones for those that fail, or on the
               meshes named; "twice" is twice its own elements along and across. The true error of a quantity is the
               distance from the nearer of the two, which both confirm. Of trains the largest 50 ms mean of each hinge's
               force counts too
--largest      elements of a reference "twice", 10 000; larger ones are not made
--every        references of every n-th impact alone, and of those that fail
--keep         records of the runs, a line each; those that are there are not made again
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import command_line
import numpy as np
from command_line import add_record, read_records, row

Record = dict[str, Any]
Draw = tuple[dict[str, Any], float]
"""Keys of an impact, and its length over its width."""
SCENE = str(Path(__file__).parents[1] / "examples" / "linear-truck.toml")
VEHICLES = (
    ((3.8, 5.0), (1.6, 1.9), (1e3, 1.9e3), (0.7, 1.3), (50, 100)),
    ((5.0, 6.2), (1.8, 2.1), (1.8e3, 3.5e3), (0.69, 1.2), (80, 120)),
    ((7.0, 11.0), (2.3, 2.6), (6e3, 14e3), (1.0, 3.3), (0, 170)),
    ((14.0, 21.0), (2.4, 2.6), (20e3, 40e3), (1.0, 3.3), (0, 330)),
)
"""Ranges of length, width [m], mass [kg], crush stiffness [MN/m] and initial force [kN] of each kind."""
UNITS = (
    ((5.5, 8.5), (2.3, 2.6), (6e3, 11e3), (1.0, 3.3)),
    ((8.0, 16.0), (2.3, 2.6), (5e3, 30e3), (1.0, 3.3)),
)
"""Ranges of length, width [m], mass [kg] and crush stiffness [MN/m] of a tractor and of a trailer."""
REFERENCES = ("quad9:10", "quad4:20")
FINER = ("quad9:16", "quad4:40")
"""References of an impact that fails: a corner's force at a point has no limit of fine meshes."""
RIGHT = 0.01
"""True error up to which an impact is right."""
QUANTILES = (0.5, 0.9, 0.98, 1.0)
"""Of the true over the stated errors."""
restitution: Sequence[float] = (0.1, 0.4)
"""Range of the restitution of the front."""
CHOSEN = ("quad4:4", "quad4:6", "quad4:12", "quad9:3")


def common_changes(random: np.random.Generator, size: Sequence[float], steepest: float) -> dict[str, Any]:
    """Draw contact, impact and thickness of a vehicle.

    size: length, width and mass.
    """
    length, width, mass = size
    return {
        "contact.restitution": random.uniform(restitution[0], restitution[1]),
        "contact.friction": random.uniform(0.05, 0.6),
        "impact.speed": random.uniform(8.0, 30.0),
        "impact.angle": math.radians(random.uniform(5.0, steepest)),
        "plate.thickness": mass / (7800.0 * length * width) * 2.0 ** random.uniform(-1.0, 1.0),
    }


def changes(seed: int, number: int) -> Draw:
    """Draw an impact."""
    random = np.random.default_rng((seed, number))
    *size, crush, force = (random.uniform(*bounds) for bounds in VEHICLES[number % len(VEHICLES)])
    keys = dict(zip(("vehicle.length", "vehicle.width", "vehicle.mass"), size, strict=True))
    keys |= {"contact.stiffness": 1e6 * crush, "contact.initial_force": 1e3 * force}
    return keys | common_changes(random, size, 28.0), size[0] / size[1]


def crush_changes(seed: int, number: int) -> Draw:
    """Draw an impact with plateau, rear corners of their own and tyres.

    Plateaus are 0.3 to 1.2 of the force without one above the initial force.
    """
    keys, slenderness = changes(seed, number)
    random, length = np.random.default_rng((seed, number, 2)), keys["vehicle.length"]
    initial, stiffness = keys["contact.initial_force"], keys["contact.stiffness"]
    closing = keys["impact.speed"] * math.sin(keys["impact.angle"])
    force = closing * math.sqrt(0.35 * stiffness * keys["vehicle.mass"])
    rear = stiffness * 2.0 ** random.uniform(-1.0, 1.0)
    front = {
        "at": 0.0,
        "stiffness": keys.pop("contact.stiffness"),
        "initial_force": keys.pop("contact.initial_force"),
    }
    front["plateau"] = initial + random.uniform(0.3, 1.2) * force
    behind = {"at": length, "stiffness": rear, "initial_force": initial}
    behind["plateau"] = initial + random.uniform(0.3, 1.2) * force
    if number % 2:
        behind["unloading_stiffness"] = rear * random.uniform(3.0, 30.0)
    else:
        behind["restitution"] = random.uniform(0.1, 0.4)
    keys |= {"strip": [front, behind], "contact.stiffness": None}
    keys["axle"] = [
        {"position": random.uniform(*ends) * length}
        | {"friction": random.uniform(0.5, 0.8), "cornering": random.uniform(4.0, 8.0)}
        for ends in ((0.12, 0.22), (0.7, 0.85))
    ]
    return keys, slenderness


def both_changes(seed: int, number: int) -> Draw:
    """Draw an impact, four of eight with a plateau."""
    return (crush_changes if number // 4 % 2 else changes)(seed, number)


def train_changes(seed: int, number: int) -> Draw:
    """Draw a train.

    Centres are 0.35 to 0.65 of the length behind the front, radii of gyration 0.22 to 0.33 lengths; the hitch is in the
    last quarter of the unit ahead, the kingpin in the first tenth of its own.
    """
    random = np.random.default_rng((seed, number, 1))
    units: list[dict[str, float]] = []
    hitch_length = {} if number % 3 else {"hitch_length": 1.5}
    for unit in range(1 + int(random.integers(1, 4))):
        length, width, mass, crush = (random.uniform(*bounds) for bounds in UNITS[min(unit, 1)])
        centre, radius = random.uniform(0.35, 0.65) * length, random.uniform(0.22, 0.33) * length
        unit_keys = {"length": length, "width": width, "mass": mass, "centre_of_mass": centre}
        unit_keys |= {"yaw_inertia": mass * radius**2, "stiffness": 1e6 * crush}
        if unit:
            unit_keys["hitch"] = random.uniform(0.75, 1.0) * units[-1]["length"]
            unit_keys |= {"kingpin": random.uniform(0.0, 0.1) * length, **hitch_length}
        units.append(unit_keys)
    tractor, *trailers = units
    strips = [
        {"unit": unit, "at": at, "stiffness": trailer["stiffness"]}
        for unit, trailer in enumerate(trailers, 2)
        for at in (0.0, trailer["length"])
    ]
    keys = {
        "contact.stiffness": tractor.pop("stiffness"),
        **{f"vehicle.{key}": value for key, value in tractor.items()},
        "trailer": [{key: trailer[key] for key in trailer if key != "stiffness"} for trailer in trailers],
        "strip": strips,
    }
    size = [tractor[name] for name in ("length", "width", "mass")]
    return keys | common_changes(random, size, 25.0), size[0] / size[1]


def of_units(seed: int, runs: int, most: int) -> list[int]:
    """List the numbers of the impacts with at most `most` units."""
    return [number for number in range(runs) if len(drawn(seed, number)[0].get("trailer", ())) < most]


drawn: Callable[[int, int], Draw] = changes
"""Function that draws the impacts."""


def case_of(seed: int, number: int, mesh: str) -> Any:
    """The impact on a mesh, with the patch lengths of the program."""
    from tailslap.case.impact.case import ImpactCase
    from tailslap.case.impact.plan import chosen_lengths
    from tailslap.scene.read import read_source
    from tailslap.scene.vary import vary

    keys, slenderness = drawn(seed, number)
    keys |= {"plate.elements": None, "impact.test_level": None}
    case = ImpactCase(*vary(read_source(SCENE), keys))
    kind, _, numbers = mesh.partition(":")
    if not numbers:
        return case
    *along, across = map(int, numbers.split("x"))
    counts = along[0] if along else max(2, round(across * slenderness)), across
    return case.varied({**chosen_lengths(case.scene), "plate.elements": counts, "plate.element": kind})


def read(answer: Any) -> Record:
    """The quantities of the first two strikes of weight, and of hinges."""
    from tailslap.case.impact import error

    strikes = error.assessed_strikes(answer)
    values = {
        f"strike_{k}.{name}": error.value(answer, strike, name)
        for k, strike in enumerate(strikes, 1)
        for name in error.QUANTITIES
    } | {"corners": [strike.corner for strike in strikes]}
    return values | by_hinge([hinge["mean_50ms"] for hinge in answer.hinges])


def by_hinge(values: Sequence[float]) -> Record:
    """Values of the hinges' largest 50 ms means by name."""
    return {f"hinge_{k}.mean_50ms": value for k, value in enumerate(values, 1)}


def judged(seed: int, number: int, mesh: str) -> Record:
    """The impact as the program runs it."""
    began, case = time.process_time(), case_of(seed, number, mesh)
    outcome = case.run()
    return {
        "seconds": time.process_time() - began,
        "failed": [check.name for check in outcome.checks if not check.passed],
        "stated": outcome.mesh_error | by_hinge(outcome.hinge_error),
        "end": float(outcome.fe.history["t"][-1]),
        "plate": [outcome.fe_plan.plate.element, *outcome.fe_plan.plate.counts],
        "values": read(outcome.fe),
    }


def rigid(seed: int, number: int) -> Record:
    """Solve the rigid impact, and state its error.

    The true error is the largest change of peaks and impulses with a quarter of the step, of strikes of 5 % of the
    largest impulse.
    """
    from solver.impact import solve_impact
    from solver.impact.trajectories import TOLERANCE
    from tailslap.errors import InputError

    start = time.process_time()
    try:
        case = case_of(seed, number, "quad4:4")
        motion = case.motion
    except InputError as error:
        return {"seconds": time.process_time() - start, "refused": str(error)}
    spent, state = time.process_time() - start, (case.vehicle, case.contact, case.touch, motion.t_end)
    finer = solve_impact(*state, tolerance=TOLERANCE / 16.0, trailers=case.trailers, axles=case.axles)
    least = 0.05 * max(strike.impulse for strike in motion.strikes)
    true = 0.0
    for strike in (strike for strike in motion.strikes if strike.impulse >= least):
        same = [candidate for candidate in finer.strikes if candidate.corner == strike.corner]
        if not same:
            true = math.inf
            continue
        nearest = min(same, key=lambda candidate: abs(candidate.start - strike.start))
        changes = nearest.peak_force / strike.peak_force - 1.0, nearest.impulse / strike.impulse - 1.0
        true = max(true, *map(abs, changes))
    return {"seconds": spent, "stated": motion.error, "true": true}


def tell_rigid(seed: int, runs: int) -> None:
    """Print refused rigid impacts, and true beside stated errors."""
    records = {number: rigid(seed, number) for number in range(runs)}
    refused = {number: record["refused"] for number, record in records.items() if "refused" in record}
    row(f"rigid: {runs} impacts; refused", "2 %", f"{len(refused)} ({100.0 * len(refused) / runs:.1f} %)")
    for number, why in refused.items():
        print(f"    {number}: {why}")
    solved = {number: record for number, record in records.items() if number not in refused}
    stated, true = (np.array([record[name] for record in solved.values()]) for name in ("stated", "true"))
    wrong = [
        number for number, record in solved.items() if record["true"] > max(1.5 * record["stated"], 1e-4)
    ]
    row("  true error beyond 1e-4 and 1.5 times the stated one", "0", f"{len(wrong)} {wrong or ''}")
    row("  stated error: median, most", "1e-3", f"{np.median(stated):.1e}, {stated.max():.1e}")
    row("  true error: median, most", "1e-3", f"{np.median(true):.1e}, {true.max():.1e}")
    mean = np.mean([record["seconds"] for record in records.values()])
    row("  processor time of one, mean", "60 ms", f"{1e3 * mean:.0f} ms")


def reference(seed: int, number: int, mesh: str, end: float) -> Record:
    """The impact on a reference mesh, as long as the others.

    A hinge may bear its largest force last. Of a mesh whose masses cannot have the yaw inertia there is none.
    """
    from tailslap.case.impact.run import attempt
    from tailslap.errors import InputError

    try:
        return {"values": read(attempt(case_of(seed, number, mesh).varied({"time.end": end})).fe)}
    except InputError as error:
        return {"refused": str(error)}


def made(
    file: Path | None, seed: int, numbers: Sequence[int], meshes: list[str], references: Callable[..., Any]
) -> dict[tuple[int, str], Record]:
    """Return the records of these runs, read or computed."""
    stored = (record for record in read_records(file) if record["number"] in numbers)
    records_of_runs = {(record["number"], record["mesh"]): record for record in stored}

    def add(number: int, name: str, make: Callable[[int, int, str], Record], mesh: str) -> Record:
        if (number, name) not in records_of_runs:
            records_of_runs[number, name] = {"number": number, "mesh": name, **make(seed, number, mesh)}
            add_record(file, records_of_runs[number, name])
        return records_of_runs[number, name]

    for number in numbers:
        records = [add(number, mesh, judged, mesh) for mesh in meshes]
        for mesh in sorted({mesh for record in records for mesh in references(record)}):
            end = max(record["end"] for record in records)
            add(number, f"reference {mesh}", partial(reference, end=end), mesh)
    return records_of_runs


def references_of(record: Record, meshes: Sequence[str] | None, every: int, largest: int) -> Sequence[str]:
    """Reference meshes of a run, none for None.

    largest: number of elements of one of twice the run's.
    """
    if meshes is None or (record["number"] % every and not record["failed"]):
        return ()
    if meshes == ["twice"]:
        element, along, across = record["plate"]
        return (f"{element}:{2 * along}x{2 * across}",) if 4 * along * across <= largest else ()
    return meshes or (FINER if record["failed"] else REFERENCES)


def true_errors(record: Record, references: list[Record], of: Callable[..., float] = min) -> dict[str, float]:
    """Relative distance of each quantity from a reference, by default the nearer.

    Infinite where others strike.
    """
    ours = record["values"]
    same = [record["values"] for record in references if record["values"]["corners"] == ours["corners"]]
    names = [name for name in ours if name != "corners"]
    return {n: of((abs(ours[n] / values[n] - 1.0) for values in same), default=math.inf) for n in names}


def tell(mesh: str, records: dict[tuple[int, str], Record], references: Callable[..., Any]) -> None:
    """Print failures on a mesh, and stated beside true errors."""
    runs = {number: record for (number, name), record in records.items() if name == mesh}
    failed = {number: record for number, record in runs.items() if record["failed"]}
    most = {number: max(record["stated"].values(), default=math.nan) for number, record in runs.items()}
    passed = [most[number] for number in runs if number not in failed]
    limit, part = "2 %" if drawn is train_changes else "1 %", f"{100.0 * len(failed) / len(runs):.1f} %"
    row(f"{mesh}: {len(runs)} impacts; failed", limit, f"{len(failed)} ({part})")
    for number, record in failed.items():
        print(f"    {number}: {', '.join(record['failed'])}; stated {most[number]:.2%}")
    largest = f"{np.median(passed):.2%}, {max(passed):.2%}"
    row("  largest error stated by one that passes: median, most", "2 %", largest)
    compared = {
        number: references_made
        for number, record in runs.items()
        if (
            references_made := [
                reference
                for name in references(record)
                if "values" in (reference := records[number, f"reference {name}"])
            ]
        )
    }
    if compared:
        tell_true(runs, failed, compared)


def tell_true(runs: dict[int, Record], failed: dict[int, Record], compared: dict[int, list[Record]]) -> None:
    """Print the true errors of impacts with references."""
    true = {number: true_errors(runs[number], finer) for number, finer in compared.items()}
    far = {
        n: (max(true[n].values()), max(true_errors(r, compared[n], max).values()))
        for n, r in failed.items()
        if n in compared
    }
    text = ", ".join(f"{number}: {near:.2%} and {farther:.2%}" for number, (near, farther) in far.items())
    row("  errors of those that fail, from either reference", "above 1 %", text)
    right = sum(farther <= RIGHT for _, farther in far.values())
    row("  failed though right: errors up to 1 %", "2 %", f"{right} ({100.0 * right / len(runs):.1f} %)")
    pairs = [
        (error, runs[n]["stated"].get(name, 0.0), n, name)
        for n in compared
        if n not in failed
        for name, error in true[n].items()
    ]
    row("  impacts with references", "", f"{len(compared)}")
    wrong = sorted({n for error, stated, n, _ in pairs if error > max(0.02, stated)})
    row("  wrong and not failed: beyond 2 % and the stated error", "0", f"{len(wrong)} {wrong or ''}")
    bounded = 100.0 * sum(error <= stated for error, stated, *_ in pairs) / len(pairs)
    row("  true over stated of those that pass: at most 1", "99 %", f"{bounded:.2f} % of {len(pairs)}")
    for quantity in ("peak_force", "impulse", "duration", "mean_50ms"):
        ratios = [error / stated for error, stated, _, name in pairs if name.endswith(quantity)]
        parts = (f"{np.quantile(ratios, level):.2f}" for level in QUANTILES)
        row(f"    {quantity}: 50, 90, 98 %, largest", "1; 1.3", ", ".join(parts))
    beyond = [(error / stated, error, stated, *which) for error, stated, *which in pairs if error > 1e-3]
    largest = f"{max(beyond)[0]:.2f}" if beyond else "none is"
    row("  the largest, where the true error is beyond 1e-3", "1.5", largest)
    for ratio, error, stated, number, name in sorted(beyond, reverse=True):
        if ratio > 1.0:
            print(f"    {number} {name}: {error:.2%}, stated {stated:.2%}")


def main() -> None:
    """Make the runs, and print the figures of each mesh."""
    global drawn, restitution
    options = command_line.options(
        __doc__, runs=200, seed=1, meshes=("default", *CHOSEN), crush=False, both=False, trains=False, units=8,
        rigid=False, restitution=restitution, references=None, largest=10_000, every=1, keep=Path,
    )  # fmt: skip
    restitution = options.restitution
    for is_drawn, function in (
        (options.crush, crush_changes), (options.both, both_changes), (options.trains, train_changes)
    ):  # fmt: skip
        drawn = function if is_drawn else drawn
    if options.rigid:
        tell_rigid(options.seed, options.runs)
        return
    references = partial(
        references_of, meshes=options.references, every=options.every, largest=options.largest
    )
    numbers = of_units(options.seed, options.runs, options.units)
    records = made(options.keep, options.seed, numbers, options.meshes, references)
    for mesh in options.meshes:
        tell(mesh, records, references)


if __name__ == "__main__":
    main()
