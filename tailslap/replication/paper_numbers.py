"""Compute the numbers of the paper beside the printed ones.

They are nested dicts in SI, the summary of `tailslap paper --json`. A printed and a computed number are in a cell
{"printed", "computed", "difference"}; difference: computed/printed - 1. Every row of Tables 4 and 5 is computed with
the vehicle and impact of Table 1, at 56 mph, as the paper does not describe the six vehicles; rows differ by the
duration of the pulse.
"""

import math
from typing import Any, NamedTuple

import numpy as np

import solver
from postprocess.units import MPH
from solver.impact import CrushLaw, ImpactMotion, ImpactVehicle, WallContact, first_touch, solve_impact
from tailslap.case.impact.answers import rigid_answer
from tailslap.replication import paper_values as paper

Cell = dict[str, float]
Numbers = dict[str, Any]
"""Numbers of a part of the paper, nested."""

TRUCK = solver.RectangularBody(paper.LENGTH, paper.WIDTH, paper.MASS)
IMPACT_TRUCK = ImpactVehicle(paper.LENGTH, paper.WIDTH, paper.MASS)

MASH_SPEED = 56.0 * MPH
SPEEDS = {"56 mph": MASH_SPEED, "90 km/h": paper.SPEED}
"""Speeds from which the start may have been computed [m/s]: of MASH for the truck, and its printed metric rounding."""

FIGURES = {10: "theta", 11: "v_gy", 12: "v_gx", 13: "omega", 14: "slide"}
"""Quantity by the number of a figure in the paper."""

INSTANTS = 201
ROUND_TIMES = (0.0, 0.1, 0.2, 0.3)  # s; the tail-slap is added

STIFFNESSES = (1e6, 2e6, 3e6)
"""Crush stiffnesses of a corner [N/m], assumed: those of such a truck are unknown."""

NEARLY_RIGID = 2e8
"""Stiffness of a nearly instantaneous impact [N/m]."""

INTERVAL = 2e-4
"""Time between the rows of force histories [s]."""


class Stages(NamedTuple):
    """Stages 1 to 3 of one impact.

    peak_force of the tail-slap [N] for a triangular pulse.
    """

    stage1: solver.ImpulseResult[float]
    strike: solver.MotionState[float]
    peak_force: float


def review() -> Numbers:
    """Compute all numbers, in less than a second.

    row_b: row b of Tables 4 and 5 with the speed and angle of its test.
    """
    return {
        "table_1": table_1(),
        "table_3": table_3(),
        "figures": figures(),
        "table_4": [force_row(row) for row in paper.TABLE_4],
        "table_5": [force_row(row) for row in paper.TABLE_5],
        "row_b": [
            force_row(table[1], paper.ROW_B_SPEED, paper.ROW_B_ANGLE)
            for table in (paper.TABLE_4, paper.TABLE_5)
        ],
        "earlier": earlier_methods(),
        "reaction": reaction(),
        "restitution": restitutions(),
        "whole_impact": whole_impact(),
    }


def beside(printed: float, computed: float) -> Cell:
    """Return printed and computed value with difference.

    Neither is zero.
    """
    cell = {"printed": float(printed), "computed": float(computed)}
    return cell | {"difference": float(computed / printed - 1.0)}


def stages(
    speed: float = MASH_SPEED,
    angle: float = paper.ANGLE,
    restitution: float = paper.RESTITUTION,
    convention: str = "paper",
    duration: float = paper.PULSE,
    start_angle: float | None = None,
) -> Stages:
    """Compute all three stages of the truck.

    Friction as in Eqs 66-67. speed [m/s]; angle [rad]; duration of the pulse [s]; start_angle: initial angle of Stage 2
    [rad], by default that of the impact.
    """
    stage1 = solver.corner_impulse(TRUCK, speed, angle, paper.FRICTION, restitution, convention)
    theta_0 = angle if start_angle is None else start_angle
    strike = solver.tail_slap(TRUCK, theta_0, stage1.omega, stage1.corner_speed, paper.FRICTION)
    return Stages(stage1, strike, solver.strike_force(paper.MASS, strike.v_gy, duration).peak_force)


def printed_motion(
    reaction: str = "drag", corner_speed: float = paper.START["corner_speed"]
) -> solver.PlaneMotion:
    """Solve Stage 2 from the printed start, corner_speed in m/s."""
    return solver.plane_motion(
        TRUCK, paper.START["angle"], paper.START["omega"], corner_speed, paper.FRICTION, reaction
    )


