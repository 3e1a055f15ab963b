"""Verify FE runs by exact motion, conservation and orders."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BarycentricInterpolator

from fem.explicit.internal_force import scratch_for, subtract_internal_forces
from fem.explicit.time_loop import State
from fem.run.corner import Stepper, simulate
from fem.start import inertia_relief

# physics.md section 3, derived in closed form; the solver's own tests hold it to these as well.
ORACLES = {
    "drag": (0.3839597401, 23.2733311090, -3.2755267205, 0.6551053441, 9.4236754419),
    "none": (0.3831252875, 23.3113534750, -3.2868596947, 0.6573719389, 9.4126003049),
    "signed": (0.3819894684, 23.3618493051, -3.3020660056, 0.6604132011, 9.3974582232),
}
START = inertia_relief.RigidStart(0.26, 0.707, 25.053)


@pytest.mark.parametrize("reaction", ORACLES)
def test_the_shipped_plate_against_the_oracles(outcome, reaction):
    """The difference of 2e-6 on v_GY is the flexibility of steel."""
    result = outcome("paper-table-3", f"corner.reaction={reaction}")
    values = [result.fe[name] for name in ("t", "v_gx", "v_gy", "omega", "slide")]
    np.testing.assert_allclose(values, ORACLES[reaction], rtol=5e-6)
    assert result.passed


@pytest.mark.parametrize("reaction", ["drag", "none"])
def test_the_difference_is_flexibility_and_falls_with_one_over_e(outcome, reaction):
    moduli = np.array([2e9, 2e10, 2e11, 2e12])
    worst = []
    for modulus in moduli:
        held = ("plate.element=quad4", "corner.constraint=penalty", f"corner.reaction={reaction}")
        result = outcome("paper-table-3", *held, f"plate.youngs_modulus={modulus}")
        worst.append(max(map(abs, result.difference.values())))
    slope = np.polyfit(np.log(moduli), np.log(worst), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.02)
    assert worst[-1] < 5e-7


@pytest.mark.long
def test_row_sum_masses_converge_with_the_square_of_the_element(outcome):
    """The error of the rotary inertia is of order h^2."""
    change = ("corner.reaction=none", "plate.lumping=row-sum")
    worst = []
    for n in (10, 20, 40):
        result = outcome("paper-table-3", *change, f"plate.elements=[{n}, {3 * n // 10}]")
        worst.append(max(map(abs, result.difference.values())))
    orders = np.log2(np.divide(worst[:-1], worst[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.1)
    assert worst[1] < 2e-4


def test_a_coarse_mesh_with_exact_masses_is_as_good(outcome):
    result = outcome("paper-table-3", "corner.reaction=none", "plate.elements=[4, 2]")
    assert max(map(abs, result.difference.values())) < 5e-6


@pytest.mark.parametrize("rows", [7, 40])
def test_the_strike_is_on_the_cubic_through_the_last_four_steps(plate_model, rows):
    """The number of steps between rows does not change it."""
    model = plate_model((4, 2), "drag", plate={"youngs_modulus": 2e9})
    run, stepper = simulate(model, START, 0.384, rows=rows), Stepper(model)
    states = [stepper.advance(stepper.start(START, "inertia-relief"), run.steps - 3)]
    for _ in range(4):
        states.append(stepper.advance(states[-1], 1))
    angles = np.array([stepper.record(state, 0, 1).rows[0, 0] for state in states[:4]])
    assert angles[1] > 0.0 >= angles[2]
    steps = run.steps + np.arange(-3.0, 1.0)
    instant = float(BarycentricInterpolator(angles, steps)(0.0)) * model.parameters.time_step
    assert run.strike is not None
    assert run.strike.values["t"] == pytest.approx(instant, rel=1e-14)
    velocities = [0.5 * (state.velocities + later.velocities) for state, later in pairwise(states)]
    expected = BarycentricInterpolator(angles, velocities)(0.0)
    assert run.strike.velocities == pytest.approx(expected, rel=0.0, abs=1e-11)


def test_damping_takes_energy_out_and_the_ledger_says_how_much(outcome):
    result = outcome("paper-table-3", "damping.ratio=0.2", "plate.start=unstressed", "corner.reaction=none")
    work, vibration = result.fe_history["damping_work"], result.fe_history["vibration_energy"]
    assert work[0] == 0.0
    assert (np.diff(work) < 0.0).all()
    assert -work[-1] > 5.0 * vibration[-1] > 0.0
    assert np.abs(result.fe_history["energy_error"]).max() < 1e-9 * result.fe_history["kinetic_energy"][0]


def test_viscous_work_follows_the_trapezoidal_rule(plate_model):
    """Its power is that of the velocities half a step back."""
    model = plate_model(elements=(6, 2), bulk_viscosity=0.06)
    laws, table = model.parameters, model.parameters.table
    stepper, scratch = Stepper(model), scratch_for(table)
    states = [stepper.advance(stepper.start(START, "unstressed"), 20)]
    states.append(stepper.advance(states[0], 1))
    powers = [
        subtract_internal_forces(
            at.positions, at.velocities, laws.viscosity, None, np.zeros_like(at.positions), table,
            laws.material, scratch,
        )
        for at in states
    ]  # fmt: skip
    before, after = (stepper.measure(state).damping_work for state in states)
    assert min(powers) > 0.0
    assert before - after == pytest.approx(0.5 * laws.time_step * sum(powers), rel=1e-10)


def test_the_whole_history_follows_the_rigid_motion(outcome):
    result = outcome("paper-table-3")
    names = ("theta", "omega", "v_gx", "v_gy", "slide", "v_p", "reaction_normal", "reaction_tangential")
    for name in (*names, "friction_work"):
        fe, rigid = result.fe_history[name], result.rigid_history[name]
        assert np.abs(fe - rigid).max() < 1e-4 * np.abs(rigid).max(), name


@pytest.mark.parametrize(("key", "values", "tolerance"), [
    ("time.safety_factor", (0.45, 0.9), 2e-8), ("time.rows", (37, 400), 1e-12),
])  # fmt: skip
def test_the_answer_does_not_depend_on_step_and_rows(key, values, tolerance, outcome):
    first, second = (outcome("paper-table-3", f"{key}={value}").fe for value in values)
    for name, value in second.items():
        assert first[name] == pytest.approx(value, rel=tolerance)


def test_a_free_plate_flies_straight_and_turns_evenly(plate_model):
    """Without the spring theta = theta_0 - omega t to rounding."""
    model = plate_model(corner={"penalty_scale": 1e-30})
    stepper = Stepper(model)
    first = stepper.start(START, "unstressed")
    rows = [stepper.measure(stepper.advance(first, n))._asdict() for n in (0, 5000)]
    for name in ("v_gx", "v_gy"):
        assert rows[1][name] == pytest.approx(rows[0][name], rel=1e-12)
    # Turning stretches the plate by about rho omega^2 L^2 / E, 2e-6: set off unstretched, it rings by that.
    assert rows[1]["omega"] == pytest.approx(0.707, rel=1e-6)
    assert 0.26 - rows[1]["theta"] == pytest.approx(0.707 * 5000 * model.parameters.time_step, rel=1e-6)


def test_a_quiet_start_does_not_ring(outcome):
    ripples = []
    for kind in ("inertia-relief", "unstressed"):
        run = outcome("paper-table-3", f"plate.start={kind}")
        ripples.append(np.abs(run.fe_history["reaction_normal"] - run.rigid_history["reaction_normal"]).max())
    assert ripples[0] < 20.0 < 3000.0 < ripples[1]


def test_the_loop_leaves_the_given_state_alone(plate_model):
    stepper = Stepper(plate_model())
    state = stepper.start(START, "inertia-relief")
    copy = State(*(array.copy() for array in state))
    stepper.advance(state, 10)
    stepper.measure(state)
    for before, after in zip(copy, state, strict=True):
        np.testing.assert_array_equal(before, after)
