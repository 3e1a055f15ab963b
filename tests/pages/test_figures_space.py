"""Verify positions and forces in pictures of a vehicle in space."""

from typing import Any

import numpy as np
import pytest

from postprocess.figures import animation, space
from postprocess.svg.areas import Boxes, Outline
from postprocess.svg.marks import Level, Line, Words
from postprocess.svg.motion import Moving
from postprocess.units import SI

UNIT = space.DrawnUnit(length=10.0, width=2.4, mass=10000.0, centre=4.0, centre_height=1.5, low=0.5, top=2.7)
AXLES = (
    space.DrawnAxle(0, position=1.0, track=2.0, radius=0.5, roll_centre=0.6, mass=500.0),
    space.DrawnAxle(0, position=7.0, track=2.0, radius=0.5, roll_centre=0.6, mass=1000.0),
)
STRIPS = (
    space.DrawnStrip(0, -1, (10.0, 10.0), (1.2, 2.6), 0.1),
    space.DrawnStrip(0, 1, (7.0, 7.0), (0.1, 1.0), 0.0),
)
FACE = np.array([(0.0, 0.0), (0.0, 0.1), (-0.2, 0.4), (-0.3, 0.9)])
VEHICLE = space.DrawnVehicle((UNIT,), AXLES, STRIPS, FACE)
BEHIND = space.DrawnAxle(1, 8.0, 2.0, 0.5, 0.6, 1000.0), space.DrawnStrip(1, -1, (0.0, 10.0), (1.2, 1.2), 0.0)
TRAIN = space.DrawnVehicle((UNIT, UNIT), (*AXLES, BEHIND[0]), (*STRIPS, BEHIND[1]), FACE)
ROLL = np.arctan2(3.0, 4.0)
"""Roll with sine 0.6 and cosine 0.8."""


def history(rows=1, units=1, axles=2, **columns):
    """Columns at rest over the origin, with others instead."""
    ends = ("", *(f"_{unit}" for unit in range(2, units + 1)))
    names = ("x_g", "y_g", "z_g", "yaw", "pitch", "roll", "v_gx", "v_gy")
    wheels = ("load_right", "load_left", "heave", "axle_roll")
    table = {f"{name}{end}": 0.0 for end in ends for name in names}
    table |= {f"z_g{end}": 1.5 for end in ends}
    table |= {
        f"{name}_{axle}": 1e4 * name.startswith("load") for axle in range(1, axles + 1) for name in wheels
    }
    return {"t": 0.5 * np.arange(rows)} | {
        name: np.broadcast_to(np.asarray(value, dtype=float), rows)
        for name, value in (table | columns).items()
    }


def marks(chart, kind: Any, plot=0):
    return [mark for mark in chart.plots[plot].marks if isinstance(mark, kind)]


def has_points(outlines, points):
    return any(
        mark.x.size == len(points) and np.allclose(np.column_stack([mark.x, mark.y]), points)
        for mark in outlines
    )


def test_a_vehicle_at_rest_has_its_dimensions():
    """The centre of mass is 4 m behind the front."""
    rear, front = space.box(VEHICLE, history(), 0)[0].reshape(2, 4, 3)
    assert front[0] == pytest.approx((4.0, -1.2, 0.5), abs=1e-12)
    assert rear[2] == pytest.approx((-6.0, 1.2, 2.7), abs=1e-12)


@pytest.mark.parametrize(
    ("angles", "corner"),
    [
        ({"roll": ROLL}, (4.0, -1.2 * 0.8 + 1.0 * 0.6, -1.2 * 0.6 - 1.0 * 0.8)),
        ({"pitch": ROLL}, (4.0 * 0.8 - 1.0 * 0.6, -1.2, -4.0 * 0.6 - 1.0 * 0.8)),
        ({"yaw": ROLL}, (4.0 * 0.8 + 1.2 * 0.6, 4.0 * 0.6 - 1.2 * 0.8, -1.0)),
        ({"yaw": np.pi / 2.0, "roll": np.pi / 2.0}, (-1.0, 4.0, -1.2)),
        ({"yaw": np.pi / 2.0, "pitch": np.pi / 2.0, "roll": np.pi / 2.0}, (-1.0, -1.2, -4.0)),
    ],
)
def test_a_corner_is_rotated_about_the_centre_of_mass(angles, corner):
    """Yaw, pitch and roll in this order, at the lower right corner.

    It is at (4, -1.2, -1) from G; pitch is nose down, roll to the right.
    """
    moved = space.box(VEHICLE, history(x_g=20.0, y_g=3.0, z_g=2.0, **angles), 0)[0, 4]
    assert moved == pytest.approx(np.array((20.0, 3.0, 2.0)) + corner, abs=1e-12)


