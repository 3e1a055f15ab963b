"""Verification: displacements and frequencies of large plates by iteration, against a factorisation."""

from typing import Any

import numpy as np
import pytest

from fem import lazy
from fem.plate import elastic
from fem.plate import elastic as multigrid
from fem.plate.elastic import ElasticSolver, Inverse, lowest_frequency
from fem.start.inertia_relief import relieved_fields
from fem.start.rigid_state import RigidStart

START = RigidStart(0.26, 0.707, 25.053)
PLATES = (
    {},
    {"element": "quad9"},
    {"element": "tri6"},
    {"element": "quad4-reduced"},
    {"poissons_ratio": 0.45},
)


def solver_of(model: Any) -> Inverse:
    """A solver of its own, that has solved nothing."""
    return Inverse(model.stiffness, model.loop.mass, model.discretisation.positions)


@pytest.fixture
def all_large(monkeypatch):
    """Every plate counts as large, and has several levels."""
    monkeypatch.setattr(elastic, "LARGE", 0)
    monkeypatch.setattr(multigrid, "COARSEST", 30)


@pytest.mark.usefixtures("all_large")
@pytest.mark.parametrize("plate", PLATES, ids=str)
def test_iteration_gives_what_a_factorisation_gives(plate_model, plate):
    model = plate_model(elements=(40, 12), plate=plate)
    solver, body = solver_of(model), model.discretisation.positions
    masses = np.tile(model.loop.mass, 2)
    load = masses * np.sin(3.0 * np.arange(masses.size) / masses.size)
    rigid = elastic.rigid_motions(body)
    load -= masses * (rigid @ np.linalg.solve(rigid.T @ (masses[:, None] * rigid), rigid.T @ load))
    expected, found = solver.factorised(load), solver(load)
    assert len(solver.multigrid._levels.levels) > 1
    assert not np.array_equal(found, expected)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.usefixtures("all_large")
def test_iteration_repeats_to_the_bit(plate_model):
    model = plate_model(elements=(40, 12))
    load = model.stiffness @ np.cos(np.arange(2.0 * model.loop.mass.size))
    np.random.seed(1)  # noqa: NPY002
    first = solver_of(model)(load)
    np.random.seed(2)  # noqa: NPY002
    np.testing.assert_array_equal(first, solver_of(model)(load))


@pytest.mark.parametrize("plate", PLATES, ids=str)
def test_lowest_frequency_by_iteration(plate_model, plate, monkeypatch):
    model = plate_model(elements=(40, 12), plate=plate)
    expected = lowest_frequency(ElasticSolver(solver_of(model), 1.0))
    monkeypatch.setattr(elastic, "LARGE", 0)
    monkeypatch.setattr(Inverse, "factorised", None)
    assert lowest_frequency(ElasticSolver(solver_of(model), 1.0)) == pytest.approx(expected, rel=1e-8)


@pytest.mark.usefixtures("all_large")
def test_without_convergence_a_factorisation_takes_over(plate_model, monkeypatch):
    model = plate_model(elements=(40, 12))
    load = model.stiffness @ np.cos(np.arange(2.0 * model.loop.mass.size))
    monkeypatch.setattr(multigrid, "MOST", 2)
    solver = solver_of(model)
    np.testing.assert_array_equal(solver(load), solver.factorised(load))


def test_start_takes_two_loads_and_statics_none_more(plate_model, monkeypatch):
    from fem.start.inertia_relief import elastic_energy, statics

    loads = []
    plain = Inverse._solved
    monkeypatch.setattr(Inverse, "_solved", lambda self, load: loads.append(load) or plain(self, load))
    lazy.forget()
    model = plate_model(elements=(10, 3))
    fields = relieved_fields(model, START)
    statics(model, START)
    elastic_energy(model, START)
    assert len(loads) == 2
    span = 1e-4
    late, early = (
        relieved_fields(model, RigidStart(0.26 - 0.707 * t, 0.707 + angular(model) * t, 25.053)).elastic
        for t in (span, -span)
    )
    rate = (late - early) / (2.0 * span)
    np.testing.assert_allclose(fields.rate, rate, rtol=0.0, atol=1e-5 * np.abs(rate).max())


def angular(model: Any) -> float:
    """Angular acceleration of the rigid body at the start [rad/s^2]."""
    from fem.start.rigid_state import at_corner, rigid_accelerations

    body = model.discretisation.positions - at_corner(model, model.discretisation.positions)
    return rigid_accelerations(model, body, 0.26, 0.707, 25.053).angular
