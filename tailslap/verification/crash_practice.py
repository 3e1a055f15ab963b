"""Checks that crash analysts are used to, with the limits that are customary there.

They are looser than this program's own (`mechanics`): a run that keeps those keeps these. Where the limits
are from, and what was found stated in print:

    energy ratio     LS-DYNA's name for total energy over initial energy plus external work; 1 is perfect (LS-DYNA
                     support, "Total energy"). Radioss calls a surplus of up to 2 % acceptable (user's guide, "Results
                     checking")
    contact energy   Radioss: hourglass and contact energy at most 15 % of the total ("Computation checks")
    hourglass, added mass, Sprague-Geers, residuals
                     NCHRP Web-Only Document 179 and its program RSVVP: 10 % of the internal energy and 5 % of the
                     energy at the start, 5 % of the mass, 40 % for M and P, 5 % and 35 %. Customary: cited so in
                     validation reports, not read in the document itself
"""

from __future__ import annotations

from functools import partial

import numpy as np

from tailslap.planning.fe_model import plate_density
from tailslap.planning.flexibility import sensitivity
from tailslap.verification.check import ROUGH, STEP, CheckKind, Evaluation, Evidence
from tailslap.verification.mechanics import STORED_ENERGIES

NCHRP = "customary limit, NCHRP W179"

ELEMENTS = 'plate.element = "quad4", or more elements'


def _energy_ratio(given: Evidence) -> Evaluation:
    """Work of the dampers counts as energy still there, that of the wall's friction as external."""
    history = given.history
    total = np.sum([history[name] for name in STORED_ENERGIES], axis=0) - history["damping_work"]
    ratio = total / (total[0] + history["friction_work"])
    meaning = (
        f"largest distance from 1 of total energy over (initial energy + external work), from {ratio.min():.7f} "
        f"to {ratio.max():.7f}; LS-DYNA's energy ratio, 2 % is customary (Radioss)"
    )
    return Evaluation(np.abs(ratio - 1.0).max(), 0.02, meaning)


def _hourglass_share(given: Evidence) -> Evaluation:
    """Shown for every element: who knows the practice looks for these lines, and they cost nothing. Held to where the
    numerical error is not small enough: an assumed strain stabilises, and with few elements across its energy is that
    of bending, all of it with one."""
    energy, strain = given.history["hourglass_energy"], given.history["strain_energy"]
    meaning = f"largest hourglass energy over the largest strain energy; {NCHRP}"
    if given.fe_plan.model.loop.hourglass is None:
        return Evaluation(energy.max(), 0.0, f"{meaning}; the elements are fully integrated and have none")
    small = given.error.total <= given.error.allowed
    why = "; not required here: it is energy of bending, and the numerical error tells what the mesh changes"
    return Evaluation(
        energy.max() / (strain + energy).max(), 1.0 if small else 0.1, meaning + (why if small else "")
    )


def _hourglass_of_total(given: Evidence) -> Evaluation:
    share = given.history["hourglass_energy"].max() / given.history["kinetic_energy"][0]
    return Evaluation(share, 0.05, f"largest hourglass energy over the energy at the start; {NCHRP}")


def _added_mass(given: Evidence) -> Evaluation:
    vehicle, plate = given.fe_plan.case.scene.vehicle, given.fe_plan.plate
    body = plate_density(given.fe_plan.case.scene, plate) * plate.thickness * vehicle.length * vehicle.width
    meaning = (
        "mass of the model over density x volume, less 1; no mass is scaled here, and the exact inertia moves mass "
        f"between nodes but adds none, so the limit is rounding; {NCHRP}, would be 0.05"
    )
    return Evaluation(abs(given.fe_plan.model.mass / body - 1.0), 1e-9, meaning)


def _metric(metric: str, customary: float, what: str, given: Evidence) -> Evaluation:
    """The worst of the histories; the reaction of an unstressed start rings, and is only shown."""
    names = [name for name in given.metrics if name != "reaction_normal" or given.relieved]
    sizes = np.abs([getattr(given.metrics[name], metric) for name in names])
    worst = int(np.argmax(sizes))  # the first NaN, where there is one
    meaning = f"{what}, largest for {names[worst]}; {NCHRP}"
    limit = max(customary, 2.0 * sensitivity(given.fe_plan.case.start.angle) * given.fe_plan.deflection_ratio)
    if limit > customary:
        meaning += f" {customary:g}, here twice what the flexibility of this soft plate changes"
    return Evaluation(sizes[worst], limit, meaning)


METRICS = {
    "Sprague-Geers magnitude": ("magnitude", 0.4, "difference in size between FE and rigid history"),
    "Sprague-Geers phase": (
        "phase",
        0.4,
        "difference in phase between FE and rigid history, 1 for opposite signs",
    ),
    "Sprague-Geers combined": ("combined", 0.4, "magnitude and phase together"),
    "mean residual": ("mean_residual", 0.05, "mean of FE - rigid over the rigid history's peak"),
    "deviation of residuals": (
        "deviation",
        0.35,
        "standard deviation of FE - rigid over the rigid history's peak",
    ),
}
"""By the name of the check: metric, its customary limit, and what it is."""

ENERGY_RATIO = CheckKind("energy ratio", _energy_ratio, STEP)
"""It is told before the checks of the contact, the others after them."""

PRACTICE = (
    CheckKind("hourglass share", _hourglass_share, ELEMENTS),
    CheckKind("hourglass over total energy", _hourglass_of_total, ELEMENTS),
    CheckKind("added mass", _added_mass, 'plate.lumping = "exact"'),
    *(CheckKind(name, partial(_metric, *how), ROUGH, of_reaction=True) for name, how in METRICS.items()),
)
"""In the order in which they are told."""
