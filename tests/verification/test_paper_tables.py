"""Verification: the cells of `tailslap paper` by hand, and tables that a terminal shows whole."""

from __future__ import annotations

import math
import re
from itertools import pairwise

import pytest

from postprocess.report.numbers import percent
from postprocess.report.terminal import printed
from solver import plane_motion
from tailslap.paper.earlier import earlier_methods
from tailslap.paper.forces import force_result
from tailslap.paper.method import TRUCK, beside
from tailslap.paper.printed import INPUTS, ForceRow
from tailslap.paper.report.columns import computed
from tailslap.paper.report.columns import printed as printed_column
from tailslap.paper.report.report import paper_report, sections
from tailslap.paper.review import Review, review_paper
from tailslap.paper.table_3 import instant

pytestmark = pytest.mark.verification


@pytest.fixture(scope="module")
def result() -> Review:
    return review_paper()


def test_a_difference_is_computed_over_printed_less_one() -> None:
    cell = beside(-4.0, -3.0)
    assert (cell.printed, cell.computed, cell.difference) == (-4.0, -3.0, -0.25)
    columns = (printed_column("cell", ".1f"), *computed("cell", ".1f"))
    assert [column.text({"cell": cell}) for column in columns] == ["-4.0", "-3.0", "-25.000 %"]
    rounded = computed("0", lambda value: f"{value / 0.5:.0f}", decimals=1)
    assert [column.text((cell,)) for column in rounded] == ["-6", "-25.0 %"]


@pytest.mark.parametrize(
    ("share", "text"), [(0.0123456, "+1.235 %"), (-0.5, "-50.000 %"), (-1e-9, "0.000 %"), (0.0, "0.000 %")]
)
def test_percentages(share: float, text: str) -> None:
    assert percent(share, 3) == text


def test_every_difference_of_the_answer(result: Review) -> None:
    columns = (result.table_3.analytical, result.table_3.abaqus, result.table_3.abaqus_drag)
    found = [cell for column in columns for cell in column.values()]
    found += [cell for row in (*result.table_4, *result.table_5) for cell in (*row.peak, *row.factor)]
    found += [reading.value for reading in result.figures.readings]
    assert len(found) == 15 + 48 + 6
    for cell in found:
        assert cell.difference == pytest.approx((cell.computed - cell.printed) / cell.printed, abs=1e-14)


def test_inputs_in_si_by_hand() -> None:
    values = {item.name: item.value for item in INPUTS}
    assert values["speed"] == pytest.approx(25.0, rel=1e-15)
    assert values["angle"] == pytest.approx(math.pi / 12.0, rel=1e-15)
    assert (values["mass"], values["width"], values["length"]) == (9979.0, 2.438, 10.0)


def test_a_row_of_table_4_by_hand(result: Review) -> None:
    """The force is inverse to the duration, 1/(1 - e) between the two, and phi_a is force over measured."""
    row = ForceRow("x", "made up", 0.2, 100e3, (300e3, 400e3), (3.0, 4.0))
    made, known = force_result(row), result.table_4[0]
    assert known.printed.duration == 0.1
    assert made.peak[0].computed == pytest.approx(known.peak[0].computed / 2.0, rel=1e-14)
    assert made.peak[1].computed == pytest.approx(made.peak[0].computed / 0.78, rel=1e-13)
    assert made.factor[1].computed == pytest.approx(made.peak[1].computed / 100e3, rel=1e-14)
    assert made.ratio.printed == pytest.approx(4.0 / 3.0, rel=1e-15)
    assert made.ratio.computed == pytest.approx(1.0 / 0.78, rel=1e-15)
    assert made.factor_of_print == (3.0, 4.0)
    assert made.impulse == pytest.approx(30e3, rel=1e-15)


