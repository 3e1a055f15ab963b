"""Charts of a vehicle in space that strikes a wall.

The vehicle from behind and from above at one instant, height of the force, and angles with lifted wheels over time. A
history has the columns of the solver by name, shape (rows,) each: x_g, y_g, z_g, yaw, pitch and roll of the first
unit, of later units with "_2" and so on; load_right_1, load_left_1, heave_1 and axle_roll_1 of the first axle. Points
of a unit at rest are (x, y, z): ahead of its front, to the left of its middle, and above the ground [m].
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from postprocess.figures import histories
from postprocess.figures.animation import View, frame_of, wall_outline
from postprocess.figures.positions import arrow, plan_view
from postprocess.svg import chart
from postprocess.svg.areas import Boxes, Outline, area
from postprocess.svg.chart import Axis, Chart
from postprocess.svg.marks import Level, Line, Mark, Swatch, Words, dot, line_style
from postprocess.svg.motion import Cursor, Moving
from postprocess.svg.scales import Floats, even_rows
from postprocess.units import measure

History = Mapping[str, Floats]

GROUP, WIDTH = "Vehicle in space", 400.0
"""Heading of the charts, and width of a drawing to scale, whose letters shrink on narrow screens [pixels]."""

EDGE, DEPTH, WHEEL, ARROW = 0.3, 2.0, 0.3, 0.8
"""Margin, least depth of the wall, width of a wheel, and length of the arrow of the force [m]."""

LEAST = 0.05
"""Force below which its height is not drawn, over the largest."""

COLOURS = ("fe", "rigid", "green", "violet")
"""Colours of the units."""

SIDES = ("right", "left")
"""Sides of an axle by -1 and 1 times its y."""


class DrawnUnit(NamedTuple):
    """Body of a unit.

    Mass with axles [kg]; its centre behind the front and above the ground; lower and upper edge of the drawn box [m].
    """

    length: float
    width: float
    mass: float
    centre: float
    centre_height: float
    low: float
    top: float


class DrawnAxle(NamedTuple):
    """Axle of a unit.

    Place behind the front, track, height of the axle and of its roll centre at rest [m]; mass [kg].
    """

    unit: int
    position: float
    track: float
    radius: float
    roll_centre: float
    mass: float


class DrawnStrip(NamedTuple):
    """Line that can touch the wall.

    Both ends behind the front of its unit and above the ground, and inwards from its side [m]; axle: -1 for the body.
    """

    unit: int
    axle: int
    at: tuple[float, float]
    height: tuple[float, float]
    inset: float


class DrawnVehicle(NamedTuple):
    """Vehicle and the face of the wall.

    face: line from [0, 0] to the upper edge, points (y, z) [m].
    """

    units: tuple[DrawnUnit, ...]
    axles: tuple[DrawnAxle, ...]
    strips: tuple[DrawnStrip, ...]
    face: Floats


def column(history: History, name: str, unit: int) -> Floats:
    """Return a column of a unit, counted from 0."""
    return history[name if unit == 0 else f"{name}_{unit + 1}"]


def moved(
    vehicle: DrawnVehicle, history: History, unit: int, points: Sequence[Sequence[float]], axle: int = -1
) -> Floats:
    """Return positions of points of a unit at every row.

    points: positions at rest, shape (points, 3) [m]; axle: number of the axle to which they belong, -1 for the body.
    Returns shape (rows, points, 3) [m].
    """
    body, still = vehicle.units[unit], np.array(points, dtype=float)
    place = np.stack([column(history, name, unit) for name in ("x_g", "y_g", "z_g")], axis=-1)[:, None]
    centre = np.zeros_like(place) + np.array([-body.centre, 0.0, body.centre_height])
    for number, part in enumerate(vehicle.axles):
        if part.unit == unit:
            at_rest = np.array([(-part.position, 0.0, part.radius)])
            centre += part.mass / body.mass * (_with_axle(part, history, number, at_rest) - at_rest)
    local = _with_axle(vehicle.axles[axle], history, axle, still) if axle >= 0 else still
    return np.asarray(place + np.einsum("rij,rpj->rpi", _rotation(history, unit), local - centre))


def _with_axle(axle: DrawnAxle, history: History, number: int, points: Floats) -> Floats:
    """Return points of an axle in the axes of its unit."""
    heave, roll = (history[f"{name}_{number + 1}"][:, None] for name in ("heave", "axle_roll"))
    x, y, z = points.T - np.array([[0.0], [0.0], [axle.roll_centre]])
    s, c = np.sin(roll), np.cos(roll)
    return np.stack([x + 0.0 * heave, y * c - z * s, axle.roll_centre + heave + y * s + z * c], axis=-1)


def _rotation(history: History, unit: int) -> Floats:
    """Return the rotation matrices of a unit, shape (rows, 3, 3).

    Yaw is first, then pitch, then roll.
    """
    angles = [column(history, name, unit) for name in ("yaw", "pitch", "roll")]
    (cy, sy), (cp, sp), (cr, sr) = ((np.cos(angle), np.sin(angle)) for angle in angles)
    rows = [
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def box(vehicle: DrawnVehicle, history: History, unit: int) -> Floats:
    """Return the corners of a body, shape (rows, 8, 3) [m].

    Those of the rear face come first: lower right, lower left, upper left, upper right.
    """
    body, half = vehicle.units[unit], 0.5 * vehicle.units[unit].width
    face = ((-half, body.low), (half, body.low), (half, body.top), (-half, body.top))
    return moved(vehicle, history, unit, [(x, *corner) for x in (-body.length, 0.0) for corner in face])


def wheel(vehicle: DrawnVehicle, history: History, number: int, side: int, above: bool = False) -> Floats:
    """Return the outline of a wheel from behind or from above.

    side: -1 for the right one, 1 for the left one. Returns shape (rows, 4, 3) [m].
    """
    axle = vehicle.axles[number]
    out, inner = (side * 0.5 * axle.track + 0.5 * part * WHEEL for part in (1.0, -1.0))
    ends = [(axle.radius, 0.0), (-axle.radius, 0.0)] if above else [(0.0, axle.radius), (0.0, -axle.radius)]
    (x0, z0), (x1, z1) = ((-axle.position + along, axle.radius + up) for along, up in ends)
    points = [(x0, out, z0), (x0, inner, z0), (x1, inner, z1), (x1, out, z1)]
    return moved(vehicle, history, axle.unit, points, number)


def draw_elevation(vehicle: DrawnVehicle, history: History, row: int, force: float, height: float) -> Chart:
    """Draw the unit with the largest roll in a row, from behind.

    force: largest 50 ms mean of the lateral force [N]; height: of its line of action [m].
    """
    state = {name: values[row : row + 1] for name, values in history.items()}
    unit = leaning_unit(vehicle, state)
    corners, roll = box(vehicle, state, unit)[0, :, 1:], float(column(state, "roll", unit)[0])
    low, high = corners.min(axis=0) - EDGE, corners.max(axis=0) + EDGE
    edge, top = vehicle.face[-1]
    low = np.minimum(low, (edge - DEPTH, -EDGE))
    high = np.maximum(high, (EDGE, top + EDGE))
    marks = [
        Line("", np.array([0.0, high[0]]), np.zeros(2), "ink", 1.4),
        area(np.array([*vehicle.face, (low[0], top), (low[0], 0.0)]), "grey", 0.25),
        *_force_marks(vehicle.face, force, height),
        *_far_marks(corners[4:], corners[:4]),
        *_axle_marks(vehicle, state, unit, (1, 2)),
        area(corners[:4], "fe", 0.12),
        *_strip_marks(vehicle, state, unit),
        *_centre_mark(state, unit, ("y_g", "z_g")),
    ]
    name = f"Unit {unit + 1}" if len(vehicle.units) > 1 else "Vehicle"
    caption = (
        f"{name} from behind at its largest roll, {measure(roll, 'rad', '.1f')} at {float(state['t'][0]):.2f} s, rear "
        "face bold and front face thin; arrow: largest 50 ms mean of the lateral force, at the height of its resultant"
    )
    plot = chart.Plot(tuple(marks), Axis("Z [m]", low[1], high[1]), None, "xy", has_grid=False)
    return chart.Chart("space_elevation", caption, (plot,), Axis("Y [m]", high[0], low[0]), GROUP, WIDTH)


def draw_plan(vehicle: DrawnVehicle, history: History, row: int) -> Chart:
    """Draw all units in a row from above."""
    state = {name: values[row : row + 1] for name, values in history.items()}
    marks = list[Mark]()
    corners = [box(vehicle, state, unit)[0, :, :2] for unit in range(len(vehicle.units))]
    for unit, (body, corner) in enumerate(zip(vehicle.units, corners, strict=True)):
        marks += _axle_marks(vehicle, state, unit, (0, 1))
        floor, roof = corner[[0, 1, 5, 4]], corner[[3, 2, 6, 7]]
        marks += [*_far_marks(roof, floor), area(floor, "fe", 0.12)]
        centre, speed = (
            np.array([column(state, name, unit)[0] for name in names])
            for names in (("x_g", "y_g"), ("v_gx", "v_gy"))
        )
        along = speed / (float(np.linalg.norm(speed)) or 1.0)
        marks += [
            *_centre_mark(state, unit, ("x_g", "y_g")),
            *arrow(centre, centre + 0.3 * body.length * along, body.length),
        ]
    outline = np.concatenate(corners)
    frame = np.array([outline.min(axis=0) - EDGE, outline.max(axis=0) + EDGE])
    frame[0, 1] = min(frame[0, 1], vehicle.face[-1, 0] - EDGE)
    marks.insert(0, Line("", frame[:, 0], np.full(2, vehicle.face[-1, 0]), "soft", 1.0))
    caption = (
        f"Vehicle from above at {float(state['t'][0]):.2f} s, lower edge of the body bold and upper edge thin; arrow: "
        "direction of travel; grey: wall, its toe and its upper edge"
    )
    return plan_view("space_plan", caption, marks, frame, GROUP, ("X along the wall [m]", "Y [m]"), WIDTH)


def leaning_unit(vehicle: DrawnVehicle, history: History) -> int:
    """Return the unit with the largest roll."""
    rolls = [float(np.abs(column(history, "roll", unit)).max()) for unit in range(len(vehicle.units))]
    return int(np.argmax(rolls))


def _far_marks(far: Floats, near: Floats) -> list[Mark]:
    """Return the far face of a body and the connecting edges."""
    edges = np.stack([far, near, np.full_like(far, np.nan)], axis=1).reshape(-1, 2)
    return [Outline(far[:, 0], far[:, 1], "fe", 0.5, 0.03), Line("", edges[:, 0], edges[:, 1], "steel", 0.6)]


def _axle_marks(vehicle: DrawnVehicle, state: History, unit: int, plane: tuple[int, int]) -> list[Mark]:
    """Return beams and wheels of a unit.

    Wheels off the ground are red.
    """
    marks = list[Mark]()
    for number, axle in enumerate(vehicle.axles):
        if axle.unit != unit:
            continue
        ends = [(-axle.position, side * 0.5 * axle.track, axle.radius) for side in (-1.0, 1.0)]
        beam = moved(vehicle, state, unit, ends, number)[0][:, plane]
        marks.append(Line("", beam[:, 0], beam[:, 1], "soft", 2.0))
        for side, name in zip((-1, 1), SIDES, strict=True):
            is_lifted = state[f"load_{name}_{number + 1}"][0] <= 0.0
            outline = wheel(vehicle, state, number, side, plane == (0, 1))[0][:, plane]
            marks.append(area(outline, "red" if is_lifted else "soft", 0.6))
    return [*marks, Swatch("wheel on the ground", "soft"), Swatch("off the ground", "red")]


def _strip_marks(vehicle: DrawnVehicle, state: History, unit: int) -> list[Mark]:
    """Return the strips on the wall side of a unit, from behind."""
    marks = list[Mark]()
    for strip in vehicle.strips:
        if strip.unit == unit:
            y = strip.inset - 0.5 * vehicle.units[unit].width
            ends = [(-at, y, height) for at, height in zip(strip.at, strip.height, strict=True)]
            _, across, up = moved(vehicle, state, unit, ends, strip.axle)[0].T
            marks.append(Line("strips", across, up, "rigid", 2.4))
    return marks


def _centre_mark(state: History, unit: int, names: tuple[str, str]) -> list[Mark]:
    """Return the centre of mass of a unit with its name."""
    centre = np.array([column(state, name, unit)[0] for name in names])
    return [dot(centre, "ink", 3.0), Words("G", float(centre[0]), float(centre[1]), (6.0, 11.0))]


def _force_marks(face: Floats, force: float, height: float) -> list[Mark]:
    """Return the arrow of the force on the wall with its labels."""
    start = np.array([np.interp(height, face[:, 1], face[:, 0]), height])
    tip = start - (ARROW, 0.0)
    texts = (measure(force / 1e3, "kN", ".0f"), -2.0), (f"at {measure(height, 'm', '.2f')}", 11.0)
    return [
        *arrow(start, tip, 5.0, "difference"),
        *(Words(text, float(tip[0]), height, (5.0, down), "start", "difference") for text, down in texts),
    ]


def draw_force_height(t: Floats, force: Floats, moment: Floats, levels: Mapping[str, float]) -> Chart:
    """Draw the lateral force and the height of its resultant over time.

    t: even instants [s], shape (n + 1,); force [N] and moment [N m]: 50 ms means, shape (n,); levels: heights by
    name [m].
    """
    cursor, t = Cursor("", t), t[1:]
    pressed = force > LEAST * force.max(initial=0.0)
    height = np.where(pressed, moment / np.where(pressed, force, 1.0), np.nan)
    forces = Line("50 ms mean", *histories.thinned(t, force / 1e3), "fe", 1.8)
    rows = even_rows(t, 2 * histories.STRETCHES)
    heights = Line("height", t[rows], height[rows], "fe", 1.8)
    lines = [Level(name, round(level, 3), "soft") for name, level in levels.items()]
    plots = (
        chart.Plot((forces, cursor), Axis("lateral force [kN]", low=0.0), 130.0, has_legend=False),
        chart.Plot((*lines, heights, cursor), Axis("height of the resultant [m]", low=0.0), 130.0),
    )
    caption = (
        "50 ms mean of the lateral force on the wall, and height of its resultant where the force exceeds "
        f"{100 * LEAST:g} % of the largest"
    )
    return chart.Chart("space_force", caption, plots, histories.TIME, GROUP, chart.HALF)


def draw_angles(vehicle: DrawnVehicle, history: History, lifts: Sequence[Mapping[str, Any]]) -> Chart:
    """Draw roll, pitch and lifted wheels of each unit over time.

    lifts: intervals with wheels off the ground by "axle", from 1, "side" of `SIDES`, "start" and "duration" [s].
    """
    count, wheels = len(vehicle.units), [(axle, side) for axle in range(len(vehicle.axles)) for side in SIDES]
    plots = []
    for name, label in (("roll", "roll, to the wall [deg]"), ("pitch", "pitch, nose down [deg]")):
        drawn = list[Mark]()
        for unit in range(count):
            places = histories.thinned(history["t"], np.degrees(column(history, name, unit)))
            style = line_style(unit) | {"width": 1.8}
            text = f"unit {unit + 1}" if count > 1 else name
            drawn.append(Line(text, *places, COLOURS[unit % len(COLOURS)], **style))
        marks = (*drawn, Cursor("", history["t"]))
        plots.append(chart.Plot(marks, Axis(label), 120.0 if name == "roll" else 70.0, has_legend=count > 1))
    rows = np.array([wheels.index((lift["axle"] - 1, lift["side"])) for lift in lifts], dtype=float)
    times = np.array([(lift["start"], lift["start"] + lift["duration"]) for lift in lifts]).reshape(-1, 2)
    texts = [f"{end - start:.3f} s" for start, end in times.tolist()]
    at = [f"axle {lift['axle']} {lift['side']}, from {lift['start']:.3f} s" for lift in lifts]
    bars = Boxes("off the ground", times, rows[:, None] + (-0.35, 0.35), "red", texts, at)
    names = tuple((float(row), f"axle {axle + 1} {side}") for row, (axle, side) in enumerate(wheels))
    across = Axis("wheels off the ground", len(wheels) - 0.5, -0.5, named=names)
    plots.append(chart.Plot((bars,), across, 15.0 * len(wheels), "xy", has_grid=False, has_legend=False))
    caption = "Roll and pitch, and intervals with wheels off the ground"
    return chart.Chart("space_angles", caption, plots, histories.TIME, GROUP, chart.HALF)


def film_views(vehicle: DrawnVehicle, history: History) -> tuple[View, View]:
    """Return the views of an animation from behind and from above.

    The latter is centred on the first unit.
    """
    unit, axles = leaning_unit(vehicle, history), range(len(vehicle.axles))
    first = np.stack([history["x_g"], 0.0 * history["x_g"]], axis=-1)[:, None]
    faces = ([4, 5, 6, 7], [0, 4, 7, 3], [1, 5, 6, 2], [0, 1, 2, 3])
    behind = [
        wheel(vehicle, history, n, side) for n in axles if vehicle.axles[n].unit == unit for side in (-1, 1)
    ]
    corners = box(vehicle, history, unit)
    above = [box(vehicle, history, number)[:, [0, 1, 5, 4]] for number in range(len(vehicle.units))]
    above += [wheel(vehicle, history, n, side, above=True) for n in axles for side in (-1, 1)]
    elevation = tuple(outline[..., 1:] for outline in (*(corners[:, face] for face in faces), *behind))
    plan = tuple(outline[..., :2] - first for outline in above)
    return (
        View(elevation, vehicle.face, ("Y", "Z"), is_mirrored=True, fill=0.12),
        View(plan, np.zeros((1, 2)), ("X from G", "Y")),
    )


def draw_films(vehicle: DrawnVehicle, history: History) -> list[Chart]:
    """Animate the motion from behind and above."""
    names = {
        "space_behind": "Vehicle from behind, animated, ten times slower",
        "space_above": "Vehicle from above about its centre of mass, animated",
    }
    charts = []
    for (name, caption), view in zip(names.items(), film_views(vehicle, history), strict=True):
        low, high = frame_of(view)
        wall = area(wall_outline(view.face, low, high), "grey", 0.25)
        moving = (Moving("", history["t"], o[..., 0], o[..., 1], fill=view.fill) for o in view.outlines)
        ends = (high[0], low[0]) if view.is_mirrored else (low[0], high[0])
        across, up = (f"{axis} [m]" for axis in view.names)
        plot = chart.Plot((wall, *moving), Axis(up, low[1], high[1]), None, "xy", has_grid=False)
        charts.append(Chart(name, caption, (plot,), Axis(across, *ends), GROUP, WIDTH))
    return charts
