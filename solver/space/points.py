"""Compiled forces of the wall on the points of a strip.

A point is pushed by the crush law along the normal of the face; one that was above the top behind the face's upper
edge by the top. Their forces are shared between both ends of the strip, in proportion to the distances from them.
"""

from typing import NamedTuple

import numpy as np

from fem.laws.contact_forces import PointCrush, crush_line, loading_force
from machine_code.compiled import inlined, reordered
from solver.space import state as col
from solver.space.stopping import returns_nothing
from solver.space.wall import mean_normal, point_of_face

EDGE = 0.02
"""Least half height of a point of a strip [m].

Over it the point leaves the face at the top and at an edge of the profile.
"""

INWARD = 0.5 / EDGE
"""Part of a point per distance from the edge, within which it lies on the top [1/m]."""

AT_REST = 1e-9
"""Distance from the deepest position within which a point rests there [m]."""

STEEPEST, STICKING = 0.25, 0.25
"""Limits of the slope of unloading times h^2, and of friction over sliding velocity times h, over the effective mass of
a point: the force of a step does not reverse the motion that causes it."""


class Ends(NamedTuple):
    """Vectors at the start a and the end b of a strip.

    Positions [m], velocities [m/s] or forces [N].
    """

    ax: float
    ay: float
    az: float
    bx: float
    by: float
    bz: float


class Crest(NamedTuple):
    """Upper end of the wall, and points of a strip beside it.

    toe: distance from which a point is clear of the wall at any height [m]; top: height of the top, edge: distance of
    the face there [m]; half: half height of a point [m]; upward: the inverse of its height [1/m].
    """

    toe: float
    top: float
    edge: float
    half: float
    upward: float


class Law(NamedTuple):
    """What the force on a point depends on.

    crush: of its length; stops: the strip returns no energy; early: largest gap that closes within the step [m]; h: the
    step, until `ahead` from now [s]; of_body, of_axle: its square over the effective mass of a point on the body, and
    added for one on an axle that is pushed up [s^2/kg]; friction [-]; stopping: largest friction over sliding velocity
    [N s/m].
    """

    crush: PointCrush
    stops: bool
    early: float
    h: float
    ahead: float
    of_body: float
    of_axle: float
    friction: float
    stopping: float


class Press(NamedTuple):
    """Sums over the points of a strip.

    force: on both ends; normal: that of it along the normals, 0 unless the strip returns no energy; gap: forces times
    the velocities that would bring points to their deepest positions [W]; spread: lateral forces times squared places
    along the wall [N m^2]; work, lost: power of normal forces and of friction [W]; presses: True if there is a force.
    """

    force: Ends
    normal: Ends
    gap: float
    spread: float
    work: float
    lost: float
    presses: bool


@inlined
def law_of(strip, points, mobility, of_axle, friction, early, h, ahead):
    """Return the law of a point of a strip.

    Arguments as of `_press_strip` in `solver.space.forces`.
    """
    crush, scale = _crush_of(strip, strip[col.LENGTH] * (1.0 / points)), h * h * points
    stopping = STICKING / (h * points * (mobility + of_axle))
    return Law(
        crush, returns_nothing(strip), early, h, ahead, scale * mobility, scale * of_axle, friction, stopping
    )  # fmt: skip


