"""Accuracy of runs of random and extreme vehicles, beside the required values.

    .venv/bin/python benchmarks/vehicles.py [realistic] [slender] [slow] [--scenes 1000] [--seed 1]

realistic   random vehicles of 4 to 19 m, 10 to 35 m/s, 5 to 30 deg, friction 0.05 to 0.8, the rest as in mash-tl4-sut
slender     widths of 0.01 to 0.03 of the length, stiffness x 0.1 to 1 000, friction to 1.3, 20 x 6 elements, against a
            finer run with the exact constraint
slow        speeds to 0.01 times, stiffness to 10 000 times, slides of over a kilometre

"Beyond flexibility": difference from the rigid motion less the part due to the plate's flexibility.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable
from typing import Any

import command_line
import numpy as np
from command_line import corner_case, on_all_cores, row

SCENE = "mash-tl4-sut"
STIFF, STIFFER, GRAZING = *(f"plate.youngs_modulus=2e{n}" for n in (13, 15)), "impact.restitution=0.994"
SLOW = (
    *(("impact.speed=0.25",), ("impact.speed=2.5", STIFF), ("impact.speed=0.25", STIFF), (STIFFER,)),
    *(("impact.speed=2.5", STIFFER), ("impact.speed=0.25", STIFFER), (GRAZING, "impact.friction=0.1")),
    (GRAZING, "impact.friction=0.1", STIFF),
)
Record = dict[str, Any]


def plan_of(changes: tuple[str, ...]) -> Any:
    """Return the case with changes, on a wall of sufficient length."""
    return corner_case(SCENE, "wall=", *changes)


def realistic_changes(seed: int, number: int) -> tuple[str, ...]:
    """Draw a vehicle as it may come."""
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


def judged(changes: tuple[str, ...]) -> Record:
    """Run the scene as the program decides."""
    from postprocess.comparison.quantities import largest
    from tailslap.case.check import failed_names
    from tailslap.case.corner.corner_run import run_corner
    from tailslap.errors import InputError

    try:
        outcome = run_corner(plan_of(changes))
    except InputError as error:
        return {"end": "refused", "failed": str(error), "changes": changes}
    normal, rigid = (h["reaction_normal"] for h in (outcome.fe_history, outcome.rigid_history))
    finite = np.isfinite(rigid)
    ripple = np.sqrt(np.mean((normal - rigid)[finite] ** 2) / np.mean(rigid[finite] ** 2))
    difference = largest(outcome.difference)
    return {
        "end": "passed" if outcome.passed else "failed",
        "failed": failed_names(outcome.checks),
        "beyond": max(0.0, difference - outcome.error.flexibility) if outcome.fe else math.inf,
        "difference": difference,
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


def against_finer(changes: tuple[str, ...]) -> Record:
    """Run the scene, and compare with more, quadratic elements."""
    record = judged((*changes, "plate.elements=[20, 6]"))
    finer = judged((*changes, "plate.elements=[30, 4]", "plate.element=quad9"))
    record |= {"from_finer": math.inf, "finer_failed": finer["failed"]}
    if record.get("values") and finer.get("values"):
        pairs = [(value, finer["values"][name]) for name, value in record["values"].items()]
        record["from_finer"] = max(abs(ours / theirs - 1.0) for ours, theirs in pairs)
    return record


def summarise(records: list[Record], required: str, what: str) -> None:
    """Print ends, failures and the largest figures."""
    run = [record for record in records if record["end"] != "refused"]
    ends = Counter(record["end"] for record in records)
    most = {name: f"{max(r[name] for r in run):.1e}" for name in ("beyond", "difference", "error")}
    row(f"{what}: ends", required, ", ".join(f"{count} {end}" for end, count in ends.items()))
    row("  largest difference from rigid beyond flexibility", "", most["beyond"])
    text = f"{most['difference']}; {most['error']}"
    row("  largest difference; largest numerical error stated", "", text)
    repeated = sum(r["attempts"] > 1 for r in run)
    row("  damped by the program; run again with more", "", f"{sum(r['damped'] for r in run)}; {repeated}")
    for record in records:
        if record["end"] != "passed":
            print("   ", record["end"], record["failed"], *record["changes"])


def realistic(scenes: int, seed: int) -> None:
    """Print the figures of random vehicles."""
    records = on_all_cores(judged, [realistic_changes(seed, number) for number in range(scenes)])
    summarise(records, "1e-4", f"{scenes} realistic vehicles")


def slender(*_: int) -> None:
    """Print the figures of widths, stiffnesses and frictions on a grid."""
    grid = itertools.product((0.1, 0.2, 0.3), (2e10, 2e11, 4.3e12, 2e14), (0.05, 0.47, 1.3))
    keys = ("vehicle.width", "plate.youngs_modulus", "corner.friction")
    changes = [tuple(f"{key}={value}" for key, value in zip(keys, values, strict=True)) for values in grid]
    records = on_all_cores(against_finer, changes)
    summarise(records, "1e-3", f"{len(records)} slender plates")
    passed = sorted((r for r in records if r["end"] == "passed"), key=lambda r: -r["from_finer"])
    row("  largest distance from the finer run, of those that pass", "1e-3", f"{passed[0]['from_finer']:.1e}")
    for r in passed[:5]:
        print(f"    {r['from_finer']:.1e} {r['difference']:.1e}", r["finer_failed"], *r["changes"])


def slow(*_: int) -> None:
    """Print the figures of slow, stiff and long runs."""
    records = on_all_cores(judged, SLOW)
    summarise(records, "1e-6", f"{len(SLOW)} slow and stiff runs")
    for r in records:
        if r["end"] != "refused":
            reaction = f"{r['difference']:.1e}, reaction to {100.0 * r['reaction']:.2g} %"
            text = f"{reaction}, {r['steps']} steps, {r['slide']:.4g} m, {r['seconds']:.0f} s"
            row(f"    {' '.join(r['changes'])}", "5 %", text)


PARTS: dict[str, Callable[[int, int], None]] = {"realistic": realistic, "slender": slender, "slow": slow}

if __name__ == "__main__":
    options = command_line.options(__doc__, ("parts", PARTS), scenes=1000, seed=1)
    for part in options.parts:
        PARTS[part](options.scenes, options.seed)
