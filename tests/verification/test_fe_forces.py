"""Verification: internal forces, masses and energies against exact answers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fem.explicit import measures, simd_blocks
from fem.explicit.internal_force import Viscosity, scratch_for, subtract_internal_forces
from fem.laws.materials import st_venant_kirchhoff
from fem.plate.elements import ElementTable, discretise, hourglass_control
from fem.start.rigid_state import to_global
from meshes import distorted, plate_mesh

MATERIAL = st_venant_kirchhoff(200e9, 0.3)
THICKNESS = 0.053


def internal_forces(
    table: ElementTable, positions: np.ndarray, velocities: Any = None, viscosity: Any = None
) -> Any:
    force = np.zeros_like(positions)
    velocities = np.zeros_like(positions) if velocities is None else velocities
    power = subtract_internal_forces(
        positions, velocities, viscosity, None, force, table, MATERIAL, scratch_for(table)
    )
    return -force, power


def viscosity(time: float) -> Viscosity:
    """Stiffness-proportional: the material's constants times a time [s]."""
    return Viscosity(*(time * constant for constant in MATERIAL))


@pytest.fixture(params=["congruent", "distorted"])
def discretisation(request, distorted_mesh):
    mesh = plate_mesh(10.0, 2.438, (20, 6)) if request.param == "congruent" else distorted_mesh
    return discretise(mesh, THICKNESS)


def test_congruent_elements_share_one_column_and_distorted_ones_do_not(distorted_mesh):
    assert discretise(plate_mesh(10.0, 2.438, (20, 6)), THICKNESS).table.gradients.shape == (32, 1)
    assert discretise(distorted_mesh, THICKNESS).table.gradients.shape == (32, 32)


@pytest.mark.parametrize("kind", ["quad4", "quad9", "tri6"])
def test_mapped_elements_are_those_of_the_gradients(kind, distorted_mesh):
    """The same forces to rounding from the nodes of each element as from scikit-fem's gradients."""
    triangles = distorted(plate_mesh(10.0, 2.438, (8, 4), "triangle"), 0.2, (8, 4))
    made = discretise(triangles if kind == "tri6" else distorted_mesh, THICKNESS, kind)
    assert made.table.mapping
    rng = np.random.default_rng(3)
    positions = made.positions + 1e-3 * rng.normal(size=made.positions.shape)
    velocities = rng.normal(size=positions.shape)
    stored = made.table._replace(mapping=None)
    for damped in (None, viscosity(1e-4)):
        forces, power = internal_forces(made.table, positions, velocities, damped)
        expected, expected_power = internal_forces(stored, positions, velocities, damped)
        assert np.abs(forces - expected).max() < 1e-12 * np.abs(expected).max()
        assert power == pytest.approx(expected_power, rel=1e-12)


def test_rigid_motion_gives_no_force(discretisation):
    """Zero to rounding: against E t, the force that a strain of one would give."""
    for angle, shift in ((0.0, 0.0), (0.26, 0.0), (2.0, 0.0), (-0.9, 10.0)):
        positions = to_global(angle) @ discretisation.positions + shift
        forces, _ = internal_forces(discretisation.table, positions)
        assert np.abs(forces).max() < 2e-14 * 200e9 * THICKNESS * 10.0


def test_patch_of_constant_strain(discretisation):
    """Affine deformation, large rotation included: inner nodes are in balance, boundary nodes carry F S N."""
    gradient = to_global(0.7) @ np.array([[1.02, 0.013], [0.004, 0.97]])
    positions = gradient @ discretisation.positions + np.array([[3.0], [-1.0]])
    forces, _ = internal_forces(discretisation.table, positions)
    strain = 0.5 * (gradient.T @ gradient - np.eye(2))
    stress = 200e9 / (1 - 0.09) * (0.7 * strain + 0.3 * np.trace(strain) * np.eye(2))
    traction = gradient @ stress * THICKNESS
    x, y = discretisation.positions
    inner = (x > -9.99) & (x < -0.01) & (y > 0.01) & (y < 2.43)
    scale = np.abs(traction).max() * 2.438
    assert inner.sum() > 10
    assert np.abs(forces[:, inner]).max() < 1e-13 * scale
    # The end's two corners also carry half an edge of the sides beside them; these shares cancel.
    np.testing.assert_allclose(
        forces[:, x > -0.01].sum(axis=1), traction[:, 0] * 2.438, atol=1e-12 * scale, rtol=0.0
    )


def test_energy_of_constant_strain(discretisation):
    gradient = to_global(-0.3) @ np.array([[1.01, 0.02], [0.0, 0.995]])
    strain = 0.5 * (gradient.T @ gradient - np.eye(2))
    density = 0.5 * 200e9 / (1 - 0.09) * (0.7 * np.sum(strain**2) + 0.3 * np.trace(strain) ** 2)
    energy = measures.energy_of_strain(gradient @ discretisation.positions, discretisation.table, MATERIAL)
    assert energy == pytest.approx(density * 10.0 * 2.438 * THICKNESS, rel=1e-12)


def test_forces_are_the_gradient_of_the_energy(discretisation):
    random = np.random.default_rng(3)
    positions = to_global(0.4) @ discretisation.positions + random.normal(
        0.0, 0.01, discretisation.positions.shape
    )
    forces, _ = internal_forces(discretisation.table, positions)
    direction = random.normal(size=positions.shape)
    step = 1e-2
    energy = {
        k: measures.energy_of_strain(positions + k * step * direction, discretisation.table, MATERIAL)
        for k in (-2, -1, 1, 2)
    }
    slope = (8.0 * (energy[1] - energy[-1]) - (energy[2] - energy[-2])) / (12.0 * step)  # exact for a quartic
    assert np.sum(forces * direction) == pytest.approx(slope, rel=1e-10)


