"""Page, summary and tables of the study of cost."""

import math
from typing import Any, NamedTuple

import numpy as np

from postprocess.comparison.quantities import QUANTITIES
from postprocess.figures.studies import Series, draw_precision
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns, listed
from postprocess.svg.chart import Chart
from postprocess.svg.scales import power_text
from postprocess.units import duration, known, measure, percent_up
from tailslap.case.report import study_page, study_summary
from tailslap.studies.cost import compute
from tailslap.studies.cost.compute import FE, LEVELS, CostResult, Row, cheapest, front, is_valid, own_error

ERROR, VALUE = known(".1e"), known(".9g")
SETTINGS = (
    *columns({"setting": "Setting", "checks": "Checks"}),
    *columns({"error": "Error", "added": "Added"}, form=ERROR),
    *columns({"seconds": "Time", "loop_s": "Time loop"}, form=duration),
    Column("steps", "Steps", form="d"),
)
LINES = (
    Column("label", "Line"),
    *columns({"coarsest": "Coarsest", "finest": "Finest"}, form=ERROR),
    Column("order", "Order", form=known(".1f")),
)
GRIDS = (
    *columns({"symbol": "Quantity", "behaviour": "Values"}),
    *columns({"values.2": "Coarse", "values.1": "Medium", "values.0": "Fine"}, form=VALUE),
    Column("extrapolated", "Extrapolated", form=VALUE),
    Column("order", "Order", form=known(".2f")),
    Column("gci_fine", "GCI fine", form=ERROR),
)
FILES = "points.csv (all settings, in SI); summary.json"
NOTE = (
    "Error: relative to the exact rigid motion, or to the mesh-converged solution of the soft plate. Added: "
    "additional error of a setting on the same mesh. Times: minimum of several runs, without compilation. "
    "Highlighted: settings on the Pareto front."
)
READING = (
    "GCI: grid convergence index (Roache 1994, ASME V&V 20) of three meshes, refinement ratio 2, safety factor 1.25 "
    "or 3.",
    "v_GY does not converge for a corner supported at one node, whose compliance grows with the logarithm of the "
    "element size; it converges with `corner.patch_length`.",
)


class Question(NamedTuple):
    """Diagram: name and title; labels of error, front and reference; kind and name of the methods compared with finite
    elements; labels of the groups drawn as lines."""

    name: str
    title: str
    error: str
    methods: tuple[str, str]
    lines: dict[str, str]
    front: str = "Pareto front"
    truth: str = "limit"


RIGID = Question(
    "precision-rigid",
    "(a) Error relative to the exact rigid motion",
    "error relative to the exact rigid motion",
    (compute.ODE, "SciPy"),
    {"exact": "exact solution", **{name: name for name in (*compute.INTEGRATORS, compute.MODES)}}
    | {compute.MESH: "FE, meshes of quad4", compute.ROWSUM: f"FE, {compute.ROWSUM}"}
    | {compute.UNSTRESSED: f"FE, {compute.UNSTRESSED}", compute.PENALTY: "FE, penalty scales"}
    | {compute.SINGLE: f"FE, {compute.SINGLE}"},
    "Pareto front without the exact solution",
    "exact solution",
)
CHOICES = {compute.PENALTY: "penalty scales", compute.DAMPING: "damping", compute.STEP: "time steps"}
SOFT = Question(
    "precision-flexible",
    "(b) Error of a soft plate relative to its converged solution",
    "error relative to the converged solution",
    (compute.MODAL, "soft plate, modes"),
    {name: name for name in (*compute.REFINED, compute.SPRING)} | CHOICES | {compute.MODES: "modes"},
)
IMPACT = Question(
    "precision",
    "Error relative to the converged solution",
    "error of both strikes relative to the converged solution",
    (compute.ODE, compute.RIGID),
    {compute.RIGID: compute.RIGID, "quad4": "meshes of quad4", "quad9": "meshes of quad9"}
    | {compute.STEP: "time steps", compute.DAMPING: "damping"},
)


def report(found: CostResult) -> Report:
    """Report of the study."""
    kicker, answer, certainty, best, sections = (_impact if found.case.scene.contact else _corner)(found)
    sections.append(Section("Every setting", tables=(_every(found.rows),)))
    title = f"Error against run time: {found.case.subject}"
    headline = Headline(title, answer, found.case.set_up, certainty)
    page = study_page(found.case, kicker, headline, sections, FILES)
    cost = f"Cost:   {len(found.rows)} settings in {found.seconds:.0f} s"
    return Report(page, summary(found), (*best, cost), {"points.csv": listed(found.rows)})


