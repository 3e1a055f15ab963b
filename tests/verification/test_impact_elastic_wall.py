"""Verify an elastic wall alone and in the whole impact.

Alone it is Hetenyi's beam on an elastic foundation (Beams on Elastic Foundation, 1946) and oscillates on its
foundation; in the impact momentum and energy balance, and the rigid wall is its limit.
"""

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from crushing_plates import ANGLE, MASS, SPEED, TOUCH, truck_model

from fem.explicit.impact_loop import ImpactMeasures
from fem.plate.properties import (
    ModelError,
    WallProperties,
)
from fem.run.impact import FirstTouch, ImpactStepper, simulate_impact
from meshes import wall_mesh

DEPTH, MODULUS = 0.3, 24.82e9
BENDING = MODULUS * DEPTH**3 / 12.0
"""EI [N m^2] of a concrete parapet 0.3 m deep and 1 m high."""


def concrete(foundation, elements=60, length=36.0, start=-12.0):
    mesh = wall_mesh(start, length, DEPTH, (elements, 1))
    return WallProperties(mesh, 1.0, 2400.0, MODULUS, 0.2, foundation)


def wave_number(foundation):
    """Hetenyi's b [1/m]."""
    return (foundation / (4.0 * BENDING)) ** 0.25


@functools.cache
def truck(foundation, law="crush", layered=0.0):
    """The whole impact on the parapet, rigid for an infinite foundation."""
    wall = None if math.isinf(foundation) else concrete(foundation)
    model = truck_model(law, layered=layered, wall=wall)
    return model, simulate_impact(model, TOUCH, 2e-4, 0.6)


def static(foundation, elements, length=48.0):
    """Positions along the face, and displacements under a force of 1 N."""
    wall = truck_model(wall=concrete(foundation, elements, length, -0.5 * length)).parameters.wall
    places = wall.start + wall.spacing * np.arange(wall.face.shape[1])
    middle = int(np.abs(places).argmin())
    return places, wall.face @ (-wall.face[1, middle] / wall.stiffness)


SLENDER = 4.0 * BENDING / 4.0**4
"""Foundation for b = 1/4 per m, 0.075 over the depth: shear and the dent under the force are then below 1 %."""


def test_a_point_force_deflects_the_wall_as_hetenyi_says():
    places, (_, y) = static(SLENDER, 48)
    b, x = wave_number(SLENDER), np.abs(places)
    exact = b / (2.0 * SLENDER) * np.exp(-b * x) * (np.cos(b * x) + np.sin(b * x))
    assert b == pytest.approx(0.25)
    assert np.abs(-y - exact).max() < 0.01 * exact.max()
    assert -y.min() == pytest.approx(b / (2.0 * SLENDER), rel=0.01)


def test_its_face_is_strained_by_hetenyis_moment():
    places, (x, _) = static(SLENDER, 96)
    b, middle = wave_number(SLENDER), 0.5 * (places[1:] + places[:-1])
    moment = -np.diff(x) / np.diff(places) * BENDING / (0.5 * DEPTH)
    exact = np.exp(-b * middle) * (np.cos(b * middle) - np.sin(b * middle)) / (4.0 * b)
    beside = (middle > 2.0 * DEPTH) & (middle < 15.0)
    assert np.abs(moment - exact)[beside].max() < 0.01 / (4.0 * b)
    fitted = moment[beside] @ exact[beside] / (exact[beside] @ exact[beside])
    assert fitted == pytest.approx(1.0, rel=0.01)  # P/(4b) of the whole course


def test_the_deflection_converges_with_the_mesh():
    deflections = []
    for elements in (12, 24, 48):
        places, (_, y) = static(SLENDER, elements)
        deflections.append(y[np.abs(places - 4.0).argmin()])
    order = math.log2(abs((deflections[0] - deflections[1]) / (deflections[1] - deflections[2])))
    assert order > 2.0
    assert deflections[2] == pytest.approx(deflections[1], rel=0.02)


