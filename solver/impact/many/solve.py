"""Many whole impacts at once, for studies: the first two strikes and the 50 ms peak of each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.elementary import Array, Number, number
from solver.errors import Gate, Rule
from solver.impact import rules
from solver.impact.many.count import Strikes, counted, no_strikes
from solver.impact.many.leapfrog import LEAST_RESTITUTION, Batch, Moving, Pushed, pushed, step_of, stepped
from solver.rules import LENGTH, MASS, WIDTH

WINDOW = 0.05  # s
_MOST_STEPS = 200_000


@dataclass(frozen=True)
class Impacts:
    """The first two strikes of many impacts, and the peaks of the total force.

    Attributes
    ----------
    corner : ndarray, shape (2, ...)
        Of each strike, index into `CORNERS`; -1 where there is no such strike [-].
    start, duration : ndarray, shape (2, ...)
        [s]; NaN where there is no such strike.
    peak_force : ndarray, shape (2, ...)
        Of the normal force [N].
    impulse : ndarray, shape (2, ...)
        Of the normal force [N s].
    raw_peak : ndarray, shape (...)
        Of the total normal force until the end [N].
    mean_50ms : ndarray, shape (...)
        Greatest mean of the total normal force over 50 ms [N].
    mean_force : ndarray, shape (rows, ...)
        Total normal force [N], each row the mean since the even instant before, the first from first touch on; no rows
        where no interval was asked for.
    """

    corner: NDArray[np.int64]
    start: Array
    duration: Array
    peak_force: Array
    impulse: Array
    raw_peak: Array
    mean_50ms: Array
    mean_force: Array


def solve_impacts(
    *,
    length: Number,
    width: Number,
    mass: Number,
    speed: Number,
    angle: Number,
    stiffness: Number,
    restitution: Number,
    friction: Number,
    initial_force: Number = 0.0,
    centre_of_mass: Number | None = None,
    yaw_inertia: Number | None = None,
    after_second: float = 0.1,
    longest: float = 5.0,
    interval: float | None = None,
) -> Impacts:
    """Whole impacts of rigid vehicles whose corners alone touch; arguments broadcast.

    Parameters
    ----------
    length, width : float or ndarray
        L, B [m].
    mass : float or ndarray
        m [kg].
    speed : float or ndarray
        [m/s].
    angle : float or ndarray
        Between side and wall [rad].
    stiffness : float or ndarray
        k of the corners [N/m].
    restitution : float or ndarray
        e [-]; below 0.02 taken as 0.02.
    friction : float or ndarray
        mu [-].
    initial_force : float or ndarray
        F0 [N].
    centre_of_mass : float, ndarray or None
        Behind the front [m]; None: L/2.
    yaw_inertia : float, ndarray or None
        [kg m^2]; None: m (L^2 + B^2)/12.
    after_second : float
        Each ends so long after its second strike [s].
    longest : float
        And after this at the latest [s].
    interval : float or None
        Between the rows of the force history [s]; None: there is none.

    Returns
    -------
    Impacts
        Arrays of the common shape.

    Raises
    ------
    RigidBodyError
        As `solve_impact`, for the first row that has no answer.

    Notes
    -----
    Leapfrog with a step of 0.02 of the stiffest oscillation's radian. Against `solve_impact` peaks and impulses are
    within 1e-3, mostly 5e-5 (tests/verification/test_impact_many.py).
    """
    given = dict(
        zip(_KEYS, (length, width, mass, speed, angle, stiffness, restitution, friction), strict=True)
    )
    shape, values = _gathered({**given, "initial_force": initial_force}, centre_of_mass, yaw_inertia)
    batch, at = _start(**values)
    strikes, t, impulse = _march(batch, at, after_second, longest)
    mean = np.array([_greatest_mean(t[:, i], impulse[:, i]) for i in range(t.shape[1])])
    return _shaped(shape, strikes, mean, _sampled(t, impulse, interval, longest))


_KEYS = ("length", "width", "mass", "speed", "angle", "stiffness", "restitution", "friction")


def _gathered(given: dict[str, Any], centre: Any, inertia: Any) -> tuple[tuple[int, ...], dict[str, Array]]:
    """The common shape, and flat arrays that have passed the rules."""
    values = {key: number(key, value) for key, value in given.items()}
    length, width, mass = values["length"], values["width"], values["mass"]
    values["centre"] = 0.5 * length if centre is None else number("centre_of_mass", centre)
    values["inertia"] = (
        mass * (length**2 + width**2) / 12.0 if inertia is None else number("yaw_inertia", inertia)
    )
    arrays = np.broadcast_arrays(*values.values())
    flat = {key: np.ravel(array).astype(float) for key, array in zip(values, arrays, strict=True)}
    _demand(**flat, given=inertia is not None)
    return arrays[0].shape, flat


def _demand(given: bool, **v: Array) -> None:
    gate, e, a = Gate(), v["restitution"], v["centre"]
    positive = (LENGTH, WIDTH, MASS, rules.SPEED, rules.STIFFNESS)
    limits: list[tuple[Rule, Any, Any]] = [
        *((rule, (v[rule.key] > 0.0) & (v[rule.key] < math.inf), v[rule.key]) for rule in positive),
        (rules.TOUCH_ANGLE, (v["angle"] > 0.0) & (v["angle"] < math.pi / 2.0), v["angle"]),
        (rules.RESTITUTION, (e >= 0.0) & (e <= 1.0), e),
        (rules.LINE, (v["initial_force"] == 0.0) | (2.0 * e * e <= 1.0 + 1e-12), e),
    ]
    for rule in (rules.FRICTION, rules.INITIAL_FORCE):
        limits.append((rule, (v[rule.key] >= 0.0) & (v[rule.key] < math.inf), v[rule.key]))
    for rule, met, value in limits:
        gate.demand(rule, met, value)
    gate.demand(rules.CENTRE, (a > 0.0) & (a < v["length"]), a, length=v["length"])
    most, inertia = v["mass"] * (a * (v["length"] - a) + v["width"] ** 2 / 4.0), v["inertia"]
    rule, value = (rules.INERTIA, inertia) if given else (rules.UNIFORM, a)
    fits = (inertia >= rules.MIN_INERTIA * most) & (inertia <= most * (1.0 + 1e-12))
    gate.demand(rule, fits, value, inertia=inertia, most=most)


def _start(
    length: Array, width: Array, mass: Array, speed: Array, angle: Array, stiffness: Array, restitution: Array,
    friction: Array, initial_force: Array, centre: Array, inertia: Array,
) -> tuple[Batch, Moving]:  # fmt: skip
    b = 0.5 * width
    along = np.stack([centre, centre - length, centre, centre - length])
    across = np.stack([-b, -b, b, b])
    reach = np.hypot(np.maximum(centre, length - centre), b)
    e = np.maximum(restitution, LEAST_RESTITUTION)
    batch = Batch(stiffness, initial_force, e, friction, mass, inertia, along, across, reach)
    s, c, zero = np.sin(angle), np.cos(angle), np.zeros_like(angle)
    return batch, Moving(zero, centre * s + b * c, angle, speed * c, -speed * s, zero, np.zeros_like(along))


def _march(batch: Batch, at: Moving, after_second: float, longest: float) -> tuple[Strikes, Array, Array]:
    """All steps: the strikes, and times and normal impulses at the steps, shape (steps + 1, n)."""
    n = at.t.size
    strikes, p = no_strikes(n), pushed(batch, at)
    start, times, impulses = at.v_y, [at.t], [np.zeros(n)]
    for _ in range(_MOST_STEPS):
        over = _over(batch, at, p, strikes, after_second, longest)
        if over.all():
            break
        h = np.where(over, 0.0, step_of(batch, at, p))
        before = p.normal
        at, p = stepped(batch, at, p, h)
        strikes = counted(strikes, at.t, h, before, p)
        times.append(at.t)
        impulses.append(batch.mass * (at.v_y - start))
    return strikes, np.array(times), np.array(impulses)


def _over(
    batch: Batch, at: Moving, p: Pushed, strikes: Strikes, after_second: float, longest: float
) -> Array:
    second = (strikes.number >= 2) & (at.t >= strikes.end.max(axis=0, initial=0.0) + after_second)
    off = (at.v_y > 0.0) & (at.y >= batch.reach) & (p.normal <= 0.0).all(axis=0)
    return second | off | (at.t >= longest)


def _greatest_mean(t: Array, impulse: Array) -> float:
    """Greatest mean force over the window, which begins or ends at a step."""
    ahead = np.interp(t + WINDOW, t, impulse) - impulse
    behind = impulse - np.interp(t - WINDOW, t, impulse)
    return float(max(ahead.max(), behind.max())) / WINDOW


def _sampled(t: Array, impulse: Array, interval: float | None, longest: float) -> Array:
    """Mean forces over even intervals, shape (rows, n), from the impulses at the steps; after its end each has none."""
    if interval is None:
        return np.zeros((0, t.shape[1]))
    instants = interval * np.arange(math.ceil(min(t[-1].max(), longest) / interval) + 1)
    sampled = [np.interp(instants, own, pushed) for own, pushed in zip(t.T, impulse.T, strict=True)]
    return np.diff(np.transpose(sampled), axis=0) / interval


def _shaped(shape: tuple[int, ...], strikes: Strikes, mean: Array, force: Array) -> Impacts:
    there = strikes.corner >= 0.0
    fields = (strikes.start, strikes.end - strikes.start, strikes.peak, strikes.impulse)
    start, duration, peak, impulse = (np.where(there, value, np.nan).reshape(2, *shape) for value in fields)
    corner = strikes.corner.astype(int).reshape(2, *shape)
    raw, history = strikes.raw.reshape(shape), force.reshape(len(force), *shape)
    return Impacts(corner, start, duration, peak, impulse, raw, mean.reshape(shape), history)
