"""Verify forces and energies of elements, with materials and hourglass control."""

import decimal
from decimal import Decimal

import numpy as np
import pytest
import scipy.sparse.linalg
from numpy.testing import assert_allclose

from fem.explicit import simd_blocks
from fem.explicit.internal_force import Viscosity, scratch_for, subtract_forces_of
from fem.explicit.nine_nodes import rectangle_sizes
from fem.laws.materials import MATERIALS, _volume_logarithm, neo_hookean, st_venant_kirchhoff
from fem.plate.discretisation import discretise, hourglass_control, hourglass_matrix, stiffness_matrix
from fem.plate.kinds import ELEMENT_KINDS
from fem.stability.deformed import deformed_frequency
from fem.start.inertia_relief import to_global
from meshes import distorted, plate_mesh

MATERIAL = st_venant_kirchhoff(200e9, 0.3)
THICKNESS = 0.053
INVISCID = Viscosity(0.0, 0.0, 0.0)
"""Viscosity of elastic forces, so that each element has one kernel to compile."""


def forces_and_energies(table, at, rate=None, viscosity=INVISCID, material=MATERIAL, hourglass=None):
    """Forces, viscous power, and energies of strain and of hourglass control."""
    force, rate = np.zeros_like(at), np.zeros_like(at) if rate is None else rate
    scratch, energies = scratch_for(table, hourglass), np.zeros(2)
    slots = simd_blocks.slot_count(table.connectivity, scratch.lattice)
    laws = viscosity, hourglass, force, table, material, scratch
    power = subtract_forces_of(0, slots, at, rate, *laws, energies)
    return -force, power, *energies


def internal_forces(table, at, rate=None, viscosity=INVISCID, material=MATERIAL, hourglass=None):
    """Forces of the elements on the nodes, and the viscous power."""
    return forces_and_energies(table, at, rate, viscosity, material, hourglass)[:2]


def elastic_energy(at, table, material, hourglass=None):
    """Energy of strain and of hourglass control."""
    return sum(forces_and_energies(table, at, material=material, hourglass=hourglass)[2:])


def slope(energy, at, direction, step):
    """Derivative of an energy along a direction, exact for a quartic."""
    far, near = (energy(at + k * step * direction) - energy(at - k * step * direction) for k in (2, 1))
    return (8.0 * near - far) / (12.0 * step)


def viscosity(time):
    """Stiffness-proportional viscosity of a time [s]."""
    return Viscosity(*(time * constant for constant in MATERIAL))


@pytest.fixture(params=["congruent", "distorted"])
def discretisation(request, distorted_mesh):
    mesh = plate_mesh(10.0, 2.438, (20, 6)) if request.param == "congruent" else distorted_mesh
    return discretise(mesh, THICKNESS)


def test_congruent_elements_share_one_column_and_distorted_ones_do_not(distorted_mesh):
    assert discretise(plate_mesh(10.0, 2.438, (20, 6)), THICKNESS).table.gradients.shape == (32, 1)
    assert discretise(distorted_mesh, THICKNESS).table.gradients.shape == (32, 32)


def forces_by_sums(table, at, rate, *laws):
    """Forces by the stored gradients, viscous power and strain energy.

    laws: constants of the elastic and of the viscous stress.
    """
    nodes, elements = table.connectivity.shape
    stored = np.broadcast_to(
        table.gradients, (len(table.gradients), elements)
    )  # one column of congruent elements
    gradients = stored.reshape(-1, nodes, 2, elements)
    f, f_rate = (
        np.einsum("iae,qake->ikqe", values[:, table.connectivity], gradients) for values in (at, rate)
    )
    product, unit = np.einsum("ikqe,ilqe->klqe", f_rate, f), np.eye(2)[:, :, None, None]
    green = 0.5 * (np.einsum("ikqe,ilqe->klqe", f, f) - unit)
    strains = green, 0.5 * (product + product.swapaxes(0, 1))
    stresses = [
        2.0 * law.c_33 * strain + law.c_12 * np.trace(strain) * unit
        for law, strain in zip(laws, strains, strict=True)
    ]
    weights = np.broadcast_to(table.weights, (len(table.weights), elements))
    pull = np.einsum("ikqe,klqe,qale,qe->iae", f, sum(stresses), gradients, weights)
    force = [np.bincount(table.connectivity.ravel(), part.ravel(), at.shape[1]) for part in pull]
    elastic_work, power = (
        np.einsum("klqe,klqe,qe->", *pair, weights) for pair in zip(stresses, strains, strict=True)
    )
    return np.array(force), power, 0.5 * elastic_work