def test_a_partly_filled_block_gives_what_full_blocks_give():
    """Two full blocks and five elements beside: stretched alike, every element carries what one alone carries."""
    count = 2 * simd_blocks.BLOCK_SIZE + 5
    many, one = (discretise(plate_mesh(10.0, 1.0, (n, 1)), THICKNESS) for n in (count, 1))
    stretch = np.diag([1.001, 1.0])
    ends = [
        internal_forces(d.table, stretch @ d.positions)[0][0][d.positions[0] > -0.01] for d in (many, one)
    ]
    np.testing.assert_allclose(np.sort(ends[0]), np.sort(ends[1]), rtol=1e-10)


def test_every_block_counts():
    """A distorted mesh of two full blocks and a rest: its forces are the sum of those of each element alone."""
    mesh = distorted(plate_mesh(10.0, 2.438, (19, 7)), 0.2, (19, 7))
    d = discretise(mesh, THICKNESS)
    assert d.table.connectivity.shape[1] == 2 * simd_blocks.BLOCK_SIZE + 5
    positions = d.positions + np.random.default_rng(7).normal(0.0, 1e-3, d.positions.shape)
    forces, _ = internal_forces(d.table, positions)
    expected = np.zeros_like(forces)
    for element in range(d.table.connectivity.shape[1]):
        alone = d.table._replace(
            connectivity=np.ascontiguousarray(d.table.connectivity[:, element : element + 1]),
            gradients=np.ascontiguousarray(d.table.gradients[:, element : element + 1]),
            weights=np.ascontiguousarray(d.table.weights[:, element : element + 1]),
        )
        expected += internal_forces(alone, positions)[0]
    np.testing.assert_allclose(forces, expected, atol=1e-12 * np.abs(forces).max(), rtol=0.0)


def test_rigid_rotation_dissipates_nothing(discretisation):
    positions = to_global(0.26) @ discretisation.positions
    spin = 0.7 * np.array([-positions[1], positions[0]]) + 25.0
    forces, power = internal_forces(discretisation.table, positions, spin, viscosity(1e-3))
    assert abs(power) < 1e-20 * 200e9
    assert np.abs(forces).max() < 1e-13 * 200e9 * THICKNESS * 10.0


def test_viscous_power_is_the_power_of_the_viscous_forces(discretisation):
    random = np.random.default_rng(5)
    positions = to_global(0.26) @ discretisation.positions
    velocities = random.normal(size=positions.shape)
    elastic, _ = internal_forces(discretisation.table, positions)
    both, power = internal_forces(discretisation.table, positions, velocities, viscosity(2e-6))
    assert power > 0.0
    assert np.sum((both - elastic) * velocities) == pytest.approx(power, rel=1e-9)


ELEMENTS = (20, 6)


def shuffled(table: ElementTable, number: np.ndarray) -> ElementTable:
    """The same elements on renumbered nodes."""
    connectivity = np.ascontiguousarray(number[table.connectivity], dtype=np.int32)
    if table.mapping is None:
        return table._replace(connectivity=connectivity)
    reference = np.ascontiguousarray(table.mapping.reference[:, np.argsort(number)])
    return table._replace(connectivity=connectivity, mapping=table.mapping._replace(reference=reference))


@pytest.mark.parametrize("share", [0.0, 0.2])
@pytest.mark.parametrize("kind", ["quad4", pytest.param("quad4-reduced", marks=pytest.mark.long)])
def test_forces_do_not_depend_on_the_numbering(kind, share):
    mesh = plate_mesh(10.0, 2.438, ELEMENTS)
    d = discretise(distorted(mesh, share, ELEMENTS) if share else mesh, 0.05, kind)
    hourglass = hourglass_control(d, 0.05, MATERIAL) if kind == "quad4-reduced" else None
    rng = np.random.default_rng(1)
    number = rng.permutation(d.positions.shape[1])
    back = np.argsort(number)
    positions, velocities = (
        d.positions + rng.normal(0.0, 1e-3, d.positions.shape),
        rng.normal(size=d.positions.shape),
    )
    results = []
    for table, at, rate in (
        (d.table, positions, velocities),
        (shuffled(d.table, number), positions[:, back], velocities[:, back]),
    ):
        force, viscosity = np.zeros_like(at), Viscosity(1e3, 3e2, 4e2)
        at, rate = np.ascontiguousarray(at), np.ascontiguousarray(rate)
        power = subtract_internal_forces(
            at, rate, viscosity, hourglass, force, table, MATERIAL, scratch_for(table, hourglass)
        )
        results.append((force, power))
    (force, power), (other, other_power) = results
    np.testing.assert_allclose(other[:, number], force, rtol=0.0, atol=1e-12 * np.abs(force).max())
    assert other_power == pytest.approx(power, rel=1e-12)


def test_a_plate_is_a_lattice_with_one_idle_slot_between_rows():
    lattice = simd_blocks.find_lattice(discretise(plate_mesh(10.0, 2.438, ELEMENTS), 0.05).table.connectivity)
    assert lattice is not None
    assert lattice.element.size == 6 * 21 - 1
    assert (lattice.element < 0).sum() == lattice.idle.size == 5


def test_triangles_and_shuffled_nodes_are_no_lattice():
    table = discretise(plate_mesh(10.0, 2.438, ELEMENTS), 0.05).table
    number = np.random.default_rng(1).permutation(147)
    assert simd_blocks.find_lattice(shuffled(table, number).connectivity) is None
    triangles = discretise(plate_mesh(10.0, 2.438, ELEMENTS, "triangle"), 0.05, "tri3").table
    assert simd_blocks.find_lattice(triangles.connectivity) is None
