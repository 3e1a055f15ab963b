"""Random whole impacts: failures, stated and true errors, and time.

    .venv/bin/python benchmarks/impacts_random.py [--runs 200] [--seed 1] [--meshes default quad4:6 ...]
        [--crush] [--trains] [--units N] [--rigid] [--references [MESH ...]] [--every N] [--keep FILE]
        [--beside CHECKOUT]

Vehicles are cars, pickups, trucks and tractors with their trailer as one body, of ordinary size and mass, as a plate of
200 GPa and half to twice the thickness that steel would have, their crush within the values that docs/impact.md names.
Below a restitution of 0.1 a strike ends too suddenly for any mesh.

--crush        the same vehicles with a plateau, rear corners of their own, half of which unload by their slope, and two
               axles with tyres
--trains       tractors with one to three trailers instead, each unit with a centre of mass and a yaw inertia of its
               own; in a third of them the hinges are spread over 1.5 m
--units        trains of at most N units only
--rigid        rigid vehicles alone, each beside the same at a quarter of its step
--meshes       "default", or a kind of element and the number across the vehicle, which are square
--references   each impact also on finer meshes of two kinds of element, still finer ones for those that fail, or on the
               meshes named. The true error of a quantity is the distance from the nearer of the two, which both
               confirm. Of trains the largest 50 ms mean of each hinge's force counts too
--every        references of every n-th impact alone, and of those that fail
--keep         records of the runs, a line each; those that are there are not made again
--beside       the same scenes by the sources of another checkout, for the time
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import command_line

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

SCENE = "impact-mash-tl4-sut"
VEHICLES = (
    {
        "length": (3.8, 5.0),
        "width": (1.6, 1.9),
        "mass": (1e3, 1.9e3),
        "crush": (0.7, 1.3),
        "force": (50, 100),
    },
    {
        "length": (5.0, 6.2),
        "width": (1.8, 2.1),
        "mass": (1.8e3, 3.5e3),
        "crush": (0.69, 1.2),
        "force": (80, 120),
    },
    {"length": (7.0, 11.0), "width": (2.3, 2.6), "mass": (6e3, 14e3), "crush": (1.0, 3.3), "force": (0, 170)},
    {
        "length": (14.0, 21.0),
        "width": (2.4, 2.6),
        "mass": (20e3, 40e3),
        "crush": (1.0, 3.3),
        "force": (0, 330),
    },
)
"""Ranges of each kind: m, kg, MN/m, kN."""
REFERENCES = ("quad9:10", "quad4:20")
FINER = ("quad9:16", "quad4:40")
"""References of an impact that fails: a corner's force at a point has no limit of fine meshes."""
CHOSEN = ("quad4:4", "quad4:6", "quad4:12", "quad9:3")
Record = dict[str, Any]


def changes(seed: int, number: int) -> tuple[dict[str, Any], float]:
    """The keys of a random impact, and its length over its width."""
    random, own = np.random.default_rng((seed, number)), VEHICLES[number % len(VEHICLES)]
    length, width, mass, crush, force = (random.uniform(*bounds) for bounds in own.values())
    keys = {
        "vehicle.length": length,
        "vehicle.width": width,
        "vehicle.mass": mass,
        "contact.stiffness": 1e6 * crush,
        "contact.initial_force": 1e3 * force,
        "contact.restitution": random.uniform(0.1, 0.4),
        "contact.friction": random.uniform(0.05, 0.6),
        "impact.speed": random.uniform(8.0, 30.0),
        "impact.angle": math.radians(random.uniform(5.0, 28.0)),
        "plate.thickness": mass / (7800.0 * length * width) * 2.0 ** random.uniform(-1.0, 1.0),
    }
    return keys, length / width


def crush_changes(seed: int, number: int) -> tuple[dict[str, Any], float]:
    """The keys of a random impact with plateau, rear corners of their own and tyres, and its length over its width.

    Plateaus are 0.3 to 1.2 of the force without one above the initial force.
    """
    keys, slenderness = changes(seed, number)
    random, length = np.random.default_rng((seed, number, 2)), keys["vehicle.length"]
    initial, stiffness = keys["contact.initial_force"], keys["contact.stiffness"]
    closing = keys["impact.speed"] * math.sin(keys["impact.angle"])
    force = closing * math.sqrt(0.35 * stiffness * keys["vehicle.mass"])
    rear = stiffness * 2.0 ** random.uniform(-1.0, 1.0)
    keys["contact.plateau_force"] = initial + random.uniform(0.3, 1.2) * force
    keys["contact.rear.stiffness"] = rear
    keys["contact.rear.plateau_force"] = initial + random.uniform(0.3, 1.2) * force
    if number % 2:
        keys["contact.rear.unloading_stiffness"] = rear * random.uniform(3.0, 30.0)
    else:
        keys["contact.rear.restitution"] = random.uniform(0.1, 0.4)
    keys["axle"] = [
        {
            "position": random.uniform(*ends) * length,
            "friction": random.uniform(0.5, 0.8),
            "cornering": random.uniform(4.0, 8.0),
        }
        for ends in ((0.12, 0.22), (0.7, 0.85))
    ]
    return keys, slenderness


