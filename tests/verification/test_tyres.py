"""Verify tyres of vehicles, trains and plates by exact forces."""

import math
from dataclasses import asdict, astuple, replace
from typing import Any

import numpy as np
import pytest
from crushing_plates import corner_strips
from plane_reference import integrated
from sampled_impacts import sampled_impacts
from shared_cases import LINEAR_TRUCK, changed

from fem.laws.friction import Drag
from fem.model.impact_model import build_impact_model
from fem.plate.properties import (
    AxleProperties,
    ContactProperties,
    PlateProperties,
    StepProperties,
    UnitProperties,
)
from fem.run.impact import FirstTouch, ImpactStepper
from meshes import plate_mesh
from solver import RigidBodyError
from solver.impact import (
    CrushLaw,
    HitchedVehicle,
    ImpactState,
    ImpactVehicle,
    Strip,
    TyreAxle,
    WallContact,
    first_touch,
    solve_impact,
)
from solver.impact.solve import loads_at_rest
from tailslap.case.impact import checks, run

GRAVITY = 9.80665
TRUCK = ImpactVehicle(10.0, 2.438, 9979.0, 5.5)
AXLES = (TyreAxle(1.3, 0.7, 6.0), TyreAxle(7.5, 0.6, 5.0))
LAW = WallContact(CrushLaw(2e6, 0.0, 0.1, 3.5e5), 0.3)


def both_ends(friction, length, front, rear):
    """Contact at the front and rear corners by laws of their own."""
    return WallContact(None, friction, (Strip((0.0, 0.0), front), Strip((length, length), rear)))


SPEED, ANGLE = 25.0, math.radians(15.0)


def impact(axles=AXLES, law=LAW, **more):
    return solve_impact(TRUCK, law, first_touch(TRUCK, ANGLE, SPEED), axles=axles, **more)


# --- loads ---


def loads_of(motion):
    return loads_at_rest(motion.vehicle, motion.contact, motion.trailers, motion.axles)


def test_loads_follow_from_levers():
    motion = impact(end=0.01)
    behind = (5.5 - 1.3) / (7.5 - 1.3)
    weight = TRUCK.mass * GRAVITY
    assert loads_of(motion) == pytest.approx((weight * (1.0 - behind), weight * behind), rel=1e-12)
    three = loads_of(impact((*AXLES, TyreAxle(8.5, 0.6)), end=0.01))
    places = np.array([1.3, 7.5, 8.5])
    assert sum(three) == pytest.approx(weight, rel=1e-12)
    assert places @ three == pytest.approx(5.5 * weight, rel=1e-12)
    assert np.diff(three)[0] / 6.2 == pytest.approx(np.diff(three)[1], rel=1e-9)  # on a rigid body
    assert loads_of(impact((TyreAxle(5.5, 0.7),), end=0.01)) == pytest.approx((weight,), rel=1e-12)


TRAILER = ImpactVehicle(12.0, 2.5, 20000.0, 6.0)


def train(axles, end=None, tolerance=1e-4):
    behind = HitchedVehicle(TRAILER, 7.0, 1.0)
    start = first_touch(TRUCK, ANGLE, SPEED, [behind])
    return solve_impact(TRUCK, LAW, start, end, trailers=[behind], axles=axles, tolerance=tolerance)


def test_a_trailer_stands_on_its_axles_and_the_kingpin():
    axles = (TyreAxle(1.3, 0.7), TyreAxle(7.5, 0.7), TyreAxle(9.5, 0.7, unit=1), TyreAxle(10.5, 0.7, unit=1))
    front, rear, *behind = loads_of(train(axles, 0.01))
    trailer, truck = TRAILER.mass * GRAVITY, TRUCK.mass * GRAVITY
    load = trailer * 5.0 / (8.5 + 9.5)  # moments about the kingpin
    assert behind == pytest.approx([load, load], rel=1e-12)
    kingpin = trailer - 2.0 * load
    assert front + rear == pytest.approx(truck + kingpin, rel=1e-12)
    assert 1.3 * front + 7.5 * rear == pytest.approx(5.5 * truck + 7.0 * kingpin, rel=1e-12)


# --- side force of one axle ---