def demand_forces_of_gradients(table, reference, size):
    """Require forces, power and energy of a random motion by the gradients."""
    rng = np.random.default_rng(3)
    positions = reference + size * rng.normal(size=reference.shape)
    velocities = rng.normal(size=reference.shape)
    for time in (0.0, 1e-4):
        forces, *scalars, _ = forces_and_energies(table, positions, velocities, viscosity(time))
        expected, *expected_scalars = forces_by_sums(table, positions, velocities, MATERIAL, viscosity(time))
        assert np.abs(forces - expected).max() < 1e-12 * np.abs(expected).max()
        assert scalars == pytest.approx(expected_scalars, rel=1e-12)


@pytest.mark.parametrize("kind", ["quad4", "quad9", "tri6"])
def test_mapped_elements_are_those_of_the_gradients(kind, distorted_mesh):
    """Forces equal those of scikit-fem's gradients to rounding."""
    triangles = distorted(plate_mesh(10.0, 2.438, (8, 4), "triangle"), 0.2, (8, 4))
    mapped = discretise(triangles if kind == "tri6" else distorted_mesh, THICKNESS, kind)
    assert mapped.table.mapping
    demand_forces_of_gradients(mapped.table, mapped.positions, 1e-3)


@pytest.mark.parametrize(("elements", "corner", "is_parallelogram"), [
    ((8, 4), (0.0, 0.0), True), ((1, 1), (0.0, 0.0), True), ((1, 1), (1.5, -0.3), False),
])  # fmt: skip
def test_congruent_elements_are_those_of_the_gradients(elements, corner, is_parallelogram):
    """Sheared parallelograms take all points at once, another quadrilateral one by one."""
    mesh = plate_mesh(10.0, 2.438, elements)
    mesh.points[:, 0] += 0.4 * mesh.points[:, 1]
    mesh.points[0, :2] += corner
    d = discretise(mesh, THICKNESS)
    assert d.table.weights.shape == (4, 1)
    assert (scratch_for(d.table).quadrilateral is not None) == is_parallelogram
    demand_forces_of_gradients(d.table, d.positions, 1e-2)


@pytest.mark.parametrize(("shape", "sizes"), [
    ("rectangles", 1), ("graded", 32), ("turned", None), ("sheared", None), ("one of many", None),
    ("mirrored", 32), ("mirrored and distorted", None),
])  # fmt: skip
def test_rectangles_of_nine_nodes_are_those_of_the_gradients(shape, sizes):
    """Rectangles of one size or several have sizes, others None."""
    mesh = plate_mesh(10.0, 2.438, (8, 4))
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    if shape == "graded":
        x *= 1.0 - 0.03 * x
        y *= 1.0 + 0.2 * y
    elif shape.startswith("mirrored"):
        x *= -1.0 + 0.03 * x
        y += 0.0 if sizes else 0.04 * x * y
    elif shape == "turned":
        (cells,) = (block.data for block in mesh.cells if block.type == "quad")
        cells[:] = np.roll(cells, 1, axis=1)
    elif shape == "sheared":
        x += 0.4 * y
    elif shape == "one of many":
        mesh.points[mesh.points[:, 0].argmax()] += 0.3, 0.1, 0.0
    d = discretise(mesh, THICKNESS, "quad9")
    actual = rectangle_sizes(d.table.gradients.reshape(9, 9, 2, -1), d.table.weights, 1e-12)
    assert (None if actual is None else actual.shape[1]) == sizes
    demand_forces_of_gradients(d.table, d.positions, 1e-2)


