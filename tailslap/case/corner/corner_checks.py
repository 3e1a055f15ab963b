"""Checks of a run of a constrained corner.

A check fails where its value is not finite.

The limits of MECHANICS and CONTACT are this program's own. The history contains
force, position and energy of the contact separately, so that each is compared with the others:

    spring      The integral of N dy equals the loss of the spring's energy. N is linear in y, so that the trapezoidal
                rule is exact for any spacing of the rows.
    friction    R of each row follows from N and the slip by the law of the scene, evaluated in Python. Where R is
                proportional to |N| or N, W = -mu integral of v_P dJ. J, the impulse of |N| or N, is summed by the time
                loop at every step and contains oscillations between two rows.

PRACTICE contains checks that are customary in crash analysis, with their customary limits, which are wider:

    energy ratio     Total energy over initial energy plus external work, 1 if perfect (LS-DYNA support, "Total
                     energy"). Radioss calls a surplus of up to 2 % acceptable (user's guide, "Results checking").
    contact energy   Radioss: hourglass and contact energy at most 15 % of the total ("Computation checks").
    hourglass, added mass, Sprague-Geers, residuals
                     NCHRP Web-Only Document 179 and its program RSVVP: 10 % of the internal energy and 5 % of the
                     energy at the start, 5 % of the mass, 40 % for M and P, 5 % and 35 %. Customary: cited so in
                     validation reports, not read in the document itself.
"""

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from postprocess.comparison.quantities import largest
from tailslap.case.case import time_step
from tailslap.case.check import FINER, STEP, CheckRegistry, Evaluation, evaluated
from tailslap.case.corner.numerical_error import FLOOR, FRACTION, RINGING, change_by_friction
from tailslap.case.corner.outcome import STORED_ENERGIES, CornerOutcome, energy_error
from tailslap.case.plate_input import plate_density

Array = NDArray[np.float64]

STIFFER = 'a larger corner.penalty_scale, or corner.constraint = "exact"'
MORE_DAMPING = "remove damping.kind, or specify damping.rate"
SOFT = "a stiffer plate"
ROUGH = f"{MORE_DAMPING}; remove the spring of the corner"
ELEMENTS = 'plate.element = "quad4", or more elements'
"""Advice of several checks."""

ERROR_ADVICE = {
    "mesh": FINER,
    "contact_spring": STIFFER,
    "damping": "remove [damping], or a smaller damping.rate",
    "rounding": "larger elements, for fewer time steps",
}
"""Advice by term of the numerical error."""

STOPS = 4.0
"""Multiple of the change of speed by friction in a step below which the corner may stop within the step."""

OSCILLATES = 1.25
"""Limit of an oscillation's kinetic energy over the plate's elastic energy, at most 1 in a linear model."""

EXPLAINED = 2.0
"""Ripple of the reaction that the plate's flexibility explains, as a multiple of its deflection ratio."""

OTHER_WORK = 0.05
"""Difference of the friction work from that of the rigid body, over it, that is allowed for a stiff plate."""

NOTICED = FLOOR / OTHER_WORK
"""Change of velocity by friction of which `OTHER_WORK` is the numerical error that is allowed for any plate."""

LEAST = 1e-12
"""Energy of a contact over the energy at the start that counts as rounding."""

NCHRP = "customary limit, NCHRP W179"
RESIDUAL = "of FE - rigid over the rigid history's peak"
PHASE = "difference in phase between FE and rigid history, 1 for opposite signs"
METRICS = {
    "Sprague-Geers magnitude": ("magnitude", 0.4, "difference in magnitude between FE and rigid history"),
    "Sprague-Geers phase": ("phase", 0.4, PHASE),
    "Sprague-Geers combined": ("combined", 0.4, "magnitude and phase together"),
    "mean residual": ("mean_residual", 0.05, f"mean {RESIDUAL}"),
    "deviation of residuals": ("deviation", 0.35, f"standard deviation {RESIDUAL}"),
}
"""Metric, customary limit and meaning by name of the check."""

MECHANICS, CONTACT, PRACTICE = "Mechanics", "Work of the contact", "Customary in crash analysis"
"""Groups of checks."""

