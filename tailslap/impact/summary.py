"""`summary.json` of a whole impact, by the names that other programs hold on to."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from tailslap.case.report import run_summary
from tailslap.impact.check_text import omitted_parts
from tailslap.impact.checks import energy_error
from tailslap.impact.outcome import ImpactOutcome

FIRST = ("t", "x_g", "y_g", "theta", "omega", "v_gx", "v_gy", "force_normal", "force_tangential")
"""Columns in front of all others."""


def impact_summary(outcome: ImpactOutcome, pictures: bool) -> dict[str, Any]:
    """The whole summary, SI."""
    plan, beside = outcome.fe_plan.case, outcome.paper_method
    return {
        **run_summary(outcome, omitted_parts(plan.scene, pictures)),
        "rigid": outcome.rigid.numbers(),
        "fe": outcome.fe.numbers(),
        "paper_method": beside and asdict(beside),
        "difference": outcome.difference,
        "numerical_error": {"mesh": outcome.mesh_error, "first_frequency": outcome.frequency_error},
        "occupant_risk": [
            asdict(measure) for measure in outcome.fe.occupant_risk(outcome.fe_plan.model.mass)
        ],
        "wall": wall_numbers(outcome),
        "vehicle": {"centre_of_mass": plan.vehicle.front_distance, "yaw_inertia": plan.vehicle.inertia},
    }


def wall_numbers(outcome: ImpactOutcome) -> dict[str, float] | None:
    """Largest deflection of a wall that gives, where and when, and the foundation's largest force beside the contact's;
    None for a rigid wall."""
    if outcome.fe_plan.case.scene.wall is None:
        return None
    from postprocess.signals.filters import moving_mean

    h = outcome.run.history
    k = int(np.argmax(h["wall_deflection"]))
    return {
        "deflection": float(h["wall_deflection"][k]),
        "place": float(h["wall_deflection_place"][k]),
        "t": float(h["t"][k]),
        "foundation_force": float(h["force_foundation"].max()),
        "foundation_mean_50ms": float(
            moving_mean(h["force_foundation"][1:], outcome.fe.interval, 0.05).max()
        ),
        "contact_mean_50ms": outcome.fe.peaks["mean_50ms"],
    }


def impact_histories(outcome: ImpactOutcome) -> dict[str, dict[str, np.ndarray]]:
    """Columns of `history.csv` and `rigid.csv`, SI, shape (rows,) each."""
    h = outcome.run.history
    ordered = {name: h[name] for name in FIRST} | h | {"energy_error": energy_error(outcome)}
    return {"history.csv": ordered, "rigid.csv": dict(outcome.rigid.history)}
