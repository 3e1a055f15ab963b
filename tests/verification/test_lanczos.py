"""Verification: the largest eigenvalue against spectra that are known, and the same digits whatever the rounding."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from fem.plate import spectrum
from fem.plate.spectrum import largest_eigenpair

pytestmark = pytest.mark.verification

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
def test_chain(masses: int) -> None:
    value, vector = largest_eigenpair(chain(masses), started(masses), 1e-9, BASIS)
    assert value == pytest.approx(2.0 - 2.0 * math.cos(masses * math.pi / (masses + 1)), rel=1e-12)
    assert np.linalg.norm(chain(masses)(vector) - value * vector) <= 1e-8 * value


def test_start_within_few_unknowns_ends_with_theirs() -> None:
    """Three unknowns that nothing couples to others: after them there is nothing to divide by."""
    start = np.zeros(40)
    start[[3, 9, 20]] = 1.0, 2.0, 3.0
    value, vector = largest_eigenpair(lambda given: np.arange(40.0) * given, start, 1e-9, BASIS)
    assert value == pytest.approx(20.0, rel=1e-12)
    assert abs(vector[20]) == pytest.approx(1.0, rel=1e-12)


def test_product_that_is_not_finite_is_an_error() -> None:
    with pytest.raises(FloatingPointError):
        largest_eigenpair(lambda vector: vector * np.nan, started(30), 1e-4, BASIS)


def test_time_step_has_the_same_digits_whatever_the_rounding(
    plate_model: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
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
