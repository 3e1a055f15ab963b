"""Verify free modes of plates by beams, a lattice and LAPACK."""

import json
import math

import numpy as np
import pytest
import scipy.linalg

from fem.modal import beams
from fem.modal.mode_kinds import mode_kinds
from fem.plate.free_modes import free_modes, most_modes
from meshes import plate_mesh
from postprocess.report.provenance import CRATE
from tailslap.cli import DONE, WRONG_INPUT, _status
from tailslap.storage.manifest import NAME as MANIFEST

STEEL = {"youngs_modulus": 200e9, "poissons_ratio": 0.3, "density": 7800.0}


def hertz(modes):
    return modes.frequencies / (2.0 * math.pi)


def strip(plate_model, depth, elements, **plate):
    return plate_model(mesh=plate_mesh(10.0, depth, elements), plate=plate)


def of_kind(model, modes, kind):
    names, _ = mode_kinds(model, modes)
    return hertz(modes)[[name == kind for name in names]]


@pytest.mark.parametrize(("depth", "limit"), [(0.2, 6e-5), (0.5, 2e-4), (1.0, 6e-4), (2.438, 1.5e-3)])
def test_bending_with_timoshenkos_correction(plate_model, depth, limit):
    """Without the correction the third bending mode is off by 43 %."""
    model = strip(plate_model, depth, (60, 4), element="quad9")
    bending = of_kind(model, free_modes(model, 5), "bending")[:3]
    beam = beams.Beam(10.0, depth, **STEEL)
    assert np.abs(bending / beams.timoshenko_frequencies(beam, 3) - 1.0).max() < limit
    assert np.all(bending < beams.euler_bernoulli_frequencies(beam, 3))


def test_longitudinal_modes_of_a_thin_strip(plate_model):
    """n c/(2 L), reduced by the inertia of the lateral contraction.

    Rayleigh and Love: by nu^2 B^2 (n pi/L)^2/24.
    """
    model = strip(plate_model, 0.2, (100, 1), element="quad9")
    frequencies = of_kind(model, free_modes(model, 12), "longitudinal")
    beam = beams.Beam(10.0, 0.2, **STEEL)
    theory = beams.longitudinal_frequencies(beam, frequencies.size)
    assert frequencies.size == 2
    assert np.abs(frequencies / theory - 1.0).max() < 1e-4
    waves = np.arange(1, 3) * math.pi / 10.0
    slowed = theory / np.sqrt(1.0 + 0.3**2 * 0.2**2 / 12.0 * waves**2)
    assert np.abs(frequencies / slowed - 1.0).max() < 2e-7


@pytest.mark.parametrize("elements", [10, 20, 40])
def test_exact_frequencies_of_a_lattice(plate_model, elements):
    """A row of quads is a chain of masses and springs.

    2 c/h sin(n pi h/(2 L)) holds without Poisson's effect, with row-sum masses.
    """
    model = strip(plate_model, 1.0, (elements, 2), poissons_ratio=0.0, lumping="row-sum")
    frequencies = of_kind(model, free_modes(model, 16), "longitudinal")[:2]
    size, speed = 10.0 / elements, math.sqrt(200e9 / 7800.0)
    exact = 2.0 * speed / size * np.sin(np.array([1, 2]) * math.pi * size / 20.0) / (2.0 * math.pi)
    assert frequencies == pytest.approx(exact, rel=1e-11)


def test_order_in_the_mesh(plate_model):
    """Longitudinal and bending frequencies converge with second order."""
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
    count = most_modes(model.parameters.mass.size)
    modes = free_modes(model, count)
    masses = np.tile(model.parameters.mass, 2)
    squares = scipy.linalg.eigvalsh(model.stiffness.toarray() / np.sqrt(np.outer(masses, masses)))
    assert modes.frequencies**2 == pytest.approx(squares[3 : 3 + count], rel=1e-9)
    assert modes.rigid_frequencies.shape == (3,)
    assert modes.rigid_frequencies.max() < 1e-6 * modes.frequencies[0]
    shapes = np.concatenate([modes.rigid, modes.shapes]).reshape(3 + count, -1)
    assert np.abs((shapes * masses) @ shapes.T - np.eye(3 + count)).max() < 1e-9
    stiff = shapes @ (model.stiffness @ shapes.T) / modes.frequencies[-1] ** 2
    squares = [0.0] * 3 + list(modes.frequencies**2 / modes.frequencies[-1] ** 2)
    assert np.abs(stiff - np.diag(squares)).max() < 1e-9


