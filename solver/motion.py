"""Stage 2 over time, exactly (Eqs 57-71).

The corner slides along the wall, and the body rotates until its side strikes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from solver import rules, stage_2
from solver.body import MotionState, RectangularBody
from solver.conditions import Array, Gate, Number, number
from solver.stage_2 import Path, Start, TimeOfAngle

OVERRUN = 0.01  # extension of a motion after the strike, relative to the time of the strike


def tail_slap(
    body: RectangularBody[Any],
    angle: Number,
    omega: Number,
    corner_speed: Number,
    friction: Number,
    reaction: str = "drag",
    *,
    invalid: str = "raise",
) -> MotionState[Any]:
    """Return the state at the tail-slap.

    The side then lies along the wall; arguments broadcast.

    Parameters
    ----------
    body : RectangularBody
        The vehicle.
    angle : float or array_like
        theta_0 at the start of Stage 2 [rad].
    omega : float or array_like
        omega_0 [rad/s], positive towards the wall.
    corner_speed : float or array_like
        v_P0 [m/s], positive forwards.
    friction : float or array_like
        Coefficient mu >= 0 [-].
    reaction : {"drag", "none", "signed"}
        "drag": Coulomb friction on N's magnitude, mu |N| against the sliding (Eqs 66-67 [1]_); "signed": Coulomb
        friction on N's sign, -mu N, which pushes the corner on as long as the wall pulls.
    invalid : {"raise", "nan"}
        Whether rows without an answer raise, or are NaN.

    Returns
    -------
    MotionState
        Floats, or arrays of the common shape.

    Raises
    ------
    RigidBodyError
        For an input that is not finite, omega <= 0, friction < 0, an angle outside 0 < theta < pi/2 - gamma, a
        corner that does not slide forwards or stops before the strike while there is friction, a path on which
        the solution is not unique (drag) or does not exist (signed), either of which needs mu > 4/3, and what
        double precision cannot hold.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, Eqs 57-71.
    """
    start, mu = stage_2.gather(body, angle, omega, corner_speed, friction, reaction)
    return _strike(Gate(invalid), start, mu, reaction)


def plane_motion(
    body: RectangularBody[float],
    angle: float,
    omega: float,
    corner_speed: float,
    friction: float,
    reaction: str = "drag",
) -> PlaneMotion:
    """Return one motion from the start of Stage 2.

    It extends slightly beyond the tail-slap.

    Parameters
    ----------
    body : RectangularBody
        The vehicle.
    angle : float
        theta_0 [rad].
    omega : float
        omega_0 [rad/s], positive towards the wall.
    corner_speed : float
        v_P0 [m/s], positive forwards.
    friction : float
        Coefficient mu >= 0 [-].
    reaction : {"drag", "none", "signed"}
        As in `tail_slap`.

    Returns
    -------
    PlaneMotion
        Its `at` returns the state at any instant.

    Raises
    ------
    RigidBodyError
        As `tail_slap`, and for arrays.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, Eqs 57-71.
    """
    start, mu = stage_2.gather_one(body, angle, omega, corner_speed, friction, reaction)
    return PlaneMotion(body, reaction, _strike(Gate(), start, mu, reaction), start)


@dataclass(frozen=True)
class PlaneMotion:
    """One motion of Stage 2, from `plane_motion`.

    Attributes
    ----------
    body : RectangularBody
        The vehicle.
    reaction : str
        Name of the friction model.
    strike : MotionState
        The state at theta = 0.
    start : Start
        The state Stage 2 starts from.
    """

    body: RectangularBody[float]
    reaction: str
    strike: MotionState[float]
    start: Start = field(repr=False)

    @cached_property
    def first(self) -> MotionState[float]:
        """State at the start."""
        state: MotionState[float] = stage_2.state(self.start, self.start.path.theta_0, 0.0)
        return state

    @property
    def latest(self) -> float:
        """Last admissible instant [s].

        It is 1.01 strike.t, or less where phi reaches 0.
        """
        return min((1.0 + OVERRUN) * self.strike.t, float(self._clock.tau[0]) / self.start.omega_0)

    def at(self, times: ArrayLike) -> MotionState[Array]:
        """Return the states at these instants.

        After the strike theta < 0.

        Parameters
        ----------
        times : array_like, of any shape
            Instants since the start of Stage 2 [s].

        Returns
        -------
        MotionState
            Arrays of the shape of `times`.

        Raises
        ------
        RigidBodyError
            For an instant outside 0 to `latest`, past the strike where the corner, with friction, has stopped, and
            for a friction so near the limit of "signed" that no table of times holds.
        """
        t = np.asarray(number("time", times))
        gate = Gate()
        latest = self.latest
        gate.demand(rules.TIME, (t >= 0.0) & (t <= latest), t, latest=latest, strike=self.strike.t)
        states = stage_2.state(self.start, self._clock.angle(self.start.omega_0 * t), t)
        sliding = (self.start.path.mu == 0.0) | (states.v_p >= 0.0)
        gate.demand(rules.STOPPED, sliding, t)
        return states

    @cached_property
    def _clock(self) -> TimeOfAngle:
        """Clock down to an angle that is not reached before `latest`.

        It ends at 0 if the equations do not hold below.
        """
        gamma, theta_0, mu = self.start.path
        below = -min(2.0 * OVERRUN * self.strike.t * self.strike.omega, gamma)
        safe = mu >= 0.0 or stage_2.least_denominator(gamma + below, gamma + theta_0, -mu) > 0.0
        return stage_2.clock(self.start.path, below if safe else 0.0)


def _strike(gate: Gate, start: Start, friction: Number, reaction: str) -> MotionState[Any]:
    stage_2.admit_inputs(gate, start, friction, reaction)
    start, friction = _safe(gate, start, friction)
    stage_2.admit_path(gate, start.path, friction, reaction)
    start, friction = _safe(gate, start, friction)
    if reaction == "signed":
        stage_2.admit_growth(gate, start.path, friction)
        start, friction = _safe(gate, start, friction)
    with np.errstate(over="ignore", invalid="ignore"):
        tau = stage_2.scaled_time(start.path)
        strike = stage_2.state(start, 0.0 * start.omega_0, tau / start.omega_0)
    stage_2.admit_strike(gate, start, strike)
    return gate.filled(strike)


def _safe(gate: Gate, start: Start, friction: Number) -> tuple[Start, Number]:
    if gate.ok is True:
        return start, friction
    return Start(Path(*gate.safe(*start.path)), *gate.safe(*start[1:])), gate.safe(friction)[0]
