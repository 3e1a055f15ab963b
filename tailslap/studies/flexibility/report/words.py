"""The study in few words: frequencies, levels, and the headline."""

from __future__ import annotations

import math

from tailslap.studies.flexibility.levels import ABOVE_ALL, CROSSED, NOT_REACHED, Level, PowerLaw
from tailslap.studies.flexibility.points import Point
from tailslap.studies.flexibility.survey import Survey
from tailslap.studies.flexibility.sweep import STARTS

NAMES = {
    "t": "t",
    "v_gx": "v_GX",
    "v_gy": "v_GY",
    "omega": "omega",
    "slide": "s",
    "reaction": "reaction",
    "stored": "stored energy",
}
START_NAMES = dict(zip(STARTS, ("inertia relief", "Stage 1's momenta", "unstressed"), strict=True))
FROM = dict(
    zip(STARTS, ("with inertia relief", "with Stage 1's momenta", "from the unstressed plate"), strict=True)
)
MAIN = "v_gy"
MAIN_LEVEL = 1e-2


def hertz(frequency: float) -> str:
    """A frequency with its unit, which a line does not break off."""
    if frequency >= 999.5:
        return f"{frequency / 1e3:.3g}\N{NO-BREAK SPACE}kHz"
    return f"{frequency:.3g}\N{NO-BREAK SPACE}Hz" if math.isfinite(frequency) else "–"


def per_cent(level: float) -> str:
    """A level as it is spoken of."""
    return f"{100.0 * level:g} %"


def headline(found: Survey) -> str:
    """The result in one sentence, and where this scene's own plate lies."""
    return f"{main_sentence(found)} {own_sentence(found)}"


def main_sentence(found: Survey) -> str:
    """Down to which first frequency the rigid body's v_GY is good, from each start and from any of them."""
    place = next(i for i, level in enumerate(found.band) if level.level == MAIN_LEVEL)
    if not any(math.isfinite(levels[place].frequency) for levels in found.starts.values()):
        return "How good rigid-body v_GY is for a soft plate is not known: no run passed its checks."
    first, *more = (f"{frequency_words(levels[place])} {FROM[name]}" for name, levels in found.starts.items())
    others = [
        f"to {per_cent(level.level)} down to {frequency_words(level)}"
        for level in found.band
        if level.level != MAIN_LEVEL and level.kind in (CROSSED, NOT_REACHED)
    ]
    also = f" ({', '.join(others)})" if others else ""
    return (
        f"Rigid-body v_GY is good to {per_cent(MAIN_LEVEL)}, at the strike and before, down to a first frequency of "
        f"{first}, {' and '.join(more)}: for any of the three down to {frequency_words(found.band[place])}{also}."
    )


def frequency_words(level: Level) -> str:
    """The lowest first frequency of a level, in a sentence."""
    words = {
        CROSSED: hertz(level.frequency),
        NOT_REACHED: f"{hertz(level.frequency)} at least",
        ABOVE_ALL: f"more than {hertz(level.frequency)}",
    }
    near = f" (not known near {hertz(level.frequency)})" if math.isfinite(level.frequency) else ""
    return words.get(level.kind, f"an unknown one{near}")


def own_sentence(found: Survey) -> str:
    """What the power law gives at the scene's own plate."""
    own, law = found.sweep.own_frequency, found.laws[MAIN]
    words = f"The scene's own plate has {hertz(own)}"
    if law and law.lowest <= own <= law.highest:
        return f"{words}, where {FROM[STARTS[0]]} the difference is {law.factor * own**law.exponent:.1e}."
    return f"{words}."


def level_words(level: Level) -> str:
    """A level's cell of the table."""
    if level.kind == CROSSED:
        return hertz(level.frequency)
    if level.kind == NOT_REACHED:
        return f"< {hertz(level.frequency)}"
    return f"> {hertz(level.frequency)}" if level.kind == ABOVE_ALL else "not known"


def law_words(law: PowerLaw | None) -> tuple[str, str]:
    """Exponent and range of a power law."""
    if law is None:
        return "none", ""
    return f"{law.exponent:.3f}", f"{hertz(law.highest)} to {hertz(law.lowest)}"


def why_words(point: Point) -> str:
    """A point's verdict."""
    if point.passed:
        return "passed"
    return f"failed: {point.why}" if point.steps else f"none: {point.why[:90]}"