UNITS = (
    {"length": (5.5, 8.5), "width": (2.3, 2.6), "mass": (6e3, 11e3), "crush": (1.0, 3.3)},
    {"length": (8.0, 16.0), "width": (2.3, 2.6), "mass": (5e3, 30e3), "crush": (1.0, 3.3)},
)
"""Ranges of a tractor and of a trailer: m, kg, MN/m."""


def train_changes(seed: int, number: int) -> tuple[dict[str, Any], float]:
    """Return the keys of a random train, and its tractor's length over its width.

    Centres are 0.35 to 0.65 of the length behind the front, radii of gyration 0.22 to 0.33 lengths; the hitch is in the
    last quarter of the unit ahead, the kingpin in the first tenth of its own.
    """
    random = np.random.default_rng((seed, number, 1))
    units: list[dict[str, float]] = []
    hitch_length = {} if number % 3 else {"hitch_length": 1.5}
    for unit in range(1 + int(random.integers(1, 4))):
        length, width, mass, crush = (random.uniform(*bounds) for bounds in UNITS[min(unit, 1)].values())
        centre, radius = random.uniform(0.35, 0.65) * length, random.uniform(0.22, 0.33) * length
        own = {"length": length, "width": width, "mass": mass, "centre_of_mass": centre}
        own |= {"yaw_inertia": mass * radius**2, "stiffness": 1e6 * crush}
        if unit:
            own["hitch"] = random.uniform(0.75, 1.0) * units[-1]["length"]
            own |= {"kingpin": random.uniform(0.0, 0.1) * length, **hitch_length}
        units.append(own)
    tractor, *trailers = units
    length, width, mass = tractor["length"], tractor["width"], tractor["mass"]
    keys = {
        "contact.stiffness": tractor.pop("stiffness"),
        **{f"vehicle.{key}": value for key, value in tractor.items()},
        "trailer": trailers,
        "contact.restitution": random.uniform(0.1, 0.4),
        "contact.friction": random.uniform(0.05, 0.6),
        "impact.speed": random.uniform(8.0, 30.0),
        "impact.angle": math.radians(random.uniform(5.0, 25.0)),
        "plate.thickness": mass / (7800.0 * length * width) * 2.0 ** random.uniform(-1.0, 1.0),
    }
    return keys, length / width


def of_units(seed: int, runs: int, most: int) -> list[int]:
    """List the numbers of the impacts with at most `most` units."""
    return [number for number in range(runs) if len(drawn(seed, number)[0].get("trailer", ())) < most]


drawn: Callable[[int, int], tuple[dict[str, Any], float]] = changes
"""What draws the impacts; with --trains `train_changes`."""


def case_of(seed: int, number: int, mesh: str) -> Any:
    """The impact on a mesh, with the forces of a train as spread as the program decides."""
    from tailslap.case.impact.case import ImpactCase
    from tailslap.case.impact.plan import chosen_lengths
    from tailslap.scene.read import read_source
    from tailslap.scene.vary import vary

    keys, slenderness = drawn(seed, number)
    keys |= {"plate.elements": None, "impact.test_level": None}
    case = ImpactCase(*vary(read_source(SCENE), keys))
    kind, _, across = mesh.partition(":")
    if not across:
        return case
    counts = max(2, round(int(across) * slenderness)), int(across)
    return case.varied({**chosen_lengths(case.scene), "plate.elements": counts, "plate.element": kind})


def read(answer: Any) -> Record:
    """The quantities of the first two strikes of weight, and of hinges."""
    from tailslap.case.impact import error

    strikes = error.assessed_strikes(answer.strikes)
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
        "values": read(outcome.fe),
    }


