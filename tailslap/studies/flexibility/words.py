"""The study in words."""

from __future__ import annotations

import math

from tailslap.studies.flexibility.levels import ABOVE_ALL, CROSSED, NOT_REACHED, STRAIGHT, Level, PowerLaw
from tailslap.studies.flexibility.survey import Point, Survey

NAMES = {
    "t": "t",
    "v_gx": "v_GX",
    "v_gy": "v_GY",
    "omega": "omega",
    "slide": "s",
    "reaction": "reaction",
    "stored": "stored energy",
}
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
    """The result in one sentence, which way it errs, and what it means for this scene."""
    return " ".join(filter(None, (main_sentence(found), sign_sentence(found), own_sentence(found))))


def main_sentence(found: Survey) -> str:
    """Down to which first frequency the rigid body's v_GY is good to 1 %."""
    levels = {level.level: level for level in found.levels[MAIN]}
    main = levels.pop(MAIN_LEVEL)
    if not math.isfinite(main.frequency):
        return "How good rigid-body v_GY is for a soft plate is not known: no run passed its checks."
    if main.kind == ABOVE_ALL:
        return f"Rigid-body v_GY is not good to 1 % even at a first frequency of {hertz(main.frequency)}."
    if main.kind == NOT_REACHED:
        words = (
            f"Rigid-body v_GY is good to 1 % down to a first frequency of {hertz(main.frequency)} at least"
        )
        return f"{words}, the softest plate whose run passed its checks."
    if main.kind != CROSSED:
        return f"Down to which first frequency rigid-body v_GY is good to 1 % is not known: {_unknown(main)}."
    others = [
        f"to {per_cent(x.level)} down to {hertz(x.frequency)}" for x in levels.values() if x.kind == CROSSED
    ]
    also = f" ({', '.join(others)})" if others else ""
    return f"Rigid-body v_GY is good to 1 % down to a first frequency of {hertz(main.frequency)}{also}."


def sign_sentence(found: Survey) -> str:
    """Whether flexible plates strike faster or slower than the rigid body, if all that passed agree."""
    faster = {point.difference[MAIN] > 0.0 for point in found.points if point.passed}
    if len(faster) != 1:
        return ""
    return f"Softer plates strike {'harder' if faster.pop() else 'less hard'}."


def own_sentence(found: Survey) -> str:
    """What the power law gives at the scene's own plate."""
    own, law = found.sweep.own_frequency, found.laws[MAIN]
    words = f"The scene's own plate has {hertz(own)}"
    if law and law.lowest <= own <= law.highest:
        return f"{words}, where the difference is {law.factor * own**law.exponent:.1e}."
    return f"{words}."


def _unknown(level: Level) -> str:
    return (
        f"near {hertz(level.frequency)} the discretisation error is not below a third of it, or runs failed"
    )


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


def law_sentence(found: Survey) -> str:
    """Whether the difference in v_GY is a power of the first frequency, and down to where."""
    law, good = found.laws[MAIN], [point for point in found.points if point.passed]
    if law is None:
        return "The difference in v_GY follows no power of the first frequency over four points."
    end = (
        "the softest plate whose run passed"
        if law.lowest == good[-1].frequency
        else "below it is none any more"
    )
    return (
        f"The difference in v_GY is {law.factor:.3g} (f1 / 1 Hz)^({law.exponent:.3f}) from {hertz(law.highest)} down "
        f"to {hertz(law.lowest)} ({end}), to {per_cent(STRAIGHT)}. Compliance goes with 1/E and E with the square of "
        "f1: a plate that follows its load without vibration has the exponent -2."
    )


def soft_sentence(found: Survey) -> str:
    """From where on the plate is too soft for the motion to make sense."""
    passed = [point.passed for point in found.points]
    if not any(passed):
        return "No run passed its checks."
    last = len(passed) - 1 - passed[::-1].index(True)
    softest, failed = found.points[last], found.points[last + 1 :]
    give = f"At its start it gives by {100.0 * softest.give:.2g} % of the way to the wall."
    if not failed:
        return f"The softest plate, of {hertz(softest.frequency)}, passes its checks. {give}"
    return (
        f"From {hertz(failed[0].frequency)} down the plate is too soft for this motion to make sense, and its runs say "
        f"so ({failed[0].why}). The softest plate that passes has {hertz(softest.frequency)}. {give}"
    )


