"""Checks of a run of a whole impact.

A value that is not finite fails.
"""

import math
from functools import partial

import numpy as np

from solver.impact.strikes import nearest
from tailslap.case import case, check
from tailslap.case.impact import answers, error, run

STORED = (
    "kinetic_energy",
    "strain_energy",
    "hourglass_energy",
    "contact_energy",
    "crush_energy",
    "wall_energy",
)
"""Columns of the stored and dissipated energy of the model."""

LOSS = 2e-2
"""Energy over the initial that exact contact may dissipate: that of its nodes on contact."""

MESH_CHECKS = {quantity: f"error of {words}" for quantity, words in error.STATED.items()}
"""Names of the checks of the stated error by quantity. A run without a stated error fails them."""

CLOSER = f"{check.FINER}; contact.patch_length for the force of a corner; a larger verify.mesh"
HINGED = CLOSER.replace("corner;", "corner, trailer.hitch_length for that of a hinge;")
FAULT = "please report it: this is a fault of the program"

IN_SPACE = "energy in space", "error in space"
"""Names of the checks of the motion in space."""

CHECKS: check.CheckRegistry[run.ImpactOutcome] = check.CheckRegistry("check")
"""Checks of a run of a whole impact."""


def energy_error(outcome: run.ImpactOutcome) -> np.ndarray:
    """Return the energy surplus [J], shape (rows,)."""
    history = outcome.run.history
    return check.energy_surplus(history, STORED) - history.get("tyre_work", 0.0)


def _initial_energy(outcome: run.ImpactOutcome) -> float:
    plan = outcome.fe_plan.case
    return 0.5 * sum(unit.mass for unit in plan.vehicles) * (plan.touch.v_gx**2 + plan.touch.v_gy**2)


@CHECKS.add("finite numbers", check.STEP)
def _finite(outcome: run.ImpactOutcome) -> check.Evaluation:
    arrays = (*outcome.run.history.values(), outcome.run.normal)
    not_finite = sum(int(np.count_nonzero(~np.isfinite(array))) for array in arrays)
    return check.Evaluation(not_finite, 0, "entries of the histories that are not finite numbers")


CHECKS.add("time step", check.STEP)(case.time_step)


@CHECKS.add("energy balance", check.STEP)
def _energy(outcome: run.ImpactOutcome) -> check.Evaluation:
    worst = np.abs(energy_error(outcome)).max() / _initial_energy(outcome)
    exact = _is_exact(outcome)
    meaning = "largest energy-balance error over the initial energy"
    meaning += "; exact contact dissipates the kinetic energy of nodes on contact" if exact else ""
    return check.Evaluation(worst, LOSS if exact else 1e-3, meaning)


@CHECKS.add("energy gained", check.STEP)
def _gain(outcome: run.ImpactOutcome) -> check.Evaluation:
    gain = energy_error(outcome).max() / _initial_energy(outcome)
    return check.Evaluation(gain, 1e-3, "largest energy gain over the initial energy")


def _is_exact(outcome: run.ImpactOutcome) -> bool:
    scene = outcome.fe_plan.case.scene
    return not scene.crushes and scene.needed_contact.enforcement == "exact"


@CHECKS.add("momentum balance", FAULT)
def _momentum(outcome: run.ImpactOutcome) -> check.Evaluation:
    h, plan, mass = outcome.run.history, outcome.fe_plan.case, outcome.fe_plan.model.mass
    scale = mass * math.hypot(plan.touch.v_gx, plan.touch.v_gy)
    across = mass * (h["v_gy"] - plan.touch.v_gy) - h["normal_impulse"] - h.get("tyre_impulse_normal", 0.0)
    along = (
        mass * (h["v_gx"] - plan.touch.v_gx) - h["tangential_impulse"] - h.get("tyre_impulse_tangential", 0.0)
    )
    worst = max(np.abs(across).max(), np.abs(along).max())
    meaning = "momentum minus integral of the forces of wall and tyres, in both directions"
    return check.Evaluation(worst / scale, 1e-9, meaning)


@CHECKS.add("angular momentum", FAULT)
def _angular(outcome: run.ImpactOutcome) -> check.Evaluation:
    h = outcome.run.history
    turned = h["angular_momentum"] - h["moment_impulse"] - h.get("tyre_impulse_angular", 0.0)
    worst = np.abs(turned - turned[0]).max() / np.abs(h["angular_momentum"]).max()
    return check.Evaluation(worst, 1e-9, "angular momentum minus integrated moment of wall and tyres")


