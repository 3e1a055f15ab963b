"""Accuracy of runs of random and extreme vehicles, beside the required values.

    .venv/bin/python benchmarks/vehicles.py [realistic] [predicted] [slender] [slow] [--scenes N] [--seed 1]

realistic   random vehicles of 4 to 19 m, 10 to 35 m/s, 5 to 30 deg, friction 0.05 to 0.8, the rest as in mash-tl4-sut
predicted   flutter predicted by `tailslap check` and that of the first run, over far wider scenes
slender     widths of 0.01 to 0.03 of the length, stiffness x 0.1 to 1 000, friction to 1.3, 20 x 6 elements, against a
            finer run with the exact constraint
slow        speeds to 0.01 times, stiffness to 10 000 times, slides of over a kilometre

"Beyond flexibility": difference from the rigid motion less the part due to the plate's flexibility.
"""

from __future__ import annotations

import itertools
import math
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import command_line

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

SCENE = "mash-tl4-sut"
Record = dict[str, Any]


def plan_of(changes: tuple[str, ...]) -> Any:
    """The plan of the scene with these changes, its wall long enough."""
    from tailslap.case.corner.corner_case import CornerCase
    from tailslap.scene.read import read_scene

    return CornerCase(*read_scene(SCENE, ("wall=", *changes)))


def realistic_changes(seed: int, number: int) -> tuple[str, ...]:
    """A vehicle as it may come."""
    random = np.random.default_rng((seed, number))
    length = random.uniform(4.0, 19.0)
    return (
        f"vehicle.length={length}",
        f"vehicle.width={random.uniform(1.5, 2.7)}",
        f"vehicle.mass={random.uniform(150.0, 1100.0) * length}",
        f"impact.speed={random.uniform(10.0, 35.0)}",
        f"impact.angle={random.uniform(5.0, 30.0)} deg",
        f"impact.friction={random.uniform(0.05, 0.8)}",
        f"impact.restitution={random.uniform(0.0, 0.5)}",
    )


def wide_changes(seed: int, number: int) -> tuple[str, ...]:
    """A vehicle as it may be thought of."""
    random = np.random.default_rng((seed, number))
    length = random.uniform(3.0, 20.0)
    changes = [
        f"vehicle.length={length}",
        f"vehicle.width={length * 10 ** random.uniform(-1.3, 0.0)}",
        f"plate.youngs_modulus={10 ** random.uniform(8.0, 14.0)}",
        f"impact.speed={10 ** random.uniform(0.0, 1.7)}",
        f"impact.angle={10 ** random.uniform(0.5, 1.7)} deg",
        f"impact.friction={random.uniform(0.0, 1.2)}",
        f"impact.restitution={random.uniform(0.0, 0.9)}",
        f"corner.reaction={random.choice(['drag', 'none', 'signed'], p=[0.8, 0.1, 0.1])}",
        f"plate.elements=[{random.integers(4, 25)}, {random.integers(2, 8)}]",
        f"plate.element={random.choice(['quad4', 'quad9', 'tri3'], p=[0.7, 0.15, 0.15])}",
    ]
    if random.random() < 0.4:
        held = ("corner.constraint=exact", f"corner.penalty_scale={10 ** random.uniform(-1.0, 1.0)}")
        changes.append(held[random.integers(2)])
    return tuple(changes)


def beyond(outcome: Any) -> float:
    """Largest difference from the rigid motion beyond what companions show of the plate's flexibility."""
    from postprocess.comparison.quantities import largest

    return max(0.0, largest(outcome.difference) - outcome.error.flexibility) if outcome.fe else math.inf


def judged(changes: tuple[str, ...]) -> Record:
    """The scene run as the program decides."""
    from postprocess.comparison.quantities import largest
    from tailslap.case.corner.corner_run import run_corner
    from tailslap.errors import InputError

    try:
        outcome = run_corner(plan_of(changes))
    except InputError as error:
        return {"end": "refused", "why": str(error), "changes": changes}
    normal, rigid = (h["reaction_normal"] for h in (outcome.fe_history, outcome.rigid_history))
    known = np.isfinite(rigid)
    ripple = np.sqrt(np.mean((normal - rigid)[known] ** 2) / np.mean(rigid[known] ** 2))
    return {
        "end": "passed" if outcome.passed else "failed",
        "failed": [check.name for check in outcome.checks if not check.passed],
        "beyond": beyond(outcome),
        "difference": largest(outcome.difference),
        "error": outcome.error.total,
        "damped": outcome.fe_plan.model.parameters.elastic_damping is not None,
        "attempts": outcome.attempts,
        "values": outcome.fe,
        "reaction": float(ripple),
        "steps": outcome.run.steps,
        "slide": outcome.fe.get("slide", math.nan),
        "seconds": outcome.run.time_loop_s,
        "changes": changes,
    }


def predicted(changes: tuple[str, ...]) -> Record:
    """What is foreseen, and whether the first run rings."""
    from tailslap.case.corner.corner_checks import rings
    from tailslap.case.corner.corner_report import flutter_sentence
    from tailslap.case.corner.corner_run import attempt
    from tailslap.errors import InputError

    try:
        outcome = attempt(plan_of(changes))
    except InputError as error:
        return {"end": "refused", "why": str(error)}
    said = flutter_sentence(outcome.fe_plan).split()[0].rstrip(":")
    return {"end": said, "rings": rings(outcome), "changes": changes, "failed": failed_of(outcome)}


def failed_of(outcome: Any) -> list[str]:
    """Names of the checks that failed."""
    return [check.name for check in outcome.checks if not check.passed]


