"""Verify that starts conserve quantities of the rigid body to rounding.

Plates are of steel, or bend by centimetres. Equilibrium of the elastic state is tested by the rigid acceleration and
the force at the corner that balance the internal forces best.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest

from fem.explicit.elastic_damping import damped_time_step
from fem.laws.constraints import Exact
from fem.model.plate_model import PlateModel
from fem.run.corner import Stepper, simulate
from fem.stability.rounding import RoundingNoise, rounding_noise
from fem.start.equilibrium import _combined, elastic_forces, equilibrium, tangent_matrix
from fem.start.inertia_relief import (
    RigidStart,
    TooSoftError,
    inertia_load,
    relieved_displacement,
    to_global,
)
from fem.start.start_kinds import START_KINDS, start_fields
from meshes import plate_mesh
from tailslap.case.corner import corner_case, corner_run
from tailslap.cli import WRONG_INPUT, _status
from tailslap.scene.read import read_scene

START = RigidStart(angle=0.26, omega=0.707, corner_speed=25.053)
SLOW = RigidStart(angle=0.26, omega=0.1, corner_speed=2.0)
RELIEVED = ("inertia-relief", "inertia-relief-momenta")
SOFT = {"youngs_modulus": 2e7}  # first frequency 1.1 Hz
STRIP = plate_mesh(10.0, 0.1, (40, 2), "quad")

Make = Callable[..., PlateModel]

GIVEN: dict[str, dict[str, Any]] = {
    "steel": {},
    "soft": {"plate": SOFT},
    "soft, exact": {"plate": SOFT, "corner": {"constraint": "exact"}},
    "soft, friction on a patch": {"plate": SOFT, "corner": {"patch_length": 1.0}, "reaction": "drag"},
}


@pytest.fixture(params=GIVEN)
def model(request, plate_model):
    """Plates whose corner is displaced by micrometres and by centimetres."""
    return plate_model(**GIVEN[request.param])


def at_corner(model, values):
    """A nodal field at the corner, shape (2,)."""
    corner = model.parameters.corner
    return np.asarray(values[:, corner.nodes] @ corner.weights)


def rigid_velocities(model, start):
    """Velocities [m/s] of the undeformed plate, rotating about its sliding corner."""
    body = model.discretisation.positions
    arm = to_global(start.angle) @ (body - at_corner(model, body)[:, None])
    return start.omega * np.array([-arm[1], arm[0]]) + np.array([[start.corner_speed], [0.0]])


def best_angle(model, positions):
    """Clockwise angle [rad] of the best rotation, by singular values."""
    masses = model.parameters.mass
    fields = (model.discretisation.positions, positions)
    body, place = (field - (field @ masses / masses.sum())[:, None] for field in fields)
    u, _, v = np.linalg.svd((place * masses) @ body.T)
    rotation = u @ v
    return float(-np.arctan2(rotation[1, 0], rotation[0, 0]))


class Balance(NamedTuple):
    """Rigid acceleration, corner forces and residual of the internal forces.

    Units are m/s^2 for the corner, 1/s^2 for the square of the spin, and N; the residual is over the largest force.
    """

    along: float
    across: float
    spin_squared: float
    tangential: float
    normal: float
    residual: float


def balance(model, positions):
    """Fit rigid accelerations and corner forces to internal forces.

    m (a + alpha x r - omega^2 r) = f + F.
    """
    masses, corner = model.parameters.mass, model.parameters.corner
    none = np.zeros_like(masses)
    x, y = (positions - at_corner(model, positions)[:, None]) * masses
    support = none.copy()
    support[corner.nodes] = corner.weights
    pairs = ((masses, none), (none, masses), (-y, x), (-x, -y), (-support, none), (none, -support))
    columns = np.array([np.concatenate(pair) for pair in pairs]).T
    sizes, forces = np.linalg.norm(columns, axis=0), -elastic_forces(model.parameters)(positions).ravel()
    solution = np.linalg.lstsq(columns / sizes, forces, rcond=None)[0] / sizes
    residual = np.abs(columns @ solution - forces).max() / np.abs(forces).max()
    along, across, _, spin_squared, tangential, normal = map(float, solution)
    return Balance(along, across, spin_squared, tangential, normal, float(residual))


@pytest.mark.parametrize("kind", ["inertia-relief-momenta", "unstressed"])
def test_momenta_of_the_rigid_body(model, kind):
    velocities = start_fields(model, START, kind)[1]
    expected = rigid_velocities(model, START) @ model.parameters.mass
    np.testing.assert_allclose(velocities @ model.parameters.mass, expected, rtol=1e-12)


def test_inertia_relief_alone_has_another_momentum(plate_model):
    """Its centre is displaced and rotates on a longer arm."""
    model = plate_model(plate=SOFT)
    velocities, rigid = start_fields(model, START, "inertia-relief")[1], rigid_velocities(model, START)
    assert (velocities @ model.parameters.mass)[1] / (rigid @ model.parameters.mass)[1] > 1.01


@pytest.mark.parametrize("kind", ["inertia-relief", "unstressed"])
def test_speed_of_the_corner_and_spin(model, kind):
    """The spin by the best rotation half a millisecond earlier and later."""
    positions, velocities = start_fields(model, START, kind)
    assert at_corner(model, velocities)[0] == pytest.approx(START.corner_speed, rel=1e-13)
    before, after = (best_angle(model, positions + time * velocities) for time in (-5e-4, 5e-4))
    assert (before - after) / 1e-3 == pytest.approx(START.omega, rel=1e-6)


@pytest.mark.parametrize("kind", START_KINDS)
def test_angle_of_the_best_rotation(model, kind):
    assert best_angle(model, start_fields(model, START, kind)[0]) == pytest.approx(START.angle, rel=1e-10)


@pytest.mark.parametrize("kind", START_KINDS)
def test_the_corner_stays_on_the_wall(model, kind):
    """The distance is the deflection of the spring, the velocity its rate."""
    positions, velocities = start_fields(model, START, kind)
    (slide, height), rate = at_corner(model, positions), at_corner(model, velocities)[1]
    assert slide == pytest.approx(0.0, abs=1e-14)
    corner = model.parameters.corner
    if kind == "unstressed" or isinstance(corner.constraint, Exact):
        assert (height, rate) == (pytest.approx(0.0, abs=1e-14), pytest.approx(0.0, abs=1e-13))
        return
    assert height == pytest.approx(-balance(model, positions).normal / corner.stiffness, rel=1e-5)
    assert rate == pytest.approx(_gap_rate(model, kind), rel=0.05)


def _gap_rate(model, kind):
    """Rate [m/s] of the equilibrium gap between 1 and 5 ms."""
    stepper, gaps, step = Stepper(model), [], model.parameters.time_step
    counts = [round(time / step) for time in (1e-3, 5e-3)]
    for count in counts:
        values = stepper.measure(stepper.advance(stepper.start(START, kind), count))
        row = values._asdict()
        later = RigidStart(row["theta"], row["omega"], row["v_p"])
        gaps.append(at_corner(model, start_fields(model, later, "inertia-relief")[0])[1])
    return float(gaps[1] - gaps[0]) / ((counts[1] - counts[0]) * step)


@pytest.mark.parametrize("kind", RELIEVED)
def test_the_elastic_state_is_in_equilibrium(model, kind):
    """Steel is held to the linear equations, whose error is its strain."""
    positions, _ = start_fields(model, START, kind)
    state, steel = balance(model, positions), model.tangent_moduli.c_11 > 1e10
    assert state.residual < (1e-5 if steel else 1e-10)
    assert state.normal < -3000.0
    assert abs(state.across) < 1e-5 * abs(state.along)
    friction = 0.47 if model.parameters.friction else 0.0
    assert state.tangential / state.normal == pytest.approx(friction, abs=1e-6)
    if kind == "inertia-relief":
        assert state.spin_squared == pytest.approx(START.omega**2, rel=1e-6)


@pytest.mark.parametrize("kind", RELIEVED)
def test_a_strip_is_in_equilibrium_too(plate_model, kind):
    """Its deflection is 6 cm, and 1.3 m at a higher spin."""
    strip = plate_model(mesh=STRIP, plate=SOFT, corner={"constraint": "exact"})
    for start in (SLOW, START):
        positions, velocities = start_fields(strip, start, kind)
        state = balance(strip, positions)
        assert state.residual < 1e-6
        assert abs(state.across) < 1e-7 * abs(state.along)
        assert best_angle(strip, positions) == pytest.approx(start.angle, rel=1e-10)
        if kind == "inertia-relief":
            assert state.spin_squared == pytest.approx(start.omega**2, rel=1e-6)
        else:
            expected = rigid_velocities(strip, start) @ strip.parameters.mass
            np.testing.assert_allclose(velocities @ strip.parameters.mass, expected, rtol=1e-12)


@pytest.mark.parametrize("kind", RELIEVED)
def test_a_strip_without_equilibrium_is_refused(plate_model, kind):
    strip = plate_model(mesh=STRIP, plate={"youngs_modulus": 2e4}, corner={"constraint": "exact"})
    with pytest.raises(TooSoftError):
        start_fields(strip, START, kind)


@pytest.mark.parametrize("element", ["quad4", "quad9", "tri6"])
def test_the_tangent_matrix_is_the_derivative_of_the_forces(plate_model, distorted_mesh, element):
    """A five-point difference is exact for cubic forces."""
    mesh = None if element == "tri6" else distorted_mesh
    model = plate_model(mesh=mesh, elements=(8, 4), plate={"element": element})
    body, random = model.discretisation.positions, np.random.default_rng(3)
    place = np.array([[1.1, 0.2], [-0.3, 0.9]]) @ body + 0.01 * random.standard_normal(body.shape)
    direction = 0.01 * random.standard_normal(body.shape)
    forces = elastic_forces(model.parameters)
    near, far = (forces(place + step * direction) - forces(place - step * direction) for step in (1.0, 2.0))
    derivative = (8.0 * near - far) / 12.0
    expected = np.abs(derivative).max()
    matrix = tangent_matrix(model, place)
    assert abs(matrix - matrix.T).max() < 1e-13 * abs(matrix).max()
    assert (matrix @ direction.ravel()).reshape(2, -1) == pytest.approx(
        derivative, rel=0.0, abs=1e-12 * expected
    )


@pytest.mark.parametrize(
    ("factor", "least", "most"), [(None, 0, 1), (1.0, 0, 0), (0.0, 1, 2), (-0.5, 1, 2), (0.5, 0, 1)], ids=str
)
def test_a_solver_of_another_state_serves_as_far_as_it_converges(
    plate_model, monkeypatch, factor, least, most
):
    """A solver that converges slowly or not at all is replaced."""
    soft = plate_model(plate=SOFT, corner={"constraint": "exact"})
    body = soft.discretisation.positions - at_corner(soft, soft.discretisation.positions)[:, None]
    assembled: list[int] = []

    def counted(*arguments: Any) -> Any:
        assembled.append(1)
        return tangent_matrix(*arguments)

    monkeypatch.setattr("fem.start.equilibrium.tangent_matrix", counted)

    def load_at(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        place = to_global(-best_angle(soft, place)) @ (place - at_corner(soft, place)[:, None])
        return place, inertia_load(soft, place, START)[0]

    begin = body + relieved_displacement(soft, START)[0]
    good, solve = equilibrium(soft, begin, load_at, lambda load: 0.0 * load)
    assembled.clear()
    other = soft.elastic if factor is None else lambda load: factor * solve(load)
    place, _ = equilibrium(soft, begin, load_at, other)
    assert least <= len(assembled) <= most
    assert place == pytest.approx(good, abs=1e-9)


def test_each_equilibrium_begins_at_the_state_that_the_last_ones_predict(plate_model, monkeypatch):
    """States near the start take fewer steps than that of the start."""
    soft, steps = plate_model(plate=SOFT, corner={"constraint": "exact"}), list[int]()

    def counted(*arguments: Any) -> Any:
        steps.append(0)
        return equilibrium(*arguments)

    def combined(*arguments: Any) -> Any:
        steps[-1] += 1
        return _combined(*arguments)

    monkeypatch.setattr("fem.start.inertia_relief.equilibrium", counted)
    monkeypatch.setattr("fem.start.equilibrium._combined", combined)
    start_fields(soft, START, "inertia-relief-momenta")
    first, later, earlier, corrected, *_ = steps
    assert later < first
    assert earlier <= first // 2
    assert corrected <= first
    assert len(steps) == 6


def test_a_plate_too_soft_for_its_start_is_refused(capsys):
    changes = ["--set", "plate.youngs_modulus=", "--set", "plate.first_frequency=0.1 Hz", "--no-pictures"]
    assert _status(["run", "mash-tl4-sut", *changes]) == WRONG_INPUT
    assert 'allowed is "unstressed"' in capsys.readouterr().err


def ripple(model, kind):
    """Largest difference of the reaction from that of equilibrium, relative.

    The elastic state is in equilibrium at the angle, spin and speed of the run.
    """
    rows = simulate(model, START, 0.38, kind, rows=12).history
    history = {name: column[:-1] for name, column in rows.items()}
    normal = []
    for angle, omega, speed in zip(*(history[name] for name in ("theta", "omega", "v_p")), strict=True):
        positions, _ = start_fields(model, RigidStart(angle, omega, speed), "inertia-relief")
        normal.append(balance(model, positions).normal)
    equilibrium = np.array(normal)
    return float(np.abs(history["reaction_normal"] - equilibrium).max() / np.abs(equilibrium).max())


def test_the_reaction_does_not_oscillate(plate_model):
    """Inertia relief follows the motion without friction, an unstressed plate oscillates."""
    model = plate_model(plate={"youngs_modulus": 2e9}, elements=(10, 3), corner={"constraint": "exact"})
    assert max(ripple(model, kind) for kind in RELIEVED) < 2e-3
    assert ripple(model, "unstressed") > 0.5


@pytest.mark.parametrize("threads", [1, pytest.param(2, marks=pytest.mark.long)])
def test_positions_stay_within_the_span(plate_model, threads):
    """The corner is within one span of the origin at any time."""
    model = plate_model(reaction="drag")
    stepper = Stepper(model, threads)
    state = stepper.start(START, "inertia-relief")
    corner = model.parameters.corner.nodes[0]
    for _ in range(20):
        state = stepper.advance(state, 250)
        assert abs(state.positions[0, corner]) <= model.parameters.span + 1e-2
    row = stepper.measure(state)
    assert state.origin[0] > 7.0
    assert row.slide == pytest.approx(state.positions[0, corner] + state.origin[0], rel=1e-14)
    assert row.slide == pytest.approx(25.053 * 5000 * model.parameters.time_step, rel=0.05)


def test_span_has_one_digit_in_binary(plate_model):
    """A span that is a power of two is subtracted without rounding."""
    mantissa, _ = np.frexp(plate_model().parameters.span)
    assert mantissa == 0.5


def test_origin_changes_nothing_but_rounding(plate_model):
    model = plate_model(reaction="drag")
    far = model.parameters._replace(span=1e9)
    near, fixed = (simulate(m, START, 0.384) for m in (model, replace(model, parameters=far)))
    assert near.strike is not None
    assert fixed.strike is not None
    for name, value in near.strike.values.items():
        assert value == pytest.approx(fixed.strike.values[name], rel=1e-6, abs=1e-9), name
    np.testing.assert_allclose(near.strike.positions, fixed.strike.positions, rtol=0.0, atol=1e-10)


SLOWER = [
    ("impact.speed=5", "plate.youngs_modulus=2e13", "plate.elements=[8,3]"),
    ("impact.speed=2.5", "plate.youngs_modulus=2e13", "plate.elements=[8,3]", "corner.constraint=exact"),
]


@pytest.mark.parametrize("changes", SLOWER)
def test_ripple_by_rounding_is_foreseen(changes):
    """The prediction is 1 to 4 times the ripple, as in benchmarks/rounding.py."""
    alone = ("wall=", "corner.reaction=none", "damping.kind=none", "plate.element=quad4")
    result = corner_run.attempt(corner_case.CornerCase(*read_scene("mash-tl4-sut", (*alone, *changes))))
    ripple = result.fe_history["reaction_normal"] - result.rigid_history["reaction_normal"]
    ripple = ripple[np.isfinite(ripple)]
    observed = np.sqrt(np.mean(ripple[-len(ripple) // 4 :] ** 2))
    predicted = rounding_noise(result.fe_plan.model).ripple(result.rigid["t"])
    assert 1.0 < predicted / observed < 4.0


def test_damping_against_rounding_is_no_faster_than_the_plate():
    """Damping per step does not increase beyond the highest frequency.

    Above the frequency w the stable step decreases with the rate r, to 2/r.
    """
    power, reaction, frequency = 2.0, 3.0, 100.0
    noise = RoundingNoise(power, reaction, frequency)
    assert noise.rate_for(1.0) == power * reaction**2
    assert noise.rate_for(0.1) == frequency
    a_step = [rate * damped_time_step(frequency, rate) for rate in (frequency, 1e3 * frequency)]
    assert a_step == [pytest.approx(4.0 / (1.0 + np.sqrt(5.0))), pytest.approx(2.0, rel=1e-5)]
