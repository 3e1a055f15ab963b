"""Checks of the mechanics, with limits of this program's own; customary practice is in `crash_practice`."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from postprocess.comparison.quantities import largest
from tailslap.planning.flexibility import sensitivity
from tailslap.verification.check import (
    FINER,
    MORE_DAMPING,
    ROUGH,
    SOFT,
    STEP,
    STIFFER,
    CheckKind,
    Evaluation,
    Evidence,
)
from tailslap.verification.numerical_error import EXPLAINED, FLOOR, SHARE
from tailslap.verification.ringing import RINGING

STORED_ENERGIES = ("kinetic_energy", "strain_energy", "hourglass_energy", "contact_energy")
"""Columns of the energy that the model stores."""

OSCILLATES = 1.25
"""Kinetic energy of the oscillation of an unstressed start, over the elastic energy that it begins without: at most 1
in a linear model without friction."""


def energy_error(history: Mapping[str, np.ndarray]) -> np.ndarray:
    """Energy [J] that the ledger has too much at each instant, shape (instants,)."""
    stored = np.sum([history[name] for name in STORED_ENERGIES], axis=0)
    balance = stored - history["friction_work"] - history["damping_work"]
    return np.asarray(balance - balance[0])


def _reached(given: Evidence) -> Evaluation:
    meaning = "angle [rad] between side and wall where the run ended; a run that flutters or diverges never gets there"
    angle = 0.0 if given.run.strike else abs(given.history["theta"][-1]) or math.inf
    return Evaluation(angle, 0.0, meaning)


def _finite(given: Evidence) -> Evaluation:
    force = given.fe_plan.case.force
    theory = (*given.fe_plan.case.tail_slap.values(), force.impulse, force.peak_force)
    results = [*given.history.values(), np.array([*theory, *given.differences.values()], dtype=float)]
    bad = sum(int(np.count_nonzero(~np.isfinite(column))) for column in results)
    return Evaluation(bad, 0, "entries of the histories and results that are not finite numbers")


def _time_step(given: Evidence) -> Evaluation:
    model = given.fe_plan.model
    share = (
        model.loop.time_step / model.stable_time_step * given.run.highest_frequency / model.highest_frequency
    )
    meaning = "time step over the stable one, with the highest frequency that the deformed plate had"
    return Evaluation(share, 1.0, meaning)


def _energy(given: Evidence) -> Evaluation:
    worst = np.abs(energy_error(given.history)).max() / given.history["kinetic_energy"][0]
    return Evaluation(worst, 1e-6, "largest gap in the energy ledger over the energy at the start")


def _momentum(given: Evidence) -> Evaluation:
    mass, speed = given.fe_plan.model.mass, given.history["v_gy"]
    gained, scale = mass * (speed - speed[0]), mass * np.abs(speed).max()
    worst = np.abs(gained - given.history["normal_impulse"]).max() / scale
    return Evaluation(worst, 1e-9, "lateral momentum against the impulse of the reaction")


def _penetration(given: Evidence) -> Evaluation:
    gap = np.abs(given.history["gap"]).max() / given.fe_plan.case.body.width
    return Evaluation(gap, 0.01, "largest distance of the corner from the wall's line over the plate's width")


def _ringing(given: Evidence) -> Evaluation | None:
    if not given.relieved:
        return None
    limit = max(RINGING, SHARE * sensitivity(given.fe_plan.case.start.angle) * given.fe_plan.deflection_ratio)
    return Evaluation(
        given.ringing, limit, "friction added by a ringing reaction, as its share of v_GX or omega"
    )


def _reaction(given: Evidence) -> Evaluation | None:
    if not given.relieved:
        return None
    expected = given.rigid["reaction_normal"]
    known = np.isfinite(expected)
    ripple = given.history["reaction_normal"][known] - expected[known]
    value = np.sqrt(np.mean(ripple**2) / np.mean(expected[known] ** 2))
    meaning = "root mean square of the difference over the rigid reaction; the five quantities are judged by themselves"
    return Evaluation(value, 0.1 + EXPLAINED * given.fe_plan.deflection_ratio, meaning)


def _mesh(given: Evidence) -> Evaluation | None:
    """What richer elements would change: a mesh that is too coarse is too stiff, and looks rigid without being so."""
    if given.second or not given.relieved:
        return None
    ratio, other = given.fe_plan.deflection_ratio, given.fe_plan.other_deflection_ratio
    meaning = (
        "change of the plate's deflection ratio with richer elements (or, on large meshes, half as many): "
        f"{FLOOR:g} and {100 * SHARE:g} % of it are allowed; refine plate.elements, or leave them out"
    )
    return Evaluation(abs(ratio - other), FLOOR + SHARE * max(ratio, other), meaning)


def _contact_spring(given: Evidence) -> Evaluation | None:
    share = given.fe_plan.spring_share
    if given.second or not given.relieved or not share:
        return None
    meaning = (
        f"deflection of the corner's spring over the way of the centre: {FLOOR:g} and {100 * SHARE:g} % of the "
        'deflection ratio are allowed; corner.constraint = "exact" has none'
    )
    return Evaluation(share, FLOOR + SHARE * given.fe_plan.deflection_ratio, meaning)


def _oscillation(given: Evidence) -> Evaluation | None:
    """An unstressed plate swings about its elastic state with the energy of that state, which goes with N squared."""
    if given.relieved:
        return None
    fe_plan, reaction = given.fe_plan, given.rigid["reaction_normal"]
    reaction = reaction[np.isfinite(reaction)]
    scale = float((reaction**2).max() / reaction[0] ** 2) * fe_plan.elastic_energy
    undamped = fe_plan.model.loop.elastic_damping is None
    limit = OSCILLATES * math.exp(fe_plan.growth.harmless if undamped else 0.0)
    meaning = (
        "largest kinetic energy of the oscillation over the elastic energy of the plate under its reaction, which an "
        "unstressed start begins without: theory allows 1, and growth by friction too slow to be damped"
    )
    return Evaluation(float(given.history["vibration_energy"].max()) / scale, limit, meaning)


def _numerical_error(given: Evidence) -> Evaluation:
    meaning = (
        f"what mesh, time step, constraint, damping and ringing may change in the five quantities; {FLOOR:g} and "
        f"{100 * SHARE:g} % of what the plate's flexibility changes are allowed"
    )
    return Evaluation(given.error.total, given.error.allowed, meaning)


def _agreement(given: Evidence) -> Evaluation | None:
    """Only where the scene demands it: a flexible plate that is right need not agree."""
    verify = given.fe_plan.case.scene.verify
    if verify is None:
        return None
    meaning = "largest difference from the rigid motion; the scene demands it by verify.tolerance"
    return Evaluation(largest(given.differences), verify.tolerance, meaning)


MECHANICS = (
    CheckKind("tail-slap reached", _reached, f"{MORE_DAMPING}; {SOFT}", shows_ringing=True),
    CheckKind("finite numbers", _finite, f"{STEP}; {MORE_DAMPING}", shows_ringing=True),
    CheckKind("time step", _time_step, STEP),
    CheckKind("energy balance", _energy, STEP),
    CheckKind("momentum balance", _momentum, STEP),
    CheckKind("penetration", _penetration, STIFFER),
    CheckKind("friction by ringing", _ringing, ROUGH, shows_ringing=True),
    CheckKind("reaction against rigid", _reaction, ROUGH, shows_ringing=True, of_reaction=True),
    CheckKind("mesh", _mesh, FINER),
    CheckKind("contact spring", _contact_spring, STIFFER),
    CheckKind("oscillation", _oscillation, ROUGH, shows_ringing=True),
    CheckKind("numerical error", _numerical_error, f"leave plate.start out if it is unstressed; {FINER}"),
    CheckKind("agreement with rigid", _agreement, "a stiffer plate, or a larger verify.tolerance"),
)
"""In the order in which they are told."""
