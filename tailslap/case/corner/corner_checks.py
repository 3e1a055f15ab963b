"""The checks that a run of a constrained corner must pass before its numbers are believed. What is not finite fails.

Adding one is adding it to MECHANICS, CONTACT or PRACTICE, or registering it in CHECKS. The limits of the first two are
this program's own. The history records force, place and energy of the contact separately, so that each can be compared
with the others:

    spring      integral of N dy must be what the spring's energy lost; N is linear in y, and the trapezoidal rule
                exact whatever the spacing of the rows
    friction    R of each row is what the law of the scene, evaluated in Python, makes of N and the slide; where it is
                proportion to |N| or N, W = -mu integral of v_P dJ, with J the impulse of |N| or N, which the time loop
                sums at every step: what rings between two rows is in it

PRACTICE has checks that crash analysts are used to, with the limits that are customary there. They are looser: a run
that keeps the others keeps these. Where the limits are from, and what was found stated in print:

    energy ratio     LS-DYNA's name for total energy over initial energy plus external work; 1 is perfect (LS-DYNA
                     support, "Total energy"). Radioss calls a surplus of up to 2 % acceptable (user's guide, "Results
                     checking")
    contact energy   Radioss: hourglass and contact energy at most 15 % of the total ("Computation checks")
    hourglass, added mass, Sprague-Geers, residuals
                     NCHRP Web-Only Document 179 and its program RSVVP: 10 % of the internal energy and 5 % of the
                     energy at the start, 5 % of the mass, 40 % for M and P, 5 % and 35 %. Customary: cited so in
                     validation reports, not read in the document itself
"""

import math
from functools import partial

import numpy as np

from fem.registry import Registry
from postprocess.comparison.quantities import largest
from tailslap.case.case import FINER, STEP, CheckKind, Evaluation, evaluated, time_step
from tailslap.case.corner.numerical_error import FLOOR, FRACTION, RINGING
from tailslap.case.corner.outcome import STORED_ENERGIES, CornerOutcome, energy_error
from tailslap.case.plate_input import plate_density

STIFFER = 'a larger corner.penalty_scale, or corner.constraint = "exact"'
MORE_DAMPING = "remove damping.kind, or specify damping.rate"
SOFT = "a stiffer plate"
ROUGH = f"{MORE_DAMPING}; remove the spring of the corner"
"""Advice of several checks."""

ERROR_ADVICE = {
    "mesh": FINER,
    "contact_spring": STIFFER,
    "damping": "remove [damping], or a smaller damping.rate",
    "rounding": "larger elements, for fewer time steps",
}
"""Advice on the terms of the numerical error."""

STOPS = 4.0
"""Change of the corner's speed by friction in a step, as a multiple: below it the corner may stop within the step."""

OSCILLATES = 1.25
"""Kinetic energy of the oscillation of an unstressed start, over the elastic energy that it begins without: at most 1
in a linear model without friction."""

EXPLAINED = 2.0
"""Ripple of a reaction that the plate's flexibility explains, as a multiple of its deflection ratio."""

LEAST = 1e-12
"""Fraction of the energy at the start below which a contact holds none: the exact one has only rounding."""

NCHRP = "customary limit, NCHRP W179"

ELEMENTS = 'plate.element = "quad4", or more elements'


def _reached(given: CornerOutcome) -> Evaluation:
    meaning = "angle [rad] between side and wall at the end of the run; 0 at the tail-slap"
    angle = 0.0 if given.run.strike else abs(given.history["theta"][-1]) or math.inf
    return Evaluation(angle, 0.0, meaning)


def _finite(given: CornerOutcome) -> Evaluation:
    force = given.fe_plan.case.force
    theory = (*given.fe_plan.case.tail_slap.values(), force.impulse, force.peak_force)
    results = [*given.history.values(), np.array([*theory, *given.difference.values()], dtype=float)]
    bad = sum(int(np.count_nonzero(~np.isfinite(column))) for column in results)
    return Evaluation(bad, 0, "entries of the histories and results that are not finite numbers")


