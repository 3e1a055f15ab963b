"""Stage 2 in closed form.

The state at an angle, the time at which it is reached, and the conditions for a solution. With S = sin(phi), C =
cos(phi), phi = theta + gamma, and mu the friction coefficient with the sign of its reaction model (+ drag, 0 none, -
signed), Eqs 57 and 60 require along the path

    d(omega)/omega = 3 S (C + mu S)/D d(phi),   D = 1 + 3 C^2 + 3 mu S C,

and as D' = -6 S C + 3 mu (C^2 - S^2), the right-hand side is -dD/(2 D) + (3 mu/2) d(phi)/D:

    omega/omega_0 = sqrt(D_0/D) exp((3 mu/2) J),   J = integral of d(phi)/D from phi_0 to phi.

The reaction's components keep the ratio R = mu N, so that v_GX - mu v_GY is constant; a second integration makes X_G
- mu Y_G linear in time. Only the time itself remains an integral, in units of 1/omega_0:

    tau = omega_0 t = integral of omega_0/omega d(theta) from theta to theta_0.
"""

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver import rules
from solver.body import REACTIONS, MotionState, RectangularBody
from solver.conditions import Array, Gate, Number, RigidBodyError, choose, functions, holds, number, refusal

MU_SIGN = {"drag": 1.0, "none": 0.0, "signed": -1.0}  # of the coefficient in Eqs 66-67
# Gauss points of two rules; the finer rule is the result, the difference of both is checked
COARSE, FINE = 12, 20
TOLERANCE = 1e-13  # of that distance, relative; the error of the fine rule is far smaller
BISECTIONS = 24
POINTS = 32  # of a panel of the clock
TAIL = 1e-14  # largest admissible last coefficients of a panel, relative
NEGLIGIBLE = 2.0**-52  # size of last coefficients that are rounding errors and omitted, relative
PANELS = 1024
CLOSE = 1e-10  # residual of Newton's method before its last step, which squares it
GUESSES = 128  # tabulated angles from which it starts
CRITICAL_FRICTION = 4.0 / 3.0  # smallest friction at which 1 + 3 C^2 - 3 mu S C can vanish
FASTEST = 1e100  # growth of omega up to which every product stays within double precision
# At an end of the path; D has rounding errors of a few 1e-16, and omega equal relative ones
SMALLEST_D = 1e-4


class Path(NamedTuple):
    """Parameters of the angle's course, floats or arrays.

    Angles [rad]; mu has the sign of its model.
    """

    gamma: Any
    theta_0: Any
    mu: Any


class Start(NamedTuple):
    """State at the start of Stage 2, and the body.

    Floats or arrays in SI, signs as in MotionState.
    """

    path: Path
    mass: Any
    radius: Any
    omega_0: Any
    v_p0: Any


def denominator(s: Number, c: Number, mu: Number) -> Number:
    """Return D at the angle phi with sine s and cosine c.

    It is the denominator of Eqs 66-67 over 4 r^2.
    """
    return 1.0 + 3.0 * c * (c + mu * s)


def slowness(path: Path, theta: Number) -> Number:
    """Return omega_0/omega at the angles theta [rad]."""
    f_0, f = functions(*path), functions(theta, *path)
    return _slowness(f, path.mu, *_course(f_0, f, path, theta))


def _slowness(f: Any, mu: Number, d_ratio: Number, j: Number) -> Number:
    return f.sqrt(d_ratio) * f.exp(-1.5 * mu * j)


def _course(f_0: Any, f: Any, path: Path, theta: Number) -> tuple[Any, Any]:
    """Return D/D_0 and J by functions of path and theta.

    J = (2/k) [atan((2 tan(phi) + p)/k) - atan((2 tan(phi_0) + p)/k)], p = 3 mu, k^2 = 16 - p^2, but as one angle,
    which avoids the pole of the tangent and the branches of its inverse; beyond |mu| = 4/3, k is imaginary.
    """
    gamma, theta_0, mu = path
    phi_0, phi, p = gamma + theta_0, gamma + theta, 3.0 * mu
    s_0, c_0, s, c = f_0.sin(phi_0), f_0.cos(phi_0), f.sin(phi), f.cos(phi)
    k2 = (4.0 - 2.0 * mu - mu) * (4.0 + 2.0 * mu + mu)  # a factor near 0 is exact, and not 0: 4/3 is no float
    k = f_0.sqrt(abs(k2))
    opposite = (2.0 * k) * f.sin(theta - theta_0)
    b_0 = 2.0 * s_0 + p * c_0
    adjacent = (k2 * c_0 + p * b_0) * c + (2.0 * b_0) * s
    j = (2.0 / k) * _arc(f, opposite, adjacent, k2 < 0.0)
    return denominator(s, c, mu) / denominator(s_0, c_0, mu), j


