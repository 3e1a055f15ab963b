"""Forces at a contact point, compiled for vehicle and plate.

Crush: F = min(F0 + k d, Fy) on loading, with hardening Fy + k2 (d - (Fy - F0)/k) beyond Fy. Unloading and reloading
follow one line from the deepest point to F = 0. It is defined by its slope, or by the part of the absorbed energy that
it returns. A prescribed slope is raised to F/d at the deepest point where that is larger, so that the line never ends
in front of the undeformed vehicle.

Friction: Coulomb's law, with the force that would stop the point within the step as its value while the point sticks.

Tyres: the side force of an axle, -mu N tanh(C a/mu) across its heading, a = atan(v_across/max(|v_ahead|, v0)).
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from machine_code.compiled import chosen, compiled
from machine_code.values import Array, Nothing

LEAST_SPEED = 1.0
"""Speed ahead v0 [m/s] below which the slip angle no longer grows as the vehicle slows down."""


class PointCrush(NamedTuple):
    """Crush of one point.

    stiffness: k [N/m]; initial_force: F0 [N]; returned: part of the energy that unloading returns [-]; plateau: Fy [N],
    infinite or None for none; unloading: its slope [N/m], 0 or None where the returned part defines it; hardening: k2
    [N/m], None for 0. There is no code for what is None.
    """

    stiffness: float
    initial_force: float
    returned: float
    plateau: Any = None
    unloading: Any = None
    hardening: Any = None


def plateau_excess(
    plateau: float | None, hardening: float | None, force: float, stiffness: float
) -> tuple[float, float]:
    """Return the excess of F0 + k d over the loading curve.

    Force [N] and energy [J]. Compiled code only.
    """
    raise NotImplementedError(type(plateau))


@chosen(plateau_excess)
def _plateau_excess(
    plateau: object, hardening: object, force: object, stiffness: object
) -> Callable[..., object]:
    def none(plateau: object, hardening: object, force: float, stiffness: float) -> tuple[float, float]:
        return 0.0, 0.0

    def level(plateau: float, hardening: None, force: float, stiffness: float) -> tuple[float, float]:
        above = max(force - plateau, 0.0)
        return above, 0.5 * above * above / stiffness if above > 0.0 else 0.0

    def rising(plateau: float, hardening: float, force: float, stiffness: float) -> tuple[float, float]:
        above = force - plateau
        if above <= 0.0:
            return 0.0, 0.0
        excess = above * (1.0 - hardening / stiffness)
        return excess, 0.5 * above * excess / stiffness

    if isinstance(plateau, Nothing):
        return none
    return level if isinstance(hardening, Nothing) else rising


def receded(hardening: float | None, compliance: float, excess: float) -> float:
    """Return the additional depth of a point [m].

    Its force is less by the excess [N].

    Compiled code only.
    """
    raise NotImplementedError(type(hardening))


@chosen(receded)
def _receded(hardening: object, compliance: object, excess: object) -> Callable[..., object]:
    def level(hardening: None, compliance: float, excess: float) -> float:
        return compliance * excess

    def rising(hardening: float, compliance: float, excess: float) -> float:
        return compliance * excess / (1.0 + compliance * hardening) if excess > 0.0 else 0.0

    return level if isinstance(hardening, Nothing) else rising


def returned_part(
    unloading: float | None, returned: float, peak: float, energy: float, deepest: float
) -> float:
    """Return the fraction of the energy that unloading recovers.

    peak: force [N], and energy: absorbed [J], at the deepest point [m]. Compiled code only.
    """
    raise NotImplementedError(type(unloading))


@chosen(returned_part)
def _returned_part(
    unloading: object, returned: object, peak: object, energy: object, deepest: object
) -> Callable[..., object]:
    def by_restitution(unloading: None, returned: float, peak: float, energy: float, deepest: float) -> float:
        return returned

    def by_slope(unloading: float, returned: float, peak: float, energy: float, deepest: float) -> float:
        if unloading <= 0.0:
            return returned
        return 0.5 * peak * min(peak / unloading, deepest) / energy if energy > 0.0 else 0.0

    return by_restitution if isinstance(unloading, Nothing) else by_slope


def item(values: Any, i: int) -> Any:
    """Return an item of an array, or a common value itself.

    Compiled code only.
    """
    raise NotImplementedError(type(values))


@chosen(item)
def _item(values: object, i: object) -> Callable[..., object]:
    return (lambda values, i: values[i]) if isinstance(values, Array) else (lambda values, i: values)


@compiled
def crush_line(crush, deepest):
    """Return the unloading line from the deepest point.

    The force [N] and the absorbed energy [J] at the deepest point; the depth [m] over which the force falls to zero;
    the part of the energy that unloading returns.
    """
    force = crush.initial_force + crush.stiffness * deepest
    above, saved = plateau_excess(crush.plateau, crush.hardening, force, crush.stiffness)
    peak, energy = force - above, deepest * (crush.initial_force + 0.5 * crush.stiffness * deepest) - saved
    part = returned_part(crush.unloading, crush.returned, peak, energy, deepest)
    length = 2.0 * part * energy / peak if peak > 0.0 else 0.0
    return peak, energy, length, part


@compiled
def loading_depth(crush, mean, compliance, part):
    """Return the depth on loading at a step's end [m].

    The force N reduces the mean depth without force, `mean`, by compliance N. part: of the step in which the initial
    force acts.
    """
    depth = (mean - compliance * part * crush.initial_force) / (1.0 + compliance * crush.stiffness)
    force = crush.initial_force + crush.stiffness * depth
    excess = plateau_excess(crush.plateau, crush.hardening, force, crush.stiffness)[0]
    return depth + receded(crush.hardening, compliance, excess)


@compiled
def loading_force(crush, depth):
    """Return the force [N] on the loading curve."""
    force = crush.initial_force + crush.stiffness * depth
    return force - plateau_excess(crush.plateau, crush.hardening, force, crush.stiffness)[0]


@compiled
def crush_force(crush, deepest, beyond, compliance, depth):
    """Return the normal force [N] at the end of the step.

    beyond: mean depth without force, from the deepest point, since both may agree in most digits; depth: of
    `loading_depth`, with a force that acts throughout the step. On the line (deepest - d) / length = 1 - N / peak, and
    d - deepest = beyond - compliance N; a line without length drops at once.
    """
    if depth > deepest:
        return loading_force(crush, depth)
    peak, _, length, _ = crush_line(crush, deepest)
    return line_force(peak, length, beyond, compliance)


@compiled
def line_force(peak, length, beyond, compliance):
    """Return the normal force [N] on the line of unloading.

    peak, length: of the line; beyond: as of `crush_force`.
    """
    return peak * max(length + beyond, 0.0) / (length + compliance * peak) if peak > 0.0 else 0.0


def coulomb_force(stopping: float, limit: float) -> float:
    """Return the stopping force within the limit of friction [N].

    The limit is 0 or more.
    """
    return min(max(stopping, -limit), limit)


@chosen(coulomb_force)
def _coulomb_force(stopping: object, limit: object) -> Callable[..., object]:
    return coulomb_force


@compiled
def side_force(load, friction, cornering, ahead, across):
    """Return the side force [N] of the tyres of an axle.

    It is positive to the side to which `across` is positive. load [N]; friction mu and cornering C [-]; ahead, across:
    speeds along and across the heading [m/s].
    """
    slip = math.atan(across / max(abs(ahead), LEAST_SPEED))
    return -friction * load * math.tanh(cornering * slip / friction) if friction > 0.0 else 0.0
