"""Roll of a truck over a wall of 36 in

Vehicle in space from behind at its largest roll, with wheels off the ground, and the height of the force on the wall.
"""

from pathlib import Path

from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.space.figures import charts
from tailslap.scene.read import read_scene

space = ImpactCase(*read_scene("impact-tipping-tl4-sut")).space
drawn = charts(space.inputs.vehicle, space.inputs.wall, space.motion, space.lifted)
chart = next(chart for chart in drawn if chart.name == "space_elevation")
Path("roll.svg").write_text(chart.svg)