def test_wheels_follow_heave_and_roll_of_their_axle():
    """The axle rolls about its roll centre.

    The common centre of mass remains. Rear axle, 0.1 of the mass: heave 0.2 m, roll with sine 0.6, which displaces its
    centre by (0.06, 0.02 + 0.2) m.
    """
    h = history(heave_2=0.2, axle_roll_2=ROLL)
    centre_y, centre_z = 0.1 * 0.6, 0.6 + 0.2 - 0.1 * 0.8
    shift = 0.1 * np.array([centre_y, centre_z - 0.5])
    wheel = space.wheel(VEHICLE, h, 1, 1)[0].mean(axis=0)
    assert wheel == pytest.approx((-3.0, centre_y + 0.8 - shift[0], centre_z + 0.6 - shift[1]), abs=1e-12)
    other = space.wheel(VEHICLE, h, 0, -1)[0].mean(axis=0)
    assert other == pytest.approx((3.0, -1.0 - shift[0], 0.5 - shift[1]), abs=1e-12)
    sizes = (
        np.ptp(space.wheel(VEHICLE, history(), 1, 1)[0], axis=0),
        np.ptp(space.wheel(VEHICLE, history(), 1, 1, True)[0], axis=0),
    )
    assert sizes[0] == pytest.approx((0.0, space.WHEEL, 1.0), abs=1e-12)
    assert sizes[1] == pytest.approx((1.0, space.WHEEL, 0.0), abs=1e-12)


def test_the_elevation_has_wall_body_strips_and_force_at_their_places():
    h = history(3, roll=[0.0, ROLL, 0.0], load_left_2=[1e4, 0.0, 1e4], y_g=2.0)
    chart = space.draw_elevation(VEHICLE, h, 1, 250e3, 0.25)
    outlines = marks(chart, Outline)
    end = chart.x.high
    assert end is not None
    assert chart.x.low is not None
    assert chart.x.low > 0.0 > end
    assert has_points(outlines, [*FACE, (end, 0.9), (end, 0.0)])
    assert has_points(outlines, space.box(VEHICLE, h, 0)[1, :4, 1:])
    red = [mark for mark in outlines if mark.colour == "red"]
    assert len(red) == 1
    assert has_points(red, space.wheel(VEHICLE, h, 1, 1)[1, :, 1:])
    lines = marks(chart, Line)
    arrow = next(line for line in lines if line.colour == "difference")
    assert (arrow.x, arrow.y) == (pytest.approx((-0.1, -0.1 - space.ARROW)), pytest.approx((0.25, 0.25)))
    strip, of_axle = (np.column_stack([line.x, line.y]) for line in lines if line.label == "strips")
    turned = np.array([[0.8, 0.6], [-0.6, 0.8]])
    assert strip == pytest.approx(np.array([(-1.1, -0.3), (-1.1, 1.1)]) @ turned + (2.0, 1.5))
    assert of_axle == pytest.approx(np.array([(-1.2, -1.4), (-1.2, -0.5)]) @ turned + (2.0, 1.5))
    assert "36.9 deg at 0.50 s" in chart.in_units(SI).caption
    texts = [mark.label for mark in marks(chart, Words)]
    assert any("250" in text for text in texts)
    assert "G" in texts


def test_the_plan_has_units_wall_and_direction():
    h = history(
        units=2, axles=3, y_g=2.0, x_g_2=-9.0, y_g_2=2.0, v_gx=4.0, v_gy=3.0, v_gx_2=5.0, load_right_3=0.0
    )
    chart = space.draw_plan(TRAIN, h, 0)
    outlines = marks(chart, Outline)
    for x in (0.0, -9.0):
        assert has_points(outlines, [(x - 6.0, 0.8), (x - 6.0, 3.2), (x + 4.0, 3.2), (x + 4.0, 0.8)])
    assert [mark.colour for mark in outlines].count("red") == 1
    arrows = [line for line in marks(chart, Line) if line.width == 1.2]
    assert (arrows[0].x[1], arrows[0].y[1]) == (pytest.approx(3.0 * 0.8), pytest.approx(2.0 + 3.0 * 0.6))
    assert (arrows[1].x[1], arrows[1].y[1]) == (pytest.approx(-6.0), pytest.approx(2.0))
    edge = marks(chart, Line)[0]
    assert edge.y == pytest.approx((-0.3, -0.3))


def test_the_height_is_the_moment_over_the_force_above_five_percent():
    t, none = np.linspace(0.0, 0.5, 6), np.zeros(5)
    force = np.array([0.0, 100e3, 4.9e3, 5.1e3, 50e3])
    chart = space.draw_force_height(t, force, force * np.array([9.0, 0.8, 9.0, 0.7, 0.6]), {"wall": 0.9})
    (height,) = marks(chart, Line, 1)
    assert height.y == pytest.approx([np.nan, 0.8, np.nan, 0.7, 0.6], nan_ok=True)
    (line,) = marks(chart, Line)
    assert line.y == pytest.approx(force / 1e3)
    (level,) = marks(chart, Level, 1)
    assert (level.label, level.value) == ("wall", 0.9)
    still = space.draw_force_height(t, none, none, {})
    assert np.isnan(marks(still, Line, 1)[0].y).all()


