"""Compute free modes of the plate."""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import tailslap
from fem.modal import beams
from fem.modal.mode_kinds import mode_kinds
from fem.model.plate_model import PlateModel
from fem.plate.free_modes import FreeModes, free_modes, most_modes
from postprocess.fields import contours
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Picture, Section
from postprocess.report.tables import Column, Table
from postprocess.units import measure, percent, percent_up
from tailslap.arguments import checked_arguments
from tailslap.case.case import MOST_ELEMENTS, Case, FePlan
from tailslap.case.of_arguments import Changes, Scene, affordable_case
from tailslap.case.plate_input import plate_density, refined
from tailslap.case.report_parts import study_page
from tailslap.errors import InputError
from tailslap.result.result import Result, filled_by, of_report

Mode = dict[str, Any]
"""Record of a mode, as in the summary."""

BENDING = ("bending", "shear")
"""Kinds of beam modes, numbered together as in Timoshenko's theory."""

MAX_PICTURES = 24
"""Number of drawn modes, lowest first."""

MODE_COLUMNS = (
    Column("number", "Mode"),
    Column("frequency", "Frequency", "Hz", "#.5g", style="strong"),
    Column("error", "Error", form=percent_up),
    Column("name", "Kind"),
    Column("theory", "Beam theory", "Hz", "#.5g"),
    Column("difference", "Difference", form=percent),
    Column("slender", "Slender beam", "Hz", "#.5g", style="soft"),
)

MODES_ERROR = 5e-3
"""Relative error of frequencies to which an automatic mesh is refined."""

LEAST_ERROR = 1e-5
"""Least stated error of a frequency [-]."""

EXTRA_MODES = 4
"""Additional modes of the finer mesh, among which those of the same kind are."""

MESH_FACTOR = 2.0
"""Ratio of the stated error to the change on a mesh twice as fine, which bounds errors of first order."""


def modes_report(case: Case, count: int) -> tuple[Report, Callable[[Path], Section]]:
    """Report the lowest elastic modes with the errors of their frequencies.

    A function beside the report draws their shapes into a folder. Raises InputError for a number of modes that the mesh
    does not allow.
    """
    fe_plan, shapes, modes = modes_with_errors(case, count)
    model, plate, case = fe_plan.model, fe_plan.plate, fe_plan.case
    beam = _beam(fe_plan)
    what = "train" if case.scene.trailer else "plate"
    table_columns = MODE_COLUMNS[:4] if case.scene.trailer else MODE_COLUMNS
    table = Table(table_columns, [mode | {"name": _name(mode)} for mode in modes])
    headline = _modes_headline(case, modes, what)
    rigid = shapes.rigid_frequencies / (2.0 * math.pi)
    sections = (
        Section("Natural frequencies", tables=(table,)),
        Section("Method", sentences=_sentences(fe_plan, rigid, beam)),
    )
    files = "summary.json"
    page = study_page(case, f"Modes of the free {what} in its plane", headline, sections, files)
    summary = {
        "scene": case.scene.name,
        "version": tailslap.__version__,
        "modes": modes,
        "numerical_error": max(mode["error"] for mode in modes),
        "rigid_frequencies": rigid,
        "plate": {
            "youngs_modulus": plate.youngs_modulus,
            "first_frequency": modes[0]["frequency"],
            "mass": model.mass,
            "elements": int(model.parameters.table.connectivity.shape[1]),
            "nodes": int(model.parameters.mass.size),
        },
    }
    return Report(page, summary, (table,)), functools.partial(_shapes, model, modes, shapes.shapes)


def modes_with_errors(case: Case, count: int) -> tuple[FePlan, FreeModes, list[Mode]]:
    """Return plan, shapes and records of modes.

    Errors are estimated on a mesh that is twice as fine. An automatic mesh is refined until they are small.
    """
    keys: dict[str, object] = {}
    fe_plan = _plan(case)
    shapes, modes = _modes_of(fe_plan, count)
    while True:
        keys |= {decision.key: decision.value for decision in fe_plan.decisions}
        chosen = {key: value for key, value in keys.items() if key.endswith(("_length", "plate.element"))}
        counts = refined(fe_plan.plate).counts
        finer = _plan(case.varied({**chosen, "plate.elements": counts}))
        finer_shapes, finer_modes = _modes_of(finer, count + EXTRA_MODES)
        _state_errors(modes, finer_modes)
        worst = max(mode["error"] for mode in modes)
        if case.scene.needed_plate.elements or worst <= MODES_ERROR or 4 * math.prod(counts) > MOST_ELEMENTS:
            return fe_plan, shapes, modes
        fe_plan, shapes, modes = finer, finer_shapes, finer_modes[:count]


