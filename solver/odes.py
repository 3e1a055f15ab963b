"""Stage 2 by numerical integration of the paper's equations (Eqs 57-71).

It verifies the exact solution (`stage_2`), with which it has no formula in common: Eqs 66-71 are written as printed,
in L, B, theta, mu_k, r_PG and gamma; their signs follow from Eqs 57 and 60-64. They hold for friction that opposes
the sliding while the wall pulls ("drag"); "none" is mu_k = 0, and "signed", where the force has the sign of the
wall's force, -mu_k.
"""

# ruff: noqa: N806 (the paper's symbols)

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from solver import rules, stage_2
from solver.body import MotionState, RectangularBody
from solver.conditions import Array, Gate, Number, RigidBodyError, number, refusal

_LONGEST = 1e3  # limit of time over theta_0/omega_0; friction slows omega to a sixth


class _Equations(NamedTuple):
    """Parameters of Eqs 66-71.

    The unknowns are y = (v_P, omega, theta, s, work of friction).
    """

    L: float
    B: float
    m: float
    mu_k: float  # with the sign of its reaction model

    def denominator(self, theta: Number, mu_k: float) -> Number:
        """Return the denominator of Eqs 66 and 67 [m^2]."""
        L, B, _, _ = self
        r_PG, gamma = np.sqrt(L**2 + B**2) / 2, np.arctan(B / L)
        arm = L * np.sin(theta) + B * np.cos(theta)
        return 4 * B**2 + 4 * L**2 - 3 * arm * (arm - 2 * mu_k * r_PG * np.cos(theta + gamma))

    def accelerations(self, omega: Number, theta: Number) -> tuple[Number, Number]:
        """Return d(v_P)/dt and d(omega)/dt (Eqs 66 and 67)."""
        L, B, _, mu_k = self
        r_PG, gamma = np.sqrt(L**2 + B**2) / 2, np.arctan(B / L)
        arm = L * np.sin(theta) + B * np.cos(theta)
        bracket = B * np.sin(theta) - L * np.cos(theta) - 2 * mu_k * r_PG * np.sin(theta + gamma)
        below = self.denominator(theta, mu_k)
        return 2 * omega**2 * (L**2 + B**2) * bracket / below, 3 * omega**2 * arm * bracket / below

    def forces(self, omega: Number, theta: Number) -> tuple[Number, Number]:
        """Return R_f and R_n on the vehicle.

        R_n is m times the derivative of Eq 71, R_f the friction of Eq 57.
        """
        L, B, m, mu_k = self
        r_PG, gamma = np.sqrt(L**2 + B**2) / 2, np.arctan(B / L)
        omega_dot = self.accelerations(omega, theta)[1]
        R_n = -m * r_PG * (omega_dot * np.cos(theta + gamma) + omega**2 * np.sin(theta + gamma))
        return mu_k * R_n, R_n

    def rates(self, t: float, y: Array) -> Array:
        """Return Eqs 66-69, and the power of R_f."""
        v_P, omega, theta = y[:3]
        v_P_dot, omega_dot = self.accelerations(omega, theta)
        return np.array([v_P_dot, omega_dot, -omega, v_P, self.forces(omega, theta)[0] * v_P])

    def state(self, t: Number, y: Array) -> MotionState[Any]:
        """Return Eqs 70 and 71, and the kinetic energy with Eq 26."""
        L, B, m, _ = self
        v_P, omega, theta, s, work = y
        r_PG, gamma = np.sqrt(L**2 + B**2) / 2, np.arctan(B / L)
        X_dot, Y_dot = v_P - omega * r_PG * np.sin(theta + gamma), -omega * r_PG * np.cos(theta + gamma)
        R_f, R_n = self.forces(omega, theta)
        energy = m * (X_dot**2 + Y_dot**2) / 2 + m * (B**2 + L**2) / 12 * omega**2 / 2
        return MotionState(t, theta, omega, X_dot, Y_dot, v_P, s, R_n, R_f, energy, work)


