"""What the reports of both calculations have alike: design forces, checks, and the record of the run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from postprocess.report.numbers import duration, grouped, number
from postprocess.report.page import Section
from postprocess.report.table import Column, Table, pairs
from postprocess.signals.design_forces import design_forces
from tailslap.verification.check import Check

if TYPE_CHECKING:
    from tailslap.scene.schema import Scene
    from tailslap.scene.write import SceneInput


def milliseconds(seconds: float) -> str:
    """A time [s] in milliseconds."""
    return f"{1e3 * seconds:.1f}"


PEAKS = (
    Column("what", "Peak lateral force"),
    Column("fe", "FE", "N", form="#.4g", style="strong"),
    Column("rigid", "Rigid", "N", form="#.4g", style="strong"),
)
DESIGN = (
    Column("name", "Design force", style="whole"),
    Column("force", "Lateral", "N", form="#.3g", style="strong"),
    Column("share", "FE over it", form=".2f"),
    Column("source", "Source", style="soft"),
)
CHECKS = (
    Column("name", "Check"),
    Column("value", "Value", form=".3g"),
    Column("limit", "Limit", form=".3g"),
    Column("passed", "Result", form=lambda passed: "passed" if passed else "failed", style="badge"),
    Column("meaning", "What it means"),
)
FAILED = (
    Column("name", "Failed check"),
    Column("value", "Value", form=".3g", style="strong"),
    Column("limit", "Limit", form=".3g"),
    Column("cure", "What to do"),
)
INPUTS = (
    Column("key", "Key", form=lambda key: f"`{key}`"),
    Column("given", "As given", form=lambda given: f"`{given}`" if given else ""),
    Column("value", "Value", form=lambda value: number(value, 6), unit_key="unit"),
    Column("unit", "Unit", is_unit=True),
    Column("origin", "From"),
)
TAIL_SLAP = (
    Column("quantity.title", "Quantity"),
    Column("quantity.symbol", ""),
    Column("fe", "FE", form="#.5g", unit_key="quantity.unit"),
    Column("rigid", "Rigid, exact", form="#.5g", unit_key="quantity.unit"),
    Column("quantity.unit", "Unit", is_unit=True),
    Column("difference", "FE/rigid − 1", form="+.1e", style="strong"),
)
"""Columns of the rows of `comparison_rows`."""

STRIKES = (
    Column("title", "Strike"),
    Column("model", "Model"),
    Column("start", "Start", "ms", form=milliseconds),
    Column("duration", "Duration", "ms", form=milliseconds),
    Column("peak_force", "Peak", "N", form=".1f", style="strong"),
    Column("impulse", "Impulse", "N s", form=".2f"),
    Column("point_of_attack", "Point of attack", "m", form=".2f"),
)
ATTACK = "Point of attack of the mean force, behind the front."
COST: Mapping[str, tuple[str, Callable[[Any], str]]] = {
    "elements": ("elements", grouped),
    "nodes": ("nodes", grouped),
    "points": ("points that may touch", grouped),
    "steps": ("time steps", grouped),
    "time_step": ("time step", duration),
    "setup_s": ("set-up", duration),
    "time_loop_s": ("time loop", duration),
    "pictures_s": ("pictures", duration),
}
"""Sizes and times of a run, as they are told."""


def design_table(scene: Scene, peak: float) -> Table:
    """Design forces of the scene's test level, and the peak force [N] over each; empty without a test level."""
    level = scene.impact.test_level if scene.impact else None
    rows = [
        {
            "name": f"{each.name}, {level}",
            "force": each.force,
            "share": peak / each.force,
            "source": each.source,
        }
        for each in (design_forces(level) if level else ())
    ]
    return Table(DESIGN, rows)


def strikes_table(strikes: Mapping[str, Sequence[Mapping[str, Any]]]) -> Table:
    """Strikes of each model, as its summary has them, in order of time."""
    rows: list[dict[str, Any]] = [
        {"point_of_attack": None, **strike, "model": model, "title": f"{n} {strike['corner']}", "number": n}
        for model, its in strikes.items()
        for n, strike in enumerate(its, 1)
    ]
    return Table(STRIKES, sorted(rows, key=lambda row: row["number"]), notes=(ATTACK,))


def short(table: Table) -> Table:
    """A table for the terminal, without its last column, which is long."""
    return Table(table.columns[:-1], table.rows)


def failed_section(checks: Sequence[Check], cure: Callable[[str], str], diagnosis: Sequence[str]) -> Section:
    """The checks that failed, with what to do against each, and what was found of the cause; empty if none failed."""
    rows = [vars(check) | {"cure": cure(check.name)} for check in checks if not check.passed]
    return Section(
        "Failed checks, and what to do", tables=[Table(FAILED, rows)], sentences=diagnosis if rows else ()
    )


def failed_lines(checks: Sequence[Check], cure: Callable[[str], str], diagnosis: Sequence[str]) -> list[str]:
    """The same for the terminal."""
    failed = [check for check in checks if not check.passed]
    lines = [f"FAILED  {check.name}: {check.value:.3g}, limit {check.limit:.3g}" for check in failed]
    cures = dict.fromkeys(part for check in failed for part in cure(check.name).split("; "))
    return [*lines, f"What to do: {'; '.join(cures)}.", *diagnosis] if lines else []


def passed_text(checks: Sequence[Check]) -> str:
    """How many passed."""
    return f"Checks: {sum(check.passed for check in checks)} of {len(checks)} passed"


def checks_section(checks: Sequence[Check], groups: Mapping[str, str]) -> Section:
    """All checks by the group of each name, which is the title of its table."""
    tables = []
    for title in dict.fromkeys(groups.get(check.name, "Others") for check in checks):
        own = [check for check in checks if groups.get(check.name, "Others") == title]
        marks = {number: "failed" for number, check in enumerate(own) if not check.passed}
        tables.append(Table(CHECKS, own, title, marks=marks))
    return Section(passed_text(checks), tables=tables, is_folded=True)


def record_sections(
    cost: Mapping[str, Any], omitted: Sequence[tuple[str, str]], inputs: Sequence[SceneInput]
) -> list[Section]:
    """Cost, what was left out, and the inputs."""
    told = {COST[name][0]: COST[name][1](value) for name, value in cost.items() if name in COST}
    parts = [{"part": part, "why": why} for part, why in omitted]
    left_out = Table((Column("part", "Part"), Column("why", "Why")), parts)
    return [
        Section("Cost", tables=[pairs(told)], is_folded=True),
        Section("Left out", "" if parts else "Nothing.", tables=[left_out], is_folded=True),
        Section("Inputs", tables=[Table(INPUTS, inputs)], is_folded=True),
    ]