CHECKS: CheckRegistry[CornerOutcome] = CheckRegistry("check")
"""Checks of a run of a constrained corner."""


@CHECKS.add("tail-slap reached", f"{MORE_DAMPING}; {SOFT}", MECHANICS, shows_ringing=True)
def _reached(outcome: CornerOutcome) -> Evaluation:
    meaning = "angle [rad] between side and wall at the end of the run; 0 at the tail-slap"
    angle = 0.0 if outcome.run.strike else abs(outcome.history["theta"][-1]) or math.inf
    return Evaluation(angle, 0.0, meaning)


@CHECKS.add("finite numbers", f"{STEP}; {MORE_DAMPING}", MECHANICS, shows_ringing=True)
def _finite(outcome: CornerOutcome) -> Evaluation:
    force = outcome.fe_plan.case.force
    theory = (*outcome.fe_plan.case.tail_slap.values(), force.impulse, force.peak_force)
    results = [*outcome.history.values(), np.array([*theory, *outcome.difference.values()], dtype=float)]
    not_finite = sum(int(np.count_nonzero(~np.isfinite(column))) for column in results)
    return Evaluation(not_finite, 0, "entries of the histories and results that are not finite numbers")


CHECKS.add("time step", STEP, MECHANICS)(time_step)


@CHECKS.add("energy balance", STEP, MECHANICS)
def _energy(outcome: CornerOutcome) -> Evaluation:
    worst = np.abs(energy_error(outcome.history)).max() / outcome.history["kinetic_energy"][0]
    return Evaluation(worst, 1e-6, "largest energy-balance error over the initial energy")


@CHECKS.add("momentum balance", STEP, MECHANICS)
def _momentum(outcome: CornerOutcome) -> Evaluation:
    mass, speed = outcome.fe_plan.model.mass, outcome.history["v_gy"]
    change, scale = mass * (speed - speed[0]), mass * np.abs(speed).max()
    worst = np.abs(change - outcome.history["normal_impulse"]).max() / scale
    return Evaluation(
        worst, 1e-9, "lateral momentum minus impulse of the reaction, over the largest momentum"
    )


@CHECKS.add("penetration", STIFFER, MECHANICS)
def _penetration(outcome: CornerOutcome) -> Evaluation:
    gap = np.abs(outcome.history["gap"]).max() / outcome.fe_plan.case.body.width
    return Evaluation(gap, 0.01, "largest distance of the corner from the wall's line over the plate's width")


@CHECKS.add("friction by ringing", ROUGH, MECHANICS, shows_ringing=True)
def _ringing(outcome: CornerOutcome) -> Evaluation | None:
    if not outcome.relieved:
        return None
    meaning = "effect of friction by an oscillating reaction on v_GX or omega, relative"
    return Evaluation(outcome.ringing, max(RINGING, FRACTION * outcome.by_flexibility), meaning)


@CHECKS.add("reaction against rigid", ROUGH, MECHANICS, shows_ringing=True, of_reaction=True)
def _reaction(outcome: CornerOutcome) -> Evaluation | None:
    if not outcome.relieved:
        return None
    expected = outcome.rigid_history["reaction_normal"]
    rows = np.isfinite(expected)
    ripple = outcome.history["reaction_normal"][rows] - expected[rows]
    value = np.sqrt(np.mean(ripple**2) / np.mean(expected[rows] ** 2))
    meaning = "root mean square of the difference from the rigid reaction, over that of the rigid reaction"
    return Evaluation(value, 0.1 + EXPLAINED * outcome.fe_plan.deflection_ratio, meaning)


@CHECKS.add("oscillation", ROUGH, MECHANICS, shows_ringing=True)
def _oscillation(outcome: CornerOutcome) -> Evaluation | None:
    """Compare the oscillation of an unstressed plate with its elastic energy.

    That energy is proportional to N squared.
    """
    if outcome.relieved:
        return None
    fe_plan, reaction = outcome.fe_plan, outcome.rigid_history["reaction_normal"]
    reaction = reaction[np.isfinite(reaction)]
    scale = float((reaction**2).max() / reaction[0] ** 2) * fe_plan.elastic_energy
    undamped = fe_plan.model.parameters.elastic_damping is None
    limit = OSCILLATES * math.exp(fe_plan.growth.harmless if undamped else 0.0)
    meaning = (
        "largest kinetic energy of the oscillation over the elastic energy of the plate under its reaction; at most 1 "
        "in theory for an unstressed start, and more by slow growth through friction"
    )
    return Evaluation(float(outcome.history["vibration_energy"].max()) / scale, limit, meaning)


