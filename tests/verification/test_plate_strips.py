"""Verify contact of the FE plate at strips inside its sides.

Exact answers are those of statics, of a spring, and of the rigid vehicle.
"""

import math

import numpy as np
import pytest
import skfem

from fem.laws.contact_forces import PointCrush
from fem.laws.friction import Drag
from fem.model.impact_model import build_impact_model
from fem.plate.kinds import ELEMENT_KINDS
from fem.plate.properties import (
    ContactProperties,
    ModelError,
    PlateProperties,
    StepProperties,
    StripProperties,
    UnitProperties,
)
from fem.run.impact import FirstTouch, ImpactStepper, simulate_impact
from meshes import plate_mesh
from solver.impact import (
    CrushLaw,
    ImpactVehicle,
    Strip,
    WallContact,
    first_touch,
    group_names,
    solve_impact,
    strikes_of,
)
from solver.impact.strips import points_of

LENGTH, WIDTH, MASS, THICKNESS = 10.0, 2.4, 9979.0, 0.05
MIDDLE, ELEMENT = 0.5 * LENGTH, LENGTH / 16
ELASTIC = PointCrush(2e6, 0.0, 1.0, math.inf, 0.0, 0.0)


def unit(
    strips,
    counts=(16, 4),
    element="quad4",
    modulus=2e11,
    friction=0.0,
    patch_length=0.0,
    law="crush",
    hinges=(),
):
    """The vehicle as a plate with these strips."""
    density = MASS / (LENGTH * WIDTH * THICKNESS)
    plate = PlateProperties(THICKNESS, density, modulus, 0.3, element=element)
    mesh = plate_mesh(LENGTH, WIDTH, counts, ELEMENT_KINDS[element].cells, hinges)
    return UnitProperties(
        mesh, plate, ContactProperties(Drag(friction), law, strips, patch_length=patch_length)
    )


def model_of(*strips, longest=math.inf, **options):
    return build_impact_model([unit(strips, **options)], StepProperties(longest=longest))


PLACES = (0.0, 0.3, 2.5, 4.37, 7.2, 9.9, LENGTH)
"""At corners, on a node, between nodes, and where a patch ends at a corner."""


@pytest.mark.parametrize("patch_length", [0.0, 1.2, 3.0])
@pytest.mark.parametrize("inset", [0.0, 0.13, 0.6])
@pytest.mark.parametrize("element", ["quad4", "quad9", "tri6"])
def test_a_point_is_its_place_in_every_rigid_motion(element, inset, patch_length):
    """Force and moment of its nodes are those of the point."""
    strips = [StripProperties(place, place, inset, ELASTIC) for place in PLACES]
    model = model_of(*strips, element=element, patch_length=patch_length)
    contact, points = model.parameters.contact, ImpactStepper(model).points
    assert np.add.reduceat(contact.weights, contact.first[:-1]) == pytest.approx(np.ones(14), abs=1e-12)
    assert points[0] == pytest.approx(np.tile(np.negative(PLACES), 2), abs=1e-10)
    assert points[1] == pytest.approx(np.repeat([inset, WIDTH - inset], 7), abs=1e-10)
    assert model.contact_groups.tolist() == list(range(14))
    squares = contact.weights * model.discretisation.positions[0, contact.nodes] ** 2
    spread = np.add.reduceat(squares, contact.first[:-1]) - points[0] ** 2
    inside = np.array([2, 3, 4, 9, 10, 11])
    assert spread[inside] == pytest.approx(np.full(6, patch_length**2 / 12.0), abs=0.25 * ELEMENT**2)
    if inset == 0.0:
        assert (np.diff(contact.first)[[0, 2, 6]] == 1).all() == (patch_length == 0.0)


