"""What could be changed in a scene whose run failed a check."""

from __future__ import annotations

from collections.abc import Iterable

FINER = "refine plate.elements, or leave plate.elements and plate.element out"
STIFFER = 'a larger corner.penalty_scale, or corner.constraint = "exact"'
CALMER = "leave damping.kind out, or give damping.rate"
STEP = "a smaller time.safety_factor"
SOFT = "a stiffer plate: it is softer than the theory of this start allows"
ROUGH = f"{CALMER}; leave the corner's spring out"

ADVICE = {
    "tail-slap reached": f"{CALMER}; {SOFT}",
    "finite numbers": f"{STEP}; {CALMER}",
    "time step": STEP,
    "energy balance": STEP,
    "momentum balance": STEP,
    "energy ratio": STEP,
    "penetration": STIFFER,
    "contact spring": STIFFER,
    "contact work": STEP,
    "contact energy": STIFFER,
    "friction by ringing": ROUGH,
    "oscillation": ROUGH,
    "reaction against rigid": ROUGH,
    "mesh": FINER,
    "numerical error": FINER,
    "hourglass share": 'plate.element = "quad4", or more elements',
    "hourglass over total energy": 'plate.element = "quad4", or more elements',
    "added mass": 'plate.lumping = "exact"',
    "friction work": "more time.rows",
    "friction takes energy": CALMER,
    "friction work against rigid": ROUGH,
    "agreement with rigid": "a stiffer plate, or a larger verify.tolerance",
    "mean residual": ROUGH,
    "deviation of residuals": ROUGH,
    "Sprague-Geers magnitude": ROUGH,
    "Sprague-Geers phase": ROUGH,
    "Sprague-Geers combined": ROUGH,
}
"""Advice by the name of the check."""


def advice(failed: Iterable[str]) -> str:
    """What could be changed, each thing once, in the order of the checks."""
    told = [ADVICE[name] for name in failed if name in ADVICE]
    parts = dict.fromkeys(part for words in told for part in words.split("; "))
    return "; ".join(parts)
