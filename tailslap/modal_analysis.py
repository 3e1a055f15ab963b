"""Modal model of the plate (floating frame with elastic modes) with its estimated error, and free modes of the plate
compared with beam theory."""

import math
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import repeat
from typing import Any, NamedTuple

import numpy as np

import tailslap
from fem.modal import beams
from fem.modal.modal_model import ModalMotion, integrate, modal_plate, modal_start, with_fewer_modes
from fem.modal.mode_kinds import mode_kinds
from fem.model.plate_model import PlateModel
from fem.plate.free_modes import FreeModes, free_modes, most_modes
from fem.start.inertia_relief import relieved_fields
from postprocess.comparison.quantities import KEYS, comparison_rows, largest_relative, relative_difference
from postprocess.figures.plates import draw_mode
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.report.terminal import part_in_units, printed
from postprocess.units import SYSTEMS, measure, percent, percent_up
from tailslap import progress
from tailslap.case.case import MOST_ELEMENTS, Case, Check, failed_sentence, unreliable
from tailslap.case.corner.plan import CornerPlan
from tailslap.case.impact.plan import ImpactPlan
from tailslap.case.model import plate_density, refined
from tailslap.case.report import study_page
from tailslap.errors import InputError

MODES, STEPS, TOLERANCE = 4, 100, 1e-5
"""Default number of elastic modes and of time steps to the tail-slap, and allowed relative error."""

MORE_MODES = 4
"""The result is compared with that of twice as many modes plus this number."""

COLUMNS = (
    Column("quantity.symbol", "at the tail-slap"),
    Column("quantity.unit", "unit", is_unit=True),
    *columns({"fe": "modal", "rigid": "rigid, exact"}, form=".7g", unit_key="quantity.unit"),
    Column("difference", "modal/rigid - 1", form="+.1e"),
)


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
"""Relative error of frequencies to which a mesh is refined that the program chooses."""

LEAST_ERROR = 1e-5
"""Least stated error of a frequency [-]."""

EXTRA_MODES = 4
"""Modes of the finer mesh beyond the number of printed ones, among which those of the same kind are."""

MESH_FACTOR = 2.0
"""Ratio of the stated error to the change on a mesh twice as fine, which bounds errors of first order."""


class ModalEstimate(NamedTuple):
    """Estimated relative errors of the five quantities, by source.

    modes: truncation, from the change at any time with more modes. linear: linearisation of the elastic strain. steps:
    time step, from the change with half as many steps.
    """

    modes: float
    linear: float
    steps: float

    @property
    def total(self) -> float:
        """Sum of the three errors."""
        return self.modes + self.linear + self.steps


@dataclass(frozen=True)
class ModalRun:
    """Result of the modal model: the five quantities at the tail-slap (empty if it was not reached), and rigid values.

    frequencies [Hz]: of the modes. Times [s]: setup_s of modes, flexibility and start; integration_s of the run;
    estimate_s of the two runs for the error estimate.
    """

    values: dict[str, float]
    rigid: dict[str, float]
    difference: dict[str, float]
    history: dict[str, np.ndarray]
    frequencies: np.ndarray
    estimate: ModalEstimate
    checks: tuple[Check, ...]
    steps: int
    iterations: int
    setup_s: float
    integration_s: float
    estimate_s: float

    @property
    def passed(self) -> bool:
        """True where every check passed."""
        return all(check.passed for check in self.checks)


