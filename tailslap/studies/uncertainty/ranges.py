"""Which inputs vary, and between which values: defaults, and what the user says instead."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from tailslap.errors import InputError, Verbatim
from tailslap.scene.files import read_scene
from tailslap.scene.inputs import SceneInput, scene_inputs
from tailslap.scene.schema import Scene
from tailslap.studies.uncertainty.tolerances import default_limits

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


class _Texts(NamedTuple):
    """The ends of a range as they would stand in a scene, and where it comes from."""

    lower: str
    upper: str
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


def study_ranges(
    name: str, changes: tuple[str, ...], ranges: tuple[str, ...], fixed: tuple[str, ...]
) -> tuple[Range, ...]:
    """The ranges for the scene `name` with its changes, in the order of `KEYS`.

    ranges: of the form KEY=LOWER:UPPER; fixed: keys that do not vary. Raises InputError.
    """
    scene = read_scene(name, changes)[0]
    used = used_keys(scene)
    texts = {
        key: _Texts(repr(lower), repr(upper), origin)
        for key, (lower, upper, origin) in default_limits(scene).items()
        if key in used
    }
    for text in ranges:
        key, limits = _split(text, used)
        texts[key] = limits
    for key in fixed:
        if texts.pop(key, None) is None:
            raise InputError("--fix", key, f"it does not vary; allowed are {', '.join(texts) or 'none'}")
    if not texts:
        raise InputError("--fix", ", ".join(fixed), "then nothing varies; allowed is to leave one free")
    return tuple(_range(name, changes, key, texts[key]) for key in KEYS if key in texts)


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


def _split(text: str, used: tuple[str, ...]) -> tuple[str, _Texts]:
    """Key and ends of KEY=LOWER:UPPER."""
    key, equals, values = (part.strip() for part in text.partition("="))
    lower, colon, upper = (part.strip() for part in values.partition(":"))
    if not all((key, equals, lower, colon, upper)):
        raise InputError("--range", text, "allowed is KEY=LOWER:UPPER, like impact.friction=0.2:0.5")
    if key not in used:
        why = f"the peak force of this scene does not depend on it; allowed are {', '.join(used)}"
        raise InputError(key, values, why)
    return key, _Texts(lower, upper, FROM_USER)


def _range(name: str, changes: tuple[str, ...], key: str, texts: _Texts) -> Range:
    """The range, its ends read as the scene would read them, with its units and bounds."""
    try:
        lower, upper = (_row(name, (*changes, f"{key}={text}"), key) for text in (texts.lower, texts.upper))
    except InputError as error:
        if texts.origin == FROM_USER:
            raise
        where = Verbatim(f"{texts.lower} to {texts.upper} by default ({texts.origin})")
        raise InputError(key, where, f"{error.allowed}; --range gives another range") from None
    if lower is None or upper is None or not _number(upper) > _number(lower):
        raise InputError(
            key, f"{texts.lower}:{texts.upper}", "the second value must be larger than the first"
        )
    given = _row(name, changes, key)
    own = None if given is None else _number(given)
    return Range(key, _number(lower), _number(upper), lower.unit, own, texts.origin)


def _row(name: str, changes: tuple[str, ...], key: str) -> SceneInput | None:
    """The key of the scene with these changes, as a row of its table of inputs."""
    return next((row for row in scene_inputs(*read_scene(name, changes)) if row.key == key), None)


def _number(row: SceneInput) -> float:
    return float(row.value or 0.0)