def test_rigid_motion_gives_no_force(discretisation):
    """Zero to rounding against E t, the force of a unit strain."""
    for angle, shift in ((0.0, 0.0), (0.26, 0.0), (2.0, 0.0), (-0.9, 10.0)):
        positions = to_global(angle) @ discretisation.positions + shift
        forces, _ = internal_forces(discretisation.table, positions)
        assert np.abs(forces).max() < 2e-14 * 200e9 * THICKNESS * 10.0


def test_energy_of_constant_strain(discretisation):
    gradient = to_global(-0.3) @ np.array([[1.01, 0.02], [0.0, 0.995]])
    strain = 0.5 * (gradient.T @ gradient - np.eye(2))
    density = 0.5 * 200e9 / (1 - 0.09) * (0.7 * np.sum(strain**2) + 0.3 * np.trace(strain) ** 2)
    energy = elastic_energy(gradient @ discretisation.positions, discretisation.table, MATERIAL)
    assert energy == pytest.approx(density * 10.0 * 2.438 * THICKNESS, rel=1e-12)


def test_every_block_counts():
    """Forces of two blocks and a rest are the sum over elements."""
    mesh = distorted(plate_mesh(10.0, 2.438, (19, 7)), 0.2, (19, 7))
    d = discretise(mesh, THICKNESS)
    assert d.table.connectivity.shape[1] == 2 * simd_blocks.BLOCK_SIZE + 5
    positions = d.positions + np.random.default_rng(7).normal(0.0, 1e-3, d.positions.shape)
    forces, _ = internal_forces(d.table, positions)
    expected = np.zeros_like(forces)
    for element in range(d.table.connectivity.shape[1]):
        names = ("connectivity", "gradients", "weights")
        parts = (getattr(d.table, name)[:, element : element + 1] for name in names)
        connectivity, gradients, weights = map(np.ascontiguousarray, parts)
        alone = d.table._replace(connectivity=connectivity, gradients=gradients, weights=weights)
        expected += internal_forces(alone, positions)[0]
    assert_allclose(forces, expected, atol=1e-12 * np.abs(forces).max(), rtol=0.0)


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


def shuffled(table, number):
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
    positions_and_velocities = (
        d.positions + rng.normal(0.0, 1e-3, d.positions.shape),
        rng.normal(size=d.positions.shape),
    )
    damped = Viscosity(1e3, 3e2, 4e2)
    positions, velocities = (np.ascontiguousarray(values[:, back]) for values in positions_and_velocities)
    force, power = internal_forces(d.table, *positions_and_velocities, damped, hourglass=hourglass)
    shuffled_table = shuffled(d.table, number)
    shuffled_force, shuffled_power = internal_forces(
        shuffled_table, positions, velocities, damped, hourglass=hourglass
    )
    assert_allclose(shuffled_force[:, number], force, rtol=0.0, atol=1e-12 * np.abs(force).max())
    assert shuffled_power == pytest.approx(power, rel=1e-12)


def test_a_plate_is_a_lattice_with_one_idle_slot_between_rows():
    lattice = simd_blocks.find_lattice(discretise(plate_mesh(10.0, 2.438, ELEMENTS), 0.05).table.connectivity)
    assert lattice is not None
    assert lattice.element.size == 6 * 21 - 1
    assert (lattice.element < 0).sum() == lattice.idle.size == 5


def test_triangles_shuffled_nodes_and_elements_on_each_other_are_no_lattice():
    table = discretise(plate_mesh(10.0, 2.438, ELEMENTS), 0.05).table
    number = np.random.default_rng(1).permutation(147)
    assert simd_blocks.find_lattice(shuffled(table, number).connectivity) is None
    assert simd_blocks.find_lattice(np.hstack([table.connectivity, table.connectivity[:, :1]])) is None
    triangles = discretise(plate_mesh(10.0, 2.438, ELEMENTS, "triangle"), 0.05, "tri3").table
    assert simd_blocks.find_lattice(triangles.connectivity) is None