def stiff_sentence(found: Survey) -> str:
    """Which stiffer plates failed, if any."""
    passed = [point.passed for point in found.points]
    last = len(passed) - 1 - passed[::-1].index(True) if any(passed) else 0
    failed = [f"{hertz(p.frequency)}: {p.why}" for p in found.points[:last] if not p.passed]
    return f"Stiffer plates that failed: {'; '.join(failed)}." if failed else ""


def error_sentence(found: Survey) -> str:
    """How the discretisation error is known, and how large it is beside the difference."""
    meshes = ", ".join(f"{along} x {across}" for along, across in found.sweep.meshes)
    shares = [p.errors[MAIN] / p.size(MAIN) for p in found.points if p.passed and p.size(MAIN) > 0.0]
    known = [share for share in shares if math.isfinite(share)]
    size = f" In v_GY it is at most {100.0 * max(known):.2g} % of the difference." if known else ""
    return (
        f"Numbers are those of the finest of three meshes, {meshes}, all of the same first frequency; the "
        f"discretisation error is its grid convergence index, with an observed order of at most 2.{size}"
    )


def corner_sentence(found: Survey) -> str:
    """How the corner is held, and why."""
    held = found.sweep.held
    patch = (
        f"the scene's patch of {held.patch:g} m"
        if held.own_patch
        else f"a patch of {held.patch:g} m, put in by the study because a corner held at one node gives ever more "
        "with finer meshes"
    )
    hold = (
        f"the scene's own hold ({held.constraint})"
        if held.own_constraint
        else "the exact constraint, which adds no spring"
    )
    return f"The corner is held by {hold} over {patch}.{_half_patch(found)}"


def _half_patch(found: Survey) -> str:
    """What half the patch changes, where both runs passed."""
    known = [p for p in found.points if p.passed and math.isfinite(p.half_patch)]
    if not known:
        return ""
    (point,) = known
    more = 100.0 * (point.half_patch / point.difference[MAIN] - 1.0)
    return (
        f" Over half that length the difference in v_GY at {hertz(point.frequency)} changes by {more:+.0f} %."
    )


def damping_sentence(found: Survey) -> str:
    """What was put in against flutter."""
    damped = [point for point in found.points if point.damping > 0.0]
    if found.sweep.plan.scene.damping:
        return "The scene's own damping is in every run, but not in the modal model, which has none."
    if not damped:
        return _uncalmed(found)
    return (
        f"From {hertz(damped[-1].frequency)} up the plate would flutter with its friction (exponent "
        f"{found.calming.growth:.0f} at {hertz(found.calming.frequency)}): damping.ratio up to "
        f"{max(p.damping for p in damped):g} is put in there."
    )


def _uncalmed(found: Survey) -> str:
    from fem.flutter import CALM

    calming = found.calming
    if calming.growth <= CALM:
        return ""
    return f"At {hertz(calming.frequency)} the plate would flutter with its friction, and nothing is put in against it."


def thickness_sentence(found: Survey) -> str:
    """That the thickness at constant mass does what the modulus does."""
    apart = [point.thickness.apart for point in found.points if point.thickness]
    if not apart:
        return ""
    return (
        "Thickness at constant mass: in plane motion only E t counts. With the scene's own E, and the thickness "
        f"that gives the same first frequency instead, the five quantities agree to {max(apart):.0e}."
    )


def start_sentence(found: Survey) -> str:
    """What the sweep does not contain."""
    duration = found.sweep.plan.motion.strike.t
    quiet = (
        " It starts in the elastic state of its rigid acceleration: vibration from the first impact is not in these "
        "numbers."
        if found.sweep.plan.scene.plate and found.sweep.plan.scene.plate.start != "unstressed"
        else ""
    )
    return f"Stage 2 lasts {duration:.3g} s, in which a plate of {hertz(1.0 / duration)} swings once.{quiet}"


def statements(found: Survey) -> tuple[str, ...]:
    """What a reader must know beside the numbers."""
    said = (
        law_sentence(found),
        soft_sentence(found),
        stiff_sentence(found),
        error_sentence(found),
        corner_sentence(found),
        damping_sentence(found),
        thickness_sentence(found),
        start_sentence(found),
    )
    return tuple(sentence for sentence in said if sentence)
