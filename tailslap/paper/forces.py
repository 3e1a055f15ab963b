"""Tables 4 and 5: peak lateral forces and adjustment factors, row by row.

The paper gives neither mass nor speed nor length of the six vehicles, so every row is computed with the
vehicle and impact of Table 1, at 56 mph, and differs from its neighbours by the pulse's duration alone.
"""

from __future__ import annotations

from dataclasses import dataclass

from tailslap.paper.method import Cell, beside, estimate
from tailslap.paper.printed import ANGLE, RESTITUTIONS, ROW_B_ANGLE, ROW_B_SPEED, TABLE_4, TABLE_5, ForceRow
from tailslap.paper.table_1 import SPEEDS

Pair = tuple[Cell, Cell]
"""For e = 0.22 and e = 0."""

CHART_READING = 5e-3
"""Share by which a ratio of two forces may be off because its numbers were rounded or read off charts."""


@dataclass(frozen=True)
class ForceResult:
    """A row: its print, and beside it what is computed.

    peak [N]; factor: phi_a. ratio: printed F(e = 0)/F(e = 0.22) beside the exact 1/(1 - e), printed first.
    rounds: whether rounding of the printed forces explains that ratio. factor_of_print: the row's own printed
    forces over its measured one. impulse: F dt/2 of the printed force for e = 0.22 [N s].
    """

    printed: ForceRow
    peak: Pair
    factor: Pair
    ratio: Cell
    rounds: bool
    factor_of_print: tuple[float, float]
    impulse: float


def table_4() -> tuple[ForceResult, ...]:
    """50 ms averages, rows a to f."""
    return tuple(force_result(row) for row in TABLE_4)


def table_5() -> tuple[ForceResult, ...]:
    """SAE-filtered forces, rows a to f."""
    return tuple(force_result(row) for row in TABLE_5)


def row_b_known() -> tuple[ForceResult, ForceResult]:
    """Row b of Tables 4 and 5 with the speed and angle of its crash test, else Table 1's vehicle."""
    first, second = (force_result(table[1], ROW_B_SPEED, ROW_B_ANGLE) for table in (TABLE_4, TABLE_5))
    return first, second


def force_result(row: ForceRow, speed: float = SPEEDS["56 mph"], angle: float = ANGLE) -> ForceResult:
    """The row computed for a speed [m/s] and an angle [rad]."""
    computed = tuple(estimate(speed, angle, e, duration=row.duration).peak_force for e in RESTITUTIONS)
    exact = 1.0 / (1.0 - RESTITUTIONS[0])
    return ForceResult(
        row,
        _pair(row.peak, computed),
        _pair(row.factor, tuple(force / row.measured for force in computed)),
        beside(row.peak[1] / row.peak[0], exact),
        _rounds(row, exact),
        (row.peak[0] / row.measured, row.peak[1] / row.measured),
        0.5 * row.peak[0] * row.duration,
    )


def _pair(printed: tuple[float, float], computed: tuple[float, ...]) -> Pair:
    first, second = (beside(*values) for values in zip(printed, computed, strict=True))
    return first, second


def _rounds(row: ForceRow, exact: float) -> bool:
    """Whether two forces that are printed as these, to the kilonewton, may have the exact ratio."""
    half = 500.0  # N
    smallest = (row.peak[1] - half) / (row.peak[0] + half)
    largest = (row.peak[1] + half) / (row.peak[0] - half)
    return smallest <= exact <= largest
