"""Verify unilateral contact of the FE plate by exact answers.

Bars strike a wall (Doyen, Ern and Piperno, SIAM J. Sci. Comput. 33, 2011; Code_Aster's SDNV100).
Body forces act in the tests only.
"""

import functools
import math
from typing import NamedTuple

import numpy as np
import pytest
from crushing_plates import TOUCH, truck_model
from scipy.integrate import quad
from scipy.optimize import brentq

from fem.explicit.impact_loop import ImpactMeasures
from fem.explicit.internal_force import scratch_for, subtract_internal_forces
from fem.laws.friction import Drag
from fem.model.impact_model import build_impact_model
from fem.plate.nodal_masses import prescribed_inertia_masses
from fem.plate.properties import (
    ContactProperties,
    Inertia,
    ModelError,
    PlateProperties,
    StepProperties,
    UnitProperties,
)
from fem.run.impact import FirstTouch, ImpactStepper, simulate_impact
from meshes import plate_mesh

HEAD_ON = math.pi / 2
TAU = 1.0 / 3.0
"""Time [s] of a wave through the bouncing bar: E = 900, rho = 1, L = 10."""
SMALL = 1e-4
"""Scale of gravity and height of the bouncing bar: its strains are then small, its times the same."""


def bar(elements, law, width=0.0, **plate):
    """A bar in one dimension, without lateral contraction."""
    values = {"thickness": 1.0, "density": 1.0, "youngs_modulus": 900.0, "length": 10.0, **plate}
    length = values.pop("length")
    properties = PlateProperties(poissons_ratio=0.0, lumping="row-sum", **values)
    mesh = plate_mesh(length, width or length / elements, (elements, 1))
    return build_impact_model(
        [UnitProperties(mesh, properties, ContactProperties(Drag(0.0), law))], StepProperties()
    )


class Bounce(NamedTuple):
    """Contact of a bouncing bar, relative to theory.

    Fields are the instants of contact over tau, the energy over the first, the mean force in the first contact over
    rho c (v0 + g t) with its noise, and the least force of the wall [N].
    """

    pressed: np.ndarray
    energy: np.ndarray
    force: float
    noise: float
    least: float

    def contact(self, begin, end):
        """First and last instant with force between these."""
        inside = self.pressed[(self.pressed > begin) & (self.pressed < end)]
        return float(inside[0]), float(inside[-1])


@functools.cache
def bounce(elements, law, periods):
    model = bar(elements, law)
    step, gravity = model.parameters.time_step, 10.0 * SMALL
    stepper = ImpactStepper(model)
    state = stepper.at_touch(FirstTouch(HEAD_ON, 0.0, 0.0))
    state.positions[1] += 5.0 * SMALL
    times, impulses, energies, least = [], [], [], 0.0
    for n in range(round(16.0 * TAU * periods / step)):
        state.velocities[1] -= gravity * step
        rows, _, state = stepper.record(state, 1, 1)
        values = dict(zip(ImpactMeasures._fields, rows[0], strict=False))
        times.append((n + 1) * step)
        impulses.append(values["normal_impulse"])
        least = min(least, state.contact.pushing.min())
        held = sum(values[name] for name in ("kinetic_energy", "strain_energy", "contact_energy"))
        energies.append(held + gravity * model.mass * values["y_g"])
    force, t = np.diff(impulses, prepend=0.0) / step, np.array(times) / TAU
    inside = (t > 3.2) & (t < 4.8)
    steady = force[inside] / (30.0 * gravity * TAU * t[inside] * 10.0 / elements)  # it falls from t = 0 on
    pressed = t[force > 1e-9 * force.max()]
    return Bounce(pressed, np.array(energies) / energies[0] - 1.0, steady.mean(), steady.std(), least)


@pytest.mark.parametrize("law", ["exact", "penalty"])
def test_a_bouncing_bar_touches_when_theory_says(law):
    bouncing = bounce(100, law, 2.0)
    for begin, end in ((3.0, 5.0), (11.0, 13.0)):
        assert bouncing.contact(begin - 1.5, end + 1.5) == pytest.approx((begin, end), rel=0.01)
    assert bouncing.least >= 0.0
    assert bouncing.force == pytest.approx(1.0, abs=2e-3)
    assert bouncing.noise < 0.03


