"""What a run will cost, from the scene alone: rough, but it needs no mesh."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tailslap.planning.cost import loop_seconds
from tailslap.planning.decide_mesh import ELEMENTS
from tailslap.scene.schema import Plate, Scene, Vehicle

STEPS_A_CROSSING = {"quad4": 1.2, "quad4-reduced": 1.2, "quad9": 3.0, "tri3": 1.5, "tri6": 3.5}
"""Steps in which a wave crosses an element's short side, measured on 20 x 6 and 8 x 10 elements."""

OTHER_STEPS = 4.0
"""The same for an element from outside."""


@dataclass(frozen=True)
class Effort:
    """Steps to the tail-slap, and seconds that they take."""

    steps: float
    seconds: float


def expected_effort(scene: Scene, duration: float) -> Effort:
    """Effort of a run over this time [s]; an open mesh counts as the program's first, of quadratic elements."""
    body, plate = scene.vehicle, scene.needed_plate
    element = plate.element if "element" in plate.model_fields_set else "quad9"
    across_all = ELEMENTS * body.width / body.length
    along, across = plate.elements or (math.sqrt(ELEMENTS * body.length / body.width), math.sqrt(across_all))
    short = min(body.length / along, body.width / max(across, 2.0)) * (1.0 - plate.distortion)
    crossings = duration * _wave_speed(body, plate) / short
    ratio = (scene.damping.ratio if scene.damping else None) or 0.0
    steps = max(
        1000.0, STEPS_A_CROSSING.get(element, OTHER_STEPS) * crossings / (math.hypot(1.0, ratio) - ratio)
    )
    cells = (max(1, round(along)), max(1, round(across)))
    return Effort(steps, loop_seconds(scene, element, cells, steps))


def _wave_speed(body: Vehicle, plate: Plate) -> float:
    area = body.length * body.width * plate.thickness
    density = plate.density or body.mass / area
    if plate.youngs_modulus is not None:
        return math.sqrt(plate.youngs_modulus / density / (1.0 - plate.poissons_ratio**2))
    slenderness = body.width / body.length
    # A stubby plate shears: its modulus is higher than a beam's of that frequency.
    shear = math.sqrt(1.0 + 8.0 * slenderness**2)
    return (plate.first_frequency or 0.0) * body.length / (_BEAM * slenderness) * shear


_BEAM = 22.3733 / (2.0 * math.pi * math.sqrt(12.0))
"""First frequency of a free beam times its length squared, over wave speed and height."""


def beam_frequency(scene: Scene, length: float, width: float, modulus: float) -> float:
    """First frequency [Hz] of a slender plate of the scene's mass and thickness with these sides and modulus."""
    vehicle, plate = scene.vehicle, scene.needed_plate
    density = plate.density or vehicle.mass / (length * width * plate.thickness)
    return float(_BEAM * math.sqrt(modulus / density) * width / length**2)
