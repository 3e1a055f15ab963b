"""Verify bounds of the strength of a parapet."""

import functools
import itertools
import json
import math
from typing import Any

import numpy as np
import parapet
import pytest
from skfem import Basis, ElementTriP2, FacetBasis, MeshTri

import tailslap
from fem.limit import conic, lower, upper
from fem.limit.bounds import collapse_load
from fem.limit.plate import PlasticPlate
from solver.conditions import RigidBodyError
from solver.parapet import overhang_tension, punching, section_strengths, yield_line_resistance
from tailslap import cli
from tailslap.case.of_arguments import case_of_scene
from tailslap.scene.write import scene_file
from tailslap.studies.parapet import parapet_study
from tailslap.wall_strength import report
from tailslap.wall_strength.strength import Load, bounds_of, wall_plate

WALL_A = parapet.uniform_wall(*parapet.WALLS["A"])
TOP = Load(1.067, WALL_A.height, None)
KN = 1e3


@functools.cache
def bounds_of_wall(name, place):
    """Bounds of a wall loaded in its middle or at its end."""
    height = parapet.WALLS[name][0]
    load = Load(parapet.LOAD_LENGTH, height, (None, 0.0)[place])
    return bounds_of(parapet.uniform_wall(*parapet.WALLS[name]), load)


def coarse(strengths, load=TOP):
    """Return the bounds of a wall on its first mesh."""
    return bounds_of(strengths, load, tolerance=10.0)


@pytest.mark.parametrize(("name", "exact"), parapet.EXACT.items())
def test_bounds_contain_exact_answers(name, exact):
    bounds = parapet.exact_case(name, 0.01)
    margin = 0.1 if "point" in name else 0.007
    assert exact * (1.0 - margin) < bounds.lower.value < exact * (1.0 + 1e-9)
    assert exact * (1.0 - 1e-9) < bounds.upper.value < exact * (1.0 + margin)
    assert bounds.lower.residual < 1e-12
    assert bounds.lower.excess <= 0.0


@pytest.mark.parametrize(
    ("name", "place"),
    [
        pytest.param(name, place, marks=[] if name == "A" else [pytest.mark.long])
        for name in "ABC"
        for place in (0, 1)
    ],
)
def test_walls_agree_with_another_program(name, place):
    bounds = bounds_of_wall(name, place)
    ends = parapet.TRIAL[name][place]
    assert bounds.lower.value <= ends[1] * KN
    assert bounds.upper.value >= ends[0] * KN
    assert bounds.width <= 0.01


@pytest.mark.parametrize("length", [3.0, 4.0])
def test_a_short_wall_turns_over(length):
    bounds = bounds_of(WALL_A, TOP, length)
    expected = length * 58.0 * KN / 0.813
    assert bounds.lower.value == pytest.approx(expected, rel=1e-4)
    assert bounds.upper.value == pytest.approx(expected, rel=1e-4)


def test_a_load_is_within_the_wall():
    with pytest.raises(ValueError, match=r"ends at 3\.4 m, beyond the wall of 3 m"):
        wall_plate(WALL_A, Load(2.5, WALL_A.height, 0.9), 3.0)
    scene = SCENE | {"parapet": SCENE["parapet"] | {"length": "3 m", "end_distance": "0.9 m"}}
    case = case_of_scene(scene, None)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, "_impact", lambda _: (1e5, 2.5, 0.8))
        _, impact = report.strengths_of_loads(case)
    assert impact.load.length == pytest.approx(1.2)
    assert impact.upper == pytest.approx(3.0 * 58.0 * KN / 0.8, rel=1e-3)


def test_the_length_below_which_a_wall_turns_over_is_that_of_a_long_wall():
    scene = SCENE | {"parapet": SCENE["parapet"] | {"length": "3 m"}}
    numbers = tailslap.parapet(scene, band=False).summary["parapet"]
    assert numbers["lower"]["interior"] == pytest.approx(214.0 * KN, rel=1e-3)
    assert numbers["turning_length"] == pytest.approx(329.0 * 0.813 / 58.0, rel=0.02)


def test_affinity():
    """The strength follows from that of one isotropic wall."""
    first, second = (
        bounds_of(parapet.uniform_wall(1.0, 0.0, m_x, 4.0), Load(math.sqrt(m_x / 4.0), 1.0, None))
        for m_x in (4.0, 1.0)
    )
    ratio = 4.0 * KN, math.sqrt(4.0) * KN
    assert first.lower.value / ratio[0] <= second.upper.value / ratio[1]
    assert second.lower.value / ratio[1] <= first.upper.value / ratio[0]
    assert first.lower.value / ratio[0] == pytest.approx(5.85, rel=0.01)


