"""Verify the crush law with plateau and unloading stiffness.

Exact answers of a point mass on the law, for one vehicle, samples and the plate; refusals.
"""

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from crushing_plates import corner_strips
from sampled_impacts import corner_tables, sampled_impacts
from shared_cases import LINEAR_TRAIN, LINEAR_TRUCK, changed
from test_impact_rigid import BOX, CLOSING, UPRIGHT, head_on

from fem.laws.contact_forces import PointCrush, crush_line, loading_depth, loading_force
from fem.laws.friction import Drag
from fem.model.impact_model import build_impact_model
from fem.plate.properties import ContactProperties, PlateProperties, StepProperties, UnitProperties
from fem.run.impact import FirstTouch, simulate_impact
from meshes import plate_mesh
from solver import RigidBodyError
from solver.impact import CrushLaw, ImpactVehicle, Strip, WallContact, first_touch, solve_impact
from tailslap.case.impact import run
from tailslap.case.impact.strike_columns import both_strikes
from tailslap.errors import InputError

K = 2e6
LAWS: dict[str, dict[str, Any]] = {
    "plateau": {"plateau_force": 2e5, "restitution": 0.22},
    "plateau at the initial force": {"initial_force": 2e5, "plateau_force": 2e5, "restitution": 0.1},
    "initial force, plateau, slope": {"initial_force": 5e4, "plateau_force": 2e5, "unloading_stiffness": 2e7},
    "slope": {"unloading_stiffness": 8e6},
    "slope of loading": {"unloading_stiffness": K},
    "plateau, no return": {"plateau_force": 2e5},
    "hardening": {"plateau_force": 1.5e5, "hardening": 4e5, "restitution": 0.22},
    "initial force, hardening, slope": {
        "initial_force": 5e4,
        "plateau_force": 1e5,
        "hardening": 1.2e6,
        "unloading_stiffness": 8e6,
    },
}
RIGID = {
    **LAWS,
    **{f"e {e}": {"restitution": e} for e in (0.0, 0.05, 0.22, 0.5, 0.9, 1.0)},
    **{
        f"initial force {force}, e {e}": {"initial_force": force, "restitution": e}
        for force in (1e4, 3e5)
        for e in (0.0, 0.22, 0.7)
    },
}


def point_mass(
    initial_force=0.0, plateau_force=math.inf, restitution=0.0, unloading_stiffness=0.0, hardening=0.0
):
    """Crush, peak, duration, exit speed and residual crush of a point mass."""
    mass, energy = BOX.mass, 0.5 * BOX.mass * CLOSING**2
    rate, rise = math.sqrt(K / mass), math.hypot(initial_force, CLOSING * math.sqrt(K * mass))
    peak = min(plateau_force, rise)
    loading = (math.asin(min(peak / rise, 1.0)) - math.asin(initial_force / rise)) / rate
    crush, remaining = (peak - initial_force) / K, energy - (peak**2 - initial_force**2) / (2.0 * K)
    if peak < rise and hardening:
        onset, rate, peak = (
            peak,
            math.sqrt(hardening / mass),
            math.hypot(peak, math.sqrt(2.0 * hardening * remaining)),
        )
        crush += (peak - onset) / hardening
        loading += math.acos(onset / peak) / rate
    elif peak < rise:
        crush += remaining / peak
        loading += math.sqrt(2.0 * remaining * mass) / peak
    slope = unloading_stiffness or (peak**2 / (2.0 * restitution**2 * energy) if restitution else math.inf)
    duration = loading + 0.5 * math.pi * math.sqrt(mass / slope)
    return crush, peak, duration, peak / math.sqrt(slope * mass), crush - peak / slope


@pytest.mark.parametrize("name", RIGID)
def test_a_rigid_point_mass_on_the_law(name):
    crush, peak, duration, exit_speed, residual = point_mass(**RIGID[name])
    motion = head_on(CrushLaw(K, **RIGID[name]), tolerance=1e-7)
    (strike,) = motion.strikes
    assert (strike.corner, motion.error < 1e-5) == ("front", True)
    assert strike.peak_force == pytest.approx(peak, rel=1e-6)
    assert strike.duration == pytest.approx(duration, rel=1e-5)
    assert motion.end.v_gy == pytest.approx(exit_speed, rel=1e-6, abs=1e-6 * CLOSING)
    assert strike.impulse == pytest.approx(BOX.mass * (CLOSING + exit_speed), rel=1e-6)
    depths = motion.contact_depths(np.linspace(strike.start, strike.end, 20001))[0]
    assert depths.max() == pytest.approx(crush, rel=1e-6)
    assert motion.contact_depths([strike.end])[0, 0] == pytest.approx(residual, rel=1e-5, abs=1e-6)
    at = motion.at([motion.t_end])
    lost = 0.5 * BOX.mass * (CLOSING**2 - exit_speed**2)
    assert at.crush_energy_lost[0] + at.crush_energy_stored[0] == pytest.approx(lost, rel=1e-6, abs=0.05)
    assert strike.energy_absorbed == pytest.approx(lost, rel=1e-5, abs=0.5)


