"""Verify that pictures of a rotating plate have the exact colours."""

import json
import os
import re
import subprocess
import sys
from ctypes.util import find_library
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.image import imread

import tailslap
from postprocess.fields import canvas, contours
from postprocess.svg.scales import viridis
from postprocess.units import SI, US
from tailslap.arguments import picture_pixels
from tailslap.cli import _status
from tailslap.errors import InputError

ROOT = Path(__file__).parents[2]
LENGTH, WIDTH, SLIDE, OMEGA, SPEED = 10.0, 2.438, 9.42, 0.655, (23.27, -3.275)
COLUMNS, ROWS = 20, 6
FOOT, KSI = 0.3048, 4448.2216152605 / 0.0254**2
SMALL = (400, 175)
"""Size of pictures of which only the words are read [pixels]."""


def grid(columns, rows, low, high):
    x, y = np.meshgrid(np.linspace(low[0], high[0], columns + 1), np.linspace(low[1], high[1], rows + 1))
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    quads = np.column_stack([first, first + 1, first + columns + 2, first + columns + 1])
    return np.column_stack([x.ravel(), y.ravel()]), quads


POINTS, QUADS = grid(COLUMNS, ROWS, (SLIDE - LENGTH, 0.0), (SLIDE, WIDTH))
WALL_POINTS, WALL_QUADS = grid(60, 10, (-10.0, -5.0), (20.0, 0.0))
CENTROID = (SLIDE - LENGTH / 2, WIDTH / 2)


def velocities(points):
    arm = points - CENTROID
    return np.column_stack([SPEED[0] - OMEGA * arm[:, 1], SPEED[1] + OMEGA * arm[:, 0]])


PLATE = contours.Situation((POINTS, QUADS), corner=(SLIDE, 0.0), centroid=CENTROID)
WITH_WALL = replace(PLATE, wall=(WALL_POINTS, WALL_QUADS))


def fields():
    v = velocities(POINTS)
    rounding = OMEGA * (1.0 + 1e-15 * np.random.default_rng(3).normal(size=len(POINTS)))
    return [
        contours.ContourField("v_gx", "v_GX: nodal velocity along X", "m/s", v[:, 0]),
        contours.ContourField("v_gy", "v_GY: nodal velocity along Y", "m/s", v[:, 1]),
        contours.ContourField("omega", "ω: nodal angular velocity", "rad/s", rounding),
    ]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    out = tmp_path_factory.mktemp("pictures")
    paths = contours.draw_contours(WITH_WALL, fields(), out)
    assert [path.name for path in paths] == ["contour_v_gx.png", "contour_v_gy.png", "contour_omega.png"]
    return {path.stem: np.rint(imread(path)[..., :3] * 255).astype(np.uint8) for path in paths}


def pixels(picture, points):
    """Colours at points (k, 2) [m], shape (k, 3)."""
    column, row = np.floor(contours.view_of_plate(POINTS).pixel(points)).astype(int).T
    return picture[canvas.SIZE[1] - 1 - row, column]


def element_points(quads):
    """A point of each element, off mesh lines and boundaries of bands."""
    return POINTS[QUADS[quads]].mean(axis=1) + np.array([0.02, 0.05])


def clear_of_words(points):
    """Return False at the label of the centre of mass."""
    across, up = (points - CENTROID).T
    return (across < -0.2) | (across > 1.9) | (np.abs(up) > 0.6)


@pytest.mark.parametrize(("name", "component"), [("contour_v_gx", 0), ("contour_v_gy", 1)])
def test_colours_are_those_of_the_exact_velocities(pictures, name, component):
    at = element_points(list(range(0, len(QUADS), 3)))
    at = at[clear_of_words(at)]
    values, nodal = velocities(at)[:, component], velocities(POINTS)[:, component]
    scale = contours.colour_scale(nodal)
    part = (values - scale.low) / (scale.high - scale.low)
    inside = np.abs(part * scale.bands - np.rint(part * scale.bands)) > 0.08
    assert inside.sum() > 20
    expected = mpl.colormaps["viridis"].resampled(scale.bands)(part[inside])[:, :3] * 255
    np.testing.assert_allclose(pixels(pictures[name], at[inside]), expected, atol=2)


def test_a_uniform_field_has_one_colour(pictures):
    at = element_points(slice(None))
    at = at[clear_of_words(at)]
    assert len(np.unique(pixels(pictures["contour_omega"], at), axis=0)) == 1


