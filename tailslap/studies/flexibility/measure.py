"""One point of the sweep: three meshes, the modal model beside them, and at some points the thickness instead of E."""

from __future__ import annotations

import copy
import math
import time
from typing import Any

import numpy as np

from postprocess.comparison import relative_difference
from tailslap.errors import InputError
from tailslap.fe_plan import make_fe_plan
from tailslap.plan import make_plan
from tailslap.run import Outcome, run_scene
from tailslap.scene_files import validate
from tailslap.studies.flexibility.sweep import Section
from tailslap.studies.stability.axes import Tables

Record = dict[str, Any]


def measure(
    meshes: list[Tables | None], modal: Tables, own: Section | None, half_patch: Tables | None
) -> Record:
    """The record of a point; meshes: tables of the three runs, coarse to fine, None for one that is left out.

    modal: of the modal model; own: the scene's section where the middle mesh is run once more by its thickness;
    half_patch: the finest mesh held over half the length, where that is to be run.
    """
    record: Record = {"meshes": [one_run(tables) for tables in meshes], "modal": modal_opinion(modal)}
    if half_patch is not None:
        record["half_patch"] = one_run(half_patch)
    middle = record["meshes"][1]
    if own is not None and meshes[1] is not None and "refused" not in middle:
        record["thickness"] = one_run(thickness_tables(meshes[1], middle["youngs_modulus"], own))
    return record


def thickness_tables(tables: Tables, modulus: float, own: Section) -> Tables:
    """The plate of these tables, whose modulus is this [Pa], with the scene's own modulus and the thickness for it.

    E t stays, and so does density times thickness, which is the mass.
    """
    tables, ratio = copy.deepcopy(tables), modulus / own.youngs_modulus
    tables["plate"].pop("first_frequency")
    changed = Section(own.thickness * ratio, own.density / ratio, own.youngs_modulus)
    tables["plate"] |= changed._asdict()
    return tables


def one_run(tables: Tables | None) -> Record:
    """Values, failed checks, reaction and stored energy of a finite-element run; `refused` says why there is none."""
    if tables is None:
        return {"refused": "left out: its time loop would take too long"}
    began = time.perf_counter()
    try:
        outcome = run_scene(make_plan(validate(tables)))
    except InputError as error:
        return {"refused": str(error)}
    except Exception as error:  # one point must not end the study; it is shown as failed
        return {"refused": f"broke: {type(error).__name__}: {error}"}
    return _record(outcome) | {"seconds": time.perf_counter() - began}


def _record(outcome: Outcome) -> Record:
    plan = outcome.fe_plan.plan
    damping = plan.scene.damping
    return {
        "elements": list(outcome.fe_plan.plate.elements),
        "youngs_modulus": outcome.fe_plan.plate.youngs_modulus,
        "thickness": outcome.fe_plan.plate.thickness,
        "damping": (damping.ratio or 0.0) if damping else 0.0,
        "values": outcome.fe,
        "failed": [check.name for check in outcome.checks if not check.passed],
        "reaction": reaction_deviation(outcome),
        "stored": stored_share(outcome),
        "give": outcome.fe_plan.give,
        "steps": outcome.run.steps,
    }


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


def modal_opinion(tables: Tables) -> Record:
    """The same plate by its lowest modes: values, the model's own estimate of its error, failed checks."""
    from tailslap.modal import modal_run

    try:
        found = modal_run(make_fe_plan(make_plan(validate(tables))), tolerance=1.0)
    except InputError as error:
        return {"refused": str(error)}
    except Exception as error:  # as above
        return {"refused": f"broke: {type(error).__name__}: {error}"}
    failed = [check.name for check in found.checks if not check.passed]
    return {"values": found.values, "estimate": found.estimate.total, "failed": failed}


def farthest(values: dict[str, float], others: dict[str, float]) -> float:
    """Largest relative difference of the five quantities; NaN where one is missing."""
    if not (values and others):
        return math.nan
    sizes = [abs(value) for value in relative_difference(values, others).values()]
    return max(sizes) if all(map(math.isfinite, sizes)) else math.nan
