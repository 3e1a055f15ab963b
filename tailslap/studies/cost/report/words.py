"""The study in words and tables; the table of all settings is in `all_settings`."""

from __future__ import annotations

import math
from collections.abc import Sequence

from postprocess.pages.study_page import StudyTable
from tailslap.studies.cost.points import CostSurvey, Point, cheapest
from tailslap.studies.cost.report.diagrams import CHOICE_LABELS, MESH_LABELS, drawn_error, order_of
from tailslap.studies.cost.settings import FE, MESH, MODAL, ODE, STEP
from tailslap.studies.cost.soft import frequency, patch
from tailslap.studies.cost.survey import LIMIT, SOFT_QUAD4, SOFT_STEP

LEVELS = tuple(10.0**-exponent for exponent in range(2, 12))
NAMES = {"t": "t", "v_gx": "v_GX", "v_gy": "v_GY", "omega": "omega", "slide": "s"}


def headline(found: CostSurvey) -> str:
    """What an error costs, in three sentences."""
    exact = found.points[0]
    words = f"The exact rigid solution takes {milliseconds(exact.seconds)}. "
    rigid, flexible = (
        min((p for p in points if p.setting.kind == FE and p.valid), key=lambda p: p.error, default=None)
        for points in (found.rigid, found.flexible)
    )
    if rigid is None:
        return words + "No finite-element setting passed its checks."
    quick = cheapest_fe(found.rigid, 2.0 * rigid.error) or rigid
    words += (
        f"Finite elements come within {quick.error:.1e} of it in {milliseconds(quick.seconds)} "
        f"({quick.setting.key}), of which the time loop takes {milliseconds(quick.loop_s)}; what is left then is the "
        "plate's own flexibility. "
    )
    if flexible is None:
        return words
    level = next((level for level in LEVELS[::-1] if flexible.error <= level <= 1e-5), LEVELS[0])
    soft = cheapest_fe(found.flexible, level) or flexible
    return words + (
        f"A soft plate's own motion, {found.flexibility:.1e} from the rigid one, they give to {soft.error:.1e} in "
        f"{milliseconds(soft.seconds)} ({soft.setting.key})."
    )


def cheapest_fe(points: Sequence[Point], level: float) -> Point | None:
    """The cheapest finite-element setting with at most this error."""
    return cheapest(tuple(p for p in points if p.setting.kind == FE), level)


def milliseconds(seconds: float) -> str:
    """A time in the unit that suits it."""
    if seconds < 1e-3:
        return f"{1e6 * seconds:.0f} us"
    return f"{1e3 * seconds:.3g} ms" if seconds < 1.0 else f"{seconds:.3g} s"


def level_table(found: CostSurvey, soft: bool) -> StudyTable:
    """The cheapest setting for each error: of the integrators or the modal model, and of finite elements."""
    points, kinds = (found.flexible, (MODAL, FE)) if soft else (found.rigid, (ODE, FE))
    rows = []
    for level in LEVELS:
        best = [cheapest(tuple(p for p in points if p.setting.kind == kind), level) for kind in kinds]
        if any(best):
            rows.append((f"{level:.0e}", *(cell for point in best for cell in _named(point))))
    names = {ODE: "SciPy", MODAL: "modes", FE: "FE"}
    columns = [f"{names[kind]}: {what}" for kind in kinds for what in ("setting", "error", "time", "loop")]
    note = "" if soft else f"The exact solution takes {milliseconds(found.points[0].seconds)}, at any level."
    return StudyTable(("at most", *columns), tuple(rows), texts=2, title="The cheapest setting", note=note)


def _named(point: Point | None) -> tuple[str, str, str, str]:
    if point is None:
        return ("none", "", "", "")
    key = point.setting.key.removeprefix("soft plate, ")
    return (key, f"{point.error:.1e}", milliseconds(point.seconds), milliseconds(point.loop_s))


def soft_sentences(found: CostSurvey) -> tuple[str, ...]:
    """What the soft plate is, and where its limits come from."""
    scene, finest = found.plan.scene, [p for p in found.flexible if p.setting.group == "quad9"][-3:]
    meshes = ", ".join(point.setting.label for point in finest)
    return (
        f"The soft plate: the scene's plate with a first frequency of {frequency(scene):g} Hz, the corner held over "
        f"{patch(scene):g} m, without friction and damping. Its modulus is found once, on a fine mesh, and is the same "
        f"in all; its answer is {found.flexibility:.1e} from the rigid motion.",
        f"Full lines: the error from the plate's limit. The limit is Richardson's extrapolation of quad9 with {meshes} "
        f"elements and the exact constraint, and is known to {found.limit.known:.0e} (the largest grid convergence "
        "index of the five quantities); smaller errors are written and drawn as that.",
        "Dashed lines: what one choice adds to the error of the mesh that it is made on, from that mesh with the exact "
        f"constraint, no damping and the step extrapolated to zero, known to {found.mesh_limit.known:.0e}. There the "
        "plate rings by what inertia relief leaves over: the step has no clean order among it, and "
        "modes, which are linear, leave as much, however many.",
    )


def order_table(found: CostSurvey) -> StudyTable:
    """Error of the coarsest and the finest of each line on the soft plate, and the observed order."""
    rows = []
    for group, label in (MESH_LABELS | CHOICE_LABELS).items():
        points = [p for p in found.flexible if p.setting.group == group and math.isfinite(drawn_error(p))]
        if points:
            known = (found.mesh_limit if points[0].setting.choice else found.limit).known
            first, last = (f"{p.setting.label}: {drawn_error(p):.1e}" for p in (points[0], points[-1]))
            order = order_of(points, known)
            rows.append((label, first, last, f"{order:.1f}" if math.isfinite(order) else "–"))
    note = "The order: the exponent of the error in the refinement, fitted to errors above three times what is known."
    return StudyTable(
        ("line", "coarsest", "finest", "order"), tuple(rows), texts=3, title="Orders", note=note
    )


TITLES = {
    MESH: "Mesh, the scene as it is",
    STEP: "Time step, the scene as it is",
    SOFT_QUAD4: "Mesh, soft plate, quad4",
    LIMIT: "Mesh, soft plate, quad9: the limit",
    SOFT_STEP: "Time step, soft plate",
}


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
    mesh = found.convergence.get(MESH)
    if mesh and mesh["v_gy"].behaviour not in ("converging", "settled"):
        said.append(
            "v_GY of the scene does not converge with the mesh: a corner held at one node gives by the logarithm of "
            "the mesh. With corner.patch_length, as on the soft plate, it has a limit."
        )
    said.append(
        "Central differences err by the square of the time step; stability keeps it so short that the step hardly "
        "shows in these digits."
        if STEP in found.convergence
        else "There is no table for the time step: the steps measured are not halves of each other, for the least "
        "number of steps of a soft plate, or the scene's own safety factor, stands against it."
    )
    return tuple(said)
