"""What a reader of the study must know beside the numbers, sentence by sentence."""

from __future__ import annotations

import math

from tailslap.studies.flexibility.levels import STRAIGHT
from tailslap.studies.flexibility.points import Point
from tailslap.studies.flexibility.report.words import FROM, MAIN, hertz, per_cent
from tailslap.studies.flexibility.survey import Survey
from tailslap.studies.flexibility.sweep import STARTS

RELIEF = STARTS[0]
START = FROM[RELIEF].capitalize()
KEPT_BY = (
    "Inertia relief begins in the elastic state of the rigid acceleration and keeps spin and corner speed; with Stage "
    "1's momenta the same state keeps the centre's v_GX and v_GY; the unstressed plate keeps all four, and oscillates."
)


def law_sentence(found: Survey) -> str:
    """Whether the difference in v_GY is a power of the first frequency, and down to where."""
    law, good = found.laws[MAIN], [point for point in found.points if point.passed]
    if law is None:
        return f"{START} v_GY's difference at the strike follows no power of the first frequency over four points."
    end = (
        "the softest plate whose run passed"
        if law.lowest == good[-1].frequency
        else "below it is none any more"
    )
    return (
        f"{START} v_GY's difference at the strike is {law.factor:.3g} (f1 / 1 Hz)^({law.exponent:.3f}) from "
        f"{hertz(law.highest)} down to {hertz(law.lowest)} ({end}), to {per_cent(STRAIGHT)}. Compliance goes with 1/E "
        "and E with the square of f1: a plate that follows its load without vibration has the exponent -2."
    )


def soft_sentence(found: Survey) -> str:
    """From where on the plate is too soft for a start by inertia relief."""
    passed = [point.passed for point in found.points]
    if not any(passed):
        return "No run passed its checks."
    last = len(passed) - 1 - passed[::-1].index(True)
    softest, failed = found.points[last], found.points[last + 1 :]
    give = f"At its start it gives by {100.0 * softest.give:.2g} % of the way to the wall."
    if not failed:
        return f"The softest plate, of {hertz(softest.frequency)}, passes its checks. {give}"
    return (
        f"From {hertz(failed[0].frequency)} down the plate is too soft for a start by inertia relief "
        f"({failed[0].why}). The softest plate that passes has {hertz(softest.frequency)}. {give}"
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
        "numerical error is its grid convergence index, with an observed order of at most 2, and what damping and "
        f"ringing may do.{size}"
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
    if found.sweep.plan.scene.damping:
        return "The scene's own damping is in every run, but not in the modal model, which has none."
    damped = [(p.frequency, s.damping) for p in found.points for s in p.starts.values() if s.damping > 0.0]
    if not damped:
        return ""
    softest = min(frequency for frequency, _ in damped)
    return (
        f"At first frequencies from {hertz(softest)} up friction would make some of the plates flutter: there the "
        f"program damps the elastic velocities, at up to {max(rate for _, rate in damped):.2g} 1/s. That takes much of "
        "an unstressed plate's oscillation away before the strike, and is why its largest difference counts."
    )


def thickness_sentence(found: Survey) -> str:
    """That the thickness at constant mass does what the modulus does."""
    apart = [point.thickness.apart for point in found.points if point.thickness]
    if not apart:
        return ""
    return (
        "Thickness at constant mass: in plane motion only E t counts. With the scene's own E, and the thickness "
        f"that gives the same first frequency instead, the five quantities agree to {max(apart):.0e}."
    )


def kept_sentence(found: Survey) -> str:
    """What each start keeps of the rigid body, and how far it departs from the rest."""
    ran = [point for point in found.points if point.starts[RELIEF].passed]
    if not ran:
        return KEPT_BY
    point = ran[-1]
    relief, momenta = (point.starts[name].departure for name in STARTS[:2])
    return (
        f"{KEPT_BY} At {hertz(point.frequency)} the first begins with a v_GY {relief['v_gy']:+.1e} off, which Stage 1 "
        f"did not give and which is {_share_at_start(point)} % of its difference at the strike; the second with spin "
        f"and corner speed {momenta['omega']:+.1e} and {momenta['v_p']:+.1e} off."
    )


def _share_at_start(point: Point) -> str:
    start = point.starts[RELIEF]
    return f"{100.0 * start.departure['v_gy'] / start.difference:.0f}"


def phase_sentence(found: Survey) -> str:
    """Which difference the levels of v_GY are held to, and how its error is known."""
    duration = found.sweep.plan.motion.strike.t
    return (
        "An oscillating plate strikes in any phase, and Stage 2 lasts "
        f"{duration:.3g} s, in which a plate of {hertz(1.0 / duration)} swings once: v_GY's levels are held to the "
        "largest difference from the rigid body at the strike and at any instant before it. Its error is the grid "
        "convergence index of the three meshes, and of the unstressed start, run on the finest, the program's own "
        "estimate from a second mesh."
    )


def statements(found: Survey) -> tuple[str, ...]:
    """What a reader must know beside the numbers."""
    said = (
        kept_sentence(found),
        phase_sentence(found),
        law_sentence(found),
        soft_sentence(found),
        stiff_sentence(found),
        error_sentence(found),
        corner_sentence(found),
        damping_sentence(found),
        thickness_sentence(found),
    )
    return tuple(sentence for sentence in said if sentence)
