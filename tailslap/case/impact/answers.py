"""Results of an impact by one model.

Strikes, filtered forces and their peaks, the duration of the second strike, occupant risk.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from postprocess.signals import filters, occupant, strike_duration
from solver.impact import ImpactMotion, ImpactVehicle, Strike, group_names, outermost, strikes_of
from solver.impact.counting import LIGHT

if TYPE_CHECKING:
    from fem.run.impact import ImpactRun

END = ("t", "theta", "omega", "v_gx", "v_gy")
"""Columns of the state at the end of an impact."""

COMPARED = ("impulse", "peak_force", "duration")
"""Quantities of the first two strikes that are compared."""

COMPANION = "companion in the plane: the same strips without heights"
"""Planar motion of a vehicle in space, which has a plate in the plane."""

WEIGHT = 0.05
"""Impulse of a strike over the largest, from which it is judged; others come and go with the mesh."""

ABOUT = 1.0 / 1.5, 1.0 / 1.2, 1.2, 1.5
"""Factors on `LIGHT`: the impulses of touches of a vehicle that leans on the wall vary so from mesh to mesh."""

STRIKE = ("corner", "start", "end", "duration", "peak_force", "impulse")
"""First quantities of a strike in a summary; more follow."""

TYRES = ("tyre_work", "tyre_impulse_tangential", "tyre_impulse_normal", "tyre_impulse_angular")
"""Columns of the tyres of all units, of scenes with axles."""

MOTION = ("x_g", "y_g", "theta", "omega", "v_gx", "v_gy")
"""Columns of the motion of each unit."""

JACK_KNIFE = 0.5 * math.pi
"""Articulation angle beyond which units that touch would hinder each other [rad]."""

MEAN_WINDOW = 0.05
"""Width of a mean [s] by which forces on barriers are compared."""

Columns = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class ImpactAnswer:
    """Impact by one of the two models.

    Attributes
    ----------
    strikes : tuple of Strike
        In order of time.
    history : dict of ndarray, shape (rows,)
        t [s], x_g, y_g, theta, omega, v_gx, v_gy, force_normal, force_tangential [N], each mean force since the row
        before, and more; even instants. In space also roll and pitch.
    units : int
        Of a train; 1 of a single vehicle.
    pushes : dict of ndarray, shape (rows - 1,)
        Normal force of each corner that touches the wall [N], mean between two rows; empty for the rigid vehicle.
    ends : (str, str)
        Names of the foremost contact of the first unit and of the rearmost one of the last.
    """

    strikes: tuple[Strike, ...]
    history: Columns
    units: int = 1
    pushes: Columns = field(default_factory=dict)
    ends: tuple[str, str] = ("front", "rear")

    @property
    def counted(self) -> int:
        """Number of strikes that are compared and whose error is stated."""
        return counted(self.units)

    @property
    def hinges(self) -> list[dict[str, float]]:
        """Largest force and articulation angle of each hinge.

        Horizontal force [N] unfiltered and as a 50 ms mean, angle [rad]; empty for a single vehicle.
        """
        h, hinges = self.history, []
        rows = min(round(MEAN_WINDOW / self.interval), h["t"].size - 1)
        for k in range(1, self.units):
            force = np.array([h[f"hinge_force_{axis}_{k}"] for axis in "xy"])
            sums = np.cumsum(force, axis=1)  # no window reaches beyond the end, where the force may still act
            peak, mean = (
                float(np.hypot(*values).max())
                for values in (force, (sums[:, rows:] - sums[:, :-rows]) / rows)
            )
            angle = float(np.abs(h[f"articulation_{k}"]).max())
            hinges.append({"peak_force": peak, "mean_50ms": mean, "largest_angle": angle})
        return hinges

    @property
    def interval(self) -> float:
        """Time between rows [s]."""
        return float(self.history["t"][1] - self.history["t"][0])

    def resampled(self, rows: int = 1, light: float = LIGHT) -> tuple[Strike, ...]:
        """Return the strikes by joined rows.

        rows: joined to one; light: see `strikes_of`.
        """
        t = self.history["t"][::rows]
        joined = {corner: push[: rows * (t.size - 1)] for corner, push in self.pushes.items()}
        means = {corner: push.reshape(-1, rows).mean(axis=1) for corner, push in joined.items()}
        return strikes_of(t, means, light=light)

    @cached_property
    def by_other_touches(self) -> tuple[Strike, ...]:
        """Strikes that lighter, and that heavier touches alone prolong."""
        return tuple(strike for factor in ABOUT for strike in self.resampled(1, factor * LIGHT))

    @property
    def cut(self) -> list[int]:
        """Numbers from 1 of the incomplete strikes."""
        return [number for number, strike in enumerate(self.strikes, 1) if strike.cut]

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """History with the filtered lateral forces, shape (rows,).

        They are 0 in the first row.
        """
        curves = {f"force_normal_{name}": force for name, force in self.lateral.items() if name != "raw"}
        return dict(self.history) | {name: np.concatenate(([0.0], force)) for name, force in curves.items()}

    @cached_property
    def lateral(self) -> dict[str, np.ndarray]:
        """Lateral force on the wall by filter [N]."""
        return filters.force_curves(self.history["force_normal"][1:], self.interval)

    @cached_property
    def longitudinal(self) -> dict[str, np.ndarray]:
        """Longitudinal force on the wall by filter [N]."""
        return filters.force_curves(-self.history["force_tangential"][1:], self.interval)

    @cached_property
    def peaks(self) -> dict[str, float]:
        """Peaks of the lateral force by filter [N]."""
        return filters.force_peaks(self.lateral)

    @property
    def end(self) -> dict[str, float]:
        """State at the end, SI."""
        return {name: float(self.history[name][-1]) for name in END}

    @cached_property
    def second_strike(self) -> dict[str, dict[str, float]]:
        """Duration of the second strike by the paper's reading of a curve.

        Besides, that of the equal triangle. Curves with a single peak are omitted.
        """
        by_curve = {}
        for name in ("mean_50ms", "cfc60", "cutoff_60hz"):
            try:
                strike = strike_duration.second_strike(self.lateral[name], self.interval)
            except ValueError:
                continue
            if self.cut and strike.end + self.interval >= self.history["t"][-1]:
                continue
            by_curve[name] = {
                "duration": strike.duration,
                "triangle": strike.triangle,
                "peak_force": strike.peak,
                "impulse": strike.impulse,
            }
        return by_curve

    def occupant_risk(self, mass: float) -> tuple[occupant.RiskMeasure, ...]:
        """Return measures of the motion.

        mass [kg]. For a train they are those of its first unit, at its centre of mass.
        """
        h = {name: values[1:] for name, values in self.history.items()}
        if self.in_space:
            from scipy.spatial.transform import Rotation

            speeds = np.array([self.history[name] for name in ("v_gx", "v_gy", "v_gz")])
            axes = Rotation.from_euler("ZYX", np.array([h["yaw"], h["pitch"], h["roll"]]).T)
            x, y, z = axes.apply(np.diff(speeds).T / self.interval, inverse=True).T
            return occupant.occupant_risk(occupant.VehicleMotion(h["t"], x, y, h["omega"], h["yaw"], z))
        along, across = h["force_tangential"] / mass, h["force_normal"] / mass
        if self.units > 1:
            along, across = (np.diff(self.history[name]) / self.interval for name in ("v_gx", "v_gy"))
        sine, cosine = np.sin(h["theta"]), np.cos(h["theta"])
        ahead, lateral = cosine * along - sine * across, sine * along + cosine * across
        return occupant.occupant_risk(occupant.VehicleMotion(h["t"], ahead, lateral, h["omega"], -h["theta"]))

    @property
    def in_space(self) -> bool:
        """True for a motion in space."""
        return "roll" in self.history

    def numbers(self) -> dict[str, Any]:
        """Return the part of `summary.json` on this model."""
        return {
            "strikes": [strike_numbers(strike) for strike in self.strikes],
            "peaks": self.peaks,
            "end": self.end,
            "second_strike": self.second_strike,
            **({"hinges": self.hinges} if self.hinges else {}),
            **({"tyre_work": float(self.history["tyre_work"][-1])} if "tyre_work" in self.history else {}),
        }


def counted(units: int) -> int:
    """Return the number of strikes that are compared.

    Two of a single vehicle; of a train the strikes up to that of its last rear.
    """
    return 3 * units - 1


def last_awaited(strikes: Sequence[Strike], rear: str | None) -> Strike | None:
    """Return the strike up to which an impact is computed.

    It is the second, or the first one of `rear`, where that is awaited.
    """
    candidates = [strike for strike in strikes if strike.corner == rear][:1] if rear else strikes[1:2]
    return candidates[0] if candidates else None


def places(columns: Columns, vehicles: Sequence[ImpactVehicle]) -> list[tuple[Any, ...]]:
    """Return motion and size of each unit.

    x_g, y_g [m] and theta [rad], shape (rows,), length, width, and distance of the centre of mass behind the front [m].
    """
    units = []
    for number, unit in enumerate(vehicles, 1):
        end = f"_{number}" if number > 1 else ""
        motion = (columns[f"{name}{end}"] for name in ("x_g", "y_g", "theta"))
        units.append((*motion, unit.length, unit.width, unit.front_distance))
    return units


def strike_numbers(strike: Strike) -> dict[str, Any]:
    """Return the known quantities of a strike, SI."""
    numbers = {name: value for name, value in asdict(strike).items() if value == value}
    return {name: getattr(strike, name) for name in STRIKE} | numbers


def mean_peak(answer: ImpactAnswer, strike: Strike) -> float:
    """Return the largest 50 ms mean force [N] about the strike."""
    t, mean = answer.history["t"][1:], answer.lateral["mean_50ms"]
    during = (t >= strike.start) & (t - answer.interval <= strike.end)
    return float(mean[during].max())


def heavy(strikes: Sequence[Strike]) -> list[Strike]:
    """Return the strikes whose impulse is at least `WEIGHT` of the largest."""
    largest = max((strike.impulse for strike in strikes), default=0.0)
    return [strike for strike in strikes if strike.impulse >= WEIGHT * largest]


def matched_strikes(strikes: Sequence[Strike], other_strikes: Sequence[Strike]) -> dict[int, Strike]:
    """Return the corresponding strike of another model by number, from 1.

    Strikes correspond in order for as long as the same corners strike, of all strikes and of the heavy ones, because
    a corner that bounces may do so another number of times.
    """
    matched = {}
    for first, second in ((strikes, other_strikes), (heavy(strikes), heavy(other_strikes))):
        for strike, counterpart in zip(first, second, strict=False):
            if strike.corner != counterpart.corner:
                break
            matched[1 + strikes.index(strike)] = counterpart
    return matched


def differences(fe: ImpactAnswer, rigid: ImpactAnswer) -> dict[str, float]:
    """Return FE/rigid - 1 of the matched strikes that are compared."""
    return {
        f"strike_{k}.{name}": getattr(fe.strikes[k - 1], name) / getattr(counterpart, name) - 1.0
        for k, counterpart in sorted(matched_strikes(fe.strikes, rigid.strikes).items())
        for name in COMPARED
        if k <= fe.counted
    }


def rigid_answer(motion: ImpactMotion, instants: np.ndarray) -> ImpactAnswer:
    """Return the rigid impact at uniform instants [s].

    Forces are means since the previous instant.
    """
    at = motion.at(np.minimum(instants, motion.t_end))
    step, units = np.diff(instants, prepend=np.nan), range(1, len(motion.vehicles) + 1)
    history = {name: getattr(at, name) for name in (*MOTION, "kinetic_energy", "friction_work")}
    for force, impulse in (("normal", at.impulse_normal), ("tangential", at.impulse_tangential)):
        history[f"force_{force}"] = np.nan_to_num(np.diff(impulse, prepend=0.0) / step)
    if motion.axles:
        ends = ("", *(f"_{unit}" for unit in units[1:]))
        history |= {name: sum(getattr(at, f"{name}{end}") for end in ends) for name in TYRES}
    history |= {"contact_energy": at.crush_energy_stored, "crush_energy": at.crush_energy_lost}
    if motion.trailers:
        trailers = ({name: getattr(at, f"{name}_{unit}") for name in MOTION} for unit in units[1:])
        impulses = [
            [getattr(at, f"impulse_{force}_{unit}") for unit in units] for force in ("normal", "tangential")
        ]
        forces = np.nan_to_num(np.diff(impulses, prepend=0.0) / step)
        hinged = np.pad(motion.hinge_forces(instants), ((0, 0), (0, 0), (1, 0)))
        history |= train_columns([history, *trailers], forces, hinged)
    lengths = [vehicle.length for vehicle in motion.vehicles]
    names, (front, rear) = group_names(motion.contact, lengths), outermost(motion.contact, lengths)
    columns = {"t": instants} | history
    return ImpactAnswer(motion.strikes, columns, len(motion.vehicles), ends=(names[front], names[rear]))


def train_columns(
    motions: Sequence[Columns], forces: np.ndarray, hinges: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the columns of a train by name.

    motions: `MOTION` of each unit, shape (rows,); forces, shape (2, units, rows): normal and tangential force on each
    [N]; hinges, shape (hinges, 2, rows): force of each hinge along X and Y on the unit ahead [N]. Names end with the
    number of the unit, or hinge, from 1; those of the first unit's motion have no number.
    """
    columns = {f"{name}_{k}": motion[name] for k, motion in enumerate(motions[1:], 2) for name in MOTION}
    for name, by_unit in zip(("normal", "tangential"), forces, strict=True):
        columns |= {f"force_{name}_{k}": force for k, force in enumerate(by_unit, 1)}
    for k, ((x, y), ahead, behind) in enumerate(zip(hinges, motions, motions[1:], strict=False), 1):
        columns |= {f"hinge_force_x_{k}": x, f"hinge_force_y_{k}": y}
        columns[f"articulation_{k}"] = behind["theta"] - ahead["theta"]
    return columns


