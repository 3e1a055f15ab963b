"""The paper's numbers computed beside printed, as nested dicts, SI throughout: what `tailslap paper --json` says.

A printed number and its own stand in a cell {"printed", "computed", "difference"}; difference: computed/printed - 1.
The paper gives neither mass nor speed nor length of the six vehicles of Tables 4 and 5, so that every row of these is
computed with the vehicle and impact of Table 1, at 56 mph, and differs from its neighbours by the pulse's duration.

The numbers that they print stand first, in SI, each with its place in the paper. Table 3 stands in
`postprocess.comparison`, whose v_GY carries this program's sign, negative towards the wall.
"""

import math
from typing import Any, NamedTuple

import numpy as np

import solver
from postprocess.comparison.quantities import PAPER_TABLE_3
from solver.impact import CrushLaw, ImpactMotion, ImpactVehicle, WallContact, first_touch, solve_impact
from tailslap.case.impact.answers import rigid_answer

PAPER = "B. Chuong and R. B. Malla, Infrastructures 2025, 10(11), 307"
MPH, KM_PER_HOUR = 0.44704, 1.0 / 3.6  # m/s


class Input(NamedTuple):
    """An input of the analysis: name, symbol and words; as the paper gives it; in SI with its unit; where."""

    name: str
    symbol: str
    title: str
    given: str
    value: float
    unit: str
    place: str = "Table 1"


INPUTS = (
    Input("speed", "V_I", "Impact speed", "90 km/h", 90.0 * KM_PER_HOUR, "m/s"),
    Input("angle", "θ", "Impact angle", "15 deg", math.radians(15.0), "rad"),
    Input("mass", "W", "Vehicle weight", "9979 kg", 9979.0, "kg"),
    Input("width", "B", "Vehicle width", "2438 mm", 2.438, "m"),
    Input("length", "L", "Vehicle length", "10,000 mm", 10.0, "m"),
    Input("friction", "μ_k", "Coefficient of friction", "0.47", 0.47, "", "Section 3.1.1"),
    Input("restitution", "e", "Coefficient of restitution", "0.22", 0.22, "", "Section 3.1.1"),
)
SPEED, ANGLE, MASS, WIDTH, LENGTH, FRICTION, RESTITUTION = (item.value for item in INPUTS)
START = {"angle": 0.26, "omega": 0.707, "corner_speed": 25.053}  # theta_0, omega_0, v_P0, Section 3.1.1
FEA_SPEED = 25.0  # m/s, V_x in Table 2, where Section 3.1.2 says 25,053 mm/s
LATERAL_SPEED = 23.3 * KM_PER_HOUR  # m/s, v_0 sin(theta) in Section 3.1.1
ANALYTICAL, ABAQUS = PAPER_TABLE_3["analytical"], PAPER_TABLE_3["abaqus"]  # Table 3
CHART_TIME, CHART_V_GY = 0.38, -3.274  # s, Figure 10 at theta = 0; m/s, Figure 11 then (Section 3.1.1)
PULSE = 0.1  # s, "a reasonable estimate ... in most cases" (Section 3.2)


class ForceRow(NamedTuple):
    """A row of Table 4 or 5; forces in N, pairs for e = 0.22 and e = 0.

    duration: of the second pulse [s]; measured: by crash test or finite elements; projected: 1.33 times the
    50 ms average, by the authors; peak: analytical, F_lat,peak; factor: adjustment factor phi_a.
    """

    row: str
    source: str
    duration: float
    measured: float
    peak: tuple[float, float]
    factor: tuple[float, float]
    projected: bool = False


SOURCES = {
    "a": "MwRSF TRP-03-415-21, crash test",
    "b": "MwRSF TRP-03-403-21, crash test",
    "c": "NCHRP 22-20(02), tall vertical wall, FEA",
    "d": "NCHRP 22-20(02), 42 in. barrier, FEA",
    "e": "TTI 9-1002-5, FEA",
    "f": "Cao et al., FEA",
}


def _row(
    row: str, duration: float, forces: tuple[float, ...], factor: tuple[float, float], projected: bool = False
) -> ForceRow:
    """A row of the forces in kN."""
    measured, elastic, plastic = (1e3 * force for force in forces)
    return ForceRow(row, SOURCES[row], duration, measured, (elastic, plastic), factor, projected)