def test_samples_on_the_law():
    """A corner below the centre of mass strikes at CLOSING."""
    names = ("initial_force", "plateau_force", "restitution", "unloading_stiffness", "hardening")
    laws = [{"plateau_force": math.inf, **law} for law in LAWS.values()]
    inputs: dict[str, Any] = {key: np.array([law.get(key, 0.0) for law in laws]) for key in names}
    inputs |= {"length": 4.0, "width": 2.0, "mass": 1500.0, "stiffness": K, "friction": 0.0}
    inputs |= {"speed": CLOSING / math.sin(UPRIGHT), "angle": UPRIGHT}
    impacts = sampled_impacts(**inputs, tolerance=1e-7)
    for i, law in enumerate(LAWS.values()):
        _, peak, duration, exit_speed, _ = point_mass(**law)
        assert impacts.peak_force[0, i] == pytest.approx(peak, rel=1e-6)
        assert impacts.duration[0, i] == pytest.approx(duration, rel=1e-5)
        assert impacts.impulse[0, i] == pytest.approx(BOX.mass * (CLOSING + exit_speed), rel=1e-6)


MODULUS, STEP = 2e15, 2e-6
REAR = PointCrush(K, 0.0, 0.5, 2e5, 2.0 * K, 0.0)
"""Crush of the rear corners, which do not strike: with it all laws have the same compiled loop."""


def plate_run(contact):
    """The box as a plate that strikes head-on with its front corner.

    It has no lateral contraction.
    """
    plate = PlateProperties(0.05, BOX.mass / (8.0 * 0.05), MODULUS, 0.0, lumping="row-sum")
    model = build_impact_model(
        [UnitProperties(plate_mesh(4.0, 2.0, (1, 1)), plate, contact)], StepProperties(longest=STEP)
    )
    return simulate_impact(model, FirstTouch(UPRIGHT, 0.0, -CLOSING), 1e-5, 0.13)


@pytest.mark.parametrize("name", LAWS)
def test_a_plate_on_the_law(name):
    """Agreement within 1e-6, and half a step of an initial force.

    Without unloading the springs of the plate return.
    """
    law = {"restitution": 0.0, **LAWS[name]}
    crush, peak, _, exit_speed, residual = point_mass(**law)
    front, rear = corner_strips(BOX.length, K, **law)
    contact = ContactProperties(Drag(0.0), "crush", (front, rear._replace(law=REAR)))
    result, momentum = plate_run(contact), BOX.mass * CLOSING
    bound = 1e-6 + STEP * law.get("initial_force", 0.0) / momentum
    if exit_speed == 0.0:
        bound += peak / (CLOSING * math.sqrt(MODULUS * 0.05 * BOX.mass))
    force, depth, t = result.normal[:, 0], result.depth[:, 0], result.history["t"]
    assert force.max() == pytest.approx(peak, rel=bound)
    assert depth.max() == pytest.approx(crush, rel=bound)
    assert force.sum() * (t[1] - t[0]) == pytest.approx(momentum + BOX.mass * exit_speed, rel=bound)
    lost = 0.5 * BOX.mass * (CLOSING**2 - exit_speed**2)
    absorbed = result.history["crush_energy"][-1] + result.history["contact_energy"][-1]
    assert absorbed == pytest.approx(lost, rel=2.0 * bound, abs=0.05)
    last = np.flatnonzero(force > 0.0)[-1]
    assert depth[last] == pytest.approx(residual, abs=2e-5 * CLOSING)