def remarks(answer: ImpactAnswer) -> list[str]:
    """List sentences on incomplete strikes and on limits of the model."""
    sentences = [
        f"Strike {number} ({answer.strikes[number - 1].part}) continues beyond the end at "
        f"{answer.end['t']:.4g} s: its duration, peak force and impulse, and the filtered forces, are lower bounds."
        for number in answer.cut
    ]
    if answer.strikes and answer.strikes[0].corner.startswith("trailer"):
        sentences.append("A trailer is so wide that it touches the wall first.")
    for k in range(1, answer.units):
        angle = np.abs(answer.history[f"articulation_{k}"])
        if angle.max() > JACK_KNIFE:
            t = answer.history["t"][np.argmax(angle > JACK_KNIFE)]
            sentences.append(
                f"The train jack-knifes: from {t:.3f} s on hinge {k} is bent by more than 90 deg. That is beyond the "
                "model, in which units do not touch one another."
            )
    return sentences


def sampled_answer(
    history: Columns, run: ImpactRun, names: Sequence[str], ends: tuple[int, int], units: int
) -> ImpactAnswer:
    """Return an impact from sampled contact forces.

    history: as of `ImpactAnswer`; run: with the forces of its points; names: of the groups of points; ends: groups of
    the ends of `ImpactAnswer`; units: of the train.
    """
    pushes, drags, stations, places = {}, {}, {}, {}
    for i in np.unique(run.group):
        name, members = names[i], run.group == i
        force = run.normal[1:, members]
        total = force.sum(axis=1)
        if not total.any():
            continue
        pushes[name], drags[name] = total, run.tangential[1:, members].sum(axis=1)
        weight = np.where(total > 0.0, total, 1.0)
        stations[name] = force @ -run.points[0, members] / weight
        places[name] = (force * run.place[1:, members]).sum(axis=1) / weight
    strikes = strikes_of(history["t"], pushes, drags, stations, places)
    return ImpactAnswer(strikes, history, units, pushes, (names[ends[0]], names[ends[1]]))
