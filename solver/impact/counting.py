"""Compiled strikes of a motion, and its end.

Contacts of a group of points are strikes by their duration and separation. The motion ends after the strikes that are
awaited.
"""

import numpy as np

from machine_code.compiled import compiled
from solver.impact import state as col
from solver.impact.contact import mean_speeds

SHORTEST = 1e-3
"""Shortest separation that ends a strike [s]."""

LEANING = 0.2
"""Force of the wall over the largest, up to which a vehicle with tyres merely leans on it."""

LIGHT = 5e-3
"""Impulse of later touches of a group, over that of the strike, below which they do not prolong it. Whether such
touches occur depends on micrometres, and therefore on the step."""


@compiled
def over_from(start, end):
    """Return the instant [s] from which a strike is over.

    start, end: its first and latest contact [s]. The group has then been off the wall for as long as the strike has
    lasted. The repeated contacts of a plate are one strike; otherwise their number would depend on the mesh.
    """
    return end + max(SHORTEST, end - start)


@compiled
def count_strikes(points, point_owner, motion, active, groups, strikes, number, last, h, t, k, steps_left):
    """Add this step's forces to the strikes, and return their number.

    steps_left: from now to the end, up to 1.
    """
    kick = 0.5 * (last + h)
    part = min(max(steps_left + 0.5 * last / kick, 0.0), 1.0)
    for p in active:
        if points[p, col.NORMAL] <= 0.0:
            continue
        group = groups[point_owner[p, 1]]
        first, until = _pressed_during(points[p], last, h, t)
        if group[col.STAMP] < float(k):
            is_new = group[col.STAMP] < float(k - 1)
            if group[col.SLOT] < 0.0 or (is_new and first >= over_from(group[col.FIRST], group[col.LAST])):
                group[col.SLOT], group[col.FIRST], group[col.LAST] = number, first, until
                group[col.WHOLE] = group[col.AFTER] = 0.0
                if number < strikes.shape[0]:
                    strikes[number, :] = 0.0
                number += 1
            if group[col.AFTER] >= LIGHT * group[col.WHOLE]:
                if is_new:
                    group[col.AFTER] = 0.0
                else:
                    group[col.LAST] = until
            group[col.BEFORE] = 0.0 if is_new else group[col.FORCE]
            group[col.FORCE], group[col.STAMP] = 0.0, k
        group[col.FORCE] += points[p, col.NORMAL]
        group[col.AFTER] += kick * points[p, col.NORMAL]
        group[col.WHOLE] += kick * points[p, col.NORMAL]
        if group[col.AFTER] >= LIGHT * group[col.WHOLE]:
            group[col.LAST] = max(group[col.LAST], until)
        if group[col.SLOT] >= float(strikes.shape[0]):
            continue
        strike, j = strikes[int(group[col.SLOT])], 3 * point_owner[p, 0]
        impulse, along = part * kick * points[p, col.NORMAL], part * kick * points[p, col.TANGENTIAL]
        strike[0], strike[1], strike[2] = point_owner[p, 1], group[col.FIRST], group[col.LAST]
        strike[3] = max(
            strike[3], group[col.FORCE] + min(steps_left, 0.0) * (group[col.FORCE] - group[col.BEFORE])
        )
        strike[4] += impulse
        strike[5] += along
        strike[6] += impulse * points[p, col.ALONG]
        strike[7] += impulse * (motion[0, j] + points[p, col.X])
        slip, opening = mean_speeds(points[p], motion, j)
        strike[8] -= impulse * opening
        strike[9] += along * slip
    return number


@compiled
def _pressed_during(point, last, h, t):
    """Return start and end of a point's contact in this step [s].

    They follow from its speed; the start applies to a new contact.
    """
    peak, length = point[col.PEAK], point[col.LINE]
    rate = (point[col.AHEAD] - point[col.EARLIER]) / (0.5 * last + 1.5 * h)
    beyond = point[col.DEPTH] + min(length, point[col.DEEPEST])
    first, until = t, t + h
    if rate > 0.0:
        first = max(t - beyond / rate, t - h, 0.0)
    if length <= 0.0 and peak > 0.0:
        until = t - 0.5 * last + 0.5 * (last + h) * min(point[col.NORMAL] / peak, 1.0)
    elif rate < 0.0:
        until = min(max(t - beyond / rate, t - 0.5 * h), t + h)
    return first, until