def rigid(seed: int, number: int) -> Record:
    """The rigid impact: its stated error, and the largest change of peaks and impulses of its strikes of 5 % of the
    largest impulse with a quarter of the step."""
    from solver.impact import solve_impact
    from solver.impact.trajectories import TOLERANCE
    from tailslap.errors import InputError

    began = time.process_time()
    try:
        case = case_of(seed, number, "quad4:4")
        motion = case.motion
    except InputError as error:
        return {"seconds": time.process_time() - began, "refused": str(error)}
    seconds, own = time.process_time() - began, (case.vehicle, case.contact, case.touch, motion.t_end)
    finer = solve_impact(*own, tolerance=TOLERANCE / 16.0, trailers=case.trailers, axles=case.axles)
    least = 0.05 * max(strike.impulse for strike in motion.strikes)
    true = 0.0
    for strike in (strike for strike in motion.strikes if strike.impulse >= least):
        alike = [other for other in finer.strikes if other.corner == strike.corner]
        if not alike:
            true = math.inf
            continue
        other = min(alike, key=lambda each: abs(each.start - strike.start))
        changes = other.peak_force / strike.peak_force - 1.0, other.impulse / strike.impulse - 1.0
        true = max(true, *map(abs, changes))
    return {"seconds": seconds, "stated": motion.error, "true": true}


def tell_rigid(seed: int, runs: int) -> None:
    """Print how many rigid impacts are refused, and the true errors of the others beside the stated ones."""
    records = {number: rigid(seed, number) for number in range(runs)}
    refused = {number: record["refused"] for number, record in records.items() if "refused" in record}
    row(f"rigid: {runs} impacts; refused", "2 %", f"{len(refused)} ({100.0 * len(refused) / runs:.1f} %)")
    for number, why in refused.items():
        print(f"    {number}: {why}")
    known = {number: record for number, record in records.items() if number not in refused}
    stated, true = (np.array([record[name] for record in known.values()]) for name in ("stated", "true"))
    wrong = [number for number, record in known.items() if record["true"] > max(1.5 * record["stated"], 1e-4)]
    row("  true error beyond 1e-4 and 1.5 times the stated one", "0", f"{len(wrong)} {wrong or ''}")
    row("  stated error: median, most", "1e-3", f"{np.median(stated):.1e}, {stated.max():.1e}")
    row("  true error: median, most", "1e-3", f"{np.median(true):.1e}, {true.max():.1e}")
    mean = np.mean([record["seconds"] for record in records.values()])
    row("  processor time of one, mean", "60 ms", f"{1e3 * mean:.0f} ms")


def reference(seed: int, number: int, mesh: str, end: float) -> Record:
    """The impact on a mesh that others are held against, as long as theirs: a hinge may bear its largest force last."""
    from tailslap.case.impact.run import attempt

    return {"values": read(attempt(case_of(seed, number, mesh).varied({"time.end": end})).fe)}


def timed(seed: int, runs: int, meshes: list[str]) -> Record:
    """Processor time of the runs [s], by mesh; by any version of the program."""
    found = {}
    for mesh in meshes:
        case_of(seed, 0, mesh).run()  # compiles
        began = time.process_time()
        for number in range(runs):
            case_of(seed, number, mesh).run()
        found[mesh] = time.process_time() - began
    return found


def beside(checkout: Path, arguments: list[str]) -> Record:
    """The times of another checkout's sources, in a process of its own."""
    own = {**os.environ, "PYTHONPATH": str(checkout.resolve())}
    command = [sys.executable, __file__, *arguments, "--times"]
    return dict(
        json.loads(subprocess.run(command, env=own, check=True, capture_output=True, text=True).stdout)
    )


def made(
    place: Path | None,
    seed: int,
    numbers: Sequence[int],
    meshes: list[str],
    references: Callable[[Record], Sequence[str]],
) -> dict[tuple[int, str], Record]:
    """Records of all runs by number and mesh; those that the file has are read."""
    found = {}
    if place and place.exists():
        for line in place.read_text().splitlines():
            record = json.loads(line)
            found[record["number"], record["mesh"]] = record

    def add(number: int, name: str, make: Callable[[int, int, str], Record], mesh: str) -> Record:
        if (number, name) not in found:
            record = {"number": number, "mesh": name, **make(seed, number, mesh)}
            found[number, name] = record
            if place:
                with place.open("a") as file:
                    print(json.dumps(record), file=file)
        return found[number, name]

    for number in numbers:
        records = [add(number, mesh, judged, mesh) for mesh in meshes]
        for mesh in sorted({mesh for record in records for mesh in references(record)}):
            end = max(record["end"] for record in records)
            add(number, f"reference {mesh}", partial(reference, end=end), mesh)
    return found


def references_of(record: Record, meshes: Sequence[str] | None, every: int) -> Sequence[str]:
    """Meshes that a run is held against: those named, or if none is, the usual ones; none for None."""
    if meshes is None or (record["number"] % every and not record["failed"]):
        return ()
    return meshes or (FINER if record["failed"] else REFERENCES)