def _energy(given: CornerOutcome) -> Evaluation:
    worst = np.abs(energy_error(given.history)).max() / given.history["kinetic_energy"][0]
    return Evaluation(worst, 1e-6, "largest energy-balance error over the initial energy")


def _momentum(given: CornerOutcome) -> Evaluation:
    mass, speed = given.fe_plan.model.mass, given.history["v_gy"]
    gained, scale = mass * (speed - speed[0]), mass * np.abs(speed).max()
    worst = np.abs(gained - given.history["normal_impulse"]).max() / scale
    return Evaluation(
        worst, 1e-9, "lateral momentum minus impulse of the reaction, over the largest momentum"
    )


def _penetration(given: CornerOutcome) -> Evaluation:
    gap = np.abs(given.history["gap"]).max() / given.fe_plan.case.body.width
    return Evaluation(gap, 0.01, "largest distance of the corner from the wall's line over the plate's width")


def _ringing(given: CornerOutcome) -> Evaluation | None:
    if not given.relieved:
        return None
    meaning = "effect of friction by an oscillating reaction on v_GX or omega, relative"
    return Evaluation(given.ringing, max(RINGING, FRACTION * given.by_flexibility), meaning)


def _reaction(given: CornerOutcome) -> Evaluation | None:
    if not given.relieved:
        return None
    expected = given.rigid_history["reaction_normal"]
    known = np.isfinite(expected)
    ripple = given.history["reaction_normal"][known] - expected[known]
    value = np.sqrt(np.mean(ripple**2) / np.mean(expected[known] ** 2))
    meaning = "root mean square of the difference from the rigid reaction, over that of the rigid reaction"
    return Evaluation(value, 0.1 + EXPLAINED * given.fe_plan.deflection_ratio, meaning)


def _oscillation(given: CornerOutcome) -> Evaluation | None:
    """An unstressed plate swings about its elastic state with the energy of that state, which goes with N squared."""
    if given.relieved:
        return None
    fe_plan, reaction = given.fe_plan, given.rigid_history["reaction_normal"]
    reaction = reaction[np.isfinite(reaction)]
    scale = float((reaction**2).max() / reaction[0] ** 2) * fe_plan.elastic_energy
    undamped = fe_plan.model.loop.elastic_damping is None
    limit = OSCILLATES * math.exp(fe_plan.growth.harmless if undamped else 0.0)
    meaning = (
        "largest kinetic energy of the oscillation over the elastic energy of the plate under its reaction; at most 1 "
        "in theory for an unstressed start, and more by slow growth through friction"
    )
    return Evaluation(float(given.history["vibration_energy"].max()) / scale, limit, meaning)


def _numerical_error(given: CornerOutcome) -> Evaluation | None:
    """Fails where companions are wanted and none could be made: its value is not a number then."""
    if not (given.fe and given.fe_plan.case.scene.verify.companion):
        return None
    meaning = (
        f"bound of the error of the five quantities by mesh, constraint, damping and rounding; limit: {FLOOR:g} and "
        f"{100 * FRACTION:g} % of the effect of flexibility"
    )
    largest = max(ERROR_ADVICE, key=lambda term: np.nan_to_num(getattr(given.error, term), nan=np.inf))
    advice = ERROR_ADVICE[largest] if given.relieved else f"remove plate.start; {ERROR_ADVICE[largest]}"
    return Evaluation(given.error.total, given.error.allowed, meaning, advice)


def _agreement(given: CornerOutcome) -> Evaluation | None:
    """Judged only where the scene demands it: a flexible plate that is right need not agree."""
    tolerance = given.fe_plan.case.scene.verify.tolerance
    if tolerance is None:
        return None
    meaning = "largest relative difference from the rigid motion; limit: verify.tolerance"
    return Evaluation(largest(given.difference), tolerance, meaning)