@CHECKS.add("numerical error", FINER, MECHANICS)
def _numerical_error(outcome: CornerOutcome) -> Evaluation | None:
    """Bound the numerical error.

    It is NaN and fails where companions are wanted and none could be run.
    """
    if not (outcome.fe and outcome.fe_plan.case.scene.verify.companion):
        return None
    meaning = (
        f"bound of the error of the five quantities by mesh, constraint, damping and rounding; limit: {FLOOR:g} and "
        f"{100 * FRACTION:g} % of the effect of flexibility"
    )
    term = max(ERROR_ADVICE, key=lambda name: np.nan_to_num(getattr(outcome.error, name), nan=np.inf))
    advice = outcome.fe_plan.finer if term == "mesh" else ERROR_ADVICE[term]
    advice = advice if outcome.relieved else f"remove plate.start; {advice}"
    return Evaluation(outcome.error.total, outcome.error.allowed, meaning, advice)


@CHECKS.add("agreement with rigid", "a stiffer plate, or a larger verify.tolerance", MECHANICS)
def _agreement(outcome: CornerOutcome) -> Evaluation | None:
    """Compare with the rigid body where the scene demands it.

    A correct flexible plate need not agree.
    """
    tolerance = outcome.fe_plan.case.scene.verify.tolerance
    if tolerance is None:
        return None
    meaning = "largest relative difference from the rigid motion; limit: verify.tolerance"
    return Evaluation(largest(outcome.difference), tolerance, meaning)


@CHECKS.add("energy ratio", STEP, PRACTICE)
def _energy_ratio(outcome: CornerOutcome) -> Evaluation:
    """Compare the total energy with initial energy and work of friction.

    The total energy includes the work of dampers.
    """
    history = outcome.history
    total = np.sum([history[name] for name in STORED_ENERGIES], axis=0) - history["damping_work"]
    ratio = total / (total[0] + history["friction_work"])
    meaning = (
        f"largest deviation from 1 of total energy over (initial energy + external work), from {ratio.min():.7f} "
        f"to {ratio.max():.7f}; LS-DYNA's energy ratio, 2 % is customary (Radioss)"
    )
    return Evaluation(np.abs(ratio - 1.0).max(), 0.02, meaning)


@CHECKS.add("contact work", STEP, CONTACT)
def _contact_work(outcome: CornerOutcome) -> Evaluation:
    """Compare the loss of the spring's energy with its work.

    An exact constraint stores no energy.
    """
    history, corner = outcome.history, outcome.fe_plan.model.parameters.corner
    if corner.is_exact:
        fraction = np.abs(history["contact_energy"]).max() / history["kinetic_energy"][0]
        meaning = "energy of the constraint over the initial energy; 0 for an exact constraint"
        return Evaluation(fraction, LEAST, meaning)
    stepped = slice(-1 if history["t"].size > 2 else None)  # the last row is interpolated, not linear in y
    energy, gap = history["contact_energy"][stepped], history["gap"][stepped]
    # N also contains the force of a dashpot.
    force = -corner.stiffness * gap if corner.dashpot else history["reaction_normal"][stepped]
    surplus = _work(force, gap) + energy - energy[0]
    scale = np.maximum(np.abs(energy).max(), LEAST * history["kinetic_energy"][0])
    meaning = "work of the normal force minus the decrease of the spring's energy, over its largest energy"
    return Evaluation(_over(np.abs(surplus).max(), scale), 1e-6, meaning)


@CHECKS.add("contact energy", STIFFER, CONTACT)
def _stored(outcome: CornerOutcome) -> Evaluation:
    stored = outcome.history["contact_energy"] + outcome.history["hourglass_energy"]
    meaning = (
        "largest energy of contact and hourglass control over the initial energy; customary limit, Radioss"
    )
    return Evaluation(stored.max() / outcome.history["kinetic_energy"][0], 0.15, meaning)