def modal_run(
    fe_plan: CornerPlan, modes: int = MODES, tolerance: float = TOLERANCE, steps: int = STEPS
) -> ModalRun:
    """Run the modal model of the plan's plate.

    steps: to the rigid tail-slap. Raises InputError for features that the modal model does not support.
    """
    _admit(fe_plan, modes)
    model, start, duration = fe_plan.model, fe_plan.start, fe_plan.case.motion.strike.t
    began = time.perf_counter()
    finer = modal_plate(model, 2 * modes + MORE_MODES)
    plate, relieved = with_fewer_modes(finer, modes), relieved_fields(model, start)
    (state, finer_state) = (modal_start(model, kept, start, relieved) for kept in (plate, finer))
    setup = time.perf_counter() - began
    motion = integrate(plate, state, duration, steps, progress.compiling)
    halved = integrate(plate, state, duration, max(1, steps // 2))
    others = integrate(finer, finer_state, duration, steps), halved
    estimate = _estimate(fe_plan, float(finer.frequencies[0]), motion, *others)
    rigid = fe_plan.case.tail_slap
    values = {name: motion.strike[name] for name in KEYS} if motion.strike else {}
    return ModalRun(
        values=values,
        rigid=rigid,
        difference=relative_difference(values, rigid) if values else {},
        history=motion.history,
        frequencies=plate.frequencies / (2.0 * math.pi),
        estimate=estimate,
        checks=_checks(motion, estimate, tolerance),
        steps=motion.steps,
        iterations=motion.iterations,
        setup_s=setup,
        integration_s=motion.integration_s,
        estimate_s=sum(other.integration_s for other in others),
    )


def _admit(fe_plan: CornerPlan, modes: int) -> None:
    """Raise InputError for features that the modal model does not support."""
    scene, plate = fe_plan.case.scene, fe_plan.plate
    most = max(0, (most_modes(fe_plan.model.loop.mass.size) - MORE_MODES) // 2)
    if not 0 <= modes <= most:
        raise InputError("--modes", modes, f"allowed for this mesh are 0 to {most}")
    if plate.start != "inertia-relief":
        allowed = 'allowed with the modal model is "inertia-relief"'
        raise InputError("plate.start", plate.start, allowed)
    if fe_plan.asked.scene.damping:
        raise InputError("damping", "a table", "the modal model does not support damping; remove it")
    if scene.corner.damping_ratio:
        allowed = "the modal model does not support a dashpot; remove it"
        raise InputError("corner.damping_ratio", scene.corner.damping_ratio, allowed)


def _estimate(
    fe_plan: CornerPlan, lowest: float, motion: ModalMotion, finer: ModalMotion, coarser: ModalMotion
) -> ModalEstimate:
    """Error estimate; lowest: frequency of the first mode [rad/s].

    Inertia relief solves the linear equations of an elastic state with the deflection ratio d. The non-linear plate
    differs by d of this state and rings with it from the start: a displacement of d^2, and a velocity larger by
    frequency times duration.
    """
    if not (motion.strike and finer.strike and coarser.strike):
        return ModalEstimate(math.nan, math.nan, math.nan)
    size = min(motion.history["t"].size, finer.history["t"].size) - 1
    apart = ((name, np.abs(motion.history[name][:size] - finer.history[name][:size])) for name in KEYS)
    moved = max(each.max() / abs(motion.strike[name]) for name, each in apart)
    modes, steps = (largest_relative(run.strike or {}, motion.strike) for run in (finer, coarser))
    cycles = max(1.0, lowest * fe_plan.case.motion.strike.t)
    return ModalEstimate(float(max(moved, modes)), fe_plan.deflection_ratio**2 * cycles, steps)


def _checks(motion: ModalMotion, estimate: ModalEstimate, tolerance: float) -> tuple[Check, ...]:
    angle = 0.0 if motion.strike else float(motion.history["theta"][-1])
    more = "relative change of the result with more modes", "a larger --modes"
    linear = (
        "relative error of the linear strain of modes",
        "`tailslap run`, for the plate is too soft for modes",
    )
    half = "relative change of the result with half as many time steps", "a larger --steps"
    stiff = "a stiffer plate, or `tailslap run`"
    return (
        Check(
            "tail-slap reached", angle, 0.0, motion.strike is not None, f"{motion.end}; angle [rad]", stiff
        ),
        Check.at_most("omitted modes", estimate.modes, tolerance, *more),
        Check.at_most("linear modes", estimate.linear, tolerance, *linear),
        Check.at_most("time steps", estimate.steps, tolerance, *half),
    )


def modal_text(fe_plan: CornerPlan, run: ModalRun, units: str = "si") -> str:
    """Text of the results in units "si" or "us"."""
    rows = comparison_rows(run.values, run.rigid, None) if run.values else ()
    parts: tuple[Table | str, ...] = (
        *modal_headline(fe_plan, run).lines,
        "",
        Table(COLUMNS, rows),
        f"Cost:   {run.steps} steps in {1e3 * run.integration_s:.2f} ms, set-up {1e3 * run.setup_s:.1f} ms, "
        f"error estimate {1e3 * run.estimate_s:.2f} ms",
    )
    return printed(parts if units == "si" else [part_in_units(part, SYSTEMS[units]) for part in parts])


def modal_headline(fe_plan: CornerPlan, run: ModalRun) -> Headline:
    """Peak force of the tail-slap, the modes, and the estimate of the error."""
    case, estimate = fe_plan.case, run.estimate
    sentence, certainty = "No tail-slap within the run.", ""
    if run.values:
        sentence = case.force_sentence(case.peak_force(run.values["v_gy"]))
        certainty = (
            f"Estimated error {percent_up(estimate.total)}: omitted modes {percent_up(estimate.modes)}, linear strain "
            f"{percent_up(estimate.linear)}, time steps {percent_up(estimate.steps)}."
        )
    if run.values and not run.passed:
        sentence = unreliable(sentence)
    kept = ", ".join(f"{frequency:.4g}" for frequency in run.frequencies)
    modes = f"Modal model: modes of {kept} Hz." if kept else "Modal model without elastic modes."
    answer = failed_sentence(run.checks) + sentence
    return Headline(case.headline().title, answer, f"{case.set_up} {modes}", certainty)


def modal_numbers(fe_plan: CornerPlan, run: ModalRun) -> dict[str, Any]:
    """Results as numbers, in SI; None without a tail-slap."""
    unknown = dict.fromkeys(run.rigid)
    cost = ("steps", "iterations", "setup_s", "integration_s", "estimate_s")
    return {
        **vars(modal_headline(fe_plan, run)),
        "scene": fe_plan.case.scene.name,
        "passed": run.passed,
        "modal": run.values or unknown,
        "rigid": run.rigid,
        "difference": run.difference or unknown,
        "estimate": run.estimate._asdict() | {"total": run.estimate.total},
        "frequencies_hz": run.frequencies,
        "checks": [asdict(check) for check in run.checks],
        "cost": {"modes": run.frequencies.size} | {name: getattr(run, name) for name in cost},
    }


def modes_report(case: Case, count: int) -> Report:
    """Report the lowest `count` elastic modes with the errors of their frequencies.

    Raises InputError for a number of modes that the mesh does not allow.
    """
    fe_plan, shapes, modes = modes_with_errors(case, count)
    model, plate, case = fe_plan.model, fe_plan.plate, fe_plan.case
    beam = _beam(fe_plan)
    what = "train" if case.scene.trailer else "plate"
    shown = MODE_COLUMNS[:4] if case.scene.trailer else MODE_COLUMNS
    table = Table(shown, [mode | {"name": _name(mode)} for mode in modes])
    headline = _modes_headline(case, modes, what)
    rigid = shapes.rigid_frequencies / (2.0 * math.pi)
    sections = (
        Section("Natural frequencies", tables=(table,)),
        _shapes(model, modes, shapes.shapes),
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
            "elements": int(model.loop.table.connectivity.shape[1]),
            "nodes": int(model.loop.mass.size),
        },
    }
    return Report(page, summary, (table,))


def modes_with_errors(case: Case, count: int) -> tuple[Any, FreeModes, list[dict[str, Any]]]:
    """Return plan, shapes and records of the modes, with the error by a mesh that is twice as fine.

    A mesh that the program chooses is refined until the errors are small.
    """
    keys: dict[str, Any] = {}
    fe_plan = case.plan()
    shapes, modes = _modes_of(fe_plan, count)
    while True:
        keys |= {decision.key: decision.value for decision in fe_plan.decisions}
        chosen = {key: value for key, value in keys.items() if key.endswith(("_length", "plate.element"))}
        counts = refined(fe_plan.plate).counts
        finer = case.varied({**chosen, "plate.elements": counts}).plan()
        finer_shapes, finer_modes = _modes_of(finer, count + EXTRA_MODES)
        _state_errors(modes, finer_modes)
        worst = max(mode["error"] for mode in modes)
        if case.scene.needed_plate.elements or worst <= MODES_ERROR or 4 * math.prod(counts) > MOST_ELEMENTS:
            return fe_plan, shapes, modes
        fe_plan, shapes, modes = finer, finer_shapes, finer_modes[:count]


def _modes_of(fe_plan: CornerPlan | ImpactPlan, count: int) -> tuple[FreeModes, list[dict[str, Any]]]:
    """Return the modes of a plan and their records. Raises InputError for a number that the mesh does not allow."""
    most = most_modes(fe_plan.model.loop.mass.size)
    if not 1 <= count <= most:
        raise InputError("--count", count, f"allowed for this mesh are 1 to {most}")
    shapes = free_modes(fe_plan.model, count)
    return shapes, [*_modes(fe_plan, shapes, _beam(fe_plan))]


def _beam(fe_plan: CornerPlan | ImpactPlan) -> beams.Beam:
    """Return the beam of the plate's dimensions."""
    plate, scene = fe_plan.plate, fe_plan.case.scene
    density = plate_density(scene, plate)
    return beams.Beam(scene.vehicle.length, scene.vehicle.width, plate.modulus, plate.poissons_ratio, density)


def _state_errors(modes: list[dict[str, Any]], finer: list[dict[str, Any]]) -> None:
    """Add the relative error to each mode by its frequency on the finer mesh.

    The mode there is that of the same kind and order, or of the same number. The change of one frequency may be small
    by accident: the error is the geometric mean with the largest change of its family.
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


def _family(mode: dict[str, Any]) -> str:
    """Return "beam" for bending and shear, which are numbered together, or the kind."""
    return "beam" if mode["kind"] in BENDING else str(mode["kind"])


def _modes_headline(case: Case, modes: list[dict[str, Any]], what: str) -> Headline:
    """Return the first natural frequency, beside that of a beam, and the errors of all."""
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


def _modes(fe_plan: CornerPlan | ImpactPlan, found: FreeModes, beam: beams.Beam) -> Iterator[dict[str, Any]]:
    """Yield the elastic modes in the order of frequency, as dicts.

    number from 1; frequency [Hz]; kind, and order: number among modes of this kind; symmetric, along, shear: fractions
    of energy that define the kind (`mode_kinds`); theory, slender [Hz]: beam theory with and without shear and
    rotary inertia, n c / (2 L) for longitudinal modes, None for transverse modes; difference: frequency/theory - 1.
    """
    count = found.frequencies.size
    kinds = mode_kinds(fe_plan.model, found, fe_plan.plate.thickness)
    bent = (beams.timoshenko_frequencies, beams.euler_bernoulli_frequencies)
    theories: dict[str, Iterator[Any]] = {
        "beam": zip(*(of(beam, count).tolist() for of in bent), strict=True),
        "longitudinal": zip(beams.longitudinal_frequencies(beam, count).tolist(), repeat(None)),
        "transverse": repeat((None, None)),
    }
    if fe_plan.case.scene.trailer:
        theories = dict.fromkeys(theories, repeat((None, None)))
    seen = dict.fromkeys(theories, 0)
    for i, (frequency, kind) in enumerate(zip(found.frequencies, kinds.names, strict=True)):
        family = _family({"kind": kind})
        seen[family] += 1
        theory, slender = next(theories[family])
        hertz = float(frequency) / (2.0 * math.pi)
        yield {
            "number": i + 1,
            "frequency": hertz,
            "kind": kind,
            "order": seen[family],
            **{name: float(getattr(kinds, name)[i]) for name in ("symmetric", "along", "shear")},
            "theory": theory,
            "slender": slender,
            "difference": None if theory is None else hertz / theory - 1.0,
        }


def _name(mode: dict[str, Any]) -> str:
    return f"{mode['kind']} {mode['order']}"


def _shapes(model: PlateModel, modes: list[dict[str, Any]], shapes: Any) -> Section:
    """Draw the lowest modes by the normalised displacements of the corner nodes of the elements."""
    cells, pictures = model.discretisation.cells, []
    corners = int(cells.max()) + 1
    places = model.discretisation.positions[:, :corners].T
    for mode, shape in zip(modes[:MAX_PICTURES], shapes, strict=False):
        moved = shape[:, :corners].T
        moved = moved / np.hypot(*moved.T).max()
        caption = f"{mode['number']}: {_name(mode)}, {mode['frequency']:.4g} Hz"
        pictures.append(draw_mode(f"mode-{mode['number']}", caption, places, cells, moved))
    drawn = "Grey: undeformed plate. Displacements are scaled to a maximum of 0.3 times the width."
    if len(modes) > MAX_PICTURES:
        drawn += f" First {MAX_PICTURES} modes."
    return Section("Mode shapes", drawn, pictures)


def _sentences(fe_plan: CornerPlan | ImpactPlan, frequencies: Any, beam: beams.Beam) -> tuple[str, ...]:
    """Description of the method; frequencies [Hz]: of the rigid modes."""
    plate, model = fe_plan.plate, fe_plan.model
    rigid = ", ".join(f"{frequency:.0e}" for frequency in frequencies)
    is_train = bool(fe_plan.case.scene.trailer)
    sentences = (
        f"Free {'hinged plates' if is_train else 'plate'} without wall and corner constraint: "
        f"{model.loop.table.connectivity.shape[1]} elements ({plate.element}), {plate.lumping} masses. Frequencies of "
        f"all {len(frequencies)} modes of rigid motion: {rigid} Hz. Error: {MESH_FACTOR:g} times the "
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
