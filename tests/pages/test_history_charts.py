"""Verify charts of histories beside the rigid motion."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from browser.charts import points_of
from chart_samples import columns, path_of, texts

from postprocess.figures import studies
from postprocess.figures.histories import Curve, draw_histories, draw_overlay, thinned
from postprocess.figures.impact import LINES, Forces, draw_forces
from postprocess.svg.marks import Line

MOTION = ("v_gy", "v_gx", "theta", "omega", "slide")


def histories(n=2000):
    """A plate that rotates evenly, and the same with a ripple."""
    t = np.linspace(0.0, 0.38, n)
    theta = 0.26 - 0.684 * t
    phase = theta + 0.239
    columns = {"t": t, "theta": theta, "omega": np.full(n, 0.684), "slide": 25.0 * t}
    columns |= {"v_gx": 25.0 - 3.4 * np.sin(phase), "v_gy": -3.5 * np.cos(phase)}
    columns |= {"reaction_normal": -3000.0 + 4000.0 * t, "reaction_tangential": -1400.0 + 1900.0 * t}
    columns["kinetic_energy"] = 2.8e6 - 2.4e4 * t
    ripple = 1e-6 * np.sin(900.0 * t)
    fe = {name: values + ripple * (name != "t") for name, values in columns.items()}
    energies = {"strain_energy": 0.02 + 0 * t, "contact_energy": 0.05 - 0.1 * t}
    energies["vibration_energy"] = 1e-3 + 0 * t
    works = {"friction_work": -2.4e4 * t, "damping_work": -0.01 * t, "energy_error": 1e-5 * np.cos(50 * t)}
    return {**fe, **energies, **works}, columns


@pytest.fixture(scope="module")
def curves():
    return {curve.name: curve for curve in draw_histories(*histories())}


def test_all_plots_are_there_in_order(curves):
    reaction = ("reaction_normal", "reaction_tangential")
    assert tuple(curves) == (*MOTION, *reaction, "energy_exchanged", "energy_stored", "energy_error")
    assert [curve.group for curve in curves.values()] == ["Motion"] * 5 + ["Reaction"] * 2 + ["Energy"] * 3


LABELS = [
    *(("theta", "θ [deg]"), ("omega", "ω [rad/s]"), ("v_gx", "vGX [m/s]"), ("v_gy", "vGY [m/s]")),
    *(("slide", "s [m]"), ("reaction_normal", "N [kN]"), ("reaction_tangential", "R [kN]")),
]


@pytest.mark.parametrize(("name", "label"), LABELS)
def test_plots_over_rigid_are_labelled(curves, name, label):
    """The power of ten of an angle is that of its degrees."""
    labels = texts(curves[name].svg)
    for words in (label, "t [s]", "FE", "rigid, exact"):
        assert labels.count(words) == 1
    unit = label.split("[")[1].replace("kN", "N")
    power = "10⁻⁶" if name == "theta" else "10⁻⁹"
    assert f"FE − rigid [{power} {unit}" in labels


def test_energy_plots_are_labelled(curves):
    assert {"kinetic, change", "work of friction", "energy [kJ]"} <= {*texts(curves["energy_exchanged"].svg)}
    stored = {*texts(curves["energy_stored"].svg)}
    assert {"strain", "spring", "vibration", "damping", "energy [10⁻³ J]"} <= stored
    assert {"error", "energy [10⁻⁶ J]"} <= {*texts(curves["energy_error"].svg)}


def test_kinetic_energy_is_shown_as_a_change(curves):
    numbers = [float(w.replace("−", "-")) for w in texts(curves["energy_exchanged"].svg) if w[-1].isdigit()]
    assert min(numbers) >= -10.0, "9.12 kJ are lost, of 2.8 MJ"
    assert max(numbers) <= 1.0


def test_the_ripple_is_drawn_at_its_size(curves):
    """The height of the difference is that of its scale."""
    assert {"−1000", "0", "1000"} <= {*texts(curves["slide"].svg)}


def test_a_chart_has_no_ids_and_needs_nothing_beside_it(curves):
    """Charts on one page do not conflict, and each is a file."""
    for curve in curves.values():
        assert not re.search(r"\b(id|href)=|url\(", curve.svg)
        root = ElementTree.fromstring(curve.svg)
        assert root.get("aria-label") == curve.caption
        assert (float(root.get("width", "nan")), root.get("role")) == (curve.width, "img")


def test_values_are_those_of_the_history(curves):
    """Values at the pointer have five digits at all points."""
    fe, _ = histories()
    where, at, values = columns(curves["slide"])["FE"]
    assert len(values) == len(points_of(path_of(curves["slide"].svg, "FE")))
    assert where == "t [s]"
    rows = np.abs(fe["t"] - np.array(at, float)[:, None]).argmin(axis=1)
    np.testing.assert_allclose(np.array(at, float), fe["t"][rows], rtol=1e-5)
    np.testing.assert_allclose(np.array(values, float), fe["slide"][rows], rtol=1e-5, atol=1e-12)


def test_only_what_the_histories_have_is_drawn():
    fe, rigid = histories(50)
    history = {k: fe[k] for k in ("t", "omega", "slide", "strain_energy")}
    few = draw_histories(history, {"t": rigid["t"], "omega": rigid["omega"]})
    assert [curve.name for curve in few] == ["omega", "energy_stored"]
    assert "spring" not in texts(few[1].svg)


def test_rigid_history_at_other_instants():
    """Straight lines interpolate exactly, except rounding."""
    t, t_rigid = np.linspace(0.0, 1.0, 77), np.linspace(0.0, 1.0, 11)
    (curve,) = draw_histories({"t": t, "slide": 3.1 * t}, {"t": t_rigid, "slide": 3.1 * t_rigid})
    assert any("[10⁻¹⁵" in words or "[10⁻¹⁸" in words for words in texts(curve.svg))


def test_a_run_that_went_wrong_is_still_drawn():
    """Other plots are unchanged, and the finite part is drawn."""
    fe, rigid = histories(900)
    good = {curve.name: curve for curve in draw_histories(fe, rigid)}
    for bad, points, label in ((np.nan, 100, ""), (np.inf, 100, ""), (1e300, 2, "10³⁰⁰")):
        broken = fe | {"omega": np.where(fe["t"] > 0.2, bad, fe["omega"])}
        curves = {curve.name: curve for curve in draw_histories(broken, rigid)}
        omega = curves["omega"]
        assert curves | {"omega": good["omega"]} == good
        assert points <= vertices(omega) <= vertices(good["omega"])
        for word in ("nan", "inf"):
            assert word not in omega.svg
        assert any(label in words for words in texts(omega.svg))


def vertices(curve):
    """Of the line of the FE history."""
    return len(points_of(path_of(curve.svg, "FE")))


def many_lines():
    """Charts of four and more lines in one place."""
    t = np.linspace(0.0, 0.4, 9)
    fe, rigid = histories(50)
    curves = [Curve(f"result {k}", t, t) for k in range(7)]
    axis = studies.SweepAxis([100.0, 10.0, 1.0], [True] * 3, 30.0)
    lines = [studies.SweepLine(n, [1e-3] * 3) for n in "abcde"]
    return {
        "forces": draw_forces("", [Forces("f", t, dict.fromkeys(LINES, 1e3 * t))]),
        "results": draw_overlay("o", "F [kN]", curves, "", 340.0),
        "energies": next(c for c in draw_histories(fe, rigid) if c.name == "energy_stored"),
        "sweep": studies.draw_sweep("s", axis, lines, "size", "", ()),
    }


@pytest.mark.parametrize("name", many_lines())
def test_lines_differ_in_shape_and_hide_none_before(name):
    """Each line has dashes, or is narrower than those below it."""
    lines = [mark for mark in many_lines()[name].plots[0].marks if isinstance(mark, Line)]
    assert len(lines) > 3
    assert len({line.dashes for line in lines}) == len(lines)
    for number, line in enumerate(lines):
        assert line.dashes or all(line.width < earlier.width for earlier in lines[:number])


@pytest.mark.parametrize("name", many_lines())
def test_letters_are_nine_pixels_at_least(name):
    sizes = map(float, re.findall(r'font-size="([\d.]+)"', many_lines()[name].svg))
    assert min(sizes) >= 9.0


def test_thinning_keeps_ends_and_peaks():
    t = np.linspace(0.0, 1.0, 20_000)
    values = np.sin(5000.0 * t + 0.3)
    values[[7_001, 12_345]] = 9.0, -7.0
    kept_t, thin_values = thinned(t, values)
    assert len(thin_values) <= 322
    assert (thin_values.max(), thin_values.min()) == (9.0, -7.0)
    assert (kept_t[0], kept_t[-1], thin_values[0], thin_values[-1]) == (0.0, 1.0, values[0], values[-1])
    assert np.all(np.diff(kept_t) > 0)
    np.testing.assert_array_equal(thin_values, values[np.searchsorted(t, kept_t)])
