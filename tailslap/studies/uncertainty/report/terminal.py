"""The study on standard output."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

from tailslap.report.tables import NARROW
from tailslap.studies.uncertainty.model import Array
from tailslap.studies.uncertainty.report.words import headline, order, range_words, refusals, value_words
from tailslap.studies.uncertainty.spread import Spread

if TYPE_CHECKING:
    from rich.table import Table


def print_spread(spread: Spread, place: Path) -> None:
    """The table of inputs and indices, the distribution, what was refused, and where the files are."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.width = max(console.width if console.is_terminal else 0, NARROW)
    console.print(_table(spread))
    for sentence in (headline(spread), refusals(spread)):
        console.print(textwrap.fill(sentence, NARROW))
    console.print(f"Report: {place / 'report.html'}")
    console.print(f"Cost:   {spread.samples.combinations} combinations in {spread.seconds:.2f} s")


def _table(spread: Spread) -> Table:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    title, indices = f"{spread.plan.scene.name}: Sobol indices of the peak force", spread.indices
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("input", "range", "scene's value", "alone", "with interactions"):
        table.add_column(name, justify="left" if name == "input" else "right", no_wrap=True)
    for i in order(spread):
        item = spread.samples.ranges[i]
        table.add_row(
            *(Text(words) for words in (item.key, range_words(item), value_words(item))),
            _index(indices.first[i], indices.first_interval[:, i]),
            _index(indices.total[i], indices.total_interval[:, i]),
        )
    return table


def _index(value: float, ends: Array) -> str:
    """The index and half its 95 % interval."""
    return f"{value:.3f} ± {(ends[1] - ends[0]) / 2.0:.3f}"