MECHANICS = (
    CheckKind("tail-slap reached", _reached, f"{MORE_DAMPING}; {SOFT}", shows_ringing=True),
    CheckKind("finite numbers", _finite, f"{STEP}; {MORE_DAMPING}", shows_ringing=True),
    CheckKind("time step", time_step, STEP),
    CheckKind("energy balance", _energy, STEP),
    CheckKind("momentum balance", _momentum, STEP),
    CheckKind("penetration", _penetration, STIFFER),
    CheckKind("friction by ringing", _ringing, ROUGH, shows_ringing=True),
    CheckKind("reaction against rigid", _reaction, ROUGH, shows_ringing=True, of_reaction=True),
    CheckKind("oscillation", _oscillation, ROUGH, shows_ringing=True),
    CheckKind("numerical error", _numerical_error, FINER),
    CheckKind("agreement with rigid", _agreement, "a stiffer plate, or a larger verify.tolerance"),
)
"""In the order in which they are listed."""


def _contact_work(given: CornerOutcome) -> Evaluation:
    """Energy that the spring lost, against the work of its force; an exact constraint stores nothing."""
    history, corner = given.history, given.fe_plan.model.loop.corner
    if corner.is_exact:
        fraction = np.abs(history["contact_energy"]).max() / history["kinetic_energy"][0]
        meaning = "energy of the constraint over the initial energy; 0 for an exact constraint"
        return Evaluation(fraction, LEAST, meaning)
    stepped = slice(-1 if history["t"].size > 2 else None)  # the last row is interpolated, not linear in y
    energy, gap = history["contact_energy"][stepped], history["gap"][stepped]
    # With a dashpot N is not the spring's force alone.
    force = -corner.stiffness * gap if corner.dashpot else history["reaction_normal"][stepped]
    surplus = _work(force, gap) + energy - energy[0]
    scale = np.maximum(np.abs(energy).max(), LEAST * history["kinetic_energy"][0])
    meaning = "work of the normal force minus the decrease of the spring's energy, over its largest energy"
    return Evaluation(_over(np.abs(surplus).max(), scale), 1e-6, meaning)


def _stored(given: CornerOutcome) -> Evaluation:
    stored = given.history["contact_energy"] + given.history["hourglass_energy"]
    meaning = (
        "largest energy of contact and hourglass control over the initial energy; customary limit, Radioss"
    )
    return Evaluation(stored.max() / given.history["kinetic_energy"][0], 0.15, meaning)


def _friction_law(given: CornerOutcome) -> Evaluation:
    """A corner that slides would need any force to stop: the law cuts it. One that may stop within the step, or is at
    rest, is held by a force that the law leaves as it is."""
    law, coefficient, loop = (
        given.friction,
        given.fe_plan.case.scene.corner_friction,
        given.fe_plan.model.loop,
    )
    constants = law.constants(coefficient) if coefficient and not law.frictionless else None
    stepped = slice(-1 if given.history["t"].size > 2 else None)  # the last row is interpolated
    names = ("reaction_tangential", "reaction_normal", "v_p")
    force, normal, speed = (given.history[name][stepped] for name in names)

    def off(rows: np.ndarray, stopping: np.ndarray) -> np.ndarray:
        pairs = zip(normal[rows], stopping[rows], strict=True)
        return np.abs(force[rows] - [law.force(constants, *pair) if constants else 0.0 for pair in pairs])

    slides = np.abs(speed) > STOPS * loop.time_step * loop.corner.mobility * np.abs(force).max()
    distance, held = off(np.ones_like(slides), -np.copysign(np.inf, speed)), ~slides
    distance[held] = np.minimum(distance[held], off(held, force))
    meaning = (
        "friction minus that of the scene's law at the same reaction and speed, over the largest friction"
    )
    return Evaluation(_over(distance.max(), np.abs(force).max()), 1e-9, meaning)


