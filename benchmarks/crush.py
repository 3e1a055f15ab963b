"""Forces by the durations of Table 4, beside the measured ones.

    .venv/bin/python benchmarks/crush.py

The table of docs/crush.md. Blind: the duration of a row and the truck of Table 1 are the input, no force is. Two
readings of the duration: that of the strike itself, by `strike_duration`, and that of its 50 ms mean from valley to
valley, as Figure 18 of the paper shows it. Bands: 5 to 95 % of the impacts with the inputs that the paper does not
state, as in the study of uncertainty.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import command_line
import numpy as np
from scipy.optimize import brentq
from scipy.stats import qmc

from solver.impact import stiffness_of_duration
from tailslap.campaign.planar_ranges import impact_ranges
from tailslap.case.impact.case import ImpactCase
from tailslap.replication.paper_values import TABLE_4, ForceRow
from tailslap.scene.read import read_scene

SCENE = str(Path(__file__).parents[1] / "examples" / "linear-truck.toml")
STIFFNESS, MEAN = "contact.stiffness", "strike_2.mean_50ms"
SAMPLES = 2048
RANGES = ("contact.restitution=0:0.4", "contact.friction=0.3:0.6")
"""Ranges of this comparison; others are those of the study of uncertainty."""

Law = Callable[[Mapping[str, np.ndarray]], np.ndarray]
Reading = tuple[float, float, np.ndarray]


def as_read(stiffness: float) -> float:
    """Duration of the second strike read on the 50 ms mean [s]."""
    case = ImpactCase(*read_scene(SCENE)).varied({STIFFNESS: float(stiffness)})
    return float(case.answer.second_strike["mean_50ms"]["duration"])


def stiffness_as_read(duration: float) -> float:
    """Stiffness [N/m] by the duration [s] of the second 50 ms mean.

    NaN above 10 MN/m.
    """
    low, high = math.log(1e5), math.log(1e7)
    if as_read(1e7) > duration:
        return math.nan
    return math.exp(brentq(lambda x: as_read(math.exp(x)) - duration, low, high, xtol=1e-3))


def forces(case: ImpactCase, stiffness: Law, samples: int = SAMPLES) -> tuple[float, np.ndarray]:
    """Return the second 50 ms mean with its band [N].

    The band is 5 to 95 %. stiffness: function of the inputs [N/m] of each impact.
    """
    nominal = {key: np.array([value]) for key, value in case.inputs.items()}
    # One crush law of front and rear, the inertia of a uniform rectangle.
    ranges = [item for item in impact_ranges(case, RANGES) if item.key in {*case.inputs} - {STIFFNESS}]
    draws = qmc.Sobol(len(ranges), seed=1).random(samples)
    drawn = {key: np.full(samples, value) for key, value in case.inputs.items()}
    drawn |= {r.key: r.lower + (r.upper - r.lower) * u for r, u in zip(ranges, draws.T, strict=True)}
    means = []
    for inputs in (nominal, drawn):
        values = {key: inputs[key] for key in ("vehicle.centre_of_mass", *(item.key for item in ranges))}
        means.append(case.many({**values, STIFFNESS: stiffness(inputs)})[MEAN])
    return float(means[0][0]), np.nanpercentile(means[1], [5.0, 95.0])


def of_strike(duration: float) -> Law:
    """Stiffness by the duration of the strike itself, of each impact [N/m]."""
    sizes = (f"vehicle.{name}" for name in ("mass", "length", "width", "centre_of_mass"))
    names = ("contact.restitution", *sizes)

    def stiffness(inputs: Mapping[str, np.ndarray]) -> np.ndarray:
        restitution, mass, length, width, centre = (inputs[name] for name in names)
        return stiffness_of_duration(duration, restitution, mass, None, length, width, centre)

    return stiffness


def of_all(stiffness: float) -> Law:
    """The same stiffness for each impact [N/m]."""
    return lambda inputs: np.full(inputs["vehicle.mass"].size, stiffness)


def rows(samples: int = SAMPLES) -> Iterator[tuple[ForceRow, list[Reading]]]:
    """Yield rows of Table 4 with forces by each reading.

    A reading is stiffness [N/m], force and band [N].
    """
    case = ImpactCase(*read_scene(SCENE))
    nominal = {key: np.array([value]) for key, value in case.inputs.items()}
    readings_of = {}
    for duration in sorted({row.duration for row in TABLE_4}):
        law, read = of_strike(duration), stiffness_as_read(duration)
        readings = [(float(law(nominal)[0]), *forces(case, law, samples))]
        if math.isfinite(read):
            readings.append((read, *forces(case, of_all(read), samples)))
        readings_of[duration] = readings
    for row in TABLE_4:
        yield row, readings_of[row.duration]


def main() -> None:
    """Print the table."""
    command_line.options(__doc__)
    for row, readings in rows():
        print(f"{row.row}  {row.duration:.2f} s  measured {row.measured / 1e3:.0f} kN", end="")
        for k, force, (low, high) in readings:
            band = f"{force / 1e3:.0f} ({low / 1e3:.0f}-{high / 1e3:.0f}) kN, {force / row.measured:.2f}"
            print(f"  | {k / 1e6:.2f} MN/m {band}", end="")
        print(f"  | paper {row.peak[0] / 1e3:.0f} kN, {row.factor[0]:.2f}")


if __name__ == "__main__":
    main()
