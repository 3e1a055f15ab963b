"""Where Stage 2 has an answer: the conditions on its inputs, and on the path that they lead to."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from solver import rules
from solver.closed_form import Path, Start, denominator, slowness, state
from solver.elapsed import scaled_time
from solver.elementary import functions
from solver.errors import Gate, holds
from solver.state import MotionState

CRITICAL_FRICTION = 4.0 / 3.0  # 1 + 3 C^2 - 3 mu S C can vanish from here on
FASTEST = 1e100  # growth of omega up to which every product stays within double precision
SMALLEST_D = 1e-4  # at an end of the path; D rounds by a few 1e-16, and omega by the same part of it


def admit_inputs(gate: Gate, start: Start, friction: Any, reaction: str) -> None:
    """The conditions on each input alone."""
    (gamma, theta_0, _), omega, v_p = start.path, start.omega_0, start.v_p0
    most = math.pi / 2.0 - gamma
    gate.demand(rules.OMEGA, (omega > 0.0) & (omega < math.inf), omega)
    gate.demand(rules.ANGLE, (theta_0 > 0.0) & (theta_0 + gamma < math.pi / 2.0), theta_0, most=most)
    gate.demand(rules.FRICTION, (friction >= 0.0) & (friction < math.inf), friction)
    free = (friction == 0.0) | (reaction == "none")
    gate.demand(rules.CORNER_SPEED, (abs(v_p) < math.inf) & (free | (v_p > 0.0)), v_p)


def admit_path(gate: Gate, path: Path, friction: Any, reaction: str) -> None:
    """The condition for one solution, and not two or none, all along the path."""
    if reaction == "none" or holds(friction < CRITICAL_FRICTION):
        return
    phi, phi_0 = path.gamma, path.gamma + path.theta_0
    least, limit = least_denominator(phi, phi_0, friction), largest_friction(phi, phi_0)
    rule, met = (rules.UNIQUE, least >= 0.0) if reaction == "drag" else (rules.SOLVABLE, least > 0.0)
    gate.demand(rule, met, friction, least=least, limit=limit)


def admit_growth(gate: Gate, path: Path, friction: Any) -> None:
    """The conditions for omega to be known and within reach; only friction that pushes on can break them."""
    ends = (path.gamma, path.gamma + path.theta_0)
    f = functions(*path)
    least = f.minimum(*(denominator(f.sin(phi), f.cos(phi), path.mu) for phi in ends))
    within = slowness(path, 0.0 * path.theta_0) >= 1.0 / FASTEST
    gate.demand(rules.GROWTH, within & (least >= SMALLEST_D), friction)


def admit_strike(gate: Gate, start: Start, strike: MotionState[Any]) -> None:
    """The conditions on the answer: it is a number, and the corner slid forwards all the way."""
    finite, mu = functions(strike.t).isfinite, start.path.mu
    gate.demand(rules.GROWTH, strike.t == strike.t, abs(mu))
    gate.demand(rules.RANGE, finite(strike.kinetic_energy) & finite(strike.slide), start.omega_0)
    sliding = (mu == 0.0) | (strike.v_p >= 0.0)
    details = {} if gate.fill or holds(sliding) else _stop(start, sliding)
    gate.demand(rules.STOP, sliding, start.v_p0, **details)


def least_denominator(phi: Any, phi_0: Any, friction: Any) -> Any:
    """The least 1 + 3 C^2 - 3 mu S C from phi to phi_0 [rad]: it falls to tan(2 phi) = -mu, then rises."""
    f = functions(phi, phi_0, friction)
    lowest = f.minimum(f.maximum(math.pi / 2.0 - f.atan2(friction, 1.0) / 2.0, phi), phi_0)
    return denominator(f.sin(lowest), f.cos(lowest), -friction)


def largest_friction(phi: Any, phi_0: Any) -> Any:
    """The friction at which that is 0: the least (T^2 + 4)/(3 T) for T = tan between phi and phi_0."""
    tangent = np.clip(2.0, np.tan(phi), np.tan(phi_0))
    return (tangent + 4.0 / tangent) / 3.0


def _stop(start: Start, sliding: Any) -> dict[str, float]:
    """Angle and time at which the first such corner stops; v_P has one zero, for it rises before it falls."""
    first = int(np.argmin(np.ravel(sliding)))
    gamma, theta_0, mu, *rest = (np.ravel(value)[first].item() for value in (*start.path, *start[1:]))
    one = Start(Path(gamma, theta_0, mu), *rest)
    stopped, moving = 0.0, theta_0
    for _ in range(60):
        middle = 0.5 * (stopped + moving)
        stopped, moving = (stopped, middle) if state(one, middle, 0.0).v_p > 0.0 else (middle, moving)
    until = Path(gamma + moving, theta_0 - moving, mu)
    return {"angle": moving, "time": scaled_time(until) / one.omega_0}
