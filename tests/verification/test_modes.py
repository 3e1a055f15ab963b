"""Verification: modes of the free plate against beam theory, an exact lattice and LAPACK; order in the mesh; page."""

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from fem.modal.mode_kinds import (
    Beam,
    euler_bernoulli_frequencies,
    longitudinal_frequencies,
    mode_kinds,
    timoshenko_frequencies,
)
from fem.plate.elastic import FreeModes, free_modes, most_modes
from meshes import plate_mesh
from postprocess.figures.plates import draw_mode, mesh_edges
from tailslap.cli import DONE, WRONG_INPUT, _status
from tailslap.files.manifest import NAME as MANIFEST

STEEL = {"youngs_modulus": 200e9, "poissons_ratio": 0.3, "density": 7800.0}
THICKNESS = 0.053


def hertz(modes: FreeModes) -> np.ndarray:
    return modes.frequencies / (2.0 * math.pi)


def strip(plate_model: Callable[..., Any], depth: float, elements: tuple[int, int], **plate: Any) -> Any:
    return plate_model(mesh=plate_mesh(10.0, depth, elements), plate=plate)


def of_kind(model: Any, modes: FreeModes, kind: str) -> np.ndarray:
    names = mode_kinds(model, modes, THICKNESS).names
    return hertz(modes)[[name == kind for name in names]]


def test_a_slender_plate_bends_as_a_beam(plate_model):
    """Depth a fiftieth of the length: 1.4e-3 below Euler and Bernoulli, which leaves Timoshenko 2e-5."""
    model = strip(plate_model, 0.2, (100, 2), element="quad9")
    found = hertz(free_modes(model, 3))
    beam = Beam(10.0, 0.2, **STEEL)
    off = found / euler_bernoulli_frequencies(beam, 3) - 1.0
    assert -1.5e-3 < off[0] < -1.3e-3
    assert np.abs(found / timoshenko_frequencies(beam, 3) - 1.0).max() < 6e-5


@pytest.mark.parametrize(("depth", "limit"), [(0.2, 1e-4), (0.5, 2e-4), (1.0, 6e-4), (2.438, 1.5e-3)])
def test_bending_with_timoshenkos_correction(plate_model, depth, limit):
    """First three bending modes; without the correction the third is off by up to 43 %."""
    model = strip(plate_model, depth, (60, 4), element="quad9")
    bending = of_kind(model, free_modes(model, 5), "bending")[:3]
    beam = Beam(10.0, depth, **STEEL)
    assert np.abs(bending / timoshenko_frequencies(beam, 3) - 1.0).max() < limit
    assert np.all(bending < euler_bernoulli_frequencies(beam, 3))


def test_longitudinal_modes_of_a_thin_strip(plate_model):
    """n c / (2 L); the sides draw in, which slows them by nu^2 B^2 (n pi / L)^2 / 24 (Rayleigh, Love)."""
    model = strip(plate_model, 0.2, (100, 1), element="quad9")
    found = of_kind(model, free_modes(model, 12), "longitudinal")
    beam = Beam(10.0, 0.2, **STEEL)
    theory = longitudinal_frequencies(beam, found.size)
    assert found.size == 2
    assert np.abs(found / theory - 1.0).max() < 1e-4
    waves = np.arange(1, 3) * math.pi / 10.0
    slowed = theory / np.sqrt(1.0 + 0.3**2 * 0.2**2 / 12.0 * waves**2)
    assert np.abs(found / slowed - 1.0).max() < 2e-7


@pytest.mark.parametrize("elements", [10, 20, 40])
def test_exact_frequencies_of_a_lattice(plate_model, elements):
    """Without Poisson's effect and with row-sum masses a row of quads is a chain: 2 c/h sin(n pi h / 2 L)."""
    model = strip(plate_model, 1.0, (elements, 2), poissons_ratio=0.0, lumping="row-sum")
    found = of_kind(model, free_modes(model, 16), "longitudinal")[:2]
    size, speed = 10.0 / elements, math.sqrt(200e9 / 7800.0)
    exact = 2.0 * speed / size * np.sin(np.array([1, 2]) * math.pi * size / 20.0) / (2.0 * math.pi)
    assert found == pytest.approx(exact, rel=1e-11)


def test_order_in_the_mesh(plate_model):
    """Without Poisson's effect n c / (2 L) is exact for the plate; and bending against elements of second order."""
    exact = math.sqrt(200e9 / 7800.0) / 20.0
    fine = plate_model(elements=(80, 24), plate={"element": "quad9"})
    bending = hertz(free_modes(fine, 1))[0]
    errors = []
    for n in (2, 4, 8):
        model = plate_model(elements=(10 * n, 3 * n), plate={"poissons_ratio": 0.0})
        along = of_kind(model, free_modes(model, 4), "longitudinal")[0]
        bent = hertz(free_modes(plate_model(elements=(10 * n, 3 * n)), 1))[0]
        errors.append((abs(along / exact - 1.0), abs(bent / bending - 1.0)))
    slopes = np.diff(np.log2(errors), axis=0)
    assert np.abs(slopes + 2.0).max() < 0.1, slopes
    assert np.array(errors)[-1].max() < 4e-4


