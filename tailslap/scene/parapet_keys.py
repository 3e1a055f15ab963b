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


def parapet_of(scene: schema.Scene) -> Parapet:
    """Return the table of the parapet.

    Raises InputError without it."""
    if scene.parapet is None:
        raise InputError("parapet", Missing, "this table is required")
    return scene.parapet


def check_parapet(scene: schema.Scene, parapet: Parapet) -> None:
    """Raise InputError for combinations of keys without a meaning."""
    for name in STRENGTHS:
        value = getattr(parapet, name)
        if value is None and parapet.section is None:
            why = "this key is required; [parapet.section] may replace the strengths"
            raise InputError(f"parapet.{name}", Missing, why)
        if value is not None and parapet.section is not None:
            raise InputError(
                f"parapet.{name}", value, "[parapet.section] defines the strengths; remove one of the two"
            )
    load_length = load_length_of(scene, parapet)
    longest = math.inf if parapet.length is None else parapet.length
    limits = [
        (name, levels[-1][0], parapet.height, "the height of the parapet")
        for name in ("base_strength", "section.thickness")
        if (levels := schema.value_at(parapet, name))
    ]
    limits += [
        ("load_height", parapet.load_height or 0.0, parapet.height, "the height of the parapet"),
        ("load_length", load_length, longest, "the length of the wall"),
        (
            "end_distance",
            parapet.end_distance or 0.0,
            0.5 * (longest - load_length),
            "half of the wall without the load",
        ),
    ]
    for name, value, most, meaning in limits:
        if value > most:
            raise InputError(f"parapet.{name}", f"{value:g} m", f"allowed is up to {meaning}, {most:g} m")
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
