"""Which inputs vary, and between which values: defaults, and what the user says instead."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from tailslap.case.corner.case import CornerCase
from tailslap.errors import InputError, Verbatim
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Source, parse_value, vary
from tailslap.scene.write import SceneInput, scene_inputs
from tailslap.studies.uncertainty.tolerances import Limits, default_limits

STAGE_ONE = ("impact.speed", "impact.angle", "impact.friction", "impact.restitution")
START = ("start.angle", "start.omega", "start.corner_speed")
KEYS = (
    "vehicle.length",
    "vehicle.width",
    "vehicle.mass",
    *STAGE_ONE,
    *START,
    "corner.friction",
    "strike.duration",
)
"""The numbers that the rigid-body method computes the peak force from."""


FROM_USER = "--range"


class _Ends(NamedTuple):
    """The ends of a range, as a scene may say them; the range as typed, and where it comes from."""

    lower: Any
    upper: Any
    text: str
    origin: str


@dataclass(frozen=True)
class Range:
    """An input that varies evenly between two values [unit]; given: the scene's own value, where it has one."""

    key: str
    lower: float
    upper: float
    unit: str
    given: float | None
    origin: str


def study_ranges(plan: CornerCase, ranges: tuple[str, ...], fixed: tuple[str, ...]) -> tuple[Range, ...]:
    """The ranges for the plan's scene, in the order of `KEYS`.

    ranges: of the form KEY=LOWER:UPPER; fixed: keys that do not vary. Raises InputError.
    """
    return ranges_of(plan, used_keys(plan.scene), default_limits(plan.scene), ranges, fixed)


def ranges_of(
    plan: Any,
    used: tuple[str, ...],
    limits: Mapping[str, Limits],
    ranges: tuple[str, ...],
    fixed: tuple[str, ...],
) -> tuple[Range, ...]:
    """The ranges for a plan with scene and source, in the order of the keys that may vary; others as `study_ranges`.

    used: the keys that may vary; limits: the ranges of those that vary by default.
    """
    given = {
        key: _Ends(lower, upper, f"{lower!r}:{upper!r}", origin)
        for key, (lower, upper, origin) in limits.items()
        if key in used
    }
    for text in ranges:
        key, ends = _split(text, used)
        if key in given and given[key].origin == FROM_USER:
            raise InputError("--range", text, "its key is given twice; allowed is one --range for each key")
        given[key] = ends
    for key in fixed:
        if key in given and given[key].origin == FROM_USER:
            raise InputError("--fix", key, "--range varies it; leave out one of the two")
        if given.pop(key, None) is None:
            raise InputError("--fix", key, f"it does not vary; allowed are {', '.join(given) or 'none'}")
    if not given:
        raise InputError("--fix", ", ".join(fixed), "then nothing varies; allowed is to leave one free")
    return tuple(_range(plan, key, given[key]) for key in used if key in given)


def used_keys(scene: Scene) -> tuple[str, ...]:
    """The keys of `KEYS` that the peak force of this scene depends on."""
    start = {key for key in START if scene.start and getattr(scene.start, key[6:]) is not None}
    overridden = {"start.omega", "start.corner_speed"} <= start
    unused = set(STAGE_ONE) if overridden or not scene.impact else set()
    if scene.impact and "start.angle" not in start:
        unused.discard("impact.angle")
    if scene.impact and scene.corner.friction is None and not scene.corner.frictionless:
        unused.discard("impact.friction")
    if scene.corner.frictionless:
        unused.add("corner.friction")
    return tuple(key for key in KEYS if key not in unused)


def _split(text: str, used: tuple[str, ...]) -> tuple[str, _Ends]:
    """Key and ends of KEY=LOWER:UPPER."""
    key, equals, values = (part.strip() for part in text.partition("="))
    lower, colon, upper = (part.strip() for part in values.partition(":"))
    if not all((key, equals, lower, colon, upper)):
        raise InputError("--range", text, "allowed is KEY=LOWER:UPPER, like impact.friction=0.2:0.5")
    if key not in used:
        why = f"the peak force of this scene does not depend on it; allowed are {', '.join(used)}"
        raise InputError(key, values, why)
    return key, _Ends(parse_value(lower), parse_value(upper), f"{lower}:{upper}", FROM_USER)


def _range(plan: Any, key: str, ends: _Ends) -> Range:
    """The range, its ends read as the scene would read them, with its units and bounds."""
    try:
        lower, upper = (_row(*vary(plan.source, {key: end}), key) for end in ends[:2])
    except InputError as error:
        if ends.origin == FROM_USER:
            raise
        where = Verbatim(f"{ends.lower} to {ends.upper} by default ({ends.origin})")
        raise InputError(key, where, f"{error.allowed}; --range gives another range") from None
    if lower is None or upper is None or not _number(upper) > _number(lower):
        raise InputError(key, ends.text, "the second value must be larger than the first")
    given = _row(plan.scene, plan.source, key)
    own = None if given is None else _number(given)
    return Range(key, _number(lower), _number(upper), lower.unit, own, ends.origin)


def _row(scene: Scene, source: Source, key: str) -> SceneInput | None:
    """The key as a row of the scene's table of inputs."""
    return next((row for row in scene_inputs(scene, source) if row.key == key), None)


def _number(row: SceneInput) -> float:
    return float(row.value or 0.0)