@pytest.mark.parametrize(("place", "length", "element"), [
    (0.0, 0.4, "0.5875"), (4.9, 0.62, "0.6625"), (LENGTH, 0.6, "0.6625"), (2.2, 10.1, "0.5875"),
])  # fmt: skip
def test_a_patch_shorter_than_its_element_or_longer_than_the_side_is_refused(place, length, element):
    """The elements behind the hinge of the mesh are longer."""
    point = StripProperties(place, place, 0.0, ELASTIC)
    with pytest.raises(ModelError, match=f"between {element} m, an element, and 10 m") as caught:
        model_of(point, patch_length=length, hinges=(4.7,))
    assert caught.value.wrong == "patch_length"


@pytest.mark.parametrize("inset", [0.0, 0.2])
@pytest.mark.parametrize(("begin", "end"), [(0.0, LENGTH), (1.37, 8.11), (2.7, 2.9), (2.5, 5.0)])
@pytest.mark.parametrize("element", ["quad4", "quad9", "tri3"])
def test_a_line_has_the_moments_of_its_length(element, begin, end, inset):
    """Force, moment and rotational stiffness are exact, whatever the mesh."""
    law = PointCrush(3e5, 2e4, 0.04, 1e5, 9e5, 2e4)
    model = model_of(StripProperties(begin, end, inset, law), element=element)
    near, points = model.contact_groups == 0, ImpactStepper(model).points
    for name, value in zip(PointCrush._fields, law, strict=True):
        if name != "returned":
            parts = getattr(model.parameters.contact.law, name)[near] / value
            assert parts.sum() == pytest.approx(end - begin, rel=1e-12)
    places = -points[0, near]
    assert (places.min(), places.max()) == pytest.approx((begin, end), abs=1e-10)
    assert parts @ places == pytest.approx(0.5 * (end**2 - begin**2), rel=1e-9)
    assert parts @ places**2 == pytest.approx((end**3 - begin**3) / 3.0, rel=1e-9)
    assert points[1, near] == pytest.approx(np.full(near.sum(), inset), abs=1e-10)


@pytest.mark.parametrize("element", ["quad4", "quad9", "tri3", "tri6"])
def test_an_even_pressure_along_a_side_loads_its_nodes_consistently(element):
    model = model_of(StripProperties(0.0, LENGTH, 0.0, ELASTIC), element=element)
    contact, scalar = model.parameters.contact, model.discretisation.scalar
    lengths = np.repeat(contact.law.stiffness / ELASTIC.stiffness, np.diff(contact.first))
    loads = np.bincount(contact.nodes, lengths * contact.weights, scalar.N)
    sides = skfem.FacetBasis(
        scalar.mesh, scalar.elem, facets=scalar.mesh.facets_satisfying(lambda x: abs(x[1] % WIDTH) < 1e-9)
    )
    expected = skfem.LinearForm(lambda v, w: v).assemble(sides)
    assert loads == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("inset", [0.0, 0.2])
def test_a_line_pressed_flat_is_a_spring_of_its_stiffness_and_length(inset):
    """Half a period of an oscillator, within the flexibility of the plate."""
    stiffness, speed, begin = 4e5, 3.0, 1.37
    law = PointCrush(stiffness, 0.0, 1.0, math.inf, 0.0, 0.0)
    strip = StripProperties(begin, LENGTH - begin, inset, law)
    spring, errors = stiffness * (LENGTH - 2.0 * begin), []
    half = math.pi * math.sqrt(MASS / spring)
    for modulus in (2e12, 2e13):
        model = model_of(strip, modulus=modulus, longest=2e-5)
        touch = FirstTouch(0.0, 0.0, -speed, height=-inset)
        run = simulate_impact(model, touch, 2e-4, 1.2 * half)
        h, force = run.history, run.history["force_normal"]
        first = np.interp(0.5 * half, h["t"] - 0.5 * h["t"][1], force)
        errors.append(abs(first / (speed * math.sqrt(spring * MASS)) - 1.0))
        impulse = h["normal_impulse"][-1] / (2.0 * MASS * speed)
        errors[-1] = max(errors[-1], abs(impulse - 1.0))
    assert errors[1] < 1e-4
    assert errors[1] < 0.5 * errors[0]


