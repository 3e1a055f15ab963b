"""Moments about the foot of vertical walls beside an independent program.

    .venv/bin/python benchmarks/moments.py [--samples 1024]

Medians of the 10000S of `tailslap validate`, first set of ranges, also on walls 20 mm higher; standard error of a
median of 48 samples, and how often the medians of 48 agree with those of all.
"""

import command_line
import numpy as np

from tailslap.validation.samples import samples_of
from tailslap.validation.tables import parameters

INDEPENDENT = {27: (112.0, 0.55), 32: (180.0, 0.61), 36: (207.0, 0.65), 42: (325.0, 0.75), 54: (406.0, 0.88)}
"""Moment [kN m] and height [m] of rigid trucks of another program by the height of the wall [in], 48 samples."""

COUNT, DRAWS, ASKED = 48, 400, 0.03
"""Samples of the other program, draws of as many, and asked agreement [-]."""

HIGHER = 0.02
"""Further height of the wall [m], or by which a truck sits lower."""


def main() -> None:
    """Print the table."""
    options = command_line.options(__doc__, samples=1024)
    tables, random, apart = parameters("first"), np.random.default_rng(1), []
    drawn = [random.choice(options.samples, COUNT, replace=False) for _ in range(DRAWS)]

    def samples(height: float) -> tuple[np.ndarray, np.ndarray]:
        wall, names = {"height": f"{height} m", "profile": "vertical"}, ("moment", "moment_height")
        answers = samples_of(tables, {"vehicle": "10000S"}, wall, options.samples, names).answers
        return 1e-3 * answers["moment"], answers["moment_height"]

    print("                                                                 standard")
    print("wall [in]  moment [kN m]  independent  difference  20 mm higher   error  height [m]  independent")
    for inches, (moment, height) in INDEPENDENT.items():
        moments, heights = samples(0.0254 * inches)
        median, higher = np.median(moments), np.median(samples(0.0254 * inches + HIGHER)[0])
        apart.append([np.median(moments[rows]) / median - 1.0 for rows in drawn])
        print(
            f"{inches:9d}{median:15.1f}{moment:13.0f}{100.0 * (median / moment - 1.0):+10.1f} %"
            f"{100.0 * (higher / moment - 1.0):+12.1f} %{100.0 * np.std(apart[-1]):6.1f} %"
            f"{np.median(heights):12.3f}{height:13.2f}"
        )
    within = (np.abs(apart) <= ASKED).all(axis=0).mean()
    print(
        f"\nMedians of {COUNT} of these trucks are within {100.0 * ASKED:g} % of those of all {options.samples} on "
        f"every wall in {100.0 * within:.0f} % of {DRAWS} draws; agreement to that with the other "
        f"program is chance without its samples."
    )


if __name__ == "__main__":
    main()
