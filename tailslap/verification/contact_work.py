"""Checks of the contact at the corner: what its forces did, against what the energies say.

The history records force, place and energy separately, so that each can be held against the others:

    spring      integral of N dy must be what the spring's energy lost; N is linear in y, and the trapezoidal rule
                exact whatever the spacing of the rows
    friction    R = -mu |N| (drag) or -mu N (signed) along the slide, so W = -mu integral of v_P dJ, with J the impulse
                of |N| or N, which the time loop sums at every step; what rings between two rows is in it
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from postprocess.pages.report import Check
from tailslap.planning.flexibility import sensitivity

if TYPE_CHECKING:
    from tailslap.planning.fe_plan import FePlan

Columns = Mapping[str, np.ndarray]

LEAST = 1e-12
"""Share of the energy at the start below which a contact holds none: the exact one has only rounding."""


def contact_checks(fe_plan: FePlan, history: Columns, rigid: Columns) -> Iterable[Check]:
    """Work of the spring, size of its energy; work of friction by impulse, by direction, by the rigid solution."""
    from fem.contact.corner import Exact

    exact = isinstance(fe_plan.model.loop.corner.hold, Exact)
    yield _no_spring(history) if exact else _spring(fe_plan, history)
    yield _stored(history)
    yield _friction(fe_plan, history)
    if fe_plan.plan.scene.corner.reaction == "drag":
        yield _dissipation(history)
    if fe_plan.plate.start != "unstressed":  # its reaction swings too far to be compared
        yield _against_rigid(fe_plan, history, rigid)


def _spring(fe_plan: FePlan, history: Columns) -> Check:
    corner, hold = fe_plan.plan.scene.corner, fe_plan.model.loop.corner.hold
    stepped = slice(-1 if history["t"].size > 2 else None)  # the last row is interpolated, not linear in y
    energy, gap = history["contact_energy"][stepped], history["gap"][stepped]
    # With a dashpot N is not the spring's force alone.
    force = -hold.stiffness * gap if corner.damping_ratio else history["reaction_normal"][stepped]
    surplus = _work(force, gap) + energy - energy[0]
    scale = np.maximum(np.abs(energy).max(), LEAST * history["kinetic_energy"][0])
    meaning = (
        "work of the normal force less what the energy in the corner's spring lost, over its largest energy"
    )
    return Check.at_most("contact work", _share(np.abs(surplus).max(), scale), 1e-6, meaning)


def _no_spring(history: Columns) -> Check:
    share = np.abs(history["contact_energy"]).max() / history["kinetic_energy"][0]
    meaning = "energy in the hold over the energy at the start: the exact constraint stores none"
    return Check.at_most("contact work", share, LEAST, meaning)


def _stored(history: Columns) -> Check:
    held = history["contact_energy"] + history["hourglass_energy"]
    meaning = "largest energy in contact and hourglass control over the energy at the start; customary limit, Radioss"
    return Check.at_most("contact energy", held.max() / history["kinetic_energy"][0], 0.15, meaning)


def _friction(fe_plan: FePlan, history: Columns) -> Check:
    scene = fe_plan.plan.scene
    impulse = history["normal_impulse_magnitude" if scene.corner.reaction == "drag" else "normal_impulse"]
    work = -scene.corner_friction * _work(history["v_p"], impulse)
    off = np.abs(history["friction_work"] - history["friction_work"][0] - work).max()
    meaning = (
        "work of friction in the ledger less coefficient x impulse x speed of the corner, over its largest"
    )
    return Check.at_most("friction work", _share(off, np.abs(work).max()), 0.01, meaning)


def _dissipation(history: Columns) -> Check:
    work = history["friction_work"]
    value = _share(np.diff(work).max(initial=0.0), np.abs(work).max())
    meaning = "largest work that friction gave back between two rows, over all that it took: it may only take"
    return Check.at_most("friction takes energy", value, 1e-9, meaning)


def _against_rigid(fe_plan: FePlan, history: Columns, rigid: Columns) -> Check:
    """Without what friction does to a reaction that rings: that has a check of its own."""
    scene, expected = fe_plan.plan.scene, rigid["friction_work"]
    ringing = 0.0 * history["v_p"]
    if scene.corner.reaction == "drag":
        rectified = history["normal_impulse_magnitude"] - np.abs(history["normal_impulse"])
        ringing = -scene.corner_friction * _work(history["v_p"], rectified)
    known = np.isfinite(expected)
    off = np.abs(history["friction_work"] - ringing - expected)[known].max()
    meaning = (
        "work of friction, but for what a ringing reaction adds, less the rigid solution's, over its largest"
    )
    value = _share(off, np.abs(expected[known]).max())
    flexible = sensitivity(fe_plan.plan.start.angle) * fe_plan.give
    return Check.at_most("friction work against rigid", value, 0.05 + 2.0 * flexible, meaning)


def _work(force: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Integral of force over `along` up to each row, by the trapezoidal rule."""
    return np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(along)))


def _share(part: float, whole: float) -> float:
    """Part over whole; 0 where there is neither."""
    return 0.0 if part == 0.0 else float(part / whole)
