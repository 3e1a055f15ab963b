"""The flexible question: a plate soft enough that its own flexibility is far above the discretisation errors."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from tailslap.case.corner.case import CornerCase
from tailslap.planning.fe_model import resolved_plate
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes
from tailslap.studies.cost.settings import DAMPING, FE, MODAL, MODES, PENALTY, STEP, Setting

FREQUENCY, PATCH = 8.0, 0.2
"""First frequency [Hz], and about the length of the corner's patch over the vehicle's, where the scene gives none."""

ACROSS, STRETCH = 3, 1.2
"""Elements across the width of the coarsest mesh, and their length over their height."""

REFINED = {
    "quad4": (1, 2, 4, 8),
    "quad9": (1, 2, 4, 8),
    "tri3": (1, 2, 4, 8),
    "tri6": (1, 2, 4),
    "quad4-reduced": (1, 2, 4, 8),
}
"""How many times finer than the coarsest mesh, by element; all with the exact constraint."""

SPRING = "quad4, penalty"
"""Group of the meshes whose corner is held by the program's own spring."""

SCALES = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
RATIOS = (1.0, 0.3, 0.1, 0.03, 0.01)
SAFETY_FACTORS = (0.9, 0.45, 0.225, 0.1125)
COUNTS = (0, 1, 2, 4, 8)
CHOICE_MESH = 2
"""Choices are made on quad9, so many times finer than the coarsest mesh."""


def soft_changes(plan: CornerCase) -> dict[str, Any]:
    """What makes the scene's plate soft.

    The modulus that gives the first frequency is found once, so that every mesh is of the same plate. Friction is
    left out: on refined meshes a soft plate flutters with it.
    """
    scene, corner = plan.scene, plan.scene.corner
    changes = {
        "plate.youngs_modulus": modulus(plan),
        "plate.start": "inertia-relief",
        "corner.constraint": "exact",
        "corner.patch_length": patch(scene),
    }
    removed = ["plate.first_frequency"] if scene.needed_plate.first_frequency is not None else []
    friction = {"corner.friction": 0} if corner.reaction != "none" else {}
    spring = sorted(corner.model_fields_set & {"penalty_scale", "damping_ratio"}, reverse=True)
    removed += [f"corner.{key}" for key in spring] + (["damping"] if scene.damping else [])
    return changes | friction | dict.fromkeys(removed)


def modulus(plan: CornerCase) -> float:
    """Young's modulus [Pa] that gives a fine mesh the first frequency."""
    plate = plan.scene.needed_plate
    changes = {
        "first_frequency": frequency(plan.scene),
        "youngs_modulus": None,
        "element": "quad9",
        "elements": mesh(plan.scene, 4),
    }
    return resolved_plate(plan.scene, plate.model_copy(update=changes)).modulus


def frequency(scene: Scene) -> float:
    """First frequency of the soft plate [Hz]: the scene's own where it gives one."""
    own = scene.needed_plate.first_frequency
    return FREQUENCY if own is None else own


def patch(scene: Scene) -> float:
    """Length of the corner's patch [m]: the scene's own, else of whole elements of the coarsest mesh."""
    along = mesh(scene, 1)[0]
    return scene.corner.patch_length or max(1, round(PATCH * along)) * scene.vehicle.length / along


def mesh(scene: Scene, factor: int) -> tuple[int, int]:
    """Elements along and across, so many times the coarsest mesh's; the scene's own mesh does not matter here."""
    along = max(2, round(ACROSS * scene.vehicle.length / (scene.vehicle.width * STRETCH)))
    return factor * along, factor * ACROSS


def soft_settings(scene: Scene) -> list[Setting]:
    """Settings for the soft plate: meshes of every element, then choices on one mesh."""
    spring = {"corner.constraint": "penalty"}

    def choice(group: str, label: str, refinement: float, changes: Changes, **more: Any) -> Setting:
        on = _mesh(scene, group, "quad9", CHOICE_MESH, changes)
        return replace(on, label=label, refinement=refinement, choice=True, **more)

    return [
        *(_mesh(scene, name, name, factor) for name, factors in REFINED.items() for factor in factors),
        *(_mesh(scene, SPRING, "quad4", factor, spring) for factor in REFINED["quad4"]),
        *(choice(STEP, f"safety factor {x:g}", 1 / x, {"time.safety_factor": x}) for x in SAFETY_FACTORS),
        *(choice(PENALTY, f"scale {x:g}", x, {**spring, "corner.penalty_scale": x}) for x in SCALES),
        *(choice(DAMPING, f"ratio {x:g}", 1 / x, {"damping.ratio": x}) for x in RATIOS),
        *(choice(MODES, f"{n} modes", float(n), {}, kind=MODAL, modes=n) for n in COUNTS),
    ]


def _mesh(scene: Scene, group: str, element: str, factor: int, more: Changes | None = None) -> Setting:
    along, across = mesh(scene, factor)
    given = {"plate.element": element, "plate.elements": (along, across), **(more or {})}
    return Setting(FE, group, f"{along} x {across}", given, refinement=factor, soft=True)
