"""Figures of a whole impact's report."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from postprocess.figures import impact
from postprocess.figures.animation import SIZE, from_above, write_animation
from postprocess.figures.impact import Forces, StrikeMark
from postprocess.figures.positions import draw_positions, vehicle_outlines
from postprocess.svg.chart import Chart
from postprocess.units import SI, Units
from solver.impact import ImpactVehicle
from tailslap import progress
from tailslap.case.impact import answers
from tailslap.case.impact.run import ImpactOutcome

PARTS = {
    "crush_energy": "crush, lost",
    "friction_work": "friction",
    "damping_work": "damping",
    "tyre_work": "tyres",
    "contact_energy": "crush, stored",
    "strain_energy": "strain",
    "hourglass_energy": "hourglass control",
    "wall_energy": "wall",
}
"""Labels of the energy by column. Works are those on the plate, and have the opposite sign."""

INSTANTS = 9
"""Number of drawn positions of the vehicle, besides those of the strikes."""


def marks(answer: answers.ImpactAnswer) -> list[StrikeMark]:
    """Return the marks of the strikes in figures."""
    t, x = answer.history["t"], answer.history["x_g"]

    def place(strike_position: float, instant: float, middle: float) -> float:
        return strike_position + float(np.interp(instant, t, x) - np.interp(middle, t, x))

    drawn = []
    for strike in answer.strikes:
        middle = 0.5 * (strike.start + strike.end)
        places = (place(strike.position, strike.start, middle), place(strike.position, strike.end, middle))
        drawn.append(StrikeMark(strike.corner.removesuffix(" far side"), strike.start, strike.end, places))
    return drawn


def outlines(answer: answers.ImpactAnswer, vehicles: Sequence[ImpactVehicle]) -> np.ndarray:
    """Return the vehicle's corners at every row [m].

    Shape (rows, 4, 2); for a train one line about all its units.
    """
    units = answers.places(answer.history, vehicles)
    right_side, left_side = list[np.ndarray](), list[np.ndarray]()
    for k, place in enumerate(units, 1):
        corners = vehicle_outlines(*place)
        ahead, behind = 0.5 * (corners[:, 0] + corners[:, 3]), 0.5 * (corners[:, 1] + corners[:, 2])
        for side, ends in ((right_side, (0, 1)), (left_side, (3, 2))):
            side += [] if k == 1 else [ahead]
            side += [corners[:, end] for end in ends] + ([behind] if k < len(units) else [])
    return np.stack([*right_side, *left_side[::-1]], axis=1)


def position_strip(answer: answers.ImpactAnswer, vehicles: Sequence[ImpactVehicle]) -> Chart:
    """Draw positions and motion of the vehicle.

    A train is drawn at the start of each strike, a single vehicle at uniform instants.
    """
    t = answer.history["t"]
    rows = np.unique(np.linspace(0, t.size - 1, INSTANTS).astype(int))
    if answer.units > 1:
        rows = np.unique(np.searchsorted(t, [*(strike.start for strike in answer.strikes), t[-1]]))
    corners = outlines(answer, vehicles)
    return draw_positions(corners[rows], t[rows], marks(answer), motion=(t, corners))


def force_figure(outcome: ImpactOutcome, levels: dict[str, float]) -> Chart:
    """Draw the raw and filtered forces of plate and rigid vehicle."""
    fe, rigid = outcome.fe, outcome.rigid
    of_rigid = {name: rigid.lateral[name] for name in impact.SHOWN}
    components = (
        Forces("lateral force on the wall", fe.history["t"][1:], fe.lateral),
        Forces("lateral force on the wall", rigid.history["t"][1:], of_rigid, ", rigid"),
        Forces("longitudinal force", fe.history["t"][1:], fe.longitudinal),
    )
    caption = "Force on the wall by filter, FE and rigid vehicle; upright line: instant of the animation"
    caption += "; lines across: design forces" if levels else ""
    return impact.draw_forces(caption, components, marks(fe), levels, fe.history["t"])


def train_figures(outcome: ImpactOutcome) -> list[Chart]:
    """Draw forces of units, and forces and angles of hinges.

    There are none for a single vehicle.
    """
    h, strikes, units = outcome.fe.history, marks(outcome.fe), range(1, outcome.fe.units + 1)
    hinges, t = units[:-1], h["t"]
    if not hinges:
        return []
    pushes = {f"unit {k}": h[f"force_normal_{k}"] / 1e3 for k in units}
    drags = {f"unit {k}": -h[f"force_tangential_{k}"] / 1e3 for k in units}
    forces, angles = {}, {}
    for model, columns in (("FE", h), ("rigid", outcome.rigid.history)):
        for k in hinges:
            pulled = np.hypot(columns[f"hinge_force_x_{k}"], columns[f"hinge_force_y_{k}"])
            forces[f"hinge {k}, {model}"] = pulled / 1e3
            angles[f"hinge {k}, {model}"] = np.degrees(columns[f"articulation_{k}"])
    return [
        impact.draw_curves(name, caption, axis, t, curves, strikes)
        for name, caption, axis, curves in (
            ("force_units", "Lateral force on the wall by unit, FE", "force [kN]", pushes),
            ("drag_units", "Longitudinal force on the wall by unit, FE", "force [kN]", drags),
            ("hinge_force", "Force of the hinges, unfiltered", "force [kN]", forces),
            ("articulation", "Articulation angle", "angle [deg]", angles),
        )
    ]


def energy_figure(outcome: ImpactOutcome) -> Chart:
    """Draw the parts of the energy over time."""
    h = outcome.run.history
    parts = {label: (-h[key] if key.endswith("work") else h[key]) for key, label in PARTS.items() if key in h}
    return impact.draw_energies(h["t"], h["kinetic_energy"], parts, marks(outcome.fe))


def contact_figures(outcome: ImpactOutcome) -> tuple[list[Chart], list[Chart]]:
    """Draw force over crush of each group, and force along the side.

    The latter requires a group of several points; for a train it is that of the first unit.
    """
    run, case = outcome.run, outcome.fe_plan.case
    loops = {}
    for i in np.unique(run.group):
        pressed = [k for k in np.flatnonzero(run.group == i) if run.normal[:, k].any()]
        if pressed:
            k = max(pressed, key=lambda k: run.normal[:, k].max())
            loops[case.names[i]] = (np.maximum(run.depth[:, k], 0.0), run.normal[:, k])
    along = []
    if np.bincount(run.group).max() > 1:
        side = np.flatnonzero((run.points[1] < 0.5 * case.vehicle.width) & (run.unit == 0))
        order = side[np.argsort(-run.points[0, side], kind="stable")]
        distances, places = np.unique(np.round(-run.points[0, order], 9), return_inverse=True)
        force = np.zeros((len(run.normal), distances.size))
        np.add.at(force.T, places, run.normal[:, order].T / 1e3)
        along.append(impact.draw_side_force(run.history["t"], distances, force, marks(outcome.fe)))
    return [impact.draw_loops(loops)] if loops else [], along


def animation(
    outcome: ImpactOutcome, folder: Path, units: Units = SI, size: tuple[int, int] | None = None
) -> Path:
    """Write the impact as a GIF.

    units: of the axes; size [pixels].
    """
    h = outcome.run.history
    with progress.announced("Drawing the animation ..."):
        views = (from_above(outlines(outcome.fe, outcome.fe_plan.case.vehicles)),)
        return write_animation(folder / "impact.gif", h["t"], views, h["force_normal"], units, size or SIZE)
