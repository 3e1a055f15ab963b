"""Ranges of uncertain inputs, by default or from the user.

Default ranges: MASH 2016 for speed and angle of any test and the inertial mass of its two light vehicles, as printed
beside the measured values of crash tests 612541-01-1 to -4 in National Academies (2024), doi 10.17226/27896, chapters
12, 13, 18 and 19. No published tolerances of the masses of its trucks were found. The ranges of friction, restitution
and duration of the strike are assumed and include the values of the paper's tables.
"""

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from postprocess.units import MPH, POUND, measure
from tailslap.case.case import Case
from tailslap.errors import InputError, Verbatim
from tailslap.scene import schema
from tailslap.scene.read import unit_remarks
from tailslap.scene.vary import parse_value, vary
from tailslap.scene.write import unit_at

Limits = tuple[float, float, str]
"""Ends of a range [SI], and its origin."""
TypedLimits = tuple[str, str, str]
"""Ends of a range as typed, and its origin."""
ASSUMED, FROM_USER, FROM_LENGTH = "assumed", "--range", "± 5 % of the length, assumed"
CRUSH: dict[str, Callable[[float], Limits]] = {
    "stiffness": lambda value: about(value, 0.5 * value, "± 50 %, assumed"),
    "plateau_force": lambda value: about(
        value, 3.0 / 7.0 * value, "± 43 %, assumed: 200 to 500 kN of 350 kN"
    ),
    "restitution": lambda value: (0.1, 0.35, "assumed; 0.22: the paper"),
    "unloading_stiffness": lambda value: about(value, 0.5 * value, "± 50 %, assumed"),
    "hardening": lambda value: about(value, 0.8 * value, "± 80 %, assumed: 0.1 to 0.9 MN/m of 2 MN/m"),
}
"""Default range of each crush parameter of a corner from its value in the scene."""
CONTACT_FRICTION = 0.1, 0.35, "ratios of impulses 0.13 to 0.31: National Academies 27896; 0.2: TL5CMB-2"
"""Default range of the friction of a whole impact."""
HARDENING = 0.25
"""Assumed hardening over stiffness of a plateau where the scene omits it: 0.5 MN/m of 2 MN/m."""
MASS = 0.05
"""Half the range of the mass of other vehicles, over the mass."""
LIGHT_VEHICLES = {"1100C": (2420.0, 55.0), "2270P": (5000.0, 110.0)}
"""Inertial mass and its tolerance [lb] by vehicle of MASH."""


def default_limits(scene: schema.Scene) -> dict[str, Limits]:
    """Return the default range of each key."""
    limits: dict[str, Limits] = {"strike.duration": (0.08, 0.18, ASSUMED)}
    for name, (pounds, tolerance) in LIGHT_VEHICLES.items():
        if abs(scene.vehicle.mass - pounds * POUND) <= tolerance * POUND:
            origin = f"± {tolerance:g} lb, MASH {name}"
            limits["vehicle.mass"] = about(scene.vehicle.mass, tolerance * POUND, origin)
    if scene.impact:
        limits |= {
            "impact.friction": (0.3, 0.6, ASSUMED),
            "impact.restitution": (0.0, 0.4, ASSUMED),
            "impact.speed": about(scene.impact.speed, 2.5 * MPH, "± 2.5 mph, MASH"),
            "impact.angle": about(scene.impact.angle, math.radians(1.5), "± 1.5 deg, MASH"),
        }
    return limits


def impact_limits(scene: schema.Scene, mass: float) -> dict[str, Limits]:
    """Return default ranges of any whole impact.

    mass: nominal mass of the vehicle [kg].
    """
    limits = {"vehicle.mass": about(mass, MASS * mass, "± 5 %, assumed")} | default_limits(scene)
    keys = ("vehicle.mass", "impact.speed", "impact.angle")
    return {key: limits[key] for key in keys} | {"contact.friction": CONTACT_FRICTION}


def nominal_value(scene: schema.Scene, key: str) -> float | None:
    """Return the value of a key about which it varies [SI].

    An omitted hardening beside a plateau is `HARDENING` of the stiffness; that of the scene may be 0.
    """
    table, _, name = key.rpartition(".")
    law, value = schema.value_at(scene, table), schema.value_at(scene, key)
    if name != "hardening" or law is None or name in law.model_fields_set:
        return None if value is None else float(value)
    plateau = law.plateau_force if table == "contact" else law.plateau
    return 0.0 if plateau is None or law.stiffness is None else HARDENING * float(law.stiffness)


def about(value: float, tolerance: float, origin: str) -> Limits:
    """Return a value plus and minus a tolerance."""
    return value - tolerance, value + tolerance, origin


