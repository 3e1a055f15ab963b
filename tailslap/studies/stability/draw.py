"""Random cells: a scene with every quantity and every choice drawn, known by seed and number.

What the machine code of a run depends on is drawn together, as one of COMBINATIONS, and quantities apart from it: most
kinds of model then serve many cells, where each would be compiled for one or two.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from tailslap.case.corner.case import CornerCase
from tailslap.case.cost import beam_frequency, expected_effort
from tailslap.errors import InputError
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, Source, vary
from tailslap.studies.stability.axes import Cell, base_source
from tailslap.studies.stability.choices import COMBINATIONS, OPEN, Choices, Dice, choices_of

MAX_STEPS, MAX_SECONDS = 400_000, 0.5
"""Steps, and seconds of its time loop, that a run may be expected to take."""

MAX_TRIES, TRIES = 1000, 50
"""Scenes drawn for one cell until one is possible and affordable, about one in three is; and quantities drawn for one
combination of choices before another is."""

RELIEVED = ("inertia-relief", "inertia-relief-momenta")


def random_cells(scene: Scene, seed: int, count: int) -> list[Cell]:
    """The first so many draws of a seed."""
    base = base_source(scene)
    return [_random_cell(scene, base, seed, number) for number in range(count)]


def _random_cell(scene: Scene, base: Source, seed: int, number: int) -> Cell:
    cell = Cell(f"{number:04d}", {}, base, draw(scene, base, seed, number))
    return replace(cell, entries={"number": number, **flat(cell.tables)})


def flat(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Values of a scene by the full names of their keys, sorted."""
    inner = [(name, table) for name, table in tables.items() if isinstance(table, dict)]
    return dict(sorted((f"{name}.{key}", value) for name, table in inner for key, value in table.items()))


def draw(scene: Scene, base: Source, seed: int, number: int) -> Changes:
    """What a cell changes in the base. Raises InputError where the scene allows no possible and affordable one."""
    dice = Dice(seed, COMBINATIONS + number)
    for attempt in range(MAX_TRIES):
        choices = choices_of(seed, number % COMBINATIONS, attempt // TRIES)
        changes = _drawn(scene, choices, dice, number)
        if _affordable(base, changes):
            return changes
    raise InputError(
        "--random", number, f"none of {MAX_TRIES} draws of this scene is possible and affordable"
    )


def _affordable(base: Source, changes: Changes) -> bool:
    """Whether the rigid motion exists, and a run is not too long."""
    try:
        plan = CornerCase(*vary(base, changes))
        effort = expected_effort(plan.scene, plan.motion.strike.t)
    except InputError:
        return False
    return effort.steps <= MAX_STEPS and effort.seconds <= MAX_SECONDS


def _drawn(scene: Scene, choices: Choices, dice: Dice, number: int) -> Changes:
    """All that is drawn, in this order: each takes its random numbers from the same sequence."""
    changes: dict[str, Any] = dict.fromkeys(("verify", "wall", "damping", "material"))
    changes |= _vehicle(dice)
    length, width = changes["vehicle.length"], changes["vehicle.width"]
    changes |= _motion(scene, choices, dice)
    changes |= _plate(scene, choices, dice, number, length, width)
    changes |= _corner(choices, dice, length, changes["plate.elements"] or (10, 1))
    changes |= _damping(choices, dice)
    if choices.neo_hookean:
        changes["material.law"] = "neo-hookean"
    return changes | {"name": f"cell-{number:04d}"}


def _vehicle(dice: Dice) -> Changes:
    length = dice.even(3.0, 20.0)
    return {"vehicle.length": length, "vehicle.width": length * dice.ratio(0.05, 1.0)}


def _motion(scene: Scene, choices: Choices, dice: Dice) -> Changes:
    """Stage 1 where the scene has it, for Stage 2 to follow; else the start, the spin in proportion to the speed."""
    speed, angle = dice.ratio(1.0, 40.0), math.radians(dice.even(2.0, 60.0))
    restitution, friction = dice.even(0.0, 0.8), dice.even(0.0, 1.2)
    reaction, start = choices.reaction, scene.start
    if choices.frictionless:
        friction = 0.0
    changes: dict[str, Any] = {"corner": None, "corner.reaction": reaction, "start": None}
    if scene.impact:
        drawn = {"speed": speed, "angle": angle, "restitution": restitution, "friction": friction}
        return changes | {f"impact.{key}": value for key, value in drawn.items()}
    assert start is not None
    assert start.omega is not None
    assert start.corner_speed is not None
    spin = start.omega / start.corner_speed
    changes |= {"start.angle": angle, "start.corner_speed": speed, "start.omega": spin * speed}
    return changes | ({"corner.friction": friction} if reaction != "none" else {})


def _plate(scene: Scene, choices: Choices, dice: Dice, number: int, length: float, width: float) -> Changes:
    keys = ("elements", "element", "lumping", "distortion")
    changes: dict[str, Any] = dict.fromkeys(f"plate.{key}" for key in keys)
    changes["plate.start"] = RELIEVED[number // 3 % 2] if number % 3 else "unstressed"
    changes |= _stiffness(scene, dice, length, width)
    if not dice.happens(OPEN):
        changes["plate.elements"] = (round(dice.ratio(4.0, 40.0)), round(dice.ratio(2.0, 12.0)))
    if choices.element != "open":
        changes["plate.element"] = choices.element
    if choices.row_sum:
        changes["plate.lumping"] = "row-sum"
    if choices.distorted:
        changes["plate.distortion"] = dice.even(0.0, 0.2)
    return changes


def _stiffness(scene: Scene, dice: Dice, length: float, width: float) -> Changes:
    """A modulus from 1e-4 to 1e4 times the scene's, for a third of the cells by the frequency that it gives a beam."""
    plate, factor = scene.needed_plate, dice.ratio(1e-4, 1e4)
    if plate.first_frequency is not None:
        return {"plate.first_frequency": plate.first_frequency * math.sqrt(factor)}
    modulus = plate.modulus * factor
    if not dice.happens(1.0 / 3.0):
        return {"plate.youngs_modulus": modulus}
    return {
        "plate.youngs_modulus": None,
        "plate.first_frequency": beam_frequency(scene, length, width, modulus),
    }


def _corner(choices: Choices, dice: Dice, length: float, elements: tuple[int, int]) -> Changes:
    changes: dict[str, Any] = {}
    if choices.constraint == "exact":
        changes["corner.constraint"] = "exact"
    elif choices.constraint != "open":
        changes |= {"corner.constraint": "penalty", "corner.penalty_scale": dice.ratio(0.1, 10.0**1.5)}
    if choices.constraint == "dashpot":
        changes["corner.damping_ratio"] = dice.ratio(0.01, 1.0)
    if choices.patch:
        changes["corner.patch_length"] = max(dice.even(0.1, 0.3) * length, 1.2 * length / elements[0])
    return changes


def _damping(choices: Choices, dice: Dice) -> Changes:
    if choices.damping == "ratio":
        return {"damping.ratio": dice.ratio(0.005, 0.3)}
    if choices.damping == "bulk":
        return {"damping.bulk_viscosity": 0.06}
    return {"damping.kind": "none"} if choices.damping == "none" else {}
