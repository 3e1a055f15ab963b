"""Figures of a whole impact's report, from its histories."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from postprocess.figures import impact
from postprocess.figures.animation import SIZE, write_animation
from postprocess.figures.impact import StrikeMark
from postprocess.figures.positions import draw_positions, vehicle_outlines
from postprocess.svg.chart import FULL, Chart
from postprocess.units import SI, Units
from solver.impact import ImpactVehicle, corner_name
from tailslap import progress
from tailslap.case.impact import answers
from tailslap.case.impact.run import ImpactOutcome, corners_of

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
"""Places where the motion's energy goes, by column; works are done on the plate, and count with the other sign."""

INSTANTS = 9
"""Positions of the vehicle that the strip shows, beside those of the strikes."""


def marks(answer: answers.ImpactAnswer) -> list[StrikeMark]:
    """The strikes as figures mark them."""
    t, x = answer.history["t"], answer.history["x_g"]

    def place(strike_position: float, instant: float, middle: float) -> float:
        return strike_position + float(np.interp(instant, t, x) - np.interp(middle, t, x))

    found = []
    for strike in answer.strikes:
        middle = 0.5 * (strike.start + strike.end)
        places = (place(strike.position, strike.start, middle), place(strike.position, strike.end, middle))
        found.append(StrikeMark(strike.corner.removesuffix(" far side"), strike.start, strike.end, places))
    return found


def outlines(answer: answers.ImpactAnswer, vehicles: Sequence[ImpactVehicle]) -> np.ndarray:
    """Corners of the vehicle at every row, shape (rows, 4, 2) [m]; of a train one line about all its units."""
    units = answers.places(answer.history, vehicles)
    right, left = list[np.ndarray](), list[np.ndarray]()
    for k, place in enumerate(units, 1):
        each = vehicle_outlines(*place)
        ahead, behind = 0.5 * (each[:, 0] + each[:, 3]), 0.5 * (each[:, 1] + each[:, 2])
        for side, ends in ((right, (0, 1)), (left, (3, 2))):
            side += [] if k == 1 else [ahead]
            side += [each[:, end] for end in ends] + ([behind] if k < len(units) else [])
    return np.stack([*right, *left[::-1]], axis=1)


def position_strip(answer: answers.ImpactAnswer, vehicles: Sequence[ImpactVehicle]) -> Chart:
    """Draw the vehicle at even instants, a train where each strike begins, and how it moves."""
    t = answer.history["t"]
    shown = np.unique(np.linspace(0, t.size - 1, INSTANTS).astype(int))
    if answer.units > 1:
        shown = np.unique(np.searchsorted(t, [*(strike.start for strike in answer.strikes), t[-1]]))
    every = outlines(answer, vehicles)
    return draw_positions(every[shown], t[shown], marks(answer), motion=(t, every))


def force_figures(outcome: ImpactOutcome, levels: dict[str, float]) -> list[Chart]:
    """Lateral and longitudinal force, raw and filtered; the rigid vehicle's lateral force beside the plate's."""
    strikes, t = marks(outcome.fe), outcome.fe.history["t"][1:]
    lateral = "Lateral force on the wall, FE; lines across: design forces" if levels else "Lateral force, FE"
    return [
        impact.draw_forces("force_lateral", lateral, t, outcome.fe.lateral, strikes, levels, FULL),
        impact.draw_forces(
            "force_longitudinal", "Longitudinal force on the wall, FE", t, outcome.fe.longitudinal, strikes
        ),
        impact.draw_forces(
            "force_rigid",
            "Lateral force on the wall, rigid vehicle",
            t,
            outcome.rigid.lateral,
            marks(outcome.rigid),
        ),
    ]


def train_figures(outcome: ImpactOutcome) -> list[Chart]:
    """Forces of each unit of a train on the wall, force and articulation angle of each hinge beside the rigid train's;
    none of a single vehicle."""
    h, strikes, units = outcome.fe.history, marks(outcome.fe), range(1, outcome.fe.units + 1)
    hinges, t = units[:-1], h["t"]
    if not hinges:
        return []
    pushes = {f"unit {k}": h[f"force_normal_{k}"] / 1e3 for k in units}
    drags = {f"unit {k}": -h[f"force_tangential_{k}"] / 1e3 for k in units}
    forces, angles = {}, {}
    for model, its in (("FE", h), ("rigid", outcome.rigid.history)):
        for k in hinges:
            pulled = np.hypot(its[f"hinge_force_x_{k}"], its[f"hinge_force_y_{k}"])
            forces[f"hinge {k}, {model}"] = pulled / 1e3
            angles[f"hinge {k}, {model}"] = np.degrees(its[f"articulation_{k}"])
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
    """Draw what becomes of the kinetic energy."""
    h = outcome.run.history
    parts = {label: (-h[key] if key.endswith("work") else h[key]) for key, label in PARTS.items() if key in h}
    return impact.draw_energies(h["t"], h["kinetic_energy"], parts, marks(outcome.fe))


def contact_figures(outcome: ImpactOutcome) -> tuple[list[Chart], list[Chart]]:
    """Force over crush of the corners that struck, and with more points than corners the force along the side, of
    a train that of its first unit."""
    run, corner = outcome.run, corners_of(outcome.fe_plan, outcome.run)
    loops = {}
    for i in np.unique(corner):
        pressed = [k for k in np.flatnonzero(corner == i) if run.normal[:, k].any()]
        if pressed:
            k = max(pressed, key=lambda k: run.normal[:, k].max())
            loops[corner_name(*divmod(int(i), 4))] = (np.maximum(run.depth[:, k], 0.0), run.normal[:, k])
    along = []
    side = np.flatnonzero((run.points[1] < 1e-6) & (run.unit == 0))
    order = side[np.argsort(-run.points[0, side], kind="stable")]
    if order.size > 4:
        distances, places = np.unique(np.round(-run.points[0, order], 9), return_inverse=True)
        force = np.zeros((len(run.normal), distances.size))
        np.add.at(force.T, places, run.normal[:, order].T / 1e3)
        along.append(impact.draw_side_force(run.history["t"], distances, force, "kN", marks(outcome.fe)))
    return [impact.draw_loops(loops)] if loops else [], along


def animation(
    outcome: ImpactOutcome, folder: Path, units: Units = SI, size: tuple[int, int] | None = None
) -> Path:
    """Write the impact as a GIF of this size [pixels], its axes in these units."""
    h = outcome.run.history
    with progress.announced("Drawing the animation ..."):
        return write_animation(
            folder / "impact.gif",
            h["t"],
            outlines(outcome.fe, outcome.fe_plan.case.motion.vehicles),
            h["force_normal"],
            units=units,
            size=size or SIZE,
        )