@inlined
def press_points(law, memories, places, rates, crest, wall, facets):
    """Return the forces of face and top on the points.

    The third value is True if a point touches.
    places, rates: of both ends [m], [m/s].
    """
    none, points = Ends(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), memories.shape[0]
    press = Press(none, none, 0.0, 0.0, 0.0, 0.0, False)
    touches, raised, first, last = False, False, points, 0
    spacing = 1.0 / points
    for n in range(points):
        p, memory = spacing * (n + 0.5), memories[n]
        _, y, z = between(places, p)
        if y > crest.toe:
            memory[col.ABOVE] = 0.0
            continue
        weight = 1.0
        if z + crest.half > crest.top or memory[col.ABOVE] > 0.0:
            if z - crest.half > crest.top and y < crest.edge - 2.0 * EDGE:
                memory[col.ABOVE], raised = 1.0, True
                continue
            weight = _part_on_face(memory, y, z, crest)
            if memory[col.ABOVE] > 0.0:
                raised = True
                depth, sunk = _on_top(memory, z, crest)
                touches = touches or sunk > 0.0
                if sunk > 0.0 and depth > memory[col.TOP + col.FOOT]:
                    first, last = min(first, n), n + 1
            if weight <= 0.0:
                continue
        if touches and crest.toe - y <= memory[col.FOOT]:  # as below, for any profile
            continue
        face, k = point_of_face(wall, facets, z)
        touches = touches or face > y
        if face - y <= max(memory[col.FOOT], 0.0) - law.early:  # the depth is no larger
            continue
        ny, nz = mean_normal(wall, facets, k, z - crest.half, z + crest.half)
        depth = (face - y) * ny
        press = _pressed(press, law, memory, col.FACE, p, depth, weight, ny, nz, places, rates)
    over = Press(none, none, 0.0, 0.0, 0.0, 0.0, False)
    for n in range(first, last):  # those in part on the top
        p, memory = spacing * (n + 0.5), memories[n]
        _, _, z = between(places, p)
        depth, sunk = _on_top(memory, z, crest)
        if sunk > 0.0:
            over = _pressed(
                over, law, memory, col.TOP, p, depth, sunk * crest.upward, 0.0, 1.0, places, rates
            )
    memories[0, col.RAISED] = 1.0 if raised else 0.0
    return press, over, touches


@inlined
def between(ends, p):
    """Return the vector at a fraction p of the way."""
    o = 1.0 - p
    return o * ends.ax + p * ends.bx, o * ends.ay + p * ends.by, o * ends.az + p * ends.bz


@inlined
def _shared(ends, p, x, y, z):
    """Share a vector at a fraction p between both ends."""
    o = 1.0 - p
    return Ends(
        ends.ax + o * x, ends.ay + o * y, ends.az + o * z, ends.bx + p * x, ends.by + p * y, ends.bz + p * z
    )  # fmt: skip


@inlined
def _part_on_face(memory, y, z, crest):
    """Return the part of a point that the face may push.

    Sets the part that was above the top.
    """
    above = min(max(0.5 + (z - crest.top) * crest.upward, 0.0), 1.0)
    share = min(max(memory[col.ABOVE], above), min(max((crest.edge - y) * INWARD, 0.0), 1.0))
    memory[col.ABOVE] = share
    return 1.0 - max(above, share)


@inlined
def _on_top(memory, z, crest):
    """Return depth and length of the part on the top [m].

    It was above the top, and lies below it where the length is above 0.
    """
    lowest = crest.top - z + crest.half * (2.0 * memory[col.ABOVE] - 1.0)
    sunk = min(lowest, 2.0 * crest.half * memory[col.ABOVE])
    return lowest - 0.5 * sunk, sunk


@inlined
def _pressed(press, law, memory, column, p, depth, weight, ny, nz, places, rates):
    """Return the forces with those on a further point.

    column: `FACE` or `TOP`; p: its place between the ends; weight: part of its length in contact; ny, nz: normal.
    """
    force, gap = _normal_force(law, memory, column, p, depth, weight, ny, nz, rates)
    if force <= 0.0:
        return press
    vx, vy, vz = between(rates, p)
    fx, fy, fz, approach, loss = _wall_force(vx, vy, vz, ny, nz, force, law.friction * force, law.stopping)
    x, _, _ = between(places, p)
    normal = _shared(press.normal, p, 0.0, force * ny, force * nz) if law.stops else press.normal
    return Press(
        _shared(press.force, p, fx, fy, fz), normal, press.gap + gap, press.spread + fy * x**2,
        press.work + force * approach, press.lost + loss, True,
    )  # fmt: skip