def _corner(found: CostResult) -> tuple[str, str, str, tuple[Table, ...], list[Section]]:
    rigid, soft = found.of(soft=False), found.of(soft=True)
    limit, mesh_limit = found.limit.known, found.mesh_limit.known
    best = _best(RIGID, rigid), _best(SOFT, soft)
    answer = (
        f"Finite elements reproduce the rigid-body motion within {_quickest(rigid)}; the exact solution takes "
        f"{duration(found.rows[0]['seconds'])}. They compute the motion of a soft plate, which differs from the rigid "
        f"one by {percent_up(found.flexibility)}, within {_quickest(soft)}."
    )
    certainty = f"The limit of fine meshes of the soft plate is known within {percent_up(limit)}."
    frequency, patch, _ = compute.soft_plate(found.case.scene)
    meshes = [row["label"] for row in soft if row["group"] == "quad9"]
    limits = (
        f"Soft plate: first frequency {frequency:g} Hz, corner supported over {measure(patch, 'm', 'g')}, no friction, "
        "no damping, the same modulus on all meshes.",
        f"Error relative to the Richardson extrapolation of quad9 ({', '.join(meshes[-3:])}), whose uncertainty is "
        f"{limit:.0e} (largest GCI); smaller errors are shown at this value.",
        f"Lines marked (added): additional error of one setting on the same mesh, with an uncertainty of "
        f"{mesh_limit:.0e}. Residual ringing after inertia relief masks the order of the time step and the convergence "
        "of the linear modes.",
    )
    orders = lines(SOFT, soft, limit, mesh_limit)
    order_table = Table(LINES, orders, "Observed order of convergence")
    grids = []
    for group, each in found.convergence.items():
        rows = [{"symbol": QUANTITIES[name].symbol, **vars(grid)} for name, grid in each.items()]
        grids.append(Table(GRIDS, rows, group[0].upper() + group[1:]))
    drawn = charts(SOFT, soft, limit, mesh_limit)
    sections = [
        Section("Rigid motion", "", charts(RIGID, rigid, compute.ROUNDING), best[:1]),
        Section("Flexible plate", "", drawn, (order_table, best[1]), limits),
        Section("Grid convergence", tables=grids, sentences=READING),
    ]
    return "All methods and settings of the program", answer, certainty, best, sections


def _impact(found: CostResult) -> tuple[str, str, str, tuple[Table, ...], list[Section]]:
    rows, rigid, known_to = found.rows, found.rows[0], found.limit.known
    best = (_best(IMPACT, rows),)
    answer = (
        f"Finite elements compute both strikes within {_quickest(rows)}; the rigid vehicle differs by "
        f"{percent_up(rigid['error'])} and takes {duration(rigid['seconds'])}."
    )
    certainty = f"The limit of fine meshes is known within {percent_up(known_to)}."
    reading = (
        "Error: largest of impulse, peak force and duration of the first two strikes, relative to the Richardson "
        f"extrapolation of quad9, whose uncertainty is {known_to:.0e}; smaller errors are shown at this value. The "
        f"crush force of a corner is distributed over {measure(found.patch, 'm', 'g')} of the side. Times: minimum of "
        "several runs, without compilation."
    )
    section = Section("Error against run time", "", charts(IMPACT, rows, known_to), best, (reading,))
    return "Settings of a whole impact", answer, certainty, best, [section]


def summary(found: CostResult) -> dict[str, Any]:
    """Summary of the study, in SI."""
    rows, limit = found.rows, found.limit
    both = {"rigid": found.of(soft=False), "flexible": found.of(soft=True)}
    numbers: dict[str, Any] = {**study_summary("cost", found.case), "points": rows}
    if found.case.scene.contact:
        cheap = {level: key for level, key in _by_level(rows).items() if key}
        numbers |= {"front": [row["setting"] for row in front(rows)], "cheapest": cheap}
        numbers |= {"known": limit.known, "limit": limit.values, "patch_length": found.patch}
    else:
        choices = {"flexible": limit.known, "choices": found.mesh_limit.known}
        soft = {"changes": found.soft, "flexibility": found.flexibility, "limit": limit.values}
        numbers["front"] = {name: [row["setting"] for row in front(its)] for name, its in both.items()}
        numbers["cheapest"] = {name: _by_level(its) for name, its in both.items()}
        numbers |= {"known": {"rigid": compute.ROUNDING, **choices}, "soft_plate": soft}
        numbers["convergence"] = found.convergence
    return numbers | {"cost": {"seconds": found.seconds}}


