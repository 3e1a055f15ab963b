"""What the study runs: first frequencies, three meshes, the corner that they are held by, damping against flutter."""

from __future__ import annotations

import copy
import math
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tailslap.errors import InputError
from tailslap.fe_model import LEAST_STEPS, plate_density
from tailslap.fe_plan import FePlan, make_fe_plan, needed_plate
from tailslap.plan import Plan, make_plan
from tailslap.scene import Scene
from tailslap.scene_files import validate
from tailslap.studies.stability.axes import Tables, base_tables
from tailslap.units import Quantity

if TYPE_CHECKING:
    from fem.flutter import Flutter

HERTZ = Quantity("a frequency in cycles a second", "Hz", '"8 Hz"', least=0.01, most=1e5)
"""What --lowest and --highest may be."""

PATCH = 0.1
"""Length of the corner's patch over the vehicle's, where the scene gives none."""

LEAST_HALVED = (4, 2)
"""Elements along and across that the coarsest mesh keeps at least; otherwise the scene's own is the coarsest."""

TOO_LONG = 120.0
"""Expected seconds of a time loop above which a run is left out."""

NANOSECONDS = {"quad4": 12.0, "quad4-reduced": 12.0, "tri3": 8.0, "quad9": 75.0, "tri6": 40.0}
"""Time per element update on one core, roughly."""

RICH = ("quad9", "tri6")
"""Elements with twice the nodes along a side."""

MOST_JUDGED = 350
"""Nodes up to which flutter is foretold for the scene's own mesh: the analysis is dense."""

THICKNESSES = (1 / 6, 1 / 2, 5 / 6)
"""Places in the sweep where it is repeated by the thickness, from the stiffest (0) to the softest (1)."""


class Section(NamedTuple):
    """Thickness [m], density [kg/m^3] and modulus [Pa] of the scene's own plate."""

    thickness: float
    density: float
    youngs_modulus: float


@dataclass(frozen=True)
class Held:
    """How the corner is held: constraint and patch length [m], and whether the scene itself says so."""

    constraint: str
    patch: float
    own_constraint: bool
    own_patch: bool


@dataclass(frozen=True)
class Calming:
    """Flutter of the stiffest plate on a mesh: exponent of growth, damping ratio that calms it or None; f [Hz] and
    elements along the length for which it was foretold."""

    growth: float
    cure: float | None
    frequency: float
    along: int

    def ratio(self, frequency: float, along: int) -> float:
        """Damping ratio to put in for this first frequency and mesh, or 0.

        Rates of growth follow the frequencies of the modes: those of the plate, and on a finer mesh the highest.
        """
        from fem.flutter import CALM
        from tailslap.tolerance.calming import MARGIN

        finer = max(1.0, along / self.along)
        if self.cure is None or self.growth * frequency / self.frequency * finer <= CALM:
            return 0.0
        return min(1.0, MARGIN * self.cure * finer)


@dataclass(frozen=True)
class Sweep:
    """The study's definition. meshes: coarse to fine, each twice the last; own_frequency: of the scene's plate [Hz]."""

    plan: Plan
    frequencies: tuple[float, ...]
    meshes: tuple[tuple[int, int], ...]
    held: Held
    own_frequency: float
    own: Section


def frequencies(lowest: str, highest: str, points: int) -> tuple[float, ...]:
    """First frequencies [Hz] from the highest to the lowest, at even ratios. Raises InputError."""
    low, high = (_hertz(*given) for given in (("--lowest", lowest), ("--highest", highest)))
    if not low < high:
        raise InputError("--lowest", lowest, f'allowed is less than --highest, which is "{highest}"')
    return tuple(np.geomspace(high, low, points).tolist())


def _hertz(option: str, given: str) -> float:
    value: float | str = given
    with suppress(ValueError):
        value = float(given)
    try:
        return HERTZ.parse(value)
    except ValueError as error:
        raise InputError(option, given, str(error)) from None


def define(plan: Plan, sweep: tuple[float, ...]) -> tuple[Sweep, FePlan]:
    """The sweep, and the scene's own finite-element plan. Raises InputError for keys that make no model."""
    fe_plan, meshes = make_fe_plan(plan), three_meshes(plan.scene)
    plate = fe_plan.plate
    assert plate.youngs_modulus is not None
    own = Section(plate.thickness, plate_density(plan, plate), plate.youngs_modulus)
    corner = held(plan.scene, meshes[0])
    return Sweep(plan, sweep, meshes, corner, fe_plan.first_frequency, own), fe_plan


