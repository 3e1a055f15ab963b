"""Print the time of the band of the force by its parts.

    .venv/bin/python benchmarks/band.py [SCENE ...]

Each part has its wall-clock and processor time; the kernels are compiled before.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import command_line
import numpy as np

SAMPLE_BLOCK = 128
"""Vehicles at a time on one core."""

SCENES = ("mash-tl4-sut", "impact-mash-tl4-sut", "impact-tipping-tl4-sut", "impact-mash-tl5-tractor-van")


def timed(call: Callable[..., Any], *arguments: Any) -> tuple[str, Any]:
    """Return times of a call in words, and its value."""
    wall, processor = time.perf_counter(), time.process_time()
    value = call(*arguments)
    return f"{time.perf_counter() - wall:.3f} ({time.process_time() - processor:.3f})", value


def main() -> None:
    """Print a line for each scene."""
    arguments = command_line.options(__doc__, ("scenes", []))
    from tailslap.campaign import band_samples
    from tailslap.case import case_of
    from tailslap.scene.read import read_scene

    print(f"{'scene':30}{'ranges [s]':>16}{'one sample':>16}{'whole band':>16}  samples")
    for scene in arguments.scenes or SCENES:
        case = case_of(*read_scene(scene))
        band_samples.force_band(case)
        ranges, (every, solve) = timed(band_samples._problem, case, SAMPLE_BLOCK)
        inputs = {item.key: np.array([0.5 * (item.lower + item.upper)]) for item in every}
        one, _ = timed(solve, inputs)
        whole, band = timed(band_samples.force_band, case)
        print(f"{scene:30}{ranges:>16}{one:>16}{whole:>16}  {band.samples}")


if __name__ == "__main__":
    main()
