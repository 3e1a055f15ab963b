"""The modal run: the plate as a floating frame with a few elastic modes, how far to trust its result, its text."""

from __future__ import annotations

import math
import time
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from postprocess.comparison.quantities import KEYS, comparison_rows, largest_relative, relative_difference
from postprocess.report.report import shown_in
from postprocess.report.table import Column, Table
from postprocess.report.terminal import printed
from postprocess.units import SYSTEMS
from tailslap.case.checks import Check
from tailslap.case.corner.plan import CornerPlan
from tailslap.errors import InputError

if TYPE_CHECKING:
    from fem.modal.model import ModalMotion

MODES, STEPS, TOLERANCE = 4, 100, 1e-5
"""Elastic modes, time steps to the tail-slap, and relative error allowed, unless the caller says otherwise."""

MORE_MODES = 4
"""The result is compared with that of twice as many modes and so many more."""

COLUMNS = (
    Column("quantity.symbol", "at the tail-slap"),
    Column("quantity.unit", "unit", is_unit=True),
    Column("fe", "modal", form=".7g", unit_key="quantity.unit"),
    Column("rigid", "rigid, exact", form=".7g", unit_key="quantity.unit"),
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
    from fem.modal.model import integrate, modal_plate, modal_start, with_fewer_modes
    from fem.start.inertia_relief import relieved_fields

    _admit(fe_plan, modes)
    model, start, duration = fe_plan.model, fe_plan.start, fe_plan.case.motion.strike.t
    began = time.perf_counter()
    finer = modal_plate(model, 2 * modes + MORE_MODES)
    plate, relieved = with_fewer_modes(finer, modes), relieved_fields(model, start)
    (state, finer_state) = (modal_start(model, kept, start, relieved) for kept in (plate, finer))
    setup = time.perf_counter() - began
    motion = integrate(plate, state, duration, steps)
    others = (
        integrate(finer, finer_state, duration, steps),
        integrate(plate, state, duration, max(1, steps // 2)),
    )
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
    from fem.plate.elastic import most_modes

    scene, plate = fe_plan.case.scene, fe_plan.plate
    most = max(0, (most_modes(fe_plan.model.loop.mass.size) - MORE_MODES) // 2)
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
    moved = max(
        np.abs(motion.history[name][:size] - finer.history[name][:size]).max() / abs(motion.strike[name])
        for name in KEYS
    )
    modes, steps = (largest_relative(run.strike or {}, motion.strike) for run in (finer, coarser))
    cycles = max(1.0, lowest * fe_plan.case.motion.strike.t)
    return ModalEstimate(float(max(moved, modes)), fe_plan.deflection_ratio**2 * cycles, steps)


def _checks(motion: ModalMotion, estimate: ModalEstimate, tolerance: float) -> tuple[Check, ...]:
    angle = 0.0 if motion.strike else float(motion.history["theta"][-1])
    more = "how far the result moves with more of them; --modes takes a larger number"
    linear = "what their linear strain leaves out; the plate is too soft for modes, `tailslap run` is not"
    half = "how far the result moves with half as many; --steps takes more"
    return (
        Check("tail-slap reached", angle, 0.0, motion.strike is not None, f"{motion.end}; angle [rad]"),
        Check.at_most("modes left out", estimate.modes, tolerance, more),
        Check.at_most("linear modes", estimate.linear, tolerance, linear),
        Check.at_most("time steps", estimate.steps, tolerance, half),
    )


def modal_text(fe_plan: CornerPlan, run: ModalRun, units: str = "si") -> str:
    """The results as a person reads them, in units "si" or "us"."""
    scene, estimate = fe_plan.case.scene, run.estimate
    kept = ", ".join(f"{frequency:.4g}" for frequency in run.frequencies) or "none"
    estimated = (
        f"Estimate of its error: {estimate.total:.1e}, of that {estimate.modes:.1e} by the modes left out, "
        f"{estimate.linear:.1e} by linear strain, {estimate.steps:.1e} by the time steps"
    )
    failed = (
        f"FAILED  {check.name}: {check.value:.3g}, limit {check.limit:.3g} ({check.meaning})"
        for check in run.checks
        if not check.passed
    )
    compared = Table(COLUMNS, comparison_rows(run.values, run.rigid, None)) if run.values else None
    parts = (
        f"{scene.name}: modal model, reaction {scene.corner.reaction}, modes kept [Hz]: {kept}",
        *((compared, estimated) if compared else ()),
        *failed,
        f"Cost:   {run.steps} steps in {1e3 * run.integration_s:.2f} ms, set-up {1e3 * run.setup_s:.1f} ms, "
        f"estimate {1e3 * run.estimate_s:.2f} ms",
    )
    return printed(parts if units == "si" else [shown_in(part, SYSTEMS[units]) for part in parts])


def modal_numbers(fe_plan: CornerPlan, run: ModalRun) -> dict[str, Any]:
    """The numbers for other programs, SI; what was not reached is None."""
    unknown = dict.fromkeys(run.rigid)
    cost = ("steps", "iterations", "setup_s", "integration_s", "estimate_s")
    return {
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
