"""One point of the sweep: three starts, the modal model beside them, and at some points the thickness instead of E."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from tailslap.case.corner.case import CornerCase
from tailslap.errors import InputError
from tailslap.planning.fe_plan import make_fe_plan
from tailslap.scene.vary import Changes, Source, vary
from tailslap.scene_run import Outcome, run_scene
from tailslap.studies.flexibility.sweep import STARTS, Section
from tailslap.verification.check import failed_names

Record = dict[str, Any]

KEPT = ("v_gx", "v_gy", "omega", "v_p")
"""Velocities that a start may keep: of the centre of mass, of rotation, of the corner along the wall."""

JUDGED = "numerical error"
"""The check that the study makes itself, by its own levels."""


def measure(
    base: Source, starts: dict[str, list[Changes | None]], modal: Changes, own: Section | None, half: bool
) -> Record:
    """The record of a point; starts: by name what its runs change, coarse to fine, None for one that is left out.

    modal: of the modal model; own: the scene's section where the first start's middle mesh is run once more by its
    thickness; half: whether the finest mesh is run once more, held over half the length.
    """
    runs = {name: [one_run(base, changes) for changes in meshes] for name, meshes in starts.items()}
    record: Record = {"starts": runs, "modal": modal_opinion(base, modal)}
    _, changes, finest = starts[STARTS[0]]
    if half and finest is not None:
        patch = 0.5 * finest["corner.patch_length"]
        record["half_patch"] = one_run(base, {**finest, "corner.patch_length": patch})
    middle = runs[STARTS[0]][1]
    if own is not None and changes is not None and "refused" not in middle:
        record["thickness"] = one_run(base, thickness_changes(changes, middle["youngs_modulus"], own))
    return record


def thickness_changes(changes: Changes, modulus: float, own: Section) -> Changes:
    """The plate of these changes, whose modulus is this [Pa], with the scene's own modulus and the thickness for it.

    E t stays, and so does density times thickness, which is the mass.
    """
    ratio = modulus / own.youngs_modulus
    changed = Section(own.thickness * ratio, own.density / ratio, own.youngs_modulus)
    plate = {f"plate.{key}": value for key, value in changed._asdict().items()}
    return {**changes, "plate.first_frequency": None, **plate}


def one_run(base: Source, changes: Changes | None) -> Record:
    """Values, failed checks, reaction and stored energy of a finite-element run; `refused` says why there is none."""
    if changes is None:
        return {"refused": "left out: its time loop would take too long"}
    began = time.perf_counter()
    try:
        outcome = run_scene(CornerCase(*vary(base, changes)))
    except InputError as error:
        return {"refused": str(error)}
    except Exception as error:  # one point must not end the study; it is shown as failed
        return {"refused": f"broke: {type(error).__name__}: {error}"}
    return _record(outcome) | {"seconds": time.perf_counter() - began}


def _record(outcome: Outcome) -> Record:
    """What the study takes from a run. Its numerical error is kept and no failure: each level is held to it."""
    fe_plan, error = outcome.fe_plan, outcome.error
    return {
        "elements": list(fe_plan.plate.elements or ()),
        "youngs_modulus": fe_plan.plate.youngs_modulus,
        "thickness": fe_plan.plate.thickness,
        "damping": getattr(fe_plan.model.loop.elastic_damping, "rate", 0.0),
        "values": outcome.fe,
        "failed": [check.name for check in outcome.checks if not (check.passed or check.name == JUDGED)],
        "departure": departures(outcome),
        "largest": largest_difference(outcome),
        "reaction": reaction_deviation(outcome),
        "stored": stored_share(outcome),
        "deflection_ratio": fe_plan.deflection_ratio,
        "error": error.total,
        "unseen": error.damping + error.ringing,
        "steps": outcome.run.steps,
    }


def departures(outcome: Outcome) -> dict[str, float]:
    """Relative difference from the rigid body at t = 0 of what a start may keep."""
    fe, rigid = outcome.fe_history, outcome.rigid_history
    return {name: float(fe[name][0] / rigid[name][0] - 1.0) for name in KEPT}


def largest_difference(outcome: Outcome) -> float:
    """Largest difference of v_GY from the rigid body, at the strike and at any instant before it, over v_GY at the
    strike: an oscillating plate may strike in any phase. NaN without a strike."""
    if not outcome.fe:
        return math.nan
    ours, rigid = outcome.fe_history["v_gy"], outcome.rigid_history["v_gy"]
    before = np.nanmax(np.abs(ours - rigid)) / abs(outcome.rigid["v_gy"])
    return max(float(before), abs(outcome.difference["v_gy"]))


def reaction_deviation(outcome: Outcome) -> float:
    """Largest difference of the wall's normal reaction from the rigid one, over the largest rigid one."""
    ours, rigid = (h["reaction_normal"] for h in (outcome.fe_history, outcome.rigid_history))
    known = np.isfinite(rigid)
    with np.errstate(all="ignore"):
        return float(np.abs(ours[known] - rigid[known]).max() / np.abs(rigid[known]).max())


def stored_share(outcome: Outcome) -> float:
    """Largest elastic energy of the plate over its kinetic energy at the start; a rigid body stores none."""
    history = outcome.fe_history
    return float(history["strain_energy"].max() / history["kinetic_energy"][0])


def modal_opinion(base: Source, changes: Changes) -> Record:
    """The same plate by its lowest modes: values, the model's own estimate of its error, failed checks."""
    from tailslap.modal_analysis.run import modal_run

    try:
        found = modal_run(make_fe_plan(CornerCase(*vary(base, changes))), tolerance=1.0)
    except InputError as error:
        return {"refused": str(error)}
    except Exception as error:  # as above
        return {"refused": f"broke: {type(error).__name__}: {error}"}
    failed = list(failed_names(found.checks))
    return {"values": found.values, "estimate": found.estimate.total, "failed": failed}
