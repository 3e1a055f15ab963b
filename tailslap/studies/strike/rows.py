"""Rows a to f of the paper's Tables 4 and 5 beside the bands, in the manner of ASME V&V 20.

The comparison error is E = S - D, simulated less measured; the validation uncertainty u_val = sqrt(u_num^2 + u_input^2
+ u_D^2). What is left of E beyond u_val is the model's. Nothing here is fitted to a row: all ranges were set before,
and where a row's own speed and angle are known it is these that are put in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tailslap.case.impact.case import ImpactCase
from tailslap.impact.rigid_text import rigid_impact
from tailslap.paper.data import ROW_B_ANGLE, ROW_B_GIVEN, ROW_B_SPEED, TABLE_4, TABLE_5, ForceRow
from tailslap.studies.strike.bands import Band, Bands, conditional
from tailslap.studies.strike.impacts import measured
from tailslap.studies.strike.plates import both_strikes
from tailslap.studies.strike.quantities import column
from tailslap.studies.uncertainty.spread import PERCENTILES

LEVEL = "TL-4"
"""The rows are of this test level's single-unit truck."""

KNOWN = {"b": {"impact.speed": ROW_B_SPEED, "impact.angle": ROW_B_ANGLE}}
"""What is known of the rows' impacts, SI."""

KNOWN_WORDS = {"b": ROW_B_GIVEN}
TAKEN = {"mean_50ms": ("50 ms mean", TABLE_4), "cfc60": ("CFC 60", TABLE_5)}
"""By the quantity of the second strike that stands beside a table: its words, the table."""


@dataclass(frozen=True)
class RowBeside:
    """A measured force beside the second strike's [N].

    Attributes
    ----------
    row, source, kind : str
        As the paper names it; by which filter.
    measured : float
        D.
    projected : bool
        Whether D is the authors' projection, 1.33 times the 50 ms mean.
    known : str
        What of its impact is known, in words, or "".
    simulated : float
        S, from the scene's own values and what is known.
    band : Band
        Of S.
    u_num, u_input : float
        Of the solution; of the inputs, the band's standard deviation.
    """

    row: str
    source: str
    kind: str
    measured: float
    projected: bool
    known: str
    simulated: float
    band: Band
    u_num: float
    u_input: float

    @property
    def label(self) -> str:
        """Its letter, with a star where D is projected."""
        return f"{self.row}*" if self.projected else self.row

    @property
    def error(self) -> float:
        """E = S - D."""
        return self.simulated - self.measured

    @property
    def u_known(self) -> float:
        """u_val with u_D, which nobody gives, left out."""
        return math.hypot(self.u_num, self.u_input)

    @property
    def within(self) -> bool:
        """Whether |E| is within u_val, whatever u_D may be."""
        return abs(self.error) <= self.u_known

    @property
    def u_d_needed(self) -> float:
        """The smallest u_D with which |E| would be within u_val; 0 where it is."""
        return math.sqrt(max(0.0, self.error**2 - self.u_known**2))

    @property
    def verdict(self) -> str:
        """Whether |E| is within u_val, or what is missing."""
        if self.within:
            return "within u_val"
        return f"beyond, unless u_D is {self.u_d_needed / 1e3:.0f} kN"

    @property
    def ends(self) -> tuple[float, float, float]:
        """5, 50 and 95 % of the simulated forces."""
        low, middle, high = self.band.percentiles
        assert PERCENTILES == (5, 50, 95)
        return low, middle, high

    @property
    def share_below(self) -> float:
        """Share of the simulated forces below the measured one."""
        return self.band.share_below(self.measured)


def find_rows(plan: ImpactCase, bands: Bands) -> tuple[RowBeside, ...]:
    """All rows of both tables; none for a scene of another test level."""
    impact = plan.scene.impact
    if impact is None or impact.test_level != LEVEL:
        return ()
    cases = {"": (plan, bands)} | {row: _known_case(plan, bands, row) for row in KNOWN}
    found = []
    for name, (kind, table) in TAKEN.items():
        beside = {row: _simulated(*case, column(2, name)) for row, case in cases.items()}
        found += [
            _row(printed, kind, beside[printed.row if printed.row in KNOWN else ""]) for printed in table
        ]
    return tuple(found)


def _known_case(plan: ImpactCase, bands: Bands, row: str) -> tuple[ImpactCase, Bands]:
    """Plan and bands with what is known of a row's impact."""
    return plan.varied(KNOWN[row]), conditional(plan, bands, KNOWN[row])


def _simulated(plan: ImpactCase, bands: Bands, name: str) -> tuple[float, Band, float]:
    """S by the solution from event to event, its band, and u_num: how far the many impacts' solution is from it."""
    exact = both_strikes(rigid_impact(plan))[name]
    own = {"contact.stiffness": plan.scene.contact.stiffness if plan.scene.contact else None}
    many = measured(plan, {key: np.array([value]) for key, value in own.items()})[name]
    return exact, bands.band(name), abs(float(many[0]) - exact)


def _row(printed: ForceRow, kind: str, beside: tuple[float, Band, float]) -> RowBeside:
    force = (printed.row, printed.source, kind, printed.measured, printed.projected)
    return RowBeside(*force, KNOWN_WORDS.get(printed.row, ""), *beside, beside[1].standard_deviation)