@pytest.mark.parametrize("element", ["quad4", "quad4-reduced", "quad9", "tri3", "tri6"])
def test_all_modes_against_lapack(plate_model, element):
    model = plate_model(elements=(6, 2), plate={"element": element})
    count = most_modes(model.loop.mass.size)
    modes = free_modes(model, count)
    masses = np.tile(model.loop.mass, 2)
    squares = scipy.linalg.eigvalsh(model.stiffness.toarray() / np.sqrt(np.outer(masses, masses)))
    assert modes.frequencies**2 == pytest.approx(squares[3 : 3 + count], rel=1e-9)
    shapes = np.concatenate([modes.rigid, modes.shapes]).reshape(3 + count, -1)
    assert np.abs((shapes * masses) @ shapes.T - np.eye(3 + count)).max() < 1e-9
    stiff = shapes @ (model.stiffness @ shapes.T) / modes.frequencies[-1] ** 2
    assert (
        np.abs(stiff - np.diag([0.0] * 3 + list(modes.frequencies**2 / modes.frequencies[-1] ** 2))).max()
        < 1e-9
    )


def test_three_modes_of_no_frequency(plate_model):
    modes = free_modes(plate_model(), 4)
    assert modes.rigid_frequencies.shape == (3,)
    assert modes.rigid_frequencies.max() < 1e-6 * modes.frequencies[0]
    for motion in modes.rigid:  # the distances of nodes do not change to first order: no strain
        assert np.ptp(motion, axis=1).min() < 1.0


def test_frequencies_go_with_the_root_of_the_modulus(plate_model):
    one, four = (free_modes(plate_model(plate={"youngs_modulus": e}), 5).frequencies for e in (1e9, 4e9))
    assert four == pytest.approx(2.0 * one, rel=1e-12)


def test_kinds_add_up(plate_model):
    """Each mode of the rectangle is symmetric or antisymmetric to rounding, also those of a distorted mesh nearly."""
    model = plate_model()
    kinds = mode_kinds(model, free_modes(model, 10), THICKNESS)
    assert np.minimum(kinds.symmetric, 1.0 - kinds.symmetric) == pytest.approx(0.0, abs=1e-9)
    assert kinds.names[:5] == ("bending", "bending", "longitudinal", "bending", "longitudinal")
    wide = plate_model(mesh=plate_mesh(4.0, 3.0, (8, 6)))
    assert "transverse" in mode_kinds(wide, free_modes(wide, 8), THICKNESS).names


@pytest.mark.parametrize("count", [-1, 291])
def test_too_many(plate_model, count):
    with pytest.raises(ValueError, match="0 to 290"):
        free_modes(plate_model(), count)


def test_beam_theory():
    """Known roots of cosh x cos x = 1; Timoshenko's correction falls with the square of the depth, and converges."""
    known = np.array([4.7300407448627, 7.8532046240958, 10.9956078380017])
    thin, thinner, stubby = (Beam(10.0, depth, **STEEL) for depth in (0.2, 0.1, 5.0))
    roots = euler_bernoulli_frequencies(thin, 3) * 2.0 * math.pi * 10.0**2 * math.sqrt(12.0)
    assert roots / (thin.wave_speed * thin.depth) == pytest.approx(known**2, rel=1e-12)
    shares = [1.0 - timoshenko_frequencies(b, 3) / euler_bernoulli_frequencies(b, 3) for b in (thin, thinner)]
    assert shares[0] / shares[1] == pytest.approx(4.0, rel=0.015)
    assert timoshenko_frequencies(stubby, 5) == pytest.approx(
        timoshenko_frequencies(stubby, 12)[:5], rel=1e-10
    )


def test_edges_of_a_mesh():
    edges, outline = mesh_edges(np.array([[0, 1, 4, 3], [1, 2, 5, 4]]))
    assert edges.tolist() == [[1, 4]]
    assert len(outline) == 6


def test_picture_is_svg_with_its_caption():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    picture = draw_mode("one", "first mode", square, np.array([[0, 1, 2, 3]]), 0.0 * square)
    assert picture.svg.startswith("<svg")
    assert 'aria-label="first mode"' in picture.svg


def test_command(tmp_path, capsys):
    out = tmp_path / "result"
    assert _status(["modes", "paper-table-3", "--count", "6", "--out", str(out)]) == DONE
    assert "bending 1" in capsys.readouterr().out
    assert {path.name for path in out.iterdir()} == {
        *("report.html", "summary.json", MANIFEST),
        *(f"mode-{number}.svg" for number in range(1, 7)),
    }
    summary = json.loads((out / "summary.json").read_text())
    assert [mode["kind"] for mode in summary["modes"]][:3] == ["bending", "bending", "longitudinal"]
    assert abs(summary["modes"][0]["difference"]) < 6e-3
    page = (out / "report.html").read_text()
    assert page.count("<svg") == 6
    assert "http" not in page.replace("http://www.w3.org", "").replace("http-equiv", "")


@pytest.mark.parametrize("count", ["0", "-3", "291"])
def test_wrong_count_writes_nothing(tmp_path, count):
    out = tmp_path / "result"
    assert _status(["modes", "paper-table-3", "--count", count, "--out", str(out)]) == WRONG_INPUT
    assert not out.exists()
