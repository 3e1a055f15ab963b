"""Verify peaks and loops in figures of an impact."""

import re

import numpy as np
import pytest
from browser.charts import points_of
from chart_samples import samples, texts

from postprocess.figures import animation, impact, positions
from postprocess.svg.marks import Line, Words
from postprocess.svg.motion import HOLD, MAX_FRAMES, SLOWER

T = np.linspace(0.0, 0.5, 5001)
STRIKES = (
    impact.StrikeMark("front", 0.0, 0.08, (0.0, 2.0)),
    impact.StrikeMark("rear", 0.29, 0.36, (-2.7, -1.2)),
)


def found(pattern, svg):
    match = re.search(pattern, svg, re.DOTALL)
    assert match
    return match[1]


def points(svg, colour):
    """Points of the longest line of a colour, y upwards."""
    groups = re.findall(rf'<g class="{colour}"[^>]*>(<path .*?)</g>', svg)
    paths = [re.findall(r' d="([^"]+)"', group)[0] for group in groups]
    return max(map(points_of, paths), key=len) * (1.0, -1.0)


def test_positions_name_instants_and_strikes():
    x, y, theta = np.array([0.0, 2.0, 5.0]), np.array([2.4, 1.5, 1.2]), np.array([0.26, 0.1, 0.0])
    outlines = positions.vehicle_outlines(x, y, theta, 10.0, 2.4, 5.0)
    curve = positions.draw_positions(outlines, (0.0, 0.1, 0.25), STRIKES)
    labels = {"0.00 s", "0.10 s", "0.25 s", "front 0.00 s", "rear 0.29 s"}
    assert labels <= set(texts(curve.svg))


def test_positions_keep_their_scale():
    """The sides of the outline have the ratio of the vehicle."""
    outlines = positions.vehicle_outlines(np.array([0.0]), np.array([2.4]), np.array([0.3]), 10.0, 2.5, 5.0)
    corners = points(positions.draw_positions(outlines, (0.0,)).svg, "fe")[:4]
    sides = np.hypot(*np.diff(corners, axis=0).T)
    assert sides[0] / sides[1] == pytest.approx(4.0, rel=1e-3)


def frames(svg, wide):
    """Corners of a polygon in each frame, shape (frames, points, 2) [pixels]."""
    strip = found(r'class="moving".*?<path d="([^"]*)Z" fill', svg).split("Z")
    corners = np.array([points_of(frame) for frame in strip])
    corners[..., 0] -= wide * np.arange(len(corners))[:, None]
    return corners


@pytest.mark.parametrize("rows", [40, 500])
def test_the_animation_shows_each_instant_where_the_vehicle_was(rows):
    """It is rotated by 0.3 rad and displaced by 4 m."""
    t, x = np.linspace(0.0, 0.5, rows), np.linspace(0.0, 4.0, rows)
    every = positions.vehicle_outlines(x, 1.2 + 0.0 * x, 0.3 - 0.6 * t, 8.0, 2.0, 4.0)
    chart = positions.draw_positions(every[[0, -1]], t[[0, -1]].tolist(), motion=(t, every))
    x_left, top, right, _ = map(float, found(r'data-box="([^"]*)"', chart.svg).split())
    outlines = frames(chart.svg, right - x_left) + np.array([x_left, top])
    assert len(outlines) == min(rows, MAX_FRAMES)
    for instant, corners in (("0.00 s", outlines[0]), ("0.50 s", outlines[-1])):
        edge = found(rf'<path data-label="{instant}" d="([^"]*)Z"', chart.svg)
        np.testing.assert_allclose(corners, points_of(edge), atol=0.21)
    way = float(found(r"--shift:(-?[\d.]+)px", chart.svg))
    assert way == pytest.approx(-(right - x_left) * (len(outlines) - 1), abs=0.01 * len(outlines))
    assert f"steps({len(outlines) - 1})" in chart.svg
    assert f"--time:{SLOWER * 0.5 / (1.0 - HOLD):.3g}s" in chart.svg
    assert chart.is_moving
    assert not positions.draw_positions(every[[0, -1]], t[[0, -1]].tolist()).is_moving


