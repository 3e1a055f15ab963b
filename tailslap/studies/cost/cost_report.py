"""Report of the study `cost`."""

import math
from typing import NamedTuple

import numpy as np

from postprocess.comparison.quantities import QUANTITIES
from postprocess.figures.studies import Series, draw_precision
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns, listed
from postprocess.svg.chart import Chart
from postprocess.svg.scales import power_text
from postprocess.units import duration, known, measure, percent_up
from tailslap.campaign.records import Record
from tailslap.case.report_parts import study_page, study_summary
from tailslap.studies.cost import cost_settings, cost_study
from tailslap.studies.cost.cost_settings import FE
from tailslap.studies.cost.cost_study import CostResult, cheapest, front, own_error

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


class Diagram(NamedTuple):
    """Labels and lines of a diagram.

    Attributes
    ----------
    name, title, error : str
        Name and title, and label of the error.
    methods : tuple of str
        Kind and name of the methods beside finite elements.
    lines : dict of str
        Labels of the groups that are drawn as lines.
    front, truth : str
        Labels of front and reference.
    shows_order : bool
        True to label lines with their orders.
    """

    name: str
    title: str
    error: str
    methods: tuple[str, str]
    lines: dict[str, str]
    front: str = "Pareto front"
    truth: str = "limit"
    shows_order: bool = False


RIGID = Diagram(
    "precision-rigid",
    "(a) Error relative to the exact rigid motion",
    "error relative to the exact rigid motion",
    (cost_settings.ODE, "SciPy"),
    {"exact": "exact solution", **{name: name for name in (*cost_settings.INTEGRATORS, cost_settings.MODES)}}
    | {cost_settings.MESH: "FE, meshes of quad4", cost_settings.ROWSUM: f"FE, {cost_settings.ROWSUM}"}
    | {
        cost_settings.UNSTRESSED: f"FE, {cost_settings.UNSTRESSED}",
        cost_settings.PENALTY: "FE, penalty scales",
    },
    "Pareto front without the exact solution",
    "exact solution",
)
CHOICES = {
    cost_settings.PENALTY: "penalty scales",
    cost_settings.DAMPING: "damping",
    cost_settings.STEP: "time steps",
}
SOFT = Diagram(
    "precision-flexible",
    "(b) Error of a soft plate relative to its converged solution",
    "error relative to the converged solution",
    (cost_settings.MODAL, "soft plate, modes"),
    {name: name for name in (*cost_settings.REFINED, cost_settings.SPRING)}
    | CHOICES
    | {cost_settings.MODES: "modes"},
    shows_order=True,
)
IMPACT = Diagram(
    "precision",
    "Error relative to the converged solution",
    "error of both strikes relative to the converged solution",
    (cost_settings.ODE, cost_settings.RIGID_VEHICLE),
    {
        cost_settings.RIGID_VEHICLE: cost_settings.RIGID_VEHICLE,
        "quad4": "meshes of quad4",
        "quad9": "meshes of quad9",
    }
    | {cost_settings.STEP: "time steps", cost_settings.DAMPING: "damping"},
)


def report(result: CostResult) -> Report:
    """Return the report of the study."""
    kicker, answer, certainty, best_tables, sections = (_impact if result.case.scene.contact else _corner)(
        result
    )
    sections.append(Section("Every setting", tables=(_every(result.rows),)))
    title = f"Error against run time: {result.case.subject}"
    headline = Headline(title, answer, result.case.set_up, certainty)
    page = study_page(result.case, kicker, headline, sections, FILES)
    cost = f"Cost:   {len(result.rows)} settings in {result.seconds:.0f} s"
    return Report(page, summary(result), (*best_tables, cost), {"points.csv": listed(result.rows)})


