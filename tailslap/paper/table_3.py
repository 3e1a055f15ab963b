"""Table 3: both printed columns against the exact motions with and without friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from solver import MotionState, PlaneMotion, strike_force
from tailslap.paper.method import Cell, beside, estimate, printed_motion
from tailslap.paper.printed import ABAQUS, ANALYTICAL, FEA_SPEED, MASS, PULSE, START
from tailslap.paper.table_1 import SPEEDS

Column = dict[str, Cell]
"""Cells by the names t [s], v_gy, v_gx [m/s], omega [rad/s], slide [m]."""


@dataclass(frozen=True)
class Table3:
    """Columns from the printed start, and what tells the motions apart.

    analytical: that column beside "drag" at the tail-slap; analytical_56: from Stage 1 at 56 mph, theta_0 as
    printed; analytical_15: the same from theta_0 = 15 degrees, not rounded. abaqus: its column beside "none" at the
    tail-slap; beside "none" at `reading` [s], four decimals of the instant at which the corner has slid as far
    as printed; and beside "drag" at the instant at which it has. crossing: the state of "drag" that has the
    printed v_GX (t [s], slide [m]). v_gx_25: v_GX without friction had v_P0 been the 25 m/s of Table 2 [m/s].
    peak_force: beside that of the printed v_GY, for a pulse of 0.1 s [N].
    """

    analytical: Column
    analytical_56: Column
    analytical_15: Column
    abaqus: Column
    abaqus_read: Column
    abaqus_drag: Column
    reading: float
    slide_at_printed_time: float
    crossing: tuple[float, float]
    v_gx_25: float
    peak_force: Cell


def table_3() -> Table3:
    """Both columns of Table 3 and their neighbours."""
    drag, none = printed_motion("drag"), printed_motion("none")
    reading = round(instant(none, "slide", ABAQUS["slide"]), 4)
    crossing = _state(drag, instant(drag, "v_gx", ABAQUS["v_gx"]))
    return Table3(
        _column(ANALYTICAL, drag.strike),
        _column(ANALYTICAL, estimate(SPEEDS["56 mph"], start_angle=START.angle).strike),
        _column(ANALYTICAL, estimate(SPEEDS["56 mph"]).strike),
        _column(ABAQUS, none.strike),
        _column(ABAQUS, _state(none, reading)),
        _column(ABAQUS, _state(drag, instant(drag, "slide", ABAQUS["slide"]))),
        reading,
        float(none.at(ABAQUS["t"]).slide),
        (crossing.t, crossing.slide),
        float(printed_motion("none", FEA_SPEED).strike.v_gx),
        beside(*(strike_force(MASS, v, PULSE).peak_force for v in (ANALYTICAL["v_gy"], drag.strike.v_gy))),
    )


def instant(motion: PlaneMotion, name: str, value: float) -> float:
    """The instant [s] at which a quantity that changes one way throughout has this value; by bisection."""
    low, high = 0.0, motion.strike.t
    rising = getattr(motion.strike, name) > float(getattr(motion.at(0.0), name))
    for _ in range(60):
        middle = 0.5 * (low + high)
        if (float(getattr(motion.at(middle), name)) < value) == rising:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _state(motion: PlaneMotion, t: float) -> MotionState[float]:
    state = motion.at(t)
    return MotionState(*(float(getattr(state, name)) for name in MotionState.__dataclass_fields__))


def _column(printed: Mapping[str, float], state: MotionState[float]) -> Column:
    return {name: beside(value, getattr(state, name)) for name, value in printed.items()}
