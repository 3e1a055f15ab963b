"""Verify strips in the plane against an independent integration.

There are three, four and six.

Exact: the equations of a rigid rectangle with sliding friction and crush laws, by an adaptive integrator of order 8.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from solver.impact import CrushLaw, ImpactVehicle, Strip, WallContact, first_touch, solve_impact

TRUCK, MU, END = ImpactVehicle(10.0, 2.438, 9979.0, 5.2, 9e4), 0.35, 0.42
SPEED, ANGLE = 25.0, math.radians(15.0)
LAWS = {
    "linear": lambda k: CrushLaw(k, 0.0, 0.4),
    "elastic": lambda k: CrushLaw(k, 0.0, 1.0),
    "plateau": lambda k: CrushLaw(k, 0.0, 0.22, 0.11 * k),
    "plateau, slope": lambda k: CrushLaw(k, 0.0, 0.0, 0.1 * k, 12.0 * k),
    "hardening": lambda k: CrushLaw(k, 0.0, 0.22, 0.11 * k, 0.0, 0.3 * k),
    "hardening, slope": lambda k: CrushLaw(k, 0.0, 0.0, 0.1 * k, 12.0 * k, 0.2 * k),
    "little return": lambda k: CrushLaw(k, 0.0, 0.1, 0.12 * k),
}
PLACES = {  # behind the front, inwards from the side [m], stiffness [N/m]
    3: [(0.0, 0.0, 2e6), (7.2, 0.0, 1.2e6), (10.0, 0.0, 1.5e6)],
    4: [(0.3, 0.05, 2e6), (1.3, 0.0, 0.8e6), (7.2, 0.1, 1.2e6), (9.4, 0.0, 1.5e6)],
    6: [(0.0, 0.02, 1e6), (0.8, 0.0, 1e6), (4.0, 0.0, 0.5e6), (6.6, 0.08, 0.9e6), (7.8, 0.08, 0.9e6), (9.9, 0.0, 2e6)],
}  # fmt: skip


def loading(law: CrushLaw, depth: float) -> tuple[float, float]:
    """Force and absorbed energy on loading."""
    k, most = float(law.stiffness), float(law.plateau_force)
    if k * depth <= most:
        return k * depth, 0.5 * k * depth**2
    after = depth - most / k
    rise = float(law.hardening) * after
    return most + rise, 0.5 * most**2 / k + (most + 0.5 * rise) * after


def force(law: CrushLaw, depth: float, deepest: float) -> float:
    """Force at a depth after the deepest one."""
    if depth >= deepest:
        return loading(law, depth)[0] if depth > 0.0 else 0.0
    peak, energy = loading(law, deepest)
    slope = float(law.unloading_stiffness)
    if not slope:
        returned = float(law.restitution) ** 2 * energy
        if returned == 0.0:
            return 0.0
        slope = peak**2 / (2.0 * returned)
    return max(0.0, peak - slope * (deepest - depth))


def peer(strips: tuple[Strip, ...], start: Any) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Impulses of the strips at the end, and contacts at instants."""
    places = np.array([[5.2 - strip.at[0], -(1.219 - strip.inset)] for strip in strips])
    count, laws = len(strips), [strip.law for strip in strips]

    def depths(y: float, theta: float) -> np.ndarray:
        return -(y + places[:, 1] * math.cos(theta) - places[:, 0] * math.sin(theta))

    def pushes(state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        depth = depths(state[1], state[2])
        return depth, np.array(
            [force(law, d, top) for law, d, top in zip(laws, depth, state[6 : 6 + count], strict=True)]
        )

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        theta, u, v, w = state[2:6]
        depth, push = pushes(state)
        arm_x = places[:, 0] * math.cos(theta) + places[:, 1] * math.sin(theta)
        arm_y = places[:, 1] * math.cos(theta) - places[:, 0] * math.sin(theta)
        along = -MU * push
        sinking = -(v + w * arm_x)
        deeper = np.where((depth >= state[6 : 6 + count]) & (depth > 0.0), np.maximum(sinking, 0.0), 0.0)
        spin = (arm_x * push - arm_y * along).sum() / TRUCK.inertia
        motion = (u, v, -w, along.sum() / TRUCK.mass, push.sum() / TRUCK.mass, spin)
        return np.concatenate([motion, deeper, push])

    initial = np.concatenate(
        [[start.x_g, start.y_g, start.theta, start.v_gx, start.v_gy, start.omega], np.zeros(2 * count)]
    )
    options: dict[str, Any] = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-10, "max_step": 2e-4}
    solution = solve_ivp(rates, (0.0, END), initial, dense_output=True, **options)

    def contacts(t: np.ndarray) -> np.ndarray:
        return np.array([pushes(column) for column in solution.sol(t).T]).transpose(1, 2, 0)

    return solution.y[6 + count :, -1], contacts


QUICK = {("plateau", 4), ("elastic", 6)}
ALL = [
    pytest.param(name, count, marks=[] if (name, count) in QUICK else pytest.mark.long)
    for name in LAWS
    for count in PLACES
]


@pytest.mark.parametrize(("name", "count"), ALL)
def test_strips_are_those_of_an_independent_integration(name, count):
    strips = tuple(Strip((at, at), LAWS[name](k), inset) for at, inset, k in PLACES[count])
    contact = WallContact(None, MU, strips)
    touch = first_touch(TRUCK, ANGLE, SPEED, contact=contact)
    motion = solve_impact(TRUCK, contact, touch, end=END, tolerance=1e-9)
    impulses, contacts = peer(strips, touch)
    names = dict.fromkeys(strike.corner for strike in motion.strikes)
    assert len(names) >= 2
    summed = [
        math.fsum(s.impulse for s in motion.strikes if s.corner == name) for name in group_names_of(contact)
    ]
    assert summed == pytest.approx(impulses, abs=1e-6 * impulses.max())
    for group, strip_name in enumerate(group_names_of(contact)):
        first = next((s for s in motion.strikes if s.corner == strip_name and not s.cut), None)
        if first is None:
            continue
        depth, push = contacts(np.linspace(first.start, first.end, 2001))
        assert first.peak_force == pytest.approx(push[group].max(), rel=2e-6)
        assert depth[group, 0] == pytest.approx(0.0, abs=1e-6)  # 2e-7 s at the speed of touch
        after = contacts(np.array([first.end - 5e-5 * first.duration, first.end + 5e-5 * first.duration]))[
            1, group
        ]
        assert after[0] > 0.0 == after[1]


def group_names_of(contact: WallContact) -> tuple[str, ...]:
    """Names of the strips on the side of the wall."""
    from solver.impact import group_names

    return group_names(contact, [TRUCK.length])[: len(contact.strips)]
