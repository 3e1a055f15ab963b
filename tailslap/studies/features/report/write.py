"""Writes the study's result folder: page, summary, table of parts, times of each turn."""

from __future__ import annotations

import csv
from dataclasses import asdict
from pathlib import Path
from typing import Any

import tailslap
from postprocess.figures.features_plots import Bar, draw_ratios
from postprocess.files.histories import write_history
from postprocess.files.summary import write_summary
from postprocess.pages.features_page import FeaturesContent, PartRow, ProcessRow, write_features_page
from postprocess.pages.report import Result
from tailslap.studies.features.costs import FEWEST_ROWS, ROWS, Cost, Costs
from tailslap.studies.features.processes import Process
from tailslap.studies.features.report.words import conclusion, headline, ratio_words, statements
from tailslap.studies.features.timing import SEED, Ratio


def write_costs(costs: Costs, folder: Path) -> None:
    """Fill the folder: `report.html`, `features.csv`, `turns.csv`, `summary.json`."""
    write_features_page(folder / "report.html", _content(costs))
    write_table(costs, folder / "features.csv")
    write_history(folder / "turns.csv", costs.table)
    write_summary(folder / "summary.json", summary(costs))


def summary(costs: Costs) -> dict[str, Any]:
    """The numbers of the study."""
    proof = costs.proof
    return {
        "study": "features",
        "scene": costs.plan.scene.name,
        "version": tailslap.__version__,
        "passed": proof.passed,
        "conclusion": conclusion(proof),
        "elements": costs.elements,
        "turns": costs.turns,
        "seed": SEED,
        "proof": {
            "verdict": proof.verdict,
            "program_over_bare": asdict(proof.program),
            "program_over_itself": asdict(proof.noise),
            "limit": proof.limit,
            "difference": proof.difference,
            "steps": proof.steps,
            "bare_ns": asdict(costs.bare),
            "again_ns": asdict(costs.again),
            "bare_instructions": asdict(costs.bare_code),
        },
        "parts": [_numbers(cost) for cost in costs.costs],
        "left_out": [{"part": name, "why": why} for name, why in costs.refused],
        "history": {"row_s": asdict(costs.history.row), "over_loop": asdict(costs.history.loop_share)},
        "wall": {"setup_without_s": asdict(costs.wall[0]), "setup_with_s": asdict(costs.wall[1])},
        "commands": [asdict(process) | {"packages": dict(process.packages)} for process in costs.processes],
        "cost": {"seconds": costs.seconds},
    }


def write_table(costs: Costs, path: Path) -> None:
    """A line a part, every number of it in a column of its own."""
    rows = [_flat(_numbers(cost)) for cost in costs.costs]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)))
        writer.writeheader()
        writer.writerows(rows)


def _numbers(cost: Cost) -> dict[str, Any]:
    return {
        "part": cost.part.name,
        "what": cost.part.what,
        "without": cost.part.without,
        "update_ns": asdict(cost.update),
        "ratio": asdict(cost.ratio) if cost.ratio else None,
        "steps": cost.steps,
        "time_loop_s": cost.loop_s,
        "setup_s": asdict(cost.setup),
        "compile_s": cost.compile_s,
        "code": asdict(cost.code) if cost.code else None,
    }


def _flat(numbers: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in numbers.items():
        flat |= _flat(value, f"{prefix}{key}_") if isinstance(value, dict) else {prefix + key: value}
    return {key: value for key, value in flat.items() if value is not None}


def _content(costs: Costs) -> FeaturesContent:
    return FeaturesContent(
        scene=costs.plan.scene.name,
        version=tailslap.__version__,
        passed=costs.proof.passed,
        headline=headline(costs),
        parts=tuple(_part(cost) for cost in costs.costs),
        proof=_proof(costs),
        beside=_beside(costs),
        processes=tuple(_process(process) for process in costs.processes),
        statements=statements(costs),
        curves=(draw_ratios(_bars(costs)),),
        scene_text=costs.plan.source.text,
    )


def _part(cost: Cost) -> PartRow:
    return PartRow(
        cost.part.name,
        cost.part.what,
        cost.update.best,
        cost.update.median,
        ratio_words(cost.ratio) if cost.ratio else "",
        cost.steps,
        1e3 * cost.loop_s,
        1e3 * cost.setup.best,
        cost.code.instructions if cost.code else None,
        cost.code.vector if cost.code else None,
    )


def _proof(costs: Costs) -> tuple[Result, ...]:
    proof, plain = costs.proof, costs.costs[0]
    assert plain.code is not None
    vector = f"{costs.bare_code.vector} of them on vectors"
    return (
        Result(
            "program's loop, best and median", f"{plain.update.best:.2f}, {plain.update.median:.2f}", "ns"
        ),
        Result("bare loop, best and median", f"{costs.bare.best:.2f}, {costs.bare.median:.2f}", "ns"),
        Result("program's over bare", ratio_words(proof.program)),
        Result("program's over itself", ratio_words(proof.noise), "", "the noise of this machine"),
        Result("limit", round(proof.limit, 3), "", "the whole interval must be above it to fail"),
        Result("positions differ by", f"{proof.difference:.1e}", "of the length"),
        Result(
            "instructions, program's", plain.code.instructions, "", f"{plain.code.vector} of them on vectors"
        ),
        Result("instructions, bare", costs.bare_code.instructions, "", vector),
    )


def _beside(costs: Costs) -> tuple[Result, ...]:
    row, (without, with_wall) = costs.history.row, costs.wall
    return (
        Result(
            "a row of the history", f"{1e6 * row.best:.1f}, {1e6 * row.median:.1f}", "µs", "best and median"
        ),
        Result(
            f"{ROWS} rows instead of {FEWEST_ROWS}",
            ratio_words(costs.history.loop_share),
            "loops",
            "times the time loop of the plain scene",
        ),
        Result("set-up without a wall", f"{1e3 * without.best:.1f}", "ms", "best"),
        Result("set-up with the wall's mesh", f"{1e3 * with_wall.best:.1f}", "ms", "best"),
    )


def _process(process: Process) -> ProcessRow:
    return ProcessRow(
        f"tailslap {process.name}",
        process.seconds.best,
        process.seconds.median,
        process.modules,
        process.import_s,
        ", ".join(f"{name} {value:.2f} s" for name, value in process.packages),
    )


def _bars(costs: Costs) -> tuple[Bar, ...]:
    named: list[tuple[str, Ratio | None]] = [(cost.part.name, cost.ratio) for cost in costs.costs]
    named += [("plain, over itself", costs.proof.noise), ("plain, over the bare loop", costs.proof.program)]
    bars = [Bar(name, ratio.median, ratio.low, ratio.high) for name, ratio in named if ratio]
    return tuple(sorted(bars, key=lambda bar: -bar.ratio))
