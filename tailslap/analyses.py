"""The two calculations: a scene with [contact] is a whole impact; any other is the paper's three stages, with a
constrained corner."""

from __future__ import annotations

from tailslap.analysis import Analysis
from tailslap.errors import InputError, Missing
from tailslap.scene.schema import Scene


def needs_plate(scene: Scene) -> None:
    """Raise InputError where the scene has no plate."""
    if scene.plate is None:
        raise InputError("plate", Missing, "a run needs this table; `tailslap rigid` does without it")


def analysis_of(scene: Scene) -> Analysis:
    """The calculation that the scene asks for; only its own modules are imported."""
    if scene.contact is None:
        from tailslap.sliding import SLIDING

        return SLIDING
    from tailslap.impact.analysis import IMPACT

    return IMPACT
