"""Random cells: a scene with every quantity and every choice drawn, known by seed and number."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tailslap.errors import InputError
from tailslap.planning.plan import make_plan
from tailslap.scene.files import validate
from tailslap.studies.stability.axes import Cell, Tables
from tailslap.studies.stability.effort import beam_frequency, expected_effort

MAX_STEPS, MAX_SECONDS = 400_000, 3.0
"""Steps, and seconds of its time loop, that a run may be expected to take."""

MAX_TRIES = 1000
"""Scenes drawn for one cell until one is possible and affordable; about one in three is."""

ELEMENTS = ("quad4", "quad4-reduced", "quad9", "tri3", "tri6")
RELIEVED = ("inertia-relief", "inertia-relief-momenta")
OPEN = 0.3
"""Share of the cells that leave a choice to the program."""


class _Dice:
    """Random numbers of one draw."""

    def __init__(self, seed: int, number: int) -> None:
        self._random = np.random.default_rng((seed, number))

    def even(self, low: float, high: float) -> float:
        return float(self._random.uniform(low, high))

    def ratio(self, low: float, high: float) -> float:
        return math.exp(self.even(math.log(low), math.log(high)))

    def happens(self, share: float) -> bool:
        return self.even(0.0, 1.0) < share

    def one_of(self, values: Sequence[str], shares: Sequence[float] | None = None) -> str:
        return values[int(self._random.choice(len(values), p=shares))]


def random_cells(base: Tables, seed: int, count: int) -> list[Cell]:
    """The first so many draws of a seed."""
    drawn = [draw(base, seed, number) for number in range(count)]
    return [Cell(f"{n:04d}", {"number": n, **flat(tables)}, tables) for n, tables in enumerate(drawn)]


def flat(tables: Tables) -> dict[str, Any]:
    """Values of a scene by the full names of their keys, sorted."""
    inner = [(name, table) for name, table in tables.items() if isinstance(table, dict)]
    return dict(sorted((f"{name}.{key}", value) for name, table in inner for key, value in table.items()))


def draw(base: Tables, seed: int, number: int) -> Tables:
    """The tables of a cell. Raises InputError where the scene allows no possible and affordable one."""
    dice = _Dice(seed, number)
    for _ in range(MAX_TRIES):
        tables = _drawn(base, dice, number)
        if _affordable(tables):
            return tables
    raise InputError(
        "--random", number, f"none of {MAX_TRIES} draws of this scene is possible and affordable"
    )


def _affordable(tables: Tables) -> bool:
    """Whether the rigid motion exists, and a run is not too long."""
    try:
        effort = expected_effort(make_plan(validate(tables)))
    except InputError:
        return False
    return effort.steps <= MAX_STEPS and effort.seconds <= MAX_SECONDS


def _drawn(base: Tables, dice: _Dice, number: int) -> Tables:
    tables = copy.deepcopy(base)
    for name in ("verify", "wall", "damping", "material"):
        tables.pop(name, None)
    _draw_vehicle(tables, dice)
    _draw_motion(tables, dice)
    _draw_plate(tables, dice, number)
    _draw_corner(tables, dice)
    _draw_damping(tables, dice)
    if dice.happens(0.5):
        tables["material"] = {"law": "neo-hookean"}
    tables["name"] = f"cell-{number:04d}"  # type: ignore[assignment]
    return tables


def _draw_vehicle(tables: Tables, dice: _Dice) -> None:
    length = dice.even(3.0, 20.0)
    tables["vehicle"] |= {"length": length, "width": length * dice.ratio(0.05, 1.0)}


def _draw_motion(tables: Tables, dice: _Dice) -> None:
    """Stage 1 where the scene has it, for Stage 2 to follow; else the start, the spin in proportion to the speed."""
    speed, angle = dice.ratio(1.0, 40.0), math.radians(dice.even(2.0, 60.0))
    restitution, friction = dice.even(0.0, 0.8), 0.0 if dice.happens(0.1) else dice.even(0.0, 1.2)
    reaction = dice.one_of(("drag", "none", "signed"), (0.6, 0.2, 0.2))
    corner = tables["corner"] = {"reaction": reaction}
    if "impact" in tables:
        tables.pop("start", None)
        drawn = {"speed": speed, "angle": angle, "restitution": restitution, "friction": friction}
        tables["impact"] |= drawn
        return
    spin = tables["start"]["omega"] / tables["start"]["corner_speed"]
    tables["start"] = {"angle": angle, "corner_speed": speed, "omega": spin * speed}
    if reaction != "none":
        corner["friction"] = friction


def _draw_plate(tables: Tables, dice: _Dice, number: int) -> None:
    plate = tables["plate"]
    for key in ("elements", "element", "hourglass", "lumping", "distortion"):
        plate.pop(key, None)
    plate["start"] = RELIEVED[number // 3 % 2] if number % 3 else "unstressed"
    _draw_stiffness(tables, dice)
    if not dice.happens(OPEN):
        plate["elements"] = (round(dice.ratio(4.0, 40.0)), round(dice.ratio(2.0, 12.0)))
    if not dice.happens(OPEN):
        plate["element"] = dice.one_of(ELEMENTS)
    if dice.happens(0.1):
        plate["lumping"] = "row-sum"
    if dice.happens(0.3):
        plate["distortion"] = dice.even(0.0, 0.2)


def _draw_stiffness(tables: Tables, dice: _Dice) -> None:
    """A modulus from 1e-4 to 1e4 times the scene's, for a third of the cells by the frequency that it gives a beam."""
    plate, factor = tables["plate"], dice.ratio(1e-4, 1e4)
    if "first_frequency" in plate:
        plate["first_frequency"] *= math.sqrt(factor)
        return
    plate["youngs_modulus"] *= factor
    if dice.happens(1.0 / 3.0):
        plate["first_frequency"] = beam_frequency(tables)
        del plate["youngs_modulus"]


def _draw_corner(tables: Tables, dice: _Dice) -> None:
    corner, length = tables["corner"], tables["vehicle"]["length"]
    hold = dice.one_of(("open", "penalty", "exact", "dashpot"), (0.4, 0.2, 0.2, 0.2))
    if hold == "exact":
        corner["constraint"] = "exact"
    elif hold != "open":
        corner |= {"constraint": "penalty", "penalty_scale": dice.ratio(0.1, 10.0**1.5)}
    if hold == "dashpot":
        corner["damping_ratio"] = dice.ratio(0.01, 1.0)
    if dice.happens(0.5):
        along = tables["plate"].get("elements", (10, 1))[0]
        corner["patch_length"] = max(dice.even(0.1, 0.3) * length, 1.2 * length / along)


def _draw_damping(tables: Tables, dice: _Dice) -> None:
    kind = dice.one_of(("open", "ratio", "bulk", "none"), (0.6, 0.15, 0.1, 0.15))
    if kind == "ratio":
        tables["damping"] = {"ratio": dice.ratio(0.005, 0.3)}
    elif kind == "bulk":
        tables["damping"] = {"bulk_viscosity": 0.06}
    elif kind == "none":
        tables["damping"] = {"kind": "none"}
