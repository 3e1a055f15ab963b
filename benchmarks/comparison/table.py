"""The table of peers.py, on the terminal and in Markdown."""

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
masses: what of it the rotary inertia of row-sum masses makes: the difference of a rigid body that has it
flexibility: the difference from that body, above all the ringing of a plate that starts unstressed (of rigid bodies:
the integration); in the error the two may cancel in part
apart: largest relative distance from the other codes that run the same model: same mesh, time step, row-sum masses,
exact corner, unstressed start
whole: time of the process on the clock, median; rest: of that, start of the interpreter, imports, results, end"""


def cells(entry: Entry, entries: Sequence[Entry]) -> tuple[str, ...]:
    """A row as text."""
    wholes = sorted(turn.whole for turn in entry.turns)
    spread = f"{wholes[0]:.2f} to {wholes[-1]:.2f}" if len(wholes) > 1 else ""
    count = len(entry.turns)
    remark = entry.why_not or f"{entry.turns[-1].remark}; {count} round{'s' * (count > 1)}"
    about = "" if entry.values is not None or entry.why_not else "about "
    errors = (entry.error, entry.by_masses if entry.values is not None else math.nan, entry.by_flexibility)
    return (
        entry.code,
        *(_size(error) for error in (*errors, apart(entry, entries))),
        about + _seconds(entry.median("whole")),
        spread,
        *(_seconds(entry.median(part)) for part in ("rest", "setup", "loop")),
        remark,
    )


def _size(error: float) -> str:
    return "" if math.isnan(error) else "0" if error == 0.0 else f"{error:.1e}"


def _seconds(spent: float) -> str:
    return "" if math.isnan(spent) else f"{spent:.3g}" if spent < 100.0 else f"{spent:.0f}"


def groups(entries: Sequence[Entry]) -> list[tuple[str, list[Entry]]]:
    """Rows of each mesh, with its title."""
    found: dict[str, list[Entry]] = {}
    for entry in entries:
        found.setdefault(entry.mesh.title if entry.mesh else "rigid bodies", []).append(entry)
    return list(found.items())


def agreement(entries: Sequence[Entry]) -> str:
    """How far the codes that run the same model are apart, in words; empty where fewer than two have ended."""
    ended = [entry for entry in entries if entry.code in SAME_MODEL and entry.values is not None]
    if len(ended) < 2:
        return ""
    names = ", ".join(entry.code for entry in ended)
    largest = max(apart(entry, ended) for entry in ended)
    return f"{names}: at most {largest:.1e} apart; their errors are those of the model"


def ratios(entries: Sequence[Entry]) -> str:
    """How many times the others' whole time ours is, medians over the rounds; empty without others."""
    ours, *rest = entries
    found = []
    for other in (entry for entry in rest if not entry.code.startswith("tailslap")):
        both = [a.whole / b.whole for a, b in zip(ours.turns, other.turns, strict=False)]
        about = "about " if other.values is None else ""
        found += [f"{other.code} {about}{statistics.median(both):.2g}"] if both else []
    return f"whole time of {ours.code} over that of: {', '.join(found)}" if found else ""


def remarks(members: Sequence[Entry]) -> list[str]:
    """List the remarks below the rows of a mesh."""
    return [text for text in (agreement(members), ratios(members)) if text]


def values_rows(members: Sequence[Entry]) -> list[tuple[str, ...]]:
    """The five quantities of each code that has them, below those of the exact rigid motion."""
    named = [("exact", members[0].exact), *((entry.code, entry.values) for entry in members)]
    return [(name, *(f"{value:.10g}" for value in values)) for name, values in named if values is not None]


def terminal_text(entries: Sequence[Entry]) -> str:
    """The table in columns."""
    rows = [cells(entry, entries) for entry in entries]
    widths = [max(map(len, column)) for column in zip(COLUMNS, *rows, strict=True)]
    by_entry = dict(zip(map(id, entries), rows, strict=True))
    lines = [_padded(COLUMNS, widths)]
    for title, members in groups(entries):
        lines += ["", title, *(_padded(by_entry[id(entry)], widths) for entry in members)]
        lines += remarks(members)
    return "\n".join([*lines, "", LEGEND, "", *_values_lines(entries)])


def _values_lines(entries: Sequence[Entry]) -> list[str]:
    widths = [max(len(entry.code) for entry in entries), *(5 * [14]), 0]
    lines = [_padded((*VALUES, ""), widths)]
    for title, members in groups(entries):
        lines += ["", title, *(_padded((*row, ""), widths) for row in values_rows(members))]
    return lines


def _padded(row: Sequence[str], widths: Sequence[int]) -> str:
    first, *rest = zip(row, widths, strict=True)
    last = rest.pop()[0]
    return "  ".join([first[0].ljust(first[1]), *(text.rjust(width) for text, width in rest), last]).rstrip()


def markdown(entries: Sequence[Entry], head: str) -> str:
    """The same for a document: a table of each mesh."""
    parts = [head]
    for title, members in groups(entries):
        rows = [COLUMNS, ("---",) * len(COLUMNS), *(cells(entry, entries) for entry in members)]
        values = [VALUES, ("---",) * len(VALUES), *values_rows(members)]
        parts += [f"**{title}**", _piped(rows), *remarks(members), _piped(values)]
    return "\n\n".join([*parts, LEGEND.replace("\n", "  \n")]) + "\n"


def _piped(rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