@pytest.mark.parametrize("law", ["exact", "penalty"])
def test_the_end_of_its_contact_converges(law):
    errors = [abs(bounce(n, law, 0.4).contact(2.0, 6.0)[1] - 5.0) for n in (25, 50, 100)]
    order = math.log2(errors[0] / errors[-1]) / 2.0
    assert errors[-1] < 0.05
    assert 0.4 < order < 1.6  # a front is smeared over elements^(1/3) to elements


@pytest.mark.long
@pytest.mark.parametrize("law", ["exact", "penalty"])
def test_no_contact_gains_energy_over_ten_periods(law):
    energy = bounce(50, law, 10.0).energy
    assert energy.max() < 2e-6  # of the order of the ledger's own ripple; a plain penalty gains 2e-2
    assert energy[-1] < 1e-8 or law == "penalty"
    assert energy.min() > -2e-4


def strike(elements, law, speed, **plate):
    """A free bar that strikes the wall, and two wave times."""
    model = bar(elements, law, **plate)
    length = float(np.ptp(model.discretisation.positions[0]))
    wave = math.sqrt(plate.get("youngs_modulus", 900.0) / plate.get("density", 1.0))
    touch, until = FirstTouch(HEAD_ON, 0.0, -speed), 3.0 * length / wave
    return model, simulate_impact(model, touch, model.parameters.time_step, until), 2.0 * length / wave


@pytest.mark.parametrize("law", ["exact", "penalty"])
def test_a_bar_strikes_a_wall(law):
    speed, errors = 1e-3, []
    for elements in (50, 200):
        _, run, expected = strike(elements, law, speed)
        t, force = run.history["t"], run.history["force_normal"]
        pressure = force / (10.0 / elements)
        middle = (t > 0.1 * expected) & (t < 0.9 * expected)
        assert pressure[middle].mean() == pytest.approx(30.0 * speed, rel=2e-3)  # rho c v
        assert run.history["v_gy"][-1] == pytest.approx(speed, rel=0.015)
        errors.append(abs(t[force > 1e-3 * force.max()][-1] / expected - 1.0))
    assert errors[-1] < 0.01
    assert errors[-1] < 0.6 * errors[0] or errors[-1] < 0.006


SDNV100 = {"thickness": 0.02, "density": 8000.0, "youngs_modulus": 2e11, "length": 0.2, "width": 0.02}


@pytest.mark.parametrize("law", ["exact", "penalty"])
def test_code_aster_sdnv100(law):
    """The force is 1.6 MN for 80 us by linear theory.

    The modulus is 4 GPa, the speed 100 m/s; the bar is linear at a hundredth of this speed.
    """
    model, run, expected = strike(100, law, 1.0, **SDNV100)
    t, force = run.history["t"], run.history["force_normal"]
    assert expected == pytest.approx(80e-6)
    assert force[(t > 1e-5) & (t < 7e-5)].mean() == pytest.approx(1.6e6 / 100.0, rel=1e-3)
    assert t[force > 0.5 * force.max()][-1] == pytest.approx(80e-6, rel=0.01)
    assert force.sum() * t[1] == pytest.approx(2.0 * model.mass, rel=0.01)


def test_sdnv100_at_full_speed_follows_the_simple_wave_of_its_material():
    """The front spreads, as St. Venant-Kirchhoff softens in compression.

    v is the integral of the wave speed over the stretch, c^2 = E (3 F^2 - 1)/(2 rho), and the force is 1.5 % below
    linear theory at 2 % strain.
    """
    _, run, _ = strike(100, "exact", 100.0, **SDNV100)
    t, force = run.history["t"], run.history["force_normal"]

    def excess(stretch):
        return quad(lambda f: math.sqrt(2e11 * (3.0 * f * f - 1.0) / 2.0 / 8000.0), stretch, 1.0)[0] - 100.0

    stretch = brentq(excess, 0.9, 1.0)
    pressure = 0.5 * 2e11 * stretch * (1.0 - stretch**2)
    assert force[(t > 1e-5) & (t < 7e-5)].mean() == pytest.approx(pressure * 0.02**2, rel=1e-3)


def struck(model):
    """The whole impact of the truck."""
    return simulate_impact(model, TOUCH, 2e-4, 0.6)


