"""Verify damping of elastic velocities, and growth by friction.

Damping does not change rigid motion, the energy balance or the time step. Growth by the Nyquist criterion agrees with
eigenvalues and with the time loop.
"""

import math

import numpy as np
import pytest

from fem.explicit.elastic_damping import SUMS, ElasticDamping, damp, damped_time_step
from fem.laws.constraints import Exact
from fem.laws.friction import friction_slope
from fem.plate.discretisation import stiffness_matrix
from fem.run.corner import Stepper, simulate
from fem.stability import flutter
from fem.start.inertia_relief import RigidStart, to_global
from tailslap.case.corner import corner_case, decisions
from tailslap.case.corner.decisions import REQUIRED_DAMPING
from tailslap.scene.read import read_scene

START = RigidStart(0.26, 0.707, 25.053)


def cloud(seed=3):
    """Positions [m], velocities [m/s] and masses [kg] of 40 nodes."""
    random = np.random.default_rng(seed)
    positions = random.uniform(-10.0, 3.0, (2, 40))
    return positions, random.normal(size=(2, 40)), random.uniform(1.0, 9.0, 40)


def forces(positions, velocities, masses, step=0.0):
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
    """The lag of half a step is in the field."""
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
    """Velocities without momentum and spin have f = -c m v."""
    positions, velocities, masses = cloud()
    law = ElasticDamping(1.0, float(masses.sum()))
    elastic = np.zeros_like(positions)
    damp(law, positions, velocities, masses, 0.0, np.zeros(SUMS), elastic)
    elastic /= -masses
    force, power = forces(positions, elastic, masses)
    np.testing.assert_allclose(force, -50.0 * masses * elastic, rtol=1e-11, atol=1e-11)
    assert power == pytest.approx(-50.0 * (masses * elastic**2).sum(), rel=1e-12)


@pytest.mark.parametrize(("constraint", "threads"), [("penalty", 1), ("exact", 1), ("exact", 2)])
def test_ledger_and_momentum_close(plate_model, constraint, threads):
    """Energy and momentum are balanced with strong damping."""
    model = plate_model(reaction="drag", elastic_rate=800.0, corner={"constraint": constraint})
    history = simulate(model, START, 0.384, kind="unstressed", threads=threads).history
    energy = np.sum([history[name] for name in ("kinetic_energy", "strain_energy", "contact_energy")], axis=0)
    balance = energy - history["friction_work"] - history["damping_work"]
    assert np.abs(balance - balance[0]).max() < 1e-10 * energy[0]
    change = model.mass * (history["v_gy"] - history["v_gy"][0])
    assert np.abs(change - history["normal_impulse"]).max() < 1e-13 * model.mass * 3.0
    work, vibration = history["damping_work"], history["vibration_energy"]
    assert work[0] == pytest.approx(0.0, abs=1e-12)
    assert -work[-1] > 1e-3
    assert vibration[-1] < 1e-4 * vibration.max()


@pytest.mark.parametrize(("element", "steps"), [("quad4", 500), ("quad4-reduced", 500), ("quad9", 100)])
def test_threads_compute_the_same(plate_model, element, steps):
    model = plate_model(reaction="drag", plate={"element": element}, elastic_rate=800.0)
    one, two = (Stepper(model, threads) for threads in (1, 2))
    start = one.start(START, "unstressed")
    states = [stepper.advance(start, steps) for stepper in (one, two)]
    np.testing.assert_allclose(states[0].velocities, states[1].velocities, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(states[0].sums, states[1].sums, rtol=1e-9, atol=1e-9)


def test_free_mode_decays_at_half_the_rate(plate_model):
    """The energy of the lowest free mode decreases by exp(-c t)."""
    from fem.plate.free_modes import free_modes

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
    slope = np.polyfit(steps * model.parameters.time_step * np.arange(30), np.log(energies), 1)[0]
    assert slope == pytest.approx(-rate, rel=0.02)


def test_stable_step_with_damping():
    """Damping half a step late is bounded at the step, not above."""
    frequency, rate = 100.0, 60.0
    for factor, bounded in ((0.999, True), (1.01, False)):
        step, x, v = factor * damped_time_step(frequency, rate), 1.0, 0.0
        for _ in range(4000):
            v += step * (-(frequency**2) * x - rate * v)
            x += step * v
        assert (abs(x) < 10.0) is bounded
    assert damped_time_step(frequency, 0.0) == 2.0 / frequency


DURATION = 0.384


def growth_rates(model, angle, ratio=0.0):
    """Rates [1/s] of all modes by dense eigenvalues, with damping."""
    corner, masses, nodes = model.parameters.corner, model.parameters.mass, model.parameters.mass.size
    along, across = to_global(angle)
    spread = np.zeros(nodes)
    spread[corner.nodes] = corner.weights
    root = 1.0 / np.sqrt(np.tile(masses, 2))
    gap = np.kron(across, spread) * root
    push = gap + friction_slope(model.parameters.friction, START.corner_speed) * np.kron(along, spread) * root
    plate = root[:, None] * model.stiffness.toarray() * root
    stiffness = plate.copy()
    if isinstance(corner.constraint, Exact):
        stiffness -= np.outer(push, gap @ plate) / (gap @ push)
    else:
        stiffness += corner.stiffness * np.outer(push, gap)
    damping = np.outer(push, gap) * getattr(corner.constraint, "damping", 0.0)
    if ratio:
        viscous = stiffness_matrix(model.discretisation.table, model.parameters.viscosity)
        damping += root[:, None] * viscous.toarray() * root
    size = 2 * nodes
    system = np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -damping]])
    values = np.linalg.eigvals(system)
    return values.real[np.abs(values.imag) > 1e-3 * np.abs(values.imag).max()]


