"""Run a scene with the modal model.

The model is a floating frame with elastic modes; its error is estimated.
"""

from __future__ import annotations

import math
import time
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np

from fem.modal.modal_model import ModalMotion, integrate, modal_plate, modal_start, with_fewer_modes
from fem.plate.free_modes import most_modes
from fem.start.inertia_relief import relieved_fields
from postprocess.comparison.quantities import KEYS, comparison_rows, largest_relative, relative_difference
from postprocess.report.data_files import plain
from postprocess.report.page import Headline
from postprocess.report.tables import Column, Table, columns
from postprocess.report.terminal import concluded, part_in_units
from postprocess.units import SYSTEMS, percent_up
from tailslap import progress
from tailslap.arguments import UnitSystem, checked_arguments
from tailslap.campaign.band_samples import force_band
from tailslap.case.check import Check, failed_sentence
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.case.of_arguments import Changes, Scene, affordable_case
from tailslap.errors import InputError
from tailslap.result.columns import history
from tailslap.result.result import Result

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


class ModalEstimate(NamedTuple):
    """Estimated relative errors of the results at the tail-slap.

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
    """Result of the modal model and rigid values.

    values: the five quantities at the tail-slap, empty if it was not reached. frequencies [Hz]: of the modes. Times
    [s]: setup_s of modes, flexibility and start; integration_s of the run; estimate_s of the two runs for the error
    estimate.
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
        """True if every check passed."""
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
    (state, finer_state) = (modal_start(model, reduced, start, relieved) for reduced in (plate, finer))
    setup = time.perf_counter() - began
    motion = integrate(plate, state, duration, steps, progress.compiling)
    halved = integrate(plate, state, duration, max(1, steps // 2))
    companions = integrate(finer, finer_state, duration, steps), halved
    estimate = _estimate(fe_plan, float(finer.frequencies[0]), motion, *companions)
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
        estimate_s=sum(companion.integration_s for companion in companions),
    )


def _admit(fe_plan: CornerPlan, modes: int) -> None:
    """Raise InputError for unsupported features."""
    scene, plate = fe_plan.case.scene, fe_plan.plate
    most = max(0, (most_modes(fe_plan.model.parameters.mass.size) - MORE_MODES) // 2)
    if not 0 <= modes <= most:
        raise InputError("--modes", modes, f"allowed for this mesh are 0 to {most}")
    if plate.start != "inertia-relief":
        allowed = 'allowed with the modal model is "inertia-relief"'
        raise InputError("plate.start", plate.start, allowed)
    if fe_plan.original.scene.damping:
        raise InputError("damping", "a table", "the modal model does not support damping; remove it")
    if scene.corner.damping_ratio:
        allowed = "the modal model does not support a dashpot; remove it"
        raise InputError("corner.damping_ratio", scene.corner.damping_ratio, allowed)


def _estimate(
    fe_plan: CornerPlan, lowest: float, motion: ModalMotion, finer: ModalMotion, coarser: ModalMotion
) -> ModalEstimate:
    """Estimate the errors of the modal model.

    lowest: frequency of the first mode [rad/s]. Inertia relief solves the linear equations of an elastic state with the
    deflection ratio d. The non-linear plate differs by d of this state and rings with it from the start: a displacement
    of d^2, and a velocity larger by frequency times duration.
    """
    if not (motion.strike and finer.strike and coarser.strike):
        return ModalEstimate(math.nan, math.nan, math.nan)
    size = min(motion.history["t"].size, finer.history["t"].size) - 1
    changes = ((name, np.abs(motion.history[name][:size] - finer.history[name][:size])) for name in KEYS)
    largest = max(change.max() / abs(motion.strike[name]) for name, change in changes)
    modes, steps = (largest_relative(run.strike or {}, motion.strike) for run in (finer, coarser))
    cycles = max(1.0, lowest * fe_plan.case.motion.strike.t)
    return ModalEstimate(float(max(largest, modes)), fe_plan.deflection_ratio**2 * cycles, steps)


def _checks(motion: ModalMotion, estimate: ModalEstimate, tolerance: float) -> tuple[Check, ...]:
    """Return the checks of a run."""
    angle = 0.0 if motion.strike else float(motion.history["theta"][-1])
    more_modes = "relative change of the result with more modes", "a larger --modes"
    linear = (
        "relative error of the linear strain of modes",
        "`tailslap run`, for the plate is too soft for modes",
    )
    half_steps = "relative change of the result with half as many time steps", "a larger --steps"
    remedy = "a stiffer plate, or `tailslap run`"
    return (
        Check(
            "tail-slap reached", angle, 0.0, motion.strike is not None, f"{motion.end}; angle [rad]", remedy
        ),
        Check.at_most("omitted modes", estimate.modes, tolerance, *more_modes),
        Check.at_most("linear modes", estimate.linear, tolerance, *linear),
        Check.at_most("time steps", estimate.steps, tolerance, *half_steps),
    )


def modal_text(fe_plan: CornerPlan, run: ModalRun, units: str = "si") -> str:
    """Return the text of the results in units "si" or "us"."""
    rows = comparison_rows(run.values, run.rigid) if run.values else ()
    parts: tuple[Table | str, ...] = (
        Table(COLUMNS, rows),
        f"Cost:   {run.steps} steps in {1e3 * run.integration_s:.2f} ms, set-up {1e3 * run.setup_s:.1f} ms, "
        f"error estimate {1e3 * run.estimate_s:.2f} ms",
    )
    system = SYSTEMS[units]
    in_units = (part_in_units(part, system) for part in parts)
    return concluded(modal_headline(fe_plan, run).in_units(system), *in_units)


def modal_headline(fe_plan: CornerPlan, run: ModalRun) -> Headline:
    """Return peak force, modes and error estimate."""
    case, estimate = fe_plan.case, run.estimate
    band = force_band(case)
    sentence, certainty = "No tail-slap within the run.", ""
    if run.values:
        sentence = case.force_sentence(case.peak_force(run.values["v_gy"]), run.passed, band)
        certainty = (
            f"Estimated error {percent_up(estimate.total)}: omitted modes {percent_up(estimate.modes)}, linear strain "
            f"{percent_up(estimate.linear)}, time steps {percent_up(estimate.steps)}."
        )
    frequencies = ", ".join(f"{frequency:.4g}" for frequency in run.frequencies)
    modes = (
        f"Modal model: modes of {frequencies} Hz." if frequencies else "Modal model without elastic modes."
    )
    answer = failed_sentence(run.checks) + sentence
    return Headline(case.headline().title, answer, f"{case.set_up} {modes}", certainty, band.sentence)


def modal_numbers(fe_plan: CornerPlan, run: ModalRun) -> dict[str, object]:
    """Return the results as numbers in SI, None without a tail-slap."""
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


@checked_arguments
def modal(
    scene: Scene,
    changes: Changes | None = None,
    *,
    modes: int = 4,
    steps: int = 100,
    tolerance: float = 1e-5,
    allow_large: bool = False,
    units: UnitSystem = "si",
) -> Result:
    """Run a scene with the modal model.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene; with a constrained corner.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    modes : int
        Number of elastic modes, lowest first.
    steps : int
        Number of time steps to the tail-slap.
    tolerance : float
        Largest allowed relative error [-].
    allow_large : bool
        Run even if the estimate exceeds this machine's memory, threads or time.
    units : {"si", "us"}
        Units of the printed text, "si" or "us"; numbers are in SI.

    Returns
    -------
    Result
        `summary` contains the numbers of `tailslap modal --json`.

    Raises
    ------
    InputError
        For an invalid scene, key or value, and for features that the modal model does not support.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.modal("paper-table-3", modes=2).passed
    True
    """
    case = affordable_case(scene, changes, allow_large)
    fe_plan = CornerCase(case.scene, case.source).plan()
    motion = modal_run(fe_plan, modes, tolerance, steps)
    summary = plain(modal_numbers(fe_plan, motion))
    histories, text = {"modal": history(motion.history)}, modal_text(fe_plan, motion, units)
    return Result("modal", summary["scene"], summary, motion.passed, histories=histories, text=text)