TABLE_4 = (  # 50 ms average
    _row("a", 0.1, (680.0, 707.0, 898.5), (1.04, 1.32)),
    _row("b", 0.1, (595.0, 680.0, 872.0), (1.14, 1.46)),
    _row("c", 0.1, (415.0, 609.0, 783.0), (1.47, 1.89)),
    _row("d", 0.08, (351.0, 765.0, 978.0), (2.17, 2.78)),
    _row("e", 0.1, (360.0, 614.0, 796.0), (1.7, 2.21)),
    _row("f", 0.18, (375.0, 351.0, 440.0), (0.94, 1.17)),
)
TABLE_5 = (  # SAE-filtered
    _row("a", 0.1, (904.0, 707.0, 898.5), (0.78, 0.99), projected=True),
    _row("b", 0.1, (791.0, 680.0, 872.0), (0.86, 1.1), projected=True),
    _row("c", 0.1, (552.0, 609.0, 783.0), (1.1, 1.42), projected=True),
    _row("d", 0.08, (467.0, 765.0, 978.0), (1.64, 2.09), projected=True),
    _row("e", 0.1, (479.0, 614.0, 796.0), (1.28, 1.66), projected=True),
    _row("f", 0.16, (500.0, 396.0, 494.0), (0.79, 0.99)),
)
RESTITUTIONS = (RESTITUTION, 0.0)  # of the pairs in Tables 4 and 5
FACTOR_RANGE_PLASTIC = (1.32, 2.78)  # Section 3.2: phi_a of Table 4 for e = 0, "for those test conditions"

# Not in the paper: the test behind row b, MNCBR-1, as its report's abstract gives it.
ROW_B_SPEED, ROW_B_ANGLE, ROW_B_GIVEN = 57.4 * MPH, math.radians(15.4), "57.4 mph and 15.4 deg"


Cell = dict[str, float]
Numbers = dict[str, Any]

TRUCK = solver.RectangularBody(LENGTH, WIDTH, MASS)
IMPACT_TRUCK = ImpactVehicle(LENGTH, WIDTH, MASS)

MASH_SPEED = 56.0 * MPH
SPEEDS = {"56 mph": MASH_SPEED, "90 km/h": SPEED}
"""Speeds that the start may have been computed from [m/s]: MASH's for the truck, and its printed metric rounding."""

FIGURES = {10: "theta", 11: "v_gy", 12: "v_gx", 13: "omega", 14: "slide"}
"""The paper's number of a figure and the quantity in it."""

INSTANTS = 201
ROUND_TIMES = (0.0, 0.1, 0.2, 0.3)  # s; the tail-slap is added

STIFFNESSES = (1e6, 2e6, 3e6)
"""Crush stiffnesses of a corner [N/m], assumed: those of such a truck are not known."""

NEARLY_RIGID = 2e8
"""Stiffness that comes close to an instantaneous impact [N/m]."""

INTERVAL = 2e-4
"""Between the rows of force histories [s]."""


class Stages(NamedTuple):
    """Stages 1 to 3 of one impact; peak_force of the tail-slap [N] for a triangular pulse."""

    stage1: solver.ImpulseResult[float]
    strike: solver.MotionState[float]
    peak_force: float


def review() -> Numbers:
    """Compute all of it; under a second. row_b: row b of Tables 4 and 5 with its test's own speed and angle."""
    return {
        "table_1": table_1(),
        "table_3": table_3(),
        "figures": figures(),
        "table_4": [force_row(row) for row in TABLE_4],
        "table_5": [force_row(row) for row in TABLE_5],
        "row_b": [force_row(table[1], ROW_B_SPEED, ROW_B_ANGLE) for table in (TABLE_4, TABLE_5)],
        "earlier": earlier_methods(),
        "reaction": reaction(),
        "restitution": restitutions(),
        "whole_impact": whole_impact(),
    }


def beside(printed: float, computed: float) -> Cell:
    """The cell of a printed and a computed value, neither of them zero."""
    cell = {"printed": float(printed), "computed": float(computed)}
    return cell | {"difference": float(computed / printed - 1.0)}


def stages(
    speed: float = MASH_SPEED,
    angle: float = ANGLE,
    restitution: float = RESTITUTION,
    convention: str = "paper",
    duration: float = PULSE,
    start_angle: float | None = None,
) -> Stages:
    """All three stages for the truck of Table 1, friction as in Eqs 66-67.

    speed [m/s]; angle [rad]; duration of the pulse [s]; start_angle: that which Stage 2 starts from [rad], if it is not
    the impact's own.
    """
    stage1 = solver.corner_impulse(TRUCK, speed, angle, FRICTION, restitution, convention)
    theta_0 = angle if start_angle is None else start_angle
    strike = solver.tail_slap(TRUCK, theta_0, stage1.omega, stage1.corner_speed, FRICTION)
    return Stages(stage1, strike, solver.strike_force(MASS, strike.v_gy, duration).peak_force)


