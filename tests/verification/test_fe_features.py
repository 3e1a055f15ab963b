"""Verification: elements, materials, holds, damping, patch, threads and flutter against exact answers."""

from __future__ import annotations

import decimal
from decimal import Decimal
from typing import Any

import numpy as np
import pytest

from fem.explicit.internal_force import scratch_for, subtract_internal_forces
from fem.explicit.measures import energy_of_hourglass, energy_of_strain
from fem.laws.materials import MATERIALS, _logarithms, neo_hookean, st_venant_kirchhoff
from fem.model.plate_model import corner_weights
from fem.plate.elements import discretise, hourglass_control
from fem.plate.kinds import ELEMENT_KINDS
from fem.run.corner import simulate
from fem.stability.deformed import deformed_frequency
from fem.start.rigid_state import RigidStart, to_global
from meshes import distorted, plate_mesh

THICKNESS = 0.053
START = RigidStart(0.26, 0.707, 25.053)
KINDS = sorted(ELEMENT_KINDS)


def worst(result: Any) -> float:
    assert result.passed, [check for check in result.checks if not check.passed]
    return max(map(abs, result.difference.values()))


def forces_of(d: Any, positions: np.ndarray, material: Any, hourglass: Any = None) -> np.ndarray:
    force = np.zeros_like(positions)
    still = np.zeros_like(positions)
    subtract_internal_forces(
        positions, still, None, hourglass, force, d.table, material, scratch_for(d.table, hourglass)
    )
    return -force


@pytest.mark.parametrize(
    ("kind", "law"),
    [*((kind, "st-venant-kirchhoff") for kind in KINDS), ("quad4", "neo-hookean"), ("tri3", "neo-hookean")],
)
def test_patch_of_constant_strain_on_distorted_elements(kind, law):
    """Every element and material: inner nodes in balance, the boundary's forces as F S N asks, energy V W."""
    mesh = distorted(plate_mesh(10.0, 2.438, (8, 4), ELEMENT_KINDS[kind].cells), 0.2, (8, 4))
    d, material = discretise(mesh, THICKNESS, kind), MATERIALS[law].make(200e9, 0.3)
    moduli = st_venant_kirchhoff(200e9, 0.3)
    hourglass = hourglass_control(d, THICKNESS, moduli) if ELEMENT_KINDS[kind].hourglass else None
    gradient = to_global(0.7) @ np.array([[1.02, 0.013], [0.004, 0.97]])
    forces = forces_of(d, gradient @ d.positions, material, hourglass)
    x, y = d.positions
    inner = (x > -9.999) & (x < -0.001) & (y > 0.001) & (y < 2.437)
    scale = 0.02 * 200e9 * THICKNESS * 2.438
    assert inner.sum() > 10
    assert np.abs(forces[:, inner]).max() < 1e-11 * scale
    stress = second_piola_kirchhoff(gradient, law)
    end = forces[:, x > -0.001].sum(axis=1)
    np.testing.assert_allclose(
        end, (gradient @ stress * THICKNESS)[:, 0] * 2.438, atol=1e-10 * scale, rtol=0.0
    )


def second_piola_kirchhoff(gradient: np.ndarray, law: str) -> np.ndarray:
    """S in the plane by the textbook formulas, the thickness stretch by bisection of S_33 = 0."""
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


@pytest.mark.parametrize("law", sorted(MATERIALS))
def test_stress_is_the_slope_of_the_energy(law):
    """At large strains, by differences of the energy along random directions."""
    d, material = discretise(plate_mesh(1.0, 1.0, (2, 2)), 1.0), MATERIALS[law].make(1e6, 0.3)
    random = np.random.default_rng(1)
    positions = np.array([[1.3, 0.2], [0.1, 0.8]]) @ d.positions + random.normal(0.0, 0.02, d.positions.shape)
    direction = random.normal(size=positions.shape)
    energies = [energy_of_strain(positions + k * 1e-4 * direction, d.table, material) for k in (-2, -1, 1, 2)]
    slope = (8.0 * (energies[2] - energies[1]) - (energies[3] - energies[0])) / 12e-4
    assert np.sum(forces_of(d, positions, material) * direction) == pytest.approx(slope, rel=1e-8)


