"""Verify the validation by NCHRP W179, its metrics, limits and page."""

import json
import re
import shutil
import subprocess

import numpy as np
import pytest

import tailslap
from postprocess.comparison.metrics import Metrics, weighted_metrics
from tailslap import cli
from tailslap.comparing import validation
from tailslap.comparing.compare_report import compare_items
from tailslap.comparing.source import Item

T = np.array([0.0, 1.0])
UNITS = {"t": "s", "v_gx": "m/s", "v_gy": "m/s", "omega": "rad/s"}


def item(label, v_gx, v_gy, omega, **more):
    columns = {"t": T, "v_gx": v_gx, "v_gy": v_gy, "omega": omega} | more
    return Item(label, {name: np.array(values, float) for name, values in columns.items()}, UNITS)


def result(*columns, mass=2.0, **more):
    """A result with a known kinetic energy.

    E = m (v^2 + (k omega)^2)/2 and k = 2 m.
    """
    base = item("ours", *columns, kinetic_energy=[9.0, 6.0], **more)
    checks = [{"name": "added mass", "value": 0.02}]
    return Item(base.label, base.columns, UNITS, {"plate": {"mass": mass}, "checks": checks})


REFERENCE = ([0.0, 2.0], [0.0, -1.0], [0.0, 0.5])


def test_an_example_by_hand():
    """Changes 2, 1 and 1 have the weights 1/2, 1/4, 1/4.

    M is 0.1, 0 and -0.2; residuals are 0 to 0.1 and 0 to -0.2.
    """
    other = item("theirs", [0.0, 2.2], [0.0, -1.0], [0.0, 0.4])
    metrics = validation.multi_channel(compare_items([result(*REFERENCE), other]))["theirs"]
    assert metrics["weights"] == pytest.approx({"v_gx": 0.5, "v_gy": 0.25, "omega": 0.25}, abs=1e-12)
    expected = {"magnitude": 0.1, "phase": 0.0, "combined": 0.1, "mean_residual": 0.05, "deviation": 0.05}
    assert {name: metrics[name] for name in expected} == pytest.approx(expected, abs=1e-12)


def test_identical_histories_have_metrics_of_zero():
    items = compare_items([result(*REFERENCE), item("theirs", *REFERENCE)])
    metrics = validation.multi_channel(items)["theirs"]
    assert [metrics[name] for name in Metrics.__dataclass_fields__] == [0.0] * 5
    assert metrics["within"]


def test_opposite_errors_do_not_cancel_each_other():
    channels = [Metrics(0.3, 0.1, 0.4, 0.02, 0.1), Metrics(-0.1, 0.0, 0.1, -0.04, 0.3)]
    metrics = weighted_metrics(channels, [3.0, 1.0])
    assert (metrics.magnitude, metrics.mean_residual) == pytest.approx((0.25, 0.025), abs=1e-15)


def test_without_a_result_the_angular_velocity_has_no_weight():
    metrics = validation.multi_channel(compare_items([item("a", *REFERENCE), item("b", *REFERENCE)]))["b"]
    assert metrics["weights"] == pytest.approx({"v_gx": 2.0 / 3.0, "v_gy": 1.0 / 3.0}, abs=1e-15)


@pytest.mark.parametrize(("speed", "omega"), [(2.0, [0.0, 0.0]), (2.0, [np.nan, np.nan]), (4.0, [0.0, 0.5])])
def test_without_energy_of_rotation_there_is_no_radius_of_gyration(speed, omega):
    """A speed of 4 m/s has more than the kinetic energy."""
    assert validation.radius_of_gyration([result([0.0, speed], [0.0, -1.0], omega)]) is None


def test_results_of_other_commands_are_validated(tmp_path):
    """Rigid body and modal model have histories without checks."""
    rigid, modal = tailslap.rigid("paper-table-3"), tailslap.modal("paper-table-3", modes=2)
    for pair in ((rigid, modal), (modal, rigid)):
        comparison = tailslap.compare(*pair)
        assert comparison.summary["multi_channel"]
        assert (comparison.save(tmp_path / pair[0].command) / "validation.html").is_file()


def test_energies_and_mass_have_the_limits_of_w179():
    """Limits are fractions of total, initial and internal energy.

    They are 10, 5 and 10 %, and 5 % of the mass.
    """
    energies = {"strain_energy": [1.0, 1.5], "hourglass_energy": [0.0, 0.5], "friction_work": [0.0, -0.5]}
    items = compare_items([result(*REFERENCE, **energies), item("theirs", *REFERENCE)])
    verified = validation.solution_verification(items)
    rows = {row["name"]: (row["value"], row["limit"], row["passed"]) for row in verified}
    assert rows == {
        "change of total energy": (pytest.approx(0.15, abs=1e-12), 0.10, False),
        "hourglass over initial energy": (pytest.approx(0.05, abs=1e-12), 0.05, False),
        "hourglass over internal energy": (pytest.approx(0.25, abs=1e-12), 0.10, False),
        "added mass over mass": (0.02, 0.05, True),
    }
    page = validation.validation_page(items)
    assert (page.passed, page.headline.answer[:9]) == (False, "Not valid")


def test_the_page_of_a_comparison(tmp_path):
    run = tailslap.run("paper-table-3", {"plate.elements": (10, 3)})
    folder = run.save(tmp_path / "run", pictures=False)
    words = [
        "compare", str(folder), str(folder / "rigid.csv"), "--author", "A. <Reader>", "--out",
        str(tmp_path / "out"),
    ]  # fmt: skip
    assert cli._status(words) == 0
    text = (tmp_path / "out" / "validation.html").read_text(encoding="utf-8")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert "A. &lt;Reader&gt;" in text
    assert tailslap.__version__ in text
    for title in ("Basic information", "Solution verification", "Metrics of single channels", "Phenomena"):
        assert re.search(f"<h2>{title}", text)
    if browser := shutil.which("chromium"):  # one page of A4
        options = ("--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer")
        profile, printed = f"--user-data-dir={tmp_path / 'profile'}", tmp_path / "page.pdf"
        page = (tmp_path / "out" / "validation.html").as_uri()
        command = [browser, *options, profile, f"--print-to-pdf={printed}", page]
        subprocess.run(command, check=True, timeout=120)
        assert re.findall(rb"/Count (\d+)", printed.read_bytes()) == [b"1"]
    weights = summary["multi_channel"]["rigid"]["weights"]
    assert sum(weights.values()) == pytest.approx(1.0, abs=1e-14)
    x, y, spin = (np.ptp(run.rigid[name][np.isfinite(run.rigid[name])]) for name in ("v_gx", "v_gy", "omega"))
    gyration = np.sqrt((10.0**2 + 2.438**2) / 12.0)
    assert weights["omega"] == pytest.approx(gyration * spin / (x + y + gyration * spin), rel=1e-3)
    assert [row["passed"] for row in summary["solution_verification"]] == 4 * [True]
