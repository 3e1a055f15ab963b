"""Checks that crash analysts are used to, with the limits that are customary there.

They are looser than this program's own (`checks`): a run that keeps those keeps these. Where the limits
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

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from postprocess.comparison.metrics import Metrics, compare_histories
from postprocess.pages.report import Check
from tailslap.planning.fe_model import plate_density
from tailslap.planning.flexibility import sensitivity
from tailslap.verification.contact_work import contact_checks

if TYPE_CHECKING:
    from tailslap.planning.fe_plan import FePlan

Columns = Mapping[str, np.ndarray]

COMPARED_HISTORIES = ("v_gx", "v_gy", "omega", "theta", "reaction_normal")
"""Histories that are compared with the rigid motion's."""

NCHRP = "customary limit, NCHRP W179"

STORED_ENERGIES = ("kinetic_energy", "strain_energy", "hourglass_energy", "contact_energy")
"""Columns of the energy that the model holds."""

NEXT_TO_NOTHING = 1e-6
"""Share of the energy at the start below which the plate stores so little that its kind does not matter."""

METRIC_LIMITS = {
    "magnitude": ("Sprague-Geers magnitude", 0.4),
    "phase": ("Sprague-Geers phase", 0.4),
    "combined": ("Sprague-Geers combined", 0.4),
    "mean_residual": ("mean residual", 0.05),
    "deviation": ("deviation of residuals", 0.35),
}
"""Name and limit of the check of each metric."""

MEANINGS = {
    "magnitude": "difference in size between FE and rigid history",
    "phase": "difference in phase between FE and rigid history, 1 for opposite signs",
    "combined": "magnitude and phase together",
    "mean_residual": "mean of FE - rigid over the rigid history's peak",
    "deviation": "standard deviation of FE - rigid over the rigid history's peak",
}


@np.errstate(all="ignore")  # a run that diverged is judged, not warned about
def practice_checks(fe_plan: FePlan, history: Columns, rigid: Columns, judged: bool = False) -> list[Check]:
    """Energy ratio, contact, hourglass, added mass, and the metrics of the histories; judged: whether a second run, of
    elements without hourglass modes, tells what these change."""
    return [
        _energy_ratio(history),
        *contact_checks(fe_plan, history, rigid),
        *_hourglass(fe_plan, history, judged),
        _added_mass(fe_plan),
        *_metric_checks(fe_plan, history_metrics(history, rigid)),
    ]


def history_metrics(history: Columns, rigid: Columns) -> dict[str, Metrics]:
    """Metrics of each compared history while the rigid solution is known."""
    known = np.isfinite(rigid["v_gx"])
    instants = history["t"][known]
    return {
        name: compare_histories(instants, history[name][known], rigid[name][known])
        for name in COMPARED_HISTORIES
    }


def _energy_ratio(history: Columns) -> Check:
    """Work of the dampers counts as energy still there, that of the wall's friction as external."""
    total = np.sum([history[name] for name in STORED_ENERGIES], axis=0) - history["damping_work"]
    ratio = total / (total[0] + history["friction_work"])
    meaning = (
        f"largest distance from 1 of total energy over (initial energy + external work), from {ratio.min():.7f} "
        f"to {ratio.max():.7f}; LS-DYNA's energy ratio, 2 % is customary (Radioss)"
    )
    return Check.at_most("energy ratio", np.abs(ratio - 1.0).max(), 0.02, meaning)


def _hourglass(fe_plan: FePlan, history: Columns, judged: bool) -> Iterable[Check]:
    """Shown for every element: who knows the practice looks for these lines, and they cost nothing."""
    energy, strain = history["hourglass_energy"], history["strain_energy"]
    controlled = fe_plan.model.loop.hourglass is not None
    how = (
        "above it the mesh is too coarse" if controlled else "the elements are fully integrated and have none"
    )
    stored = (strain + energy).max()
    little = stored < NEXT_TO_NOTHING * history["kinetic_energy"][0]
    spared = little or judged
    why = "it stores next to nothing" if little else "the second run tells what it changes"
    yield Check.at_most(
        "hourglass share",
        energy.max() / stored,
        1.0 if spared else 0.1,
        f"largest hourglass energy over the largest strain energy; {how}; {NCHRP}"
        + (f"; not held to it here: {why}" if spared else ""),
    )
    yield Check.at_most(
        "hourglass over total energy",
        energy.max() / history["kinetic_energy"][0],
        0.05,
        f"largest hourglass energy over the energy at the start; {NCHRP}",
    )


def _added_mass(fe_plan: FePlan) -> Check:
    vehicle, plate = fe_plan.plan.scene.vehicle, fe_plan.plate
    body = plate_density(fe_plan.plan, plate) * plate.thickness * vehicle.length * vehicle.width
    meaning = (
        "mass of the model over density x volume, less 1; no mass is scaled here, and the exact inertia moves mass "
        f"between nodes but adds none, so the limit is rounding; {NCHRP}, would be 0.05"
    )
    return Check.at_most("added mass", abs(fe_plan.model.mass / body - 1.0), 1e-9, meaning)


def _metric_checks(fe_plan: FePlan, metrics: Mapping[str, Metrics]) -> Iterable[Check]:
    """The worst of the histories for each metric; the reaction of an unstressed start rings, and is only shown."""
    names = [name for name in metrics if name != "reaction_normal" or fe_plan.plate.start != "unstressed"]
    for metric, (title, customary) in METRIC_LIMITS.items():
        sizes = np.abs([getattr(metrics[name], metric) for name in names])
        worst = int(np.argmax(sizes))  # the first NaN, where there is one
        meaning = f"{MEANINGS[metric]}, largest for {names[worst]}; {NCHRP}"
        limit = max(customary, 2.0 * sensitivity(fe_plan.plan.start.angle) * fe_plan.give)
        if limit > customary:
            meaning += f" {customary:g}, here twice what the flexibility of this soft plate changes"
        yield Check.at_most(title, sizes[worst], limit, meaning)
