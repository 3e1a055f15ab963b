"""Parts of reports, texts and summaries that both kinds of case have: checks, forces, cost, fields."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import tailslap
from fem.plate.kinds import ELEMENT_KINDS
from fem.start import start_kinds
from postprocess import units
from postprocess.fields import series
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table, columns, pairs
from postprocess.signals.design_forces import DesignForce, design_forces
from postprocess.units import duration, number
from tailslap.case import resources
from tailslap.case.case import LABEL, Case, Check, FePlan, Outcome, as_read
from tailslap.errors import typed_command
from tailslap.scene import write

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.run.observers import Snapshots

Parts = Sequence[tuple[str, str]]
"""Parts that a scene does without, each with the reason."""


def milliseconds(seconds: float) -> str:
    """A time [s] in milliseconds."""
    return f"{1e3 * seconds:.1f}"


PEAKS = (
    Column("what", "Peak lateral force"),
    Column("fe", "FE", "N", form="#.4g", style="strong"),
    Column("rigid", "Rigid", "N", form="#.4g", style="strong"),
)
DESIGN = (
    Column("name", "Design force", style="whole"),
    Column("force", "Lateral", "N", form="#.4g", style="strong"),
    Column("ratio", "Ratio", form=".2f"),
    Column("source", "Source", style="soft"),
)
CHECKS = (
    Column("name", "Check"),
    *columns({"value": "Value", "limit": "Limit"}, form=str),
    Column("passed", "Result", form=lambda passed: "passed" if passed else "failed", style="badge"),
    Column("meaning", "Meaning"),
)
FAILED = (
    Column("name", "Failed check"),
    Column("value", "Value", form=str, style="strong"),
    Column("limit", "Limit", form=str),
    Column("advice", "Remedy"),
)
INPUTS = (
    Column("key", "Key", form=lambda key: f"`{key}`"),
    Column("given", "As given", form=lambda given: f"`{given}`" if given else ""),
    Column("value", "Value", form=lambda value: number(value, 6), unit_key="unit"),
    Column("unit", "Unit", is_unit=True),
    Column("origin", "From"),
)
TAIL_SLAP = (
    *columns({"quantity.title": "Quantity", "quantity.symbol": ""}),
    *columns({"fe": "FE", "rigid": "Rigid, exact"}, form="#.5g", unit_key="quantity.unit"),
    Column("quantity.unit", "Unit", is_unit=True),
    Column("difference", "FE/rigid − 1", form="+.1e", style="strong"),
)
"""Columns of the rows of `comparison_rows`."""

STRIKES = (
    *columns({"title": "Strike", "model": "Model"}),
    Column("start", "Start", "ms", form=milliseconds),
    Column("duration", "Duration", "ms", form=milliseconds),
    Column("peak_force", "Peak", "N", form=".1f", style="strong"),
    Column("impulse", "Impulse", "N s", form=".2f"),
    Column("point_of_attack", "Resultant", "m", form="z.2f"),
)
ATTACK = "Resultant: distance of the resultant force behind the front bumper."
CUT = " (cut)"
AT_LEAST = (
    "Cut: the strike is not over at the end; its duration, peak force and impulse are at least those given."
)
COST: Mapping[str, tuple[str, Callable[[Any], str]]] = {
    "elements": ("elements", units.grouped),
    "nodes": ("nodes", units.grouped),
    "steps": ("time steps", units.grouped),
    "time_step": ("time step", duration),
    "setup_s": ("set-up", duration),
    "time_loop_s": ("time loop", duration),
    "pictures_s": ("pictures", duration),
}
"""Sizes and times of a run, in words."""


def fe_text(
    fe_plan: FePlan, rows: int, start: str, contact: Sequence[str], steps: str = "", more: Sequence[str] = ()
) -> list[str]:
    """Lines of `tailslap check` on the FE run of so many rows.

    start: words on the start; contact: its lines; steps: words after the number of steps; more: further lines.
    """
    model, plate = fe_plan.model, fe_plan.plate
    elements, step = model.loop.table.connectivity.shape[1], model.loop.time_step
    seconds = resources.loop_seconds(
        fe_plan.case.scene, plate.element, plate.counts, fe_plan.expected_steps, rows
    )
    return [
        f"plate        {elements} elements, {model.loop.mass.size} nodes, {units.measure(model.mass, 'kg', '.1f')}, "
        f"{plate.element}, {plate.lumping} masses{start}",
        f"stiffness    Young's modulus {units.measure(plate.modulus, 'Pa', '.6g')}, first frequency of the "
        f"free plate in its plane {fe_plan.first_frequency:.4g} Hz",
        *contact,
        f"time step    {step:.4g} s, {step / model.stable_time_step:.2f} of the stable {model.stable_time_step:.4g} s",
        f"steps        {fe_plan.expected_steps} time steps, about {seconds:.2g} s in the time loop{steps}",
        *more,
        *(f"chosen       {decision.shown}" for decision in fe_plan.decisions),
    ]


def omitted_text(omitted: Parts) -> list[str]:
    """Lines of `tailslap check` on the omitted parts."""
    return [f"omitted      {part}: {why}" for part, why in omitted]


def as_numbers(lines: list[str]) -> dict[str, list[str]]:
    """Collect the texts of the lines by their labels."""
    found: dict[str, list[str]] = {}
    for line in lines:
        found.setdefault(line[:LABEL].strip(), []).append(line[LABEL:])
    return found


def run_summary(outcome: Outcome, headline: Headline, omitted: Parts) -> dict[str, Any]:
    """Make the part of a summary that runs of both kinds have, SI."""
    fe_plan, model = outcome.fe_plan, outcome.fe_plan.model
    return {
        **vars(headline),
        "scene": fe_plan.case.scene.name,
        "version": tailslap.__version__,
        "passed": outcome.passed,
        "checks": [asdict(check) for check in outcome.checks],
        "design_forces": design_ratios(outcome.fe_plan.case, outcome.lateral_force),
        "chosen": [asdict(decision) for decision in fe_plan.decisions],
        "cost": run_cost(outcome),
        "left_out": [{"part": part, "why": why} for part, why in omitted],
        "plate": {
            "mass": model.mass,
            "youngs_modulus": fe_plan.plate.youngs_modulus,
            "first_frequency": fe_plan.first_frequency,
            "highest_frequency": model.highest_frequency,
            "stable_time_step": model.stable_time_step,
        },
    }


def run_cost(outcome: Outcome) -> dict[str, float | int]:
    """Sizes and times of a run."""
    loop = outcome.fe_plan.model.loop
    return {
        "elements": int(loop.table.connectivity.shape[1]),
        "nodes": int(loop.mass.size),
        "steps": outcome.run.steps,
        "time_step": loop.time_step,
        "setup_s": outcome.setup_s,
        "time_loop_s": outcome.run.time_loop_s,
    }


def run_page(
    outcome: Outcome,
    kicker: str,
    headline: Headline,
    sections: Sequence[Section],
    omitted: Parts,
    about: str,
    diagnosis: Sequence[str],
    drawn: Mapping[str, float] | None = None,
) -> Page:
    """Page of a run: failed checks and their diagnosis, set-up, sections, cost with that of pictures, omitted parts and
    inputs."""
    fe_plan = outcome.fe_plan
    scene, source = fe_plan.case.scene, fe_plan.case.source
    chosen = {decision.key: decision.value for decision in fe_plan.decisions}
    inputs = write.resolved_inputs(scene, source, fe_plan.plate, chosen)
    spent = {**run_cost(outcome), **(drawn or {})}
    spent_text = {COST[name][0]: COST[name][1](value) for name, value in spent.items() if name in COST}
    parts = [{"part": part, "why": why} for part, why in omitted]
    left_out = Table((Column("part", "Part"), Column("why", "Why")), parts)
    record = [
        Section("Cost", tables=[pairs(spent_text)], is_folded=True),
        Section("Omitted parts", "" if parts else "None.", tables=[left_out], is_folded=True),
        Section("Inputs", tables=[Table(INPUTS, inputs)], is_folded=True),
    ]
    below, given = f"{footer()} {about}", write.scene_text(source)
    failed = failed_section(outcome.checks, diagnosis)
    every = [failed, Section("Set-up", figures=[fe_plan.case.drawing()]), *sections, *record]
    found = [check for check in outcome.checks if check.passed is outcome.passed]
    checked = f"{len(found)} of {len(outcome.checks)} checks"
    return Page(kicker, headline, every, below, given, outcome.passed, True, checked)


def terminal_text(
    outcome: Outcome, tables: Sequence[Table], diagnosis: Sequence[str] = (), drawn: str = ""
) -> tuple[Table | str, ...]:
    """Text of a run on the terminal, below the headline: tables, decisions, checks and cost.

    diagnosis: cause of a failure; drawn: cost of pictures.
    """
    return (
        *(() if outcome.passed else (*diagnosis, "")),
        *tables,
        *(f"Chosen: {decision.shown}" for decision in outcome.fe_plan.decisions),
        passed_text(outcome.checks),
        f"Cost:   {outcome.run.steps} steps in {outcome.run.time_loop_s:.3f} s, set-up {outcome.setup_s:.2f} s{drawn}",
    )


def plate_sentence(fe_plan: FePlan) -> str:
    """The finite-element model in a sentence."""
    (along, across), element = fe_plan.plate.counts, fe_plan.plate.element
    frequency = f"first natural frequency {fe_plan.first_frequency:.4g} Hz"
    if fe_plan.case.scene.trailer:
        total = len(fe_plan.model.discretisation.cells)
        return f"Hinged plates of {total} {element} elements, {frequency}."
    return f"Plate of {along} x {across} {element} elements, {frequency}."


def chosen_sentences(fe_plan: FePlan) -> list[str]:
    """List the choices of the program as sentences."""
    return [f"Chosen by the program: {decision.shown}." for decision in fe_plan.decisions]


def footer(files: str = "") -> str:
    """Version, date, command line, and the files beside the page."""
    typed = typed_command()
    command = f"`{typed}`" if typed else "from Python"
    beside = f" Files beside this page: {files}." if files else ""
    return f"tailslap {tailslap.__version__}, {datetime.date.today().isoformat()}, {command}.{beside}"


def study_page(
    case: Case,
    kicker: str,
    headline: Headline,
    sections: Sequence[Section],
    files: str,
    passed: bool | None = None,
) -> Page:
    """Page of a study of a case; files: those beside it."""
    every = [Section("Set-up", figures=[case.drawing()]), *sections]
    return Page(kicker, headline, every, footer(files), case.source.text, passed)


def study_summary(study: str, case: Case) -> dict[str, Any]:
    """Begin the summary of a study."""
    return {"study": study, "scene": case.scene.name, "version": tailslap.__version__}


def design_ratios(case: Case, lateral: float) -> list[dict[str, Any]]:
    """Design forces of the scene's test level, and a lateral force [N] over each; none without a test level."""
    impact = case.scene.impact
    return [
        {"name": name, "force": each.force, "ratio": lateral / each.force, "source": each.source}
        for name, each in known_forces(impact.test_level if impact else None).items()
    ]


