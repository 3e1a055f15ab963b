"""Findings on the motion, Stages 1 and 2: Table 1's start, Table 3, the wall's reaction."""

from __future__ import annotations

from postprocess.report.numbers import percent
from postprocess.report.page import Finding
from tailslap.paper.printed import ABAQUS, FEA_SPEED, KM_PER_HOUR, MPH, START
from tailslap.paper.review import Reaction
from tailslap.paper.table_1 import Table1
from tailslap.paper.table_3 import Table3

PRINTED_START = "RectangularBody(10, 2.438, 9979), 0.26, 0.707, 25.053, 0.47"


def analytical_finding(table: Table3) -> Finding:
    """Eqs 66-71, solved exactly, give the analytical column."""
    column, exact = table.analytical, table.analytical_15
    longer = exact["slide"].computed / column["slide"].computed - 1.0
    worst = max(abs(column[name].difference) for name in ("v_gy", "v_gx", "slide"))
    return Finding(
        "The analytical column of Table 3 is right",
        "Eqs 66-71 were integrated exactly from the printed start: they have a closed form but for one quadrature.",
        (
            f"v_GY, v_GX and s agree to {100 * worst:.2f} %, t to {100 * abs(column['t'].difference):.1f} %, ω to "
            f"{100 * abs(column['omega'].difference):.1f} %, two digits being printed.",
            f"The peak force for Δt = 0.1 s is {table.peak_force.computed / 1e3:.1f} kN; from the printed v_GY it is "
            f"{table.peak_force.printed / 1e3:.1f} kN.",
            f"θ_0 = {START.angle:g} rad is 15 deg, rounded. From 15 deg itself, t = {exact['t'].computed:.4f} s and "
            f"s = {exact['slide'].computed:.3f} m ({percent(longer, 1)}).",
        ),
        ("tailslap rigid paper-table-3", "tailslap rigid mash-tl4-sut"),
    )


def speed_finding(table: Table1) -> Finding:
    """Which speed the printed start belongs to."""
    mph, metric = table.starts["56 mph"], table.starts["90 km/h"]
    return Finding(
        "The start values agree with 56 mph, not with the 90 km/h of Table 1",
        f"Stage 1 (Eqs 6-33) was computed from both speeds and compared with the printed ω_0 = {START.omega:g} rad/s "
        f"and v_P0 = {START.corner_speed:g} m/s.",
        (
            f"56 mph gives {mph.omega.computed:.4f} rad/s and {mph.corner_speed.computed:.3f} m/s; 90 km/h gives "
            f"{metric.omega.computed:.4f} rad/s and {metric.corner_speed.computed:.3f} m/s.",
            f"The printed v_P0 is reached from {table.implied_speed / MPH:.3f} mph, or "
            f"{table.implied_speed / KM_PER_HOUR:.2f} km/h. 90 km/h, or {metric.speed / MPH:.2f} mph, "
            f"would change the peak force by {percent(metric.peak_force / mph.peak_force - 1.0, 2)}.",
        ),
        ("tailslap rigid mash-tl4-sut", 'tailslap rigid mash-tl4-sut --set impact.speed="90 km/h"'),
        ("The printed start was computed from 56 mph, which Table 1 gives in km/h, rounded.",),
    )


def abaqus_finding(table: Table3) -> Finding:
    """What the finite-element column is, as far as its five numbers tell."""
    read, drag, strike = table.abaqus_read, table.abaqus_drag, table.abaqus
    t, slide = table.crossing
    beyond = ABAQUS["v_gy"] / strike["v_gy"].computed - 1.0
    reading = f"{table.reading:g}"
    at = f'print(plane_motion({PRINTED_START}, "{{}}").at({reading}))'
    return Finding(
        f"The ABAQUS column of Table 3 equals the motion without friction at t = {reading} s",
        "The printed start was followed exactly with the friction of Eqs 66-67 and without friction. The one "
        f"unknown, the instant of reading, was set by the printed s = {ABAQUS['slide']:g} m.",
        (
            f"Without friction, t = {reading} s: s = {read['slide'].computed:.3f} m to all digits, "
            f"v_GX = {read['v_gx'].computed:.3f} m/s ({percent(read['v_gx'].difference, 2)}), "
            f"v_GY = {read['v_gy'].computed:.3f} m/s ({percent(read['v_gy'].difference, 2)}), "
            f"ω = {read['omega'].computed:.3f} rad/s.",
            f"With friction, at the same s: v_GX = {drag['v_gx'].computed:.3f} m/s "
            f"({percent(drag['v_gx'].difference, 2)}), v_GY = {drag['v_gy'].computed:.3f} m/s "
            f"({percent(drag['v_gy'].difference, 2)}). No instant of that motion gives the column: v_GX has fallen "
            f"through {ABAQUS['v_gx']:g} m/s at t = {t:.3f} s, when s = {slide:.2f} m.",
            f"The tail-slap is at {strike['t'].computed:.4f} s, {1e3 * (strike['t'].computed - table.reading):.0f} ms "
            f"after the reading. The printed t = {ABAQUS['t']:g} s and s do not belong together in either motion: "
            f"at that t, s = {table.slide_at_printed_time:.3f} m without friction.",
            f"What is left: the printed v_GY is {100.0 * beyond:.2f} % beyond what the motion without friction "
            f"reaches at the tail-slap. From the V_x = {FEA_SPEED:g} m/s of Table 2, v_GX would be "
            f"{table.v_gx_25:.3f} m/s.",
        ),
        (
            *(f"python -c 'from solver import *; {at.format(name)}'" for name in ("none", "drag")),
            "tailslap run paper-abaqus",
        ),
        (
            "The column was read before the tail-slap from a run on which friction did not act, and which started from "
            "the printed v_P0, not from Table 2's V_x. Then the agreement of the two columns compares a run without "
            "friction with equations that have it.",
            "A likely reason: the corner's boundary condition in Table 2 carries the wall's reaction, and the penalty "
            "contact has no normal force for its friction to act on. A plate that vibrates, read at a node, may "
            "explain what is left of v_GY.",
        ),
    )


def reaction_finding(reaction: Reaction) -> Finding:
    """The sign of the wall's reaction."""
    first, last = reaction.first / 1e3, reaction.last / 1e3
    return Finding(
        "The wall's reaction pulls the vehicle throughout Stage 2",
        "N = m a_GY, the equilibrium across the wall that Section 2.2.2 leaves out, was evaluated along the "
        "exact motion with friction.",
        (
            f"N runs from {first:.2f} kN at the start to {last:.2f} kN at the tail-slap and is never above "
            f"{reaction.largest / 1e3:.2f} kN: negative, a pull.",
            "The model is a corner on a two-sided slider, with friction μ_k |N|. That the truck's corner stays on "
            "the wall is an assumption of Stage 2, not a result of it.",
        ),
        (
            f"python -c 'from solver import *; "
            f"print(plane_motion({PRINTED_START}).at([0, 0.3839]).reaction_normal)'",
        ),
        ("A wall can only push: without that pull the truck's corner would leave it.",),
    )
