"""Elements in SIMD blocks: the layout of a mesh numbered row by row gives the forces of any other numbering."""

import numpy as np
import pytest

from fem.explicit.internal_force import Viscosity, scratch_for, subtract_internal_forces
from fem.explicit.simd_blocks import find_lattice
from fem.laws.materials import st_venant_kirchhoff
from fem.plate.elements import ElementTable, discretise, hourglass_control
from meshes import distorted, plate_mesh

MATERIAL = st_venant_kirchhoff(200e9, 0.3)
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
def test_forces_do_not_depend_on_the_numbering(kind: str, share: float) -> None:
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


def test_a_plate_is_a_lattice_with_one_idle_slot_between_rows() -> None:
    lattice = find_lattice(discretise(plate_mesh(10.0, 2.438, ELEMENTS), 0.05).table.connectivity)
    assert lattice is not None
    assert lattice.element.size == 6 * 21 - 1
    assert (lattice.element < 0).sum() == lattice.idle.size == 5


def test_triangles_and_shuffled_nodes_are_no_lattice() -> None:
    table = discretise(plate_mesh(10.0, 2.438, ELEMENTS), 0.05).table
    number = np.random.default_rng(1).permutation(147)
    assert find_lattice(shuffled(table, number).connectivity) is None
    triangles = discretise(plate_mesh(10.0, 2.438, ELEMENTS, "triangle"), 0.05, "tri3").table
    assert find_lattice(triangles.connectivity) is None