def test_bars_are_the_intervals_of_lifted_wheels():
    """Rows from the right wheels of the first axle downwards."""
    places = (1, "left", 0.1, 0.3), (2, "right", 0.2, 0.05)
    lifts = [dict(zip(("axle", "side", "start", "duration"), place, strict=True)) for place in places]
    chart = space.draw_angles(VEHICLE, history(5, roll=0.1, pitch=-0.05), lifts)
    (bars,) = marks(chart, Boxes, 2)
    assert np.asarray(bars.x) == pytest.approx(np.array([(0.1, 0.4), (0.2, 0.25)]))
    assert np.mean(bars.y, axis=1) == pytest.approx((1.0, 2.0))
    assert chart.plots[2].y.named == (
        (0.0, "axle 1 right"),
        (1.0, "axle 1 left"),
        (2.0, "axle 2 right"),
        (3.0, "axle 2 left"),
    )
    assert list(bars.values) == ["0.300 s", "0.050 s"]
    assert marks(chart, Line)[0].y == pytest.approx(np.degrees(0.1))
    assert marks(chart, Line, 1)[0].y == pytest.approx(np.degrees(-0.05))
    assert marks(space.draw_angles(VEHICLE, history(5), []), Boxes, 2)[0].x.shape == (0, 2)


def test_a_train_has_a_line_for_each_unit():
    h = history(5, units=2, axles=3, roll=0.1, roll_2=0.3)
    chart = space.draw_angles(TRAIN, h, [])
    labels = [[line.label for line in marks(chart, Line, plot)] for plot in (0, 1)]
    assert labels == [["unit 1", "unit 2"]] * 2
    assert [float(line.y[0]) for line in marks(chart, Line)] == pytest.approx(np.degrees([0.1, 0.3]))
    assert "Unit 2 from behind" in space.draw_elevation(TRAIN, h, 0, 1e5, 0.5).caption


def test_an_animation_has_both_views(tmp_path):
    """The plan is about the first unit, and frames differ."""
    from PIL import Image

    h = history(6, x_g=np.arange(6.0), y_g=2.0, roll=0.1 * np.arange(6))
    behind, above = space.film_views(VEHICLE, h)
    corners = space.box(VEHICLE, h, 0)
    assert behind.outlines[3] == pytest.approx(corners[:, :4, 1:])
    assert above.outlines[0][:, 0, 0] == pytest.approx(-6.0)
    films = space.draw_films(VEHICLE, h)
    drawn = [[mark.y for mark in marks(film, Moving)] for film in films]
    assert [len(polygons) for polygons in drawn] == [len(behind.outlines), len(above.outlines)]
    np.testing.assert_array_equal(drawn[0][3], behind.outlines[3][..., 1])
    assert behind.is_mirrored
    assert behind.face is FACE
    path = animation.write_animation(tmp_path / "space.gif", h["t"], (behind, above), 1e5 * h["t"])
    with Image.open(path) as film:
        assert getattr(film, "n_frames", 1) == 6
        first = np.array(film.convert("RGB"))
        film.seek(5)
        assert (np.array(film.convert("RGB")) != first).any(axis=-1).mean() > 0.02


@pytest.mark.long
@pytest.mark.parametrize("changes", [(), ("wall.profile=new-jersey",)])
def test_drawn_tyres_are_compressed_by_their_loads(changes):
    """The load is stiffness times depth of the unloaded tyre."""
    from tailslap.case.impact.space.answer import solve
    from tailslap.case.impact.space.figures import charts, geometry
    from tailslap.case.impact.space.input import space_input
    from tailslap.scene.read import read_scene

    answer = solve(space_input(read_scene("impact-tipping-tl4-sut", changes)[0]))
    vehicle, wall, motion = answer.inputs.vehicle, answer.inputs.wall, answer.motion
    h, drawn = motion.history, geometry(vehicle, wall)
    for number, axle in enumerate(vehicle.axles):
        at_rest = h[f"load_right_{number + 1}"][0] / axle.tyre
        place, half = float(axle.position), 0.5 * float(axle.track)
        lowest = [(-place, side * half, -float(at_rest)) for side in (-1.0, 1.0)]
        depth = -space.moved(drawn, h, 0, lowest, number)[..., 2]
        for column, side in enumerate(space.SIDES):
            load = h[f"load_{side}_{number + 1}"]
            assert axle.tyre * np.maximum(depth[:, column], 0.0) == pytest.approx(load, rel=1e-6, abs=1.0)
    edge, top = drawn.face[-1]
    assert (top, edge < -0.1) == (pytest.approx(0.9144), bool(changes))
    *_, elevation, _, force, angles = charts(vehicle, wall, motion, answer.lifted)
    (height,) = marks(force, Line, 1)
    assert height.y[np.nanargmin(np.abs(height.x - motion.answers.mean_time))] > 0.5
    assert f"{np.degrees(motion.answers.largest_roll):.1f} deg" in elevation.in_units(SI).caption
    (bars,) = marks(angles, Boxes, 2)
    assert len(bars.x) == len(answer.lifted)