def printed_motion(reaction: str = "drag", corner_speed: float = START["corner_speed"]) -> solver.PlaneMotion:
    """Stage 2 from the start that the paper prints; corner_speed [m/s]."""
    return solver.plane_motion(TRUCK, START["angle"], START["omega"], corner_speed, FRICTION, reaction)


def table_1() -> Numbers:
    """Stage 1 from both speeds beside the printed start; implied_speed gives the printed v_P0 exactly [m/s].

    derived: gamma, phi, beta [rad]; r_PG [m]; I_G [kg m^2] (Eqs 7, 15, 26, 63).
    """
    starts = {}
    for name, speed in SPEEDS.items():
        stage1, _, peak_force = stages(speed)
        starts[name] = {
            "speed": speed,
            "omega": beside(START["omega"], stage1.omega),
            "corner_speed": beside(START["corner_speed"], stage1.corner_speed),
            "lateral_speed": beside(LATERAL_SPEED, speed * math.sin(ANGLE)),
            "impulse": stage1.impulse,
            "peak_force": peak_force,
        }
    derived = {
        "gamma": TRUCK.corner_angle,
        "phi": ANGLE + TRUCK.corner_angle,
        "beta": math.atan2(1.0, FRICTION),
        "corner_radius": TRUCK.corner_radius,
        "moment_of_inertia": TRUCK.moment_of_inertia,
    }
    unit = stages(1.0).stage1  # velocities are proportional to the speed
    implied = START["corner_speed"] / unit.corner_speed
    return {"derived": derived, "starts": starts, "implied_speed": implied}


def table_3() -> Numbers:
    """Both columns of Table 3 beside the exact motions from the printed start.

    analytical: that column beside "drag" at the tail-slap; analytical_56: from Stage 1 at 56 mph, theta_0 as printed;
    analytical_15: from theta_0 = 15 degrees, not rounded. abaqus: its column beside "none" at the tail-slap;
    abaqus_read: at `reading` [s], four decimals of the instant at which the corner has slid as far as printed;
    abaqus_drag: beside "drag" at the instant at which it has. crossing: t [s] and slide [m] where "drag" has the
    printed v_GX. v_gx_25: v_GX without friction had v_P0 been the 25 m/s of Table 2 [m/s]. peak_force: beside that of
    the printed v_GY, for a pulse of 0.1 s [N].
    """
    drag, none = printed_motion("drag"), printed_motion("none")
    reading = round(instant(none, "slide", ABAQUS["slide"]), 4)
    crossing = drag.at(instant(drag, "v_gx", ABAQUS["v_gx"]))
    columns = {
        "analytical": (ANALYTICAL, drag.strike),
        "analytical_56": (ANALYTICAL, stages(start_angle=START["angle"]).strike),
        "analytical_15": (ANALYTICAL, stages().strike),
        "abaqus": (ABAQUS, none.strike),
        "abaqus_read": (ABAQUS, none.at(reading)),
        "abaqus_drag": (ABAQUS, drag.at(instant(drag, "slide", ABAQUS["slide"]))),
    }
    cells = {
        name: {key: beside(value, getattr(state, key)) for key, value in printed.items()}
        for name, (printed, state) in columns.items()
    }
    forces = (solver.strike_force(MASS, v, PULSE).peak_force for v in (ANALYTICAL["v_gy"], drag.strike.v_gy))
    return cells | {
        "reading": reading,
        "slide_at_printed_time": float(none.at(ABAQUS["t"]).slide),
        "crossing": [float(crossing.t), float(crossing.slide)],
        "v_gx_25": float(printed_motion("none", FEA_SPEED).strike.v_gx),
        "peak_force": beside(*forces),
    }


def instant(motion: solver.PlaneMotion, name: str, value: float) -> float:
    """The instant [s] at which a quantity that changes one way throughout has this value; by bisection."""
    low, high = 0.0, motion.strike.t
    rising = getattr(motion.strike, name) > float(getattr(motion.at(0.0), name))
    for _ in range(60):
        middle = 0.5 * (low + high)
        before = (float(getattr(motion.at(middle), name)) < value) == rising
        low, high = (middle, high) if before else (low, middle)
    return 0.5 * (low + high)


