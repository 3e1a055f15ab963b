"""What the study of cost reports."""

from __future__ import annotations

from typing import Any

from postprocess.comparison.comparison import QUANTITIES
from postprocess.figures.precision_plots import draw_precision
from postprocess.report.numbers import duration, known
from postprocess.report.page import Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, columns, listed
from tailslap.report.common import study_page, study_summary
from tailslap.studies.cost.campaign import ROUNDING
from tailslap.studies.cost.diagrams import flexible_diagram, impact_diagram, rigid_diagram, soft_lines
from tailslap.studies.cost.impacts import ImpactCost
from tailslap.studies.cost.points import CostResults, Point, by_level, front, quickest
from tailslap.studies.cost.settings import FE, MODAL, ODE, RIGID
from tailslap.studies.cost.soft import frequency, patch

ERROR, VALUE = known(".1e"), known(".9g")
SETTINGS = (
    Column("setting.key", "Setting"),
    Column("checks", "Checks"),
    Column("error", "Error", form=ERROR),
    Column("added", "Added", form=ERROR),
    Column("seconds", "Time", form=duration),
    Column("loop_s", "Of which loop", form=duration),
    Column("steps", "Steps", form="d"),
)
LINES = (
    Column("label", "Line"),
    Column("coarsest.own_error", "Coarsest", form=ERROR),
    Column("finest.own_error", "Finest", form=ERROR),
    Column("order", "Order", form=known(".1f")),
)
GRIDS = (
    Column("symbol", "Quantity"),
    Column("behaviour", "Values"),
    *columns({"values.2": "Coarse", "values.1": "Medium", "values.0": "Fine"}, form=VALUE),
    Column("extrapolated", "Extrapolated", form=VALUE),
    Column("order", "Order", form=known(".2f")),
    Column("gci_fine", "GCI fine", form=ERROR),
)
FILES = "points.csv, every setting with its numbers in SI; summary.json"
NOTE = (
    "Error: from the exact rigid motion, or from the soft plate's limit. Added: what a choice adds to its mesh's. "
    "Times: the fastest of several, all compiled and loaded. Set off: on the Pareto front of its question."
)
READING = (
    "GCI: grid convergence index (Roache 1994, ASME V&V 20) of three, each half the last; safety factor 1.25, or 3.",
    "v_GY of a corner held at one node has no limit: its compliance grows by the logarithm of the mesh. Over a "
    "`corner.patch_length` it has one.",
)


def cost_report(found: CostResults | ImpactCost) -> Report:
    """Page, summary, points, and what the terminal says."""
    if isinstance(found, ImpactCost):
        return _impact_report(found)
    known_to = (found.limit.known, found.mesh_limit.known)
    rigid, soft = rigid_diagram(found.points, ROUNDING), flexible_diagram(found.points, *known_to)
    lines = Table(LINES, soft_lines(found.points, *known_to), "Order of the errors well above what is known")
    best = _best(found.rigid, ODE, "SciPy"), _best(found.flexible, MODAL, "soft plate, modes")
    page = study_page(
        found.plan,
        "Error against run time: every method and setting that the program has",
        headline(found),
        (
            Section("The rigid question", "", draw_precision(rigid), best[:1]),
            Section("The flexible question", "", draw_precision(soft), (lines, best[1]), _limits(found)),
            Section("Grid convergence", tables=_convergence(found), sentences=READING),
            Section("Every setting", tables=(_every(found.points),)),
        ),
        FILES,
    )
    return Report(page, summary(found), (*best, page.headline, _cost(found)), _points(found))


def _impact_report(found: ImpactCost) -> Report:
    best = _best(found.points, ODE, RIGID)
    reading = (
        f"Error: largest of impulse, peak and duration of the first two strikes, from Richardson's extrapolation of "
        f"quad9, known to {found.limit.known:.0e}; smaller ones are shown as that. A corner's crush is spread over "
        f"{found.patch:g} m of its side. Times: the fastest of several, all compiled and loaded."
    )
    diagram = impact_diagram(found.points, found.limit.known)
    page = study_page(
        found.plan,
        "Error against run time: settings of a whole impact",
        _impact_headline(found),
        (
            Section("Error against run time", "", draw_precision(diagram), (best,), (reading,)),
            Section("Every setting", tables=(_every(found.points),)),
        ),
        FILES,
    )
    said = (best, page.headline, reading, _cost(found))
    return Report(page, _impact_summary(found), said, _points(found))


def _cost(found: CostResults | ImpactCost) -> str:
    return f"Cost:   {len(found.points)} settings in {found.seconds:.0f} s"


