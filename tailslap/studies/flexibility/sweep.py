"""What the study runs: first frequencies, three meshes, the corner that they are held by, three starts."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fem.start.start_kinds import START_KINDS
from tailslap.case.corner.case import CornerCase
from tailslap.case.cost import loop_seconds
from tailslap.errors import InputError
from tailslap.planning.fe_model import MIN_STEPS, plate_density
from tailslap.planning.fe_plan import FePlan, make_fe_plan
from tailslap.scene.schema import Scene
from tailslap.scene.units import Quantity
from tailslap.scene.vary import Changes

STARTS = ("inertia-relief", "inertia-relief-momenta", "unstressed")
"""The starts that are run, whatever the scene's own; the first with meshes, modal model and thicknesses beside it."""

HERTZ = Quantity("a frequency in cycles a second", "Hz", '"8 Hz"', least=0.01, most=1e5)
"""What --lowest and --highest may be."""

PATCH = 0.1
"""Length of the corner's patch over the vehicle's, where the scene gives none."""

MIN_HALVED = (4, 2)
"""Elements along and across that the coarsest mesh keeps at least; otherwise the scene's own is the coarsest."""

TOO_LONG = 120.0
"""Expected seconds of a time loop above which a run is left out."""

THICKNESSES = (1 / 6, 1 / 2, 5 / 6)
"""Places in the sweep where it is repeated by the thickness, from the stiffest (0) to the softest (1)."""

ROWS_A_PERIOD, MAX_ROWS = 12, 20_000
"""Rows of the history of a start that oscillates, a period of the first frequency: enough to see its largest swing."""


class Section(NamedTuple):
    """Thickness [m], density [kg/m^3] and modulus [Pa] of the scene's own plate."""

    thickness: float
    density: float
    youngs_modulus: float


@dataclass(frozen=True)
class Support:
    """How the corner is held: constraint and patch length [m], and whether the scene itself says so."""

    constraint: str
    patch: float
    own_constraint: bool
    own_patch: bool


@dataclass(frozen=True)
class Sweep:
    """The study's definition. meshes: coarse to fine, each twice the last; element: that of the scene's own plate;
    own_frequency: of that plate [Hz]."""

    plan: CornerCase
    frequencies: tuple[float, ...]
    meshes: tuple[tuple[int, int], ...]
    element: str
    support: Support
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


def define(plan: CornerCase, sweep: tuple[float, ...]) -> tuple[Sweep, FePlan]:
    """The sweep, and the scene's own finite-element plan. Raises InputError for keys that make no model."""
    fe_plan = make_fe_plan(plan)
    plate, meshes = fe_plan.plate, three_meshes(fe_plan.case.scene)
    own = Section(plate.thickness, plate_density(plan.scene, plate), plate.modulus)
    corner = corner_support(plan.scene, meshes[0])
    return Sweep(plan, sweep, meshes, plate.element, corner, fe_plan.first_frequency, own), fe_plan


def three_meshes(scene: Scene) -> tuple[tuple[int, int], ...]:
    """The scene's mesh halved, itself, doubled; or where it cannot be halved, itself, doubled, and doubled again.

    scene: one whose elements are decided.
    """
    along, across = scene.needed_plate.counts
    patch, length = scene.corner.patch_length, scene.vehicle.length
    halves = along % 2 == 0 and across % 2 == 0 and along // 2 >= MIN_HALVED[0]
    halves = halves and across // 2 >= MIN_HALVED[1] and (patch is None or patch * (along // 2) >= length)
    coarse = (along // 2, across // 2) if halves else (along, across)
    return tuple((n * coarse[0], n * coarse[1]) for n in (1, 2, 4))


def corner_support(scene: Scene, coarsest: tuple[int, int]) -> Support:
    """The scene's own where it gives one, else the exact constraint over a patch of whole elements."""
    corner, element = scene.corner, scene.vehicle.length / coarsest[0]
    own = bool(corner.model_fields_set & {"constraint", "penalty_scale", "damping_ratio"})
    patch = corner.patch_length or max(1, round(PATCH * scene.vehicle.length / element)) * element
    return Support(corner.constraint if own else "exact", patch, own, corner.patch_length is not None)


def run_changes(sweep: Sweep, frequency: float, elements: tuple[int, int], start: str = STARTS[0]) -> Changes:
    """What gives the scene this first frequency [Hz], mesh and start, its corner supported as in the study."""
    changes: dict[str, Any] = {
        "wall": None,
        "verify": None,  # plates that differ from the rigid body are the subject, and no failure
        "plate.youngs_modulus": None,
        "plate.first_frequency": frequency,
        "plate.elements": elements,
        "plate.element": sweep.element,
        "plate.start": start,
        "corner.patch_length": sweep.support.patch,
    }
    if not sweep.support.own_constraint:
        changes["corner.constraint"] = sweep.support.constraint
    if not START_KINDS[start].relieved:
        changes["time.rows"] = _rows(sweep, frequency)
    return changes


def _rows(sweep: Sweep, frequency: float) -> int:
    """Rows of the history that show every swing of a plate of this first frequency [Hz]."""
    periods = frequency * sweep.plan.motion.strike.t
    return max(sweep.plan.scene.time.rows, min(MAX_ROWS, math.ceil(ROWS_A_PERIOD * periods)))


def expected_seconds(sweep: Sweep, fe_plan: FePlan, frequency: float, elements: tuple[int, int]) -> float:
    """Time that the loop is expected to take, from the scene's own steps."""
    finer = elements[0] / fe_plan.plate.counts[0]
    steps = max(MIN_STEPS, fe_plan.expected_steps * finer * frequency / sweep.own_frequency)
    return loop_seconds(sweep.plan.scene, fe_plan.plate.element, elements, steps)


def thickness_places(points: int) -> set[int]:
    """Which points of the sweep are repeated by the thickness."""
    return {round(share * (points - 1)) for share in THICKNESSES}
