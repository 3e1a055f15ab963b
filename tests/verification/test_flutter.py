"""Verification: growth by friction as the Nyquist criterion tells it, against eigenvalues and against the time loop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fem.laws.constraints import Exact
from fem.laws.friction import friction_slope
from fem.plate.elements import stiffness_matrix
from fem.run.corner import Stepper
from fem.stability import flutter
from fem.start.rigid_state import RigidStart, to_global
from tailslap.case.corner import case, decisions
from tailslap.case.corner.decisions import REQUIRED_DAMPING
from tailslap.scene.read import read_scene

START = RigidStart(0.26, 0.707, 25.053)
DURATION = 0.384


def growth_rates(model: Any, angle: float, ratio: float = 0.0) -> np.ndarray:
    """Rates [1/s] of all modes by dense eigenvalues of the first-order system, damping included."""
    corner, masses, nodes = model.loop.corner, model.loop.mass, model.loop.mass.size
    along, across = to_global(angle)
    spread = np.zeros(nodes)
    spread[corner.nodes] = corner.weights
    root = 1.0 / np.sqrt(np.tile(masses, 2))
    gap = np.kron(across, spread) * root
    push = gap + friction_slope(model.loop.friction, START.corner_speed) * np.kron(along, spread) * root
    plate = root[:, None] * model.stiffness.toarray() * root
    stiffness = plate.copy()
    if isinstance(corner.constraint, Exact):
        stiffness -= np.outer(push, gap @ plate) / (gap @ push)
    else:
        stiffness += corner.stiffness * np.outer(push, gap)
    damping = np.outer(push, gap) * getattr(corner.constraint, "damping", 0.0)
    if ratio:
        viscous = stiffness_matrix(model.discretisation.scalar, model.thickness, model.loop.viscosity)
        damping += root[:, None] * viscous.toarray() * root
    size = 2 * nodes
    system = np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -damping]])
    values = np.linalg.eigvals(system)
    return values.real[np.abs(values.imag) > 1e-3 * np.abs(values.imag).max()]


CORNERS: dict[str, dict[str, Any]] = {
    "penalty": {"penalty_scale": 3.0},
    "exact": {"constraint": "exact"},
    "dashpot": {"penalty_scale": 3.0, "damping_ratio": 0.2},
    "patch": {"patch_length": 3.0},
}


@pytest.mark.parametrize("corner", CORNERS)
@pytest.mark.parametrize("ratio", [0.0, 0.002])
def test_number_of_growing_modes_is_that_of_the_eigenvalues(plate_model, corner, ratio):
    """At three angles and five rates: the modes with a larger real part are as many as the criterion counts."""
    model = plate_model((10, 3), "drag", corner=CORNERS[corner], damping_ratio=ratio)
    modes, slope = flutter.corner_modes(model), friction_slope(model.loop.friction, START.corner_speed)
    viscous = 0.5 * model.loop.viscosity.c_33 / model.tangent_moduli.c_33 if ratio else 0.0
    constraint, seen = model.loop.corner.constraint, 0
    for angle in (0.26, 0.1, 0.0):
        rates = growth_rates(model, angle, ratio)
        along, across = to_global(angle) @ modes.corner
        residues = across * (across + slope * along)
        residues[2], squares = residues[:3].sum(), modes.squares.copy()
        squares[2] = 0.0
        stiffness = getattr(constraint, "stiffness", np.inf)
        top = 1.5 * flutter.highest_mode(squares, residues[2:], stiffness)
        for rate in (3.0, 10.0, 30.0, 100.0, 300.0):
            if np.abs(rates - rate).min() < 0.02 * rate:
                continue  # too near to tell
            counted = flutter.growing_modes(
                squares[2:], residues[2:], stiffness, getattr(constraint, "damping", 0.0), viscous, rate, top
            )
            expected = int((rates > rate).sum())
            assert counted == expected, (angle, rate)
            seen += expected
    assert seen > 0 or ratio > 0.0 or corner == "patch"


@pytest.mark.long
def test_rate_is_the_least_tried_that_no_mode_outgrows(plate_model):
    model = plate_model(reaction="drag", corner={"constraint": "exact"})
    found = flutter.predict_flutter(model, START, DURATION)
    angles = np.linspace(START.angle, 0.0, flutter.INSTANTS)
    fastest = max(growth_rates(model, angle).max() for angle in angles)
    assert fastest < found.rate <= 1.01 * flutter.FACTOR * fastest


def test_disturbance_grows_in_the_time_loop_as_foreseen(plate_model):
    """A plate so stiff that it hardly turns meanwhile; with the damping that is said to suppress it, it decays."""
    stiff = {"plate": {"youngs_modulus": 2e15}, "corner": {"penalty_scale": 3.0}, "safety_factor": 0.45}
    model = plate_model(reaction="drag", **stiff)
    fastest = growth_rates(model, 0.255).max()
    assert measured_rate(model, 1e-9, slice(24, 40)) == pytest.approx(fastest, rel=0.1)
    damped = plate_model(reaction="drag", elastic_rate=REQUIRED_DAMPING * fastest, **stiff)
    slowest = (0.5 * REQUIRED_DAMPING - 1.0) * fastest
    assert -4.0 * slowest < measured_rate(damped, 1e-6, slice(2, 10)) < -0.9 * slowest


def measured_rate(model: Any, size: float, calls: slice) -> float:
    """Rate [1/s] at which the vibration of a plate disturbed by random velocities of this size [m/s] grows."""
    stepper = Stepper(model)
    state = stepper.start(START, "inertia-relief")
    noise = size * np.random.default_rng(4).normal(size=state.positions.shape)
    state = state._replace(velocities=state.velocities + noise)
    energies, instants = [], 1000 * model.loop.time_step * np.arange(calls.stop)
    for _ in instants:
        state = stepper.advance(state, 1000)
        energies.append(stepper.measure(state).vibration_energy)
    return float(0.5 * np.polyfit(instants[calls], np.log(energies[calls]), 1)[0])


@pytest.mark.parametrize(
    ("changes", "flutters"),
    [
        ((), False),
        (("impact.friction=0.8", "corner.penalty_scale=3"), True),
        (("plate.youngs_modulus=20 TPa", "corner.penalty_scale=3"), True),
        (("corner.constraint=exact", "plate.youngs_modulus=20 TPa"), True),
    ],
)
def test_flutter_is_foreseen_and_suppressed(outcome, changes, flutters):
    """Forbidden to damp, the run fails; left to decide, the program damps it, and it is right to its flexibility."""
    forbidden = outcome("paper-table-3", *changes, "damping.kind=none")
    assert forbidden.passed is not flutters
    free = outcome("paper-table-3", *changes)
    assert (free.fe_plan.model.loop.elastic_damping is not None) is flutters
    assert free.passed
    assert max(map(abs, free.difference.values())) < 5e-6


def test_without_friction_nothing_grows(plate_model):
    assert flutter.predict_flutter(plate_model(reaction="none"), START, DURATION).growth == 0.0


def test_only_meshes_that_can_be_analysed_are_made(monkeypatch):
    """Of the coarser meshes of a large one."""
    made, plain = [], decisions.static_models

    def counted(plan: Any, plates: Any, meshes: Any) -> Any:
        made.extend(plate.elements for plate in plates)
        return plain(plan, plates, meshes)

    monkeypatch.setattr(decisions, "static_models", counted)
    plan = case.CornerCase(*read_scene("paper-table-3", ("plate.elements=[400, 120]",)))
    models = list(decisions._coarser_models(plan, plan.scene.needed_plate, flutter.MAX_UNKNOWNS))
    assert [2 * model.loop.mass.size <= flutter.MAX_UNKNOWNS for model in models] == [True, True]
    assert made == [(35, 10), (23, 7)]  # (53, 15) has 1 728 unknowns


@pytest.mark.long
def test_coarser_meshes_stand_in_for_a_large_one():
    """Their rates, with the margin, are above those of the mesh itself."""
    stiff = ("corner.constraint=exact", "impact.friction=0.8")
    changes = (*stiff, "plate.element=quad4", "plate.elements=[40, 14]")
    plan = case.CornerCase(*read_scene("mash-tl4-sut", changes)).plan()
    assert plan.growth.stand_in
    angles = np.linspace(plan.start.angle, 0.0, 3)
    assert plan.growth.rate > max(growth_rates(plan.model, angle).max() for angle in angles)