def figures() -> Numbers:
    """Values that the paper reads off Figures 10 to 14, and where; instants: those of the page's table [s]."""
    drag = printed_motion()
    strike = drag.strike
    charts = [
        (10, "t", "θ = 0", CHART_TIME, strike.t),
        (11, "v_gy", f"t = {CHART_TIME} s", CHART_V_GY, float(drag.at(CHART_TIME).v_gy)),
    ]
    known = [(number, name) for number, name in FIGURES.items() if name in ANALYTICAL]
    charts += [(n, name, "θ = 0", ANALYTICAL[name], getattr(strike, name)) for n, name in known]
    readings = [
        {"figure": number, "quantity": name, "where": where, "value": beside(*values)}
        for number, name, where, *values in charts
    ]
    return {"instants": [*ROUND_TIMES, strike.t], "readings": readings}


def course(reaction: str, instants: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Columns t [s] and those of FIGURES, SI, at evenly spaced instants up to the strike, or at these."""
    motion = printed_motion(reaction)
    t = np.linspace(0.0, motion.strike.t, INSTANTS) if instants is None else instants
    states = motion.at(t)
    return {"t": t, **{name: np.asarray(getattr(states, name)) for name in FIGURES.values()}}


def marks(name: str) -> dict[str, tuple[tuple[float, float], ...]]:
    """Printed points (t [s], value in SI) of a quantity of FIGURES: the start's, and those of Table 3's columns."""
    starts = {"theta": START["angle"], "omega": START["omega"], "slide": 0.0}
    analytical = [(0.0, starts[name])] if name in starts else []
    analytical.append((CHART_TIME, 0.0) if name == "theta" else (ANALYTICAL["t"], ANALYTICAL[name]))
    return {"paper": tuple(analytical), "ABAQUS": ((ABAQUS["t"], ABAQUS[name]),) if name in ABAQUS else ()}


def force_row(row: ForceRow, speed: float = MASH_SPEED, angle: float = ANGLE) -> Numbers:
    """A row of Table 4 or 5 and what is computed for a speed [m/s] and an angle [rad]; pairs for e = 0.22 and e = 0.

    peak [N]; factor: phi_a. ratio: printed F(e = 0)/F(e = 0.22) beside the exact 1/(1 - e). rounds: whether rounding
    of the printed forces explains that ratio. factor_of_print: the row's own printed forces over its measured one.
    impulse: F dt/2 of the printed force for e = 0.22 [N s].
    """
    computed = [stages(speed, angle, e, duration=row.duration).peak_force for e in RESTITUTIONS]
    elastic, plastic = row.peak
    exact, half = 1.0 / (1.0 - RESTITUTION), 500.0  # forces are printed to the kilonewton
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
    """Olson, Hirsch and Ritter (Section 2.1) at 56 mph and 15 degrees: inputs, travel [m], time [s], forces [N].

    Assumed: centre of mass at half the length, Olson's B half the width, a rigid barrier, D = 0. olson_first_member:
    the average force by the first member of Eq 1, V sin(theta)/(2 g t), half of its last. paper: that of the tail-slap.
    """
    inputs = {"speed": MASH_SPEED, "angle": ANGLE, "front_distance": LENGTH / 2.0}
    inputs |= {"half_width": WIDTH / 2.0, "deflection": 0.0}
    olson = solver.olson_force(MASS, *inputs.values())
    average = olson.average_force
    return inputs | {
        "travel": olson.travel,
        "time": olson.time,
        "olson": average,
        "olson_first_member": 0.5 * average,
        "hirsch": solver.hirsch_force(average),
        "ritter": solver.ritter_force(MASS, *inputs.values()).peak_force,
        "paper": stages().peak_force,
    }


def reaction() -> Numbers:
    """The wall's reaction N on the vehicle, "drag" from the printed start [N]; negative: it pulls.

    first, last: at the start and at the tail-slap; largest: the one nearest to a push.
    """
    motion = printed_motion()
    normal = motion.at(np.linspace(0.0, motion.strike.t, INSTANTS)).reaction_normal
    return {"first": float(normal[0]), "last": motion.strike.reaction_normal, "largest": float(normal.max())}


def restitutions() -> dict[str, Numbers]:
    """Both signs of restitution, "paper" (Eq 24) and "newton", at 56 mph, and e = 0, where they are one.

    corner_recoil: the corner's velocity across the wall after Stage 1 [m/s], negative into the wall, v_Py =
    F sin(beta)/m - v_0 sin(theta) + omega_1 r cos(phi), Eq 21; change: of the peak force against the paper's sign.
    """
    cases = {name: stages(convention=name) for name in solver.CONVENTIONS}
    cases["e = 0"] = stages(restitution=0.0)
    found = {}
    for name, (stage1, _, peak_force) in cases.items():
        normal = stage1.impulse * math.sin(math.atan2(1.0, FRICTION)) / MASS
        turning = stage1.omega * TRUCK.corner_radius * math.cos(ANGLE + TRUCK.corner_angle)
        found[name] = {
            "corner_recoil": normal - MASH_SPEED * math.sin(ANGLE) + turning,
            "omega": stage1.omega,
            "peak_force": peak_force,
            "change": peak_force / cases["paper"].peak_force - 1.0,
        }
    return found


def whole_impact() -> Numbers:
    """The whole impact, rigid, on a wall that only pushes, and what the paper's stages have in its place.

    share, share_friction: m_eff/m of the rear corner at angle zero, without and with friction. plastic_impulse: m
    |v_GY| of the paper for e = 0; corner_impulse: that of the rear corner, m_eff 2 |v_GY|. paper_impulse: m |v_GY| for
    e = 0.22, paper_time: when. omegas: after Stage 1 by "paper" and "newton"; nearly_rigid: by the crush law.
    """
    paper, plastic, newton = stages(), stages(restitution=0.0), stages(convention="newton")
    stopped = MASS * abs(plastic.strike.v_gy)
    return {
        "cases": [impact_case(stiffness) for stiffness in STIFFNESSES],
        "share": corner_fraction(0.0),
        "share_friction": corner_fraction(FRICTION),
        "plastic_impulse": stopped,
        "corner_impulse": 2.0 * corner_fraction(0.0) * stopped,
        "paper_impulse": MASS * abs(paper.strike.v_gy),
        "paper_time": paper.strike.t,
        "omegas": {"paper": paper.stage1.omega, "newton": newton.stage1.omega},
        "nearly_rigid": float(impact_motion(NEARLY_RIGID, end=0.05).end.omega),
    }


def corner_fraction(friction: float) -> float:
    """m_eff/m of a uniform rectangle whose rear corner strikes, its side along the wall.

    1/m_eff = 1/m + (L/2) (L/2 + mu B/2)/I with I = m (L^2 + B^2)/12.
    """
    return 1.0 / (1.0 + 3.0 * LENGTH * (LENGTH + friction * WIDTH) / (LENGTH**2 + WIDTH**2))


def impact_motion(stiffness: float, end: float | None = None) -> ImpactMotion:
    """The rigid truck's impact, corners alone, e and friction as printed; to `end` [s]."""
    contact = WallContact(CrushLaw(stiffness, 0.0, RESTITUTION), FRICTION)
    start = first_touch(IMPACT_TRUCK, ANGLE, MASH_SPEED)
    return solve_impact(IMPACT_TRUCK, contact, start, end, after_second=0.2)


def impact_case(stiffness: float) -> Numbers:
    """The whole impact with one crush stiffness [N/m], SI.

    omega: after the first strike; released: its end. rear_...: of the rear corner's strike; closing: that corner's
    speed into the wall at its start; share: impulse over (1 + e) m closing. read: by curve, the second strike's
    duration from valley to valley. gap: how far the crushed front corner is from the wall at most before the rear one
    strikes; back: when it touches again, NaN if it does not.
    """
    found = impact_motion(stiffness)
    front, rear = (next(s for s in found.strikes if s.corner == name) for name in ("front", "rear"))
    again = [s.start for s in found.strikes if s.corner == "front" and s.start > rear.start]
    instants = np.linspace(front.end, rear.start, 101)
    crush = found.corner_depths(instants)[0]
    closing = rear_speed(found, rear.start)
    curves = rigid_answer(found, INTERVAL * np.arange(int(found.t_end / INTERVAL) + 1)).second_strike
    return {
        "stiffness": stiffness,
        "omega": float(found.at(instants[50]).omega),
        "released": front.end,
        "rear_start": rear.start,
        "rear_duration": rear.duration,
        "rear_peak": rear.peak_force,
        "rear_impulse": rear.impulse,
        "closing": closing,
        "share": rear.impulse / ((1.0 + RESTITUTION) * MASS * closing),
        "read": {name: curve["duration"] for name, curve in curves.items()},
        "gap": float(crush[0] - crush.min()),
        "back": again[0] if again else math.nan,
    }


def rear_speed(found: ImpactMotion, instant: float) -> float:
    """Speed of the rear corner into the wall at an instant [m/s]."""
    at, size = found.at(instant), found.vehicle
    along, across = size.front_distance - size.length, -0.5 * size.width
    ahead = along * math.cos(float(at.theta)) + across * math.sin(float(at.theta))
    return -float(at.v_gy) - float(at.omega) * ahead