def table_1() -> Numbers:
    """Compute Stage 1 from both speeds beside the printed start.

    implied_speed is that of the printed v_P0 [m/s]. derived: gamma, phi, beta [rad]; r_PG [m]; I_G [kg m^2] (Eqs 7,
    15, 26, 63).
    """
    starts = {}
    for name, speed in SPEEDS.items():
        stage1, _, peak_force = stages(speed)
        starts[name] = {
            "speed": speed,
            "omega": beside(paper.START["omega"], stage1.omega),
            "corner_speed": beside(paper.START["corner_speed"], stage1.corner_speed),
            "lateral_speed": beside(paper.LATERAL_SPEED, speed * math.sin(paper.ANGLE)),
            "impulse": stage1.impulse,
            "peak_force": peak_force,
        }
    derived = {
        "gamma": TRUCK.corner_angle,
        "phi": paper.ANGLE + TRUCK.corner_angle,
        "beta": math.atan2(1.0, paper.FRICTION),
        "corner_radius": TRUCK.corner_radius,
        "moment_of_inertia": TRUCK.moment_of_inertia,
    }
    unit = stages(1.0).stage1  # velocities are proportional to the speed
    implied = paper.START["corner_speed"] / unit.corner_speed
    return {"derived": derived, "starts": starts, "implied_speed": implied}


def table_3() -> Numbers:
    """Compute both columns of Table 3.

    Motions begin at the printed start. analytical: that column beside "drag" at the tail-slap; analytical_56: from
    Stage 1 at 56 mph, theta_0 as printed; analytical_15: from theta_0 = 15 degrees, not rounded. abaqus: its column
    beside "none" at the tail-slap; abaqus_read: at `reading` [s], four decimals of the instant at which the corner has
    slid as far as printed; abaqus_drag: beside "drag" at the instant at which it has. crossing: t [s] and slide [m]
    where "drag" has the printed v_GX. v_gx_25: v_GX without friction for v_P0 = 25 m/s as in Table 2 [m/s]. peak_force:
    beside that of the printed v_GY, for a pulse of 0.1 s [N].
    """
    drag, none = printed_motion("drag"), printed_motion("none")
    reading = round(instant(none, "slide", paper.ABAQUS["slide"]), 4)
    crossing = drag.at(instant(drag, "v_gx", paper.ABAQUS["v_gx"]))
    columns = {
        "analytical": (paper.ANALYTICAL, drag.strike),
        "analytical_56": (paper.ANALYTICAL, stages(start_angle=paper.START["angle"]).strike),
        "analytical_15": (paper.ANALYTICAL, stages().strike),
        "abaqus": (paper.ABAQUS, none.strike),
        "abaqus_read": (paper.ABAQUS, none.at(reading)),
        "abaqus_drag": (paper.ABAQUS, drag.at(instant(drag, "slide", paper.ABAQUS["slide"]))),
    }
    cells = {
        name: {key: beside(value, getattr(state, key)) for key, value in printed.items()}
        for name, (printed, state) in columns.items()
    }
    speeds = paper.ANALYTICAL["v_gy"], drag.strike.v_gy
    forces = (solver.strike_force(paper.MASS, v, paper.PULSE).peak_force for v in speeds)
    return cells | {
        "reading": reading,
        "slide_at_printed_time": float(none.at(paper.ABAQUS["t"]).slide),
        "crossing": [float(crossing.t), float(crossing.slide)],
        "v_gx_25": float(printed_motion("none", paper.FEA_SPEED).strike.v_gx),
        "peak_force": beside(*forces),
    }


def instant(motion: solver.PlaneMotion, name: str, value: float) -> float:
    """Return the instant [s] of a value of a monotonic quantity.

    It is computed by bisection.
    """
    low, high = 0.0, motion.strike.t
    rising = getattr(motion.strike, name) > float(getattr(motion.at(0.0), name))
    for _ in range(60):
        middle = 0.5 * (low + high)
        before = (float(getattr(motion.at(middle), name)) < value) == rising
        low, high = (middle, high) if before else (low, middle)
    return 0.5 * (low + high)


def figures() -> Numbers:
    """Compute the values that the paper reads from Figures 10 to 14.

    instants: those of the table of the page [s].
    """
    drag = printed_motion()
    charts = [
        (10, "t", "θ = 0", paper.CHART_TIME, drag.strike.t),
        (11, "v_gy", f"t = {paper.CHART_TIME} s", paper.CHART_V_GY, float(drag.at(paper.CHART_TIME).v_gy)),
    ]
    at_end = [(number, name) for number, name in FIGURES.items() if name in paper.ANALYTICAL]
    charts += [(n, name, "θ = 0", paper.ANALYTICAL[name], getattr(drag.strike, name)) for n, name in at_end]
    readings = [
        {"figure": number, "quantity": name, "where": where, "value": beside(*values)}
        for number, name, where, *values in charts
    ]
    return {"instants": [*ROUND_TIMES, drag.strike.t], "readings": readings}


