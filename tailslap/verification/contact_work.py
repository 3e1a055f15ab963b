"""Checks of the contact at the corner: what its forces did, against what the energies say.

The history records force, place and energy separately, so that each can be compared with the others:

    spring      integral of N dy must be what the spring's energy lost; N is linear in y, and the trapezoidal rule
                exact whatever the spacing of the rows
    friction    where R is in proportion to |N| or N along the slide, W = -mu integral of v_P dJ, with J the impulse of
                |N| or N, which the time loop sums at every step; what rings between two rows is in it
"""

from __future__ import annotations

import numpy as np

from tailslap.planning.flexibility import sensitivity
from tailslap.verification.check import MORE_DAMPING, ROUGH, STEP, STIFFER, CheckKind, Evaluation, Evidence

LEAST = 1e-12
"""Share of the energy at the start below which a contact holds none: the exact one has only rounding."""


def _contact_work(given: Evidence) -> Evaluation:
    """What the spring lost, against the work of its force; an exact constraint stores nothing."""
    history, corner = given.history, given.fe_plan.model.loop.corner
    if corner.is_exact:
        share = np.abs(history["contact_energy"]).max() / history["kinetic_energy"][0]
        meaning = "energy in the constraint over the energy at the start: the exact constraint stores none"
        return Evaluation(share, LEAST, meaning)
    stepped = slice(-1 if history["t"].size > 2 else None)  # the last row is interpolated, not linear in y
    energy, gap = history["contact_energy"][stepped], history["gap"][stepped]
    # With a dashpot N is not the spring's force alone.
    force = -corner.stiffness * gap if corner.dashpot else history["reaction_normal"][stepped]
    surplus = _work(force, gap) + energy - energy[0]
    scale = np.maximum(np.abs(energy).max(), LEAST * history["kinetic_energy"][0])
    meaning = (
        "work of the normal force less what the energy in the corner's spring lost, over its largest energy"
    )
    return Evaluation(_share(np.abs(surplus).max(), scale), 1e-6, meaning)


def _stored(given: Evidence) -> Evaluation:
    stored = given.history["contact_energy"] + given.history["hourglass_energy"]
    meaning = "largest energy in contact and hourglass control over the energy at the start; customary limit, Radioss"
    return Evaluation(stored.max() / given.history["kinetic_energy"][0], 0.15, meaning)


def _friction(given: Evidence) -> Evaluation | None:
    if not given.friction.impulse:
        return None
    history = given.history
    work = -given.fe_plan.case.scene.corner_friction * _work(history["v_p"], history[given.friction.impulse])
    off = np.abs(history["friction_work"] - history["friction_work"][0] - work).max()
    meaning = (
        "work of friction in the ledger less coefficient x impulse x speed of the corner, over its largest"
    )
    return Evaluation(_share(off, np.abs(work).max()), 0.01, meaning)


def _dissipation(given: Evidence) -> Evaluation | None:
    if given.friction.frictionless or not given.friction.dissipative:
        return None
    work = given.history["friction_work"]
    value = _share(np.diff(work).max(initial=0.0), np.abs(work).max())
    meaning = "largest work that friction gave back between two rows, over all that it took: it may only take"
    return Evaluation(value, 1e-9, meaning)


def _against_rigid(given: Evidence) -> Evaluation | None:
    """Without what friction does to a reaction that rings: that has a check of its own. An unstressed plate's reaction
    swings too far to be compared."""
    if not given.relieved:
        return None
    history, expected = given.history, given.rigid["friction_work"]
    ringing = 0.0 * history["v_p"]
    if given.friction.impulse == "normal_impulse_magnitude":
        rectified = history["normal_impulse_magnitude"] - np.abs(history["normal_impulse"])
        ringing = -given.fe_plan.case.scene.corner_friction * _work(history["v_p"], rectified)
    known = np.isfinite(expected)
    off = np.abs(history["friction_work"] - ringing - expected)[known].max()
    meaning = (
        "work of friction, but for what a ringing reaction adds, less the rigid solution's, over its largest"
    )
    value = _share(off, np.abs(expected[known]).max())
    flexible = sensitivity(given.fe_plan.case.start.angle) * given.fe_plan.deflection_ratio
    return Evaluation(value, 0.05 + 2.0 * flexible, meaning)


def _work(force: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Integral of force over `along` up to each row, by the trapezoidal rule."""
    return np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(along)))


def _share(part: float, whole: float) -> float:
    """Part over whole; 0 where there is neither."""
    return 0.0 if part == 0.0 else float(part / whole)


CONTACT = (
    CheckKind("contact work", _contact_work, STEP),
    CheckKind("contact energy", _stored, STIFFER),
    CheckKind("friction work", _friction, "more time.rows"),
    CheckKind("friction takes energy", _dissipation, MORE_DAMPING),
    CheckKind("friction work against rigid", _against_rigid, ROUGH, of_reaction=True),
)
"""In the order in which they are told."""
