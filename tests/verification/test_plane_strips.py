"""Verify three, four and six strips by an independent integration."""

import math

import numpy as np
import plane_reference
import pytest

from solver.impact import (
    CrushLaw,
    ImpactVehicle,
    Strip,
    TyreAxle,
    WallContact,
    first_touch,
    group_names,
    solve_impact,
)
from solver.impact.solve import loads_at_rest

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
    "initial force": lambda k: CrushLaw(k, 0.02 * k, 0.3, 0.15 * k),
}
PLACES = {  # behind the front, inwards from the side [m], stiffness [N/m]
    3: [(0.0, 0.0, 2e6), (7.2, 0.0, 1.2e6), (10.0, 0.0, 1.5e6)],
    4: [(0.3, 0.05, 2e6), (1.3, 0.0, 0.8e6), (7.2, 0.1, 1.2e6), (9.4, 0.0, 1.5e6)],
    6: [(0.0, 0.02, 1e6), (0.8, 0.0, 1e6), (4.0, 0.0, 0.5e6), (6.6, 0.08, 0.9e6), (7.8, 0.08, 0.9e6), (9.9, 0.0, 2e6)],
}  # fmt: skip


TYRES = (TyreAxle(1.3, 0.7, 6.0), TyreAxle(7.5, 0.6, 5.0))
QUICK = [("elastic", 6, ()), ("plateau", 4, TYRES)]
LONG = [(name, count, ()) for name in LAWS for count in PLACES] + [
    (name, 3, TYRES) for name in ("plateau, slope", "initial force")
]


@pytest.mark.parametrize(
    ("name", "count", "axles"),
    [*QUICK, *(pytest.param(*case, marks=pytest.mark.long) for case in LONG if case not in QUICK)],
)
def test_strips_are_those_of_an_independent_integration(name, count, axles):
    strips = tuple(Strip((at, at), LAWS[name](k), inset) for at, inset, k in PLACES[count])
    contact = WallContact(None, MU, strips)
    touch = first_touch(TRUCK, ANGLE, SPEED, contact=contact)
    motion = solve_impact(TRUCK, contact, touch, end=END, tolerance=1e-8, axles=axles)
    loads = loads_at_rest(TRUCK, contact, axles=axles) if axles else ()
    _, impulses, contacts = plane_reference.integrated(TRUCK, touch, END, strips, MU, axles, loads)
    assert len({strike.corner for strike in motion.strikes}) >= 2
    names = group_names(contact, [TRUCK.length])[: len(strips)]  # on the side of the wall
    summed = [math.fsum(s.impulse for s in motion.strikes if s.corner == name) for name in names]
    assert summed == pytest.approx(impulses, abs=1e-6 * impulses.max())
    for group, strip_name in enumerate(names):
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