def test_materials_agree_at_small_strain():
    d = discretise(plate_mesh(1.0, 1.0, (3, 3)), 1.0)
    positions = d.positions + 1e-7 * np.random.default_rng(2).normal(size=d.positions.shape)
    first, second = (forces_of(d, positions, law(1e9, 0.3)) for law in (st_venant_kirchhoff, neo_hookean))
    np.testing.assert_allclose(first, second, atol=1e-5 * np.abs(first).max(), rtol=0.0)


def test_hourglass_control_sees_only_what_one_point_does_not():
    mesh = distorted(plate_mesh(10.0, 2.438, (8, 4)), 0.2, (8, 4))
    d = discretise(mesh, THICKNESS, "quad4-reduced")
    control = hourglass_control(d, THICKNESS, st_venant_kirchhoff(2e11, 0.3))
    affine = np.array([[1.4, 0.3], [-0.2, 0.9]]) @ d.positions + 5.0
    assert energy_of_hourglass(affine, d.table, control) < 1e-18 * 2e11
    bent = d.positions + 1e-3 * np.array([d.positions[0] * d.positions[1], np.zeros(d.positions.shape[1])])
    assert energy_of_hourglass(bent, d.table, control) > 1.0


@pytest.mark.parametrize(
    "changes",
    [
        ("plate.distortion=0.2",),
        ("corner.constraint=exact",),
        ("corner.patch_length=1",),
        *(
            pytest.param(each, marks=pytest.mark.long)
            for each in (
                ("plate.element=tri3",),
                ("plate.element=tri6",),
                ("plate.element=quad9", "plate.elements=[8, 3]"),
                ("plate.element=quad4-reduced", "damping.ratio=0.05"),
                ("material.law=neo-hookean",),
                ("corner.damping_ratio=0.2",),
                ("damping.bulk_viscosity=0.06",),
                ("damping.ratio=0.05", "damping.bulk_viscosity=0.06", "corner.damping_ratio=0.3"),
                ("plate.element=tri3", "plate.distortion=0.2", "corner.reaction=none"),
            )
        ),
    ],
)
def test_every_feature_gives_the_rigid_answer(outcome, changes):
    assert worst(outcome("paper-table-3", *changes)) < 5e-6


def test_a_distorted_mesh_and_triangles_are_told_apart(outcome):
    """They are other meshes, not the same one by another name."""
    plain = outcome("paper-table-3").fe_plan.model
    moved = outcome("paper-table-3", "plate.distortion=0.2").fe_plan.model
    cut = outcome("paper-table-3", "plate.element=tri3").fe_plan.model
    assert np.abs(plain.discretisation.positions - moved.discretisation.positions).max() > 0.05
    assert cut.loop.table.connectivity.shape == (3, 240)


def test_the_exact_constraint_holds_the_corner_on_the_wall(outcome):
    result = outcome("paper-table-3", "corner.constraint=exact")
    assert np.abs(result.fe_history["gap"]).max() < 1e-14
    assert (result.fe_history["contact_energy"] == 0.0).all()
    assert np.abs(outcome("paper-table-3").fe_history["gap"]).max() > 1e-8


def test_the_penalty_tends_to_the_exact_constraint(outcome):
    """The gap is N / k: its part of the difference falls with 1 / k."""
    exact = outcome("paper-table-3", "corner.reaction=none", "corner.constraint=exact").fe["t"]
    errors = [
        outcome("paper-table-3", "corner.reaction=none", f"corner.penalty_scale={scale}").fe["t"] - exact
        for scale in (0.1, 1.0, 10.0)
    ]
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 10.0, rtol=0.05)


@pytest.mark.long
def test_a_dashpot_and_bulk_viscosity_take_energy_out(outcome):
    for change in ("corner.damping_ratio=0.2", "damping.bulk_viscosity=0.3"):
        result = outcome("paper-table-3", "corner.reaction=none", "plate.start=unstressed", change)
        assert result.fe_history["damping_work"][-1] < -1e-3
        assert np.abs(result.fe_history["energy_error"]).max() < 1e-9 * result.fe_history["kinetic_energy"][0]