@pytest.mark.parametrize(
    ("law", "deepest", "answer"),
    [
        (PointCrush(K, 0.0, 0.04, math.inf, 0.0), 0.1, (2e5, 1e4, 4e-3, 0.04)),
        (PointCrush(K, 0.0, 0.04, 1e5, 0.0), 0.15, (1e5, 1.25e4, 1e-2, 0.04)),
        (PointCrush(K, 5e4, 0.0, 1e5, 1e7), 0.125, (1e5, 1.1875e4, 1e-2, 500.0 / 11875.0)),
        (PointCrush(K, 1e5, 0.0, math.inf, K), 0.05, (2e5, 7.5e3, 0.05, 5e3 / 7.5e3)),
        (PointCrush(K, 1e5, 0.0, math.inf, K), 0.0, (1e5, 0.0, 0.0, 0.0)),
        (PointCrush(K, 0.0, 0.0, math.inf, K), 0.0, (0.0, 0.0, 0.0, 0.0)),
        (PointCrush(K, 0.0, 0.0, 1e5, 1e7, 5e5), 0.15, (1.5e5, 1.5e4, 1.5e-2, 0.075)),
        (PointCrush(K, 5e4, 0.04, 1e5, 0.0, K), 0.125, (3e5, 2.1875e4, 2.0 * 0.04 * 2.1875e4 / 3e5, 0.04)),
    ],
)
def test_the_line_of_unloading(law, deepest, answer):
    """Force, energy, length and returned part of the line of unloading.

    Of a slope below F/d the line is as long as the crush: it does not end in front of the vehicle.
    """
    assert crush_line(law, deepest) == pytest.approx(answer, rel=1e-12)


@pytest.mark.parametrize("hardening", [0.0, 6e5, K])
@pytest.mark.parametrize("mean", [0.05, 0.2, 0.9])
def test_force_and_depth_at_the_end_of_a_step(hardening, mean):
    """d = mean - compliance N(d), also in a long step."""
    law, compliance = PointCrush(K, 2e4, 0.04, 1e5, 0.0, hardening), 1e-6
    depth = loading_depth(law, mean, compliance, 1.0)
    expected = min(2e4 + K * depth, 1e5 + hardening * max(depth - 0.04, 0.0))
    assert loading_force(law, depth) == pytest.approx(expected, rel=1e-12)
    assert depth == pytest.approx(mean - compliance * expected, rel=1e-12)


FRONT = {"stiffness": 2e6, "plateau": 350e3, "restitution": 0.15}
BEHIND = {"stiffness": 1.5e6, "plateau": 300e3, "unloading_stiffness": 12e6}
TRUCK = {"strip": corner_tables(10.0, FRONT, BEHIND), "contact.stiffness": None, "contact.restitution": None}


@pytest.mark.parametrize(
    ("elements", "hardening"),
    [((10, 3), 0.0), ((10, 3), 5e5), pytest.param((20, 6), 0.0, marks=pytest.mark.long)],
)
def test_the_plate_tends_to_the_rigid_vehicle(elements, hardening):
    """The difference is in proportion to 1/E, 1e-3 at 2 TPa."""
    off = []
    for modulus in (0.2e12, 2e12):
        changes = {"plate.youngs_modulus": modulus, "plate.elements": elements, "plate.element": "quad4"}
        changes |= {f"strip.{n}.hardening": hardening for n in (0, 1)}
        outcome = run.attempt(changed(LINEAR_TRUCK, **TRUCK, **changes))
        off.append(max(abs(outcome.difference[f"strike_{k}.impulse"]) for k in (1, 2)))
    assert off[1] < 1e-3
    assert off[1] / off[0] == pytest.approx(0.1, abs=0.04)


def test_the_rear_has_values_of_its_own():
    """Peak forces are the plateaus, and samples agree."""
    case = changed(LINEAR_TRUCK, **TRUCK)
    front, rear = case.motion.strikes[:2]
    assert (front.corner, rear.corner) == ("front", "rear")
    assert (front.peak_force, rear.peak_force) == pytest.approx((350e3, 300e3), rel=1e-9)
    assert {f"strip.1.{key}" for key in BEHIND} <= set(case.arguments)
    sampled = case.many({"strip.1.plateau": np.array([300e3, 250e3])})
    for k, strike in enumerate((front, rear), 1):
        assert sampled[f"strike_{k}.impulse"][0] == pytest.approx(strike.impulse, rel=2e-4)
    assert sampled["strike_2.raw"] == pytest.approx([300e3, 250e3], rel=1e-9)
    other = changed(
        LINEAR_TRUCK, **{**TRUCK, "strip": corner_tables(10.0, FRONT, BEHIND | {"plateau": 250e3})}
    )
    assert sampled["strike_2.impulse"][1] == pytest.approx(other.motion.strikes[1].impulse, rel=2e-4)


