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

from machine_code.compiled import chosen, compiled, inlined
from machine_code.values import Array

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


@inlined
def _plateau_excess(crush, force):
    """Return the excess of F0 + k d over the loading curve.

    Force [N] and energy [J].
    """
    if crush.plateau is None:
        return 0.0, 0.0
    if crush.hardening is None:
        level = max(force - crush.plateau, 0.0)
        return level, 0.5 * level * level / crush.stiffness if level > 0.0 else 0.0
    above = force - crush.plateau
    if above <= 0.0:
        return 0.0, 0.0
    excess = above * (1.0 - crush.hardening / crush.stiffness)
    return excess, 0.5 * above * excess / crush.stiffness


@inlined
def _returned_part(crush, peak, energy, deepest):
    """Return the fraction of the energy that unloading recovers.

    peak: force [N], and energy: absorbed [J], at the deepest point [m].
    """
    if crush.unloading is None:
        return crush.returned
    if crush.unloading <= 0.0:
        return crush.returned
    return 0.5 * peak * min(peak / crush.unloading, deepest) / energy if energy > 0.0 else 0.0


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
    above, saved = _plateau_excess(crush, force)
    peak, energy = force - above, deepest * (crush.initial_force + 0.5 * crush.stiffness * deepest) - saved
    part = _returned_part(crush, peak, energy, deepest)
    length = 2.0 * part * energy / peak if peak > 0.0 else 0.0
    return peak, energy, length, part


@compiled
def loading_depth(crush, mean, compliance, part):
    """Return the depth on loading at a step's end [m].

    The force N reduces the mean depth without force, `mean`, by compliance N. part: of the step in which the initial
    force acts.
    """
    depth = (mean - compliance * part * crush.initial_force) / (1.0 + compliance * crush.stiffness)
    excess = _plateau_excess(crush, crush.initial_force + crush.stiffness * depth)[0]
    if crush.hardening is None:
        return depth + compliance * excess
    return depth + (compliance * excess / (1.0 + compliance * crush.hardening) if excess > 0.0 else 0.0)


@compiled
def loading_force(crush, depth):
    """Return the force [N] on the loading curve."""
    force = crush.initial_force + crush.stiffness * depth
    return force - _plateau_excess(crush, force)[0]


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


@compiled
def side_force(load, friction, cornering, ahead, across):
    """Return the side force [N] of the tyres of an axle.

    It is positive to the side to which `across` is positive. load [N]; friction mu and cornering C [-]; ahead, across:
    speeds along and across the heading [m/s].
    """
    slip = math.atan(across / max(abs(ahead), LEAST_SPEED))
    return -friction * load * math.tanh(cornering * slip / friction) if friction > 0.0 else 0.0
