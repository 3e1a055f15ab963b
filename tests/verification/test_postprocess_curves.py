"""Verification: the plots are XML, say what they show, and keep the peaks of the histories they thin."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from postprocess.figures.histories import draw_histories, power_of_ten, thinned
from postprocess.svg.chart import Chart

MOTION = ("theta", "omega", "v_gx", "v_gy", "slide")
SVG = "{http://www.w3.org/2000/svg}"


def histories(n: int = 2000) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """A plate that turns evenly while its centre slides, and the same with a ripple."""
    t = np.linspace(0.0, 0.38, n)
    theta = 0.26 - 0.684 * t
    columns = {
        "t": t,
        "theta": theta,
        "omega": np.full(n, 0.684),
        "v_gx": 25.0 - 3.4 * np.sin(theta + 0.239),
        "v_gy": -3.5 * np.cos(theta + 0.239),
        "slide": 25.0 * t,
        "reaction_normal": -3000.0 + 4000.0 * t,
        "reaction_tangential": -1400.0 + 1900.0 * t,
        "kinetic_energy": 2.8e6 - 2.4e4 * t,
    }
    ripple = 1e-6 * np.sin(900.0 * t)
    fe = {name: values + ripple * (name != "t") for name, values in columns.items()}
    energies = {
        "strain_energy": 0.02 + 0 * t,
        "contact_energy": 0.05 - 0.1 * t,
        "vibration_energy": 1e-3 + 0 * t,
    }
    works = {"friction_work": -2.4e4 * t, "damping_work": -0.01 * t, "energy_error": 1e-5 * np.cos(50 * t)}
    return {**fe, **energies, **works}, columns


def texts(curve: Chart) -> list[str]:
    root = ElementTree.fromstring(curve.svg)
    assert root.tag == SVG + "svg"
    return [
        "".join(element.itertext()).replace("\u200b", "").strip()
        for element in root.iter()
        if element.tag == SVG + "text"
    ]


@pytest.fixture(scope="module")
def curves():
    return {curve.name: curve for curve in draw_histories(*histories())}


def test_all_plots_are_there_in_order(curves):
    reaction = ("reaction_normal", "reaction_tangential")
    assert tuple(curves) == (*MOTION, *reaction, "energy_exchanged", "energy_stored", "energy_error")
    assert [curve.group for curve in curves.values()] == ["Motion"] * 5 + ["Reaction"] * 2 + ["Energy"] * 3


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("theta", "θ [rad]"),
        ("omega", "ω [rad/s]"),
        ("v_gx", "vGX [m/s]"),
        ("v_gy", "vGY [m/s]"),
        ("slide", "s [m]"),
        ("reaction_normal", "N [kN]"),
        ("reaction_tangential", "R [kN]"),
    ],
)
def test_plots_over_rigid_are_labelled(curves, name, label):
    shown = texts(curves[name])
    for words in (label, "t [s]", "FE", "rigid, exact"):
        assert shown.count(words) == 1
    unit = label.split("[")[1].replace("kN", "N")
    assert f"FE − rigid [10⁻⁹ {unit}" in shown


def test_energy_plots_are_labelled(curves):
    assert {"kinetic, change", "work of friction", "energy [kJ]"} <= {*texts(curves["energy_exchanged"])}
    stored = {*texts(curves["energy_stored"])}
    assert {"strain", "spring", "vibration", "damping", "energy [10⁻³ J]"} <= stored
    assert {"error", "energy [10⁻⁶ J]"} <= {*texts(curves["energy_error"])}


def test_kinetic_energy_is_shown_as_a_change(curves):
    numbers = [float(w.replace("−", "-")) for w in texts(curves["energy_exchanged"]) if w[-1].isdigit()]
    assert min(numbers) >= -10.0, "9.12 kJ are lost, of 2.8 MJ"
    assert max(numbers) <= 1.0


def test_the_ripple_is_drawn_at_its_size(curves):
    """Height of the difference line in the panel of 10^-9, whose ticks tell its scale."""
    assert {"−1000", "0", "1000"} <= {*texts(curves["slide"])}


def test_a_chart_has_no_ids_and_needs_nothing_beside_it(curves):
    """Several fit on a page, and each is a file: its name spaces are declared, it has a paper and a size."""
    for curve in curves.values():
        assert not re.search(r"\b(id|href)=|url\(", curve.svg)
        root = ElementTree.fromstring(curve.svg)
        assert root.get("aria-label") == curve.caption
        assert (float(root.get("width", "nan")), root.get("role")) == (curve.width, "img")


def test_values_are_those_of_the_history(curves):
    """What a page shows at the pointer, to five digits, at as many points as the path has."""
    fe, _ = histories()
    (path,) = [e for e in ElementTree.fromstring(curves["slide"].svg).iter() if e.get("data-label") == "FE"]
    values = np.array(path.get("data-values", "").split(), float)
    assert len(values) == len(re.findall(r"[ML]", path.get("d", "")))
    np.testing.assert_allclose(values, thinned(fe["t"], fe["slide"])[1], rtol=1e-4, atol=1e-12)


def test_only_what_the_histories_have_is_drawn():
    fe, rigid = histories(50)
    few = draw_histories(
        {k: fe[k] for k in ("t", "omega", "slide", "strain_energy")},
        {"t": rigid["t"], "omega": rigid["omega"]},
    )
    assert [curve.name for curve in few] == ["omega", "energy_stored"]
    assert "spring" not in texts(few[1])


def test_rigid_history_at_other_instants():
    """Straight lines at other instants interpolate exactly: the difference is rounding, below a billionth."""
    t, other = np.linspace(0.0, 1.0, 77), np.linspace(0.0, 1.0, 11)
    (curve,) = draw_histories({"t": t, "slide": 3.1 * t}, {"t": other, "slide": 3.1 * other})
    assert any("[10⁻¹⁵" in words or "[10⁻¹⁸" in words for words in texts(curve))


def test_a_run_that_went_wrong_is_still_drawn():
    """Its other plots are as they were; of the broken column the part before, and where it goes if that is finite."""
    fe, rigid = histories(900)
    good = {curve.name: curve for curve in draw_histories(fe, rigid)}
    for bad, points, shown in ((np.nan, 150, ""), (np.inf, 150, ""), (1e300, 2, "10³⁰⁰")):
        broken = fe | {"omega": np.where(fe["t"] > 0.2, bad, fe["omega"])}
        found = {curve.name: curve for curve in draw_histories(broken, rigid)}
        omega = found["omega"]
        assert found | {"omega": good["omega"]} == good
        assert points <= vertices(omega) <= vertices(good["omega"])
        assert "nan" not in omega.svg
        assert "inf" not in omega.svg
        assert any(shown in words for words in texts(omega))


def vertices(curve: Chart) -> int:
    """Of the line of the FE history."""
    (line,) = [e for e in ElementTree.fromstring(curve.svg).iter() if e.get("data-label") == "FE"]
    return line.get("d", "").count("L")


def test_equal_input_gives_equal_text():
    assert draw_histories(*histories(50)) == draw_histories(*histories(50))


def test_thinning_keeps_ends_and_peaks():
    t = np.linspace(0.0, 1.0, 20_000)
    values = np.sin(5000.0 * t + 0.3)
    values[[7_001, 12_345]] = 9.0, -7.0
    kept_t, kept = thinned(t, values)
    assert len(kept) <= 402
    assert (kept.max(), kept.min()) == (9.0, -7.0)
    assert (kept_t[0], kept_t[-1], kept[0], kept[-1]) == (0.0, 1.0, values[0], values[-1])
    assert np.all(np.diff(kept_t) > 0)
    np.testing.assert_array_equal(kept, values[np.searchsorted(t, kept_t)])


@pytest.mark.parametrize(
    ("size", "power"),
    [(0.0, 0), (1.0, 0), (999.0, 0), (1000.0, 3), (0.5, -3), (-2e-7, -9), (np.nan, 0), (np.inf, 0)],
)
def test_power_of_ten(size, power):
    assert power_of_ten(np.array([0.0, size])) == power