def true_errors(record: Record, references: list[Record], of: Callable[..., float] = min) -> dict[str, float]:
    """Distance of each quantity from the nearer reference, or the farther, relative; infinite where others strike."""
    own, others = record["values"], [each["values"] for each in references]
    alike = [other for other in others if other["corners"] == own["corners"]]
    names = [name for name in own if name != "corners"]
    return {
        name: of((abs(own[name] / other[name] - 1.0) for other in alike), default=math.inf) for name in names
    }


def row(what: str, asked: str, measured: str) -> None:
    """A line of the table."""
    print(f"{what:<62} {asked:<24} {measured}", flush=True)


def tell(
    mesh: str, records: dict[tuple[int, str], Record], references: Callable[[Record], Sequence[str]]
) -> None:
    """What fails on a mesh, and how the stated errors compare with the true ones."""
    own = {number: record for (number, its), record in records.items() if its == mesh}
    failed = {number: record for number, record in own.items() if record["failed"]}
    row(
        f"{mesh}: {len(own)} impacts; failed",
        "2 %" if drawn is train_changes else "1 %",
        f"{len(failed)} ({100.0 * len(failed) / len(own):.1f} %)",
    )
    for number, record in failed.items():
        most = max(record["stated"].values(), default=math.nan)
        print(f"    {number}: {', '.join(record['failed'])}; stated {most:.2%}")
    stated = [
        max(record["stated"].values(), default=math.nan) for record in own.values() if not record["failed"]
    ]
    row(
        "  largest error stated by one that passes: median, most",
        "2 %",
        f"{np.median(stated):.2%}, {max(stated):.2%}",
    )
    held = {
        number: [records[number, f"reference {each}"] for each in meshes]
        for number, record in own.items()
        if (meshes := references(record))
    }
    if not held:
        return
    true = {number: true_errors(own[number], finer) for number, finer in held.items()}
    far = {n: (max(true[n].values()), max(true_errors(r, held[n], max).values())) for n, r in failed.items()}
    said = ", ".join(f"{number}: {near:.2%} and {farther:.2%}" for number, (near, farther) in far.items())
    row("  how far off those are that fail, from either reference", "more than 1 %", said)
    pairs = [
        (true[n][name], record["stated"].get(name, 0.0), n, name)
        for n, record in own.items()
        if n in held and not record["failed"]
        for name in true[n]
    ]
    bounded = sum(found <= said for found, said, *_ in pairs)
    row("  impacts with references", "", f"{len(held)}")
    wrong = sorted({n for found, said, n, _ in pairs if found > max(0.02, said)})
    row("  wrong and not failed: beyond 2 % and what is stated", "0", f"{len(wrong)} {wrong or ''}")
    row(
        "  true over stated of those that pass: at most 1",
        "99 %",
        f"{100.0 * bounded / len(pairs):.2f} % of {len(pairs)}",
    )
    beyond = [(found / said, found, said, *which) for found, said, *which in pairs if found > 1e-3]
    row(
        "  the largest, where the true error is beyond 1e-3",
        "1.5",
        f"{max(beyond)[0]:.2f}" if beyond else "none is",
    )
    for ratio, found, said, number, name in sorted(beyond, reverse=True):
        if ratio > 1.0:
            print(f"    {number} {name}: {found:.2%}, stated {said:.2%}")


def main() -> None:
    """Command line."""
    parser = command_line.parser(__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--meshes", nargs="+", default=["default", *CHOSEN])
    parser.add_argument("--crush", action="store_true")
    parser.add_argument("--trains", action="store_true")
    parser.add_argument("--units", type=int, default=8)
    parser.add_argument("--rigid", action="store_true")
    parser.add_argument("--references", nargs="*", metavar="MESH")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--beside", type=Path)
    parser.add_argument("--times", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    global drawn
    if given.trains or given.crush:
        drawn = train_changes if given.trains else crush_changes
    if given.rigid:
        tell_rigid(given.seed, given.runs)
        return
    if given.times:
        print(json.dumps(timed(given.seed, given.runs, given.meshes)))
        return
    if given.beside:
        arguments = ["--runs", str(given.runs), "--seed", str(given.seed), "--meshes", *given.meshes]
        its, own = beside(given.beside, arguments), beside(Path(__file__).parents[1], arguments)
        for mesh, seconds in own.items():
            row(
                f"{mesh}: processor time of {given.runs} runs over the other's",
                "1.5",
                f"{seconds / its[mesh]:.2f}: {seconds:.1f} s",
            )
        return
    references = partial(references_of, meshes=given.references, every=given.every)
    numbers = of_units(given.seed, given.runs, given.units)
    records = made(given.keep, given.seed, numbers, given.meshes, references)
    for mesh in given.meshes:
        tell(mesh, records, references)


if __name__ == "__main__":
    main()
