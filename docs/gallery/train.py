"""Motion of a tractor with its trailer

Positions of the rigid train of MASH TL-5 from above at the start of each strike, and its motion ten times slower.
"""

from pathlib import Path

from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.figures import position_strip
from tailslap.scene.read import read_scene

case = ImpactCase(*read_scene("impact-mash-tl5-tractor-van"))
chart = position_strip(case.answer, case.motion.vehicles)
Path("train.svg").write_text(chart.svg)