def _by_level(rows: list[Row]) -> dict[str, str | None]:
    """Fastest setting for each level of error, or None."""
    return {f"{level:.0e}": (cheapest(rows, level) or {}).get("setting") for level in LEVELS}


def _best(question: Question, rows: list[Row]) -> Table:
    """Table of the fastest settings for each level of error."""
    groups, best, shown = dict((question.methods, (FE, "finite elements"))), [], []
    for level in LEVELS:
        each = {kind: cheapest([row for row in rows if row["kind"] == kind], level) for kind in groups}
        if any(each.values()):
            named = {kind: row and {**row, "name": _name(row)} for kind, row in each.items()}
            best.append({"level": f"{level:.0e}", **named})
    for kind, group in groups.items():
        shown.append(Column(f"{kind}.name", "setting", group=group))
        shown.append(Column(f"{kind}.error", "error", form=ERROR, group=group))
        shown.append(Column(f"{kind}.seconds", "time", form=duration, group=group))
    return Table((Column("level", "Error at most"), *shown), best, "Fastest settings")


def _name(row: Row) -> str:
    return f"{row['group']}: {row['label']}"


def _quickest(rows: list[Row]) -> str:
    """Fastest FE setting whose error is below the power of ten next above the smallest FE error, in words."""
    fe = [row for row in rows if row["kind"] == FE and is_valid(row)]
    least = 10.0 ** math.ceil(math.log10(min(row["error"] for row in fe))) if fe else 0.0
    best = cheapest(fe, least)
    if best is None:
        return "no valid setting"
    return f"{percent_up(best['error'])} in {duration(best['seconds'])} ({_name(best)})"


def _every(rows: list[Row]) -> Table:
    """Table of all settings; those on a Pareto front are highlighted."""
    best = [row["setting"] for soft in (False, True) for row in front(r for r in rows if r["soft"] == soft)]
    shown = [column for column in SETTINGS if column.key != "added" or any(row["choice"] for row in rows)]
    marks = {number: "marked" for number, row in enumerate(rows) if row["setting"] in best}
    said = []
    for row in rows:
        words = [f"{how}: {row[how]}" for how in ("refused", "failed") if row[how]]
        said.append({**row, "checks": (words or ["passed"])[0]})
    return Table(tuple(shown), said, notes=(NOTE,), marks=marks)


def charts(question: Question, rows: list[Row], known_to: float, mesh_known: float = math.nan) -> list[Chart]:
    """The diagram; known_to, mesh_known: what the truth is known to, and what the limit of the mesh of choices is."""
    series = []
    for line in lines(question, rows, known_to, mesh_known):
        ordered = question is SOFT and line["order"] > 0.5 and line["group"] != compute.MODES
        order = f", order {line['order']:.1f}" if ordered else ""
        series.append(_series(line["label"] + order, line["rows"]))
    best = question.front, [(row["seconds"], row["error"]) for row in front(rows)]
    floor = f"uncertainty of the {question.truth}: {power_text(float(f'{known_to:.0e}'))}", known_to
    return draw_precision(question.name, question.title, series, question.error, best, floor)


def _series(label: str, rows: list[Row]) -> Series:
    """A line of the diagram, whose label says where it is what choices add."""
    drawn = [row for row in rows if math.isfinite(own_error(row))]
    numbers = [row["seconds"] for row in drawn], [own_error(row) for row in drawn]
    passed = [not row["failed"] for row in drawn]
    added = " (added)" if any(row["choice"] for row in drawn) else ""
    return Series(label + added, *numbers, passed, [row["label"] for row in drawn])


def lines(question: Question, rows: list[Row], known_to: float, mesh_known: float) -> list[Row]:
    """The question's lines: their rows, errors of the coarsest and the finest, and the order observed of errors well
    above what is known, NaN where there is none."""
    found = []
    for group, label in question.lines.items():
        its = [row for row in rows if row["group"] == group and math.isfinite(own_error(row))]
        errors = np.array([own_error(row) for row in its])
        fineness = np.array([row["refinement"] for row in its])
        level = 3.0 * (mesh_known if any(row["choice"] for row in its) else known_to)
        clear = (errors > level) & (fineness > 0.0)
        x, y = np.log(fineness[clear]), np.log(errors[clear])
        order = -float(np.polyfit(x, y, 1)[0]) if len(x) > 1 and np.ptp(x) else math.nan
        ends = {"coarsest": errors[0], "finest": errors[-1]} if its else {"coarsest": None, "finest": None}
        found.append({"group": group, "label": label, "rows": its, "order": order, **ends})
    return found