def _plan(case: Case) -> FePlan:
    """Return the plan of a run.

    The growth of oscillations by friction, on which no mode depends, is not predicted.
    """
    from tailslap.case.corner.corner_case import CornerCase
    from tailslap.case.corner.corner_plan import make_corner_plan
    from tailslap.case.corner.decisions import Growth

    if isinstance(case, CornerCase):
        return make_corner_plan(case, growth=Growth(0.0, 0.0, 0.0))
    return case.plan()


def _modes_of(fe_plan: FePlan, count: int) -> tuple[FreeModes, list[Mode]]:
    """Return the modes of a plan.

    Raises InputError for a number that the mesh does not allow.
    """
    most = most_modes(fe_plan.model.parameters.mass.size)
    if not 1 <= count <= most:
        raise InputError("--count", count, f"allowed for this mesh are 1 to {most}")
    shapes = free_modes(fe_plan.model, count)
    return shapes, [*_modes(fe_plan, shapes, _beam(fe_plan))]


def _beam(fe_plan: FePlan) -> beams.Beam:
    """Return the beam of the plate's dimensions."""
    plate, scene = fe_plan.plate, fe_plan.case.scene
    density = plate_density(scene, plate)
    return beams.Beam(scene.vehicle.length, scene.vehicle.width, plate.modulus, plate.poissons_ratio, density)


def _state_errors(modes: list[Mode], finer: list[Mode]) -> None:
    """Add the relative error to each mode.

    It is estimated from the frequency on the finer mesh, of the mode of the same kind and order, or of the same number.
    The change of one frequency may be small by accident: the error is the geometric mean with the largest change of its
    family.
    """
    frequencies = {(_family(mode), mode["order"]): mode["frequency"] for mode in finer}
    largest: dict[str, float] = {}
    for mode, same_number in zip(modes, finer, strict=False):
        family = _family(mode)
        frequency = frequencies.get((family, mode["order"]), same_number["frequency"])
        mode["error"] = MESH_FACTOR * abs(frequency / mode["frequency"] - 1.0)
        largest[family] = max(mode["error"], largest.get(family, 0.0))
    for mode in modes:
        mode["error"] = max(LEAST_ERROR, math.sqrt(mode["error"] * largest[_family(mode)]))


def _family(mode: Mode) -> str:
    """Return "beam" for bending and shear, else the kind.

    Bending and shear are numbered together.
    """
    return "beam" if mode["kind"] in BENDING else str(mode["kind"])


def _modes_headline(case: Case, modes: list[Mode], what: str) -> Headline:
    """Return the headline with the first natural frequency and its error."""
    first = modes[0]
    answer = f"First natural frequency of the free {what} in its plane: {first['frequency']:.4g} Hz ({_name(first)})."
    worst = max(mode["error"] for mode in modes)
    certainty = (
        f"Discretisation error {percent_up(first['error'])}, of all modes at most {percent_up(worst)}."
    )
    if first["theory"]:
        certainty += (
            f" Beam theory: {first['theory']:.4g} Hz; the plate differs by {percent(first['difference'])}."
        )
    return Headline(f"Natural frequencies: {case.subject}", answer, case.set_up, certainty)


def _modes(fe_plan: FePlan, free: FreeModes, beam: beams.Beam) -> Iterator[Mode]:
    """Yield records of the elastic modes in the order of frequency.

    number from 1; frequency [Hz]; kind, and order: number among modes of this kind; symmetric, along, shear: fractions
    of energy that define the kind (`mode_kinds`); theory, slender [Hz]: beam theory with and without shear and
    rotary inertia, n c / (2 L) for longitudinal modes, None for transverse modes; difference: frequency/theory - 1.
    """
    count = free.frequencies.size
    kinds, fractions = mode_kinds(fe_plan.model, free)
    bent = (beams.timoshenko_frequencies, beams.euler_bernoulli_frequencies)
    theories: dict[str, Iterator[tuple[float | None, float | None]]] = {
        "beam": zip(*(of(beam, count).tolist() for of in bent), strict=True),
        "longitudinal": zip(beams.longitudinal_frequencies(beam, count).tolist(), repeat(None)),
        "transverse": repeat((None, None)),
    }
    if fe_plan.case.scene.trailer:
        theories = dict.fromkeys(theories, repeat((None, None)))
    seen = dict.fromkeys(theories, 0)
    for i, (frequency, kind) in enumerate(zip(free.frequencies, kinds, strict=True)):
        family = _family({"kind": kind})
        seen[family] += 1
        theory, slender = next(theories[family])
        hertz = float(frequency) / (2.0 * math.pi)
        yield {
            "number": i + 1,
            "frequency": hertz,
            "kind": kind,
            "order": seen[family],
            **{name: float(values[i]) for name, values in fractions.items()},
            "theory": theory,
            "slender": slender,
            "difference": None if theory is None else hertz / theory - 1.0,
        }