def test_strengths_that_vary_with_the_height():
    levels = np.array([0.0, 0.25, 1.0]) * WALL_A.height
    varying = WALL_A._replace(
        levels=levels, moments=np.array([[40 / 0.813] * 3] * 2 + [[85, 62, 40]] * 2) * KN
    )
    assert varying.base == pytest.approx(56.625 * KN)
    assert varying.resistance(1.067, "interior").force == pytest.approx(382e3, rel=2e-3)
    bounds = bounds_of(varying, TOP)
    assert bounds.lower.value <= 342e3
    assert bounds.upper.value >= 339e3
    assert bounds.width < 0.011


@pytest.mark.parametrize("case", [
    pytest.param(wall, marks=pytest.mark.long if k > 2 else ()) for k, wall in enumerate(parapet.random_walls(8, 3))
])  # fmt: skip
def test_random_walls(case):
    strengths, load, length = case
    bounds = bounds_of(strengths, load, length, 0.2, 300)
    assert 0.0 < bounds.lower.value <= bounds.upper.value
    assert bounds.lower.residual < 1e-12
    assert bounds.lower.excess <= 0.0
    assert bounds.width < 0.5


def test_moments_balance_the_load_in_the_weak_form():
    """The power of the moments equals that of the load."""
    bounds = coarse(parapet.uniform_wall(*parapet.WALLS["A"]), Load(1.067, 0.6, 0.2))
    mesh, moments, value = bounds.lower_mesh, bounds.lower.moments, bounds.lower.value
    w = np.random.default_rng(1).normal(size=Basis(mesh, ElementTriP2()).N)
    basis = Basis(mesh, ElementTriP2(), intorder=4)
    w[basis.get_dofs(lambda x: x[1] == 0.0).all()] = 0.0
    nodes = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    inverse = basis.mapping.invDF(nodes)[..., 0]
    slopes = np.stack([basis.elem.lbasis(nodes, k)[1] for k in range(6)])
    slopes = np.einsum("jit,kjp,kt->tpi", inverse, slopes, w[basis.element_dofs])
    gradients = np.einsum("jit,jp->tpi", inverse, np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]))
    bent = np.einsum("tpi,tpj->tij", slopes, gradients)
    mean, area = moments.mean(axis=1), 0.5 * np.abs(basis.mapping.detA)
    power = area @ (
        mean[:, 0] * bent[:, 0, 0] + mean[:, 1] * bent[:, 1, 1] + 2.0 * mean[:, 2] * bent[:, 0, 1]
    )
    for t, (corners, of_moments) in enumerate(zip(mesh.t.T, moments, strict=True)):
        for a, b in ((0, 1), (1, 2), (0, 2)):
            start, end = mesh.p[:, corners[a]], mesh.p[:, corners[b]]
            along = end - start
            normal = np.array([along[1], -along[0]]) / np.hypot(*along)
            normal *= -np.sign(normal @ (mesh.p[:, corners[3 - a - b]] - start))
            for s, weight in ((0.5 - 0.5 / math.sqrt(3.0), 0.5), (0.5 + 0.5 / math.sqrt(3.0), 0.5)):
                xx, yy, xy = (1.0 - s) * of_moments[a] + s * of_moments[b]
                across = xx * normal[0] ** 2 + yy * normal[1] ** 2 + 2.0 * xy * normal[0] * normal[1]
                slope = ((1.0 - s) * slopes[t, a] + s * slopes[t, b]) @ normal
                power -= weight * np.hypot(*along) * across * slope
    forces = bounds.plate.line_forces(mesh)
    loaded = np.flatnonzero(forces)
    line = FacetBasis(mesh, basis.elem, facets=loaded, intorder=4)
    pushed = (line.interpolate(w) * line.dx).sum(axis=1) @ forces[loaded]
    assert power == pytest.approx(value * pushed, rel=1e-9)


