"""What an impact is read for: strikes, filtered forces and their peaks, the second strike's duration, occupant risk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from postprocess.signals.flail_space import VehicleMotion
from postprocess.signals.occupant_risk import RiskMeasure, occupant_risk
from postprocess.signals.peaks import force_curves, force_peaks, second_strike
from solver.impact import CORNERS, ImpactMotion, Strike, strikes_of

END = ("t", "theta", "omega", "v_gx", "v_gy")
"""What is told of the end of an impact."""

STRIKE = ("corner", "start", "end", "duration", "peak_force", "impulse")
"""What the contract tells of a strike; more follows."""

Columns = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class ImpactAnswer:
    """An impact by one of the two models.

    Attributes
    ----------
    strikes : tuple of Strike
        In order of time.
    history : dict of ndarray, shape (rows,)
        t [s], x_g, y_g, theta, omega, v_gx, v_gy, force_normal, force_tangential [N], each mean force since the row
        before, and more; even instants.
    """

    strikes: tuple[Strike, ...]
    history: Columns

    @property
    def interval(self) -> float:
        """Time between rows [s]."""
        return float(self.history["t"][1] - self.history["t"][0])

    @cached_property
    def lateral(self) -> dict[str, np.ndarray]:
        """Force on the wall across it, raw and filtered [N], shape (rows - 1,)."""
        return force_curves(self.history["force_normal"][1:], self.interval)

    @cached_property
    def longitudinal(self) -> dict[str, np.ndarray]:
        """Force on the wall along it, raw and filtered [N], shape (rows - 1,)."""
        return force_curves(-self.history["force_tangential"][1:], self.interval)

    @cached_property
    def peaks(self) -> dict[str, float]:
        """Peaks of the lateral force, raw and filtered [N]."""
        return force_peaks(self.lateral)

    @property
    def end(self) -> dict[str, float]:
        """State at the end, SI."""
        return {name: float(self.history[name][-1]) for name in END}

    @cached_property
    def second_strike(self) -> dict[str, dict[str, float]]:
        """Duration of the second strike as the paper reads it off a curve, and of the equal triangle; empty for curves
        with a single peak."""
        found = {}
        for name in ("mean_50ms", "cfc60", "cutoff_60hz"):
            try:
                strike = second_strike(self.lateral[name], self.interval)
            except ValueError:
                continue
            found[name] = {
                "duration": strike.duration,
                "triangle": strike.triangle,
                "peak_force": strike.peak,
                "impulse": strike.impulse,
            }
        return found

    def occupant_risk(self, mass: float) -> tuple[RiskMeasure, ...]:
        """Measures of the planar motion; mass [kg]."""
        h = {name: values[1:] for name, values in self.history.items()}
        along, across = h["force_tangential"] / mass, h["force_normal"] / mass
        sine, cosine = np.sin(h["theta"]), np.cos(h["theta"])
        ahead, left = cosine * along - sine * across, sine * along + cosine * across
        return occupant_risk(VehicleMotion(h["t"], ahead, left, h["omega"], -h["theta"]))

    def numbers(self) -> dict[str, Any]:
        """What `summary.json` holds."""
        return {
            "strikes": [strike_numbers(strike) for strike in self.strikes],
            "peaks": self.peaks,
            "end": self.end,
            "second_strike": self.second_strike,
        }


def strike_numbers(strike: Strike) -> dict[str, Any]:
    """A strike, SI, the contract's names first."""
    rest = {
        name: value for name, value in asdict(strike).items() if value == value
    }  # without what is not known
    return {name: getattr(strike, name) for name in STRIKE} | rest


def rigid_answer(motion: ImpactMotion, instants: np.ndarray) -> ImpactAnswer:
    """The rigid impact at these even instants [s]; forces are means since the instant before."""
    at = motion.at(np.minimum(instants, motion.t_end))
    step = np.diff(instants, prepend=np.nan)
    history = {
        name: getattr(at, name)
        for name in ("x_g", "y_g", "theta", "omega", "v_gx", "v_gy", "kinetic_energy", "friction_work")
    }
    for force, impulse in (("normal", at.impulse_normal), ("tangential", at.impulse_tangential)):
        history[f"force_{force}"] = np.nan_to_num(np.diff(impulse, prepend=0.0) / step)
    history |= {"contact_energy": at.crush_energy_stored, "crush_energy": at.crush_energy_lost}
    return ImpactAnswer(motion.strikes, {"t": instants} | history)


def sampled_answer(
    history: Columns,
    points: np.ndarray,
    normal: np.ndarray,
    tangential: np.ndarray,
    place: np.ndarray,
    length: float,
) -> ImpactAnswer:
    """An impact from sampled forces of contact points.

    Parameters
    ----------
    history : dict of ndarray, shape (rows,)
        As of `ImpactAnswer`.
    points : ndarray, shape (2, points)
        Places in the body frame, the front corner on the wall's side at the origin [m].
    normal, tangential, place : ndarray, shape (rows, points)
        Mean forces since the row before [N]; place along the wall [m].
    length : float
        Of the vehicle [m].

    Returns
    -------
    ImpactAnswer
        Its strikes by the nearest corner of each point.
    """
    corner = nearest_corner(points, length)
    pushes, drags, stations, places = {}, {}, {}, {}
    for i, name in enumerate(CORNERS):
        force, own = normal[1:, corner == i], corner == i
        total = force.sum(axis=1)
        if not total.any():
            continue
        pushes[name], drags[name] = total, tangential[1:, own].sum(axis=1)
        weight = np.where(total > 0.0, total, 1.0)
        stations[name] = force @ -points[0, own] / weight
        places[name] = (force * place[1:, own]).sum(axis=1) / weight
    return ImpactAnswer(strikes_of(history["t"], pushes, drags, stations, places), history)


def nearest_corner(points: np.ndarray, length: float) -> np.ndarray:
    """Number of the nearest corner in `CORNERS` of points in the body frame, shape (points,)."""
    rear = points[0] < -0.5 * length
    far = points[1] > 0.5 * points[1].max()
    return np.asarray(rear + 2 * far)