@CHECKS.add("no pull", FAULT)
def _pull(outcome: run.ImpactOutcome) -> check.Evaluation:
    least = -float(outcome.run.normal.min())
    return check.Evaluation(least, 1e-6 * np.abs(outcome.run.normal).max(), "largest tensile force [N]")


@CHECKS.add("strikes found", "a stiffer plate, or a later time.end")
def _strikes(outcome: run.ImpactOutcome) -> check.Evaluation:
    counted = outcome.rigid.counted
    missing = min(counted, len(outcome.rigid.strikes)) - len(outcome.fe.strikes[:counted])
    number = "two" if counted == 2 else f"{counted}"
    return check.Evaluation(
        missing, 0, f"of the rigid vehicle's first {number} strikes, those absent from the FE run"
    )


@CHECKS.add("sampling", "a softer contact: the rows do not resolve strikes as short as these")
def _sampling(outcome: run.ImpactOutcome) -> check.Evaluation:
    """Compare strikes by the rows with those by rows twice as long.

    An error in proportion to their length is as large as that change.
    """
    joined = outcome.fe.resampled(rows=2)
    changed = []
    for strike in error.assessed_strikes(outcome.fe):
        same = nearest(joined, strike)
        changed += [
            getattr(same, name) / getattr(strike, name) - 1.0 if same else math.inf
            for name in ("peak_force", "duration")
        ]
    meaning = "largest change of peak force or duration of an assessed strike by rows that are twice as long"
    return check.Evaluation(max(map(abs, changed), default=math.nan), 0.02, meaning)


@CHECKS.add("articulation", "a time.end before that, for the model holds until then")
def _articulation(outcome: run.ImpactOutcome) -> check.Evaluation | None:
    if not outcome.run.units:
        return None
    largest = max(hinge["largest_angle"] for hinge in outcome.fe.hinges)
    return check.Evaluation(
        largest, 0.5 * math.pi, "largest angle of a hinge [rad]; beyond it units touch: jack-knifing"
    )


@CHECKS.add(IN_SPACE[0], FAULT)
def _energy_in_space(outcome: run.ImpactOutcome) -> check.Evaluation | None:
    space = outcome.fe_plan.case.space
    if space is None:
        return None
    meaning = "largest error of the energy balance of the vehicle in space over its initial energy"
    return check.Evaluation(space.energy_error, 1e-3, meaning)


@CHECKS.add(IN_SPACE[1], "softer springs and tyres, or heavier axles; a larger verify.mesh", in_percent=True)
def _error_in_space(outcome: run.ImpactOutcome) -> check.Evaluation | None:
    space = outcome.fe_plan.case.space
    if space is None:
        return None
    meaning = "error of roll, force and height of the vehicle in space by step and points; limit: verify.mesh"
    return check.Evaluation(space.motion.error, outcome.fe_plan.case.scene.verify.mesh, meaning)


def _stated(quantity: str, outcome: run.ImpactOutcome) -> check.Evaluation | None:
    verify, errors = outcome.fe_plan.case.scene.verify, outcome.stated_errors
    if not verify.companion or quantity not in errors:
        return None
    hinged = bool(outcome.run.units)
    measured = (
        f"{error.QUANTITIES[quantity]} of the first two major strikes and those near the largest"
        if quantity in error.QUANTITIES
        else "largest 50 ms mean of a hinge"
    )
    meaning = f"larger discretisation error of the {measured}; limit: verify.mesh"
    advice = (HINGED if hinged else CLOSER).replace(check.FINER, outcome.fe_plan.finer)
    return check.Evaluation(errors[quantity], verify.mesh, meaning, advice)


for _quantity, _name in MESH_CHECKS.items():
    CHECKS.add(_name, CLOSER, in_percent=True)(partial(_stated, _quantity))


def impact_checks(outcome: run.ImpactOutcome) -> tuple[check.Check, ...]:
    """Evaluate all checks of a run."""
    return check.evaluated(CHECKS.values(), outcome)


def groups(outcome: run.ImpactOutcome) -> dict[str, str]:
    """Return the titles of the tables of checks by their names."""
    names, plane = [check.name for check in outcome.checks], answers.COMPANION.capitalize()
    if outcome.fe_plan.case.space is None:
        return dict.fromkeys(names, "")
    return {name: "In space" if name in IN_SPACE else plane for name in names}


def failed_but_mesh(outcome: run.ImpactOutcome) -> tuple[str, ...]:
    """Return the names of failed checks except those of the mesh."""
    failed = check.failed_names(outcome.checks or impact_checks(outcome))
    return tuple(name for name in failed if name not in MESH_CHECKS.values())
