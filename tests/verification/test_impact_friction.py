"""Verification: stick and slip: a pressed block, Gauss's principle, the limits of stuck points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from solver.elementary import Array
from solver.impact import CrushLaw, ImpactState, ImpactVehicle, WallContact
from solver.impact.dynamics import Dynamics, Forces, Kinematics
from solver.impact.friction import Body, Candidates, released, sliding_of, stick_margin
from solver.impact.integrate import Span, at_start, integrate
from solver.impact.measure import intervals
from solver.impact.modes import FREE, LINE, Modes

pytestmark = pytest.mark.verification

BLOCK = ImpactVehicle(4.0, 2.0, 1000.0)
REACH = math.hypot(2.0, 1.0)
UPRIGHT = math.pi / 2.0 - math.atan(0.5)  # the front corner is below the centre of mass


@dataclass(frozen=True)
class Loaded(Dynamics):
    """With a constant force on the centre of mass."""

    push: float = 0.0
    press: float = 0.0

    @property
    def load(self) -> Array:
        return np.array([self.push, -self.press, 0.0]) / self.mass

    def rates(self, t: float, y: Array) -> Array:
        out = super().rates(t, y)
        out[3:6] += self.load
        return out

    def accelerations(self, at: Kinematics, forces: Forces) -> Array:
        return super().accelerations(at, forces) + self.load[:, None]


def motion(law: CrushLaw, mu: float, state: ImpactState, end: float, **loads: float) -> list[Span]:
    """Of a block that does not turn."""
    dynamics, y = at_start(BLOCK, WallContact(law, mu), state)
    known = {key: getattr(dynamics, key) for key in ("mass", "mu", "points", "modes")}
    return integrate(Loaded(inertia=1e30, **known, **loads), y, lambda spans, t, y, dynamics: end)


def pressed_block(mu: float, push: float, speed: float, end: float) -> list[Span]:
    """A block that rests on its spring under N0 = 10 kN."""
    law, press = CrushLaw(1e6, 0.0, 0.5), 1e4
    dynamics, y = at_start(BLOCK, WallContact(law, mu), ImpactState(0.0, REACH, UPRIGHT, speed, 0.0, 0.0))
    known = {key: getattr(dynamics, key) for key in ("mass", "mu", "points")}
    crush, most = np.array([LINE, FREE, FREE, FREE]), np.array([press / 1e6, 0.0, 0.0, 0.0])
    y[1] -= most[0]
    modes = Modes(crush, np.sign(np.full(4, speed)), most)
    block = Loaded(inertia=1e30, **known, modes=modes, push=push, press=press)
    return integrate(block, y, lambda spans, t, y, dynamics: end)


def last(spans: list[Span]) -> Array:
    return spans[-1].y


def test_a_sliding_block_stops_after_its_way() -> None:
    """v^2 m/(2 mu N0), and stays there."""
    mu, v = 0.4, 3.0
    for end in (0.9, 2.0):
        y = last(pressed_block(mu, 0.0, v, end))
        assert y[0] == pytest.approx(v * v * BLOCK.mass / (2.0 * mu * 1e4), rel=1e-9)
        assert y[3] == pytest.approx(0.0, abs=1e-11)
    half = v * BLOCK.mass / (2.0 * mu * 1e4)
    assert last(pressed_block(mu, 0.0, v, half))[3] == pytest.approx(v / 2.0, rel=1e-9)


def test_a_block_sticks_below_the_limit_and_slips_above() -> None:
    mu = 0.4
    stuck, slipped = (last(pressed_block(mu, push, 0.0, 1.0)) for push in (0.999 * mu * 1e4, 1.5 * mu * 1e4))
    assert (stuck[0], stuck[3]) == (pytest.approx(0.0, abs=1e-11), pytest.approx(0.0, abs=1e-11))
    assert slipped[3] == pytest.approx(0.5 * mu * 1e4 / BLOCK.mass, rel=1e-9)


def test_a_sliding_block_turns_round_under_a_greater_force() -> None:
    """It stops under push and friction, and goes back under push less friction."""
    mu, v, push = 0.4, 3.0, -7e3
    stop = v * BLOCK.mass / (mu * 1e4 - push)
    y = last(pressed_block(mu, push, v, stop + 1.0))
    assert y[3] == pytest.approx((push + mu * 1e4) / BLOCK.mass, rel=1e-9)


@pytest.mark.parametrize("e", [0.3, 0.5])
def test_a_bouncing_mass(e: float) -> None:
    """t1 = sqrt(2 h/g), then 2 v/g with v to e v; from the second bounce on its own dent it loses no more."""
    g, h = 10.0, 5.0
    v = math.sqrt(2.0 * g * h)
    spans = motion(
        CrushLaw(1e16, 0.0, e), 0.0, ImpactState(0.0, REACH + h, UPRIGHT, 0.0, 0.0, 0.0),
        v / g * (1.0 + 5.0 * e), press=g * BLOCK.mass,
    )  # fmt: skip
    found = intervals(spans)
    assert [interval.start for interval in found] == pytest.approx(
        [v / g * (1.0 + 2.0 * e * n) for n in range(3)], rel=1e-6
    )
    ends = {interval.end for interval in found}
    assert [span.y[4] for span in spans if span.end in ends] == pytest.approx([e * v] * 3, rel=1e-6)


def cases(count: int) -> list[tuple[Body, Candidates]]:
    rng = np.random.default_rng(count)
    out = []
    for _ in range(100):
        n = int(rng.integers(1, count + 1))
        body = Body(rng.uniform(1.0, 5.0), rng.uniform(1.0, 5.0), *rng.normal(size=2) * 3.0)
        centripetal = rng.normal(size=n) * rng.integers(0, 2)
        out.append((body, Candidates(rng.normal(size=n), centripetal, rng.uniform(0.1, 4.0, n))))
    return out


def rest(body: Body, points: Candidates) -> tuple[Array, Array]:
    """Friction that minimises T G T/2 + b T within its limits, G Delassus' matrix, and the accelerations."""
    from scipy.optimize import minimize

    ones = np.ones_like(points.y)
    delassus = np.outer(ones, ones) / body.mass + np.outer(points.y, points.y) / body.inertia
    b = body.u - body.w * points.y - points.centripetal
    found = minimize(
        lambda force: (force @ delassus @ force / 2.0 + b @ force, delassus @ force + b), 0.0 * b, jac=True,
        bounds=list(zip(-points.limit, points.limit, strict=True)), method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 1000},
    )  # fmt: skip
    return found.x, delassus @ found.x + b


