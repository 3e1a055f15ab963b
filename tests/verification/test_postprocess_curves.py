"""Verification: the plots are XML, say what they show, and keep the peaks of the histories they thin."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from postprocess.figures.curves import draw_histories, power_of_ten, thinned
from postprocess.figures.style import FE, Curve

pytestmark = pytest.mark.verification

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


def texts(curve: Curve) -> list[str]:
    root = ElementTree.fromstring(curve.svg)
    assert root.tag == SVG + "svg"
    return [
        (element.text or "").strip()
        for element in root.iter()
        if element.tag in (SVG + "text", SVG + "tspan")
    ]


@pytest.fixture(scope="module")
def curves() -> dict[str, Curve]:
    return {curve.name: curve for curve in draw_histories(*histories())}


def test_all_plots_are_there_in_order(curves: dict[str, Curve]) -> None:
    reaction = ("reaction_normal", "reaction_tangential")
    assert tuple(curves) == (*MOTION, *reaction, "energy_exchanged", "energy_stored", "energy_error")
    assert [curve.group for curve in curves.values()] == ["Motion"] * 5 + ["Reaction"] * 2 + ["Energy"] * 3


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("theta", "θ [rad]"),
        ("omega", "ω [rad/s]"),
        ("v_gx", "v_GX [m/s]"),
        ("v_gy", "v_GY [m/s]"),
        ("slide", "s [m]"),
        ("reaction_normal", "N [N]"),
        ("reaction_tangential", "R [N]"),
    ],
)
def test_plots_over_rigid_are_labelled(curves: dict[str, Curve], name: str, label: str) -> None:
    shown = texts(curves[name])
    for words in (label, "t [s]", "━ FE", "━ rigid, exact", "FE − rigid"):
        assert shown.count(words) == 1
    unit = label.split("[")[1]
    assert any(words.startswith("[10⁻⁹ ") and words.endswith(unit) for words in shown)


def test_energy_plots_are_labelled(curves: dict[str, Curve]) -> None:
    assert {"━ kinetic, change", "━ work of friction", "energy [10³ J]"} <= {
        *texts(curves["energy_exchanged"])
    }
    stored = {*texts(curves["energy_stored"])}
    assert {"━ strain", "━ spring", "━ vibration", "━ damping", "energy [10⁻³ J]"} <= stored
    assert {"━ error", "energy [10⁻⁶ J]"} <= {*texts(curves["energy_error"])}


def test_kinetic_energy_is_shown_as_a_change(curves: dict[str, Curve]) -> None:
    numbers = [float(w.replace("−", "-")) for w in texts(curves["energy_exchanged"]) if w[-1].isdigit()]
    assert min(numbers) >= -10.0, "9.12 kJ are lost, of 2.8 MJ"
    assert max(numbers) <= 1.0


def test_the_ripple_is_drawn_at_its_size(curves: dict[str, Curve]) -> None:
    """Height of the difference line in the panel of 10^-9, whose ticks tell its scale."""
    assert {"−1000", "0", "1000"} <= {*texts(curves["slide"])}


def test_ids_do_not_clash_on_a_page(curves: dict[str, Curve]) -> None:
    ids = [e.get("id") for c in curves.values() for e in ElementTree.fromstring(c.svg).iter() if e.get("id")]
    assert len(ids) == len({*ids})
    for curve in curves.values():
        own = {e.get("id") for e in ElementTree.fromstring(curve.svg).iter()}
        used = {
            part.split(")")[0].split('"')[0]
            for part in curve.svg.replace('href="#', "url(#").split("url(#")[1:]
        }
        assert used <= own


def test_only_what_the_histories_have_is_drawn() -> None:
    fe, rigid = histories(50)
    few = draw_histories(
        {k: fe[k] for k in ("t", "omega", "slide", "strain_energy")},
        {"t": rigid["t"], "omega": rigid["omega"]},
    )
    assert [curve.name for curve in few] == ["omega", "energy_stored"]
    assert "━ spring" not in texts(few[1])


def test_rigid_history_at_other_instants() -> None:
    """Straight lines at other instants interpolate exactly: the difference is rounding, below a billionth."""
    t, other = np.linspace(0.0, 1.0, 77), np.linspace(0.0, 1.0, 11)
    (curve,) = draw_histories({"t": t, "slide": 3.1 * t}, {"t": other, "slide": 3.1 * other})
    assert any(words.startswith(("[10⁻¹⁵", "[10⁻¹⁸")) for words in texts(curve))


@pytest.mark.long
def test_a_run_that_went_wrong_is_still_drawn() -> None:
    """Its other plots are as they were; of the broken column the part before, and where it goes if that is finite."""
    fe, rigid = histories(900)
    good = {curve.name: curve for curve in draw_histories(fe, rigid)}
    for bad, points, shown in ((np.nan, 150, ""), (np.inf, 150, ""), (1e300, 2, "1e300")):
        broken = fe | {"omega": np.where(fe["t"] > 0.2, bad, fe["omega"])}
        found = {curve.name: curve for curve in draw_histories(broken, rigid)}
        omega = found["omega"]
        assert found | {"omega": good["omega"]} == good
        assert points <= vertices(omega) < vertices(good["omega"])
        assert any(shown in words for words in texts(omega))


def vertices(curve: Curve) -> int:
    """Of the line of the FE history."""
    paths = [
        path for path in ElementTree.fromstring(curve.svg).iter(SVG + "path") if FE in path.get("style", "")
    ]
    return sum(path.get("d", "").count("L") for path in paths)


def test_equal_input_gives_equal_text_and_leaves_the_settings_alone() -> None:
    import matplotlib as mpl

    expected = draw_histories(*histories(50))
    with mpl.rc_context({"font.size": 31.0, "axes.grid": False, "svg.hashsalt": "mine"}):
        before = dict(mpl.rcParams)
        assert draw_histories(*histories(50)) == expected
        assert dict(mpl.rcParams) == before


def test_thinning_keeps_ends_and_peaks() -> None:
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
def test_power_of_ten(size: float, power: int) -> None:
    assert power_of_ten(np.array([0.0, size])) == power
