"""Verification: damping of elastic velocities leaves rigid motion alone, closes the ledger, and costs no time step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from fem.explicit.elastic_damping import SUMS, ElasticDamping, damp, damped_time_step
from fem.run.corner import Stepper, simulate
from fem.start.rigid_state import RigidStart

START = RigidStart(0.26, 0.707, 25.053)


def cloud(seed: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions [m], velocities [m/s] and masses [kg] of 40 nodes."""
    random = np.random.default_rng(seed)
    positions = random.uniform(-10.0, 3.0, (2, 40))
    return positions, random.normal(size=(2, 40)), random.uniform(1.0, 9.0, 40)


def forces(positions: np.ndarray, velocities: np.ndarray, masses: np.ndarray, step: float = 0.0) -> Any:
    force = np.zeros_like(positions)
    law = ElasticDamping(50.0, float(masses.sum()))
    return force, damp(law, positions, velocities, masses, step, np.zeros(SUMS), force)


def test_forces_have_no_resultant_and_no_moment():
    positions, velocities, masses = cloud()
    for step in (0.0, 1e-2):
        force, _ = forces(positions, velocities + np.array([[25.0], [-3.0]]), masses, step)
        scale = np.abs(force).sum()
        assert scale > 1.0
        assert np.abs(force.sum(axis=1)).max() < 1e-13 * scale
        moment = (positions[0] * force[1] - positions[1] * force[0]).sum()
        assert abs(moment) < 1e-12 * scale


def test_rigid_motion_is_not_damped():
    """At the instant; and half a step back, where the field belongs to a body that has not turned so far."""
    positions, _, masses = cloud()
    spin, step = 0.9, 1e-2
    rigid = spin * np.array([-positions[1], positions[0]]) + [[25.0], [1.0]]
    assert np.abs(forces(positions, rigid, masses)[0]).max() < 1e-10
    turn = spin * step
    back = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    chord = (positions - back @ positions) / step
    without, with_lag = (np.abs(forces(positions, chord, masses, lag)[0]).max() for lag in (0.0, step))
    assert with_lag < 1e-4 * without


def test_what_is_elastic_is_damped_at_the_rate():
    """Velocities without momentum and spin: f = -c m v, and the power is -c times twice their kinetic energy."""
    positions, velocities, masses = cloud()
    law = ElasticDamping(1.0, float(masses.sum()))
    elastic = np.zeros_like(positions)
    damp(law, positions, velocities, masses, 0.0, np.zeros(SUMS), elastic)
    elastic /= -masses
    force, power = forces(positions, elastic, masses)
    np.testing.assert_allclose(force, -50.0 * masses * elastic, rtol=1e-11, atol=1e-11)
    assert power == pytest.approx(-50.0 * (masses * elastic**2).sum(), rel=1e-12)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("constraint", ["penalty", "exact"])
def test_ledger_and_momentum_close(plate_model, constraint, threads):
    """An unstressed start that is damped strongly; what the damping takes is what the plate has less."""
    model = plate_model(reaction="drag", elastic_rate=800.0, corner={"constraint": constraint})
    history = simulate(model, START, 0.384, kind="unstressed", threads=threads).history
    held = sum(history[name] for name in ("kinetic_energy", "strain_energy", "contact_energy"))
    balance = held - history["friction_work"] - history["damping_work"]
    assert np.abs(balance - balance[0]).max() < 1e-10 * held[0]
    gained = model.mass * (history["v_gy"] - history["v_gy"][0])
    assert np.abs(gained - history["normal_impulse"]).max() < 1e-13 * model.mass * 3.0
    work, vibration = history["damping_work"], history["vibration_energy"]
    assert work[0] == pytest.approx(0.0, abs=1e-12)
    assert -work[-1] > 1e-3
    assert vibration[-1] < 1e-4 * vibration.max()


def test_threads_compute_the_same(plate_model):
    model = plate_model(reaction="drag", elastic_rate=800.0)
    one, two = (Stepper(model, threads) for threads in (1, 2))
    start = one.start(START, "unstressed")
    states = [stepper.advance(start, 500) for stepper in (one, two)]
    np.testing.assert_allclose(states[0].velocities, states[1].velocities, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(states[0].sums, states[1].sums, rtol=1e-9, atol=1e-9)


def test_free_mode_decays_at_half_the_rate(plate_model):
    """A free plate in its lowest mode: the energy falls by exp(-c t), the frequency being far above c."""
    from fem.plate.elastic import free_modes

    rate = 20.0
    model = plate_model(corner={"penalty_scale": 1e-12}, elastic_rate=rate)
    stepper, mode = Stepper(model), free_modes(model, 1)
    state = stepper.start(RigidStart(0.26, 1e-6, 0.0), "unstressed")
    cosine, sine = math.cos(0.26), math.sin(0.26)
    state.velocities[:] = 1e-3 * np.array([[cosine, sine], [-sine, cosine]]) @ mode.shapes[0]
    energies, steps = [], 400
    for _ in range(30):
        row = stepper.measure(state)._asdict()
        energies.append(row["kinetic_energy"] + row["strain_energy"])
        state = stepper.advance(state, steps)
    slope = np.polyfit(steps * model.loop.time_step * np.arange(30), np.log(energies), 1)[0]
    assert slope == pytest.approx(-rate, rel=0.02)


def test_stable_step_with_damping():
    """One mode, its damping half a step late: bounded at the step, and not 1 % above it."""
    frequency, rate = 100.0, 60.0
    for factor, bounded in ((0.999, True), (1.01, False)):
        step, x, v = factor * damped_time_step(frequency, rate), 1.0, 0.0
        for _ in range(4000):
            v += step * (-(frequency**2) * x - rate * v)
            x += step * v
        assert (abs(x) < 10.0) is bounded
    assert damped_time_step(frequency, 0.0) == 2.0 / frequency


def test_without_it_there_is_no_code(plate_model):
    assert plate_model(reaction="drag").loop.elastic_damping is None
    assert plate_model(reaction="drag", elastic_rate=1.0).loop.elastic_damping.rate == 1.0