CORNERS = {
    **{"penalty": {"penalty_scale": 3.0}, "dashpot": {"penalty_scale": 3.0, "damping_ratio": 0.2}},
    **{"exact": {"constraint": "exact"}, "patch": {"patch_length": 3.0}},
}


@pytest.mark.parametrize("corner", CORNERS)
@pytest.mark.parametrize("ratio", [0.0, 0.002])
def test_number_of_growing_modes_is_that_of_the_eigenvalues(plate_model, corner, ratio):
    """The criterion counts the modes of larger real part."""
    model = plate_model((10, 3), "drag", corner=CORNERS[corner], damping_ratio=ratio)
    modes, slope = flutter.corner_modes(model), friction_slope(model.parameters.friction, START.corner_speed)
    viscous = 0.5 * model.parameters.viscosity.c_33 / model.tangent_moduli.c_33 if ratio else 0.0
    constraint, seen = model.parameters.corner.constraint, 0
    for angle in (0.26, 0.1, 0.0):
        rates = growth_rates(model, angle, ratio)
        along, across = to_global(angle) @ modes.corner
        residues = across * (across + slope * along)
        residues[2], squares = residues[:3].sum(), modes.squares.copy()
        squares[2] = 0.0
        stiffness = getattr(constraint, "stiffness", np.inf)
        top = 1.5 * flutter.highest_mode(squares, residues[2:], stiffness)
        for rate in (0.01, 0.3, 3.0, 10.0, 30.0, 100.0, 300.0):
            if np.abs(rates - rate).min() < 0.02 * rate:
                continue  # too close to decide
            counted = flutter.growing_modes(
                squares[2:], residues[2:], stiffness, getattr(constraint, "damping", 0.0), viscous, rate, top
            )
            expected = int((rates > rate).sum())
            assert counted == expected, (angle, rate)
            seen += expected
    assert seen > 0 or ratio > 0.0 or corner == "patch"


@pytest.mark.parametrize("corner", CORNERS)
def test_rates_are_the_first_ones_without_growing_modes(plate_model, corner):
    """Each trial rate is counted in turn."""
    model = plate_model((10, 3), "drag", corner=CORNERS[corner])
    slope, constraint = friction_slope(model.parameters.friction, START.corner_speed), model.parameters.corner
    modes, least, rates = flutter.corner_modes(model), 1.0, np.empty(3)
    squares, stiffness = np.append(0.0, modes.squares[3:]), (constraint.stiffness, constraint.dashpot, 0.0)
    residues = flutter.residues_at(modes, (0.26, 0.1, 0.0), slope)
    flutter.least_rates(squares, residues, *stiffness, least, rates)
    for at_angle, rate in zip(residues, rates, strict=True):
        top, number = 1.5 * flutter.highest_mode(squares, at_angle, constraint.stiffness), 0
        trial = least * (1.0 + 1e-9)
        while flutter.growing_modes(squares, at_angle, *stiffness, trial, top):
            number, trial = number + 1, trial * flutter.RATE_RATIO
        assert rate == pytest.approx(number and least * flutter.RATE_RATIO**number, rel=1e-12)
    assert rates.max() > least or corner == "patch"


@pytest.mark.parametrize("slower", [1.0, 1e-4, 1e-9])
def test_steps_along_the_line_grow_with_the_modes_alone(plate_model, monkeypatch, slower):
    """The number of steps is bounded for any rate."""
    model, evaluations = plate_model((10, 3), "drag", corner=CORNERS["penalty"]), []
    modes, plain = flutter.corner_modes(model), flutter._response.py_func

    def counted(*arguments):
        evaluations.append(1)
        return plain(*arguments)

    monkeypatch.setattr(flutter, "_response", counted)
    squares, residues = np.append(0.0, modes.squares[3:]), modes.corner[1, 2:] ** 2
    stiffness = model.parameters.corner.stiffness
    top = flutter.highest_mode(squares, residues, stiffness)
    flutter.growing_modes.py_func(squares, residues, stiffness, 0.0, 0.0, 100.0 * slower, top)
    assert len(evaluations) < squares.size * (40.0 - 20.0 * math.log10(slower))