def test_moments_are_within_the_criterion_between_nodes():
    strengths, load, length = next(itertools.islice(parapet.random_walls(9), 8, None))
    bounds = bounds_of(strengths, load, length, tolerance=10.0)
    mesh, plate = bounds.lower_mesh, bounds.plate
    weights = np.random.default_rng(2).dirichlet(np.ones(3), size=50)
    m = np.einsum("pi,tic->tpc", weights, bounds.lower.moments)
    strong = plate.scale * plate.strengths_at(weights @ mesh.p[1, mesh.t])
    for sign, (x, y) in ((1.0, (0, 2)), (-1.0, (1, 3))):
        bent = np.array([[sign * m[..., 0].T, sign * m[..., 2].T], [sign * m[..., 2].T, sign * m[..., 1].T]])
        right = np.array([[strong[x], 0.0 * strong[x]], [0.0 * strong[y], strong[y]]])
        assert np.linalg.eigvalsh((right - bent).transpose(2, 3, 0, 1)).min() > -1e-9 * plate.scale


def test_dissipation_is_that_of_fine_quadrature(monkeypatch):
    """It is above the integral, and close to it."""
    random = np.random.default_rng(5)
    bent, strong = random.normal(size=(20, 3, 3)), 10.0 ** random.uniform(-1.0, 1.0, (20, 3, 4))
    area = random.uniform(0.5, 2.0, (20, 1, 1))
    stated = upper._dissipation(bent, strong, area)
    monkeypatch.setattr(upper, "PARTS", 60)
    points = np.array([corners.mean(axis=0) for corners in upper._parts()])
    k, m = points @ bent, points @ strong
    size = np.sqrt(m[..., [0, 2]] + m[..., [1, 3]])
    scaled = np.empty((*k.shape[:2], 2, 2))
    scaled[..., 0, 0], scaled[..., 1, 1] = k[..., 0] * size[..., 0] ** 2, k[..., 1] * size[..., 1] ** 2
    scaled[..., 0, 1] = scaled[..., 1, 0] = 0.5 * k[..., 2] * size[..., 0] * size[..., 1]
    total = np.maximum(np.linalg.eigvalsh(scaled), 0.0).sum(axis=-1)
    total -= m[..., 1] * k[..., 0] + m[..., 3] * k[..., 1]
    integral = area[:, 0, 0] * total.mean(axis=1)
    assert (stated >= integral * (1.0 - 1e-4)).all()
    assert stated.sum() == pytest.approx(integral.sum(), rel=0.05)
    # No moment within the criterion has more power.
    for angle in np.linspace(0.0, np.pi, 9):
        turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        root = size[..., :, None] * turned
        for first in (0.0, 1.0):
            for second in (0.0, 1.0):
                moment = np.einsum("...ik,k,...jk->...ij", root, [first, second], root)
                power = (moment[..., 0, 0] - m[..., 1]) * k[..., 0] + (moment[..., 1, 1] - m[..., 3]) * k[
                    ..., 1
                ]
                power += moment[..., 0, 1] * k[..., 2]
                assert (power <= total + 1e-9).all()


def test_any_end_of_the_solver_has_a_certificate_or_no_bound(monkeypatch):
    """Bounds of arbitrary vectors remain bounds.

    Without a vector they are 0 and infinite."""
    exact = bounds_of_wall("A", 0)
    solve, random = conic.minimum, np.random.default_rng(4)
    plain = coarse(WALL_A)

    def disturbed(*program):
        x = solve(*program)
        return 1.5 * x + 1e-6 * np.abs(x).max() * random.normal(size=x.size)

    monkeypatch.setattr(conic, "minimum", disturbed)
    scaled = coarse(WALL_A)
    assert 0.999 * plain.lower.value < scaled.lower.value <= exact.upper.value
    assert scaled.lower.residual < 1e-12
    assert 1.001 * plain.upper.value > scaled.upper.value >= exact.lower.value
    monkeypatch.setattr(conic, "minimum", lambda cost, *_: random.normal(size=cost.size))
    arbitrary = coarse(WALL_A)
    assert 0.0 <= arbitrary.lower.value <= exact.upper.value
    assert arbitrary.upper.value >= exact.lower.value
    assert arbitrary.lower.residual < 1e-12 or arbitrary.lower.value == 0.0
    monkeypatch.setattr(conic, "minimum", lambda cost, *_: np.full(cost.size, np.nan))
    nothing = coarse(WALL_A)
    assert (nothing.lower.value, nothing.upper.value) == (0.0, math.inf)


def test_gaps_sum_to_the_difference_of_the_bounds():
    plate = wall_plate(WALL_A, TOP, 5.0)
    mesh = MeshTri.init_tensor(np.array([0.0, 0.5335, 1.0, 1.5, 2.5]), np.array([0.0, 0.4065, 0.813]))
    below = lower.lower_bound(plate, mesh)
    above = upper.upper_bound(plate, mesh)
    gaps = upper.gaps(mesh, above, below.moments)
    assert gaps.min() > -1e-6 * above.value
    assert gaps.sum() == pytest.approx(above.value - below.value, rel=1e-5)
    assert above.value > 1.02 * below.value