@inlined
def _normal_force(law, memory, column, p, depth, weight, ny, nz, rates):
    """Return the normal force [N] and its part of the gap [W].

    Arguments as of `_pressed`.
    """
    if column == col.FACE and law.early > 0.0 and memory[column] == 0.0:
        _, vy, vz = between(rates, p)
        closing = -vy * ny - vz * nz
        return weight * _first_force(law.crush, memory, depth, _part(depth, closing, law.h, law.ahead)), 0.0
    if law.stops:
        _, vy, vz = between(rates, p)
        closing = -vy * ny - vz * nz
        beyond, memory[column] = depth - memory[column], max(memory[column], depth)
        part = _part(beyond, closing, law.h, law.ahead) if abs(beyond) > AT_REST else 1.0
        force = weight * part * loading_force(law.crush, memory[column])
        return force, -force * min(beyond, 0.0) / law.h
    inverse = law.of_body + nz * nz * law.of_axle
    return _point_force(law.crush, memory, column, depth, weight, inverse), 0.0


@inlined
def _part(depth, closing, h, ahead):
    """Return the part of the step after the touch of a point.

    closing: velocity into the face [m/s]. It applies to a force that begins suddenly.
    """
    if closing <= 0.0:
        return 1.0 if depth > 0.0 else 0.0
    return min(max((ahead + depth / closing) / h, 0.0), 1.0)


@inlined
def _first_force(crush, memory, depth, part):
    """Return the force on a point that has not been pressed [N].

    part: of the step, in which the initial force acts.
    """
    memory[col.FACE] = max(depth, 0.0)
    begun = PointCrush(
        crush.stiffness,
        part * crush.initial_force,
        crush.returned,
        crush.plateau,
        crush.unloading,
        crush.hardening,
    )
    return loading_force(begun, memory[col.FACE])


@inlined
def _crush_of(strip, length):
    """Return the crush law of this length of a strip [m]."""
    stiffness, plateau = strip[col.STIFFNESS] * length, strip[col.PLATEAU] * length
    unloading, hardening = strip[col.UNLOADING] * length, strip[col.HARDENING] * length
    return PointCrush(
        stiffness, strip[col.INITIAL] * length, strip[col.RETURNED], plateau, unloading, hardening
    )


@inlined
def _point_force(crush, memory, column, depth, weight, inverse):
    """Return the force of the crush law on a point [N].

    weight: fraction of its length that is in contact; inverse: square of the step over the effective mass [s^2/kg].
    """
    if depth <= memory[column + col.FOOT]:
        return 0.0
    if depth >= memory[column]:
        memory[column], memory[column + col.SLOPE] = depth, 0.0
        return weight * loading_force(crush, depth)
    if memory[column + col.SLOPE] == 0.0:
        _set_unloading(crush, memory, column, inverse)
    return weight * memory[column + col.SLOPE] * (depth - memory[column + col.FOOT])


@inlined
def _wall_force(vx, vy, vz, ny, nz, force, limit, stopping):
    """Return force of the wall on a point, approach and loss.

    The force has the normal part `force` and friction of at most `limit` [N]. stopping: largest friction over sliding
    velocity [N s/m]. The approach is the velocity along the normal [m/s], the loss the power of friction [W].
    """
    approach = vy * ny + vz * nz
    ty, tz = vy - approach * ny, vz - approach * nz
    sliding = np.sqrt(vx * vx + ty * ty + tz * tz)
    drag = limit / sliding if limit < stopping * sliding else stopping
    return -drag * vx, force * ny - drag * ty, force * nz - drag * tz, approach, drag * sliding * sliding


@reordered
def _set_unloading(crush, memory, column, inverse):
    """Set the line of unloading of a point from its deepest position.

    inverse: square of the step over the effective mass [s^2/kg].
    """
    peak, _, length, _ = crush_line(crush, memory[column])
    length = max(length, peak * inverse / STEEPEST)
    memory[column + col.FOOT] = memory[column] - length
    memory[column + col.SLOPE] = peak / length if length > 0.0 else 0.0