def _friction(given: CornerOutcome) -> Evaluation | None:
    if not given.friction.impulse:
        return None
    history, recorded = given.history, given.history["friction_work"]
    work = -given.fe_plan.case.scene.corner_friction * _work(history["v_p"], history[given.friction.impulse])
    off = _over(np.abs(recorded - recorded[0] - work).max(), np.abs(work).max())
    step = given.fe_plan.model.loop.time_step * np.abs(history["reaction_tangential"] * history["v_p"]).max()
    meaning = (
        "friction work minus coefficient x impulse x corner speed, over its largest value; initial work over that of a "
        "step"
    )
    return Evaluation(max(off, _over(abs(recorded[0]), step)), 0.01, meaning)


def _dissipation(given: CornerOutcome) -> Evaluation | None:
    if given.friction.frictionless or not given.friction.dissipative:
        return None
    work = given.history["friction_work"]
    value = _over(np.diff(work).max(initial=0.0), np.abs(work).max())
    meaning = (
        "largest increase of the friction work between two rows over the total; friction only dissipates"
    )
    return Evaluation(value, 1e-9, meaning)


def _against_rigid(given: CornerOutcome) -> Evaluation | None:
    """Work of friction without what a ringing reaction adds, which has its own check. An unstressed plate's reaction
    swings too far to be compared."""
    if not given.relieved:
        return None
    history, expected = given.history, given.rigid_history["friction_work"]
    ringing = 0.0 * history["v_p"]
    if given.friction.impulse == "normal_impulse_magnitude":
        rectified = history["normal_impulse_magnitude"] - np.abs(history["normal_impulse"])
        ringing = -given.fe_plan.case.scene.corner_friction * _work(history["v_p"], rectified)
    known = np.isfinite(expected)
    off = np.abs(history["friction_work"] - ringing - expected)[known].max()
    meaning = "friction work without the part by oscillations, minus that of the rigid body, over the largest"
    value = _over(off, np.abs(expected[known]).max())
    return Evaluation(value, 0.05 + 2.0 * given.by_flexibility, meaning)