def _corner(result: CostResult) -> tuple[str, str, str, tuple[Table, ...], list[Section]]:
    """Return the texts, tables and sections of a corner."""
    rigid, soft = result.rows_of(soft=False), result.rows_of(soft=True)
    limit, mesh_limit = result.limit.uncertainty, result.mesh_limit.uncertainty
    best = _best(RIGID, rigid), _best(SOFT, soft)
    answer = (
        f"Finite elements reproduce the rigid-body motion within {_quickest(rigid)}; the exact solution takes "
        f"{duration(result.rows[0]['seconds'])}. They compute the motion of a soft plate, which differs from the rigid "
        f"one by {percent_up(result.flexibility)}, within {_quickest(soft)}."
    )
    certainty = f"The limit of fine meshes of the soft plate is known within {percent_up(limit)}."
    frequency, patch, _ = cost_settings.soft_plate(result.case.scene)
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
    for group, grids_by_name in result.convergence.items():
        rows = [{"symbol": QUANTITIES[name].symbol, **vars(grid)} for name, grid in grids_by_name.items()]
        grids.append(Table(GRIDS, rows, group[0].upper() + group[1:]))
    soft_charts = charts(SOFT, soft, limit, mesh_limit)
    sections = [
        Section("Rigid motion", "", charts(RIGID, rigid, cost_study.ROUNDING), best[:1]),
        Section("Flexible plate", "", soft_charts, (order_table, best[1]), limits),
        Section("Grid convergence", tables=grids, sentences=READING),
    ]
    return "All methods and settings of the program", answer, certainty, best, sections


def _impact(result: CostResult) -> tuple[str, str, str, tuple[Table, ...], list[Section]]:
    """Return the texts, tables and sections of an impact."""
    rows, rigid, uncertainty = result.rows, result.rows[0], result.limit.uncertainty
    best = (_best(IMPACT, rows),)
    answer = (
        f"Finite elements compute both strikes within {_quickest(rows)}; the rigid vehicle differs by "
        f"{percent_up(rigid['error'])} and takes {duration(rigid['seconds'])}."
    )
    certainty = f"The limit of fine meshes is known within {percent_up(uncertainty)}."
    reading = (
        "Error: largest of impulse, peak force and duration of the first two strikes, relative to the Richardson "
        f"extrapolation of quad9, whose uncertainty is {uncertainty:.0e}; smaller errors are shown at this value. The "
        f"crush force of a corner is distributed over {measure(result.patch, 'm', 'g')} of the side. Times: minimum of "
        "several runs, without compilation."
    )
    section = Section("Error against run time", "", charts(IMPACT, rows, uncertainty), best, (reading,))
    return "Settings of a whole impact", answer, certainty, best, [section]


def summary(result: CostResult) -> Record:
    """Return the summary of the study, in SI."""
    rows, limit = result.rows, result.limit
    groups = {"rigid": result.rows_of(soft=False), "flexible": result.rows_of(soft=True)}
    numbers: Record = {**study_summary("cost", result.case), "points": rows}
    if result.case.scene.contact:
        cheap = {level: key for level, key in _by_level(rows).items() if key}
        numbers |= {"front": [row["setting"] for row in front(rows)], "cheapest": cheap}
        numbers |= {"known": limit.uncertainty, "limit": limit.values, "patch_length": result.patch}
    else:
        choices = {"flexible": limit.uncertainty, "choices": result.mesh_limit.uncertainty}
        soft = {"changes": result.soft, "flexibility": result.flexibility, "limit": limit.values}
        numbers["front"] = {name: [row["setting"] for row in front(group)] for name, group in groups.items()}
        numbers["cheapest"] = {name: _by_level(group) for name, group in groups.items()}
        numbers |= {"known": {"rigid": cost_study.ROUNDING, **choices}, "soft_plate": soft}
        numbers["convergence"] = result.convergence
    return numbers | {"cost": {"seconds": result.seconds}}


def _by_level(rows: list[Record]) -> dict[str, str | None]:
    """Return the fastest setting for each level."""
    return {f"{level:.0e}": (cheapest(rows, level) or {}).get("setting") for level in cost_study.LEVELS}


