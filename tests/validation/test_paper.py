"""Validate `tailslap paper` and FE runs by Chuong and Malla (2025).

The numbers are typed here from the paper's text, not taken from the program's data file. The paper has ABAQUS and
analytical results of the MASH TL-4 single-unit truck in Table 3, read off charts; a chart's reading is held to a unit
of its last digit, or two where the unit is a millimetre per second.
"""

import contextlib
import io
import json
import math
from typing import Any

import numpy as np
import pytest

from postprocess.comparison.quantities import PAPER_TABLE_3
from tailslap.cli import _status

ANALYTICAL = {"t": 0.383, "v_gy": -3.274, "v_gx": 23.270, "omega": 0.65, "slide": 9.420}  # Table 3
FORCES = {  # kN: 50 ms, peak for e = 0.22 and e = 0; then Table 5's three; Tables 4 and 5
    "a": ((680, 707, 898.5), (904, 707, 898.5)), "b": ((595, 680, 872), (791, 680, 872)),
    "c": ((415, 609, 783), (552, 609, 783)), "d": ((351, 765, 978), (467, 765, 978)),
    "e": ((360, 614, 796), (479, 614, 796)), "f": ((375, 351, 440), (500, 396, 494)),
}  # fmt: skip
FACTORS = {  # phi_a for e = 0.22 and e = 0, Table 4, then Table 5
    "a": ((1.04, 1.32), (0.78, 0.99)), "b": ((1.14, 1.46), (0.86, 1.1)), "c": ((1.47, 1.89), (1.1, 1.42)),
    "d": ((2.17, 2.78), (1.64, 2.09)), "e": ((1.7, 2.21), (1.28, 1.66)), "f": ((0.94, 1.17), (0.79, 0.99)),
}  # fmt: skip


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert _status(["paper", "--json", "--out", str(tmp_path_factory.mktemp("paper") / "out")]) == 0
    answer: dict[str, Any] = json.loads(out.getvalue())
    return answer


@pytest.mark.parametrize("column", ["analytical", "analytical_56"])
@pytest.mark.parametrize(
    ("name", "read"), [("v_gy", 2e-3), ("v_gx", 1e-2), ("slide", 9e-3), ("t", 1e-3), ("omega", 5.2e-3)]
)
def test_the_analytical_column(answers, column, name, read):
    """From the printed start, and from 56 mph with theta_0 = 0.26."""
    cell = answers["table_3"][column][name]
    assert cell["printed"] == ANALYTICAL[name]
    assert cell["computed"] == pytest.approx(ANALYTICAL[name], abs=read)


def test_the_start_is_that_of_56_mph(answers):
    mph, metric = (answers["table_1"]["starts"][words] for words in ("56 mph", "90 km/h"))
    assert mph["omega"]["computed"] == pytest.approx(0.707, abs=5e-4)
    assert mph["corner_speed"]["computed"] == pytest.approx(25.053, abs=1e-3)
    assert abs(metric["omega"]["computed"] - 0.707) > 8e-4
    assert abs(metric["corner_speed"]["computed"] - 25.053) > 0.03
    assert answers["table_1"]["implied_speed"] / 0.44704 == pytest.approx(56.0, abs=2e-3)


def test_the_abaqus_column_is_the_frictionless_motion_at_0_3625_s(answers):
    """s agrees to all digits, omega to two, v_GX better."""
    table = answers["table_3"]
    read, drag = table["abaqus_read"], table["abaqus_drag"]
    assert (table["reading"], f"{read['slide']['computed']:.3f}") == (0.3625, "8.915")
    assert f"{read['omega']['computed']:.2f}" == "0.66"
    assert read["v_gy"]["computed"] == pytest.approx(-3.289, rel=2e-3)
    assert read["v_gx"]["computed"] == pytest.approx(23.305, abs=0.01)
    assert abs(drag["v_gx"]["computed"] - 23.305) > 4.0 * abs(read["v_gx"]["computed"] - 23.305)
    assert drag["slide"]["computed"] == pytest.approx(8.915, abs=1e-9)
    assert table["crossing"][1] < 0.2 * 8.915


def test_the_peak_force(answers):
    """The printed 654 kN is 2 m v_GY/(0.1 s)."""
    force = answers["table_3"]["peak_force"]
    assert force["computed"] == pytest.approx(654e3, abs=0.5e3)
    assert force["printed"] == pytest.approx(2.0 * 9979.0 * 3.274 / 0.1, rel=1e-12)


