"""The checks that a run must pass before its numbers are believed. A value that is not finite fails.

Here are those of the mechanics, with limits of this program's own; customary practice is in `crash_practice`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from postprocess.comparison.comparison import largest
from postprocess.pages.report import Check
from tailslap.planning.fe_plan import FePlan
from tailslap.planning.flexibility import sensitivity
from tailslap.verification.crash_practice import STORED_ENERGIES, practice_checks
from tailslap.verification.numerical_error import (
    EXPLAINED,
    FLOOR,
    SHARE,
    NumericalError,
    SecondRun,
    numerical_error,
)

if TYPE_CHECKING:
    from fem.explicit.simulate import Run

OSCILLATES = 1.25
"""Kinetic energy of the oscillation of an unstressed start, over the elastic energy that it begins without: at most 1
in a linear model without friction."""

RINGING, SPOILT = 2e-3, 0.1
"""Friction by ringing that is allowed, and at which a run is given up."""


def run_checks(
    fe_plan: FePlan,
    run: Run,
    rigid: Mapping[str, np.ndarray],
    differences: Mapping[str, float],
    second: SecondRun | None = None,
) -> tuple[Check, ...]:
    """All checks of a run; `rigid` is the rigid history at the run's instants, `differences` may be empty."""
    history, relieved = run.history, fe_plan.plate.start != "unstressed"
    checks = [
        _reached(run),
        _finite(history),
        _time_step(fe_plan, run),
        _energy(history),
        _momentum(fe_plan, history),
        _penetration(fe_plan, history),
    ]
    if relieved:
        checks += [_ringing(fe_plan, history), _reaction(fe_plan, history, rigid)]
        checks += [] if second else [_mesh(fe_plan), *_contact_spring(fe_plan)]
    else:
        checks.append(_oscillation(fe_plan, history, rigid))
    checks.append(error_of(fe_plan, run, differences, second).check)
    checks += _agreement(fe_plan, differences)
    return (*checks, *practice_checks(fe_plan, history, rigid, judged=second is not None))


def error_of(
    fe_plan: FePlan, run: Run, differences: Mapping[str, float], second: SecondRun | None
) -> NumericalError:
    """The run's numerical error."""
    ringing = friction_by_ringing(fe_plan, _last_row(run.history))
    return numerical_error(fe_plan, differences, ringing, second)


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
    meaning = "friction added by a ringing reaction, as its share of v_GX or omega"
    limit = max(RINGING, SHARE * sensitivity(fe_plan.plan.start.angle) * fe_plan.give)
    return Check.at_most(
        "friction by ringing", friction_by_ringing(fe_plan, _last_row(history)), limit, meaning
    )


def _last_row(history: Mapping[str, np.ndarray]) -> dict[str, float]:
    return {name: float(column[-1]) for name, column in history.items()}


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
        f"{FLOOR:g} and {100 * SHARE:g} % of the give are allowed; refine plate.elements, or leave them out"
    )
    return Check.at_most("mesh", abs(give - other), FLOOR + SHARE * max(give, other), meaning)


def _contact_spring(fe_plan: FePlan) -> Iterable[Check]:
    if not fe_plan.spring_share:
        return
    meaning = (
        f"deflection of the corner's spring over the way of the centre: {FLOOR:g} and {100 * SHARE:g} % of the "
        'give are allowed; corner.constraint = "exact" has none'
    )
    yield Check.at_most("contact spring", fe_plan.spring_share, FLOOR + SHARE * fe_plan.give, meaning)


def _oscillation(
    fe_plan: FePlan, history: Mapping[str, np.ndarray], rigid: Mapping[str, np.ndarray]
) -> Check:
    """An unstressed plate swings about its elastic state with the energy of that state, which goes with N squared."""
    reaction = rigid["reaction_normal"][np.isfinite(rigid["reaction_normal"])]
    scale = float((reaction**2).max() / reaction[0] ** 2) * fe_plan.elastic_energy
    undamped = fe_plan.model.loop.elastic_damping is None
    limit = OSCILLATES * math.exp(fe_plan.growth.harmless if undamped else 0.0)
    meaning = (
        "largest kinetic energy of the oscillation over the elastic energy of the plate under its reaction, which an "
        "unstressed start begins without: theory allows 1, and growth by friction too slow to be damped"
    )
    return Check.at_most("oscillation", float(history["vibration_energy"].max()) / scale, limit, meaning)


def _reaction(fe_plan: FePlan, history: Mapping[str, np.ndarray], rigid: Mapping[str, np.ndarray]) -> Check:
    expected = rigid["reaction_normal"]
    known = np.isfinite(expected)
    ripple = history["reaction_normal"][known] - expected[known]
    value = float(np.sqrt(np.mean(ripple**2) / np.mean(expected[known] ** 2)))
    limit = 0.1 + EXPLAINED * fe_plan.give
    return Check.at_most(
        "reaction against rigid",
        value,
        limit,
        "root mean square of the difference over the rigid reaction; the five quantities are judged by themselves",
    )


def _agreement(fe_plan: FePlan, differences: Mapping[str, float]) -> Iterable[Check]:
    """Only where the scene demands it: a flexible plate that is right need not agree."""
    verify = fe_plan.plan.scene.verify
    if verify is None:
        return
    meaning = "largest difference from the rigid motion; the scene demands it by verify.tolerance"
    yield Check.at_most("agreement with rigid", largest(differences), verify.tolerance, meaning)
