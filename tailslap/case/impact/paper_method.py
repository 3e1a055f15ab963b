"""Method of the paper for the impact of a scene with [contact]."""

from typing import Any

from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact.answers import ImpactAnswer
from tailslap.errors import InputError
from tailslap.scene.schema import Scene
from tailslap.scene.units import shown
from tailslap.scene.vary import Source, vary

OF_A_WHOLE_IMPACT = (
    "contact", "sensor", "parapet", "axle", "body", "strip", "plate", "material", "damping", "wall", "time", "verify",
    "vehicle.centre_of_mass", "vehicle.yaw_inertia", "impact.test_level",
)  # fmt: skip
"""Tables and keys that the paper's method does not use."""

DIGITS = 4
"""Digits of numbers in the text; those in files and in --json are complete."""


def paper_method(scene: Scene, answer: ImpactAnswer) -> dict[str, Any] | None:
    """Return the results of the paper's method for the same impact.

    It is that of the uniform rectangle. scene: with [contact]; answer: of the rigid vehicle. Returns omega after Stage
    1 [rad/s]; t and impulse of the tail-slap [s], [N s], the whole mass stopped; duration that the paper reads off
    crash tests [s], peak_force and mean_50ms with it [N]; computed_duration, computed_peak_force: with the duration of
    the second strike as the paper would read it off the computed 50 ms mean, or None. Returns None where [impact] has
    no friction or restitution, where the method has no answer, and of trains.
    """
    table = scene.impact
    if table is None or table.friction is None or table.restitution is None or scene.trailer:
        return None
    try:
        case = CornerCase(*vary(Source.of(scene), dict.fromkeys(OF_A_WHOLE_IMPACT)))
    except InputError:
        return None
    read, force = answer.second_strike.get("mean_50ms", {}).get("duration"), case.force
    return {
        "omega": float(case.start.omega),
        "t": float(case.motion.strike.t),
        **{name: float(getattr(force, name)) for name in ("impulse", "duration", "peak_force")},
        "mean_50ms": case.mean_force(float(force.peak_force)),
        "computed_duration": read,
        "computed_peak_force": 2.0 * float(force.impulse) / read if read else None,
    }


def paper_lines(beside: dict[str, Any] | None, units: str) -> list[str]:
    """Return lines on the paper's method."""
    if beside is None:
        return []
    impulse = shown(beside["impulse"], "N s", units, digits=DIGITS)
    force = shown(beside["peak_force"], "N", units, digits=DIGITS)
    lines = [
        "",
        "The paper's method (uniform rectangle, whole side stopped at once)",
        f"  tail-slap at {beside['t']:.4g} s, impulse {impulse}, peak force {force}, 50 ms mean "
        f"{shown(beside['mean_50ms'], 'N', units, digits=DIGITS)} with {beside['duration']:g} s, assumed",
    ]
    if read := beside["computed_duration"]:
        force = shown(beside["computed_peak_force"], "N", units, digits=DIGITS)
        lines.append(f"  {force} with {read:.3f} s, the duration in the 50 ms mean")
    return lines
