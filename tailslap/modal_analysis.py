"""The modal run: the plate as a floating frame with a few elastic modes, how far to trust its result, its text.

The free modes of a scene's plate, the kind of each, beam theory's answer, and their page.
"""

import math
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import repeat
from typing import Any, NamedTuple

import numpy as np

import tailslap
from fem.modal import model as modal
from fem.modal.model import ModalMotion, integrate, modal_plate, modal_start, with_fewer_modes
from fem.model.plate_model import PlateModel
from fem.plate import elastic
from fem.start.inertia_relief import relieved_fields
from postprocess.comparison.quantities import KEYS, comparison_rows, largest_relative, relative_difference
from postprocess.figures.plates import draw_mode
from postprocess.report.page import Column, Headline, Section, Table, columns
from postprocess.report.report import Report, printed, shown_in
from postprocess.units import SYSTEMS, measure, percent, percent_up
from tailslap.case.case import Case, Check, failed_sentence, unreliable
from tailslap.case.corner.plan import CornerPlan
from tailslap.case.model import plate_density
from tailslap.case.report import study_page
from tailslap.errors import InputError

MODES, STEPS, TOLERANCE = 4, 100, 1e-5
"""Elastic modes, time steps to the tail-slap, and relative error allowed, unless the caller says otherwise."""

MORE_MODES = 4
"""The result is compared with that of twice as many modes and so many more."""

COLUMNS = (
    Column("quantity.symbol", "at the tail-slap"),
    Column("quantity.unit", "unit", is_unit=True),
    *columns({"fe": "modal", "rigid": "rigid, exact"}, form=".7g", unit_key="quantity.unit"),
    Column("difference", "modal/rigid - 1", form="+.1e"),
)


class ModalEstimate(NamedTuple):
    """Estimated relative distance of the five quantities from the finite-element run's, by cause.

    modes: how far they move, at any time of the run, with twice as many modes and four more. linear: what the
    geometric non-linearity of the elastic strain leaves out. steps: how far they move with half as many time steps.
    """

    modes: float
    linear: float
    steps: float

    @property
    def total(self) -> float:
        """The sum of the three."""
        return self.modes + self.linear + self.steps


@dataclass(frozen=True)
class ModalRun:
    """A modal run: the five quantities at the tail-slap (empty if it was not reached), beside the rigid ones.

    frequencies [Hz] of the modes kept. setup_s: modes, flexibility and start; integration_s: of the run itself;
    estimate_s: of the two runs that the estimate takes.
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
    """Run the plan's plate with its lowest elastic modes; `fem.run.corner` runs all of it.

    steps: to the rigid tail-slap. Raises InputError for what the modal model does not have.
    """
    _admit(fe_plan, modes)
    model, start, duration = fe_plan.model, fe_plan.start, fe_plan.case.motion.strike.t
    began = time.perf_counter()
    finer = modal_plate(model, 2 * modes + MORE_MODES)
    plate, relieved = with_fewer_modes(finer, modes), relieved_fields(model, start)
    (state, finer_state) = (modal_start(model, kept, start, relieved) for kept in (plate, finer))
    setup = time.perf_counter() - began
    motion = integrate(plate, state, duration, steps)
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
    """InputError for what the modal model does not have."""
    scene, plate = fe_plan.case.scene, fe_plan.plate
    most = max(0, (elastic.most_modes(fe_plan.model.loop.mass.size) - MORE_MODES) // 2)
    if not 0 <= modes <= most:
        raise InputError("--modes", modes, f"allowed with this mesh is a whole number from 0 to {most}")
    if plate.start != "inertia-relief":
        allowed = 'the modes that the modal model leaves out cannot oscillate; allowed is "inertia-relief"'
        raise InputError("plate.start", plate.start, allowed)
    if fe_plan.asked.scene.damping:
        raise InputError("damping", "a table", "the modal model has no damping; leave it out")
    if scene.corner.damping_ratio:
        allowed = "the modal model has no dashpot; leave it out"
        raise InputError("corner.damping_ratio", scene.corner.damping_ratio, allowed)


def _estimate(
    fe_plan: CornerPlan, lowest: float, motion: ModalMotion, finer: ModalMotion, coarser: ModalMotion
) -> ModalEstimate:
    """The estimate; lowest: frequency of the first mode [rad/s].

    Inertia relief solves here the linear equations of an elastic state that moves the corner by the deflection ratio d
    of its travel. The non-linear plate is off that by d once more, and rings with it from the start: a displacement of
    d^2, and a velocity larger by frequency times duration.
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
        f"estimate {1e3 * run.estimate_s:.2f} ms",
    )
    return printed(parts if units == "si" else [shown_in(part, SYSTEMS[units]) for part in parts])


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
    """The numbers for other programs, SI; what was not reached is None."""
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


BENDING = ("bending", "shear")
"""Kinds that bend the plate as a beam; they are numbered together, as Timoshenko's frequencies are."""

MAX_PICTURES = 24
"""Modes that are drawn: the lowest."""

MODE_COLUMNS = (
    Column("number", "Mode"),
    Column("frequency", "Frequency", "Hz", "#.5g", style="strong"),
    Column("name", "Kind"),
    Column("theory", "Beam theory", "Hz", "#.5g"),
    Column("difference", "Difference", form=percent),
    Column("slender", "Slender beam", "Hz", "#.5g", style="soft"),
)