E, NU, T = 2e11, 0.3, 0.05
MODULI = st_venant_kirchhoff(E, NU)


def stiffness(d, kind):
    matrix = stiffness_matrix(d.table, MODULI)
    if kind == "quad4-reduced":
        matrix = matrix + hourglass_matrix(d.table, hourglass_control(d, T, MODULI), d.positions.shape[1])
    return matrix


def tip_deflection(length, width, counts, kind):
    """Tip deflection of a cantilever over that of Timoshenko's beam.

    The reference is P L^3/(3 E I) + 6/5 P L/(G A); the load is the parabola of shear.
    """
    d = discretise(plate_mesh(length, width, counts), T, kind)
    x, y = d.positions
    clamped = np.isclose(x, x.max())
    free = np.isclose(x, x.min())
    eta = (y - y.min()) / width
    share = np.where(free, 6.0 * eta * (1.0 - eta) if counts[1] > 1 else 1.0, 0.0)
    load = np.concatenate([np.zeros(x.size), share / share.sum()])
    moves = ~np.concatenate([clamped, clamped & np.isclose(eta, eta[clamped].min())])
    matrix = stiffness(d, kind).tocsc()[moves][:, moves]
    displacement = np.zeros(2 * x.size)
    displacement[moves] = scipy.sparse.linalg.spsolve(matrix, load[moves])
    inertia, shear = T * width**3 / 12.0, E / (2.0 * (1.0 + NU))
    exact = length**3 / (3.0 * E * inertia) + 1.2 * length / (shear * T * width)
    return float(displacement @ load / exact)


@pytest.mark.parametrize("slenderness", [0.02, 0.1, 0.25])
def test_a_cantilever_of_one_element_across_bends_as_a_beam(slenderness):
    """20 elements along are within 2 %, where quad4 locks."""
    assert tip_deflection(10.0, 10.0 * slenderness, (20, 1), "quad4-reduced") == pytest.approx(1.0, abs=0.02)
    if slenderness == 0.02:
        assert tip_deflection(10.0, 0.2, (20, 1), "quad4") < 0.5


def test_refined_along_the_slender_beam_it_converges():
    """Second order along, up to the effect of width over length."""
    deflections = [tip_deflection(10.0, 0.2, (n, 1), "quad4-reduced") for n in (5, 10, 20, 40)]
    changes = np.diff(deflections)
    assert changes[:2] / changes[1:] == pytest.approx(4.0, rel=0.05)
    assert deflections[-1] == pytest.approx(1.0, abs=5e-4)


def test_a_rectangle_in_pure_bending_stores_what_the_beam_does():
    """The exact bending field of plane stress has the beam's energy.

    u = k x y and v = -k (x^2 + nu y^2)/2, of curvature k, at the nodes of one element.
    """
    length, width, k = 3.0, 0.8, 1e-6
    d = discretise(plate_mesh(length, width, (1, 1)), T, "quad4-reduced")
    x, y = d.positions - d.positions.mean(axis=1, keepdims=True)
    u = np.concatenate([k * x * y, -0.5 * k * (x**2 + NU * y**2)])
    energy = 0.5 * u @ (stiffness(d, "quad4-reduced") @ u)
    assert energy == pytest.approx(0.5 * E * T * width**3 / 12.0 * k**2 * length, rel=1e-9)


SVK = "st-venant-kirchhoff"