def test_size_wall_and_background(pictures):
    ground, hatch = (
        np.array([int(c[i : i + 2], 16) for i in (1, 3, 5)])
        for c in (canvas.LIGHT["wall"], canvas.LIGHT["hatch"])
    )
    for picture in pictures.values():
        assert picture.shape == (700, 1600, 3)
        wall = pixels(picture, np.column_stack([np.linspace(2.2, 2.8, 200), np.full(200, -0.4)])).astype(int)
        bare = np.abs(wall - ground).max(axis=1) < 2
        assert 0.7 < bare.mean() < 0.97, "most of the wall is bare"
        starts = np.flatnonzero(np.diff(bare.astype(int)) == -1)
        step = contours.HATCH_STEP * contours.view_of_plate(POINTS).length / (0.6 / 199)
        np.testing.assert_allclose(np.diff(starts), step, atol=2.0 * step / contours.HATCH_STEP + 1.0)
        assert np.abs(wall - hatch).max(axis=1).min() < 40, "lines across it, which the vehicle has not"
        beside = pixels(picture, np.array([[-0.8, 0.75], [9.8, 1.0], [4.0, 2.6]]))
        np.testing.assert_array_equal(beside, np.full((3, 3), 255))


def test_corner_and_centroid_are_marked(pictures):
    for picture in pictures.values():
        marks = pixels(picture, np.array([(SLIDE, 0.0), CENTROID]))
        np.testing.assert_array_equal(marks, np.full((2, 3), 255))


def test_without_a_wall_mesh_there_is_a_line(tmp_path):
    (path,) = contours.draw_contours(contours.Situation((POINTS, QUADS)), fields()[:1], tmp_path)
    picture = np.rint(imread(path)[..., :3] * 255).astype(np.uint8)
    below = pixels(picture, np.array([[2.3, -0.3], [9.8, -0.13]]))
    np.testing.assert_array_equal(below, np.full((2, 3), 255))
    assert pixels(picture, np.array([[9.8, 0.0]])).max() < 100


def test_a_wall_out_of_sight_is_not_drawn(tmp_path):
    beyond = replace(WITH_WALL, wall=(WALL_POINTS + np.array([500.0, 0.0]), WALL_QUADS))
    (path,) = contours.draw_contours(beyond, fields()[:1], tmp_path)
    picture = np.rint(imread(path)[..., :3] * 255).astype(int)
    np.testing.assert_array_equal(pixels(picture, np.array([[2.3, -0.3]])), np.full((1, 3), 255))


def test_words_are_set_as_in_tables():
    """Typographic minus, powers of ten and indices, with equal decimals."""
    assert canvas.typeset("v_X = -1.5e-07 m/s") == [("v", False), ("X", True), (" = −1.5×10⁻⁷ m/s", False)]
    assert canvas.typeset("kip ft/ft^3 a$b") == [("kip ft/ft³ a$b", False)]
    assert [contours.field_title(name) for name in ("velocity_y", "stress_von_mises")] == [
        "Velocity Y",
        "Von Mises stress",
    ]


@pytest.fixture
def words(monkeypatch):
    """Texts of each picture that is drawn."""
    pictures = []

    image = canvas.Canvas.image

    def read(drawn):
        typeset = ([piece for piece, _ in canvas.typeset(words[0])] for words in drawn._words)
        pictures.append({"".join(pieces) for pieces in typeset})
        return image(drawn)

    monkeypatch.setattr(canvas.Canvas, "image", read)
    return pictures


def test_words_in_the_picture(tmp_path, words):
    _, across, spin = fields()
    situation = replace(PLATE, scene="a-scene", time=0.38395974)
    contours.draw_contours(situation, [replace(across, of_centre=-3.2), spin], tmp_path, size=SMALL)
    velocity, dark, angular, _ = words
    assert dark == velocity
    assert {"a-scene,  tail-slap at t = 0.384 s", "P", "Y [m]", "0.5", "2.0", "0", "9"} <= velocity & angular
    title = "vGY: nodal velocity along Y [m/s]"
    assert {title, "G: −3.2000 m/s", "nodal values from −6.55 to 0 m/s"} <= velocity
    assert {"ω: nodal angular velocity [rad/s]", "G: 0.65500 rad/s"} <= angular
    uniform = re.compile(r"uniform to \d×10⁻¹.: 0.655 rad/s at every node; .* widened to 1 %")
    assert any(map(uniform.match, angular))


