"""Verify the inertial estimate of a sensor.

Exact: mass times the acceleration of the centre of mass is the force of the wall. Kinematics: velocities of a point of
a rigid body from the history.
"""

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from sampled_impacts import sampled_impacts
from scipy.spatial.transform import Rotation
from shared_cases import case

import tailslap
from postprocess.units import SI
from tailslap.errors import InputError

IMPACT, SPACE, TRAIN = "impact-mash-tl4-sut", "impact-tipping-tl4-sut", "impact-mash-tl5-tractor-van"
ROWS = 50
"""Rows of a 50 ms mean in space."""


def test_at_the_centre_of_mass_the_estimate_is_the_force():
    """Of impacts without tyres, coarse and fine steps."""
    values = {"length": 10.0, "width": 2.438, "mass": np.array([9979.0, 2e4]), "speed": 25.0, "angle": 0.26}
    law = {"stiffness": 2e6, "restitution": 0.22, "initial_force": 1e4}
    for tolerance in (4e-3, 5e-4):
        impacts = sampled_impacts(0.35, **values, **law, interval=5e-4, sensor=5.0, tolerance=tolerance)
        force = impacts.mean_force
        assert values["mass"] * impacts.acceleration == pytest.approx(force, abs=1e-9 * force.max())
    assert not sampled_impacts(0.35, **values, **law, interval=5e-4).acceleration.size


@pytest.mark.parametrize("position", [1.0, 5.4])
def test_many_are_each_alone(position):
    one = case(IMPACT, f"sensor.position={position}")
    impacts = one.impacts({"contact.friction": np.array([0.35])}, sensor=position, interval=5e-4)
    rows = 100
    speed = np.cumsum(impacts.acceleration[:, 0]) * 5e-4
    mean = (speed[rows:] - speed[:-rows]).max() / 0.05
    assert one.inertial["mean_50ms"] == pytest.approx(one.vehicle.mass * mean, rel=2e-3)
    assert (one.inertial["position"], one.inertial["assumed"]) == (position, False)


@pytest.mark.parametrize(("position", "height"), [(5.0, 1.35), (2.0, 0.4), (6.0, 3.0)])
def test_in_space_the_sensor_is_a_point_of_the_body(position, height):
    """Axles are of 20 kg, and both centres of mass nearly coincide."""
    light = [f"axle.{number}.mass=20" for number in (0, 1)]
    one = case(SPACE, *light, f"sensor.position={position}", f"sensor.height={height}")
    h = one.space.motion.history
    axes = Rotation.from_euler("ZYX", np.array([h["yaw"], h["pitch"], h["roll"]]).T)
    arm = axes.apply([5.0 - position, 0.0, height - 1.35])
    spin = np.array([h["omega_x"], h["omega_y"], h["omega_z"]]).T
    speed = h["v_gy"] + np.cross(spin, arm)[:, 1]
    mean = (speed[ROWS:] - speed[:-ROWS]).max() / 0.05
    assert one.inertial["mean_50ms"] == pytest.approx(9979.0 * mean, rel=1e-3)
    assert one.inertial["height"] == height


@pytest.mark.parametrize(("name", "label"), [(IMPACT, "rigid"), (SPACE, "space")])
def test_files_have_the_motion_of_the_sensor(name, label, tmp_path):
    """A file's acceleration times mass is the printed force.

    Without [sensor] a file has none.
    """
    columns, changes = {"sensor_velocity", "sensor_acceleration"}, ["sensor.position=4", "time.end=0.4"]
    result = tailslap.run(name, [*changes, "plate.elements=[20, 6]"], band=False)
    result.save(tmp_path / "out", pictures=False)
    histories = tailslap.load(tmp_path / "out").histories
    assert all(columns <= set(history) for history in histories.values())
    assert not columns & set(case(name).rigid_history())
    h = histories[label]
    rows = round(0.05 / h["t"][1])
    mean = sliding_window_view(h["sensor_acceleration"], rows).mean(axis=1).max()
    assert case(name).vehicle.mass * mean == pytest.approx(result.summary["inertial"]["mean_50ms"], rel=1e-3)
    gain = h["sensor_velocity"][-1] - h["sensor_velocity"][0]
    assert h["sensor_acceleration"].sum() * h["t"][1] == pytest.approx(gain, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "changes"), [(IMPACT, ("sensor.position=4",)), ("impact-parapet-tl4-sut", ())]
)
def test_the_papers_method_ignores_tables_of_a_whole_impact(name, changes):
    assert case(name, *changes).paper_method == case("impact-mash-tl4-sut").paper_method | {
        key: case(name, *changes).paper_method[key] for key in ("computed_duration", "computed_peak_force")
    }


def test_an_assumed_place_is_called_assumed():
    for name in (IMPACT, SPACE):
        one = case(name)
        assert one.inertial["position"] == pytest.approx(5.25)
        assert "5.25 m behind the front" in SI.rendered(one.inertial_sentence)
        assert "an assumed place" in SI.rendered(one.inertial_sentence)
        assert tailslap.rigid(name, band=False).summary["inertial"] == one.inertial
    assert case(SPACE).inertial["height"] == pytest.approx(0.95)
    placed = case(SPACE, "sensor.behind_centre=0", "sensor.height=1 m")
    assert "assumed" not in placed.inertial_sentence
    assert case(TRAIN).inertial is None


@pytest.mark.parametrize(("name", "change", "allowed"), [
    (IMPACT, ("sensor.position=10.1",), "from 0 to the length of the vehicle, 10 m"),
    (IMPACT, ("sensor.behind_centre=-5.1",), "from -5 to 5 m"),
    (IMPACT, ("sensor.height=1",), "requires \\[body\\]"),
    (IMPACT, ("sensor.position=5", "sensor.behind_centre=0"), "remove one of the two"),
    (SPACE, ("sensor.height=4.1",), "up to 3 times"),
    (TRAIN, ("sensor.position=1",), "of a single vehicle"),
    ("mash-tl4-sut", ("sensor.position=1",), "requires \\[contact\\]"),
])  # fmt: skip
def test_a_sensor_outside_the_vehicle_is_refused(name, change, allowed):
    with pytest.raises(InputError, match=allowed):
        case(name, *change)
