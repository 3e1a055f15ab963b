"""Tables 4 and 5 and the earlier methods as tables of text."""

from __future__ import annotations

import math

from postprocess.pages.paper_page import DIFFERENT, PRINTED, Column, Row, Table
from tailslap.paper.earlier import EarlierMethods
from tailslap.paper.forces import ForceResult
from tailslap.paper.printed import RESTITUTIONS, ROW_B_GIVEN
from tailslap.paper.report.text import cells, columns, fixed, percent

KILO = fixed(1, 1e3)
GROUPS = tuple(f"e = {restitution:g}" for restitution in RESTITUTIONS)
KNOWN = f"row b, computed with the {ROW_B_GIVEN} of its test, MNCBR-1 (from the test's report)"


def force_table(rows: tuple[ForceResult, ...], known: ForceResult, repeated: bool = False) -> Table:
    """Peak forces of Table 4 or 5, and how those for e = 0 and e = 0.22 are to each other.

    repeated: the notes are those of the table before.
    """
    exact = f"{rows[0].ratio.computed:.4f}"
    lines = [_forces(result, result.printed.row) for result in rows]
    lines.insert(2, _forces(known, "b*", KNOWN))
    heads = (Column("Δt [s]"), *(head for group in GROUPS for head in columns(group)))
    heads += (Column("printed", PRINTED, "ratio"), Column(f"to {exact[:5]}", DIFFERENT, "ratio"))
    return Table(
        "Peak lateral force in kN", "Row", heads, tuple(lines), (REPEATED,) if repeated else _notes(exact)
    )


REPEATED = (
    "Computed as for Table 4. The analytical columns of rows a to e repeat those of Table 4 in the paper."
)


def _notes(exact: str) -> tuple[str, ...]:
    return (
        "The paper gives neither mass nor speed nor length of the six vehicles. Computed are therefore the vehicle "
        "and impact of Table 1 (9979 kg, 10 m x 2.438 m, 56 mph, 15 deg) with the row's duration Δt. What the "
        "row's own vehicle and impact do is in the difference; nothing was adjusted to match.",
        f"ratio: F(e = 0)/F(e = 0.22), which the method makes 1/(1 - e) = {exact} for any vehicle.",
    )


def factor_table(rows: tuple[ForceResult, ...], known: ForceResult) -> Table:
    """Adjustment factors of Table 4 or 5."""
    lines = [_factors(result, result.printed.row) for result in rows]
    lines.insert(2, _factors(known, "b*"))
    heads = (Column("measured [kN]", PRINTED), *(head for group in GROUPS for head in columns(group)))
    notes = ["φ_a is the analytical force over that of the crash test or simulation."]
    if any(result.printed.projected for result in rows):
        notes.append("*: projected by the authors, 1.33 times the 50 ms average.")
    return Table("Adjustment factor φ_a", "Row", heads, tuple(lines), tuple(notes))


def earlier_table(result: EarlierMethods) -> Table:
    """The four methods on the vehicle of Table 1."""
    forces = (
        ("Olson", "Average force, Eqs 1-2", result.olson),
        ("Hirsch", "Peak force, Eq 3", result.hirsch),
        ("Ritter", "Peak force, Eqs 4-5", result.ritter),
        ("Chuong and Malla", "Peak force of the tail-slap, Eqs 6-73", result.paper),
    )
    rows = (
        Row(name, (f"{force / 1e3:.1f}", percent(force / result.paper - 1.0, 1)), "", title)
        for name, title, force in forces
    )
    heads = (Column("force [kN]"), Column("to the paper's", DIFFERENT))
    notes = (
        f"At 56 mph and {math.degrees(result.angle):g} deg, 9979 kg. Assumed, since the paper gives no numbers: "
        f"A_L = {result.front_distance:g} m, half the length; B = {result.half_width:g} m, half the width, as in "
        f"Olson's report; D = {result.deflection:g}. The centre of mass then travels {result.travel:.4f} m in "
        f"t = {result.time:.4f} s. The paper's own method: e = 0.22, Δt = 0.1 s.",
        "The members of Eq 1 are not equal: as t follows from half the lateral speed, the first, V_I sin θ/(2 g t), "
        f"gives {result.olson_first_member / 1e3:.1f} kN, the last, which is Olson's and is used here, "
        f"{result.olson / 1e3:.1f} kN.",
    )
    return Table("Lateral force", "Method", heads, tuple(rows), notes, spelled=True)


def _forces(result: ForceResult, head: str, title: str = "") -> Row:
    row = result.printed
    texts = [f"{row.duration:g}"]
    for cell in result.peak:
        texts += cells(cell, KILO, 1, f"{cell.printed / 1e3:g}")
    texts += [f"{result.ratio.printed:.4f}", percent(result.ratio.difference, 1)]
    return Row(head, tuple(texts), "", title or row.source)


def _factors(result: ForceResult, head: str) -> Row:
    row = result.printed
    texts = [f"{row.measured / 1e3:g}{'*' if row.projected else ''}"]
    for cell in result.factor:
        texts += cells(cell, fixed(3), 1, f"{cell.printed:.2f}")
    return Row(head, tuple(texts))