def _arc(f: Any, opposite: Number, adjacent: Number, hyperbolic: bool | NDArray[np.bool_]) -> Number:
    ratio = opposite / f.where(hyperbolic, adjacent, 1.0)
    return f.where(hyperbolic, f.atanh(f.where(hyperbolic, ratio, 0.0)), f.atan2(opposite, adjacent))


def state(start: Start, theta: Number, t: Number) -> MotionState[Any]:
    """Return the exact state at an angle.

    theta: angle [rad]; t: time at which it is reached [s].
    """
    return MotionState(*numbers_at(functions(*start.path), functions(theta, *start.path), start, theta, t))


def numbers_at(f_0: Any, f: Any, start: Start, theta: Number, t: Number) -> tuple[Any, ...]:
    """Return the numbers of a `MotionState`, in the language of kernels too.

    f_0, f: functions of the start and of the angle, see `functions`.
    """
    path, m, r, omega_0, v_p0 = start
    gamma, theta_0, mu = path
    phi_0, phi = gamma + theta_0, gamma + theta
    s_0, c_0, s, c = f_0.sin(phi_0), f_0.cos(phi_0), f.sin(phi), f.cos(phi)
    d, (d_ratio, j) = denominator(s, c, mu), _course(f_0, f, path, theta)
    u, u_0 = r * omega_0 / _slowness(f, mu, d_ratio, j), r * omega_0
    v_gy, v_gy0, v_gx0 = -u * c, -u_0 * c_0, v_p0 - u_0 * s_0  # Eqs 70-71
    v_gx = v_gx0 + mu * (v_gy - v_gy0)
    mean, turn = 0.5 * (phi + phi_0), 2.0 * r * f.sin(0.5 * (theta - theta_0))
    slide = (v_gx0 - mu * v_gy0) * t + turn * (mu * f.cos(mean) - f.sin(mean))  # G's, and G to P
    normal = -m * u * (u / r) * s / d
    energy = 0.5 * m * (v_gx * v_gx + v_gy * v_gy + u * u / 3.0)
    # The gain of energy, m/2 (v_GX^2) + m/6 (u^2 (1 + 3 C^2)), with each difference in closed form, so that
    # it vanishes without friction; D u^2 = D_0 u_0^2 exp(3 mu J).
    turning = f.expm1(3.0 * mu * j) * u_0 * u_0 * (d / d_ratio)
    turning -= 3.0 * mu * (u * u * s * c - u_0 * u_0 * s_0 * c_0)
    work = m * (mu * (v_gy - v_gy0) * (v_gx + v_gx0) / 2.0 + turning / 6.0)
    v_p, tangential = v_gx + u * s, mu * normal
    return t, theta, u / r, v_gx, v_gy, v_p, slide, normal, tangential + 0.0, energy, work + 0.0


def scaled_time(path: Path) -> Number:
    """Return tau at theta = 0.

    Floats, or arrays of one shape; NaN where TOLERANCE is not reached.
    """
    fine, coarse = _panel(path, 0.0 * path.theta_0, path.theta_0)
    converged = abs(fine - coarse) <= TOLERANCE * fine
    if holds(converged):
        return fine
    arrays = Path(*(np.ravel(value) for value in path))
    tau = _bisected(arrays, np.ravel(fine)).reshape(np.shape(fine))
    return tau if tau.ndim else tau.item()


@cache
def _quadrature() -> tuple[Array, Array]:
    """Return nodes of both rules in (0, 1), and their weights.

    Weights have a column for each rule.
    """
    (x_f, w_f), (x_c, w_c) = (np.polynomial.legendre.leggauss(n) for n in (FINE, COARSE))
    weights = np.zeros((FINE + COARSE, 2))
    weights[:FINE, 0], weights[FINE:, 1] = w_f / 2.0, w_c / 2.0
    return (np.concatenate([x_f, x_c]) + 1.0) / 2.0, weights


def _panel(path: Path, lower: Number, upper: Number) -> tuple[Any, Any]:
    """Integrate from lower to upper by both rules, for all rows."""
    nodes, weights = _quadrature()
    if isinstance(lower, float):
        fine, coarse = (slowness(path, lower + (upper - lower) * nodes) @ weights).tolist()
        return fine * (upper - lower), coarse * (upper - lower)
    columns = Path(*(value[..., None] for value in path))
    sums = slowness(columns, lower[..., None] + (upper - lower)[..., None] * nodes) @ weights
    return sums[..., 0] * (upper - lower), sums[..., 1] * (upper - lower)