@pytest.mark.parametrize(
    ("plastic", "rounds"), [(1282e3, True), (1281e3, True), (1284e3, False), (1280e3, False)]
)
def test_what_rounding_explains(plastic: float, rounds: bool) -> None:
    """1000 kN stands for 999.5 to 1000.5, so that 1/0.78 makes it 1281.4 to 1282.7, and half a kilonewton more."""
    row = ForceRow("x", "made up", 0.1, 1e6, (1e6, plastic), (1.0, 1.0))
    assert force_result(row).rounds is rounds


def test_every_ratio_is_exact(result: Review) -> None:
    for row in (*result.table_4, *result.table_5, *result.row_b):
        assert row.peak[1].computed / row.peak[0].computed == pytest.approx(1.0 / 0.78, rel=1e-12)


def test_the_instant_at_which_a_quantity_has_a_value() -> None:
    motion = plane_motion(TRUCK, 0.26, 0.707, 25.053, 0.47)
    for name in ("slide", "v_gx", "theta", "omega"):
        assert instant(motion, name, float(getattr(motion.at(0.2), name))) == pytest.approx(0.2, abs=1e-9)


def test_earlier_methods_by_hand() -> None:
    """Olson stops the lateral motion within A_L sin(theta) - B (1 - cos(theta)); Hirsch pi/2, Ritter twice that."""
    theta, speed = math.radians(15.0), 56.0 * 0.44704
    way = 5.0 * math.sin(theta) - 1.219 * (1.0 - math.cos(theta))
    olson = 9979.0 * (speed * math.sin(theta)) ** 2 / (2.0 * way)
    methods = earlier_methods()
    assert methods.olson == pytest.approx(olson, rel=1e-13)
    assert methods.olson_first_member == pytest.approx(olson / 2.0, rel=1e-13)
    assert methods.hirsch == pytest.approx(math.pi / 2.0 * olson, rel=1e-13)
    assert methods.ritter == pytest.approx(2.0 * olson, rel=1e-13)


def test_tables_are_rectangular_and_without_empty_or_undefined_words(result: Review) -> None:
    tables = [table for section in sections(result) for table in section.tables]
    assert len(tables) == 11
    for table in tables:
        assert len(table.records()) == len(table.rows)
        assert sum(span for _, span in table.groups) in (0, len(table.columns))
        cells = [column.text(row) for row in table.rows for column in table.columns]
        words = " ".join((table.title, *table.notes, *cells))
        assert not {"nan", "inf", "None", "–", "infinite", "number"} & {*words.split()}


@pytest.mark.parametrize("width", [60, 80, 100])
def test_no_line_is_longer_than_the_terminal(
    result: Review, width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every word is there, in one piece."""
    monkeypatch.setenv("COLUMNS", str(width))
    out = printed(paper_report(result).terminal)
    words = {word for word in out.split() if word != "\\"}
    longest = max(len(word) for word in words if "─" not in word)
    assert max(map(len, out.splitlines())) <= max(width, longest + 11)
    monkeypatch.setenv("COLUMNS", "100")
    wide = printed(paper_report(result).terminal).split()
    assert {word for word in wide if "─" not in word and word != "\\"} <= words


def test_a_terminal_shows_the_tables_whole(result: Review, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it is wide enough nothing is cut or wrapped, and markup is left alone."""
    monkeypatch.setenv("COLUMNS", "100")
    out = printed(paper_report(result).terminal)
    lines = [line for line in out.splitlines() if not line.startswith("  repeat")]
    assert "…" not in out
    assert "\N{NO-BREAK SPACE}" not in out
    for line, after in pairwise(line for line in lines if "  " not in line.strip()):
        assert not re.fullmatch(r".*(\d\n *(%|kN|m/s|rad|s|m|ms|mph)(?!\w).*|=)", f"{line}\n{after}"), line
    shown = {" ".join(line.split()) for line in lines}
    for section in sections(result):
        assert section.title in lines
        for table in section.tables:
            for row in table.rows:
                cells = " ".join(column.text(row) for column in table.columns)
                assert " ".join(cells.split()) in shown
    assert "1. The analytical column" in out
