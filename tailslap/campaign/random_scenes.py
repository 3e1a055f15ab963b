"""Random scenes for a campaign.

Of a constrained corner, all quantities and choices are drawn at once. Of a whole impact, all quantities of each unit
are drawn near those of the scene. The choices that determine the machine code of a run form one of `COMBINATIONS`, and
quantities are drawn separately. Most models then serve many scenes, and compilation is rare.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from fem.plate.kinds import ELEMENT_KINDS
from tailslap.campaign.records import Record
from tailslap.case import case_of
from tailslap.case.resources import beam_frequency, expected_effort
from tailslap.errors import InputError
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, Source, vary

Random = np.random.Generator

COMBINATIONS = 97
"""Number of combinations of choices; almost any two choices occur together.

It is prime, so that choices that follow from the number of a cell, such as its start, vary within a combination.
"""

OPEN_FRACTION = 0.3
"""Fraction of the cells that leave a choice to the program."""

MAX_STEPS, MAX_SECONDS, MAX_TRIES, TRIES = 400_000, 0.5, 1000, 50
"""Limits of a random cell: expected steps and seconds of its time loop, scenes drawn for it, and scenes drawn per
combination.

About one scene in three is valid and affordable.
"""

SCATTER = 1.25
"""Largest factor between a quantity of a whole impact and that of the scene."""


def log_uniform(random: Random, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniformly distributed."""
    return math.exp(random.uniform(math.log(low), math.log(high)))


def stiffness(scene: Scene, factor: float) -> Changes:
    """Return the changes that multiply the plate's stiffness.

    They multiply Young's modulus, or scale the first frequency accordingly.
    """
    plate = scene.needed_plate
    if plate.first_frequency is not None:
        return {"plate.first_frequency": plate.first_frequency * math.sqrt(factor)}
    return {"plate.youngs_modulus": plate.modulus * factor}


def choices_of(seed: int, combination: int, attempt: int) -> Record:
    """Draw the choices that determine the machine code.

    "open" leaves a choice to the program. `attempt` counts the earlier combinations without a valid scene.
    """
    random = np.random.default_rng((seed, combination, attempt))
    elements = [kind.name for kind in ELEMENT_KINDS.values() for _ in range(kind.draw_weight)]
    return {
        "reaction": str(random.choice(("drag", "none", "signed"), p=(0.6, 0.2, 0.2))),
        "frictionless": random.random() < 0.1,
        "element": "open" if random.random() < OPEN_FRACTION else str(random.choice(elements)),
        "row_sum": random.random() < 0.1,
        "distorted": random.random() < 0.3,
        "constraint": str(random.choice(("open", "penalty", "exact", "dashpot"), p=(0.4, 0.2, 0.2, 0.2))),
        "patch": random.random() < 0.5,
        "damping": str(random.choice(("open", "ratio", "bulk", "none"), p=(0.6, 0.15, 0.1, 0.15))),
        "neo_hookean": random.random() < 0.5,
    }


