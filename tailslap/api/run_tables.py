"""The tables and the sentence of a run, from its summary: of one just made, or of one in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from postprocess.comparison.comparison import KEYS, comparison_rows
from postprocess.report.table import Table
from tailslap.report.parts import CHECKS, TAIL_SLAP, strikes_table

COMPARISON = tuple(replace(c, form=".7g") if c.key in ("fe", "rigid") else c for c in TAIL_SLAP)


def run_tables(summary: Mapping[str, Any]) -> dict[str, Table]:
    """What was found, and the checks that failed."""
    strikes = {label: summary[model].get("strikes") for label, model in (("FE", "fe"), ("rigid", "rigid"))}
    found = {"Strikes": strikes_table(strikes)} if strikes["FE"] is not None else _comparison(summary)
    failed = [check for check in summary["checks"] if not check["passed"]]
    return found | ({"Failed checks": Table(CHECKS, failed)} if failed else {})


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