@pytest.mark.parametrize("ahead", [20.0, -20.0, 0.3])
def test_the_side_force_of_an_axle_that_turns_steadily(ahead):
    """The force follows from the slip of the axle.

    It is -mu N tanh(C a/mu), with its work and moment.
    """
    heavy, rate, sideways = ImpactVehicle(10.0, 2.0, 1e12, 4.0), 0.4, -2.0
    axles = [TyreAxle(1.0, 0.0, 6.0), TyreAxle(9.0, 0.7, 6.0)]  # the first slides, and carries 5/8
    start = ImpactState(0.0, 10.0, 0.0, ahead, sideways, rate)
    motion = solve_impact(heavy, LAW, start, end=1e-4, axles=axles, step=1e-5)
    across = sideways + rate * (4.0 - 9.0)
    slip = math.atan2(across, max(abs(ahead), 1.0))
    force = -0.7 * 3.75e11 * GRAVITY * math.tanh(6.0 * slip / 0.7)
    at = motion.at([motion.t_end])
    # Within 1e-4 s it rotates by 4e-5.
    assert at.tyre_impulse_normal[0] / motion.t_end == pytest.approx(force, rel=2e-4)
    short = solve_impact(heavy, LAW, start, end=1e-7, axles=axles, step=1e-8).at([1e-7])
    assert short.tyre_impulse_normal[0] / 1e-7 == pytest.approx(force, rel=1e-6)
    assert short.tyre_work[0] / 1e-7 == pytest.approx(force * across, rel=1e-6)
    arm = force * (4.0 - 9.0)
    assert short.tyre_impulse_angular[0] / 1e-7 == pytest.approx(arm, rel=1e-6)


def test_a_vehicle_on_the_road_alone_follows_its_equations():
    """1 s of a skid by SciPy, with an order of two."""
    start = ImpactState(0.0, 500.0, 0.3, 15.0, 4.0, 0.8)
    loads = loads_of(impact(end=0.01))
    exact = integrated(TRUCK, start, 1.0, axles=AXLES, loads=loads).end
    steps = (4e-3, 2e-3, 1e-3)

    def state(step):
        return np.array(astuple(solve_impact(TRUCK, LAW, start, end=1.0, axles=AXLES, step=step).end))

    off = [float(np.abs(state(step) - exact).max()) for step in steps]
    assert off[-1] < 2e-5
    assert np.polyfit(np.log(steps), np.log(off), 1)[0] == pytest.approx(2.0, abs=0.1)
    assert state(1e-4) == pytest.approx(exact, rel=1e-6, abs=1e-6)


# --- a whole impact ---


def test_hinge_forces_of_a_train_with_tyres():
    motion = train((*AXLES, TyreAxle(9.5, 0.7, unit=1), TyreAxle(10.5, 0.7, unit=1)))
    times = np.linspace(0.0, motion.t_end, 2001)
    at, forces = motion.at(times), motion.hinge_forces(times)
    gained = np.diff(TRUCK.mass * at.v_gy - at.impulse_normal_1 - at.tyre_impulse_normal) / np.diff(times)
    assert np.abs(forces[0, 1] - gained).max() < 1e-6 * np.abs(gained).max()


def test_tyres_weaken_the_tail_slap():
    """The second strike is weaker by 10 to 30 %."""
    bare, steered = impact(()), impact()
    assert steered.strikes[0].impulse == pytest.approx(bare.strikes[0].impulse, rel=0.05)
    assert 0.7 < steered.strikes[1].impulse / bare.strikes[1].impulse < 0.95
    at = steered.at(np.array([0.0, steered.t_end]))
    assert -0.2 < at.tyre_work[1] / at.kinetic_energy[0] < -0.01


HELD = ImpactVehicle(7.079, 2.335, 13538.0)
HELD_LAW = both_ends(
    0.2466, 7.079, CrushLaw(1.228e6, 16984.0, 0.1031, 97318.0), CrushLaw(1.384e6, 16984.0, 0.3661, 123106.0)
)
HELD_AXLES = (TyreAxle(1.315, 0.7812, 6.21), TyreAxle(5.336, 0.7697, 7.46))


@pytest.mark.parametrize("step", [2e-5, 1e-5])
def test_a_vehicle_that_leans_on_the_wall_is_not_followed_for_seconds(step):
    """A vehicle whose front stays in contact ends with the rear strike.

    The strike of the front is in progress and marked as cut. The impulses of all strikes add up to the impulse of the
    wall.
    """
    touch = first_touch(HELD, 0.08887, 21.768)
    motion = solve_impact(HELD, HELD_LAW, touch, longest=5.0, step=step, axles=HELD_AXLES)
    assert [(strike.corner, strike.cut) for strike in motion.strikes] == [
        ("front", False), ("rear", False), ("front", True),
    ]  # fmt: skip
    assert 0.45 < motion.t_end < 0.6
    total = sum(strike.impulse for strike in motion.strikes)
    assert total == pytest.approx(motion.at(np.array([motion.t_end])).impulse_normal[0], rel=1e-7)
    longer = solve_impact(HELD, HELD_LAW, touch, 1.0, step=step, axles=HELD_AXLES)
    assert longer.strikes[2].cut
    lean = np.diff(longer.at(np.array([motion.t_end, 1.0])).impulse_normal)[0] / (1.0 - motion.t_end)
    assert 0.0 < lean < 0.1 * max(strike.peak_force for strike in motion.strikes)