@pytest.mark.parametrize("size", [(2400, 1050), (800, 350), (600, 900)])
def test_a_picture_has_the_size_that_is_asked_for(tmp_path, size):
    """Widths of lines are in proportion, and the plate keeps its shape."""
    (path,) = contours.draw_contours(WITH_WALL, fields()[:1], tmp_path, size=size)
    picture = np.rint(imread(path)[..., :3] * 255).astype(np.uint8)
    assert picture.shape == (size[1], size[0], 3)
    dot = min(size[0] / 1600, size[1] / 700)
    view = contours.view_of_plate(POINTS, size, dot)
    (x_min, bottom), (x_max, top) = view.pixel([POINTS.min(axis=0), POINTS.max(axis=0)])
    assert (top - bottom) / (x_max - x_min) == pytest.approx(WIDTH / LENGTH)
    assert x_min >= contours.SIDE * dot - 1e-9
    column, row = np.floor(view.pixel(CENTROID)).astype(int)
    white = (picture[size[1] - 1 - row, column - round(20 * dot) : column] == 255).all(axis=1)
    assert white.sum() == pytest.approx(5.0 * dot, abs=1.5)


@pytest.mark.parametrize("text", ["1600", "1600x", "1600x70", "90000x700", "axb", "1600x700x3", ""])
def test_another_size_is_wrong_input(text, tmp_path, capsys):
    """Command and Python have one message with the allowed values."""
    place = tmp_path / "result"
    assert _status(["run", "paper-table-3", "--picture-size", text, "--out", str(place)]) == 2
    message = capsys.readouterr().err
    assert message.startswith("tailslap: --picture-size: given")
    assert "like 1600x700, each 300 to 8000" in message
    assert not place.exists()
    with pytest.raises(InputError, match="allowed is WIDTHxHEIGHT"):
        tailslap.run("paper-table-3", picture_size=text)


def test_sizes_are_texts_or_pairs():
    sizes = [picture_pixels(size) for size in ("1600x700", " 300 X 8000", (640, 480), None)]
    assert sizes == [(1600, 700), (300, 8000), (640, 480), None]


def test_stresses_have_the_unit_that_suits_them(tmp_path, words):
    """81 kPa at most, with the mean of four elements about G."""
    x = POINTS[QUADS].mean(axis=1)[:, 0]
    stress = contours.ContourField(
        "von_mises", "Von Mises stress", "Pa", 8.1e4 * (x - x.min()) / np.ptp(x), "element"
    )
    contours.draw_contours(PLATE, [stress], tmp_path, size=SMALL)
    assert {"Von Mises stress [kPa]", "element values from 0 to 81 kPa", "G: 40.500 kPa"} <= words[0]


def numbers(texts):
    return [float(text) for text in texts if re.fullmatch(r"[\d.]+", text)]


def test_contours_have_rulers_title_and_values_in_feet(tmp_path, words):
    square = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]])
    field = contours.ContourField("v", "Velocity", "m/s", square[:, 0])
    situation = contours.Situation((square, np.array([[0, 1, 2, 3]])), corner=(0.0, 0.0), centroid=(1.5, 0.5))
    for units in (SI, US):
        contours.draw_contours(situation, [field], tmp_path, units, SMALL)
    metres, feet = words[0], words[2]
    assert {"X [m], driving direction →", "Y [m]", "Velocity [m/s]", "G: 1.5000 m/s"} <= metres
    assert {"X [ft], driving direction →", "Y [ft]", "Velocity [ft/s]", "G: 4.9213 ft/s"} <= feet
    assert max(numbers(metres)) == 3.0
    assert 3.0 / FOOT - 1.0 <= max(numbers(feet)) <= 3.0 / FOOT + 1.0
    assert f"nodal values from 0 to {3.0 / FOOT:.4g} ft/s" in feet


def test_drawn_fields_are_in_feet_and_ksi(tmp_path, words):
    """Title, range and rulers differ, the picture does not."""
    series = tailslap.run("paper-table-3", {"output.fields": 3, "plate.elements": [8, 2]}).fields
    for units in (SI, US):
        contours.draw_instants(tmp_path, series, "stress_von_mises", instants=[1], units=units)
    stress = series.elemental["stress_von_mises"][1]
    metres, feet = words
    assert {"Von Mises stress [ksi]", "Y [ft]", "X [ft], driving direction →"} <= feet
    assert {"Von Mises stress [kPa]", "Y [m]", f"t = {series.t[1]:.4f} s"} <= metres
    for said, unit, size in ((metres, "kPa", 1e3), (feet, "ksi", KSI)):
        assert f"element values from {stress.min() / size:.4g} to {stress.max() / size:.4g} {unit}" in said