def test_frequencies_go_with_the_root_of_the_modulus(plate_model):
    one, four = (free_modes(plate_model(plate={"youngs_modulus": e}), 5).frequencies for e in (1e9, 4e9))
    assert four == pytest.approx(2.0 * one, rel=1e-12)


def test_kinds_add_up(plate_model):
    """Modes are symmetric or antisymmetric, transverse ones in a wide plate."""
    model = plate_model()
    kinds, fractions = mode_kinds(model, free_modes(model, 10))
    assert np.minimum(fractions["symmetric"], 1.0 - fractions["symmetric"]) == pytest.approx(0.0, abs=1e-9)
    assert kinds[:5] == ("bending", "bending", "longitudinal", "bending", "longitudinal")
    wide = plate_model(mesh=plate_mesh(4.0, 3.0, (8, 6)))
    assert "transverse" in mode_kinds(wide, free_modes(wide, 8))[0]


@pytest.mark.parametrize("count", [-1, 291])
def test_too_many(plate_model, count):
    with pytest.raises(ValueError, match="0 to 290"):
        free_modes(plate_model(), count)


def test_beam_theory():
    """Compare with the roots of cosh x cos x = 1.

    Timoshenko's correction decreases with the square of the depth, and converges.
    """
    root_values = np.array([4.7300407448627, 7.8532046240958, 10.9956078380017])
    thin, thinner, stubby = (beams.Beam(10.0, depth, **STEEL) for depth in (0.2, 0.1, 5.0))
    roots = beams.euler_bernoulli_frequencies(thin, 3) * 2.0 * math.pi * 10.0**2 * math.sqrt(12.0)
    assert roots / (thin.wave_speed * thin.depth) == pytest.approx(root_values**2, rel=1e-12)
    theories = beams.timoshenko_frequencies, beams.euler_bernoulli_frequencies
    pairs = ([theory(beam, 3) for theory in theories] for beam in (thin, thinner))
    shares = [1.0 - corrected / plain for corrected, plain in pairs]
    assert shares[0] / shares[1] == pytest.approx(4.0, rel=0.015)
    more = beams.timoshenko_frequencies(stubby, 12)[:5]
    assert beams.timoshenko_frequencies(stubby, 5) == pytest.approx(more, rel=1e-10)


def test_command(tmp_path, capsys):
    out = tmp_path / "result"
    assert _status(["modes", "paper-table-3", "--count", "4", "--out", str(out)]) == DONE
    assert "bending 1" in capsys.readouterr().out
    pictures = {f"mode-{number}{form}.png" for number in range(1, 5) for form in ("", "-dark")}
    names = {"report.html", "set-up.svg", "summary.json", MANIFEST, CRATE}
    assert {path.name for path in out.iterdir()} == names | pictures
    summary = json.loads((out / "summary.json").read_text())
    assert [mode["kind"] for mode in summary["modes"]][:3] == ["bending", "bending", "longitudinal"]
    assert abs(summary["modes"][0]["difference"]) < 6e-3
    page = (out / "report.html").read_text()
    assert page.count("data:image/webp") == len(pictures)
    assert "4: bending 3, " in page
    assert "http" not in page.replace("http://www.w3.org", "").replace("http-equiv", "")


@pytest.mark.parametrize("count", ["0", "-3", "291"])
def test_wrong_count_writes_nothing(tmp_path, count):
    out = tmp_path / "result"
    assert _status(["modes", "paper-table-3", "--count", count, "--out", str(out)]) == WRONG_INPUT
    assert not out.exists()
