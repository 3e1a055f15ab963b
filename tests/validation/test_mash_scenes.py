"""Validate the MASH and EN 1317 scenes by published test conditions.

MASH 2016 names a vehicle by its mass in kg; speeds are 31, 44, 62, 56 and 50 mph or 50, 70, 100, 90 and
80 km/h. Tests 3-10 and 3-11 as printed in National Academies (2024), doi 10.17226/27896, chapters 12 and 13.
"""

import math

import pytest

from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.read import read_scene, scenes, shipped_scenes

POUND, MILE, FOOT, KIP = 0.45359237, 1609.344, 0.3048, 4448.2216152605
TESTS = {  # pounds, the kilograms of the vehicle's name, mph, km/h, degrees
    "mash-tl1-car": (2420, 1100, 31, 50, 25), "mash-tl1-pickup": (5000, 2270, 31, 50, 25),
    "mash-tl2-car": (2420, 1100, 44, 70, 25), "mash-tl2-pickup": (5000, 2270, 44, 70, 25),
    "mash-tl3-car": (2420, 1100, 62, 100, 25), "mash-tl3-pickup": (5000, 2270, 62, 100, 25),
    "mash-tl4-sut": (22000, 10000, 56, 90, 15),
}  # fmt: skip
NEW = sorted(set(TESTS) - {"mash-tl4-sut"})


def test_every_mash_scene_is_one_of_these():
    assert {name for name in shipped_scenes() if name.startswith("mash-")} == set(TESTS)


@pytest.mark.parametrize("name", TESTS)
def test_conditions(name):
    pounds, kilograms, mph, kmh, degrees = TESTS[name]
    scene = read_scene(name)[0]
    assert scene.vehicle.mass == pytest.approx(pounds * POUND, rel=1e-5)  # the paper prints 9979 kg
    assert scene.vehicle.mass == pytest.approx(kilograms, rel=0.0025)
    assert scene.impact is not None
    assert scene.impact.speed == pytest.approx(mph * MILE / 3600.0, rel=1e-12)
    assert scene.impact.speed == pytest.approx(kmh / 3.6, abs=1.0 / 3.6)
    assert math.degrees(scene.impact.angle) == pytest.approx(degrees, rel=1e-12)
    assert (scene.impact.friction, scene.impact.restitution) == (0.47, 0.22)  # the paper's Table 1


@pytest.mark.parametrize(("name", "least"), [("mash-tl3-car", 51.0), ("mash-tl3-pickup", 106.0)])
def test_impact_severity(name, least):
    """The severity is at most a tenth above the least [kip ft].

    The severity is m (v sin(theta))^2/2.
    """
    scene = read_scene(name)[0]
    assert scene.impact is not None
    severity = scene.vehicle.mass * (scene.impact.speed * math.sin(scene.impact.angle)) ** 2 / 2.0
    assert least < severity / (KIP * FOOT) < 1.1 * least


@pytest.mark.parametrize(("name", "length", "width"), [
    ("mash-tl3-car", 169 / 12, 65 / 12), ("mash-tl3-pickup", 237 / 12, 78 / 12),
])  # fmt: skip
def test_dimensions_in_feet(name, length, width):
    vehicle = read_scene(name)[0].vehicle
    assert (vehicle.length / FOOT, vehicle.width / FOOT) == pytest.approx((length, width), rel=1e-12)


@pytest.mark.parametrize("name", NEW)
def test_scenes_say_what_is_assumed(name):
    text = shipped_scenes()[name].read_text()
    assert scenes()[name].startswith(f"MASH TL-{name[7]}, test {name[7]}-1")
    assert text.count("# Assumed: ") == 2


TRAINS = {  # kg, km/h, degrees as published
    "impact-mash-tl5-tractor-van": (79300 * POUND, 50 * MILE / 1000, 15.0),
    "impact-mash-tl6-tractor-tank": (79300 * POUND, 50 * MILE / 1000, 15.0),
    "impact-tl5cmb-2": (36153.0, 84.9, 15.4),
    "impact-tti-7069-13": (22723.0, 82.7, 16.2),
    "impact-foil-03008": (14683 * POUND, 50.0, 25.0),
}


@pytest.mark.parametrize("name", TRAINS)
def test_conditions_of_tractors(name):
    """Mass, speed and angle are published, others marked as assumed."""
    mass, kmh, degrees = TRAINS[name]
    scene, text = read_scene(name)[0], shipped_scenes()[name].read_text()
    assert sum(unit.mass for unit in scene.units) == pytest.approx(mass, rel=2e-5)
    assert scene.impact is not None
    assert (3.6 * scene.impact.speed, math.degrees(scene.impact.angle)) == pytest.approx(
        (kmh, degrees), rel=1e-12
    )
    assert text.count("Assumed: ") >= 2
    assert len(scene.trailer) == (name != "impact-foil-03008")


EN_1317 = {  # km/h, degrees, kg, level
    "tb11": (100, 20, 900, "N2"), "tb21": (80, 8, 1300, "T1"), "tb22": (80, 15, 1300, "T2"),
    "tb31": (80, 20, 1500, "N1"), "tb32": (110, 20, 1500, "N2"), "tb41": (70, 8, 10000, "T3"),
    "tb42": (70, 15, 10000, "H1"), "tb51": (70, 20, 13000, "H2"), "tb61": (80, 20, 16000, "H3"),
    "tb71": (65, 20, 30000, "H4a"), "tb81": (65, 20, 38000, "H4b"),
}  # fmt: skip


@pytest.mark.parametrize("name", EN_1317)
def test_conditions_of_en_1317(name):
    """The first line marks what no source confirms."""
    kmh, degrees, mass, level = EN_1317[name]
    case, text = (
        ImpactCase(*read_scene(f"impact-en-{name}")),
        shipped_scenes()[f"impact-en-{name}"].read_text(),
    )
    across = kmh / 3.6 * math.sin(math.radians(degrees))
    assert case.impact_severity == pytest.approx(0.5 * mass * across**2, rel=1e-12)
    assert case.scene.impact
    assert (3.6 * case.scene.impact.speed, case.scene.impact.test_level) == (pytest.approx(kmh), level)
    assert text.startswith(f"# EN 1317-2 {name.upper()}: ")
    assert text.splitlines()[0].endswith("not confirmed")
    assert "Assumed: " in text


@pytest.mark.parametrize("level", ["tl1", "tl2", "tl3"])
@pytest.mark.parametrize("vehicle", ["car", "pickup"])
def test_a_level_changes_the_speed_alone(level, vehicle):
    """Velocities after the impact are in proportion to the speed."""
    plan, fastest = (CornerCase(*read_scene(f"mash-{tl}-{vehicle}")) for tl in (level, "tl3"))
    assert plan.scene.vehicle == fastest.scene.vehicle
    speeds = [p.scene.impact.speed for p in (plan, fastest) if p.scene.impact]
    assert plan.force.peak_force / fastest.force.peak_force == pytest.approx(speeds[0] / speeds[1], rel=1e-12)


@pytest.mark.parametrize("name", NEW)
def test_a_stiff_plate_agrees_with_the_rigid_body(outcome, name):
    result = outcome(name)
    assert max(map(abs, result.difference.values())) < 5e-5
    assert result.fe_plan.model.mass == pytest.approx(result.fe_plan.case.scene.vehicle.mass, rel=1e-12)