def _best(diagram: Diagram, rows: list[Record]) -> Table:
    """Return the table of the fastest settings."""
    groups, best, heads = dict((diagram.methods, (FE, "finite elements"))), [], []
    for level in cost_study.LEVELS:
        fastest = {kind: cheapest([row for row in rows if row["kind"] == kind], level) for kind in groups}
        if any(fastest.values()):
            cells = {kind: row and {**row, "name": _name(row)} for kind, row in fastest.items()}
            best.append({"level": f"{level:.0e}", **cells})
    for kind, group in groups.items():
        heads.append(Column(f"{kind}.name", "setting", group=group))
        heads.append(Column(f"{kind}.error", "error", form=ERROR, group=group))
        heads.append(Column(f"{kind}.seconds", "time", form=duration, group=group))
    return Table((Column("level", "Error at most"), *heads), best, "Fastest settings")


def _name(row: Record) -> str:
    """Return the name of a setting."""
    return f"{row['group']}: {row['label']}"


def _quickest(rows: list[Record]) -> str:
    """Return the fastest accurate FE setting in words.

    Its error is below the power of ten above the least error.
    """
    fe = [row for row in rows if row["kind"] == FE and cost_study.is_valid(row)]
    least = 10.0 ** math.ceil(math.log10(min(row["error"] for row in fe))) if fe else 0.0
    best = cheapest(fe, least)
    if best is None:
        return "no valid setting"
    return f"{percent_up(best['error'])} in {duration(best['seconds'])} ({_name(best)})"


def _every(rows: list[Record]) -> Table:
    """Return the table of all settings."""
    best = [row["setting"] for soft in (False, True) for row in front(r for r in rows if r["soft"] == soft)]
    heads = [column for column in SETTINGS if column.key != "added" or any(row["choice"] for row in rows)]
    marks = {number: "marked" for number, row in enumerate(rows) if row["setting"] in best}
    table_rows = []
    for row in rows:
        faults = [f"{column}: {row[column]}" for column in ("refused", "failed") if row[column]]
        table_rows.append({**row, "checks": (faults or ["passed"])[0]})
    return Table(tuple(heads), table_rows, notes=(NOTE,), marks=marks)


def charts(
    diagram: Diagram, rows: list[Record], uncertainty: float, mesh_uncertainty: float = math.nan
) -> list[Chart]:
    """Return the diagram.

    The uncertainties are those of the reference and of the mesh of choices.
    """
    series = []
    for line in lines(diagram, rows, uncertainty, mesh_uncertainty):
        ordered = diagram.shows_order and line["order"] > 0.5 and line["group"] != cost_settings.MODES
        order = f", order {line['order']:.1f}" if ordered else ""
        series.append(_series(line["label"] + order, line["rows"]))
    best = diagram.front, [(row["seconds"], row["error"]) for row in front(rows)]
    floor = f"uncertainty of the {diagram.truth}: {power_text(float(f'{uncertainty:.0e}'))}", uncertainty
    return draw_precision(diagram.name, diagram.title, series, diagram.error, best, floor)


def _series(label: str, rows: list[Record]) -> Series:
    """Return a line of the diagram, labelled for choices."""
    finite = [row for row in rows if math.isfinite(own_error(row))]
    numbers = [row["seconds"] for row in finite], [own_error(row) for row in finite]
    passed = [not row["failed"] for row in finite]
    added = " (added)" if any(row["choice"] for row in finite) else ""
    return Series(label + added, *numbers, passed, [row["label"] for row in finite])


def lines(diagram: Diagram, rows: list[Record], uncertainty: float, mesh_uncertainty: float) -> list[Record]:
    """Return the lines of a diagram.

    Each has its errors and observed order, that of errors well above the uncertainty, NaN without any.
    """
    drawn = []
    for group, label in diagram.lines.items():
        members = [row for row in rows if row["group"] == group and math.isfinite(own_error(row))]
        errors = np.array([own_error(row) for row in members])
        fineness = np.array([row["refinement"] for row in members])
        level = 3.0 * (mesh_uncertainty if any(row["choice"] for row in members) else uncertainty)
        certain = (errors > level) & (fineness > 0.0)
        x, y = np.log(fineness[certain]), np.log(errors[certain])
        order = -float(np.polyfit(x, y, 1)[0]) if len(x) > 1 and np.ptp(x) else math.nan
        coarsest, finest = (errors[0], errors[-1]) if members else (None, None)
        line = {"group": group, "label": label, "rows": members, "order": order}
        drawn.append({**line, "coarsest": coarsest, "finest": finest})
    return drawn