@pytest.mark.long
def test_rate_is_the_least_tried_that_no_mode_outgrows(plate_model):
    model = plate_model(reaction="drag", corner={"constraint": "exact"})
    prediction = flutter.predict_flutter(model, START, DURATION)
    angles = np.linspace(START.angle, 0.0, flutter.INSTANTS)
    fastest = max(growth_rates(model, angle).max() for angle in angles)
    assert fastest < prediction.rate <= 1.01 * flutter.RATE_RATIO * fastest


def test_disturbance_grows_in_the_time_loop_as_foreseen(plate_model):
    """A stiff plate grows at the predicted rate, and decays when damped."""
    stiff = {"plate": {"youngs_modulus": 2e15}, "corner": {"penalty_scale": 3.0}, "safety_factor": 0.45}
    model = plate_model(reaction="drag", **stiff)
    fastest = growth_rates(model, 0.255).max()
    assert measured_rate(model, 1e-9, slice(24, 40)) == pytest.approx(fastest, rel=0.1)
    damped = plate_model(reaction="drag", elastic_rate=REQUIRED_DAMPING * fastest, **stiff)
    slowest = (0.5 * REQUIRED_DAMPING - 1.0) * fastest
    assert -4.0 * slowest < measured_rate(damped, 1e-6, slice(2, 10)) < -0.9 * slowest


def measured_rate(model, size, calls):
    """Growth rate [1/s] of a plate with random velocities [m/s]."""
    stepper = Stepper(model)
    state = stepper.start(START, "inertia-relief")
    noise = size * np.random.default_rng(4).normal(size=state.positions.shape)
    state = state._replace(velocities=state.velocities + noise)
    energies, instants = [], 1000 * model.parameters.time_step * np.arange(calls.stop)
    for _ in instants:
        state = stepper.advance(state, 1000)
        energies.append(stepper.measure(state).vibration_energy)
    return float(0.5 * np.polyfit(instants[calls], np.log(energies[calls]), 1)[0])


@pytest.mark.parametrize(("changes", "flutters"), [
    ((), False), (("impact.friction=0.8", "corner.penalty_scale=3"), True),
    (("plate.youngs_modulus=20 TPa", "corner.penalty_scale=3"), True),
    (("corner.constraint=exact", "plate.youngs_modulus=20 TPa"), True),
])  # fmt: skip
def test_flutter_is_foreseen_and_suppressed(outcome, changes, flutters):
    """Without damping the run fails, by default it is damped."""
    forbidden = outcome("paper-table-3", *changes, "damping.kind=none")
    assert forbidden.passed is not flutters
    free = outcome("paper-table-3", *changes)
    assert (free.fe_plan.model.parameters.elastic_damping is not None) is flutters
    assert free.passed
    assert max(map(abs, free.difference.values())) < 5e-6


def test_without_friction_nothing_grows(plate_model):
    assert flutter.predict_flutter(plate_model(reaction="none"), START, DURATION).growth == 0.0


def test_only_meshes_that_can_be_analysed_are_made(monkeypatch):
    """Of the coarser meshes of a large one."""
    counts: list[int] = []
    plain = decisions.static_model

    def counted(plan, plate, mesh):
        counts.append(plate.elements)
        return plain(plan, plate, mesh)

    monkeypatch.setattr(decisions, "static_model", counted)
    plan = corner_case.CornerCase(*read_scene("paper-table-3", ("plate.elements=[400, 120]",)))
    models = list(decisions._coarser_models(plan, plan.scene.needed_plate, flutter.MAX_UNKNOWNS))
    assert [2 * model.parameters.mass.size <= flutter.MAX_UNKNOWNS for model in models] == [True, True]
    assert counts == [(35, 10), (23, 7)]  # (53, 15) has 1 728 unknowns


@pytest.mark.long
def test_coarser_meshes_stand_in_for_a_large_one():
    """Their rates, with the margin, are above those of the mesh itself."""
    stiff = ("corner.constraint=exact", "impact.friction=0.8")
    changes = (*stiff, "plate.element=quad4", "plate.elements=[40, 14]")
    plan = corner_case.CornerCase(*read_scene("mash-tl4-sut", changes)).plan()
    assert plan.growth.by_coarser
    angles = np.linspace(plan.start.angle, 0.0, 3)
    assert plan.growth.rate > max(growth_rates(plan.model, angle).max() for angle in angles)