@pytest.mark.parametrize("form", ["", "-dark"])
def test_a_mode_has_the_colours_of_its_displacements_where_they_are(tmp_path, form, words):
    """The shape grows from 0 to 1 along the plate."""
    share = (POINTS[:, 0] - POINTS[:, 0].min()) / LENGTH
    shape = np.column_stack([0.0 * share, share])
    (path,) = contours.draw_modes(tmp_path, (POINTS, QUADS), {"mode-1": ("1: bending 1, 107.9 Hz", shape)})
    assert {"1: bending 1, 107.9 Hz", "displacement over its largest", "0.2", "1.0"} <= words[0] == words[1]
    picture = np.rint(imread(path.with_stem(f"mode-1{form}"))[..., :3] * 255).astype(np.uint8)
    (wide, high), dot, reach = contours.MODE_SIZE, contours.MODE_DOT, 0.3 * WIDTH
    rest = POINTS - POINTS.min(axis=0) + 1.1 * reach
    view = contours.view_of_plate(np.array([(0.0, 0.0), rest.max(axis=0) + 1.1 * reach]), (wide, high), dot)
    middles = (rest + reach * shape)[QUADS].mean(axis=1) + np.array([0.05, 0.1])
    column, row = np.floor(view.pixel(middles)).astype(int).T
    part = share[QUADS].mean(axis=1) + 0.05 / LENGTH
    expected = mpl.colormaps["viridis"].resampled(10)(part)[:, :3] * 255
    np.testing.assert_allclose(picture[high - 1 - row, column], expected, atol=2)
    below = np.floor(view.pixel((rest[COLUMNS][0] - 0.2, rest[COLUMNS][1] + 0.15))).astype(int)
    ground = canvas.DARK["paper"] if form else "#ffffff"
    assert "#" + bytes(picture[high - 1 - below[1], below[0]].tolist()).hex() == ground, (
        "the mode has left it"
    )


DRAW = """
import os, sys
from pathlib import Path
import numpy as np
from postprocess.fields import contours
points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
plate = contours.Situation((points, np.array([[0, 1, 2, 3]])))
field = contours.ContourField('v', 'v_X', 'm/s', points[:, 0])
for display in (None, ':4711'):
    if display:
        os.environ['DISPLAY'] = display
    (path,) = contours.draw_contours(plate, [field], Path(sys.argv[1]), size=(300, 300))
    assert path.exists()
    path.unlink()
from vtkmodules.vtkCommonCore import vtkLogger
vtkLogger.Log(vtkLogger.VERBOSITY_WARNING, '', 0, 'a warning of its own')
"""


def test_a_missing_display_is_not_mentioned(tmp_path):
    """No display, and one that is not there.

    Standard error has VTK's later warnings alone.
    """
    variables = {name: text for name, text in os.environ.items() if name not in ("DISPLAY", "ALLOW_PLOTTING")}
    process = subprocess.run(
        [sys.executable, "-c", DRAW, str(tmp_path)], capture_output=True, text=True, cwd=ROOT, env=variables
    )
    assert process.returncode == 0, process.stderr
    (line,) = process.stderr.splitlines()
    assert "a warning of its own" in line


@pytest.fixture
def blind(monkeypatch):
    """A machine without a library of OpenGL."""
    if find_library("OSMesa"):
        pytest.skip("OSMesa is installed")
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")


def test_a_machine_that_cannot_draw_says_so_and_the_run_goes_on(blind, tmp_path, capsys):
    place = tmp_path / "result"
    assert _status(["run", "paper-table-3", "--set", "output.fields=2", "--quiet", "--out", str(place)]) == 0
    remark = "tailslap: remark: no pictures are drawn: VTK finds neither libEGL.so.1 nor libOSMesa.so nor a display\n"
    assert capsys.readouterr().err == remark
    assert not list(place.glob("*.png"))
    omitted = json.loads((place / "summary.json").read_text())["left_out"]
    assert "pictures" in [entry["part"] for entry in omitted]
    assert _status(["export", str(place), "--to", "png", "--out", str(tmp_path / "png")]) == 3
    assert "libEGL.so.1" in capsys.readouterr().err
    assert not (tmp_path / "png").exists()


@pytest.mark.parametrize(("where", "count"), [("nodal", 147), ("element", 120)])
def test_another_number_of_values_is_refused(tmp_path, where, count):
    field = contours.ContourField("bad", "too few", "m", np.zeros(3), where)
    with pytest.raises(ValueError, match=f"3 values for {count} "):
        contours.draw_contours(contours.Situation((POINTS, QUADS)), [field], tmp_path)
    assert not (tmp_path / "contour_bad.png").exists()


