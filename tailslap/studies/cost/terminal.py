"""The study on standard output."""

from __future__ import annotations

import textwrap
from pathlib import Path

from tailslap.studies.cost.survey import CostSurvey
from tailslap.studies.cost.words import headline, level_table
from tailslap.tables import NARROW


def print_cost(found: CostSurvey, place: Path) -> None:
    """The cheapest settings, the headline, and where the files are."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    words = level_table(found, "error")
    title = f"{found.plan.scene.name}: the cheapest setting for an error from the exact rigid motion"
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for column in words.columns:
        table.add_column(column)
    for row in words.rows:
        table.add_row(*map(Text, row))
    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.width = max(console.width if console.is_terminal else 0, 130)
    console.print(table)
    print(textwrap.fill(headline(found), NARROW))
    print(f"Report: {place / 'report.html'}")
    print(f"Cost:   {len(found.points)} settings in {found.seconds:.0f} s")