def test_the_reaction_pulls(answers):
    """N is -m r omega^2 S/D.

    D = 1 + 3 C^2 + 3 mu S C.
    """
    gamma, r = math.atan(0.2438), math.hypot(10.0, 2.438) / 2.0
    for name, phi, omega in (("first", gamma + 0.26, 0.707), ("last", gamma, 0.6551053441)):
        s, c = math.sin(phi), math.cos(phi)
        normal = -9979.0 * r * omega**2 * s / (1.0 + 3.0 * c * c + 3.0 * 0.47 * s * c)
        assert answers["reaction"][name] == pytest.approx(normal, rel=1e-8)
    assert answers["reaction"]["largest"] == pytest.approx(answers["reaction"]["last"], rel=1e-12)


def test_what_restitution_changes(answers):
    """The peak force is in proportion to 1 -+ e."""
    cases = answers["restitution"]
    recoil = 0.22 * 56.0 * 0.44704 * math.sin(math.radians(15.0))
    assert cases["newton"]["change"] == pytest.approx(1.22 / 0.78 - 1.0, rel=1e-12)
    assert cases["e = 0"]["change"] == pytest.approx(1.0 / 0.78 - 1.0, rel=1e-12)
    assert cases["paper"]["corner_recoil"] == pytest.approx(-recoil, rel=1e-12)
    assert cases["newton"]["corner_recoil"] == pytest.approx(recoil, rel=1e-12)


@pytest.mark.parametrize("table", [0, 1])
def test_tables_4_and_5_are_printed_as_in_the_paper(answers, table):
    for result in answers[f"table_{4 + table}"]:
        row = result["printed"]
        measured, *peak = (1e3 * force for force in FORCES[row["row"]][table])
        assert (row["measured"], row["peak"]) == (measured, peak)
        assert row["factor"] == list(FACTORS[row["row"]][table])
        assert row["projected"] == (table == 1 and row["row"] != "f")


def test_the_printed_tables_agree_with_themselves(answers):
    """phi_a is force over measured force.

    Projected forces are 1.33 times those over 50 ms.
    """
    for result in (*answers["table_4"], *answers["table_5"]):
        assert result["factor_of_print"] == pytest.approx(result["printed"]["factor"], abs=0.01)
    for fifty, sae in zip(answers["table_4"], answers["table_5"], strict=True):
        assert sae["printed"]["measured"] == pytest.approx(1.33 * fifty["printed"]["measured"], abs=1.3e3)


def test_rows_off_the_exact_ratio(answers):
    """b is 1/(1 - 0.22) to rounding, c and d nearly."""
    off = {result["printed"]["row"]: abs(result["ratio"]["difference"]) for result in answers["table_4"]}
    assert [result["printed"]["row"] for result in answers["table_4"] if result["rounds"]] == ["b"]
    assert {row for row, difference in off.items() if difference > 5e-3} == {"a", "e", "f"}


def test_row_b_with_the_speed_and_angle_of_its_test(answers):
    """Speed and angle of the test lead to both printed forces."""
    for cell, printed in zip(answers["row_b"][0]["peak"], (680e3, 872e3), strict=True):
        assert cell["computed"] == pytest.approx(printed, rel=1e-2)


def test_the_analytical_column_by_finite_elements(outcome):
    """Values with friction are within rounding and reading of the plots."""
    fe, printed = outcome("paper-table-3").fe, PAPER_TABLE_3["analytical"]
    for name, share in (("v_gx", 1e-3), ("v_gy", 1e-3), ("slide", 1e-3), ("t", 3e-3), ("omega", 8e-3)):
        assert fe[name] == pytest.approx(printed[name], rel=share), name


def test_the_abaqus_column_is_the_frictionless_run_read_before_the_strike(outcome):
    """s and omega at 0.3625 s have all printed digits."""
    history, printed = outcome("paper-abaqus").fe_history, PAPER_TABLE_3["abaqus"]
    at = {name: np.interp(0.3625, history["t"], history[name]) for name in ("slide", "omega", "v_gx", "v_gy")}
    assert (round(at["slide"], 3), round(at["omega"], 2)) == (printed["slide"], printed["omega"])
    assert at["v_gx"] == pytest.approx(printed["v_gx"], rel=5e-4)
    assert at["v_gy"] == pytest.approx(printed["v_gy"], rel=2e-3)


def test_with_friction_no_instant_gives_the_abaqus_column(outcome):
    """At the printed slide its velocity is not the printed one."""
    history, printed = outcome("paper-table-3").fe_history, PAPER_TABLE_3["abaqus"]
    v_gx = np.interp(printed["slide"], history["slide"], history["v_gx"])
    assert abs(v_gx - printed["v_gx"]) > 0.025
