"""Columns of a `Cell`: a printed number, the computed one, and how far they are apart."""

from __future__ import annotations

from functools import partial

from postprocess.report.numbers import percent
from postprocess.report.table import Column, Form


def printed(key: str, form: Form = "g", group: str = "") -> Column:
    """The printed number of the cell at `key`."""
    return Column(f"{key}.printed", "printed", form=form, style="soft", group=group)


def computed(key: str, form: Form = "#.5g", group: str = "", decimals: int = 3) -> tuple[Column, Column]:
    """The computed number, and its difference in per cent with so many decimals."""
    difference = partial(percent, decimals=decimals)
    return (
        Column(f"{key}.computed", "computed", form=form, group=group),
        Column(f"{key}.difference", "diff.", form=difference, style="strong", group=group),
    )
