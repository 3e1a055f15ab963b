"""Accuracy and cost of the rigid-body theory, beside the required values.

    .venv/bin/python benchmarks/rigid.py

Coverage of `solver` by its tests:

    .venv/bin/python -m pytest tests -k rigid --cov=solver --cov-branch
"""

from __future__ import annotations

import math
from collections.abc import Callable

import command_line
import numpy as np
from command_line import row, seconds
from scipy.integrate import solve_ivp

from postprocess.comparison.quantities import PAPER_TABLE_3
from solver import (
    RectangularBody,
    RigidBodyError,
    corner_impulse,
    integrate_odes,
    plane_motion,
    strike_force,
    tail_slap,
)

MPH = 0.44704
KEYS = ("t", "v_gx", "v_gy", "omega", "slide")
TRUCK = RectangularBody(10.0, 2.438, 9979.0)


def against_integration(count: int = 1000) -> None:
    """Print the largest difference of exact and DOP853 solutions."""
    random, worst, solved, refused = np.random.default_rng(1), 0.0, 0, 0
    while solved < count:
        body = RectangularBody(random.uniform(3.0, 20.0), random.uniform(1.0, 3.0), 1e4)
        start = (random.uniform(0.02, 1.2), random.uniform(0.1, 3.0), random.uniform(5.0, 40.0))
        friction, reaction = random.uniform(0.0, 1.6), random.choice(["drag", "none", "signed"])
        try:
            exact = plane_motion(body, *start, friction, reaction).strike
            integrated = integrate_odes(body, *start, friction, reaction, rtol=1e-12).strike
        except RigidBodyError:
            refused += 1
            continue
        worst = max(worst, *(abs(getattr(exact, key) / getattr(integrated, key) - 1.0) for key in KEYS))
        solved += 1
    row(f"exact against DOP853, {count} random inputs ({refused} refused)", "1e-10", f"{worst:.1e}")


def table_3() -> None:
    """Print differences from the analytical column of Table 3."""
    start = corner_impulse(TRUCK, 56 * MPH, math.radians(15.0), 0.47, 0.22)
    strike = plane_motion(TRUCK, 0.26, start.omega, start.corner_speed, 0.47).strike
    printed = PAPER_TABLE_3["analytical"]
    for key, limit in {"v_gy": 0.1, "v_gx": 0.1, "slide": 0.1, "t": 0.3, "omega": 0.8}.items():
        difference = f"{100 * (getattr(strike, key) / printed[key] - 1):+.3f} %"
        row(f"Table 3, analytical, {key}", f"{limit} %", difference)


def best(function: Callable[[], object], repeats: int, loops: int = 1) -> float:
    """Return the best time of one call [s]."""
    return min(seconds(lambda: [function() for _ in range(loops)]) for _ in range(repeats)) / loops


def bare_integration(atol: float) -> Callable[[], object]:
    """Return Eqs 66-69 for `solve_ivp` with an event in their shortest form.

    The scene is the paper's truck with friction.
    """
    radius, gamma, mu = TRUCK.corner_radius, TRUCK.corner_angle, 0.47

    def rates(t: float, y: np.ndarray) -> tuple[float, float, float, float]:
        sine, cosine = math.sin(y[2] + gamma), math.cos(y[2] + gamma)
        d = 1.0 + 3.0 * cosine**2 + 3.0 * mu * sine * cosine
        acceleration = -y[1] * y[1] * radius * 4.0 * (cosine + mu * sine) / d
        return acceleration, 0.75 * sine / radius * acceleration, -y[1], y[0]

    def struck(t: float, y: np.ndarray) -> float:
        return float(y[2])

    struck.terminal = True  # type: ignore[attr-defined]
    start = [25.053, 0.707, 0.26, 0.0]
    return lambda: solve_ivp(rates, (0.0, 1.0), start, method="DOP853", rtol=1e-10, atol=atol, events=struck)


def cost() -> None:
    """Print the time of exact solutions beside solve_ivp."""
    exact = best(lambda: plane_motion(TRUCK, 0.26, 0.707, 25.053, 0.47).strike, 9, 200)
    for atol in (1e-12, 1e-6):
        bare = best(bare_integration(atol), 9, 10)
        what = f"exact ({exact * 1e6:.0f} us) against bare solve_ivp, rtol 1e-10, atol {atol:g}"
        row(what, "1/20", f"1/{bare / exact:.0f} of {bare * 1e6:.0f} us")
    checked = best(lambda: integrate_odes(TRUCK, 0.26, 0.707, 25.053, 0.47, rtol=1e-10), 5, 3)
    text = f"1/{checked / exact:.0f} of {checked * 1e6:.0f} us"
    row("the same against the program's integrate_odes", "1/20", text)
    row("100 000 combinations, Stages 1 to 3, one core", "2 s", f"{best(many, 3):.2f} s")


def many() -> None:
    """Solve a hundred thousand combinations of speed, angle, mass, friction and restitution."""
    random, n = np.random.default_rng(2), 100_000
    body = RectangularBody(10.0, 2.438, random.uniform(8e3, 12e3, n))
    angle, friction = random.uniform(0.1, 0.4, n), random.uniform(0.2, 0.7, n)
    start = corner_impulse(body, random.uniform(15.0, 35.0, n), angle, friction, random.uniform(0.0, 0.5, n))
    strike = tail_slap(body, angle, start.omega, start.corner_speed, friction)
    strike_force(body.mass, strike.v_gy, 0.1)


if __name__ == "__main__":
    command_line.options(__doc__)
    for part in (against_integration, table_3, cost):
        part()
