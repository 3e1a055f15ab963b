"""The checks that a run of a whole impact must pass before its numbers are believed. What is not finite fails."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

import numpy as np

from solver.impact import Strike
from tailslap.case import case
from tailslap.case.case import FINER, STEP, CheckKind, Evaluation
from tailslap.case.impact.run import ImpactOutcome

STORED = (
    "kinetic_energy",
    "strain_energy",
    "hourglass_energy",
    "contact_energy",
    "crush_energy",
    "wall_energy",
)
"""Columns of the energy that the model holds, or has taken for good."""

MODAL_FRACTION = 0.25
"""Mass that a free beam's first mode moves as its ends do, over the beam's."""

FLOOR, FRACTION, MOST = 2e-3, 0.1, 0.05
"""Mesh error that every run may have, the fraction of the difference from the rigid vehicle that comes on top, and how
much that is at most."""

FORCES, DURATIONS = ("impulse", "peak_force"), ("duration",)
"""Quantities of a strike whose mesh error is judged together."""

WEDGE = 1.0 / (0.5 * math.pi + 1.0) + 1.0 / (0.5 * math.pi - 1.0)
"""Displacement of a force on the corner of a plate, at 45 deg to its sides, times E t over force and logarithm of the
distance (Timoshenko and Goodier, Theory of Elasticity, on a force at the point of a wedge)."""

LOSS = 2e-2
"""Energy, over the initial, that exact contact may take: what its nodes bring on touching."""


def energy_error(outcome: ImpactOutcome) -> np.ndarray:
    """Energy [J] that the balance has too much at each instant, shape (rows,)."""
    return case.energy_surplus(outcome.run.history, STORED)


def _initial_energy(outcome: ImpactOutcome) -> float:
    plan = outcome.fe_plan.case
    return 0.5 * plan.vehicle.mass * (plan.touch.v_gx**2 + plan.touch.v_gy**2)


def _finite(outcome: ImpactOutcome) -> Evaluation:
    arrays = (*outcome.run.history.values(), outcome.run.normal)
    bad = sum(int(np.count_nonzero(~np.isfinite(array))) for array in arrays)
    return Evaluation(bad, 0, "entries of the histories that are not finite numbers")


def _energy(outcome: ImpactOutcome) -> Evaluation:
    worst = np.abs(energy_error(outcome)).max() / _initial_energy(outcome)
    exact = _is_exact(outcome)
    meaning = "largest gap in the energy ledger over the initial energy"
    meaning += "; exact contact takes what nodes bring" if exact else ""
    return Evaluation(worst, LOSS if exact else 1e-3, meaning)


def _gain(outcome: ImpactOutcome) -> Evaluation:
    gain = energy_error(outcome).max() / _initial_energy(outcome)
    return Evaluation(gain, 1e-3, "energy that came from nowhere, over the initial")


def _is_exact(outcome: ImpactOutcome) -> bool:
    contact = outcome.fe_plan.case.scene.needed_contact
    return not contact.crushes and contact.enforcement == "exact"


def _momentum(outcome: ImpactOutcome) -> Evaluation:
    h, plan, mass = outcome.run.history, outcome.fe_plan.case, outcome.fe_plan.model.mass
    scale = mass * math.hypot(plan.touch.v_gx, plan.touch.v_gy)
    across = np.abs(mass * (h["v_gy"] - plan.touch.v_gy) - h["normal_impulse"]).max()
    along = np.abs(mass * (h["v_gx"] - plan.touch.v_gx) - h["tangential_impulse"]).max()
    meaning = "momentum in both directions against the integral of the wall's force"
    return Evaluation(max(across, along) / scale, 1e-9, meaning)


def _angular(outcome: ImpactOutcome) -> Evaluation:
    h = outcome.run.history
    turned = h["angular_momentum"] - h["moment_impulse"]
    worst = np.abs(turned - turned[0]).max() / np.abs(h["angular_momentum"]).max()
    return Evaluation(worst, 1e-9, "against the moment of the wall's force, about the first touch")


def _pull(outcome: ImpactOutcome) -> Evaluation:
    least = -float(outcome.run.normal.min())
    return Evaluation(least, 1e-6 * np.abs(outcome.run.normal).max(), "largest force [N] that pulls")


def _strikes(outcome: ImpactOutcome) -> Evaluation:
    wanted = min(2, len(outcome.rigid.strikes))
    names = [strike.corner for strike in outcome.fe.strikes[:2]]
    missing = wanted - len(names)
    return Evaluation(missing, 0, "of the rigid vehicle's first two, those that the plate lacks")


def _mesh(what: str, quantities: tuple[str, ...], outcome: ImpactOutcome) -> Evaluation | None:
    if not outcome.fe_plan.case.scene.verify.companion:
        return None
    meaning = (
        f"what richer elements change in {what} of the first two strikes: {FLOOR:g} and {100 * FRACTION:g} % of what "
        f"flexibility changes, {MOST:g} at most, are allowed; refine plate.elements"
    )
    worst = _largest(outcome.mesh_error, quantities, math.nan)
    return Evaluation(worst, _allowed(outcome, quantities), meaning)


def _allowed(outcome: ImpactOutcome, quantities: tuple[str, ...]) -> float:
    return FLOOR + min(FRACTION * _largest(outcome.difference, quantities, 1.0), MOST)


def _largest(found: Mapping[str, float], quantities: tuple[str, ...], without: float) -> float:
    return max((abs(value) for name, value in found.items() if name.endswith(quantities)), default=without)


def _point(outcome: ImpactOutcome) -> Evaluation:
    plan, plate = outcome.fe_plan.case, outcome.fe_plan.plate
    contact = plan.scene.needed_contact
    stiffness = 0.0 if contact.patch_length else contact.stiffness or 0.0
    softened = stiffness * WEDGE * math.log(2.0) / (plate.modulus * plate.thickness)
    meaning = (
        "what elements half as large take off the stiffness of crush and plate; a corner's force acts on a point, "
        "whose compliance has no limit; give contact.patch_length"
    )
    return Evaluation(softened, _allowed(outcome, FORCES), meaning)


def _vibration(outcome: ImpactOutcome) -> Evaluation | None:
    if not outcome.fe_plan.case.scene.verify.companion:
        return None
    meaning = (
        "change of the second strike's impulse by the vibration that the first one leaves, as far as the mesh does not "
        "tell its phase; refine plate.elements, or let it die away by damping.rate"
    )
    return Evaluation(unknown_by_vibration(outcome), _allowed(outcome, FORCES), meaning)


def _sampling(outcome: ImpactOutcome) -> Evaluation:
    shortest = min((strike.duration for strike in outcome.fe.strikes[:2]), default=math.nan)
    meaning = "time between rows over the shorter of the first two strikes"
    return Evaluation(outcome.fe.interval / shortest, 0.02, meaning)


def unknown_by_vibration(outcome: ImpactOutcome) -> float:
    """Largest relative change of the second strike's impulse by the vibration's phase, as far as it is not known.

    The end of the plate moves with v cos(2 pi f t + phase); over a strike of duration T such a velocity is in the mean
    at most v/(pi f T) and at most v. Over n cycles between the strikes the phase is off by 2 pi n times the relative
    error of the frequency; without a second mesh it is unknown. 0 without a second strike, or a flight between the two.
    """
    strikes, frequency = outcome.fe.strikes, outcome.fe_plan.first_frequency
    if len(strikes) < 2 or strikes[1].start <= strikes[0].end:
        return 0.0
    first, second = strikes[:2]
    cycles = frequency * (second.start - first.end)
    phase = min(1.0, 2.0 * math.pi * cycles * abs(outcome.frequency_error))  # NaN: 1
    mean = min(1.0, 1.0 / (math.pi * frequency * second.duration))
    return _velocity(outcome, first, second) / _approach(outcome, second) * mean * phase


def _velocity(outcome: ImpactOutcome, first: Strike, second: Strike) -> float:
    """Velocity of an end, from the energy of the plate in flight, all of it in the first mode [m/s]."""
    h = outcome.run.history
    free = (h["t"] > first.end) & (h["t"] < second.start)
    energy = float(h["strain_energy"][free].max(initial=0.0))
    return math.sqrt(2.0 * energy / (MODAL_FRACTION * outcome.fe_plan.model.mass))


def _approach(outcome: ImpactOutcome, second: Strike) -> float:
    """Speed towards the wall of the corner that strikes, as of a rigid vehicle [m/s]."""
    h, vehicle = outcome.run.history, outcome.fe_plan.case.vehicle
    k = int(np.searchsorted(h["t"], second.start)) - 1
    ahead = vehicle.front_distance - (vehicle.length if second.corner.startswith("rear") else 0.0)
    return abs(float(h["v_gy"][k] + h["omega"][k] * ahead * math.cos(h["theta"][k])))


FAULT = "please report it: a run does not fail this by its scene"
SHORT = "a softer contact, or a coarser question: the strikes are shorter than rows can tell"
CHECKS = (
    CheckKind("finite numbers", _finite, STEP),
    CheckKind("time step", case.time_step, STEP),
    CheckKind("energy balance", _energy, STEP),
    CheckKind("energy gained", _gain, STEP),
    CheckKind("momentum balance", _momentum, FAULT),
    CheckKind("angular momentum", _angular, FAULT),
    CheckKind("no pull", _pull, FAULT),
    CheckKind("strikes found", _strikes, "a stiffer plate, or a later time.end"),
    CheckKind("sampling", _sampling, SHORT),
    CheckKind("mesh", partial(_mesh, "impulse and peak", FORCES), FINER),
    CheckKind("mesh for durations", partial(_mesh, "duration", DURATIONS), FINER),
    CheckKind("point contact", _point, "give contact.patch_length"),
    CheckKind("vibration", _vibration, FINER),
)
"""In the order in which they are listed."""

MESH_CHECKS = ("mesh", "mesh for durations", "vibration")
"""Checks of the mesh error; a run that has none, for others tell it, fails them."""


def impact_checks(outcome: ImpactOutcome) -> tuple[case.Check, ...]:
    """All checks of a run."""
    return case.evaluated(CHECKS, outcome)


def failed_but_mesh(outcome: ImpactOutcome) -> tuple[str, ...]:
    """Names of the checks that fail, those of the mesh apart: where others tell its error."""
    failed = case.failed_names(outcome.checks or impact_checks(outcome))
    return tuple(name for name in failed if name not in MESH_CHECKS)


def advice(name: str) -> str:
    """Advice where a check fails."""
    return next((kind.advice for kind in CHECKS if kind.name == name), FAULT)