def _work(force: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Integral of force over `along` up to each row, by the trapezoidal rule."""
    return np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(along)))


def _over(part: float, whole: float) -> float:
    """Part over whole; 0 where there is neither."""
    return 0.0 if part == 0.0 else float(part / whole)


CONTACT = (
    CheckKind("contact work", _contact_work, STEP),
    CheckKind("contact energy", _stored, STIFFER),
    CheckKind("friction law", _friction_law, "empty the folder of compiled code, under ~/.cache/tailslap"),
    CheckKind("friction work", _friction, "a larger time.rows"),
    CheckKind("friction takes energy", _dissipation, MORE_DAMPING),
    CheckKind("friction work against rigid", _against_rigid, ROUGH, of_reaction=True),
)
"""In the order in which they are listed."""


def _energy_ratio(given: CornerOutcome) -> Evaluation:
    """Work of the dampers counts as energy still there, that of the wall's friction as external."""
    history = given.history
    total = np.sum([history[name] for name in STORED_ENERGIES], axis=0) - history["damping_work"]
    ratio = total / (total[0] + history["friction_work"])
    meaning = (
        f"largest deviation from 1 of total energy over (initial energy + external work), from {ratio.min():.7f} "
        f"to {ratio.max():.7f}; LS-DYNA's energy ratio, 2 % is customary (Radioss)"
    )
    return Evaluation(np.abs(ratio - 1.0).max(), 0.02, meaning)


def _hourglass_of_strain(given: CornerOutcome) -> Evaluation:
    """Ratio that is shown for every element: who knows the practice looks for these lines, and they cost nothing. Held
    to where the numerical error is not small enough: an assumed strain stabilises, and with few elements across its
    energy is that of bending, all of it with one."""
    energy, strain = given.history["hourglass_energy"], given.history["strain_energy"]
    meaning = f"largest hourglass energy over the largest strain energy; {NCHRP}"
    if given.fe_plan.model.loop.hourglass is None:
        return Evaluation(energy.max(), 0.0, f"{meaning}; the elements are fully integrated and have none")
    small = given.error.total <= given.error.allowed
    why = "; not required here: it is bending energy, and the numerical error bounds the effect of the mesh"
    worst = energy.max() / (strain + energy).max()
    return Evaluation(worst, 1.0, meaning + why) if small else Evaluation(worst, 0.1, meaning)


def _hourglass_of_total(given: CornerOutcome) -> Evaluation:
    ratio = given.history["hourglass_energy"].max() / given.history["kinetic_energy"][0]
    return Evaluation(ratio, 0.05, f"largest hourglass energy over the initial energy; {NCHRP}")


def _added_mass(given: CornerOutcome) -> Evaluation:
    vehicle, plate = given.fe_plan.case.scene.vehicle, given.fe_plan.plate
    body = plate_density(given.fe_plan.case.scene, plate) * plate.thickness * vehicle.length * vehicle.width
    meaning = (
        "mass of the model over density x volume, minus 1; mass is not scaled, so that the limit is rounding; "
        f"{NCHRP}: 0.05"
    )
    return Evaluation(abs(given.fe_plan.model.mass / body - 1.0), 1e-9, meaning)


def _metric(metric: str, customary: float, what: str, given: CornerOutcome) -> Evaluation:
    """The worst of the histories; the reaction of an unstressed start rings, and is only shown."""
    names = [name for name in given.metrics if name != "reaction_normal" or given.relieved]
    sizes = np.abs([getattr(given.metrics[name], metric) for name in names])
    worst = int(np.argmax(sizes))  # the first NaN, where there is one
    meaning = f"{what}, largest for {names[worst]}; {NCHRP}"
    limit = max(customary, 2.0 * given.by_flexibility)
    if limit > customary:
        meaning += f" {customary:g}, here twice the effect of the plate's flexibility"
    return Evaluation(sizes[worst], limit, meaning)


RESIDUAL = "of FE - rigid over the rigid history's peak"
PHASE = "difference in phase between FE and rigid history, 1 for opposite signs"
METRICS = {
    "Sprague-Geers magnitude": ("magnitude", 0.4, "difference in magnitude between FE and rigid history"),
    "Sprague-Geers phase": ("phase", 0.4, PHASE),
    "Sprague-Geers combined": ("combined", 0.4, "magnitude and phase together"),
    "mean residual": ("mean_residual", 0.05, f"mean {RESIDUAL}"),
    "deviation of residuals": ("deviation", 0.35, f"standard deviation {RESIDUAL}"),
}
"""Metric, its customary limit, and what it is, by the name of the check."""

ENERGY_RATIO = CheckKind("energy ratio", _energy_ratio, STEP)
"""Listed before the checks of the contact, the others after them."""

PRACTICE = (
    CheckKind("hourglass over strain energy", _hourglass_of_strain, ELEMENTS),
    CheckKind("hourglass over total energy", _hourglass_of_total, ELEMENTS),
    CheckKind("added mass", _added_mass, 'plate.lumping = "exact"'),
    *(CheckKind(name, partial(_metric, *how), ROUGH, of_reaction=True) for name, how in METRICS.items()),
)
"""In the order in which they are listed."""

CHECKS: Registry[CheckKind] = Registry("check")
"""Checks by name, in the order in which they are listed."""

for _kind in (*MECHANICS, ENERGY_RATIO, *CONTACT, *PRACTICE):
    CHECKS.register(_kind)


@np.errstate(all="ignore")  # a run that diverged is judged, not warned about
def rings(outcome: CornerOutcome) -> bool:
    """True where a check says that the reaction rang, or the run came to no answer."""
    showing = [kind for kind in CHECKS.values() if kind.shows_ringing]
    return any(not check.passed for check in evaluated(showing, outcome))


def reaction_checks() -> set[str]:
    """Names of the checks that a reaction which rings can fail while the five quantities are right."""
    return {name for name, kind in CHECKS.items() if kind.of_reaction}
