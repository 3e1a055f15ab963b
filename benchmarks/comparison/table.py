"""Table of peers.py in Markdown."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

from comparison.entries import SAME_MODEL, Entry, apart

COLUMNS = (
    *("code", "error", "masses", "flexibility", "apart", "whole [s]", "least to greatest"),
    *("rest [s]", "set-up [s]", "loop [s]", "remark"),
)
VALUES = ("at the tail-slap", "t [s]", "v_GX [m/s]", "v_GY [m/s]", "omega [rad/s]", "slide [m]")
LEGEND = """\
error: largest relative difference of t, v_GX, v_GY, omega and slide from the exact rigid motion at the tail-slap
masses: the part by the rotary inertia of row-sum masses, the difference of a rigid body that has it
flexibility: the difference from that body, above all the ringing of a plate that starts unstressed (of rigid bodies:
the integration); in the error the two may cancel in part
apart: largest relative distance from the other codes that run the same model: same mesh, time step, row-sum masses,
exact corner, unstressed start
whole: time of the process on the clock, median; rest: of that, start of the interpreter, imports, results, end"""


def cells(entry: Entry, entries: Sequence[Entry]) -> tuple[str, ...]:
    """Return a row as text."""
    wholes = sorted(turn.whole for turn in entry.turns)
    spread = f"{wholes[0]:.2f} to {wholes[-1]:.2f}" if len(wholes) > 1 else ""
    count = len(entry.turns)
    remark = entry.why_not or f"{entry.turns[-1].remark}; {count} round{'s' * (count > 1)}"
    about = "" if entry.values is not None or entry.why_not else "about "
    errors = (entry.error, entry.by_masses if entry.values is not None else math.nan, entry.by_flexibility)
    return (
        *(entry.code, *(_size(error) for error in (*errors, apart(entry, entries)))),
        *(about + _seconds(entry.median("whole")), spread),
        *(*(_seconds(entry.median(part)) for part in ("rest", "setup", "loop")), remark),
    )


def _size(error: float) -> str:
    return "" if math.isnan(error) else "0" if error == 0.0 else f"{error:.1e}"


def _seconds(spent: float) -> str:
    return "" if math.isnan(spent) else f"{spent:.3g}" if spent < 100.0 else f"{spent:.0f}"


def agreement(entries: Sequence[Entry]) -> str:
    """Return the largest distance of codes of the same model."""
    ended = [entry for entry in entries if entry.code in SAME_MODEL and entry.values is not None]
    if len(ended) < 2:
        return ""
    names = ", ".join(entry.code for entry in ended)
    largest = max(apart(entry, ended) for entry in ended)
    return f"{names}: at most {largest:.1e} apart; their errors are those of the model"


def ratios(entries: Sequence[Entry]) -> str:
    """Return our time over the others', empty without others."""
    ours, *rest = entries
    texts = []
    for other in (entry for entry in rest if not entry.code.startswith("tailslap")):
        both = [a.whole / b.whole for a, b in zip(ours.turns, other.turns, strict=False)]
        about = "about " if other.values is None else ""
        texts += [f"{other.code} {about}{statistics.median(both):.2g}"] if both else []
    return f"whole time of {ours.code} over that of: {', '.join(texts)}" if texts else ""


def values_rows(members: Sequence[Entry]) -> list[tuple[str, ...]]:
    """Return the quantities of each code, below the exact ones."""
    named = [("exact", members[0].exact), *((entry.code, entry.values) for entry in members)]
    return [(name, *(f"{value:.10g}" for value in values)) for name, values in named if values is not None]


def markdown(entries: Sequence[Entry], head: str) -> str:
    """Return a table of each mesh."""
    meshes: dict[str, list[Entry]] = {}
    for entry in entries:
        meshes.setdefault(entry.mesh.title if entry.mesh else "rigid bodies", []).append(entry)
    parts = [head]
    for title, members in meshes.items():
        rows = [COLUMNS, ("---",) * len(COLUMNS), *(cells(entry, entries) for entry in members)]
        values = [VALUES, ("---",) * len(VALUES), *values_rows(members)]
        remarks = [text for text in (agreement(members), ratios(members)) if text]
        parts += [f"**{title}**", _piped(rows), *remarks, _piped(values)]
    return "\n\n".join([*parts, LEGEND.replace("\n", "  \n")]) + "\n"


def _piped(rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