LAWS = CrushLaw(2e6, 0.0, 0.22), CrushLaw(1.5e6, 0.0, 0.3, 3e5), CrushLaw(2e6, 0.0, 0.0, 4e5, 8e6)
STRIPS = tuple(
    Strip(at, law, inset)
    for at, law, inset in zip(((0.6, 0.6), (7.23, 7.23), (9.9, 9.9)), LAWS, (0.0, 0.15, 0.0), strict=True)
)
LINE = Strip((2.6, 9.7), CrushLaw(3e5, 0.0, 0.2), 0.05)
VEHICLE, ANGLE, SPEED, FRICTION = ImpactVehicle(LENGTH, WIDTH, MASS), math.radians(15.0), 25.0, 0.4


def on_plate(strip):
    """A strip of the rigid vehicle as that of the plate."""
    law, (begin, end) = strip.law, strip.at
    returned = law.restitution**2
    slopes = law.unloading_stiffness, law.hardening
    crush = PointCrush(law.stiffness, law.initial_force, returned, law.plateau_force, *slopes)
    return StripProperties(begin, end, strip.inset, crush)


def plate_strikes(strips, counts, modulus, names, first, end):
    height = first.y_g - VEHICLE.front_distance * math.sin(ANGLE) - 0.5 * WIDTH * math.cos(ANGLE)
    model = model_of(
        *map(on_plate, strips), modulus=modulus, friction=FRICTION, element="quad9", counts=counts
    )
    run = simulate_impact(model, FirstTouch(ANGLE, first.v_gx, first.v_gy, 0.0, height), 2e-4, end)
    pushes = {names[g]: run.normal[1:, run.group == g].sum(axis=1) for g in np.unique(run.group)}
    return strikes_of(run.history["t"], {name: push for name, push in pushes.items() if push.any()})


@pytest.mark.parametrize(
    ("strips", "counts", "bound"), [(STRIPS, (8, 2), 2e-5), ((STRIPS[0], LINE), (16, 2), 1e-4)]
)
def test_a_stiff_plate_strikes_as_the_rigid_vehicle(strips, counts, bound):
    """The error of impulses is in proportion to 1/E."""
    contact = WallContact(None, FRICTION, strips)
    names = group_names(contact, [LENGTH])
    first = first_touch(VEHICLE, ANGLE, SPEED, contact=contact)
    expected = solve_impact(VEHICLE, contact, first, end=0.6).strikes
    errors = []
    for modulus in (2e12, 8e12):
        strikes = plate_strikes(strips, counts, modulus, names, first, 0.6)
        assert [strike.corner for strike in strikes] == [strike.corner for strike in expected]
        errors.append(
            [one.impulse / other.impulse - 1.0 for one, other in zip(strikes, expected, strict=True)]
        )
    soft, stiff = np.array(errors)
    assert np.abs(soft).max() < 5e-4
    assert np.abs((4.0 * stiff - soft) / 3.0).max() < bound


def test_groups_are_those_of_the_rigid_vehicle():
    """They count both sides and, without crush, the corners of each unit."""
    strips = (*STRIPS, LINE)
    sizes = (np.full((1, 1), value) for value in (LENGTH, WIDTH, MIDDLE))
    rigid = points_of(WallContact(None, 0.0, strips), *sizes)
    places = {
        g: (
            rigid.along[rigid.group == g].mean() - MIDDLE,
            rigid.across[rigid.group == g].mean() + 0.5 * WIDTH,
        )
        for g in np.unique(rigid.group)
    }
    model = model_of(*map(on_plate, strips), patch_length=1.3)
    points, weights = ImpactStepper(model).points, model.parameters.contact.law.stiffness
    for g, place in places.items():
        members = model.contact_groups == g
        mean = np.average(points[:, members], axis=1, weights=weights[members])
        assert mean == pytest.approx(place, abs=1e-9)
    corners = model_of(law="exact")
    x, y = ImpactStepper(corners).points
    assert corners.contact_groups.tolist() == ((x < -MIDDLE) + 2 * (y > 0.5 * WIDTH)).tolist()
