"""Verification: one-point elements with an assumed strain bend as beams do, and their forces are those of an energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.sparse.linalg

from fem.explicit.internal_force import scratch_for, subtract_internal_forces
from fem.explicit.measures import energy_of_hourglass, energy_of_strain
from fem.laws.materials import st_venant_kirchhoff
from fem.plate import elements
from meshes import distorted, plate_mesh

E, NU, T = 2e11, 0.3, 0.05
MODULI = st_venant_kirchhoff(E, NU)


def stiffness(d: elements.Discretisation, kind: str) -> Any:
    matrix = elements.stiffness_matrix(d.scalar, T, MODULI)
    if kind == "quad4-reduced":
        matrix = matrix + elements.hourglass_matrix(
            d.table, elements.hourglass_control(d, T, MODULI), d.positions.shape[1]
        )
    return matrix


def tip_deflection(length: float, width: float, counts: tuple[int, int], kind: str) -> float:
    """Of a cantilever, over that of Timoshenko's beam, P L^3/3EI + 6/5 P L/GA; its load as the parabola of shear."""
    d = elements.discretise(plate_mesh(length, width, counts), T, kind)
    x, y = d.positions
    held = np.isclose(x, x.max())
    free = np.isclose(x, x.min())
    eta = (y - y.min()) / width
    share = np.where(free, 6.0 * eta * (1.0 - eta) if counts[1] > 1 else 1.0, 0.0)
    load = np.concatenate([np.zeros(x.size), share / share.sum()])
    moves = ~np.concatenate([held, held & np.isclose(eta, eta[held].min())])
    matrix = stiffness(d, kind).tocsc()[moves][:, moves]
    found = np.zeros(2 * x.size)
    found[moves] = scipy.sparse.linalg.spsolve(matrix, load[moves])
    inertia, shear = T * width**3 / 12.0, E / (2.0 * (1.0 + NU))
    exact = length**3 / (3.0 * E * inertia) + 1.2 * length / (shear * T * width)
    return float(found @ load / exact)


@pytest.mark.parametrize("slenderness", [0.02, 0.1, 0.25])
def test_a_cantilever_of_one_element_across_bends_as_a_beam(slenderness):
    """Within 2 % of Timoshenko's beam, by 20 elements along; ordinary quad4 locks, and has less than half."""
    assert tip_deflection(10.0, 10.0 * slenderness, (20, 1), "quad4-reduced") == pytest.approx(1.0, abs=0.02)
    if slenderness == 0.02:
        assert tip_deflection(10.0, 0.2, (20, 1), "quad4") < 0.5


def test_refined_along_the_slender_beam_it_converges():
    """Second order: a quarter of each change is the next; the width over the length is left of the error."""
    found = [tip_deflection(10.0, 0.2, (n, 1), "quad4-reduced") for n in (5, 10, 20, 40)]
    changes = np.diff(found)
    assert changes[:2] / changes[1:] == pytest.approx(4.0, rel=0.05)
    assert found[-1] == pytest.approx(1.0, abs=5e-4)


def test_a_rectangle_in_pure_bending_stores_what_the_beam_does():
    """Plane stress, curvature k: u = k x y, v = -k (x^2 + nu y^2)/2 at the nodes of an element that is its middle."""
    length, width, k = 3.0, 0.8, 1e-6
    d = elements.discretise(plate_mesh(length, width, (1, 1)), T, "quad4-reduced")
    x, y = d.positions - d.positions.mean(axis=1, keepdims=True)
    u = np.concatenate([k * x * y, -0.5 * k * (x**2 + NU * y**2)])
    energy = 0.5 * u @ (stiffness(d, "quad4-reduced") @ u)
    assert energy == pytest.approx(0.5 * E * T * width**3 / 12.0 * k**2 * length, rel=1e-9)


def test_forces_are_the_slope_of_the_energy_in_any_position():
    """Distorted elements, turned and strained; by differences of the energy along a direction."""
    mesh = distorted(plate_mesh(2.0, 1.0, (3, 2)), 0.2, (3, 2))
    d = elements.discretise(mesh, T, "quad4-reduced")
    control = elements.hourglass_control(d, T, MODULI)
    random = np.random.default_rng(1)
    turned = np.array([[0.3, -1.1], [0.9, 0.2]]) @ d.positions
    positions = turned + random.normal(0.0, 0.02, d.positions.shape)
    direction = random.normal(size=positions.shape)

    def energy(step: float) -> float:
        at = positions + step * 1e-4 * direction
        return float(energy_of_strain(at, d.table, MODULI) + energy_of_hourglass(at, d.table, control))

    slope = (8.0 * (energy(1) - energy(-1)) - (energy(2) - energy(-2))) / 12e-4
    force, scratch = np.zeros_like(positions), scratch_for(d.table, control)
    subtract_internal_forces(
        positions, np.zeros_like(positions), None, control, force, d.table, MODULI, scratch
    )
    assert -np.sum(force * direction) == pytest.approx(slope, rel=1e-8)
    assert np.abs(force.sum(axis=1)).max() < 1e-9 * np.abs(force).max()
    moment = positions[0] * force[1] - positions[1] * force[0]
    assert abs(moment.sum()) < 1e-9 * np.abs(moment).max()


def test_at_rest_the_forces_are_the_stiffness():
    mesh = distorted(plate_mesh(2.0, 1.0, (3, 2)), 0.2, (3, 2))
    d = elements.discretise(mesh, T, "quad4-reduced")
    control = elements.hourglass_control(d, T, MODULI)
    u = 1e-7 * np.random.default_rng(2).normal(size=d.positions.shape)
    force, scratch = np.zeros_like(u), scratch_for(d.table, control)
    subtract_internal_forces(
        d.positions + u, np.zeros_like(u), None, control, force, d.table, MODULI, scratch
    )
    linear = (stiffness(d, "quad4-reduced") @ u.ravel()).reshape(2, -1)
    np.testing.assert_allclose(-force, linear, atol=1e-5 * np.abs(linear).max(), rtol=0.0)