def test_an_axle_without_friction_changes_nothing():
    bare, smooth = impact(()), impact((TyreAxle(1.3), TyreAxle(7.5)))
    assert [strike.impulse for strike in smooth.strikes] == [strike.impulse for strike in bare.strikes]


def test_samples_have_tyres():
    sample: dict[str, Any] = {"length": 10.0, "width": 2.438, "mass": np.array([9979.0, 9000.0])}
    sample |= {"speed": SPEED, "angle": ANGLE, "stiffness": 2e6, "restitution": 0.1, "plateau_force": 3.5e5}
    sample |= {"friction": 0.3, "centre_of_mass": 5.5}
    axles: list[dict[str, Any]] = [
        {"position": 1.3, "friction": np.array([0.7, 0.5]), "cornering": 6.0},
        {"position": 7.5, "friction": 0.6, "cornering": 5.0},
    ]
    impacts = sampled_impacts(**sample, axles=axles, tolerance=1e-5)
    for i, (mass, friction) in enumerate(((9979.0, 0.7), (9000.0, 0.5))):
        vehicle = replace(TRUCK, mass=mass)
        single_axles = (TyreAxle(1.3, friction, 6.0), AXLES[1])
        motion = solve_impact(vehicle, LAW, first_touch(vehicle, ANGLE, SPEED), axles=single_axles)
        for k in range(2):
            assert impacts.impulse[k, i] == pytest.approx(motion.strikes[k].impulse, rel=2e-5)


def test_samples_with_long_steps_stay_within_their_stated_error():
    """Steps between strikes are longer than the interval.

    Rows lie between them.
    """
    motion, interval = impact(), 5e-4
    law = {key: getattr(LAW.crush, key) for key in ("stiffness", "plateau_force", "restitution")}
    sample = sampled_impacts(
        **asdict(TRUCK) | law, speed=SPEED, angle=ANGLE, friction=LAW.friction,
        axles=[asdict(axle) for axle in AXLES], interval=interval,
    )  # fmt: skip
    assert 1e-5 < sample.error < 4e-3
    for k, strike in enumerate(motion.strikes[:2]):
        assert sample.impulse[k] == pytest.approx(strike.impulse, rel=float(sample.error))
        assert sample.peak_force[k] == pytest.approx(strike.peak_force, rel=float(sample.error))
    t = interval * np.arange(1, int(motion.t_end / interval))
    exact = motion.at(t).impulse_normal
    computed = interval * np.cumsum(sample.mean_force)[: t.size]
    np.testing.assert_allclose(computed, exact, atol=float(sample.error) * exact[-1])
    force = np.diff(computed - exact) / interval
    assert np.abs(force).max() < 0.05 * law["plateau_force"]  # unloading begins 0.2 ms apart


@pytest.mark.parametrize(("axle", "key"), [
    (TyreAxle(-0.1, 0.7), "axle.0.position"), (TyreAxle(10.1, 0.7), "axle.0.position"),
    (TyreAxle(math.nan, 0.7), "axle.0.position"), (TyreAxle(1.0, -0.1), "axle.0.friction"),
    (TyreAxle(1.0, 0.7, -1.0), "axle.0.cornering"), (TyreAxle(1.0, math.inf), "axle.0.friction"),
    (TyreAxle(1.0, 0.7, unit=1), "axle.0.unit"),
])  # fmt: skip
def test_an_impossible_axle_is_refused(axle, key):
    with pytest.raises(RigidBodyError) as caught:
        impact((axle,), end=0.01)
    assert caught.value.key == key


def test_axles_that_cannot_carry_the_vehicle_are_refused():
    with pytest.raises(RigidBodyError) as caught:
        impact((TyreAxle(1.0, 0.7), TyreAxle(2.0, 0.7)), end=0.01)
    assert caught.value.key == "axle.0.position"
    assert "centre of mass" in caught.value.allowed


# --- the plate ---