def _points(found: CostResults | ImpactCost) -> dict[str, Table]:
    return {"points.csv": listed([point.row for point in found.points])}


def _impact_headline(found: ImpactCost) -> str:
    """What an error costs, and what the rigid vehicle's is."""
    rigid = found.points[0]
    return (
        f"Both strikes of the plate, by finite elements: within {_spent(quickest(found.points))}. "
        f"The rigid vehicle is {rigid.error:.1e} off in {duration(rigid.seconds)}."
    )


def _impact_summary(found: ImpactCost) -> dict[str, Any]:
    return {
        **study_summary("cost", found.plan),
        "points": [point.row for point in found.points],
        "front": [point.setting.key for point in front(found.points)],
        "cheapest": {row["level"]: row["key"] for row in by_level(found.points) if row["key"]},
        "known": found.limit.known,
        "limit": found.limit.values,
        "patch_length": found.patch,
        "cost": {"seconds": found.seconds},
    }


def summary(found: CostResults) -> dict[str, Any]:
    """The numbers of the study, SI."""
    both = {"rigid": found.rigid, "flexible": found.flexible}.items()
    return {
        **study_summary("cost", found.plan),
        "points": [point.row for point in found.points],
        "front": {name: [point.setting.key for point in front(its)] for name, its in both},
        "cheapest": {name: {row["level"]: row["key"] for row in by_level(its)} for name, its in both},
        "known": {"rigid": ROUNDING, "flexible": found.limit.known, "choices": found.mesh_limit.known},
        "soft_plate": {"changes": found.soft, "flexibility": found.flexibility, "limit": found.limit.values},
        "convergence": found.convergence,
        "cost": {"seconds": found.seconds},
    }


def headline(found: CostResults) -> str:
    """What an error costs."""
    rigid, soft = (_spent(quickest(points)) for points in (found.rigid, found.flexible))
    return (
        f"The exact rigid solution takes {duration(found.points[0].seconds)}. Finite elements come within {rigid}; the "
        f"rest is the plate's own flexibility. A soft plate's motion, {found.flexibility:.1e} from the rigid one, they "
        f"give to {soft}."
    )


def _spent(best: Point | None) -> str:
    return f"{best.error:.1e} in {duration(best.seconds)} ({best.setting.name})" if best else "nothing known"


def _limits(found: CostResults) -> tuple[str, ...]:
    """What the soft plate is, and where its limits come from."""
    scene, meshes = found.plan.scene, [p.setting.label for p in found.flexible if p.setting.group == "quad9"]
    return (
        f"The soft plate: {frequency(scene):g} Hz first frequency, the corner held over {patch(scene):g} m, no "
        "friction, no damping, one modulus on all meshes: what is left of its error falls with refinement.",
        f"Full lines: the error from Richardson's extrapolation of quad9 ({', '.join(meshes[-3:])}), known to "
        f"{found.limit.known:.0e}, the largest GCI; smaller errors are shown as that.",
        f"Dashed lines: what one choice adds to its mesh, known to {found.mesh_limit.known:.0e}. What inertia relief "
        "leaves over rings, so that steps have no clean order; linear modes leave as much, however many.",
    )


def _best(points: tuple[Point, ...], kind: str, name: str) -> Table:
    """The cheapest setting for each error: of a kind, and of finite elements."""
    rows = [row for row in by_level(points) if row[kind] or row[FE]]
    columns = (*_best_columns(kind, name), *_best_columns(FE, "finite elements"))
    return Table((Column("level", "Error at most"), *columns), rows, "The cheapest setting")


def _best_columns(kind: str, group: str) -> tuple[Column, ...]:
    return (
        Column(f"{kind}.setting.name", "setting", group=group),
        Column(f"{kind}.error", "error", form=ERROR, group=group),
        Column(f"{kind}.seconds", "time", form=duration, group=group),
    )


def _convergence(found: CostResults) -> list[Table]:
    """Observed order, extrapolated value and grid convergence index of each quantity."""
    tables = []
    for group, grids in found.convergence.items():
        rows = [{"symbol": QUANTITIES[name].symbol, **vars(grid)} for name, grid in grids.items()]
        tables.append(Table(GRIDS, rows, group[0].upper() + group[1:]))
    return tables


def _every(points: tuple[Point, ...]) -> Table:
    """Every setting; those on the Pareto front of their question are set off."""
    best = [point for soft in (False, True) for point in front(p for p in points if p.setting.soft == soft)]
    columns = [
        column for column in SETTINGS if column.key != "added" or any(p.setting.choice for p in points)
    ]
    marks = {i: "marked" for i, point in enumerate(points) if point in best}
    return Table(tuple(columns), points, notes=(NOTE,), marks=marks)