def against_finer(changes: tuple[str, ...]) -> Record:
    """The scene as it is, and its distance from a run on more, quadratic elements."""
    record = judged((*changes, "plate.elements=[20, 6]"))
    finer = judged((*changes, "plate.elements=[30, 4]", "plate.element=quad9"))
    record["from_finer"] = math.inf
    if record.get("values") and finer.get("values"):
        pairs = [(value, finer["values"][name]) for name, value in record["values"].items()]
        record["from_finer"] = max(abs(ours / its - 1.0) for ours, its in pairs)
    record["finer_failed"] = finer.get("failed")
    return record


def on_all_cores(function: Callable[..., Record], scenes: Iterable[tuple[str, ...]]) -> list[Record]:
    """The records of all scenes."""
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        return list(pool.map(function, scenes, chunksize=1))


def row(what: str, asked: str, measured: str) -> None:
    """A line of the table."""
    print(f"{what:<66} {asked:<28} {measured}", flush=True)


def tell(records: list[Record], asked: str, what: str) -> None:
    """Ends, failures and the largest figures."""
    run = [record for record in records if record["end"] != "refused"]
    ends = Counter(record["end"] for record in records)
    row(f"{what}: ends", asked, ", ".join(f"{count} {end}" for end, count in ends.items()))
    row("  largest difference from rigid beyond flexibility", "", f"{max(r['beyond'] for r in run):.1e}")
    row(
        "  largest difference; largest numerical error stated",
        "",
        f"{max(r['difference'] for r in run):.1e}; {max(r['error'] for r in run):.1e}",
    )
    row(
        "  damped by the program; run again with more",
        "",
        f"{sum(r['damped'] for r in run)}; {sum(r['attempts'] > 1 for r in run)}",
    )
    for record in records:
        if record["end"] != "passed":
            print(
                "   ", record["end"], record.get("failed") or record.get("why"), " ".join(record["changes"])
            )


def realistic(scenes: int, seed: int) -> None:
    """The first row."""
    records = on_all_cores(judged, [realistic_changes(seed, number) for number in range(scenes)])
    tell(records, "all pass; 1e-4", f"{scenes} realistic vehicles")


def predict(scenes: int, seed: int) -> None:
    """Compare predicted flutter with that of runs."""
    records = on_all_cores(predicted, [wide_changes(seed, number) for number in range(scenes)])
    counts = Counter((record["end"], record.get("rings")) for record in records)
    told = [record for record in records if record["end"] in ("none", "harmless") and record["rings"]]
    row(f"{scenes} scenes: run corrupted that was called harmless or none", "0", str(len(told)))
    for (end, rang), count in sorted(counts.items(), key=str):
        row(f"  {end}, {'rang' if rang else 'did not ring'}", "", str(count))
    for record in told:
        print("   ", record["failed"], " ".join(record["changes"]))


def slender(scenes: int, seed: int) -> None:
    """Widths, stiffnesses and frictions on a grid."""
    grid = itertools.product((0.01, 0.02, 0.03), (0.1, 1.0, 21.5, 1000.0), (0.05, 0.47, 1.3))
    changes = [
        (
            f"vehicle.width={10.0 * width}",
            f"plate.youngs_modulus={factor * 2e11}",
            f"corner.friction={friction}",
        )
        for width, factor, friction in grid
    ]
    records = on_all_cores(against_finer, changes)
    tell(records, "right to 1e-3", f"{len(records)} slender plates")
    sure = [record for record in records if record["end"] == "passed"]
    row(
        "  largest distance from the finer run, of those that pass",
        "1e-3",
        f"{max(r['from_finer'] for r in sure):.1e}",
    )
    for record in sorted(sure, key=lambda r: -r["from_finer"])[:5]:
        print(
            f"    {record['from_finer']:.1e} {record['difference']:.1e}",
            record["finer_failed"],
            *record["changes"],
        )


def slow(scenes: int, seed: int) -> None:
    """Slow, stiff and long runs."""
    cases = [
        ("impact.speed=0.25",),
        ("impact.speed=2.5", "plate.youngs_modulus=2e13"),
        ("impact.speed=0.25", "plate.youngs_modulus=2e13"),
        ("plate.youngs_modulus=2e15",),
        ("impact.speed=2.5", "plate.youngs_modulus=2e15"),
        ("impact.speed=0.25", "plate.youngs_modulus=2e15"),
        ("impact.restitution=0.994", "impact.friction=0.1"),
        ("impact.restitution=0.994", "impact.friction=0.1", "plate.youngs_modulus=2e13"),
    ]
    records = on_all_cores(judged, cases)
    tell(records, "all pass; 1e-6", f"{len(cases)} slow and stiff runs")
    for record in records:
        if record["end"] == "refused":
            continue
        row(
            f"    {' '.join(record['changes'])}",
            "reaction within 5 %",
            f"{record['difference']:.1e}, reaction to {100.0 * record['reaction']:.2g} %, {record['steps']} steps, "
            f"{record['slide']:.4g} m, {record['seconds']:.0f} s",
        )


PARTS = {"realistic": realistic, "predicted": predict, "slender": slender, "slow": slow}
SCENES = {"realistic": 1000, "predicted": 500, "slender": 0, "slow": 0}


def main() -> None:
    """Command line."""
    parser = command_line.parser(__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--scenes", type=int, help="scenes of a part")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    for part in given.parts or list(PARTS):
        began = time.perf_counter()
        PARTS[part](given.scenes or SCENES[part], given.seed)
        print(f"  {part}: {time.perf_counter() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