def _bisected(path: Path, scale: Array) -> Array:
    """Integrate rows, halving panels until both rules agree.

    scale: a first estimate.
    """
    total, rows = np.zeros(scale.size), np.arange(scale.size)
    lower, upper = np.zeros(scale.size), path.theta_0
    for _ in range(BISECTIONS):
        fine, coarse = _panel(Path(*(value[rows] for value in path)), lower, upper)
        open_ = ~(abs(fine - coarse) <= TOLERANCE * np.maximum(fine, 0.1 * scale[rows]))
        total += np.bincount(rows[~open_], fine[~open_], scale.size)
        rows, lower, upper = rows[open_], lower[open_], upper[open_]
        if rows.size == 0:
            return total
        middle = 0.5 * (lower + upper)
        rows, lower, upper = np.tile(rows, 2), np.append(lower, middle), np.append(middle, upper)
    total[rows] = np.nan
    return total


class TimeOfAngle(NamedTuple):
    """tau(theta) of one motion as Legendre series, and its inverse."""

    path: Path
    edges: Array  # of the panels, ascending [rad]
    tau: Array  # at the edges, descending
    series: Array  # of tau within each panel, minus its value at the upper edge; one column per panel
    table: tuple[Array, Array] = (np.empty(0), np.empty(0))  # tau, ascending, and angles for the first guess

    def read(self, theta: Array) -> Array:
        """Return tau at the angles theta [rad]."""
        panel = np.clip(np.searchsorted(self.edges, theta, side="right") - 1, 0, self.edges.size - 2)
        lower, upper = self.edges[panel], self.edges[panel + 1]
        x = (2.0 * theta - lower - upper) / (upper - lower)
        series = np.polynomial.legendre.legval(x, self.series[:, panel], tensor=False)
        return self.tau[panel + 1] + np.asarray(series)

    def angle(self, tau: Array) -> Array:
        """Return the angles [rad] at the times tau.

        By Newton's method to rounding.
        """
        theta = np.interp(tau, *self.table)
        for _ in range(50):
            late = self.read(theta) - tau
            theta = np.clip(theta + late / slowness(self.path, theta), self.edges[0], self.edges[-1])
            if np.all(abs(late) <= CLOSE * self.tau[0]):  # before the step just taken
                return theta
        raise refusal(rules.GROWTH, abs(self.path.mu))


@cache
def _projection() -> tuple[Array, Array]:
    """Return nodes in (-1, 1) and the matrix of Legendre coefficients.

    The matrix multiplies values at the POINTS nodes.
    """
    x, w = np.polynomial.legendre.leggauss(POINTS)
    values = np.polynomial.legendre.legvander(x, POINTS - 1)
    return x, (np.arange(POINTS) + 0.5)[:, None] * (values * w[:, None]).T


def clock(path: Path, lowest: float) -> TimeOfAngle:
    """Return the clock of one motion from theta_0 down to an angle.

    lowest: that angle [rad]. The panels are doubled until the last coefficients of each are rounding errors; raises
    RigidBodyError if none suffice.
    """
    (x, transform), panels = _projection(), 1
    while panels <= PANELS:
        edges = np.linspace(lowest, path.theta_0, panels + 1)
        half = (path.theta_0 - lowest) / (2.0 * panels)
        series = transform @ slowness(path, (edges[:-1] + half) + half * x[:, None])
        if np.max(abs(series[-2:])) <= TAIL * np.max(abs(series[0])):
            integral = half * np.polynomial.legendre.legint(-series, lbnd=1.0)
            across = 2.0 * half * series[0]
            largest = abs(integral).max(axis=1)
            integral = integral[: np.flatnonzero(largest > NEGLIGIBLE * largest.max())[-1] + 1]
            times = TimeOfAngle(path, edges, np.append(np.cumsum(across[::-1])[::-1], 0.0), integral)
            angles = np.linspace(path.theta_0, lowest, GUESSES * panels + 1)
            return times._replace(table=(times.read(angles), angles))
        panels *= 2
    raise refusal(rules.GROWTH, abs(path.mu))


def admit_inputs(gate: Gate, start: Start, friction: Number, reaction: str) -> None:
    """Check each input."""
    (gamma, theta_0, _), omega, v_p = start.path, start.omega_0, start.v_p0
    most = math.pi / 2.0 - gamma
    gate.positive(rules.OMEGA, omega)
    gate.demand(rules.ANGLE, (theta_0 > 0.0) & (theta_0 + gamma < math.pi / 2.0), theta_0, most=most)
    gate.not_negative(rules.FRICTION, friction)
    free = (friction == 0.0) | (reaction == "none")
    gate.demand(rules.CORNER_SPEED, (abs(v_p) < math.inf) & (free | (v_p > 0.0)), v_p)