@CHECKS.add("friction law", "empty the folder of compiled code, under ~/.cache/tailslap", CONTACT)
def _friction_law(outcome: CornerOutcome) -> Evaluation:
    """Compare friction with the law of the scene.

    A sliding corner has the largest friction that the law allows. One that may stop within the step, or is at rest, may
    have any smaller one.
    """
    law, parameters = outcome.friction, outcome.fe_plan.model.parameters
    coefficient = outcome.fe_plan.case.scene.corner_friction
    constants = law.constants(coefficient) if coefficient and not law.frictionless else None
    stepped = slice(-1 if outcome.history["t"].size > 2 else None)  # the last row is interpolated
    names = ("reaction_tangential", "reaction_normal", "v_p")
    force, normal, speed = (outcome.history[name][stepped] for name in names)

    def distance_from_law(rows: NDArray[np.bool_], stopping: Array) -> Array:
        pairs = zip(normal[rows].tolist(), stopping[rows].tolist(), strict=True)
        by_law = [law.force(constants, *pair) if constants else 0.0 for pair in pairs]
        return np.asarray(np.abs(force[rows] - by_law))

    slides = np.abs(speed) > STOPS * parameters.time_step * parameters.corner.mobility * np.abs(force).max()
    distance, at_rest = distance_from_law(np.ones_like(slides), -np.copysign(np.inf, speed)), ~slides
    distance[at_rest] = np.minimum(distance[at_rest], distance_from_law(at_rest, force))
    meaning = (
        "friction minus that of the scene's law at the same reaction and speed, over the largest friction"
    )
    return Evaluation(_over(distance.max(), np.abs(force).max()), 1e-9, meaning)


@CHECKS.add("friction work", "a larger time.rows", CONTACT)
def _friction(outcome: CornerOutcome) -> Evaluation | None:
    if not outcome.friction.impulse:
        return None
    history, recorded = outcome.history, outcome.history["friction_work"]
    work = -outcome.fe_plan.case.scene.corner_friction * _work(
        history["v_p"], history[outcome.friction.impulse]
    )
    difference = _over(np.abs(recorded - recorded[0] - work).max(), np.abs(work).max())
    step = (
        outcome.fe_plan.model.parameters.time_step
        * np.abs(history["reaction_tangential"] * history["v_p"]).max()
    )
    meaning = (
        "friction work minus coefficient x impulse x corner speed, over its largest value; initial work over that of a "
        "step"
    )
    return Evaluation(max(difference, _over(abs(recorded[0]), step)), 0.01, meaning)


@CHECKS.add("friction takes energy", MORE_DAMPING, CONTACT)
def _dissipation(outcome: CornerOutcome) -> Evaluation | None:
    if outcome.friction.frictionless or not outcome.friction.dissipative:
        return None
    work = outcome.history["friction_work"]
    value = _over(np.diff(work).max(initial=0.0), np.abs(work).max())
    meaning = (
        "largest increase of the friction work between two rows over the total; friction only dissipates"
    )
    return Evaluation(value, 1e-9, meaning)


@CHECKS.add("friction work against rigid", ROUGH, CONTACT)
def _against_rigid(outcome: CornerOutcome) -> Evaluation | None:
    """Compare the work of friction with the rigid body's.

    The part by oscillations is excluded and has its own check. The reaction of an unstressed plate oscillates too far
    to be compared. Friction that changes the velocities by less than `NOTICED` counts as that much.
    """
    if not outcome.relieved:
        return None
    history, expected = outcome.history, outcome.rigid_history["friction_work"]
    ringing = 0.0 * history["v_p"]
    if outcome.friction.impulse == "normal_impulse_magnitude":
        rectified = history["normal_impulse_magnitude"] - np.abs(history["normal_impulse"])
        ringing = -outcome.fe_plan.case.scene.corner_friction * _work(history["v_p"], rectified)
    rows = np.isfinite(expected)
    difference = np.abs(history["friction_work"] - ringing - expected)[rows].max()
    whole = np.abs(expected[rows]).max()
    if whole > 0.0:
        change = change_by_friction(outcome.fe_plan, whole / np.abs(history["v_p"]).max())
        whole *= max(1.0, NOTICED / change)
    meaning = (
        "friction work without the part by oscillations, minus that of the rigid body, over the largest, at least over "
        f"the work that changes v_GX or omega by {100.0 * NOTICED:g} %"
    )
    return Evaluation(_over(difference, whole), OTHER_WORK + 2.0 * outcome.by_flexibility, meaning)


