"""The study on standard output."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

from postprocess.report.terminal import NARROW
from tailslap.studies.features.costs import Cost, Costs
from tailslap.studies.features.report.words import conclusion, ratio_words

if TYPE_CHECKING:
    from rich.table import Table


def print_costs(costs: Costs, place: Path) -> None:
    """The table of parts, whole commands, the conclusion, and where the files are."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.width = max(console.width if console.is_terminal else 0, NARROW)
    console.print(_table(costs))
    for process in costs.processes:
        console.print(
            f"{process.name:<18} {process.seconds.best:6.2f} s, {process.modules:5d} modules, "
            f"imports {process.import_s:.2f} s"
        )
    console.print(textwrap.fill(conclusion(costs.proof), NARROW))
    console.print(f"Report: {place / 'report.html'}")
    console.print(f"Cost:   {costs.turns} turns, {costs.seconds:.0f} s")


def _table(costs: Costs) -> Table:
    from rich import box
    from rich.table import Table

    title = f"{costs.plan.scene.name}: what each part of the time loop costs"
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("part", "ns an update", "times the loop without", "steps", "loop [s]", "code"):
        table.add_column(name, justify="left" if name == "part" else "right", no_wrap=True)
    for cost in costs.costs:
        table.add_row(*_row(cost))
    table.add_row("bare loop", f"{costs.bare.median:.1f}", "", "", "", str(costs.bare_code.instructions))
    return table


def _row(cost: Cost) -> tuple[str, ...]:
    return (
        cost.part.name,
        f"{cost.update.median:.1f}",
        ratio_words(cost.ratio) if cost.ratio else "",
        str(cost.steps),
        f"{cost.loop_s:.3g}",
        str(cost.code.instructions) if cost.code else "",
    )