def admit_path(gate: Gate, path: Path, friction: Number, reaction: str) -> None:
    """Check that the solution is unique along the path."""
    if reaction == "none" or holds(friction < CRITICAL_FRICTION):
        return
    phi, phi_0 = path.gamma, path.gamma + path.theta_0
    least, limit = least_denominator(phi, phi_0, friction), largest_friction(phi, phi_0)
    rule, met = (rules.UNIQUE, least >= 0.0) if reaction == "drag" else (rules.SOLVABLE, least > 0.0)
    gate.demand(rule, met, friction, least=least, limit=limit)


def admit_growth(gate: Gate, path: Path, friction: Number) -> None:
    """Check that omega is accurate and in range.

    Only friction that accelerates the corner can violate it.
    """
    ends = (path.gamma, path.gamma + path.theta_0)
    f = functions(*path)
    least = f.minimum(*(denominator(f.sin(phi), f.cos(phi), path.mu) for phi in ends))
    within = slowness(path, 0.0 * path.theta_0) >= 1.0 / FASTEST
    gate.demand(rules.GROWTH, within & (least >= SMALLEST_D), friction)


def admit_strike(gate: Gate, start: Start, strike: MotionState[Any]) -> None:
    """Check that the result is finite and the corner slid forwards."""
    finite, mu = functions(strike.t).isfinite, start.path.mu
    gate.demand(rules.GROWTH, strike.t == strike.t, abs(mu))
    gate.demand(rules.RANGE, finite(strike.kinetic_energy) & finite(strike.slide), start.omega_0)
    sliding = (mu == 0.0) | (strike.v_p >= 0.0)
    details = {} if gate.fill or holds(sliding) else _stop(start, sliding)
    gate.demand(rules.STOP, sliding, start.v_p0, **details)


def least_denominator(phi: Number, phi_0: Number, friction: Number) -> Number:
    """Return the least denominator on the path.

    1 + 3 C^2 - 3 mu S C falls from phi to tan(2 phi) = -mu, then rises to phi_0 [rad].
    """
    f = functions(phi, phi_0, friction)
    lowest = f.minimum(f.maximum(math.pi / 2.0 - f.atan2(friction, 1.0) / 2.0, phi), phi_0)
    return denominator(f.sin(lowest), f.cos(lowest), -friction)


def largest_friction(phi: Number, phi_0: Number) -> Number:
    """Return the friction at which the least denominator is 0.

    It is the least (T^2 + 4)/(3 T) for T = tan between phi and phi_0.
    """
    tangent = np.clip(2.0, np.tan(phi), np.tan(phi_0))
    return (tangent + 4.0 / tangent) / 3.0


def _stop(start: Start, sliding: Any) -> dict[str, float]:
    """Return angle and time at which the first such corner stops.

    v_P has one zero, because it rises before it falls.
    """
    first = int(np.argmin(np.ravel(sliding)))
    gamma, theta_0, mu, *rest = (np.ravel(value)[first].item() for value in (*start.path, *start[1:]))
    one = Start(Path(gamma, theta_0, mu), *rest)
    stopped, moving = 0.0, theta_0
    for _ in range(60):
        middle = 0.5 * (stopped + moving)
        stopped, moving = (stopped, middle) if state(one, middle, 0.0).v_p > 0.0 else (middle, moving)
    until = Path(gamma + moving, theta_0 - moving, mu)
    return {"angle": moving, "time": scaled_time(until) / one.omega_0}


def gather(
    body: RectangularBody[Any],
    angle: Number,
    omega: Number,
    corner_speed: Number,
    friction: Number,
    reaction: str,
) -> tuple[Start, Any]:
    """Return the start and the unsigned friction coefficient."""
    sign = MU_SIGN[choose("reaction", reaction, REACTIONS)]
    mu = number("friction", friction)
    inputs = number("angle", angle), number("omega", omega), number("corner_speed", corner_speed)
    values: Any = (body.corner_angle, inputs[0], sign * mu, body.mass, body.corner_radius, *inputs[1:], mu)
    if not all(isinstance(value, float) for value in values):
        values = np.broadcast_arrays(*values)
    return Start(Path(*values[:3]), *values[3:7]), values[7]


def gather_one(
    body: RectangularBody[float],
    angle: Number,
    omega: Number,
    corner_speed: Number,
    friction: Number,
    reaction: str,
) -> tuple[Start, float]:
    """Return start and friction coefficient of one motion.

    Raises RigidBodyError for arrays.
    """
    start, mu = gather(body, angle, omega, corner_speed, friction, reaction)
    if not isinstance(mu, float):
        allowed = "(), numbers; `tail_slap` takes arrays"
        raise RigidBodyError("shape", mu.shape, "this is one motion", allowed)
    return start, mu
