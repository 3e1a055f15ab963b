"""Many impacts of a scene's rigid vehicle, with columns in place of some of its numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from solver.impact import Impacts, solve_impacts
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.rigid import AFTER_SECOND, LONGEST, refusals
from tailslap.errors import InputError, Missing
from tailslap.studies.strike.quantities import COLUMNS, STRIKES, Array, column, filtered, peaks_within

ARGUMENTS = {
    "vehicle.length": "length",
    "vehicle.width": "width",
    "vehicle.mass": "mass",
    "vehicle.centre_of_mass": "centre_of_mass",
    "impact.speed": "speed",
    "impact.angle": "angle",
    "contact.stiffness": "stiffness",
    "contact.initial_force": "initial_force",
    "contact.restitution": "restitution",
    "contact.friction": "friction",
}
"""Keys of the scene that the rigid vehicle's impact depends on, and what the solution calls them."""

BLOCK = 512
"""Impacts at a time: their force histories stay small."""

INTERVAL = 5e-4
"""Time between rows of the force histories [s]: peaks of a 50 ms mean are within 1e-4."""


def demand_corners(plan: ImpactCase) -> None:
    """Raise InputError unless the corners alone touch, and crush."""
    contact = plan.scene.contact
    if contact is None or contact.stiffness is None:
        raise InputError(
            "contact.stiffness", Missing, "`tailslap study strike` varies the crush law: give it one"
        )
    if contact.side_stiffness:
        allowed = "the impacts of `tailslap study strike` are of the corners alone; leave it out"
        raise InputError("contact.side_stiffness", contact.side_stiffness, allowed)


def scene_values(plan: ImpactCase) -> dict[str, float]:
    """The scene's own number of each key of `ARGUMENTS`."""
    scene, vehicle = plan.scene, plan.vehicle
    own = {key: getattr(getattr(scene, key.split(".")[0]), key.split(".")[1]) for key in ARGUMENTS}
    own["contact.restitution"] = own["contact.restitution"] or 0.0
    return own | {"vehicle.centre_of_mass": vehicle.front_distance}


def measured(
    plan: ImpactCase, inputs: Mapping[str, Array], progress: Callable[[float], None] = lambda share: None
) -> dict[str, Array]:
    """The columns of `COLUMNS` [SI], shape (n,), of n impacts; NaN where there is no such strike.

    Parameters
    ----------
    plan : ImpactCase
        Gives what is not among the inputs; its yaw inertia, where the scene gives one, in proportion to the mass.
    inputs : dict of ndarray, shape (n,)
        By key of `ARGUMENTS` [SI].
    progress : callable
        Told the share that is done.

    Returns
    -------
    dict of ndarray, shape (n,)
        By column.

    Raises
    ------
    InputError
        Where the theory refuses one of them.
    """
    size = next(iter(inputs.values())).size
    order = np.argsort(
        inputs.get("contact.restitution", np.zeros(size)), kind="stable"
    )  # a block has like steps
    out = {name: np.empty(size) for name in COLUMNS}
    for first in range(0, size, BLOCK):
        progress(first / size)
        rows = order[first : first + BLOCK]
        for name, values in _block(plan, {key: given[rows] for key, given in inputs.items()}).items():
            out[name][rows] = values
    return out


def _block(plan: ImpactCase, inputs: Mapping[str, Array]) -> dict[str, Array]:
    with refusals(plan.scene):
        return _columns(solve_impacts(**_arguments(plan, inputs), interval=INTERVAL))


def _arguments(plan: ImpactCase, inputs: Mapping[str, Array]) -> dict[str, Any]:
    values: dict[str, Array | float] = {**scene_values(plan), **inputs}
    if plan.scene.vehicle.centre_of_mass is None and "vehicle.centre_of_mass" not in inputs:
        values["vehicle.centre_of_mass"] = 0.5 * np.asarray(values["vehicle.length"])
    given: dict[str, Any] = {name: values[key] for key, name in ARGUMENTS.items()}
    inertia = plan.scene.vehicle.yaw_inertia
    if inertia is not None:
        given["yaw_inertia"] = inertia / plan.vehicle.mass * np.asarray(values["vehicle.mass"])
    return given | {"after_second": AFTER_SECOND, "longest": LONGEST}


def _columns(found: Impacts) -> dict[str, Array]:
    starts, ends = found.start, found.start + found.duration
    columns: dict[str, Array] = {}
    curves = [_filtered(force, end) for force, end in zip(found.mean_force.T, ends.T, strict=True)]
    for k, strike in enumerate(STRIKES):
        times = zip(curves, starts[k].tolist(), ends[k].tolist(), strict=True)
        peaks = [peaks_within(own, INTERVAL, start, end) for own, start, end in times]
        columns |= {column(strike, name): np.array([each[name] for each in peaks]) for name in curves[0]}
        known = np.isfinite(starts[k])
        columns[column(strike, "raw")] = np.where(known, found.peak_force[k], np.nan)
        columns[column(strike, "impulse")] = np.where(known, found.impulse[k], np.nan)
        columns[column(strike, "duration")] = found.duration[k]
    return columns


def _filtered(force: Array, ends: Array) -> dict[str, Array]:
    """The history of one impact, to 0.1 s after its last strike, by the filters."""
    rows = int(np.ceil((np.nanmax(ends) + AFTER_SECOND) / INTERVAL))
    return filtered(force[:rows], INTERVAL)