def _work(force: Array, along: Array) -> Array:
    """Integrate a force along a coordinate by the trapezoidal rule, shape (rows,)."""
    return np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(along)))


def _over(part: float, whole: float) -> float:
    """Return part over whole, 0 where the part is 0."""
    return 0.0 if part == 0.0 else float(part / whole)


@CHECKS.add("hourglass over strain energy", ELEMENTS, PRACTICE)
def _hourglass_of_strain(outcome: CornerOutcome) -> Evaluation:
    """Compare hourglass and strain energy.

    This is customary, and shown for every element. The limit holds where the numerical error is too large: an assumed
    strain stabilises, and with few elements across its energy is that of bending.
    """
    energy, strain = outcome.history["hourglass_energy"], outcome.history["strain_energy"]
    meaning = f"largest hourglass energy over the largest strain energy; {NCHRP}"
    if outcome.fe_plan.model.parameters.hourglass is None:
        return Evaluation(energy.max(), 0.0, f"{meaning}; the elements are fully integrated and have none")
    small = outcome.error.total <= outcome.error.allowed
    why = "; not required here: it is bending energy, and the numerical error bounds the effect of the mesh"
    worst = energy.max() / (strain + energy).max()
    return Evaluation(worst, 1.0, meaning + why) if small else Evaluation(worst, 0.1, meaning)


@CHECKS.add("hourglass over total energy", ELEMENTS, PRACTICE)
def _hourglass_of_total(outcome: CornerOutcome) -> Evaluation:
    ratio = outcome.history["hourglass_energy"].max() / outcome.history["kinetic_energy"][0]
    return Evaluation(ratio, 0.05, f"largest hourglass energy over the initial energy; {NCHRP}")


@CHECKS.add("added mass", 'plate.lumping = "exact"', PRACTICE)
def _added_mass(outcome: CornerOutcome) -> Evaluation:
    scene, plate = outcome.fe_plan.case.scene, outcome.fe_plan.plate
    body = plate_density(scene, plate) * plate.thickness * scene.vehicle.length * scene.vehicle.width
    meaning = (
        "mass of the model over density x volume, minus 1; mass is not scaled, so that the limit is rounding; "
        f"{NCHRP}: 0.05"
    )
    return Evaluation(abs(outcome.fe_plan.model.mass / body - 1.0), 1e-9, meaning)


def _metric(metric: str, customary: float, what: str, outcome: CornerOutcome) -> Evaluation:
    """Return the worst metric of all histories.

    The reaction after an unstressed start, which oscillates, is excluded.
    """
    names = [name for name in outcome.metrics if name != "reaction_normal" or outcome.relieved]
    sizes = np.abs([getattr(outcome.metrics[name], metric) for name in names])
    worst = int(np.argmax(sizes))  # the first NaN, if any
    meaning = f"{what}, largest for {names[worst]}; {NCHRP}"
    limit = max(customary, 2.0 * outcome.by_flexibility)
    if limit > customary:
        meaning += f" {customary:g}, here twice the effect of the plate's flexibility"
    return Evaluation(sizes[worst], limit, meaning)


for _name, _how in METRICS.items():
    CHECKS.add(_name, ROUGH, PRACTICE, of_reaction=True)(partial(_metric, *_how))


@np.errstate(all="ignore")  # diverged runs fail their checks; warnings would add nothing
def rings(outcome: CornerOutcome) -> bool:
    """Return whether the reaction oscillated, or the run has no result."""
    showing = [kind for kind in CHECKS.values() if kind.shows_ringing]
    return any(not check.passed for check in evaluated(showing, outcome))


def reaction_checks() -> set[str]:
    """Return the names of checks that an oscillating reaction alone can fail."""
    return {name for name, kind in CHECKS.items() if kind.of_reaction}