OF_TRACTORS = ("TL-5", "TL-6")
"""Test levels of tractors with trailers, whose forces stand beside each other."""


def known_forces(level: str | None) -> dict[str, DesignForce]:
    """Design forces of a test level by name, of tractors with trailers those of both levels."""
    levels = OF_TRACTORS if level in OF_TRACTORS else (level,) if level else ()
    return {f"{each.name}, {one}": each for one in levels for each in design_forces(one)}


def design_table(case: Case, lateral: float) -> Table:
    """Table of design forces, which names the force [N] whose ratio to them it shows."""
    name, force, ratio, source = DESIGN
    ratio = replace(ratio, label=f"{case.force_name} / design")
    return Table((name, force, ratio, source), design_ratios(case, lateral))


def strikes_table(strikes: Mapping[str, Sequence[Mapping[str, Any]]]) -> Table:
    """Strikes of each model, as its summary has them, in order of time."""
    rows: list[dict[str, Any]] = [
        {"point_of_attack": None, **strike, "model": model, "number": n}
        | {"title": f"{n} {strike['corner']}{CUT if strike.get('cut') else ''}"}
        for model, its in strikes.items()
        for n, strike in enumerate(its, 1)
    ]
    notes = (ATTACK, *([AT_LEAST] if any(row.get("cut") for row in rows) else []))
    return Table(STRIKES, sorted(rows, key=lambda row: row["number"]), notes=notes)


