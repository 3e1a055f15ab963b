"""Growth of the force of TL-4 trucks with speed and mass.

    .venv/bin/python benchmarks/growth.py

Medians of the bands of a scene in the plane and of one in space, at both ends of a key.
"""

import command_line

from tailslap.campaign.band_samples import force_band
from tailslap.case import case_of
from tailslap.scene.read import read_scene

SCENES = ("impact-mash-tl4-sut", "impact-tipping-tl4-sut")
"""The truck in the plane and in space."""

ENDS = (("impact.speed", "45 mph", "75 mph"), ("vehicle.mass", "7000 kg", "20000 kg"))
"""Keys with the ends of their growth."""


def main() -> None:
    """Print a line for each scene and key."""
    command_line.options(__doc__)
    for scene in SCENES:
        for key, *ends in ENDS:
            bands = [force_band(case_of(*read_scene(scene, (f"{key}={end}",)))) for end in ends]
            slow, fast = (band.percentiles[1] for band in bands)
            medians = f"{1e-3 * slow:.1f} to {1e-3 * fast:.1f} kN"
            print(f"{scene:24}{key:14}{ends[0]:>8} to {ends[1]:10}{medians:20}{fast / slow:.3f}")


if __name__ == "__main__":
    main()