@pytest.mark.parametrize(("kind", "law", "share", "step", "bound"), [
    ("quad4", SVK, 0.0, 1e-2, 1e-10), ("quad4", SVK, 0.2, 1e-2, 1e-10),
    ("quad4", "neo-hookean", 0.2, 1e-4, 1e-8), ("quad4-reduced", SVK, 0.2, 1e-4, 1e-8),
])  # fmt: skip
def test_forces_are_the_slope_of_the_energy_in_any_position(kind, law, share, step, bound):
    """Elements are rotated and strained, and have no resultant or moment."""
    mesh = distorted(plate_mesh(2.0, 1.0, (3, 2)), share, (3, 2))
    d, material = discretise(mesh, T, kind), MATERIALS[law].make(E, NU)
    control = hourglass_control(d, T, MODULI) if ELEMENT_KINDS[kind].hourglass else None
    random = np.random.default_rng(1)
    turned = np.array([[0.3, -1.1], [0.9, 0.2]]) @ d.positions
    positions = turned + random.normal(0.0, 0.02, d.positions.shape)
    direction = random.normal(size=positions.shape)
    force = internal_forces(d.table, positions, material=material, hourglass=control)[0]
    expected = slope(lambda at: elastic_energy(at, d.table, material, control), positions, direction, step)
    assert np.sum(force * direction) == pytest.approx(expected, rel=bound)
    assert np.abs(force.sum(axis=1)).max() < 1e-9 * np.abs(force).max()
    moment = positions[0] * force[1] - positions[1] * force[0]
    assert abs(moment.sum()) < 1e-9 * np.abs(moment).max()


def test_at_rest_the_forces_are_the_stiffness():
    mesh = distorted(plate_mesh(2.0, 1.0, (3, 2)), 0.2, (3, 2))
    d = discretise(mesh, T, "quad4-reduced")
    control = hourglass_control(d, T, MODULI)
    u = 1e-7 * np.random.default_rng(2).normal(size=d.positions.shape)
    force = internal_forces(d.table, d.positions + u, material=MODULI, hourglass=control)[0]
    linear = (stiffness(d, "quad4-reduced") @ u.ravel()).reshape(2, -1)
    assert_allclose(force, linear, atol=1e-5 * np.abs(linear).max(), rtol=0.0)


KINDS = sorted(ELEMENT_KINDS)


@pytest.mark.parametrize(("kind", "law", "share"), [
    ("quad4", SVK, 0.0), *((kind, SVK, 0.2) for kind in KINDS),
    ("quad4", "neo-hookean", 0.2), pytest.param("tri3", "neo-hookean", 0.2, marks=pytest.mark.long),
])  # fmt: skip
def test_patch_of_constant_strain(kind, law, share):
    """Inner nodes are in balance, and boundary nodes carry F S N.

    The deformation is affine with a large rotation.
    """
    mesh = distorted(plate_mesh(10.0, 2.438, (8, 4), ELEMENT_KINDS[kind].cells), share, (8, 4))
    d, material = discretise(mesh, THICKNESS, kind), MATERIALS[law].make(200e9, 0.3)
    moduli = st_venant_kirchhoff(200e9, 0.3)
    hourglass = hourglass_control(d, THICKNESS, moduli) if ELEMENT_KINDS[kind].hourglass else None
    gradient = to_global(0.7) @ np.array([[1.02, 0.013], [0.004, 0.97]])
    positions = gradient @ d.positions + np.array([[3.0], [-1.0]])
    forces, _ = internal_forces(d.table, positions, material=material, hourglass=hourglass)
    x, y = d.positions
    inner = (x > -9.999) & (x < -0.001) & (y > 0.001) & (y < 2.437)
    traction = gradient @ second_piola_kirchhoff(gradient, law) * THICKNESS
    scale = np.abs(traction).max() * 2.438
    assert inner.sum() > 10
    assert np.abs(forces[:, inner]).max() < (1e-13 if kind == "quad4" else 1e-12) * scale
    # The end's two corners also carry half an edge of the sides beside them; these parts cancel.
    end = forces[:, x > -0.001].sum(axis=1)
    assert_allclose(end, traction[:, 0] * 2.438, atol=1e-12 * scale, rtol=0.0)


def second_piola_kirchhoff(gradient, law):
    """S in the plane by textbook formulas, S_33 by bisection."""
    strain = 0.5 * (gradient.T @ gradient - np.eye(2))
    if law == "st-venant-kirchhoff":
        return 200e9 / (1 - 0.09) * (0.7 * strain + 0.3 * np.trace(strain) * np.eye(2))
    shear, lame = 200e9 / 2.6, 200e9 * 0.3 / 1.3 / 0.4
    area = np.linalg.det(gradient)
    low, high = 0.5, 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        value = shear * (middle**2 - 1.0) + lame * np.log(area * middle)
        low, high = (low, middle) if value > 0.0 else (middle, high)
    inverse = np.linalg.inv(gradient.T @ gradient)
    return shear * (np.eye(2) - inverse) + lame * np.log(area * low) * inverse