def modes_report(fe_plan: CornerPlan, count: int) -> Report:
    """Find the lowest `count` elastic modes: page, summary, and text for the terminal.

    Raises InputError for a number that the mesh does not have.
    """
    model, plate, case = fe_plan.model, fe_plan.plate, fe_plan.case
    most = elastic.most_modes(model.loop.mass.size)
    if not 1 <= count <= most:
        raise InputError("--count", count, f"allowed with this mesh is a whole number from 1 to {most}")
    found, vehicle = elastic.free_modes(model, count), case.scene.vehicle
    density = plate_density(case.scene, plate)
    beam = modal.Beam(vehicle.length, vehicle.width, plate.modulus, plate.poissons_ratio, density)
    modes = [*_modes(fe_plan, found, beam)]
    table = Table(MODE_COLUMNS, [mode | {"name": _name(mode)} for mode in modes])
    headline = _modes_headline(case, modes[0])
    rigid = found.rigid_frequencies / (2.0 * math.pi)
    sections = (
        Section("Frequencies, beside those of a free beam", tables=(table,)),
        _shapes(model, modes, found.shapes),
        Section("What was computed, and what it means", sentences=_sentences(fe_plan, rigid, beam)),
    )
    files = "summary.json, these numbers and the shares of energy behind the kinds"
    page = study_page(case, "Modes of the free plate in its plane", headline, sections, files)
    summary = {
        "scene": case.scene.name,
        "version": tailslap.__version__,
        "modes": modes,
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


def _modes_headline(case: Case, first: dict[str, Any]) -> Headline:
    """The first natural frequency, beside that of a beam."""
    answer = f"First natural frequency of the free plate in its plane: {first['frequency']:.4g} Hz ({_name(first)})."
    certainty = ""
    if first["theory"]:
        certainty = (
            f"Beam theory: {first['theory']:.4g} Hz; the plate differs by {percent(first['difference'])}."
        )
    return Headline(f"Natural frequencies: {case.subject}", answer, case.set_up, certainty)


def _modes(fe_plan: CornerPlan, found: elastic.FreeModes, beam: modal.Beam) -> Iterator[dict[str, Any]]:
    """Yield the elastic modes in rising frequency, as dicts, each beside the beam's.

    number from 1; frequency [Hz]; kind, and order: number among its like; symmetric, along, shear: the fractions of
    energy that make it that kind (`modal.mode_kinds`); theory, slender [Hz]: beam theory with shear and rotary inertia,
    and without, for longitudinal modes `theory` is n c / (2 L); None: no beam does that; difference: frequency/theory -
    1.
    """
    count = found.frequencies.size
    kinds = modal.mode_kinds(fe_plan.model, found, fe_plan.plate.thickness)
    bent = (modal.timoshenko_frequencies, modal.euler_bernoulli_frequencies)
    theories: dict[str, Iterator[Any]] = {
        "beam": zip(*(of(beam, count).tolist() for of in bent), strict=True),
        "longitudinal": zip(modal.longitudinal_frequencies(beam, count).tolist(), repeat(None)),
        "transverse": repeat((None, None)),
    }
    seen = dict.fromkeys(theories, 0)
    for i, (frequency, kind) in enumerate(zip(found.frequencies, kinds.names, strict=True)):
        family = "beam" if kind in BENDING else kind
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
    """Draw the lowest modes: displacements of the elements' corner nodes, the largest of length one."""
    cells, pictures = model.discretisation.cells, []
    corners = int(cells.max()) + 1
    places = model.discretisation.positions[:, :corners].T
    for mode, shape in zip(modes[:MAX_PICTURES], shapes, strict=False):
        moved = shape[:, :corners].T
        moved = moved / np.hypot(*moved.T).max()
        caption = f"{mode['number']}: {_name(mode)}, {mode['frequency']:.4g} Hz"
        pictures.append(draw_mode(f"mode-{mode['number']}", caption, places, cells, moved))
    drawn = "Grey: the plate at rest. The largest displacement is drawn as three tenths of the width."
    if len(modes) > MAX_PICTURES:
        drawn += f" Drawn are the first {MAX_PICTURES} modes."
    return Section("Shapes", drawn, pictures)


def _sentences(fe_plan: CornerPlan, frequencies: Any, beam: modal.Beam) -> tuple[str, ...]:
    """Say how it was computed and how to read it; frequencies [Hz]: of the rigid modes."""
    plate, model = fe_plan.plate, fe_plan.model
    rigid = ", ".join(f"{frequency:.0e}" for frequency in frequencies)
    return (
        f"The plate is free: no wall, no corner. {model.loop.table.connectivity.shape[1]} elements ({plate.element}), "
        f"{plate.lumping} masses, the stiffness that the run has; its three rigid modes come out at {rigid} Hz.",
        "Kinds: longitudinal and transverse modes are symmetric about the long middle line, by more than half of their "
        "kinetic energy; longitudinal ones move along the length with more than half of it. The others bend the plate: "
        "shear where more than half of the strain energy is that of shear strain, else bending; both are numbered "
        "together.",
        f"Beam theory: a free beam of length {measure(beam.length, 'm', 'g')} and depth "
        f"{measure(beam.depth, 'm', 'g')}. For bending it is "
        "Timoshenko's, with shear and rotary inertia; the slender beam is Euler and Bernoulli's, without them. For "
        f"longitudinal modes it is n c / (2 L) with c = {measure(beam.wave_speed, 'm/s', '.5g')}, "
        "which leaves out that the plate "
        "grows thinner where it is stretched. A plate this deep leaves both with the higher modes.",
    )