def _name(mode: Mode) -> str:
    """Return kind and number of a mode."""
    return f"{mode['kind']} {mode['order']}"


def _shapes(model: PlateModel, modes: list[Mode], shapes: NDArray[np.float64], folder: Path) -> Section:
    """Draw the lowest modes by normalised displacements of the corner nodes."""
    cells, drawn = model.discretisation.cells, dict[str, tuple[str, NDArray[np.float64]]]()
    corners = int(cells.max()) + 1
    for mode, shape in zip(modes[:MAX_PICTURES], shapes, strict=False):
        displacement = shape[:, :corners].T
        title = f"{mode['number']}: {_name(mode)}, {mode['frequency']:.4g} Hz"
        drawn[f"mode-{mode['number']}"] = title, displacement / np.hypot(*displacement.T).max()
    caption = "Grey: undeformed plate. Displacements are scaled to a maximum of 0.3 times the width."
    if len(modes) > MAX_PICTURES:
        caption += f" First {MAX_PICTURES} modes."
    places = model.discretisation.positions[:, :corners].T
    try:
        paths = contours.draw_modes(folder, (places, cells), drawn)
    except ImportError as error:
        warnings.warn(f"no pictures are drawn: {error}", stacklevel=2)
        return Section("Mode shapes")
    titles = (title for title, _ in drawn.values())
    pictures = [Picture(*pair, contours.dark_form(pair[0])) for pair in zip(paths, titles, strict=True)]
    return Section("Mode shapes", caption, pictures, layout="wide")


def _sentences(fe_plan: FePlan, frequencies: NDArray[np.float64], beam: beams.Beam) -> tuple[str, ...]:
    """Describe the method.

    frequencies [Hz]: of the rigid modes.
    """
    plate, model = fe_plan.plate, fe_plan.model
    rigid = ", ".join(f"{frequency:.0e}" for frequency in frequencies)
    is_train = bool(fe_plan.case.scene.trailer)
    sentences = (
        f"Free {'hinged plates' if is_train else 'plate'} without wall and corner constraint: "
        f"{model.parameters.table.connectivity.shape[1]} elements ({plate.element}), {plate.lumping} masses. "
        f"Frequencies of all {len(frequencies)} modes of rigid motion: {rigid} Hz. Error: {MESH_FACTOR:g} times the "
        "change of the frequency on a mesh of twice as many elements in both directions, as geometric mean with the "
        "largest of the modes of its kind, 0.001 % at least.",
        "Kinds: more than half of the kinetic energy of longitudinal and transverse modes is symmetric about the "
        "longitudinal axis, and longitudinal or transverse, respectively. Of the others, shear modes have more than "
        "half of their strain energy in shear; the remaining modes are bending modes. Both are numbered together.",
        f"Beam theory: free beam of length {measure(beam.length, 'm', 'g')} and depth "
        f"{measure(beam.depth, 'm', 'g')}; Timoshenko's theory for bending, Euler-Bernoulli theory for the slender "
        f"beam, n c / (2 L) with c = {measure(beam.wave_speed, 'm/s', '.5g')} for longitudinal modes. Higher modes of "
        "a deep plate deviate from beam theory.",
    )
    return sentences[:2] if is_train else sentences


@checked_arguments
def modes(
    scene: Scene, changes: Changes | None = None, *, count: int = 10, allow_large: bool = False
) -> Result:
    """Compute the free modes of the plate.

    They are those in its plane, of a train those of the hinged plates.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    count : int
        Number of elastic modes, lowest first.
    allow_large : bool
        Run even if the estimate exceeds this machine's memory, threads or time.

    Returns
    -------
    Result
        `summary["modes"]` contains a record per mode: frequency [Hz], its relative error [-], kind, frequency of
        beam theory.

    Raises
    ------
    InputError
        For an invalid scene, key or value, and for more modes than the mesh allows.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.modes("paper-table-3", count=1).summary["modes"][0]["kind"]
    'bending'
    """
    case = affordable_case(scene, changes, allow_large, 6)
    report, draw = modes_report(case, count)

    def drawn(folder: Path, pictures: bool, units: str) -> Report:
        *before, method = report.page.sections
        sections = [*before, *([draw(folder)] if pictures else []), method]
        return replace(report, page=replace(report.page, sections=sections))

    tables = {"Frequencies": report.terminal[0]}
    return of_report("modes", report, fill=filled_by(drawn), tables=tables, changes=case.changes)