def draw(scene: Scene, base: Source, seed: int, number: int) -> Changes:
    """Draw the changes of a random cell.

    They depend on seed and number only. Raises InputError where the scene allows no valid and affordable cell.
    """
    random = np.random.default_rng((seed, COMBINATIONS + number))
    scene_case: Any = case_of(scene, base)
    nominal = scene_case.inputs if scene.contact else {}
    for attempt in range(MAX_TRIES):
        if scene.contact:
            changes = _about(scene, nominal, random, number)
        else:
            choices = choices_of(seed, number % COMBINATIONS, attempt // TRIES)
            changes = _drawn(scene, choices, random, number)
        try:
            case = case_of(*vary(base, changes))
            effort = expected_effort(case.scene, case.duration)
        except InputError:
            continue
        if scene.contact or (effort.steps <= MAX_STEPS and effort.seconds <= MAX_SECONDS):
            return changes
    allowed = f"none of {MAX_TRIES} random scenes is valid and within the limits of this machine"
    raise InputError("--random", number, allowed)


def _about(scene: Scene, nominal: Mapping[str, float], random: Random, number: int) -> Changes:
    """Draw the quantities of a whole impact."""
    changes = {
        key: value * log_uniform(random, 1.0 / SCATTER, SCATTER) for key, value in nominal.items() if value
    }
    stiffer = stiffness(scene, log_uniform(random, 0.1, 10.0))
    return {**changes, **stiffer, "name": f"cell-{number:04d}"}


def _drawn(scene: Scene, choices: Record, random: Random, number: int) -> Changes:
    """Draw all changes from one sequence of random numbers."""
    length = random.uniform(3.0, 20.0)
    width = length * log_uniform(random, 0.05, 1.0)
    changes: Record = dict.fromkeys(("verify", "wall", "damping", "material"))
    changes |= {"vehicle.length": length, "vehicle.width": width}
    changes |= _motion(scene, choices, random)
    changes |= _plate(scene, choices, random, number, length, width)
    changes |= _corner(choices, random, length, changes["plate.elements"] or (10, 1))
    if choices["damping"] == "ratio":
        changes["damping.ratio"] = log_uniform(random, 0.005, 0.3)
    elif choices["damping"] != "open":
        bulk = choices["damping"] == "bulk"
        changes |= {"damping.bulk_viscosity": 0.06} if bulk else {"damping.kind": "none"}
    if choices["neo_hookean"]:
        changes["material.law"] = "neo-hookean"
    return changes | {"name": f"cell-{number:04d}"}


def _motion(scene: Scene, choices: Record, random: Random) -> Changes:
    """Draw the state at impact or start.

    The angular velocity of a start is in proportion to its speed.
    """
    speed, angle = log_uniform(random, 1.0, 40.0), math.radians(random.uniform(2.0, 60.0))
    restitution, friction = random.uniform(0.0, 0.8), random.uniform(0.0, 1.2)
    if choices["frictionless"]:
        friction = 0.0
    changes: Record = {"corner": None, "corner.reaction": choices["reaction"], "start": None}
    if scene.impact:
        drawn = {"speed": speed, "angle": angle, "restitution": restitution, "friction": friction}
        return changes | {f"impact.{key}": value for key, value in drawn.items()}
    start: Any = scene.start
    spin = start.omega / start.corner_speed
    changes |= {"start.angle": angle, "start.corner_speed": speed, "start.omega": spin * speed}
    return changes | ({"corner.friction": friction} if choices["reaction"] != "none" else {})


def _plate(
    scene: Scene, choices: Record, random: Random, number: int, length: float, width: float
) -> Changes:
    """Draw the plate.

    Its modulus is 1e-4 to 1e4 times that of the scene. For a third of the cells, the corresponding frequency of a beam
    replaces it.
    """
    plate, factor = scene.needed_plate, log_uniform(random, 1e-4, 1e4)
    element, relieved = choices["element"], ("inertia-relief", "inertia-relief-momenta")
    changes: Record = {"plate.elements": None, "plate.element": None if element == "open" else element}
    changes |= {"plate.lumping": "row-sum" if choices["row_sum"] else None, "plate.distortion": None}
    changes["plate.start"] = relieved[number // 3 % 2] if number % 3 else "unstressed"
    changes |= stiffness(scene, factor)
    if plate.first_frequency is None and random.random() < 1.0 / 3.0:
        frequency = beam_frequency(scene, length, width, plate.modulus * factor)
        changes |= {"plate.youngs_modulus": None, "plate.first_frequency": frequency}
    if random.random() >= OPEN_FRACTION:
        changes["plate.elements"] = (
            round(log_uniform(random, 4.0, 40.0)),
            round(log_uniform(random, 2.0, 12.0)),
        )
    if choices["distorted"]:
        changes["plate.distortion"] = random.uniform(0.0, 0.2)
    return changes


def _corner(choices: Record, random: Random, length: float, elements: tuple[int, int]) -> Changes:
    """Draw the constraint of the corner."""
    changes: Record = {}
    if choices["constraint"] == "exact":
        changes["corner.constraint"] = "exact"
    elif choices["constraint"] != "open":
        changes |= {
            "corner.constraint": "penalty",
            "corner.penalty_scale": log_uniform(random, 0.1, 10.0**1.5),
        }
    if choices["constraint"] == "dashpot":
        changes["corner.damping_ratio"] = log_uniform(random, 0.01, 1.0)
    if choices["patch"]:
        changes["corner.patch_length"] = max(random.uniform(0.1, 0.3) * length, 1.2 * length / elements[0])
    return changes
