"""The findings of the review: what was checked and seen, how to repeat it, what is inferred; figures are computed."""

from __future__ import annotations

from postprocess.report.page import Finding
from tailslap.paper.printed import ABAQUS
from tailslap.paper.report.force_findings import factors_finding, ratios_finding, restitution_finding
from tailslap.paper.report.impact_findings import (
    duration_finding,
    mass_finding,
    push_finding,
    rebound_finding,
)
from tailslap.paper.report.motion_findings import (
    abaqus_finding,
    analytical_finding,
    reaction_finding,
    speed_finding,
)
from tailslap.paper.review import Review


def findings(result: Review) -> tuple[Finding, ...]:
    """In the order of the paper's results, that of restitution before the forces it changes; the whole impact last."""
    return (
        analytical_finding(result.table_3),
        speed_finding(result.table_1),
        abaqus_finding(result.table_3),
        reaction_finding(result.reaction),
        restitution_finding(result.restitution),
        ratios_finding(result.table_4, result.table_5),
        factors_finding(result.table_4, result.table_5, result.row_b[0]),
        rebound_finding(result.whole_impact),
        push_finding(result.whole_impact, result.reaction),
        mass_finding(result.whole_impact),
        duration_finding(result.whole_impact),
    )


def headline(result: Review) -> str:
    """The result in three sentences."""
    column, force = result.table_3.analytical, result.table_3.peak_force.computed / 1e3
    worst = max(abs(column[name].difference) for name in ("v_gy", "v_gx", "slide"))
    return (
        f"The analytical column of Table 3 is confirmed: velocities and slide to {100 * worst:.2f} %, with a peak "
        f"force of {force:.0f} kN for a pulse of 0.1 s. The ABAQUS column equals the motion without friction at "
        f"t = {result.table_3.reading:g} s, where s = {result.table_3.abaqus_read['slide'].computed:.3f} m against "
        f"the printed {ABAQUS['slide']:g} m. Tables 4 and 5 can be recomputed only for the vehicle of Table 1: the "
        "paper gives no other."
    )