def short(table: Table) -> Table:
    """A table for the terminal, without its last column, which is long."""
    return Table(table.columns[:-1], table.rows)


def failed_section(checks: Sequence[Check], diagnosis: Sequence[str]) -> Section:
    """The checks that failed with their remedies, and the diagnosis; empty if none failed."""
    rows = [as_read(vars(check)) for check in checks if not check.passed]
    title, sentences = "Failed checks and remedies", diagnosis if rows else ()
    return Section(title, tables=[Table(FAILED, rows)], sentences=sentences)


def passed_text(checks: Sequence[Check]) -> str:
    """Number of checks that passed, as a sentence."""
    return f"Checks: {sum(check.passed for check in checks)} of {len(checks)} passed"


def checks_section(checks: Sequence[Check], groups: Mapping[str, str]) -> Section:
    """All checks by the group of each name, which is the title of its table."""
    tables = []
    for title in dict.fromkeys(groups.get(check.name, "Others") for check in checks):
        own = [check for check in checks if groups.get(check.name, "Others") == title]
        marks = {number: "failed" for number, check in enumerate(own) if not check.passed}
        tables.append(Table(CHECKS, [as_read(vars(check)) for check in own], title, marks=marks))
    return Section(passed_text(checks), tables=tables, is_folded=True)