def test_settings_of_the_user_change_no_picture(tmp_path, pictures, monkeypatch):
    """Colours and letters are those of the program."""
    import pyvista

    monkeypatch.setattr(pyvista.global_theme, "background", pyvista.Color("red"))
    monkeypatch.setattr(pyvista.global_theme, "cmap", "gray")
    with mpl.rc_context({"image.cmap": "gray", "font.size": 30}):
        (path,) = contours.draw_contours(WITH_WALL, fields()[:1], tmp_path)
    alone = np.rint(imread(path)[..., :3] * 255).astype(np.uint8)
    np.testing.assert_array_equal(alone, pictures[path.stem])


@pytest.mark.parametrize("count", [2, 12, 13, 64])
def test_own_colour_map_is_viridis(count):
    expected = mpl.colormaps["viridis"].resampled(count)(np.linspace(0.0, 1.0, count))[:, :3]
    np.testing.assert_allclose(viridis(count), expected, atol=1.0 / 255.0)


@pytest.mark.parametrize(("low", "high"), [
    (22.4747, 24.0719), (0.65507, 0.65613), (-6.551, 0.0), (0.6551053, 0.6553), (1e7, 1.1e7), (1e7, 1.002e7),
    (-3e-9, 2e-9), (0.0, 7.0),
])  # fmt: skip
def test_labels_differ_and_are_round(low, high):
    """Labels are multiples of 1, 2 or 5 powers of ten."""
    scale = contours.colour_scale(np.array([low, high]))
    assert not scale.uniform
    assert len(set(scale.labels)) == len(scale.labels)
    assert 4 <= len(scale.labels) <= 9
    printed = np.array([float(tick.replace("−", "-")) for tick in scale.labels])
    steps = np.diff(printed)
    size = float(f"{steps[0]:.0e}")
    assert f"{size:e}"[0] in "125"
    np.testing.assert_allclose(steps, size, rtol=1e-6)
    np.testing.assert_allclose(printed / size, np.rint(printed / size), atol=1e-6)
    assert low - size < scale.low <= low + 1e-9 * size
    assert high - 1e-9 * size <= scale.high < high + size
    assert scale.bands == 2 * (len(scale.labels) - 1)


def test_next_to_nothing_is_uniform_not_a_drama():
    """Rounding and 4e-6 have one colour in a range of 1 %."""
    for spread in (1e-13, 4e-6):
        scale = contours.colour_scale(0.655 * (1.0 + spread * np.linspace(-1, 1, 9)))
        assert scale.uniform
        assert scale.high - scale.low == pytest.approx(0.655e-2, rel=1e-4)
        assert (0.5 * (scale.high + scale.low), scale.bands % 2) == (pytest.approx(0.655, rel=1e-6), 1)
        assert scale.labels == ["0.652", "0.655", "0.658"]


def test_uniform_threshold_is_1e_4():
    assert contours.colour_scale(np.array([1.0, 1.0 + 0.9e-4])).uniform
    assert not contours.colour_scale(np.array([1.0, 1.0 + 1.1e-4])).uniform


def test_zero_everywhere():
    scale = contours.colour_scale(np.zeros(4))
    assert (scale.low, scale.high, scale.uniform) == (-5e-3, 5e-3, True)


def test_a_zero_has_no_sign_and_others_a_true_minus():
    scale = contours.colour_scale(np.array([-6.5, -1e-12]))
    assert (scale.high, scale.labels[-1]) == (0.0, "0.0")
    assert scale.labels[0] == "−7.0"


def test_values_that_are_not_finite_are_refused():
    with pytest.raises(ValueError, match="not finite"):
        contours.colour_scale(np.array([1.0, np.nan]))


def test_the_view_reaches_down_to_the_wall_from_a_plate_above_it():
    view = contours.view_of_plate(np.array([[0.0, 3.0], [2.0, 5.0]]))
    assert view.pixel([0.0, 0.0])[1] >= 120.0 - 1e-9
    assert view.pixel([0.0, 5.0])[1] <= 510.0 + 1e-9


def test_round_positions():
    assert contours.round_between(-0.9, 3.2, 12) == pytest.approx([-0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0])
    assert contours.round_between(0.0, 100.0, 12) == pytest.approx(np.arange(0.0, 101.0, 10.0))
    assert contours.round_between(3.0, 3.0, 12) == contours.round_between(3.0, 2.0, 12) == []