def course(reaction: str, instants: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Return columns t [s] and those of FIGURES of a motion, SI.

    instants [s]: by default evenly spaced up to the tail-slap.
    """
    motion = printed_motion(reaction)
    t = np.linspace(0.0, motion.strike.t, INSTANTS) if instants is None else instants
    states = motion.at(t)
    return {"t": t, **{name: np.asarray(getattr(states, name)) for name in FIGURES.values()}}


def marks(name: str) -> dict[str, tuple[tuple[float, float], ...]]:
    """Return the printed points (t [s], value) of a quantity.

    The quantity is one of FIGURES, in SI. Points are those of the start, and of the columns of Table 3.
    """
    starts = {"theta": paper.START["angle"], "omega": paper.START["omega"], "slide": 0.0}
    analytical = [(0.0, starts[name])] if name in starts else []
    analytical.append(
        (paper.CHART_TIME, 0.0) if name == "theta" else (paper.ANALYTICAL["t"], paper.ANALYTICAL[name])
    )
    return {
        "paper": tuple(analytical),
        "ABAQUS": ((paper.ABAQUS["t"], paper.ABAQUS[name]),) if name in paper.ABAQUS else (),
    }


def force_row(row: paper.ForceRow, speed: float = MASH_SPEED, angle: float = paper.ANGLE) -> Numbers:
    """Compute a row of Table 4 or 5.

    speed [m/s]; angle [rad]; pairs for e = 0.22 and e = 0. peak [N]; factor: phi_a. ratio: printed F(e = 0)/F(e = 0.22)
    beside the exact 1/(1 - e). rounds: True if rounding of the printed forces explains that ratio. factor_of_print:
    printed forces of the row over its measured one. impulse: F dt/2 of the printed force for e = 0.22 [N s].
    """
    computed = [stages(speed, angle, e, duration=row.duration).peak_force for e in paper.RESTITUTIONS]
    elastic, plastic = row.peak
    exact, half = 1.0 / (1.0 - paper.RESTITUTION), 500.0  # forces are printed to the kilonewton
    return {
        "printed": row._asdict(),
        "peak": [beside(*pair) for pair in zip(row.peak, computed, strict=True)],
        "factor": [
            beside(factor, force / row.measured) for factor, force in zip(row.factor, computed, strict=True)
        ],
        "ratio": beside(plastic / elastic, exact),
        "rounds": (plastic - half) / (elastic + half) <= exact <= (plastic + half) / (elastic - half),
        "factor_of_print": [force / row.measured for force in row.peak],
        "impulse": 0.5 * elastic * row.duration,
    }


def earlier_methods() -> Numbers:
    """Compute the forces of earlier methods (Section 2.1).

    Olson, Hirsch and Ritter, at 56 mph and 15 degrees: inputs, travel [m], time [s], forces [N]. Assumed: centre of
    mass at half the length, Olson's B half the width, a rigid barrier, D = 0. olson_first_member: the average force by
    the first member of Eq 1, V sin(theta)/(2 g t), half of its last. paper: that of the tail-slap.
    """
    inputs = {"speed": MASH_SPEED, "angle": paper.ANGLE, "front_distance": paper.LENGTH / 2.0}
    inputs |= {"half_width": paper.WIDTH / 2.0, "deflection": 0.0}
    olson = solver.olson_force(paper.MASS, *inputs.values())
    average = olson.average_force
    return inputs | {
        "travel": olson.travel,
        "time": olson.time,
        "olson": average,
        "olson_first_member": 0.5 * average,
        "hirsch": solver.hirsch_force(average),
        "ritter": solver.ritter_force(paper.MASS, *inputs.values()).peak_force,
        "paper": stages().peak_force,
    }


def reaction() -> Numbers:
    """Return the reaction N of the wall on the vehicle [N].

    Friction is "drag", from the printed start; a negative reaction is tension. first, last: at the start and at the
    tail-slap; largest: the largest algebraic value.
    """
    motion = printed_motion()
    normal = motion.at(np.linspace(0.0, motion.strike.t, INSTANTS)).reaction_normal
    return {"first": float(normal[0]), "last": motion.strike.reaction_normal, "largest": float(normal.max())}


def restitutions() -> dict[str, Numbers]:
    """Compute both definitions of restitution at 56 mph.

    They are "paper" (Eq 24) and "newton", and e = 0, where they agree. corner_recoil: velocity of the corner across the
    wall after Stage 1 [m/s], negative into the wall, v_Py = F sin(beta)/m - v_0 sin(theta) + omega_1 r cos(phi), Eq 21;
    change: of the peak force relative to "paper".
    """
    cases = {name: stages(convention=name) for name in solver.CONVENTIONS}
    cases["e = 0"] = stages(restitution=0.0)
    results = {}
    for name, (stage1, _, peak_force) in cases.items():
        normal = stage1.impulse * math.sin(math.atan2(1.0, paper.FRICTION)) / paper.MASS
        turning = stage1.omega * TRUCK.corner_radius * math.cos(paper.ANGLE + TRUCK.corner_angle)
        results[name] = {
            "corner_recoil": normal - MASH_SPEED * math.sin(paper.ANGLE) + turning,
            "omega": stage1.omega,
            "peak_force": peak_force,
            "change": peak_force / cases["paper"].peak_force - 1.0,
        }
    return results


def whole_impact() -> Numbers:
    """Compute the whole impact, and the corresponding values of the stages.

    The vehicle is rigid, the contact unilateral. `share`, `share_friction`: m_eff/m of the rear corner at angle zero,
    without and with friction. plastic_impulse: m |v_GY| of the paper for e = 0; corner_impulse: that of the rear
    corner, m_eff 2 |v_GY|. paper_impulse: m |v_GY| for e = 0.22, at paper_time. omegas: after Stage 1 by "paper" and
    "newton"; nearly_rigid: by the crush law.
    """
    elastic, plastic, newton = stages(), stages(restitution=0.0), stages(convention="newton")
    stopped = paper.MASS * abs(plastic.strike.v_gy)
    return {
        "cases": [impact_case(stiffness) for stiffness in STIFFNESSES],
        "share": corner_fraction(0.0),
        "share_friction": corner_fraction(paper.FRICTION),
        "plastic_impulse": stopped,
        "corner_impulse": 2.0 * corner_fraction(0.0) * stopped,
        "paper_impulse": paper.MASS * abs(elastic.strike.v_gy),
        "paper_time": elastic.strike.t,
        "omegas": {"paper": elastic.stage1.omega, "newton": newton.stage1.omega},
        "nearly_rigid": float(impact_motion(NEARLY_RIGID, end=0.05).end.omega),
    }


def corner_fraction(friction: float) -> float:
    """Return m_eff/m of the rear corner.

    The vehicle is a uniform rectangle with its side along the wall. 1/m_eff = 1/m + (L/2) (L/2 + mu B/2)/I with I = m
    (L^2 + B^2)/12.
    """
    length, width = paper.LENGTH, paper.WIDTH
    return 1.0 / (1.0 + 3.0 * length * (length + friction * width) / (length**2 + width**2))


def impact_motion(stiffness: float, end: float | None = None) -> ImpactMotion:
    """Solve the impact of the rigid truck, to `end` [s].

    Contact is at the corners alone, with e and friction as printed.
    """
    contact = WallContact(CrushLaw(stiffness, 0.0, paper.RESTITUTION), paper.FRICTION)
    start = first_touch(IMPACT_TRUCK, paper.ANGLE, MASH_SPEED)
    return solve_impact(IMPACT_TRUCK, contact, start, end, after_second=0.2)


def impact_case(stiffness: float) -> Numbers:
    """Compute the whole impact with one stiffness.

    omega: after the first strike; released: its end. rear_...: of the strike of the rear corner; closing: speed of that
    corner into the wall at its start; `share`: impulse over (1 + e) m closing. read: duration of the second strike from
    minimum to minimum, by curve. gap: largest distance of the crushed front corner from the wall before the rear one
    strikes; back: its next contact, NaN without one.
    """
    motion = impact_motion(stiffness)
    front, rear = (next(s for s in motion.strikes if s.corner == name) for name in ("front", "rear"))
    again = [s.start for s in motion.strikes if s.corner == "front" and s.start > rear.start]
    instants = np.linspace(front.end, rear.start, 101)
    crush = motion.contact_depths(instants)[0]
    closing = rear_speed(motion, rear.start)
    curves = rigid_answer(motion, INTERVAL * np.arange(int(motion.t_end / INTERVAL) + 1)).second_strike
    return {
        "stiffness": stiffness,
        "omega": float(motion.at(instants[50]).omega),
        "released": front.end,
        "rear_start": rear.start,
        "rear_duration": rear.duration,
        "rear_peak": rear.peak_force,
        "rear_impulse": rear.impulse,
        "closing": closing,
        "share": rear.impulse / ((1.0 + paper.RESTITUTION) * paper.MASS * closing),
        "read": {name: curve["duration"] for name, curve in curves.items()},
        "gap": float(crush[0] - crush.min()),
        "back": again[0] if again else math.nan,
    }


def rear_speed(motion: ImpactMotion, instant: float) -> float:
    """Return the speed of the rear corner into the wall [m/s]."""
    at, size = motion.at(instant), motion.vehicle
    along, across = size.front_distance - size.length, -0.5 * size.width
    ahead = along * math.cos(float(at.theta)) + across * math.sin(float(at.theta))
    return -float(at.v_gy) - float(at.omega) * ahead