@dataclass(frozen=True)
class Range:
    """An input, uniformly distributed between two values.

    A key with "*" is a factor of the scene's values of all axles or strips. `scene_value` is that of the scene where it
    has one. All values are in `unit`.
    """

    key: str
    lower: float
    upper: float
    unit: str
    scene_value: float | None
    origin: str

    def in_words(self) -> tuple[str, str]:
        """Return range and nominal value in words."""
        factor, unit = (1e-6, "MN/m") if self.unit == "N/m" else (1.0, self.unit)
        texts = []
        for value, is_last in ((self.lower, False), (self.upper, True), (self.scene_value, True)):
            rounded = 0.0 if value is None else float(f"{factor * value:.4g}")
            form = ".4g" if abs(rounded) < 1e4 else ".0f"  # without powers of ten
            texts.append("–" if value is None else measure(rounded, unit, form, named=bool(unit) and is_last))
        lower, upper, nominal = texts
        return f"{lower} to {upper}", nominal


def ranges_of(
    case: Case,
    used: tuple[str, ...],
    limits: Mapping[str, Limits | TypedLimits],
    ranges: tuple[str, ...] = (),
    fixed: tuple[str, ...] = (),
) -> tuple[Range, ...]:
    """Return the ranges of a case.

    used: keys that may vary; limits: default ranges; ranges, fixed: options --range (KEY=LOWER:UPPER) and --fix (KEY).
    The scene defines units and values of the keys. Raises InputError for an invalid range or key.
    """
    ends = {key: ends for key, ends in limits.items() if key in used}
    for text in ranges:
        key, lower, upper = _split(text, used)
        if key in ends and ends[key][2] == FROM_USER:
            raise InputError("--range", text, "this key has two ranges")
        ends[key] = (lower, upper, FROM_USER)
    for key in fixed:
        if key in ends and ends[key][2] == FROM_USER:
            raise InputError("--fix", key, "--range and --fix exclude each other; remove one of the two")
        if ends.pop(key, None) is None:
            raise InputError("--fix", key, f"this key does not vary; allowed are {', '.join(ends) or 'none'}")
    if not ends:
        raise InputError("--fix", ", ".join(fixed), "at least one key must vary")
    return tuple(_range(case, key, *ends[key]) for key in used if key in ends)


def _split(text: str, used: tuple[str, ...]) -> tuple[str, str, str]:
    """Return key and ends of a text of --range."""
    key, equals, values = (part.strip() for part in text.partition("="))
    lower, colon, upper = (part.strip() for part in values.partition(":"))
    if not all((key, equals, lower, colon, upper)):
        raise InputError("--range", text, "allowed is KEY=LOWER:UPPER, e.g. impact.friction=0.2:0.5")
    if key not in used:
        why = f"the peak force of this scene is independent of this key; allowed are {', '.join(used)}"
        raise InputError(key, values, why)
    return key, lower, upper


def _range(case: Case, key: str, lower: float | str, upper: float | str, origin: str) -> Range:
    """Return the range of a key."""
    if "*" in key:
        return Range(key, *_factors(key, lower, upper), "", 1.0, origin)
    typed, base = origin == FROM_USER, key.partition("@")[0]  # of a corner among several
    try:
        changes = ({base: parse_value(str(end)) if typed else end} for end in (lower, upper))
        varied = [vary(case.source, change) for change in changes]
    except InputError as error:
        if typed:
            raise
        where = Verbatim(f"{lower} to {upper} by default ({origin})")
        raise InputError(key, where, f"{error.allowed}; --range changes the range") from None
    remarks = (unit_remarks(source).get(base) for _, source in varied if typed)
    if remark := next(filter(None, remarks), None):
        warnings.warn(remark, stacklevel=2)
    low, high = (float(schema.value_at(scene, base)) for scene, _ in varied)
    if not high > low:
        text = f"{lower}:{upper}" if typed else f"{lower!r}:{upper!r}"
        raise InputError(key, text, "the upper limit must exceed the lower limit")
    nominal = schema.value_at(case.scene, base)
    return Range(
        key, low, high, unit_at(key, case.source.tables), None if nominal is None else float(nominal), origin
    )


def _factors(key: str, *ends: float | str) -> tuple[float, float]:
    """Return the ends of the range of a factor. Raises InputError."""
    try:
        lower, upper = map(float, ends)
    except ValueError:
        lower = upper = 0.0
    if not 0.0 < lower < upper < math.inf:
        allowed = f"this key is a factor of the scene's values; allowed is e.g. {key}=0.5:2"
        raise InputError(key, ":".join(map(str, ends)), allowed)
    return lower, upper
