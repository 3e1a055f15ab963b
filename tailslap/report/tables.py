"""What the commands print on standard output."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from tailslap.planning.plan import Plan
from tailslap.report.omitted_parts import left_out

if TYPE_CHECKING:
    from rich.table import Table

    from tailslap.planning.fe_plan import FePlan
    from tailslap.run import Outcome

NARROW = 96
"""Columns where standard output is no terminal."""


def print_outcome(outcome: Outcome, place: Path) -> None:
    """The comparison, the checks that failed, where the files are, and what it cost."""
    for line in (
        _drawn(_comparison(outcome)),
        *_picked(outcome),
        *(f"Chosen: {decision.shown}" for decision in outcome.fe_plan.decisions),
        *_verdict(outcome),
        f"Report: {place / 'report.html'}",
    ):
        print(line)
    print(
        f"Cost:   {outcome.run.steps} steps in {outcome.run.time_loop_s:.3f} s, "
        f"set-up {outcome.setup_s:.2f} s, pictures {outcome.pictures_s:.2f} s"
    )


def _picked(outcome: Outcome) -> list[str]:
    choice = outcome.choice
    if choice is None:
        return []
    return [f"Picked: {', '.join(choice.changes)}; expected error {choice.expected_error:.1e}"]


def _verdict(outcome: Outcome) -> list[str]:
    from tailslap.verification.verdict import verdict_sentence

    failed = [check for check in outcome.checks if not check.passed]
    lines = [
        f"FAILED  {check.name}: {check.value:.3g}, limit {check.limit:.3g} ({check.meaning})"
        for check in failed
    ]
    if failed:
        lines += chosen_lines(outcome.fe_plan)
    count = f"Checks: {len(outcome.checks) - len(failed)} of {len(outcome.checks)} passed"
    return [*lines, f"{verdict_sentence(outcome)} {count}"]


def _drawn(table: Table) -> str:
    """The table as text: captured, for rich would end the program itself when the reader of a pipe leaves."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.width = max(console.width if console.is_terminal else 0, NARROW)
    with console.capture() as shown:
        console.print(table)
    return shown.get().rstrip("\n")


def _comparison(outcome: Outcome) -> Table:
    from rich.table import Table
    from rich.text import Text

    from tailslap.report.write import table_rows

    rows = table_rows(outcome)
    paper = any(row.paper_analytical is not None for row in rows)
    table = Table(title=f"{outcome.fe_plan.plan.scene.name} at the tail-slap", title_justify="left")
    table.add_column("")
    for name in (
        "FE",
        "rigid, exact",
        "FE/rigid - 1",
        *(("paper, analytical", "paper, ABAQUS") if paper else ()),
    ):
        table.add_column(name, justify="right")
    for row in rows:
        printed = (row.paper_analytical, row.paper_abaqus) if paper else ()
        table.add_row(
            Text(f"{row.quantity.symbol} [{row.quantity.unit}]"),
            f"{row.fe:.7g}",
            f"{row.rigid:.7g}",
            f"{row.difference:+.1e}",
            *("" if value is None else f"{value:g}" for value in printed),
        )
    return table


def rigid_part(plan: Plan, pictures: bool = True) -> list[str]:
    """Lines of `tailslap check` that need no mesh."""
    start, strike = plan.start, plan.motion.strike
    lines = [
        f"{plan.scene.name}: the scene is valid",
        f"start        angle {start.angle:.6g} rad, omega {start.omega:.6g} rad/s, "
        f"corner speed {start.corner_speed:.6g} m/s"
        + ("" if plan.stage1 is None else " (see `tailslap rigid`)"),
        f"reaction     {plan.scene.corner.reaction}, friction {plan.scene.corner_friction:g}",
        f"tail-slap    expected at {strike.t:.6g} s after {strike.slide:.5g} m of sliding",
    ]
    return lines + [f"left out     {part}: {why}" for part, why in left_out(plan.scene, pictures)]


def fe_part(fe_plan: FePlan) -> list[str]:
    """Lines of `tailslap check` on the finite-element run."""
    from tailslap.planning.fe_plan import UPDATES_PER_SECOND

    model, steps = fe_plan.model, fe_plan.expected_steps
    elements = model.loop.table.connectivity.shape[1]
    seconds = steps * elements / UPDATES_PER_SECOND
    return [
        f"plate        {elements} elements, {model.loop.mass.size} nodes, {model.mass:.1f} kg, "
        f"{fe_plan.plate.element}, {fe_plan.plate.lumping} masses, {fe_plan.plate.start} start",
        f"stiffness    {_stiffness(fe_plan)}",
        f"corner       {_hold(model.loop.corner)}",
        f"frequency    {model.highest_frequency:.6g} rad/s, the highest, by Lanczos with the corner's spring",
        f"time step    {model.loop.time_step:.4g} s, {model.loop.time_step / model.stable_time_step:.2f} of the "
        f"stable {model.stable_time_step:.4g} s",
        f"steps        {steps}, about {seconds:.2g} s in the time loop "
        f"(at {UPDATES_PER_SECOND:.0e} element updates a second)",
        f"flexibility  the reaction moves the centre by {fe_plan.give:.1e} of its way: expect differences of that size",
    ]


def chosen_lines(fe_plan: FePlan) -> list[str]:
    """What the program chose where the scene leaves it open, and what it foretells of flutter."""
    from tailslap.verification.verdict import flutter_sentence

    chosen = [f"chosen       {decision.shown}" for decision in fe_plan.decisions]
    return [*chosen, f"flutter      {flutter_sentence(fe_plan)}"]


def _stiffness(fe_plan: FePlan) -> str:
    """The modulus, and the first frequency of the free plate in its plane."""
    modulus, frequency = fe_plan.plate.youngs_modulus, fe_plan.first_frequency
    return (
        f"Young's modulus {modulus:.6g} Pa, first frequency of the free plate in its plane {frequency:.4g} Hz"
    )


def _hold(corner: Any) -> str:
    where = "one node" if len(corner.nodes) == 1 else f"a patch of {len(corner.nodes)} nodes"
    stiffness = getattr(corner.hold, "stiffness", None)
    return (
        f"{where}, held exactly" if stiffness is None else f"{where}, penalty stiffness {stiffness:.4g} N/m"
    )
