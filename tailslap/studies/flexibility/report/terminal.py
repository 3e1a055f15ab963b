"""The study on standard output."""

from __future__ import annotations

import textwrap
from pathlib import Path

from postprocess.report.terminal import NARROW
from tailslap.studies.flexibility.report.tabulate import start_level_table
from tailslap.studies.flexibility.report.words import headline
from tailslap.studies.flexibility.statements import kept_sentence, soft_sentence, stiff_sentence
from tailslap.studies.flexibility.survey import Survey


def print_flexibility(found: Survey, place: Path) -> None:
    """The headline, the levels, what failed, and where the files are."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    words, name = start_level_table(found), found.sweep.plan.scene.name
    title = f"{name}: lowest first frequency at which the rigid body's answer is good"
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for number, column in enumerate(words.columns):
        table.add_column(column, justify="right" if number else "left", no_wrap=True)
    for row in words.rows:
        table.add_row(*map(Text, row))
    print(textwrap.fill(headline(found), NARROW))
    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.width = max(console.width if console.is_terminal else 0, 130)
    console.print(table)
    for sentence in filter(None, (kept_sentence(found), soft_sentence(found), stiff_sentence(found))):
        print(textwrap.fill(sentence, NARROW))
    print(f"Report: {place / 'report.html'}")
    print(f"Cost:   {len(found.points)} plates in {found.seconds:.0f} s")