def test_a_train_bends_in_the_animation():
    """The second unit rotates relative to the first."""
    t = np.linspace(0.0, 0.5, 30)
    bent = np.stack(
        [np.array([(9.0, 1.0), (5.0, 1.0), (1.0, 1.0 + rise), (1.0, 3.0), (9.0, 3.0)]) for rise in t]
    )
    chart = positions.draw_positions(bent[[0, -1]], t[[0, -1]].tolist(), motion=(t, bent))
    x_left, _, right, _ = map(float, found(r'data-box="([^"]*)"', chart.svg).split())
    outlines = frames(chart.svg, right - x_left)
    turned = np.arctan2(*(outlines[:, 2] - outlines[:, 1]).T)
    assert turned[0] - turned[-1] == pytest.approx(np.arctan(0.5 / 4.0), abs=1e-3)
    np.testing.assert_allclose(outlines[:, 0], outlines[0, 0][None].repeat(30, 0), atol=0.11)


def test_the_cursor_runs_from_start_to_end_with_the_animation():
    force = impact.Forces("force", T[1:], {"raw": 1e5 + 0.0 * T[1:]})
    svg = impact.draw_forces("Force", [force], motion=T).svg
    x_left, _, right, _ = map(float, found(r'data-box="([^"]*)"', svg).split())
    assert float(found(r'class="moving".*?<path d="M([\d.]+) ', svg)) == pytest.approx(x_left, abs=0.01)
    assert float(found(r"--shift:(-?[\d.]+)px", svg)) == pytest.approx(right - x_left, abs=0.02)
    assert f"steps({MAX_FRAMES - 1})" in svg


def test_filters_and_the_rigid_vehicle_are_shown_on_request():
    """Raw force and 50 ms mean are drawn, the others hidden."""
    curves = {name: 1e5 * np.sin(6.0 * T) for name in impact.LINES}
    forces = [
        impact.Forces("lateral", T, curves),
        impact.Forces("lateral", T, {"raw": curves["raw"]}, ", rigid"),
    ]
    chart = impact.draw_forces("Force", [*forces, impact.Forces("along", T, curves)])
    lateral, along = ([mark for mark in plot.marks if isinstance(mark, Line)] for plot in chart.plots)
    assert [line.label for line in lateral if line.is_shown] == ["raw", "50 ms mean"]
    assert [line.label for line in along if line.is_shown] == ["raw", "50 ms mean"]
    assert {line.label for line in lateral if not line.is_shown} >= {"CFC 60", "raw, rigid"}
    assert chart.svg.count('style="display:none"') == 4 + 4 + 3, "keys, lateral and longitudinal lines"
    headings = {column.heading.partition(" [")[0] for column in samples(chart)}
    assert {"CFC 60: lateral", "CFC 60: along", "raw, rigid: lateral"} <= headings


def test_instants_of_close_positions_stand_in_two_rows():
    """At 10, 10.2, 10.4 and 13 m one is raised, one omitted."""
    square = np.array([(0.0, 0.0), (-9.0, 0.0), (-9.0, 2.0), (0.0, 2.0)])
    outlines = np.stack([square + np.array([x, 0.0]) for x in (10.0, 10.2, 10.4, 13.0)])
    chart = positions.draw_positions(outlines, (0.0, 0.1, 0.2, 0.3))
    words = [mark for mark in chart.plots[0].marks if isinstance(mark, Words)]
    assert [(word.label, word.shift[1]) for word in words] == [
        ("0.00 s", -3.0), ("0.10 s", -13.0), ("0.30 s", -3.0),
    ]  # fmt: skip