@pytest.mark.parametrize("ahead", [20.0, 0.3])
def test_the_side_force_on_a_plate_that_turns_steadily(ahead):
    """Force, moment and power at once equal those of the rigid vehicle."""
    rate, sideways, theta, load = 0.4, -2.0, 0.2, 7e4
    unit = UnitProperties(
        plate_mesh(10.0, 2.4, (5, 2)),
        PlateProperties(0.05, 7800.0, 2e11, 0.3),
        ContactProperties(Drag(0.0), "crush", corner_strips(10.0, 1.0, plateau_force=1.0)),
        axles=(AxleProperties(8.7, load, 0.7, 6.0),),
    )
    model = build_impact_model([unit], StepProperties(longest=1e-8))
    stepper, (c, s) = ImpactStepper(model), (math.cos(theta), math.sin(theta))
    u, v = ahead * c + sideways * s, sideways * c - ahead * s  # of the corner P, whose frame the start is in
    state = stepper.at_touch(FirstTouch(theta, u, v, rate))
    state.positions[1] += 100.0
    rows, _, _ = stepper.record(state, 1, 3)
    road = stepper.parts(rows)[-1]
    work, along, across, moment = (road[2] - road[1]) / model.parameters.time_step
    side = sideways - rate * 8.7
    slip = math.atan2(side, max(ahead - rate * 1.2, 1.0))
    force = -0.7 * load * math.tanh(6.0 * slip / 0.7)
    assert (along, across) == pytest.approx((force * s, force * c), rel=1e-6)
    assert work == pytest.approx(force * side, rel=1e-6)
    x, y = -8.7 * c + 1.2 * s, 100.0 + 8.7 * s + 1.2 * c
    assert moment == pytest.approx(x * across - y * along, rel=1e-6)


TABLES = [{"position": 1.3, "friction": 0.7}, {"position": 7.5, "friction": 0.7, "cornering": 5.0}]


def test_a_plate_with_tyres_tends_to_the_rigid_vehicle():
    """The difference is in proportion to 1/E, and balances are closed."""
    off = []
    for modulus in (0.2e12, 2e12):
        mesh = {"plate.youngs_modulus": modulus, "plate.elements": (10, 3), "plate.element": "quad4"}
        outcome = run.attempt(changed(LINEAR_TRUCK, axle=TABLES, contact__plateau_force=350e3, **mesh))
        off.append(max(abs(outcome.difference[f"strike_{k}.impulse"]) for k in (1, 2)))
        passed = {check.name: check.passed for check in checks.impact_checks(outcome)}
        balance = ("energy balance", "energy gained", "momentum balance", "angular momentum")
        assert all(passed[name] for name in balance)
        works = [answer.history["tyre_work"][-1] for answer in (outcome.fe, outcome.rigid)]
        assert works[0] == pytest.approx(works[1], rel=0.02)
    assert off[1] < 1e-3
    assert off[1] / off[0] == pytest.approx(0.1, abs=0.04)


# --- scenes ---


def test_a_scene_with_axles():
    """Tyres are in answer, texts and samples, without friction they are omitted."""
    case = changed(LINEAR_TRUCK, axle=TABLES)
    numbers, text = case.rigid_numbers(), "\n".join(case.rigid_text())
    assert -2e5 < numbers["tyre_work"] < -1e4
    assert "load of axle 1" in text
    assert {"axle.0.position", "axle.1.friction"} <= set(case.arguments)
    samples = case.many({"axle.1.friction": np.array([0.7, 0.5])})
    assert samples["strike_2.impulse"][0] == pytest.approx(case.motion.strikes[1].impulse, rel=2e-4)
    other = changed(LINEAR_TRUCK, axle=[TABLES[0], TABLES[1] | {"friction": 0.5}])
    assert samples["strike_2.impulse"][1] == pytest.approx(other.motion.strikes[1].impulse, rel=2e-4)
    smooth, bare = changed(LINEAR_TRUCK, axle=[{"position": 1.3}]), changed(LINEAR_TRUCK)
    assert smooth.rigid_numbers() == bare.rigid_numbers()
    slides = changed(LINEAR_TRUCK, axle=[TABLES[0] | {"friction": 0.0}, TABLES[1]])
    assert slides.loads == case.loads
    many = slides.many({"axle.1.friction": np.array([TABLES[1]["friction"]])})
    assert many["strike_2.impulse"][0] == pytest.approx(slides.motion.strikes[1].impulse, rel=2e-4)


@pytest.mark.parametrize(("axle", "key"), [
    ({"position": 10.5}, "axle.0.position"), ({"position": -0.5}, "axle.0.position"),
    ({"position": 1.0, "friction": -0.1}, "axle.0.friction"), ({"position": 1.0, "unit": 2}, "axle.0.unit"),
    ({"position": 1.0, "cornering": -6.0}, "axle.0.cornering"), ({}, "axle.0.position"),
    ({"position": 1.0, "tyre": 1.0}, "axle.0.tyre"),
])  # fmt: skip
def test_a_bad_axle_is_named(axle, key, refused):
    assert refused(lambda: changed(LINEAR_TRUCK, axle=[axle])) == key


def test_axles_require_a_whole_impact(refused):
    assert refused(lambda: changed("mash-tl4-sut", axle=TABLES)) == "axle"
