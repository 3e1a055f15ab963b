"""The tables and the sentence of a run, from its summary: of one just made, or of one in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from postprocess.comparison.comparison import KEYS, comparison_rows
from postprocess.report.table import Column, Table

COMPARISON = (
    Column("quantity.title", "Quantity"),
    Column("quantity.unit", "Unit"),
    Column("fe", "FE", form=".7g"),
    Column("rigid", "Rigid, exact", form=".7g"),
    Column("difference", "FE/rigid − 1", form="+.2e"),
)
STRIKES = (
    Column("corner", "Strike"),
    Column("model", "Model"),
    Column("start", "Start", "s", form=".4f"),
    Column("duration", "Duration", "s", form=".4f"),
    Column("peak_force", "Peak", "N", form=".4g"),
    Column("impulse", "Impulse", "N s", form=".4g"),
)
FAILED = (
    Column("name", "Failed check"),
    Column("value", "Value", form=".3g"),
    Column("limit", "Limit", form=".3g"),
    Column("meaning", "What it means"),
)


def run_tables(summary: Mapping[str, Any]) -> dict[str, Table]:
    """What was found, and the checks that failed."""
    found = _strikes(summary) if "strikes" in summary["fe"] else _comparison(summary)
    failed = [check for check in summary["checks"] if not check["passed"]]
    return found | ({"Failed checks": Table(FAILED, failed)} if failed else {})


def run_headline(summary: Mapping[str, Any]) -> str:
    """The verdict; of a whole impact its forces."""
    if "verdict" in summary:
        return str(summary["verdict"])
    fe, rigid = (summary[model]["peaks"]["mean_50ms"] for model in ("fe", "rigid"))
    count = len(summary["fe"]["strikes"])
    return f"Peak lateral force {_kn(fe)} as a 50 ms mean (rigid vehicle {_kn(rigid)}); {count} strikes."


def _kn(force: float | None) -> str:
    return "unknown" if force is None else f"{force / 1e3:.0f} kN"


def _comparison(summary: Mapping[str, Any]) -> dict[str, Table]:
    fe, rigid = summary["fe"], summary["rigid"]
    if any(fe[key] is None for key in KEYS):
        return {}
    return {"At the tail-slap": Table(COMPARISON, comparison_rows(fe, rigid, None))}


def _strikes(summary: Mapping[str, Any]) -> dict[str, Table]:
    rows = [
        {"model": label, **strike}
        for label, model in (("FE", "fe"), ("rigid", "rigid"))
        for strike in summary[model]["strikes"]
    ]
    return {"Strikes": Table(STRIKES, rows)}