def three_meshes(scene: Scene) -> tuple[tuple[int, int], ...]:
    """The scene's mesh halved, itself, doubled; or where it cannot be halved, itself, doubled, and doubled again."""
    along, across = needed_plate(scene).elements
    patch, length = scene.corner.patch_length, scene.vehicle.length
    halves = along % 2 == 0 and across % 2 == 0 and along // 2 >= LEAST_HALVED[0]
    halves = halves and across // 2 >= LEAST_HALVED[1] and (patch is None or patch * (along // 2) >= length)
    coarse = (along // 2, across // 2) if halves else (along, across)
    return tuple((n * coarse[0], n * coarse[1]) for n in (1, 2, 4))


def held(scene: Scene, coarsest: tuple[int, int]) -> Held:
    """The scene's hold where it says one, else the exact constraint over a patch of whole elements."""
    corner, element = scene.corner, scene.vehicle.length / coarsest[0]
    own = bool(corner.model_fields_set & {"constraint", "penalty_scale", "damping_ratio"})
    patch = corner.patch_length or max(1, round(PATCH * scene.vehicle.length / element)) * element
    return Held(corner.constraint if own else "exact", patch, own, corner.patch_length is not None)


def judged_mesh(plan: Plan) -> tuple[int, int]:
    """The scene's mesh, or a coarser one where the dense analysis of flutter would take too long."""
    plate = needed_plate(plan.scene)
    along, across = plate.elements
    order = 2 if plate.element in RICH else 1
    while (order * along + 1) * (order * across + 1) > MOST_JUDGED and min(along, across) > 2:
        along, across = along // 2, across // 2
    return along, across


def foretell(sweep: Sweep) -> dict[str, Any]:
    """Flutter of the stiffest plate of the sweep, as a record: the fields of `Calming`."""
    from fem.flutter import foresee_flutter

    highest, mesh = sweep.frequencies[0], judged_mesh(sweep.plan)
    found: Flutter | None = None
    if sweep.plan.scene.damping is None:
        tables = run_tables(sweep, highest, mesh)
        if sweep.held.patch * mesh[0] < sweep.plan.body.length * (1.0 - 1e-9):
            tables["corner"].pop(
                "patch_length"
            )  # shorter than an element of the coarser mesh: held at one node
        fe_plan = make_fe_plan(make_plan(validate(tables)))
        found = foresee_flutter(fe_plan.model, fe_plan.start, sweep.plan.motion.strike.t)
    growth, cure = (found.growth, found.cure) if found else (0.0, None)
    return {"growth": growth, "cure": cure, "frequency": highest, "along": mesh[0]}


def run_tables(sweep: Sweep, frequency: float, elements: tuple[int, int], damping: float = 0.0) -> Tables:
    """The scene with this first frequency [Hz] and mesh, its corner held as the study holds it."""
    tables = copy.deepcopy(base_tables(sweep.plan.scene))
    plate, corner = tables["plate"], tables.setdefault("corner", {})
    plate.pop("youngs_modulus", None)
    plate |= {"first_frequency": frequency, "elements": elements}
    corner |= {"patch_length": sweep.held.patch}
    if not sweep.held.own_constraint:
        corner["constraint"] = sweep.held.constraint
    if damping:
        tables["damping"] = {"ratio": damping}
    return tables


def half_patch_tables(tables: Tables) -> Tables:
    """The same with the corner held over half the length of side."""
    tables = copy.deepcopy(tables)
    tables["corner"]["patch_length"] *= 0.5
    return tables


def expected_seconds(sweep: Sweep, fe_plan: FePlan, frequency: float, elements: tuple[int, int]) -> float:
    """Time that the loop is expected to take, from the scene's own steps."""
    own = fe_plan.plate.elements
    finer = elements[0] / own[0]
    steps = max(LEAST_STEPS, fe_plan.expected_steps * finer * frequency / sweep.own_frequency)
    return math.prod(elements) * steps * NANOSECONDS[fe_plan.plate.element] * 1e-9


def thickness_places(points: int) -> set[int]:
    """Which points of the sweep are repeated by the thickness."""
    return {round(share * (points - 1)) for share in THICKNESSES}