def test_viscous_work_follows_the_trapezoidal_rule():
    """The power is that of velocities half a step back."""
    plate = PlateProperties(0.01, 7800.0, 200e9, 0.3)
    unit = UnitProperties(plate_mesh(1.0, 0.2, (4, 2)), plate, ContactProperties(Drag(0.3), "penalty"))
    model = build_impact_model([unit], StepProperties(bulk_viscosity=0.06))
    laws, stepper = model.parameters, ImpactStepper(model)
    state = stepper.at_touch(FirstTouch(0.0, 0.0, 0.0))
    state.positions[1] += 1.0
    state.positions[0] *= 1.001
    scratch, works, powers = scratch_for(laws.table), list[float](), list[float]()
    for _ in range(6):
        rows, _, state = stepper.record(state, 1, 1)
        works.append(dict(zip(ImpactMeasures._fields, rows[0], strict=False))["damping_work"])
        powers.append(
            subtract_internal_forces(
                state.positions, state.velocities, laws.viscosity, None, np.zeros_like(state.positions),
                laws.table, laws.material, scratch,
            )
        )  # fmt: skip
    steps = 0.5 * laws.time_step * (np.array(powers[:-1]) + powers[1:])
    assert min(powers) > 0.0
    np.testing.assert_allclose(-np.diff(works), steps, rtol=1e-10)


@pytest.mark.parametrize(("centre", "fraction"), [(3.0, 0.1), (3.4, 0.5), (2.0, 1.2), (3.0, 2.8)])
def test_prescribed_inertia_leaves_no_light_nodes(centre, fraction):
    """In the analytic centre m_0/m is linear in the moments."""
    length, width, mass = 6.0, 2.4, 1000.0
    plate = PlateProperties(0.01, 7800.0, 200e9, 0.3)
    unit = UnitProperties(plate_mesh(length, width, (20, 8)), plate, ContactProperties(Drag(0.3), "penalty"))
    x, y = build_impact_model([unit], StepProperties()).discretisation.positions
    uniform = np.full(x.size, mass / x.size)
    yaw_inertia = fraction * mass * (length**2 + width**2) / 12.0
    masses = prescribed_inertia_masses(np.array([x, y]), uniform, Inertia(centre, yaw_inertia))
    moments = np.array(
        [np.ones_like(x), x + centre, y - 0.5 * width, (x + centre) ** 2 + (y - 0.5 * width) ** 2]
    )
    assert moments @ masses == pytest.approx([mass, 0.0, 0.0, yaw_inertia], rel=1e-9, abs=1e-7 * mass)
    fitted = np.linalg.lstsq(moments.T, uniform / masses, rcond=None)[0] @ moments
    assert fitted == pytest.approx(uniform / masses, rel=1e-9)
    assert (masses / uniform).min() > 0.03
    with pytest.raises(ModelError, match="no positive nodal masses"):
        prescribed_inertia_masses(np.array([x, y]), uniform, Inertia(0.1, 1.2 * yaw_inertia / fraction))


def test_a_layer_along_the_sides_is_the_same_on_finer_meshes():
    runs = [struck(truck_model(elements=mesh, layered=2e5)) for mesh in ((20, 6), (40, 12))]
    peaks = [run.history["force_normal"].max() for run in runs]
    assert peaks[1] == pytest.approx(peaks[0], rel=2e-3)


def test_peaks_and_impulses_converge_with_the_mesh():
    """Both strikes of a soft plate converge with order 1.4 to 1.9.

    Its corners are spread over 2 m, on 20 x 6, 40 x 12 and 80 x 24 elements.
    """
    results = []
    for mesh in ((20, 6), (40, 12), (80, 24)):
        run = struck(truck_model(elements=mesh, modulus=2e9, patch_length=2.0))
        front, rear = run.normal[: round(0.2 / run.history["t"][1]), 0], run.normal[:, 1]
        results.append((front.max(), front.sum(), rear.max()))
    coarse, middle, fine = np.array(results)
    orders = np.log2(np.abs(coarse - middle) / np.abs(middle - fine))
    assert ((orders > 1.2) & (orders < 2.2)).all()
    assert np.abs(fine / middle - 1.0).max() < 1.2e-3
