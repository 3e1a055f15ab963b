"""Verification: the largest eigenvalue against spectra that are known, and the bound that the time step is made from,
against dense solutions.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from fem.plate import spectrum
from fem.plate.spectrum import Spectrum, hold_of, largest_eigenpair

ANGLES = (0.26, 0.13, 0.0)
MESHES = ((6, 3), (10, 3), (20, 6), (3, 12))


def dense(model: Any, angle: float, step: float = 0.0, damping: Any = None) -> float:
    """Largest eigenvalue of K with the corner's spring, or of dt^2 K + 2 dt C, against the masses."""
    masses, corner = model.loop.mass, model.loop.corner
    unknowns = np.concatenate([corner.nodes, corner.nodes + masses.size])
    across = np.kron((-np.sin(angle), np.cos(angle)), corner.weights)
    matrix, spring = model.stiffness.toarray(), corner.spring
    if step:
        plate = 0.0 if damping is None else damping.toarray()
        matrix = step**2 * matrix + 2.0 * step * plate
        spring = step**2 * spring + 2.0 * step * corner.dashpot
    matrix[np.ix_(unknowns, unknowns)] += spring * np.outer(across, across)
    return float(scipy.linalg.eigh(matrix, np.diag(np.tile(masses, 2)), eigvals_only=True)[-1])


@pytest.mark.parametrize("scale", [1e-3, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("elements", MESHES)
def test_bound_is_safe_at_every_angle_and_close(plate_model, elements, scale):
    model = plate_model(elements=elements, corner={"penalty_scale": scale})
    found = Spectrum(model.stiffness, model.loop.mass, hold_of(model.loop.corner, ANGLES))
    highest = max(np.sqrt(dense(model, angle)) for angle in ANGLES)
    assert highest <= found.bound <= (1.0 + spectrum.TOLERANCE) * highest
    assert found.frequency == pytest.approx(highest, rel=1e-5)


@pytest.mark.parametrize("given", [{"damping_ratio": 0.2}, {"corner": {"damping_ratio": 0.5}}])
def test_damped_step_is_safe_and_close(plate_model, given):
    """dt^2 K + 2 dt C has no eigenvalue above 4, and one within the residual of it."""
    from fem.plate.elements import stiffness_matrix

    model = plate_model(elements=(6, 3), **given)
    viscosity = model.loop.viscosity
    damping = viscosity and stiffness_matrix(model.discretisation.scalar, model.thickness, viscosity)
    worst = max(dense(model, angle, model.undamped_time_step, damping) for angle in ANGLES)
    assert 4.0 * (1.0 - 2.0 * spectrum.TOLERANCE) < worst <= 4.0


def test_residual_is_in_the_bound(plate_model, monkeypatch):
    """Lanczos that ends far too early finds a frequency that is too low; its bound is not."""
    model = plate_model()
    masses = model.loop.mass
    exact = Spectrum(model.stiffness, masses).frequency
    monkeypatch.setattr(spectrum, "TOLERANCE", 0.03)
    monkeypatch.setattr("fem.plate.spectrum.SETTLED", np.inf)
    rough = Spectrum(model.stiffness, masses)
    assert rough.frequency < (1.0 - 1e-4) * exact
    assert rough.bound >= exact


def test_angles_that_are_lower_are_not_looked_at_closely(plate_model, monkeypatch):
    model, tolerances = plate_model(), []
    plain = Spectrum._largest

    def counted(self: Spectrum, *given: Any) -> Any:
        tolerances.append(given[-1])
        return plain(self, *given)

    monkeypatch.setattr(Spectrum, "_largest", counted)
    Spectrum(model.stiffness, model.loop.mass, hold_of(model.loop.corner, ANGLES))
    assert tolerances == [spectrum.TOLERANCE, spectrum.ROUGH, spectrum.ROUGH]


BASIS = 12


def chain(masses: int) -> Callable[[np.ndarray], np.ndarray]:
    """Unit masses between unit springs, both ends held: eigenvalues 2 - 2 cos(k pi / (masses + 1))."""

    def product(vector: np.ndarray) -> np.ndarray:
        padded = np.pad(vector, 1)
        return np.asarray(2.0 * vector - padded[:-2] - padded[2:])

    return product


def started(size: int) -> np.ndarray:
    return np.cos(1.7 * np.arange(size)) + 0.1


@pytest.mark.parametrize("masses", [1, 2, 5, 12, 13, 40, 150])
def test_chain(masses):
    value, vector = largest_eigenpair(chain(masses), started(masses), 1e-9, BASIS)
    assert value == pytest.approx(2.0 - 2.0 * math.cos(masses * math.pi / (masses + 1)), rel=1e-12)
    assert np.linalg.norm(chain(masses)(vector) - value * vector) <= 1e-8 * value


def test_start_within_few_unknowns_ends_with_theirs():
    """Three unknowns that nothing couples to others: after them there is nothing to divide by."""
    start = np.zeros(40)
    start[[3, 9, 20]] = 1.0, 2.0, 3.0
    value, vector = largest_eigenpair(lambda given: np.arange(40.0) * given, start, 1e-9, BASIS)
    assert value == pytest.approx(20.0, rel=1e-12)
    assert abs(vector[20]) == pytest.approx(1.0, rel=1e-12)


def test_product_that_is_not_finite_is_an_error():
    with pytest.raises(FloatingPointError):
        largest_eigenpair(lambda vector: vector * np.nan, started(30), 1e-4, BASIS)


def test_time_step_has_the_same_digits_whatever_the_rounding(plate_model, monkeypatch):
    """Products that differ in their last bit, as those of two versions of a library may: the tolerance is far above."""
    noise, plain = np.random.default_rng(1), largest_eigenpair
    models = [plate_model(elements=each, damping_ratio=0.05) for each in ((6, 3), (20, 6), (40, 12))]

    def steps() -> np.ndarray:
        spectra = (spectrum.Spectrum(each.stiffness, each.loop.mass) for each in models)
        return np.array([each.stable_time_step() for each in spectra])

    def rounded(product: Callable[[np.ndarray], np.ndarray], *given: Any) -> tuple[float, np.ndarray]:
        return plain(
            lambda vector: product(vector) * (1.0 + 2e-16 * noise.choice((-1.0, 1.0), vector.size)), *given
        )

    exact = steps()
    monkeypatch.setattr(spectrum, "largest_eigenpair", rounded)
    assert 0.0 < np.abs(steps() / exact - 1.0).max() < 1e-10
