"""The study in words and tables."""

from __future__ import annotations

import math

from postprocess.study_page import StudyTable
from tailslap.studies.cost.settings import FE, HOLD, MESH, MODAL, ODE, STEP
from tailslap.studies.cost.survey import CostSurvey, Point, cheapest, front

LEVELS = tuple(10.0**-exponent for exponent in range(2, 12))
NAMES = {"t": "t", "v_gx": "v_GX", "v_gy": "v_GY", "omega": "omega", "slide": "s"}


def headline(found: CostSurvey) -> str:
    """What an error costs, in two sentences."""
    fe = [p for p in found.points if p.setting.kind == FE and p.valid]
    exact = found.points[0]
    words = f"The exact rigid solution takes {milliseconds(exact.seconds)}. "
    if not fe:
        return words + "No finite-element setting passed its checks."
    best = min(fe, key=lambda p: p.error)
    quick = min((p for p in fe if p.error <= 2.0 * best.error), key=lambda p: p.seconds)
    return words + (
        f"Finite elements come within {quick.error:.1e} of it in {milliseconds(quick.seconds)} "
        f"({quick.setting.key}), of which the time loop takes {milliseconds(quick.loop_s)}; what is left then is the "
        "plate's own flexibility."
    )


def milliseconds(seconds: float) -> str:
    """A time in the unit that suits it."""
    if seconds < 1e-3:
        return f"{1e6 * seconds:.0f} us"
    return f"{1e3 * seconds:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"


def level_table(found: CostSurvey, by: str) -> StudyTable:
    """The cheapest setting for each error level: of the integrators and of finite elements."""
    kinds = (ODE, FE) if by == "error" else (MODAL, FE)
    rows = []
    for level in LEVELS:
        best = [
            cheapest(tuple(p for p in found.points if p.setting.kind == kind), level, by) for kind in kinds
        ]
        if any(best):
            rows.append((f"{level:.0e}", *(cell for point in best for cell in _named(point, by))))
    names = {ODE: "SciPy", MODAL: "modes", FE: "FE"}
    columns = [f"{names[kind]}: {what}" for kind in kinds for what in ("setting", "error", "time")]
    note = (
        f"The exact solution takes {milliseconds(found.points[0].seconds)}, at any level."
        if by == "error"
        else ""
    )
    return StudyTable(("at most", *columns), tuple(rows), texts=2, title="The cheapest setting", note=note)


def _named(point: Point | None, by: str) -> tuple[str, str, str]:
    if point is None:
        return ("none", "", "")
    return (point.setting.key, f"{getattr(point, by):.1e}", milliseconds(point.seconds))


def all_table(found: CostSurvey) -> StudyTable:
    """Every setting; those on the Pareto front of the error from the rigid motion are set off."""
    best = {p.setting.key for p in front(found.points, "error")}
    rows = tuple(_row(point) for point in found.points)
    marked = frozenset(i for i, point in enumerate(found.points) if point.setting.key in best)
    columns = (
        "setting",
        "checks",
        "error, rigid",
        "error, limit",
        "set-up",
        "loop",
        "median",
        "compile",
        "steps",
    )
    note = "Set off: on the Pareto front of the error from the exact rigid motion; no setting beats them in both."
    return StudyTable(columns, rows, texts=2, marked=marked, note=note)


def _row(point: Point) -> tuple[str, ...]:
    if point.refused:
        return (point.setting.key, "refused: " + point.refused[:90], *("–",) * 7)
    verdict = "failed: " + ", ".join(point.failed) if point.failed else "passed"
    times = (point.setup_s, point.loop_s, point.median_s, point.compile_s)
    shown = (milliseconds(value) if value else "–" for value in times)
    return (
        point.setting.key,
        verdict,
        _error(point.error),
        _error(point.from_limit),
        *shown,
        str(point.steps or "–"),
    )


def _error(value: float) -> str:
    return f"{value:.1e}" if math.isfinite(value) else "–"


TITLES = {MESH: "Mesh, the scene's own hold", HOLD: "Mesh, exact constraint", STEP: "Time step"}


def convergence_tables(found: CostSurvey) -> tuple[StudyTable, ...]:
    """Observed order, extrapolated value and grid convergence index of each quantity."""
    tables = []
    for group, by_name in found.convergence.items():
        rows = []
        for name, grid in by_name.items():
            order = f"{grid.order:.2f}" if math.isfinite(grid.order) else "–"
            values = tuple(f"{value:.9g}" for value in (*grid.values[::-1], grid.extrapolated))
            indices = (f"{grid.gci_fine:.1e}", f"{grid.gci_coarse:.1e}")
            rows.append((NAMES[name], grid.behaviour, *values, order, *indices))
        columns = (
            "quantity",
            "values",
            "coarse",
            "medium",
            "fine",
            "extrapolated",
            "order",
            "GCI fine",
            "GCI medium",
        )
        tables.append(
            StudyTable(columns, tuple(rows), texts=2, title=f"{TITLES[group]}: three, each half the last")
        )
    return tuple(tables)


def convergence_sentences(found: CostSurvey) -> tuple[str, ...]:
    """How the tables are read."""
    said = [
        "Observed order, Richardson's extrapolation and the grid convergence index after Roache (1994) and ASME "
        "V&V 20, safety factor 1.25; 3 where the values oscillate or hardly converge, which are not extrapolated.",
    ]
    if not found.has_limit:
        said.append(
            "v_GY does not converge with the mesh: a corner held at one node gives by the logarithm of the mesh. "
            'The "limit" is then the finest mesh\'s value. With corner.patch_length the plate has a limit.'
        )
    said.append(
        "Central differences err by the square of the time step; stability keeps it so short that the step hardly "
        "shows in these digits."
        if STEP in found.convergence
        else "There is no table for the time step: the steps measured are not halves of each other, for the least "
        "number of steps of a soft plate, or the scene's own safety factor, stands against it."
    )
    return tuple(said)