def test_samples_vary_what_the_scene_does_not_give():
    case = changed(LINEAR_TRUCK)
    inputs = {"contact.plateau_force": np.array([3e5, 4e5]), "contact.unloading_stiffness": np.full(2, 2e7)}
    samples = case.many(inputs)
    for i in range(2):
        changes = {key: float(values[i]) for key, values in inputs.items()} | {"contact.restitution": None}
        strikes = changed(LINEAR_TRUCK, **changes).motion.strikes
        assert samples["strike_1.impulse"][i] == pytest.approx(strikes[0].impulse, rel=2e-4)
        assert samples["strike_2.impulse"][i] == pytest.approx(strikes[1].impulse, rel=2e-4)


def test_two_laws_in_one_place_are_one_with_hardening():
    """On loading both have the same forces."""
    at, k2 = (0.0, 10.0), 4e5
    both = [Strip((x, x), law) for x in at for law in (CrushLaw(K - k2, plateau_force=2.4e5), CrushLaw(k2))]
    one = [Strip((x, x), CrushLaw(K, plateau_force=3e5, hardening=k2)) for x in at]
    truck = ImpactVehicle(10.0, 2.438, 9979.0)
    motions = []
    for strips in (both, one):
        law = WallContact(None, 0.3, tuple(strips))
        start = first_touch(truck, math.radians(15.0), 25.0, contact=law)
        motions.append(solve_impact(truck, law, start, end=0.5, step=1e-5))
    together, alone = (motion.at(np.linspace(0.0, 0.5, 501)) for motion in motions)
    assert alone.force_normal.max() > 3.5e5
    for name in ("v_gx", "v_gy", "omega", "impulse_normal"):
        expected = getattr(together, name)
        assert getattr(alone, name) == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max()), (
            name
        )


FORCES = {
    0.0: (346.3, 350.0, 350.0, 350.0),
    0.3: (363.9, 395.9, 422.2, 453.9),
    0.5: (373.8, 420.9, 459.7, 505.4),
}
"""Largest 50 ms means [kN] at 45, 56, 65 and 75 mph by hardening [MN/m], of an independent model."""


@pytest.mark.parametrize("hardening", FORCES)
def test_the_force_grows_with_the_speed(hardening):
    """The rigid TL-4 truck agrees with an independent integration."""
    changes = {"axle": None, "time.end": "0.7 s", "contact.hardening": 1e6 * hardening}
    for mph, expected in zip((45, 56, 65, 75), FORCES[hardening], strict=True):
        case = changed("impact-mash-tl4-sut", **changes, **{"impact.speed": f"{mph} mph"})
        assert 1e-3 * case.answer.peaks["mean_50ms"] == pytest.approx(expected, rel=1e-3)


SOFT = {"stiffness": 2e6, "plateau": 400e3}
OF_TRAIN = [
    *corner_tables(6.9, SOFT, SOFT | {"plateau": 300e3}),
    *corner_tables(
        14.6304, SOFT | {"plateau": 500e3}, SOFT | {"plateau": 250e3, "unloading_stiffness": 2e7}, 2
    ),
]


def test_each_trailer_has_values_of_its_own():
    case = changed(LINEAR_TRAIN, **{"strip": OF_TRAIN, "contact.stiffness": None})
    peaks: dict[str, float] = {}
    for strike in case.motion.strikes:
        peaks[strike.corner] = max(peaks.get(strike.corner, 0.0), strike.peak_force)
    limits = {"front": 400e3, "rear": 300e3, "trailer front": 500e3, "trailer rear": 250e3}
    assert {name: peaks[name] for name in limits} == pytest.approx(limits, rel=1e-6)
    many = case.many({"strip.3.plateau": np.array([250e3])})
    assert many["strike_2.raw"] == pytest.approx([both_strikes(case.answer)["strike_2.raw"]], rel=3e-3)
    assert case.contact.strips[3].law == CrushLaw(2e6, 0.0, 0.0, 250e3, 2e7)


