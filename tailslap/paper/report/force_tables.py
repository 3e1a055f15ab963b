"""Tables 4 and 5 and the earlier methods: what stands in their columns."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from postprocess.report.numbers import percent
from postprocess.report.table import Column, Table
from tailslap.paper.earlier import EarlierMethods
from tailslap.paper.forces import ForceResult
from tailslap.paper.printed import RESTITUTIONS, ROW_B_GIVEN
from tailslap.paper.report.columns import computed, printed

GROUPS = tuple(f"e = {restitution:g}" for restitution in RESTITUTIONS)
KNOWN = f"row b, computed with the {ROW_B_GIVEN} of its test, MNCBR-1 (from the test's report)"


def _kilo(form: str) -> Callable[[float], str]:
    return lambda force: format(force / 1e3, form)


ROW = Column("printed.row", "Row")
FORCES = (
    ROW,
    Column("printed.duration", "Δt", "s", "g"),
    *(printed("peak.0", _kilo("g"), GROUPS[0]), *computed("peak.0", _kilo(".1f"), GROUPS[0], 1)),
    *(printed("peak.1", _kilo("g"), GROUPS[1]), *computed("peak.1", _kilo(".1f"), GROUPS[1], 1)),
    printed("ratio", ".4f", "ratio"),
)
FACTORS = (
    ROW,
    Column("printed.measured", "measured", "kN", _kilo("g"), style="soft"),
    *(printed("factor.0", ".2f", GROUPS[0]), *computed("factor.0", ".3f", GROUPS[0], 1)),
    *(printed("factor.1", ".2f", GROUPS[1]), *computed("factor.1", ".3f", GROUPS[1], 1)),
)
METHODS = (
    Column("method", "Method"),
    Column("what", ""),
    Column("force", "force", "kN", _kilo(".1f")),
    Column("to_paper", "to the paper's", form=partial(percent, decimals=1), style="strong"),
)


def force_table(rows: tuple[ForceResult, ...], known: ForceResult, repeated: bool = False) -> Table:
    """Peak forces of Table 4 or 5, and how those for e = 0 and e = 0.22 are to each other.

    repeated: the notes are those of the table before.
    """
    exact, lines = f"{rows[0].ratio.computed:.4f}", _with_known(rows, known)
    _, ratio = computed("ratio", group="ratio", decimals=1)
    legend = "; ".join(f"{line.printed.row}: {line.printed.source}" for line in lines) + "."
    notes = (REPEATED,) if repeated else (legend, *_notes(exact))
    return Table((*FORCES, replace(ratio, label=f"to {exact[:5]}")), lines, "Peak lateral force in kN", notes)


REPEATED = "Rows and computation as in Table 4, whose analytical columns the paper repeats in rows a to e."


def _notes(exact: str) -> tuple[str, ...]:
    return (
        "The paper gives neither mass nor speed nor length of the six vehicles. Computed are therefore the vehicle "
        "and impact of Table 1 (9979 kg, 10 m x 2.438 m, 56 mph, 15 deg) with the row's duration Δt. What the "
        "row's own vehicle and impact do is in the difference; nothing was adjusted to match.",
        f"ratio: F(e = 0)/F(e = 0.22), which the method makes 1/(1 - e) = {exact} for any vehicle.",
    )


def factor_table(rows: tuple[ForceResult, ...], known: ForceResult) -> Table:
    """Adjustment factors of Table 4 or 5."""
    projected = ", ".join(result.printed.row for result in rows if result.printed.projected)
    notes = ["φ_a is the analytical force over that of the crash test or simulation."]
    if projected:
        notes.append(
            f"Measured forces of rows {projected}: projected by the authors, 1.33 times the 50 ms average."
        )
    return Table(FACTORS, _with_known(rows, known), "Adjustment factor φ_a", tuple(notes))


def earlier_table(result: EarlierMethods) -> Table:
    """The four methods on the vehicle of Table 1."""
    forces = (
        ("Olson", "Average force, Eqs 1-2", result.olson),
        ("Hirsch", "Peak force, Eq 3", result.hirsch),
        ("Ritter", "Peak force, Eqs 4-5", result.ritter),
        ("Chuong and Malla", "Peak force of the tail-slap, Eqs 6-73", result.paper),
    )
    rows = [
        {"method": method, "what": what, "force": force, "to_paper": force / result.paper - 1.0}
        for method, what, force in forces
    ]
    notes = (
        f"At 56 mph and {math.degrees(result.angle):g} deg, 9979 kg. Assumed, since the paper gives no numbers: "
        f"A_L = {result.front_distance:g} m, half the length; B = {result.half_width:g} m, half the width, as in "
        f"Olson's report; D = {result.deflection:g}. The centre of mass then travels {result.travel:.4f} m in "
        f"t = {result.time:.4f} s. The paper's own method: e = 0.22, Δt = 0.1 s.",
        "The members of Eq 1 are not equal: as t follows from half the lateral speed, the first, V_I sin θ/(2 g t), "
        f"gives {result.olson_first_member / 1e3:.1f} kN, the last, which is Olson's and is used here, "
        f"{result.olson / 1e3:.1f} kN.",
    )
    return Table(METHODS, rows, "Lateral force", notes)


def _with_known(rows: tuple[ForceResult, ...], known: ForceResult) -> list[ForceResult]:
    """The rows; after row b the one that is computed with the speed and angle of its test."""
    marked = replace(known, printed=replace(known.printed, row="b*", source=KNOWN))
    return [*rows[:2], marked, *rows[2:]]