def test_a_spike_of_the_force_is_drawn():
    """One sample of 1 MN is twice as high as a level."""
    force = np.zeros_like(T)
    force[1234] = 1e6
    svg = impact.draw_forces(
        "Force", [impact.Forces("force", T, {"raw": force})], STRIKES, {"AASHTO LRFD": 5e5}
    ).svg
    line = points(svg, "grey")[:, 1]
    level = -float(found(r'class="difference"[^>]*><path d="M\S+ ([\d.]+)H', svg))
    assert line.max() - level == pytest.approx(level - line.min(), rel=1e-4)
    assert {"raw", "front", "rear", "AASHTO LRFD 500 kN"} <= set(texts(svg))
    assert "CFC 60" not in texts(svg)


def test_a_loop_keeps_its_corners():
    """Loading, unloading, reloading and further loading have few points."""
    crush = np.interp(np.linspace(0.0, 4.0, 4001), range(5), [0.0, 0.3, 0.28, 0.3, 0.4])
    force = np.interp(np.linspace(0.0, 4.0, 4001), range(5), [0.0, 600e3, 0.0, 600e3, 800e3])
    drawn = points(impact.draw_loops({"front": (crush, force)}).svg, "red")
    assert len(drawn) < 40
    x, y = ((drawn - drawn[0]) / np.ptp(drawn, axis=0)).T
    for corner in ((0.75, 0.75), (0.7, 0.0), (1.0, 1.0)):
        assert np.hypot(x - corner[0], y - corner[1]).min() < 1e-3


def test_layers_end_at_what_was_given_up():
    """Half goes to friction, half to crush."""
    kinetic = 3e6 - 9e5 * np.clip(T / 0.4, 0.0, 1.0)
    half = 0.5 * (kinetic[0] - kinetic)
    svg = impact.draw_energies(
        T, kinetic, {"crush, lost": half, "friction": half, "damping": 0.0 * half}, STRIKES
    ).svg
    assert {"kinetic energy lost", "crush, lost", "friction"} <= set(texts(svg))
    assert "damping" not in texts(svg)
    layer = points_of(found(r'<path data-label="friction".*? d="([^"]+)"', svg))
    assert max(-layer[:, 1]) == pytest.approx(points(svg, "ink")[:, 1].max(), abs=1e-4)


def test_contact_of_one_instant_is_seen():
    """A cell has the largest force of its time."""
    force = np.zeros((T.size, 5))
    plain = impact.draw_side_force(T, np.linspace(0.0, 10.0, 5), force)
    force[1777, 2] = 300.0
    chart = impact.draw_side_force(T, np.linspace(0.0, 10.0, 5), force, STRIKES)
    assert samples(plain) == []
    svg = chart.svg
    (cells,) = samples(chart)
    assert (cells.where, cells.values[0]) == ("t [s]; distance from the front [m]", "300 kN")
    time, place = cells.at[0].split("; ")
    assert (float(time[:-2]), place) == (pytest.approx(T[1777], abs=T[-1] / impact.COLUMNS), "5 m")
    assert "300\N{NO-BREAK SPACE}kN" in texts(svg)
    assert len(svg) < len(plain.svg) + 1500


@pytest.mark.parametrize(("instants", "frames"), [(7, 7), (animation.MAX_FRAMES + 30, animation.MAX_FRAMES)])
def test_animation(tmp_path, instants, frames):
    """The film is ten times slower, with at most MAX_FRAMES frames."""
    from PIL import Image

    t = np.linspace(0.0, 0.3, instants)
    outlines = positions.vehicle_outlines(25.0 * t, 2.5 - t, 0.26 - t / 2.0, 10.0, 2.4, 5.0)
    view = animation.from_above(outlines)
    path = animation.write_animation(tmp_path / "impact.gif", t, (view,), 1e5 * np.sin(10.0 * t))
    assert path == tmp_path / "impact.gif"
    with Image.open(path) as film:
        assert getattr(film, "n_frames", 1) == frames
        assert film.info["duration"] == pytest.approx(3000.0 / (frames - 1), abs=5.0)
        first = np.array(film.convert("RGB"))
        film.seek(frames - 1)
        assert (np.array(film.convert("RGB")) != first).any(axis=-1).mean() > 0.02