@pytest.mark.parametrize("length", [0.25, 0.8, 1.0, 9.999])
def test_the_patch_s_weighted_mean_is_the_corner_itself(length):
    """Resultant 1, no moment about P, for lengths that end on a node or within an element."""
    d = discretise(plate_mesh(10.0, 2.438, (40, 4)), THICKNESS)
    nodes, weights = corner_weights(d, length)
    assert weights.sum() == pytest.approx(1.0, rel=1e-13)
    assert d.positions[:, nodes] @ weights == pytest.approx((0.0, 0.0), abs=1e-13)
    assert d.positions[0, nodes].min() <= -length * (1.0 - 1e-9)


def test_a_point_deflects_without_bound_and_a_patch_converges(outcome):
    """A point load's deflection grows by the same amount with each halving of the mesh, a patch's stops growing."""
    ratios: dict[str, list[float]] = {"point": [], "patch": []}
    for n in (10, 20, 40, 80):
        for name, change in (("point", ()), ("patch", ("corner.patch_length=2",))):
            elements = f"plate.elements=[{n}, {3 * n // 10}]"
            changes = ("corner.reaction=none", "corner.constraint=exact", "plate.start=unstressed", elements)
            ratios[name].append(ratio_of(*changes, *change))
    point, patch = np.diff(ratios["point"]), np.diff(ratios["patch"])
    assert point[2] == pytest.approx(point[1], rel=0.1)
    assert (np.abs(patch[1:] / patch[:-1]) < 0.45).all()
    assert abs(patch[2]) < 0.05 * point[2]


def ratio_of(*changes: str) -> float:
    """Give of a model that is only built."""
    from tailslap.case.corner.case import CornerCase
    from tailslap.scene.read import read_scene

    return CornerCase(*read_scene("paper-table-3", changes)).plan().deflection_ratio


@pytest.mark.parametrize("threads", [2, pytest.param(3, marks=pytest.mark.long)])
def test_threads_give_the_same_answer_and_repeat_to_the_bit(plate_model, threads):
    model = plate_model(reaction="drag", elements=(40, 12))
    alone = simulate(model, START, 0.384)
    first, second = (simulate(model, START, 0.384, threads=threads) for _ in range(2))
    assert alone.strike is not None
    assert first.strike is not None
    for name, column in first.history.items():
        np.testing.assert_array_equal(column, second.history[name])
    for name in ("t", "v_gx", "v_gy", "omega", "slide"):
        assert first.strike.values[name] == pytest.approx(alone.strike.values[name], rel=1e-8)


def test_the_deformed_frequency_is_the_assembled_one_at_rest(plate_model):
    for plate in ({}, {"element": "tri6"}, {"element": "quad4-reduced"}):
        model = plate_model(elements=(6, 3), plate=plate)
        found = max(
            deformed_frequency(model, to_global(angle) @ model.discretisation.positions)
            for angle in (0.26, 0.13, 0.0)
        )
        assert found == pytest.approx(model.highest_frequency, rel=1e-4)


def test_a_stretched_plate_has_a_higher_frequency(plate_model):
    """St. Venant-Kirchhoff stiffens in tension: stretched by 10 % both ways, by (3 L^2 - 1) / 2, a third."""
    model = plate_model(elements=(6, 3), plate={"poissons_ratio": 0.0})
    positions = 1.1 * model.discretisation.positions
    assert deformed_frequency(model, positions) > 1.05 * model.highest_frequency


@pytest.mark.parametrize("poissons_ratio", [0.0, 0.1, 0.3, 0.499])
@pytest.mark.parametrize("area", [-0.8, -0.3, -1e-2, -1e-5, -1e-12, 1e-9, 1e-4, 3e-2, 0.5, 19.0])
def test_the_stretch_of_the_thickness_to_fifty_digits(poissons_ratio, area):
    """2 mu (C_33 - 1) + lambda ln(det C C_33) = 0, against Newton's method in decimals."""
    material = neo_hookean(1.0, poissons_ratio)
    with decimal.localcontext(prec=50):
        lame, shear, plane = (*map(Decimal, material), (1 + Decimal(area)).ln())
        exact = -lame / (lame + 2 * shear) * plane
        for _ in range(20):
            residual = 2 * shear * (exact.exp() - 1) + lame * (plane + exact)
            exact -= residual / (2 * shear * exact.exp() + lame)
    found = _logarithms(material.lame, material.shear, area)
    assert found == pytest.approx((float(plane), float(exact)), rel=1e-15, abs=0.0)