@pytest.mark.parametrize("count", [1, 2, 6])
def test_what_begins_to_slide_is_what_gauss_says(count: int) -> None:
    """Against the dual problem, for friction forces, by another method; both signs and sticking occur."""
    signs = []
    for body, points in cases(count):
        sliding = sliding_of(body, points)
        _, acceleration = rest(body, points)
        clear = np.abs(acceleration) > 1e-4
        assert np.array_equal(sliding[clear], np.sign(acceleration[clear]))
        assert np.all(np.abs(acceleration[sliding == 0.0]) < 1e-4)
        signs += sliding.tolist()
    assert set(signs) == {-1.0, 0.0, 1.0}


def bearable(y: Array, limit: Array, force: Array) -> bool:
    """Whether friction within the limits has the sum and the moment of `force`, by linear programming."""
    from scipy.optimize import linprog

    equal = np.vstack([np.ones_like(y), y])
    bounds = list(zip(-limit, limit, strict=True))
    return bool(linprog(np.zeros(y.size), A_eq=equal, b_eq=equal @ force, bounds=bounds).status == 0)


def test_the_margin_of_stuck_points() -> None:
    rng = np.random.default_rng(3)
    verdicts = []
    for _ in range(200):
        n = int(rng.integers(1, 6))
        y, limit, force = rng.normal(size=n), rng.uniform(0.1, 1.0, n), rng.normal(size=n)
        margin = stick_margin(y, limit, force)
        if abs(margin) > 1e-6:
            assert (margin > 0.0) == bearable(y, limit, force)
            verdicts.append(margin > 0.0)
    assert set(verdicts) == {True, False}


def test_what_slips_first() -> None:
    """At the end of the margin the released points are at their limits, opposite to their sliding."""
    y, limit = np.array([-1.0, 0.3, 0.5, 2.0]), np.array([1.0, 2.0, 0.5, 1.0])
    force = np.array([1.0, 2.0, 0.2, -1.0])  # the third has some left
    assert stick_margin(y, limit, force) == pytest.approx(0.0, abs=1e-12)
    assert released(y, limit, force).tolist() == [-1.0, -1.0, 0.0, 1.0]
    assert released(y[:1], limit[:1], limit[:1]).tolist() == [-1.0]
    level = released(np.ones(3), limit[:3], limit[:3])
    assert level.tolist() == [-1.0] * 3
