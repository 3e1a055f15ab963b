"""Verification: the highest frequency and the bound that the time step is made from, against dense solutions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from fem.plate import spectrum as lanczos
from fem.plate.spectrum import Spectrum, hold_of

pytestmark = pytest.mark.verification

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
def test_bound_is_safe_at_every_angle_and_close(
    plate_model: Callable[..., Any], elements: tuple[int, int], scale: float
) -> None:
    model = plate_model(elements=elements, corner={"penalty_scale": scale})
    found = Spectrum(model.stiffness, model.loop.mass, hold_of(model.loop.corner, ANGLES))
    highest = max(np.sqrt(dense(model, angle)) for angle in ANGLES)
    assert highest <= found.bound <= (1.0 + lanczos.TOLERANCE) * highest
    assert found.frequency == pytest.approx(highest, rel=1e-5)


@pytest.mark.parametrize("given", [{"damping_ratio": 0.2}, {"corner": {"damping_ratio": 0.5}}])
def test_damped_step_is_safe_and_close(plate_model: Callable[..., Any], given: dict[str, Any]) -> None:
    """dt^2 K + 2 dt C has no eigenvalue above 4, and one within the residual of it."""
    from fem.plate.elements import stiffness_matrix

    model = plate_model(elements=(6, 3), **given)
    viscosity = model.loop.viscosity
    damping = viscosity and stiffness_matrix(model.discretisation.scalar, model.thickness, viscosity)
    worst = max(dense(model, angle, model.undamped_time_step, damping) for angle in ANGLES)
    assert 4.0 * (1.0 - 2.0 * lanczos.TOLERANCE) < worst <= 4.0


def test_residual_is_in_the_bound(plate_model: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Lanczos that ends far too early finds a frequency that is too low; its bound is not."""
    model = plate_model()
    masses = model.loop.mass
    exact = Spectrum(model.stiffness, masses).frequency
    monkeypatch.setattr(lanczos, "TOLERANCE", 0.03)
    monkeypatch.setattr("fem.plate.spectrum.SETTLED", np.inf)
    rough = Spectrum(model.stiffness, masses)
    assert rough.frequency < (1.0 - 1e-4) * exact
    assert rough.bound >= exact


def test_angles_that_are_lower_are_not_looked_at_closely(
    plate_model: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    model, tolerances = plate_model(), []
    plain = Spectrum._largest

    def counted(self: Spectrum, *given: Any) -> Any:
        tolerances.append(given[-1])
        return plain(self, *given)

    monkeypatch.setattr(Spectrum, "_largest", counted)
    Spectrum(model.stiffness, model.loop.mass, hold_of(model.loop.corner, ANGLES))
    assert tolerances == [lanczos.TOLERANCE, lanczos.ROUGH, lanczos.ROUGH]