@dataclass(frozen=True)
class OdeMotion:
    """One integrated motion of Stage 2, from `integrate_odes`.

    Attributes
    ----------
    strike : MotionState
        The state at theta = 0.
    """

    strike: MotionState[float]
    _equations: _Equations = field(repr=False)
    _dense: Callable[[Array], Array] = field(repr=False)

    def at(self, times: ArrayLike) -> MotionState[Array]:
        """Return the states at these instants.

        They are from the method's dense output, which is less accurate than its steps.

        Parameters
        ----------
        times : array_like, of any shape
            Instants from 0 to the strike [s].

        Returns
        -------
        MotionState
            Arrays of the shape of `times`.

        Raises
        ------
        RigidBodyError
            For an instant outside that range.
        """
        t = np.asarray(number("time", times))
        end = self.strike.t
        Gate().demand(rules.TIME, (t >= 0.0) & (t <= end), t, latest=end, strike=end)
        return self._equations.state(t, self._dense(np.ravel(t)).reshape(-1, *t.shape))


def integrate_odes(
    body: RectangularBody[float],
    angle: float,
    omega: float,
    corner_speed: float,
    friction: float,
    reaction: str = "drag",
    method: str = "DOP853",
    rtol: float = 1e-12,
    atol: float = 1e-14,
) -> OdeMotion:
    """Integrate Stage 2 by SciPy's `solve_ivp`.

    From its start to the tail-slap.

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
    method : str
        Name of a method of `solve_ivp`.
    rtol : float
        Relative tolerance [-].
    atol : float
        Absolute tolerance [SI], for v_P, omega, theta, s and the work of friction.

    Returns
    -------
    OdeMotion
        Its `at` returns the state at any instant up to the strike.

    Raises
    ------
    RigidBodyError
        As `plane_motion`.

    References
    ----------
    .. [1] Chuong and Malla, Infrastructures 2025, 10(11), 307, Eqs 66-71.
    """
    from scipy.integrate import solve_ivp

    start, friction = stage_2.gather_one(body, angle, omega, corner_speed, friction, reaction)
    stage_2.admit_inputs(Gate(), start, friction, reaction)
    equations = _Equations(body.length, body.width, body.mass, stage_2.MU_SIGN[reaction] * friction)
    events = _events(equations)
    if events[2].value(0.0, np.array([corner_speed, omega, angle])) <= 0.0:
        raise _ambiguous(friction, angle)
    options: dict[str, Any] = {"method": method, "rtol": rtol, "atol": atol}
    y_0, span = np.array([corner_speed, omega, angle, 0.0, 0.0]), (0.0, _LONGEST * angle / omega)
    with np.errstate(all="ignore"):
        run = solve_ivp(equations.rates, span, y_0, events=events, dense_output=True, **options)
        _demand_strike(run, corner_speed, friction)
        # The event lies on the dense output, which is less accurate than the steps: take the last step to it.
        t = float(run.t_events[0][0])
        last = solve_ivp(equations.rates, (run.t[-2], t), run.y[:, -2], **options)
    y, delay = last.y[:, -1], last.y[2, -1] / last.y[1, -1]
    y = y + delay * equations.rates(t, y)
    y[2] = 0.0
    return OdeMotion(equations.state(t + delay, y), equations, run.sol)


@dataclass(frozen=True)
class _Event:
    """Event of `solve_ivp` that ends the integration.

    Its value then falls through 0.
    """

    value: Callable[[float, Array], float]
    terminal: bool = True
    direction: float = -1.0

    def __call__(self, t: float, y: Array) -> float:
        return self.value(t, y)


def _events(equations: _Equations) -> tuple[_Event, _Event, _Event]:
    """Return the events that end the integration.

    The strike; the corner's stop, with friction; the end of uniqueness, or of the solution.
    """
    mu_k = equations.mu_k
    return (
        _Event(lambda t, y: y[2]),
        _Event(lambda t, y: y[0] if mu_k else 1.0),
        _Event(lambda t, y: float(equations.denominator(y[2], -abs(mu_k)))),
    )


def _demand_strike(run: Any, corner_speed: float, friction: float) -> None:
    """Raise RigidBodyError unless the integration ended with the strike."""
    if run.t_events[0].size:
        return
    if run.t_events[1].size:
        angle, time = run.y_events[1][0][2], run.t_events[1][0]
        raise refusal(rules.STOP, corner_speed, angle=angle, time=time)
    if run.t_events[2].size or friction > 4.0 / 3.0:  # or the steps became too short before that
        raise _ambiguous(friction, run.y[2, -1])
    raise refusal(rules.GROWTH, friction)


def _ambiguous(friction: float, theta: float) -> RigidBodyError:
    why = f"the wall's reaction is not unique, or has no bound, from the angle {theta:.6g} rad on"
    return RigidBodyError("friction", f"{friction:.10g}", why, "less than 4/3 = 1.33333 for every path")
