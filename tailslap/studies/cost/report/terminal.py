"""The study on standard output."""

from __future__ import annotations

import textwrap
from pathlib import Path

from postprocess.report.terminal import NARROW
from tailslap.studies.cost.points import CostSurvey
from tailslap.studies.cost.report.words import headline, level_table

TITLES = {
    False: "the cheapest setting for an error from the exact rigid motion",
    True: "soft plate: the cheapest setting for an error from its own limit",
}


def print_cost(found: CostSurvey, place: Path) -> None:
    """The cheapest settings for both questions, the headline, and where the files are."""
    for soft in TITLES:
        _print_levels(found, soft)
    print(textwrap.fill(headline(found), NARROW))
    print(f"Report: {place / 'report.html'}")
    print(f"Cost:   {len(found.points)} settings in {found.seconds:.0f} s")


def _print_levels(found: CostSurvey, soft: bool) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    words, title = level_table(found, soft), f"{found.plan.scene.name}: {TITLES[soft]}"
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for column in words.columns:
        table.add_column(column)
    for row in words.rows:
        table.add_row(*map(Text, row))
    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.width = max(console.width if console.is_terminal else 0, 140)
    console.print(table)
