"""Validate the intrusion over a wall by a published crash test.

MwRSF, mwrsf.unl.edu/q&a/view.php?id=1254 (2018): 24 in of the single-unit truck of Report 350 over the BR27C rail of 42
in, essentially vertical; 12 in on 54 in is an estimate there.
"""

import numpy as np
import pytest

from solver.space import solve_space
from tailslap.campaign import sampling, space_samples
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.space.design import intrusions
from tailslap.case.impact.space.input import space_input
from tailslap.scene.vary import Source, vary
from tailslap.validation.tables import parameters

INCH, SAMPLES = 0.0254, 48


@pytest.mark.parametrize(("wall", "published"), [("42 in", 24.0), ("54 in", 12.0)])
def test_intrusion_of_a_truck_of_report_350(wall, published):
    """The published value lies within 5 to 95 % of the samples."""
    truck = parameters("first")["space_vehicles"]["8000S"]
    scene, source = vary(Source(tables=truck["scene"] | {"wall": {"height": wall}}), {})
    ranges = space_samples.stated_ranges(ImpactCase(scene, source), truck["ranges"])
    points, _ = sampling.sobol_points(ranges, SAMPLES)
    largest = []
    for row in np.array(points).T[:SAMPLES]:
        values = dict(zip((item.key for item in ranges), map(float, row), strict=True))
        inputs = space_input(scene, space_samples.expanded(scene, values))
        motion = solve_space(*inputs, step=1e-3)
        over = intrusions(inputs.vehicle, inputs.wall, motion)
        largest.append(max(strip["intrusion"] for strip in over))
    lower, median, upper = np.percentile(largest, [5.0, 50.0, 95.0])
    assert lower <= published * INCH <= upper
    assert median == pytest.approx(published * INCH, rel=0.3)
