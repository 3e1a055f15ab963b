"""The checks that a run must pass before its numbers are believed. A value that is not finite fails.

Here are those of the mechanics, with limits of this program's own; customary practice is in `tailslap.practice`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from postprocess.report import Check
from tailslap.fe_plan import FePlan
from tailslap.practice import STORED_ENERGIES, practice_checks

if TYPE_CHECKING:
    from fem.simulate import Run

AGREEMENT = 5e-4
"""Difference from the rigid motion that is allowed of a plate that does not give."""
GIVES = 2.0
"""Multiples of the plate's own give that are allowed on top: for soft plates the difference is 0.3 to 2.0 of it."""

NUMERICAL_SHARE = 0.25
"""Share of the plate's give that may be the mesh's doing, and that may be the corner's spring; more, and the
difference from the rigid motion is not the plate's own."""

RINGING, SPOILT = 2e-3, 0.1
"""Friction by ringing that is allowed, and at which a run is given up."""


def run_checks(
    fe_plan: FePlan, run: Run, rigid: Mapping[str, np.ndarray], differences: Mapping[str, float]
) -> tuple[Check, ...]:
    """All checks of a run; `rigid` is the rigid history at the run's instants, `differences` may be empty."""
    from fem.corner import Exact

    history = run.history
    checks = [
        _reached(run),
        _finite(history),
        _time_step(fe_plan, run),
        _energy(history),
        _momentum(fe_plan, history),
        _ringing(fe_plan, history),
        _penetration(fe_plan, history),
        _mesh(fe_plan),
    ]
    if not isinstance(fe_plan.model.loop.corner.hold, Exact):
        checks.append(_contact_spring(fe_plan, rigid))
    if fe_plan.plate.start == "quiet":
        checks.append(_reaction(fe_plan, history, rigid))
    checks.append(_agreement(fe_plan, differences))
    return (*checks, *practice_checks(fe_plan, history, rigid))


def energy_error(history: Mapping[str, np.ndarray]) -> np.ndarray:
    """Energy [J] that the ledger has too much at each instant, shape (instants,)."""
    held = np.sum([history[name] for name in STORED_ENERGIES], axis=0)
    balance = held - history["friction_work"] - history["damping_work"]
    return np.asarray(balance - balance[0])


def _reached(run: Run) -> Check:
    angle = 0.0 if run.strike else float(run.history["theta"][-1])
    meaning = "angle [rad] between side and wall where the run ended; a run that flutters or diverges never gets there"
    return Check("tail-slap reached", angle, 0.0, run.strike is not None, meaning)


def _finite(history: Mapping[str, np.ndarray]) -> Check:
    bad = sum(int(np.count_nonzero(~np.isfinite(column))) for column in history.values())
    return Check.at_most("finite numbers", bad, 0, "entries of the history that are not finite numbers")


def _time_step(fe_plan: FePlan, run: Run) -> Check:
    model = fe_plan.model
    share = model.loop.time_step / model.stable_time_step * run.highest_frequency / model.highest_frequency
    meaning = "time step over the stable one, with the highest frequency that the deformed plate had"
    return Check.at_most("time step", float(share), 1.0, meaning)


def _energy(history: Mapping[str, np.ndarray]) -> Check:
    worst = float(np.abs(energy_error(history)).max() / history["kinetic_energy"][0])
    return Check.at_most(
        "energy balance", worst, 1e-6, "largest gap in the energy ledger over the energy at the start"
    )


def _momentum(fe_plan: FePlan, history: Mapping[str, np.ndarray]) -> Check:
    gained = fe_plan.model.mass * (history["v_gy"] - history["v_gy"][0])
    scale = fe_plan.model.mass * np.abs(history["v_gy"]).max()
    worst = float(np.abs(gained - history["normal_impulse"]).max() / scale)
    return Check.at_most(
        "momentum balance", worst, 1e-9, "lateral momentum against the impulse of the reaction"
    )


def _ringing(fe_plan: FePlan, history: Mapping[str, np.ndarray]) -> Check:
    last = {name: float(column[-1]) for name, column in history.items()}
    meaning = "friction added by a ringing reaction, as its share of v_GX or omega; [damping] ratio = 0.1 quietens it"
    return Check.at_most("friction by ringing", friction_by_ringing(fe_plan, last), RINGING, meaning)


def friction_by_ringing(fe_plan: FePlan, row: Mapping[str, float]) -> float:
    """Friction follows |N|: where N rings through zero it brakes more than the motion's own reaction would.

    row: of the history. The share of v_GX or omega, whichever is more, that this has taken off by then.
    """
    rectified = row["normal_impulse_magnitude"] - abs(row["normal_impulse"])
    law = fe_plan.model.loop.friction
    speed = (law.coefficient if law else 0.0) * rectified / fe_plan.model.mass
    radius, strike = fe_plan.plan.body.corner_radius, fe_plan.plan.motion.strike
    return max(abs(speed / (strike.v_gx or math.inf)), 0.75 * abs(speed) / (radius * strike.omega))


def _penetration(fe_plan: FePlan, history: Mapping[str, np.ndarray]) -> Check:
    gap = float(np.abs(history["gap"]).max() / fe_plan.plan.body.width)
    meaning = "largest distance of the corner from the wall's line over the plate's width"
    return Check.at_most("penetration", gap, 0.01, meaning)


def _mesh(fe_plan: FePlan) -> Check:
    """What richer elements would change: a mesh that is too coarse is too stiff, and looks rigid without being so."""
    give, other = fe_plan.give, fe_plan.other_give
    meaning = (
        "change of the plate's give with richer elements (or, on large meshes, half as many): "
        f"{AGREEMENT:g} and {100 * NUMERICAL_SHARE:g} % of the give are allowed; refine plate.elements"
    )
    return Check.at_most("mesh", abs(give - other), AGREEMENT + NUMERICAL_SHARE * max(give, other), meaning)


def _contact_spring(fe_plan: FePlan, rigid: Mapping[str, np.ndarray]) -> Check:
    gap = abs(rigid["reaction_normal"][0]) / fe_plan.model.loop.corner.hold.stiffness
    share = float(gap / fe_plan.travel)
    meaning = (
        f"part of the give that is the corner's spring and not the plate: {AGREEMENT:g} and "
        f'{100 * NUMERICAL_SHARE:g} % of the give are allowed; corner.constraint = "exact" has none'
    )
    return Check.at_most("contact spring", share, AGREEMENT + NUMERICAL_SHARE * fe_plan.give, meaning)


def _reaction(fe_plan: FePlan, history: Mapping[str, np.ndarray], rigid: Mapping[str, np.ndarray]) -> Check:
    expected = rigid["reaction_normal"]
    known = np.isfinite(expected)
    ripple = history["reaction_normal"][known] - expected[known]
    value = float(np.sqrt(np.mean(ripple**2) / np.mean(expected[known] ** 2)))
    limit = 0.1 + GIVES * fe_plan.give
    return Check.at_most(
        "reaction against rigid", value, limit, "root mean square of the difference over the rigid reaction"
    )


def _agreement(fe_plan: FePlan, differences: Mapping[str, float]) -> Check:
    sizes = [abs(value) for value in differences.values()]
    worst = max(sizes) if sizes and all(map(math.isfinite, sizes)) else math.nan
    meaning = (
        f"largest difference from the rigid motion; {AGREEMENT:g} and {GIVES:g} times the {fe_plan.give:.1e} "
        "by which this plate gives at the start are allowed"
    )
    return Check.at_most("agreement with rigid", worst, AGREEMENT + GIVES * fe_plan.give, meaning)
