"""A sweep on standard output."""

from __future__ import annotations

from pathlib import Path

from tailslap.sweep.complete import Sweep
from tailslap.sweep.folder import TABLE
from tailslap.sweep.progress import clock
from tailslap.sweep.report.words import counts


def print_sweep(sweep: Sweep, place: Path) -> None:
    """How many rows have each status, what the runs took, and where the files are."""
    print(f"{sweep.definition.scene}: {sweep.definition.runs} runs, {counts(sweep)}")
    print(f"Table:  {place / TABLE}")
    print(f"Report: {place / 'report.html'}")
    print(f"Cost:   {_cost(sweep)}")


def _cost(sweep: Sweep) -> str:
    effort = sweep.effort
    if not effort.runs:
        return "nothing was left to run"
    return (
        f"{effort.runs} runs on {effort.threads} workers in {clock(effort.wall_s)}, {effort.rate:.3g} runs/s, "
        f"{1e3 * effort.overhead_s:.1f} ms a run beyond the runs themselves"
    )
