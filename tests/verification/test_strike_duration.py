"""Verify the crush stiffness from the duration of a strike."""

import math

import numpy as np
import pytest
from shared_cases import LINEAR_TRAIN, LINEAR_TRUCK, changed
from test_impact_rigid import BOX, head_on

from solver.impact import CrushLaw, stiffness_of_duration
from tailslap import InputError
from tailslap.scene.read import read_scene, read_source
from tailslap.scene.vary import Source, vary
from tailslap.scene.write import scene_inputs, scene_text

KEY = "contact.strike_duration"
TRUCK = (9979.0, None, 10.0, 2.438, 5.0)


@pytest.mark.parametrize("e", [0.0, 0.22, 0.9])
def test_a_point_mass_strikes_for_that_long(e):
    """k of the effective mass lasts dt = (pi/2)(1 + e) sqrt(m/k)."""
    k = stiffness_of_duration(0.1, e, BOX.mass, None, 4.0, 2.0, 4.0)  # no arm: the centre of mass at the rear
    (strike,) = head_on(CrushLaw(k, 0.0, e), tolerance=1e-6).strikes
    assert strike.duration == pytest.approx(0.1, rel=1e-5)


def test_the_effective_mass_of_the_rear_corner():
    """The rear corner has a known fraction of the mass.

    A rectangle has m/(1 + 3 L^2/(L^2 + B^2)), others 1/(1/m + a^2/I).
    """
    unit = (math.pi / 2.0 * 1.22 / 0.1) ** 2
    stiffness = stiffness_of_duration(0.1, 0.22, *TRUCK) / unit / 9979.0
    assert stiffness == pytest.approx(1.0 / (1.0 + 300.0 / (100.0 + 2.438**2)), rel=1e-14)
    other = stiffness_of_duration(0.1, 0.22, 8000.0, 96000.0, 10.0, 2.438, 4.0)
    assert other / unit == pytest.approx(2000.0, rel=1e-14)  # 1/8000 + 36/96000 = 1/2000


@pytest.mark.parametrize(("duration", "k", "lasts", "mean"), [
    ("0.1 s", 0.96e6, 0.096, 390e3), ("80 ms", 1.5e6, 0.077, 456e3), (0.18, 0.3e6, 0.173, 236e3),
])  # fmt: skip
def test_durations_of_table_4(duration, k, lasts, mean):
    """Stiffness, rear duration and largest mean of the truck of the paper."""
    case = changed(LINEAR_TRUCK, **{KEY: duration})
    rear = case.motion.strikes[1]
    assert case.scene.contact.stiffness == pytest.approx(k, rel=0.02)
    assert (rear.corner, rear.duration) == ("rear", pytest.approx(lasts, abs=6e-4))
    assert case.answer.peaks["mean_50ms"] == pytest.approx(mean, abs=1e3)


def test_the_stiffness_follows_the_duration_and_not_the_other_way():
    scene, source = vary(read_source(LINEAR_TRUCK), {KEY: "0.1 s"})
    assert source.tables["contact"].keys() == {"strike_duration", "restitution", "friction"}
    assert vary(Source.of(scene), {})[0] == scene
    heavy = vary(source, {"vehicle.mass": 2 * 9979.0})[0].needed_contact
    assert heavy.stiffness == pytest.approx(2.0 * (scene.needed_contact.stiffness or 0.0), rel=1e-14)
    back, source = vary(source, {"contact.stiffness": 1e6})
    assert (back.needed_contact.stiffness, back.needed_contact.strike_duration) == (1e6, None)
    assert "strike_duration" not in scene_text(source).partition("[contact]")[2]
    rows = {row.key: row for row in scene_inputs(*vary(read_source(LINEAR_TRUCK), {KEY: "0.1 s"}))}
    assert rows["contact.stiffness"].origin == "from contact.strike_duration"


def test_a_plate_has_the_stiffness_of_the_rigid_vehicle():
    case = changed(LINEAR_TRUCK, **{KEY: "0.1 s"})
    plate = changed(LINEAR_TRUCK, contact__stiffness=case.scene.contact.stiffness)
    np.testing.assert_equal(case.plan().model.parameters.contact, plate.plan().model.parameters.contact)


@pytest.mark.parametrize(("changes", "key", "allowed"), [
    ({KEY: "0.1 s", "contact.stiffness": 1e6}, "contact.stiffness", "remove one of the two"),
    ({KEY: "0.1 s", "contact.initial_force": 1e4}, "contact.initial_force", "remove one of the two, or use"),
    ({KEY: "0.1 s", "strip": [{"at": 0.0, "stiffness": 2e6}]}, KEY, "all units have [[strip]]"),
    ({KEY: "0.1 s", "contact.enforcement": "exact"}, "contact.enforcement", "no effect"),
    ({KEY: "0.1 s", "contact.restitution": None}, "contact.restitution", "required"),
    ({KEY: "1e-9 s"}, KEY, "the crush stiffness would be 9.56e+21 N/m; allowed is 0.001 to 1e+15 N/m"),
    ({KEY: "0.1 m"}, KEY, "a duration"),
])  # fmt: skip
def test_what_contradicts_a_duration_is_refused(changes, key, allowed):
    with pytest.raises(InputError) as caught:
        vary(read_source(LINEAR_TRUCK), changes)
    assert (caught.value.key, allowed in caught.value.allowed) == (key, True), str(caught.value)


def test_a_train_has_no_single_effective_mass():
    with pytest.raises(InputError, match="of a train allowed is"):
        read_scene(LINEAR_TRAIN, [f"{KEY}=0.1 s"])
