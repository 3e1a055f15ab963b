"""Moments about the foot of vertical walls beside an independent program.

    .venv/bin/python benchmarks/moments.py [--samples 1024]

Medians of the 10000S of `tailslap validate`, first set of ranges; standard error of the median of 48 samples.
"""

import command_line
import numpy as np

from tailslap.validation.samples import samples_of
from tailslap.validation.tables import parameters

INDEPENDENT = {27: (112.0, 0.55), 32: (180.0, 0.61), 36: (207.0, 0.65), 42: (325.0, 0.75), 54: (406.0, 0.88)}
"""Moment [kN m] and height [m] of rigid trucks of another program by the height of the wall [in], 48 samples."""

COUNT = 48
"""Samples of the other program."""


def main() -> None:
    """Print the table."""
    options = command_line.options(__doc__, samples=1024)
    tables, draw = parameters("first"), np.random.default_rng(1)
    print("wall [in]  moment [kN m]  independent  difference  its standard error  height [m]  independent")
    for inches, (moment, height) in INDEPENDENT.items():
        wall, names = {"height": f"{inches} in", "profile": "vertical"}, ("moment", "moment_height")
        samples = samples_of(tables, {"vehicle": "10000S"}, wall, options.samples, names).answers
        moments, median = samples["moment"], float(np.median(samples["moment"]))
        medians = [np.median(draw.choice(moments, COUNT, replace=False)) for _ in range(400)]
        print(
            f"{inches:9d}{1e-3 * median:15.1f}{moment:13.0f}{100.0 * (1e-3 * median / moment - 1.0):+10.1f} %"
            f"{100.0 * np.std(medians) / median:18.1f} %{np.median(samples['moment_height']):12.3f}{height:13.2f}"
        )


if __name__ == "__main__":
    main()
