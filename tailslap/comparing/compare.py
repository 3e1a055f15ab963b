"""Function `compare` of `import tailslap`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path

from tailslap.arguments import checked_arguments
from tailslap.comparing.compare_report import compare_items, compare_report
from tailslap.comparing.validation import with_validation
from tailslap.result.columns import Columns
from tailslap.result.result import Result, of_report


@checked_arguments
def compare(
    reference: Result | str | os.PathLike[str],
    *results: Result | str | os.PathLike[str],
    columns: Mapping[str, str] | str | None = None,
    only: Sequence[str] = (),
    author: str = "",
    decimal_commas: Sequence[int] = (),
    force: bool = False,
) -> Result:
    """Compare histories with a reference.

    The result has differences, Sprague-Geers metrics, residuals, and the validation by NCHRP W179.

    Parameters
    ----------
    reference : Result or path
        Result of a run, its folder, a text file with columns: a history from ABAQUS, LS-DYNA or a test; an ISO-MME
        channel; a Parquet file of this program; or nodes of CalculiX (.dat), LS-DYNA (nodout), ABAQUS (field output
        report) or OpenRadioss (CSV of th_to_csv).
    *results : Result or path
        Results, folders or files that are compared with the reference.
    columns : mapping or str, optional
        Column names of the files by names of this program: {"time": "t", "v_gy": "-VY [mph]"}; a minus reverses the
        sign, a unit in brackets holds for a file without one. Default: SI. A column without a name has its number; a
        name for one result alone follows its number, from 1: {"2:time": "t [ms]"}.
    only : sequence of str
        Columns to compare. Default: main and mapped columns in common, and those that this program does not have.
    author : str
        Name on the page `validation.html`. Default: a blank to fill in.
    decimal_commas : sequence of int
        Numbers of the results, from 1, that are text files with decimal commas.
    force : bool
        Read the intact files of damaged or modified results.

    Returns
    -------
    Result
        `summary["compared"]` contains the metrics by label and column, `summary["notes"]` what is assumed, is missing,
        or hardly shows in them, `summary["not_compared"]` other columns with the reason; `passed` is True if all are
        within the limits of NCHRP W179 over half of the reference's time.

    Raises
    ------
    InputError
        For unreadable or damaged results, cells without a number, columns of different dimensions, or no common column.

    Examples
    --------
    >>> import tailslap
    >>> soft = tailslap.run("paper-table-3", {"plate.youngs_modulus": "20 GPa"})
    >>> tailslap.compare(tailslap.run("paper-table-3"), soft).passed
    True
    """
    items = (reference, *results)
    comparison = compare_items(items, columns, only, force, decimal_commas)
    page = with_validation(compare_report(comparison), comparison, author)
    histories = {item.label: Columns(item.columns, item.units) for item in comparison.items}
    tables = {"Metrics": page.tables["metrics.csv"]}
    inputs = chain(*(item.inputs if isinstance(item, Result) else (Path(item),) for item in items))
    return of_report("compare", page, tables=tables, histories=histories, inputs=tuple(inputs))
