"""Validate the keys of [parapet], and return its strengths."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from postprocess.signals.design_forces import design_forces
from tailslap.errors import InputError, Missing
from tailslap.scene import schema
from tailslap.scene.model_tables import Parapet

if TYPE_CHECKING:
    from solver.parapet import Strengths

STRENGTHS = ("wall_strength", "base_strength")
"""Keys that [parapet.section] replaces."""


def check_parapet(scene: schema.Scene, parapet: Parapet) -> None:
    """Raise InputError for combinations of keys without a meaning."""
    if parapet.section is None:
        for name in STRENGTHS:
            if getattr(parapet, name) is None:
                why = "this key is required; [parapet.section] may replace the strengths"
                raise InputError(f"parapet.{name}", Missing, why)
    else:
        for name in STRENGTHS:
            if getattr(parapet, name) is not None:
                why = "[parapet.section] defines the strengths; remove one of the two"
                raise InputError(f"parapet.{name}", getattr(parapet, name), why)
    height, load_length = parapet.height, load_length_of(scene, parapet)
    for name in ("base_strength", "section.thickness"):
        levels = schema.value_at(parapet, name)
        if levels is not None and levels[-1][0] > height:
            allowed = f"allowed are heights up to that of the parapet, {height:g} m"
            raise InputError(f"parapet.{name}", f"{levels[-1][0]:g} m", allowed)
    if parapet.load_height is not None and parapet.load_height > height:
        raise InputError(
            "parapet.load_height",
            f"{parapet.load_height:g} m",
            f"allowed is up to the height, {height:g} m",
        )
    longest = math.inf if parapet.length is None else parapet.length
    if load_length > longest:
        allowed = f"allowed is up to the length of the wall, {longest:g} m"
        raise InputError("parapet.load_length", f"{load_length:g} m", allowed)
    if parapet.end_distance is not None and parapet.end_distance > 0.5 * (longest - load_length):
        allowed = f"allowed is up to half of the wall without the load, {0.5 * (longest - load_length):g} m"
        raise InputError("parapet.end_distance", f"{parapet.end_distance:g} m", allowed)
    strengths_of(parapet)


def load_length_of(scene: schema.Scene, parapet: Parapet) -> float:
    """Return the length of the load [m].

    By default it is that of AASHTO or EN 1991-2 for the test level. Raises InputError without both.
    """
    if parapet.load_length is not None:
        return parapet.load_length
    level = scene.impact and scene.impact.test_level
    if not level:
        raise InputError("parapet.load_length", Missing, "it is required without impact.test_level")
    length = design_forces(level)[-1].length
    assert length
    return length


def strengths_of(parapet: Parapet) -> Strengths:
    """Return the strengths of a parapet.

    Raises InputError for a section without any."""
    import numpy as np

    from solver.conditions import RigidBodyError
    from solver.parapet import Strengths, section_strengths

    section, height = parapet.section, parapet.height
    levels_and_values = section.thickness if section else parapet.base_strength
    assert levels_and_values
    at, values = np.array(levels_and_values).T
    levels = np.unique([*at, 0.0, height])
    values = np.interp(levels, at, values)
    if section is None:
        assert parapet.wall_strength
        along = np.full(levels.size, parapet.wall_strength / height)
        return Strengths(levels, np.array([along, along, values, values]), parapet.beam_strength)
    try:
        strengths = section_strengths(
            list(zip(levels, values, strict=True)),
            section.concrete_strength,
            section.yield_strength,
            section.cover,
            section.vertical_bars,
            section.horizontal_bars,
        )
    except RigidBodyError as error:
        allowed = f"{error.why}; allowed are {error.allowed}"
        raise InputError(f"parapet.section.{error.key}", error.value, allowed) from None
    return strengths._replace(beam=parapet.beam_strength)