REFUSED = [
    ("plateau_force", partial(CrushLaw, 1e6, 2e5, plateau_force=1e5), "at least that, 200000, above 0"),
    ("plateau_force", partial(CrushLaw, 1e6, plateau_force=0.0), "above 0"),
    ("plateau_force", partial(CrushLaw, 1e6, plateau_force=math.nan), "above 0"),
    ("unloading_stiffness", partial(CrushLaw, 1e6, unloading_stiffness=0.9e6), "at least the stiffness"),
    ("unloading_stiffness", partial(CrushLaw, 1e6, unloading_stiffness=-1.0), "at least the stiffness"),
    ("unloading_stiffness", partial(CrushLaw, 1e6, 0.0, 0.2, unloading_stiffness=2e6), "one of the two"),
    ("restitution", partial(CrushLaw, 1e6, 0.0, 0.8, 1e5), "at most sqrt(1/2)"),
    (
        "hardening",
        partial(CrushLaw, 1e6, plateau_force=1e5, hardening=1.1e6),
        "0 to the stiffness, 1e+06",
    ),
    ("hardening", partial(CrushLaw, 1e6, plateau_force=1e5, hardening=-1.0), "0 to the stiffness"),
    ("hardening", partial(CrushLaw, 1e6, hardening=1e5), "with a plateau"),
]


@pytest.mark.parametrize(("key", "make", "allowed"), REFUSED)
def test_an_impossible_law_is_refused(key, make, allowed):
    with pytest.raises(RigidBodyError) as caught:
        make()
    assert caught.value.key == key
    assert allowed in caught.value.allowed


LINE = {"strip": [{"at": [1.0, 9.0], "stiffness": 1e6}], "contact.stiffness": None}
SETS = [
    ("contact.plateau_force", {"contact.initial_force": "50 kN", "contact.plateau_force": "40 kN"}),
    ("strip.1.plateau", TRUCK | {"strip": corner_tables(10.0, FRONT, BEHIND | {"initial_force": 4e5})}),
    ("contact.unloading_stiffness", {"contact.unloading_stiffness": "3 MN/m"}),
    ("contact.unloading_stiffness", {"contact.restitution": None, "contact.unloading_stiffness": "1 MN/m"}),
    (
        "strip.1.unloading_stiffness",
        TRUCK | {"strip": corner_tables(10.0, FRONT, BEHIND | {"stiffness": 2e7})},
    ),
    (
        "strip.1.unloading_stiffness",
        TRUCK | {"strip": corner_tables(10.0, FRONT, BEHIND | {"restitution": 0.0})},
    ),
    ("contact.plateau_force", TRUCK | {"contact.plateau_force": 3e5}),
    ("contact.stiffness", TRUCK | {"contact.stiffness": 2e6, "contact.restitution": 0.2}),
    ("contact.stiffness", {"strip": corner_tables(10.0, FRONT, BEHIND, 2), "contact.stiffness": None}),
    ("contact.restitution", TRUCK | {"contact.restitution": 0.2}),
    ("contact.patch_length", LINE | {"contact.patch_length": 1.0}),
    ("contact.rear", {"contact.rear.plateau_force": 3e5}),
    ("contact.side_stiffness", {"contact.side_stiffness": 3e5}),
    ("contact.plateau_force", {"contact.plateau_force": -1.0}),
    ("contact.plateau_force", {"contact.plateau_force": 0.0}),
    ("contact.rear", {"contact.rear": 1.0}),
    ("contact.hardening", {"contact.hardening": 1e5}),
    ("contact.hardening", {"contact.plateau_force": 1e5, "contact.hardening": "3 MN/m"}),
    ("strip.1.hardening", TRUCK | {"strip": corner_tables(10.0, FRONT, BEHIND | {"hardening": 2e6})}),
    ("contact.plateau_force", {"contact.strike_duration": 0.1, "contact.plateau_force": 3e5}),
]


@pytest.mark.parametrize(("key", "changes"), SETS)
def test_a_bad_key_of_the_law_is_named(key, changes, refused):
    assert refused(lambda: changed(LINEAR_TRUCK, **changes)) == key


REPLACED = {
    "contact.rear.stiffness": "[[strip]] with at = the length of the vehicle, and stiffness",
    "contact.side_stiffness": "[[strip]] with at = two places, and stiffness",
    "trailer.0.plateau_force": '[[strip]] with unit = 2, at = "0 m" and at = its length, and plateau',
    "trailer.0.rear.restitution": "[[strip]] with unit = 2",
}


@pytest.mark.parametrize("key", REPLACED)
def test_a_former_key_names_its_replacement(key):
    with pytest.raises(InputError) as caught:
        changed(LINEAR_TRAIN, **{key: 0.1})
    assert key.startswith(caught.value.key)
    assert REPLACED[key] in caught.value.allowed
