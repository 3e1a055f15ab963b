"""Results and other histories side by side."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from postprocess.files.summary import plain
from tailslap.api.columns import Columns
from tailslap.api.result import Result, filled_by


def compare(
    reference: Result | str | os.PathLike[str],
    *others: Result | str | os.PathLike[str],
    columns: Mapping[str, str] | str | None = None,
    only: Sequence[str] = (),
) -> Result:
    """Set histories beside a reference: differences, Sprague and Geers' metrics, residuals.

    Parameters
    ----------
    reference : Result or path
        A run, its result folder, or a file with named columns: a history of ABAQUS, LS-DYNA or a test.
    *others : Result or path
        What is compared with it, likewise.
    columns : mapping or str, optional
        What columns of files are called, by this program's names: {"time": "t", "v_gy": "-VY [mph]"}; a minus turns the
        sign, a unit in brackets is the file's. Without a unit in file or mapping SI is assumed.
    only : sequence of str
        Columns to compare; without any, the usual ones in common.

    Returns
    -------
    Result
        `summary["compared"]` has the metrics by label and column; `passed` says whether all are within the limits of
        NCHRP W179.

    Raises
    ------
    InputError
        For what cannot be read, or has no column in common.

    Examples
    --------
    >>> import tailslap
    >>> soft = tailslap.run("paper-table-3", {"plate.youngs_modulus": "20 GPa"})
    >>> tailslap.compare(tailslap.run("paper-table-3"), soft).passed
    True
    """
    from tailslap.comparing.report import compare_items, compare_report, headline, metrics_table, summary

    found = compare_items((reference, *others), columns, only)
    return Result(
        "compare",
        " · ".join(item.label for item in found.items),
        plain(summary(found)),
        headline(found),
        found.within,
        {"Metrics": metrics_table(found)},
        {item.label: Columns(item.columns, item.units) for item in found.items},
        fill=filled_by(lambda folder, pictures: compare_report(found)),
    )