def test_materials_agree_at_small_strain():
    d = discretise(distorted(plate_mesh(1.0, 1.0, (3, 3)), 0.2, (3, 3)), 1.0)
    positions = d.positions + 1e-7 * np.random.default_rng(2).normal(size=d.positions.shape)
    laws = st_venant_kirchhoff(1e9, 0.3), neo_hookean(1e9, 0.3)
    first, second = (internal_forces(d.table, positions, material=law)[0] for law in laws)
    assert_allclose(first, second, atol=1e-5 * np.abs(first).max(), rtol=0.0)


def test_hourglass_control_sees_only_what_one_point_does_not():
    mesh = distorted(plate_mesh(10.0, 2.438, (8, 4)), 0.2, (8, 4))
    d = discretise(mesh, THICKNESS, "quad4-reduced")
    control = hourglass_control(d, THICKNESS, st_venant_kirchhoff(2e11, 0.3))
    affine = np.array([[1.4, 0.3], [-0.2, 0.9]]) @ d.positions + 5.0
    assert forces_and_energies(d.table, affine, hourglass=control)[3] < 1e-18 * 2e11
    bent = d.positions + 1e-3 * np.array([d.positions[0] * d.positions[1], np.zeros(d.positions.shape[1])])
    assert forces_and_energies(d.table, bent, hourglass=control)[3] > 1.0


def test_the_deformed_frequency_is_the_assembled_one_at_rest(plate_model):
    for plate in ({}, {"element": "tri6"}, {"element": "quad4-reduced"}):
        model = plate_model(elements=(6, 3), plate=plate)
        turned = (to_global(angle) @ model.discretisation.positions for angle in (0.26, 0.13, 0.0))
        frequency = deformed_frequency(model, turned)
        assert frequency == pytest.approx(model.highest_frequency, rel=1e-4)


def test_shapes_that_are_not_finite_have_no_frequency(plate_model):
    model = plate_model(elements=(6, 3))
    shape = model.discretisation.positions
    assert deformed_frequency(model, [np.full_like(shape, np.nan)]) == np.inf
    assert deformed_frequency(model, [np.full_like(shape, np.nan), shape]) == deformed_frequency(
        model, [shape]
    )


def test_a_stretched_plate_has_a_higher_frequency(plate_model):
    """St. Venant-Kirchhoff stiffens by (3 L^2 - 1)/2 at a stretch L."""
    model = plate_model(elements=(6, 3), plate={"poissons_ratio": 0.0})
    positions = 1.1 * model.discretisation.positions
    assert deformed_frequency(model, [positions]) > 1.05 * model.highest_frequency


@pytest.mark.parametrize("poissons_ratio", [0.0, 0.1, 0.3, 0.499])
@pytest.mark.parametrize("area", [-0.8, -0.3, -1e-2, -1e-5, -1e-12, 1e-9, 1e-4, 3e-2, 0.5, 19.0])
def test_the_volume_of_the_free_thickness_to_fifty_digits(poissons_ratio, area):
    """Compare with a solution in decimals by Newton's method.

    The equation is 2 mu (C_33 - 1) + lambda ln(det C C_33) = 0.
    """
    material = neo_hookean(1.0, poissons_ratio)
    with decimal.localcontext(prec=50):
        lame, shear, plane = (*map(Decimal, material), (1 + Decimal(area)).ln())
        exact = -lame / (lame + 2 * shear) * plane
        for _ in range(20):
            residual = 2 * shear * (exact.exp() - 1) + lame * (plane + exact)
            exact -= residual / (2 * shear * exact.exp() + lame)
        volume = float(plane + exact)
    ratio = 0.5 * material.lame / material.shear
    assert _volume_logarithm(ratio, area) == pytest.approx(volume, rel=1e-15, abs=0.0)