def test_bounds_without_refinement_say_how_far_they_are():
    plate = PlasticPlate(
        1.0, 1.0, dict.fromkeys(parapet.SIDES, "clamped"), parapet.UNIT, np.ones((4, 2)), pressure=1.0
    )
    bounds = collapse_load(plate, *parapet.diagonal_mesh(1.0, 1), 1e-6, 1)
    assert bounds.width == bounds.upper.value / bounds.lower.value - 1.0 > 0.01


@pytest.mark.parametrize("place", ["interior", "end"])
def test_formula_is_the_least_of_its_mechanisms(place):
    """The critical length has the least load."""
    height, beam, wall, base, length = 0.9, 12.0, 45.0, 66.0, 1.2
    critical, force = yield_line_resistance(height, beam, wall, base, length, place)
    lines = {"interior": 8.0, "end": 1.0}[place] * (beam + wall)
    lengths = np.linspace(0.8, 1.25, 2001) * critical
    forces = 2.0 / (2.0 * lengths - length) * (lines + base * lengths**2 / height)
    assert force == pytest.approx(forces.min(), rel=1e-6)
    assert force == pytest.approx(2.0 * base * critical / height, rel=1e-12)


def test_section_of_one_layer():
    """The stress block balances the force of the bars."""
    strengths = section_strengths(
        [(0.0, 0.2), (0.9, 0.2)], 30e6, 420e6, 0.05, (500e-6, 250e-6), (400e-6, 400e-6)
    )
    depth = 0.5 * 500e-6 * 420e6 / (0.85 * 30e6)
    assert strengths.moments[2] == pytest.approx(500e-6 * 420e6 * (0.15 - depth))
    assert strengths.moments[3, 0] < strengths.moments[2, 0]
    assert strengths.wall == pytest.approx(0.9 * strengths.moments[0, 0])


@pytest.mark.parametrize("areas", [(0.0, 1e-4), (1e-4, -1e-4), (0.1, 1e-4)])
def test_section_without_bars_or_without_room(areas):
    with pytest.raises(RigidBodyError, match="vertical_bars"):
        section_strengths([(0.0, 0.2), (0.9, 0.2)], 30e6, 420e6, 0.05, areas, (1e-4, 1e-4))


def test_simple_formulas_by_hand():
    """Concrete of 4 ksi, d 8 in, patch 42 by 12 in."""
    inch, kip = 0.0254, 4448.2216152605
    beta = 42.0 / 12.0
    expected = (0.0633 + 0.1265 / beta) * 2.0 * (42.0 + 8.0 + 2.0 * 16.0) * 8.0
    assert punching(4e3 * 6894.757293, 8 * inch, 42 * inch, 12 * inch) == pytest.approx(
        expected * kip, rel=1e-6
    )
    assert overhang_tension(100.0, 3.0, 1.0) == 20.0


SCENE: dict[str, Any] = {
    "name": "wall",
    "vehicle": {"length": "10 m", "width": "2438 mm", "mass": "9979 kg"},
    "impact": {
        "speed": "56 mph",
        "angle": "15 deg",
        "friction": 0.47,
        "restitution": 0.22,
        "test_level": "TL-4",
    },
    "parapet": {
        "height": "0.813 m",
        "wall_strength": "40 kN m",
        "base_strength": "58 kN",
        "load_length": "1.067 m",
    },
}
SECTION = {
    "thickness": "0.3 m", "concrete_strength": "28 MPa", "yield_strength": "420 MPa", "cover": "50 mm",
    "vertical_bars": "650 mm^2/m", "horizontal_bars": "500 mm^2/m",
}  # fmt: skip


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("parapet.wall_strength", "0 kN m"),
        ("parapet.base_strength", "-1 kN"),
        ("parapet.base_strength", None),
        ("parapet.base_strength", [["0.1 m", "58 kN"], ["0.8 m", "40 kN"]]),
        ("parapet.base_strength", [["0 m", "58 kN"], ["2 m", "40 kN"]]),
        ("parapet.load_height", "1 m"),
        ("parapet.load_length", "11 m"),
        ("parapet.end_distance", "4.5 m"),
        ("parapet.section", SECTION),
        ("parapet.height", "0 m"),
    ],
)
def test_bad_input_names_key_value_and_what_is_allowed(key, value):
    with pytest.raises(tailslap.InputError) as error:
        tailslap.rigid(SCENE, {"parapet.length": "10 m", key: value})
    assert key in str(error.value) or "parapet.wall_strength" in str(error.value)
    assert "allowed" in str(error.value) or "required" in str(error.value) or "remove" in str(error.value)