def field_series(model: PlateModel, snapshots: Snapshots) -> series.FieldSeries:
    """Displacement, velocity, stress and energy density at the kept instants."""
    cell_type, cells = _cells(model)
    nodes = int(cells.max()) + 1
    place = _rigid_place(model, snapshots.positions[0])
    rigid = np.array([_rigid_place(model, positions) for positions in snapshots.positions])
    nodal = {
        "displacement": snapshots.positions - place,
        "elastic_displacement": snapshots.positions - rigid,
        "velocity": snapshots.velocities,
    }
    return series.FieldSeries(
        cell_type,
        place.T[:nodes].copy(),
        cells,
        snapshots.t,
        {name: np.ascontiguousarray(field.transpose(0, 2, 1)[:, :nodes]) for name, field in nodal.items()},
        element_fields(model, snapshots.positions),
    )


def series_of_ends(outcome: Any) -> series.FieldSeries:
    """Fields at the start and at the tail-slap of a run that reached it."""
    from fem.run.observers import Snapshots

    plan, strike = outcome.fe_plan, outcome.run.strike
    start = start_kinds.start_fields(plan.model, plan.start, plan.plate.start)
    states = zip(start, (strike.positions, strike.velocities), strict=True)
    return field_series(plan.model, Snapshots(np.array([0.0, strike.values["t"]]), *map(np.array, states)))


def keep_fields(outcome: Any, folder: Path) -> None:
    """Write the fields of a run into the folder, where some were kept."""
    if outcome.run.snapshots is not None:
        series.write_fields(folder / series.FILE, field_series(outcome.fe_plan.model, outcome.run.snapshots))


def _cells(model: PlateModel) -> tuple[str, np.ndarray]:
    """Type and nodes of the elements; the corners alone of one that other programs do not know."""
    scalar = model.discretisation.scalar
    element = type(scalar.elem).__name__
    kind = next((kind for kind in ELEMENT_KINDS.values() if kind.element == element), None)
    if kind and kind.cell_type:
        return kind.cell_type, np.ascontiguousarray(model.loop.table.connectivity.T)
    cells = model.discretisation.cells
    return ("quad" if cells.shape[1] == 4 else "triangle"), np.ascontiguousarray(cells)


def _rigid_place(model: Any, positions: np.ndarray) -> np.ndarray:
    """The unstrained plate where it fits these positions best, by mass, shape (2, nodes) [m]."""
    fraction = model.loop.mass / model.loop.mass.sum()
    body = model.discretisation.positions
    body = body - (body @ fraction)[:, None]
    centre = (positions @ fraction)[:, None]
    (a, b), (c, d) = (fraction * (positions - centre)) @ body.T
    angle = np.arctan2(c - b, a + d)
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.asarray(centre + np.array([[cosine, -sine], [sine, cosine]]) @ body)


def element_fields(model: PlateModel, positions: np.ndarray) -> dict[str, np.ndarray]:
    """Fields of the elements at positions of the nodes, shape (instants, 2, nodes) [m]: shape (instants, elements)."""
    from fem.stability.element_stress import element_stress

    found = np.array([element_stress(model, each) for each in positions])
    s_xx, s_yy, s_xy, density = found.transpose(1, 0, 2)
    middle, radius = 0.5 * (s_xx + s_yy), np.hypot(0.5 * (s_xx - s_yy), s_xy)
    return {
        "stress_von_mises": np.sqrt(middle**2 + 3.0 * radius**2),
        "stress_principal_1": middle + radius,
        "stress_principal_2": middle - radius,
        "strain_energy_density": density,
    }