def test_modes_that_the_step_leaves_out_hardly_deflect():
    """A soft plate omits modes, a stiff one does not."""

    def deflection(modulus):
        """Deflection by 1 N, and the ratio of highest and foundation frequency."""
        wall = truck_model(wall=concrete(1e8, 72), modulus=modulus).parameters.wall
        below = float((wall.face[1, wall.face.shape[1] // 3] ** 2 / wall.stiffness).sum())
        return below, math.sqrt(wall.stiffness[-1] / wall.foundation)

    (some, followed), (every, highest) = deflection(1e8), deflection(200e12)
    assert followed == pytest.approx(40.0, rel=0.01)
    assert highest > 100.0
    assert some == pytest.approx(every, rel=0.01)


def test_the_wall_swings_on_its_foundation():
    """A uniform velocity V leads to V/w0 sin(w0 t) everywhere.

    w0^2 is k' over the mass per length.
    """
    model = truck_model(wall=concrete(1e8))
    wall, stepper = model.parameters.wall, ImpactStepper(model)
    state = stepper.at_touch(FirstTouch(0.0, 0.0, 0.0))
    state.positions[1] += 5.0
    assert state.wall is not None
    masses = wall.momentum @ wall.momentum.T
    assert masses == pytest.approx(2400.0 * DEPTH * 36.0 * np.eye(2), rel=1e-9, abs=1e-6)
    frequency, speed = math.sqrt(1e8 / (2400.0 * DEPTH)), -0.3
    state.wall.rate[:] = speed * wall.momentum[1]
    count = round(0.5 * math.pi / frequency / model.parameters.time_step)
    last = dict(zip(ImpactMeasures._fields, stepper.record(state, count, 1).rows[0], strict=False))
    assert last["wall_deflection"] == pytest.approx(-speed / frequency, rel=1e-3)
    assert last["wall_energy"] == pytest.approx(0.5 * masses[1, 1] * speed**2, rel=1e-3)
    assert last["foundation_impulse"] == pytest.approx(-masses[1, 1] * speed, rel=0.02)
    assert np.ptp(wall.face[1] @ state.wall.amplitude) < 1e-9 * -speed / frequency


CASES: dict[str, dict[str, Any]] = {
    "crush": {}, "layer": {"layered": 2e5}, "penalty": {"law": "penalty"}, "exact": {"law": "exact"},
}  # fmt: skip
COMPILED_APART = {"penalty", "exact"}
"""Cases with a compiled loop of their own."""
GAINED = {"exact": 2e-5, "penalty": 2e-5, "layer": 5e-6}
LOST = {"exact": 2e-3}
"""Fraction of the energy in light nodes on touching, and in waves that the step does not resolve."""


EACH_CASE = pytest.mark.parametrize(
    "case", [pytest.param(c, marks=pytest.mark.long) if c in COMPILED_APART else c for c in CASES]
)


@EACH_CASE
def test_energy_of_plate_and_wall(case):
    _, run = truck(1e8, **CASES[case])
    h = run.history
    names = ("kinetic_energy", "strain_energy", "contact_energy", "crush_energy", "wall_energy")
    balance = sum(h[name] for name in names) - h["friction_work"]
    balance = (balance - balance[0]) / (0.5 * MASS * SPEED**2)
    assert balance.max() < GAINED.get(case, 1e-6)
    assert balance.min() > -LOST.get(case, 1e-6)
    assert run.normal.min() >= 0.0


@EACH_CASE
def test_momentum_of_plate_and_wall_is_what_the_foundation_gives(case):
    model, _ = truck(1e8, **CASES[case])
    stepper, wall = ImpactStepper(model), model.parameters.wall
    state: Any = stepper.at_touch(TOUCH)
    start = state.velocities @ model.parameters.mass
    for _ in range(6):
        state = stepper.record(state, 1000, 1).state
        gained = state.velocities @ model.parameters.mass + wall.momentum @ state.wall.rate - start
        assert np.abs(gained - state.wall.impulse).max() < 1e-9 * MASS * SPEED
    assert np.abs(state.wall.impulse).min() > 0.05 * MASS * SPEED * math.sin(ANGLE)


def heavier(scale):
    """Peak and impulse on a wall of scaled stiffness and mass."""
    wall = concrete(1e9)
    names = ("density", "youngs_modulus", "foundation_stiffness")
    wall = replace(wall, **{name: scale * getattr(wall, name) for name in names})
    return first_strike(wall)


def first_strike(wall):
    """Peak and impulse of the first strike on a wall."""
    model = truck_model(wall=wall, longest=3.5e-5)
    force = simulate_impact(model, TOUCH, 2e-4, 0.12).history["force_normal"]
    return float(force.max()), float(force.sum())


def test_a_stiff_wall_approaches_the_rigid_one_at_first_order():
    strikes = np.array([heavier(scale) for scale in (4.0, 8.0, 16.0)])
    off = np.abs(strikes / first_strike(None) - 1.0)
    assert off[-1].max() < 2e-4
    assert np.log2(off[:-1] / off[1:]) == pytest.approx(1.0, abs=0.01)


def first_peak(foundation):
    run = truck(foundation)[1]
    return float(run.history["force_normal"][run.history["t"] < 0.14].max())


def test_a_softer_wall_lowers_the_peak():
    """Wall and crush are springs in series.

    The stiffness is k over 1 + k b/(2 k').
    """
    rigid = first_peak(math.inf)
    for foundation in (1e8, 1e7):
        series = 1.0 + 2e6 * wave_number(foundation) / (2.0 * foundation)
        assert first_peak(foundation) / rigid == pytest.approx(1.0 / math.sqrt(series), rel=3e-3)
    assert first_peak(1e6) < 0.85 * rigid


def test_figures_of_a_concrete_parapet():
    """The first strike has Hetenyi's deflection, the third is a blow."""
    h = truck(1e8)[1].history
    first, force, foundation = h["t"] < 0.09, h["force_normal"], h["force_foundation"]
    deflection = h["wall_deflection"]
    assert deflection[first].max() == pytest.approx(force[first].max() * wave_number(1e8) / 2e8, rel=0.05)
    assert deflection.max() == pytest.approx(3.7e-3, rel=0.03)
    assert h["wall_deflection_place"][deflection.argmax()] == pytest.approx(11.0, abs=0.5)
    assert foundation[first].max() / force[first].max() == pytest.approx(1.06, abs=0.03)
    assert foundation.max() / force.max() == pytest.approx(1.78, abs=0.05)
    # It oscillates on: its impulse is at most a percent or two of that of the contact.
    assert h["foundation_impulse"][-1] == pytest.approx(h["normal_impulse"][-1], rel=0.03)


def test_a_rigid_wall_has_no_part_in_the_record():
    model, run = truck(math.inf)
    assert model.parameters.wall is None
    assert ImpactStepper(model).at_touch(TOUCH).wall is None
    for name in ("wall_energy", "wall_deflection", "wall_deflection_place", "foundation_impulse"):
        assert not run.history[name].any()


def test_a_plate_that_leaves_the_wall_ends_the_run():
    model = truck_model(wall=concrete(1e8, 20, 12.0, -11.0))
    with pytest.raises(ModelError, match="beyond the end of the wall") as fault:
        simulate_impact(model, TOUCH, 2e-4, 0.6)
    assert fault.value.wrong == "wall.length"


@pytest.mark.parametrize(("foundation", "elements", "message", "key"), [
    *((foundation, 60, "must be above 0", "wall.foundation_stiffness") for foundation in (0.0, -1.0)),
    (1e8, 400, "unknowns", "wall.elements"),
])  # fmt: skip
def test_a_wall_without_a_foundation_or_of_too_many_elements_is_refused(foundation, elements, message, key):
    with pytest.raises(ModelError, match=message) as fault:
        truck_model(wall=concrete(foundation, elements))
    assert fault.value.wrong == key