@pytest.mark.parametrize("key", ["vertical_bars", "horizontal_bars"])
@pytest.mark.parametrize("value", ["0 mm^2/m", ["650 mm^2/m", "0 mm^2/m"], "90000 mm^2/m"])
def test_a_section_without_bars_is_refused(key, value):
    table = {"height": "0.9 m", "section": SECTION | {key: value}}
    with pytest.raises(tailslap.InputError, match=f"parapet.section.{key}"):
        tailslap.rigid(SCENE | {"parapet": table})


def test_a_scene_without_the_table_is_refused():
    tables = {name: table for name, table in SCENE.items() if name != "parapet"}
    with pytest.raises(tailslap.InputError, match="parapet"):
        tailslap.parapet(tables)


@pytest.fixture
def rough(monkeypatch):
    """Bounds of commands are within 10 %."""
    monkeypatch.setattr(report, "ALLOWED", dict.fromkeys(report.ALLOWED, 0.1))


def test_command_prints_the_bounds_and_writes_the_page(tmp_path, monkeypatch, capsys, rough):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wall.toml").write_text(scene_file(SCENE, "a wall"), encoding="utf-8")
    assert cli._status(["parapet", "wall.toml", "--json", "--no-band", "--quiet"]) == 0
    assert cli._status(["parapet", "wall.toml", "--json", "--set", "parapet.end_distance=0.3 m"]) == 0
    numbers = json.loads(capsys.readouterr().out)["parapet"]
    assert numbers["lower"]["impact"] < 219e3 < numbers["upper"]["impact"] * 1.01
    assert numbers["aashto"]["interior"] == pytest.approx(387.7e3, rel=1e-3)
    ratio = numbers["demand_over_capacity"]
    assert ratio["lower"] < ratio["median"] < ratio["upper"]
    assert 0.0 <= ratio["exceeded"] <= 1.0
    assert ratio["nominal"] == pytest.approx(numbers["demand"] / numbers["lower"]["impact"])
    (page,) = tmp_path.glob("results/*end_distance*/report.html")
    assert "flexural strength" in page.read_text(encoding="utf-8").lower()
    assert {path.name for path in page.parent.glob("*.png")} == {
        "parapet-impact.png",
        "parapet-impact-dark.png",
    }


def test_a_machine_that_cannot_draw_writes_the_page_without_pictures(tmp_path, monkeypatch, rough):
    def window(*_, **__):
        raise ImportError("no window")

    monkeypatch.setattr("postprocess.fields.panels.Canvas", window)
    result = tailslap.parapet(SCENE | {"parapet": SCENE["parapet"] | {"end_distance": 2.0}}, band=False)
    with pytest.warns(UserWarning, match="no pictures are drawn: no window"):
        folder = result.save(tmp_path / "wall")
    assert (folder / "report.html").is_file()
    assert not list(folder.glob("*.png"))


def test_without_proof_the_command_fails_and_prints_no_bound(monkeypatch):
    monkeypatch.setattr(conic, "minimum", lambda cost, *_: np.full(cost.size, np.nan))
    result = tailslap.parapet(SCENE, band=False)
    assert result.passed is False
    assert result.summary["parapet"]["lower"] == {"interior": None, "end": None}
    assert result.summary["parapet"]["upper"] == {"interior": None, "end": None}
    assert "not proven" in result.summary["answer"]


def test_study_over_height_length_and_distance(monkeypatch):
    for name in ("HEIGHTS", "LENGTHS"):
        monkeypatch.setattr(parapet_study, name, (0.75, 1.0))
    monkeypatch.setattr(parapet_study, "DISTANCES", (0.0, 3.0))
    result = tailslap.study("parapet", SCENE)
    low, high, *_, end, far = result.summary["rows"]
    assert low["lower"] > high["upper"]
    assert end["upper"] < far["lower"]
    assert low["lower"] * 0.75 == pytest.approx(high["lower"], rel=0.05)
    assert result.summary["interior_from"] == pytest.approx(3.0 * 0.813)
    assert [*result.charts][1:] == [f"strength-over-{name}" for name in parapet_study.SWEPT]
