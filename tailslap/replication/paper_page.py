"""Lay out the page of `tailslap paper`.

It has the numbers of `paper_numbers`, and the curves of Figures 10 to 14. docs/paper.md explains how to read them.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

import tailslap
from postprocess.comparison.quantities import QUANTITIES, ComparedQuantity
from postprocess.figures.histories import COMPARED, TIME, History, thinned
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Form, Table, columns, pairs
from postprocess.svg import chart, marks
from postprocess.units import MPH, percent, percent_up
from tailslap import progress
from tailslap.arguments import checked_arguments
from tailslap.case.report_parts import footer
from tailslap.replication import paper_numbers, paper_values
from tailslap.replication.paper_numbers import FIGURES, Numbers
from tailslap.replication.paper_values import KM_PER_HOUR, START
from tailslap.result.result import Result, of_report

PAGE = "paper.html"
NAMES = {"theta": ComparedQuantity("theta", "Angle between side PE and the wall", "θ", "rad"), **QUANTITIES}
CAPTIONS = {
    "theta": "Dynamic rotation angle θ",
    "v_gy": "Linear velocity v_GY, negative towards the wall",
    "v_gx": "Linear velocity v_GX",
    "omega": "Angular velocity ω",
    "slide": "Distance s",
}
DIFFERENCE = "diff. = computed/printed - 1."
PLOTTED = (
    "drag: exact motion with friction μ_k |N| from the printed initial state; none: without friction. Markers: printed "
    "values; paper: initial state and analytical column of Table 3 (Figure 10: t = 0.38 s of Section 3.1.1); ABAQUS: "
    "ABAQUS column of Table 3."
)
AXES = (
    " SI units; X along the wall, in the direction of travel, Y away from it; ω positive as the rear rotates towards "
    "the wall."
)

MOTION_STYLES: Any = ({"colour": "rigid", "width": 3.2}, {"colour": "fe", "width": 1.6, "dashes": "5 3"})
MARK_STYLES: Any = tuple({"colour": colour, "width": 0.0, "dots": 3.6} for colour in ("ink", "difference"))
"""Styles of the first and the second motion, and of the two kinds of mark."""


@checked_arguments
def paper() -> Result:
    """Compare the tables and figures of the paper with computed values.

    Returns
    -------
    Result
        `summary` contains printed value, computed value and difference of each cell, as `tailslap paper --json`.

    Examples
    --------
    >>> import tailslap
    >>> result = tailslap.paper()
    >>> result.summary["table_3"]["analytical"]["v_gy"]["printed"]
    -3.274
    """
    with progress.announced("Computing the paper's tables ..."):
        return of_report("paper", paper_report(paper_numbers.review()), scene="", page_name=PAGE)


def paper_report(numbers: Numbers) -> Report:
    """Report the numbers with the curves of Figures 10 to 14."""
    courses = {name: paper_numbers.course(name) for name in ("drag", "none")}
    parts = sections(numbers, courses)
    off = max(abs(numbers["table_3"]["analytical"][name]["difference"]) for name in ("v_gy", "v_gx", "slide"))
    title = "The paper's tables and figures, computed beside printed"
    answer = f"Velocities and slide of Table 3's analytical column are reproduced within {percent_up(off)}."
    headline = Headline(title, answer, f"{paper_values.PAPER}.", DIFFERENCE)
    page = Page("Replication", headline, parts, footer() + AXES, contents=True)
    curves = {f"figures_10_to_14_{name}.csv": course for name, course in courses.items()}
    return Report(page, summary(numbers), parts, histories=curves)


def summary(numbers: Numbers) -> Numbers:
    """Return the summary in SI, without the curves of the figures."""
    inputs = paper_values.INPUTS
    return {
        "version": tailslap.__version__,
        "paper": paper_values.PAPER,
        "inputs": {i.name: {"given": i.given, "value": i.value, "unit": i.unit} for i in inputs},
        "start": paper_values.START,
        **numbers,
    }


def sections(numbers: Numbers, courses: Mapping[str, History]) -> tuple[Section, ...]:
    """Return the sections in the paper's order.

    Earlier methods and assumptions are last.
    """
    row_b = numbers["row_b"]
    tables_by_title = {
        "Table 1. MASH TL-4 (SUT) impact requirements": table_1(numbers["table_1"]),
        "Table 3. Comparison of FEA and analytical results": table_3(numbers["table_3"]),
        "Figures 10 to 14. Histories of the motion": figure_tables(numbers["figures"]),
        "Table 4. TL-4 peak lateral impact force, 50 ms average": force_tables(numbers["table_4"], row_b[0]),
        "Table 5. TL-4 peak lateral impact force, SAE-filtered data": force_tables(
            numbers["table_5"], row_b[1], True
        ),
        "Earlier methods. Olson, Hirsch and Ritter (Section 2.1)": earlier_tables(numbers["earlier"]),
        "Assumptions. Restitution, tensile reaction, effective mass": (
            _restitution_table(numbers),
            *_impact_tables(numbers["whole_impact"]),
            _stages_table(numbers),
        ),
    }
    parts = [Section(title, tables=content) for title, content in tables_by_title.items()]
    parts[2] = replace(parts[2], lead=PLOTTED, figures=[figure(*item, courses) for item in FIGURES.items()])
    return tuple(parts)


def printed(key: str, form: Form = "g", group: str = "") -> Column:
    """Return the column of a printed value."""
    return Column(f"{key}.printed", "printed", form=form, style="soft", group=group)


def computed(key: str, form: Form = "#.5g", group: str = "", decimals: int = 3) -> tuple[Column, Column]:
    """Return columns of computed value and difference."""
    difference = partial(percent, decimals=decimals)
    return (
        Column(f"{key}.computed", "computed", form=form, group=group),
        Column(f"{key}.difference", "diff.", form=difference, style="strong", group=group),
    )


def scaled(factor: float, form: str) -> Callable[[float], str]:
    """Return the format of a number in units of `factor`."""
    return lambda value: format(value / factor, form)


def table_1(numbers: Numbers) -> tuple[Table, Table]:
    """Return tables of the inputs, and of Stage 1 from both speeds.

    Stage 1 is compared with the printed start of Stage 2.
    """
    heads = (
        *columns({"title": "Input", "symbol": ""}),
        Column("given", "printed", form=str, style="soft"),
        Column("value", "SI", form=".7g"),
        *columns({"unit": "", "place": "source"}),
    )
    derived = (
        ("gamma", "γ", "Corner angle, atan(B/L)", "rad", "Eq 63"),
        ("phi", "φ", "Angle between wall and PG, θ + γ", "rad", "Eq 63"),
        ("beta", "β", "Direction of the impulse, atan(1/μ_k)", "rad", "Eq 7"),
        ("corner_radius", "r_PG", "Distance from the corner to the centre of mass", "m", "Eq 15"),
        ("moment_of_inertia", "I_G", "Moment of inertia", "kg m²", "Eq 26"),
    )
    follows = (
        paper_values.Input(key, symbol, title, "", numbers["derived"][key], unit, place)
        for key, symbol, title, unit, place in derived
    )
    starts = (
        Column("from", "Stage 1"),
        *computed("omega", ".6f", "ω_0 [rad/s]"),
        *computed("corner_speed", ".6f", "v_P0 [m/s]"),
        *computed("lateral_speed", scaled(KM_PER_HOUR, ".3f"), "v_0 sin θ [km/h]"),
    )
    rows = [{"from": name, **start} for name, start in numbers["starts"].items()]
    speed = numbers["implied_speed"]
    note = (
        f"Printed: ω_0 = {START['omega']:g} rad/s, v_P0 = {START['corner_speed']:g} m/s, v_0 sin θ = "
        f"{paper_values.LATERAL_SPEED / KM_PER_HOUR:g} km/h. This v_P0 corresponds to {speed:.4f} m/s "
        f"({speed / MPH:.3f} mph, {speed / KM_PER_HOUR:.3f} km/h)."
    )
    title = "Initial state of Stage 2, computed from 56 mph and from 90 km/h"
    inputs = Table(heads, (*paper_values.INPUTS, *follows), "Inputs and derived quantities")
    return inputs, Table(starts, rows, title, (note,))


def table_3(numbers: Numbers) -> tuple[Table, Table]:
    """Return the tables of both columns of Table 3.

    The analytical column is beside the motion with friction from three starts, the ABAQUS column beside both motions.
    """
    start, force = START, numbers["peak_force"]
    analytical = {"analytical": "as printed", "analytical_56": "from 56 mph", "analytical_15": "56 mph, 15°"}
    abaqus = {
        "abaqus": "none, θ = 0",
        "abaqus_read": f"none, {numbers['reading']:g} s",
        "abaqus_drag": "drag, same s",
    }
    notes = (
        'Exact motion with friction μ_k |N| ("drag", Eqs 66-67) at θ = 0. As printed: initial state of the paper, '
        f"θ_0 = {start['angle']:g} rad, ω_0 = {start['omega']:g} rad/s, v_P0 = {start['corner_speed']:g} m/s. From 56 "
        "mph: ω_0 and v_P0 by Stage 1, θ_0 as printed. 56 mph, 15°: θ_0 = 15 deg. The paper prints the magnitude of "
        "v_GY.",
        f"Peak force 2 m |v_GY|/Δt (Eqs 72-73) for Δt = 0.1 s: {force['computed'] / 1e3:.1f} kN from the printed "
        f"start, {force['printed'] / 1e3:.1f} kN from the printed v_GY.",
    )
    note = (
        'Motion without friction ("none") from the printed initial state at θ = 0 and at an earlier time; last, motion '
        f"with friction at the printed slide of {paper_values.ABAQUS['slide']:g} m."
    )

    def table(title: str, columns: dict[str, str], notes: tuple[str, ...]) -> Table:
        heads = [
            Column("quantity.label", "", below=Column("quantity.title", "")),
            printed(next(iter(columns))),
            *(column for name, group in columns.items() for column in computed(name, group=group)),
        ]
        order = ("t", "v_gy", "v_gx", "omega", "slide")
        rows = [{"quantity": NAMES[name], **{key: numbers[key][name] for key in columns}} for name in order]
        return Table(tuple(heads), rows, title, notes)

    return table("Analytical column", analytical, notes), table("ABAQUS column", abaqus, (note,))


def figure(number: int, name: str, courses: Mapping[str, History]) -> chart.Chart:
    """Draw one of Figures 10 to 14.

    Motions are lines, printed points markers.
    """
    panel = next(panel for panel in COMPARED if panel.name == name)
    lines: list[tuple[str, Any]] = [(label, thinned(c["t"], c[name])) for label, c in courses.items()]
    points = [(label, np.transpose(pairs)) for label, pairs in paper_numbers.marks(name).items() if pairs]
    styles = [*zip(lines, MOTION_STYLES, strict=False), *zip(points, MARK_STYLES, strict=False)]
    curves = [marks.Line(label, *places, **style) for (label, places), style in styles]
    plot = chart.Plot(tuple(curves), chart.Axis(f"{panel.symbol} [{panel.unit}]"), 200.0)
    return chart.Chart(name, f"Figure {number}. {CAPTIONS[name]}.", (plot,), TIME, panel.group)


def figure_tables(numbers: Numbers) -> tuple[Table, Table]:
    """Return tables of the values read from charts, and the exact motion."""
    readings = (
        Column("figure", "Figure"),
        Column("quantity", "quantity", form=lambda name: NAMES[name].label),
        Column("where", "read at", form=str),
        printed("value"),
        *computed("value"),
    )
    note = "Computed: exact motion with friction from the printed initial state."
    decimals = {"theta": 4, "v_gy": 4, "v_gx": 3, "omega": 5, "slide": 4}
    heads = (
        Column(name, NAMES[name].symbol, NAMES[name].unit, f"z.{decimals[name]}f", group=f"Fig. {number}")
        for number, name in FIGURES.items()
    )
    instants = (Column("t", "t", "s", ".4f"), *heads)
    values = paper_numbers.course("drag", np.array(numbers["instants"]))
    rows = [dict(zip(values, row, strict=True)) for row in zip(*values.values(), strict=True)]
    read = Table(readings, numbers["readings"], "Values read from the charts of the paper", (note,))
    return read, Table(instants, rows, "Exact motion with friction")


def force_tables(rows: Sequence[Numbers], row_b: Numbers, repeated: bool = False) -> tuple[Table, Table]:
    """Return tables of peak forces and adjustment factors.

    They are those of Table 4 or 5, with the ratio of the forces for e = 0 and e = 0.22. row_b: with the speed and angle
    of its test. repeated: True if the notes are those of the previous table.
    """
    source = f"row b, computed with {paper_values.ROW_B_GIVEN} of its test MNCBR-1 (test report)"
    marked = row_b | {"printed": row_b["printed"] | {"row": "b*", "source": source}}
    lines, exact = [*rows[:2], marked, *rows[2:]], f"{row_b['ratio']['computed']:.4f}"
    _, ratio = computed("ratio", group="ratio", decimals=1)
    forces = (
        Column("printed.row", "Row"),
        Column("printed.duration", "Δt", "s", "g"),
        *_pair("peak", scaled(1e3, "g"), scaled(1e3, ".1f")),
        printed("ratio", ".4f", "ratio"),
        replace(ratio, label=f"/ {exact[:5]} - 1"),
    )
    factors = (
        Column("printed.row", "Row"),
        Column("printed.measured", "measured", "kN", scaled(1e3, "g"), style="soft"),
        *_pair("factor", ".2f", ".3f"),
    )
    notes: tuple[str, ...] = (
        "; ".join(f"{line['printed']['row']}: {line['printed']['source']}" for line in lines) + ".",
        "Mass, speed and length of the six vehicles are not in the paper. Computed: vehicle and impact of Table 1 "
        "(9979 kg, 10 m x 2.438 m, 56 mph, 15 deg) with the duration Δt of the row, without adjustment.",
        f"ratio: F(e = 0)/F(e = 0.22), which is 1/(1 - e) = {exact} for any vehicle.",
    )
    if repeated:
        notes = ("Rows and computation as in Table 4; the analytical columns of rows a to e are the same.",)
    note = "φ_a: analytical force divided by the force of the crash test or simulation."
    projected = ", ".join(line["printed"]["row"] for line in rows if line["printed"]["projected"])
    by_authors = (
        f"Measured forces of rows {projected}: projected by the authors as 1.33 times the 50 ms average."
    )
    return (
        Table(forces, lines, "Peak lateral force in kN", notes),
        Table(factors, lines, "Adjustment factor φ_a", (note, by_authors) if projected else (note,)),
    )


def _pair(key: str, first: Form, second: Form) -> Iterator[Column]:
    """Yield columns of the printed and computed values for both restitutions."""
    for i, e in enumerate(paper_values.RESTITUTIONS):
        yield printed(f"{key}.{i}", first, f"e = {e:g}")
        yield from computed(f"{key}.{i}", second, f"e = {e:g}", 1)


def earlier_tables(numbers: Numbers) -> tuple[Table]:
    """Return the lateral force by four methods."""
    heads = (
        *columns({"method": "Method", "what": ""}),
        Column("force", "force", "kN", scaled(1e3, ".1f")),
        Column("to_paper", "difference", form=partial(percent, decimals=1), style="strong"),
    )
    methods = (
        ("Olson", "Average force, Eqs 1-2", "olson"),
        ("Hirsch", "Peak force, Eq 3", "hirsch"),
        ("Ritter", "Peak force, Eqs 4-5", "ritter"),
        ("Chuong and Malla", "Peak force of the tail-slap, Eqs 6-73", "paper"),
    )
    rows = [
        {
            "method": name,
            "what": what,
            "force": numbers[key],
            "to_paper": numbers[key] / numbers["paper"] - 1.0,
        }
        for name, what, key in methods
    ]
    notes = (
        f"56 mph, {math.degrees(numbers['angle']):g} deg, 9979 kg. Assumed: A_L = {numbers['front_distance']:g} m "
        f"(half the length), B = {numbers['half_width']:g} m (half the width, as in Olson's report), D = "
        f"{numbers['deflection']:g}. Travel of the centre of mass: {numbers['travel']:.4f} m in t = "
        f"{numbers['time']:.4f} s. Chuong and Malla: e = 0.22, Δt = 0.1 s. Differences are relative to Chuong and "
        "Malla.",
        "The two expressions of Eq 1 differ because t follows from half the lateral speed: V_I sin θ/(2 g t) yields "
        f"{numbers['olson_first_member'] / 1e3:.1f} kN; Olson's expression, used here, {numbers['olson'] / 1e3:.1f} "
        "kN.",
    )
    return (Table(heads, rows, "Lateral force", notes),)


def _restitution_table(numbers: Numbers) -> Table:
    """Return the peak force by the definition of restitution."""
    signs = (
        Column("sign", "Restitution"),
        Column("corner_recoil", "corner after Stage 1", "m/s", "z.3f"),
        Column("omega", "ω_0", "rad/s", ".4f"),
        Column("peak_force", "peak force", "kN", scaled(1e3, ".1f")),
        Column("change", "difference", form=partial(percent, decimals=1), style="strong"),
    )
    names = {"paper": "paper, 1 - e", "newton": "Newton, 1 + e"}
    rows = [{"sign": names.get(name, name), **case} for name, case in numbers["restitution"].items()]
    return Table(signs, rows, "Definition of restitution, at 56 mph")


def _impact_tables(whole: Numbers) -> tuple[Table, Table]:
    """Return tables of the whole impact by crush stiffness."""
    stiffness = Column("stiffness", "k", "MN/m", scaled(1e6, "g"))
    impact = (
        stiffness,
        Column("omega", "ω", "rad/s", ".4f", group="first strike"),
        Column("released", "end", "s", ".4f", group="first strike"),
        Column("gap", "gap", "m", ".3f", group="front corner"),
        Column("back", "next contact", "s", ".4f", group="front corner"),
        Column("rear_start", "start", "s", ".4f", group="rear strike"),
        Column("rear_impulse", "impulse", "kN s", scaled(1e3, ".2f"), group="rear strike"),
        Column("share", "m_eff/m", form=".4f", group="rear strike"),
    )
    labels = {"rear_duration": "strike", "read.mean_50ms": "50 ms mean", "read.cfc60": "CFC 60"}
    peak = Column("rear_peak", "raw peak force", "kN", scaled(1e3, ".1f"))
    durations = (stiffness, *columns(labels, "ms", scaled(1e-3, ".1f")), peak)
    solved = "Rigid vehicle, e = 0.22, μ_k = 0.47; unilateral contact with crush at the corners."
    share = "m_eff/m: impulse / ((1 + e) m v_E), with the normal velocity v_E of the rear corner."
    read = "Durations by the rule of the paper: between the minima around the second peak."
    title = "Duration of the rear strike, computed and read from filtered forces"
    return (
        Table(impact, whole["cases"], "Whole impact, by crush stiffness k of a corner", (solved, share)),
        Table(durations, whole["cases"], title, (read,)),
    )


def _stages_table(numbers: Numbers) -> Table:
    """Return the corresponding values of Stages 1 to 3."""
    whole, pull, rigid = numbers["whole_impact"], numbers["reaction"], paper_numbers.NEARLY_RIGID / 1e6
    stages = (
        ("Stage 1, ω_0 with 1 - e", whole["omegas"]["paper"], "rad/s"),
        ("Stage 1, ω_0 with 1 + e", whole["omegas"]["newton"], "rad/s"),
        (f"First strike, ω for k = {rigid:g} MN/m", whole["nearly_rigid"], "rad/s"),
        ("Stage 2, initial reaction N", pull["first"], "N"),
        ("Stage 2, N at the tail-slap", pull["last"], "N"),
        ("Stage 2, time of the tail-slap", whole["paper_time"], "s"),
        ("Stage 3, impulse m v_GY", whole["paper_impulse"], "N s"),
        ("Stage 3, impulse m v_GY for e = 0", whole["plastic_impulse"], "N s"),
        ("Rear corner, impulse m_eff 2 v_GY for e = 0", whole["corner_impulse"], "N s"),
        ("Rear corner, m_eff/m", whole["share"], ""),
        ("Rear corner, m_eff/m with friction", whole["share_friction"], ""),
    )
    return pairs(stages, title="Corresponding values of Stages 1 to 3")