@compiled
def end_of_motion(t, k, number, touching, loaded, largest, motion, work, strikes, clock, steered):
    """Return the end of the motion [s], and updated `loaded`, `largest`.

    loaded: last instant at which the vehicle did more than lean on the wall, where its tyres may hold it for seconds;
    largest: force of the wall so far [N]. steered: True with tyres.
    """
    force, is_young = 0.0, True
    if steered:
        force, is_young = _pressing(work.groups, k, t - clock.after)
        largest = max(largest, force)
    if is_young or force > LEANING * largest:
        loaded = t
    open_end = _open_end(
        t, k, loaded, number, touching, motion, work.reach, work.groups, strikes, clock, steered
    )
    leaning = loaded + clock.after if loaded < t else np.inf
    finish = min(max(open_end, _all_over(work.groups, k, leaning)), clock.longest)
    if loaded < t:  # a group that touches lightly again does not end the motion in the past
        finish = max(finish, t)
    return finish, loaded, largest


@compiled
def _open_end(t, k, loaded, number, touching, motion, reach, groups, strikes, clock, steered):
    """Return the end of the motion [s], infinite while it is unknown.

    loaded: see `end_of_motion`. steered: with tyres a vehicle that is directed towards the wall will return to it.
    """
    after, rear = clock.after, clock.awaited
    if rear >= 0 and number >= 2 and groups[rear, col.SLOT] >= 0.0:
        if groups[rear, col.STAMP] != float(k):
            return groups[rear, col.LAST] + after
        return loaded + after if loaded < t else np.inf
    if rear < 0 and number >= 2:
        end = 0.0
        for s in range(2):
            g = int(strikes[s, 0])
            pressed = groups[g, col.STAMP] == float(k) and groups[g, col.SLOT] == float(s)
            if pressed and not loaded < t:
                return np.inf
            end = max(end, loaded if pressed else strikes[s, 2])
        return end + after
    end = max(after, t)
    for u in range(reach.size):
        v = motion[2, 3 * u + 1]
        if touching > 0 or v <= 0.0 or (steered and motion[0, 3 * u + 2] > 0.0):
            return np.inf
        end = max(end, t + max(reach[u] - motion[0, 3 * u + 1], 0.0) / v)
    return end


@compiled
def _pressing(groups, k, recent):
    """Return the normal force of the wall in this step [N].

    Also whether a strike in progress began after `recent`.
    """
    force, is_young = 0.0, False
    for g in range(groups.shape[0]):
        if groups[g, col.STAMP] == float(k):
            force += groups[g, col.FORCE]
            is_young = is_young or groups[g, col.FIRST] > recent
    return force, is_young


@compiled
def _all_over(groups, k, pressed):
    """Return the end of all strikes [s].

    pressed: end of strikes with a group in contact.
    """
    latest = 0.0
    for g in range(groups.shape[0]):
        if groups[g, col.SLOT] >= 0.0:
            over = over_from(groups[g, col.FIRST], groups[g, col.LAST])
            latest = max(latest, pressed if groups[g, col.STAMP] == float(k) else over)
    return latest


@compiled
def mark_cut(groups, k, finish, strikes):
    """Mark the strikes that are not over when the motion ends."""
    for g in range(groups.shape[0]):
        if groups[g, col.SLOT] >= 0.0 and groups[g, col.SLOT] < float(strikes.shape[0]):
            is_cut = (
                groups[g, col.STAMP] == float(k)
                or over_from(groups[g, col.FIRST], groups[g, col.LAST]) > finish
            )
            strikes[int(groups[g, col.SLOT]), col.CUT] = 1.0 if is_cut else 0.0
