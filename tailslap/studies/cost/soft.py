"""The flexible question: a plate soft enough that its own flexibility is far above the discretisation errors."""

from __future__ import annotations

from tailslap.planning.fe_model import resolved_plate
from tailslap.planning.fe_plan import needed_plate
from tailslap.planning.plan import Plan
from tailslap.scene.schema import Scene
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


def soft_changes(plan: Plan) -> tuple[str, ...]:
    """What makes the scene's plate soft, as --set would give it.

    The modulus that gives the first frequency is found once, so that every mesh is of the same plate. Friction is
    left out: on refined meshes a soft plate flutters with it.
    """
    scene, corner = plan.scene, plan.scene.corner
    plate = needed_plate(scene)
    found = [
        f"plate.youngs_modulus={modulus(plan)!r}",
        "plate.start=inertia-relief",
        "corner.constraint=exact",
    ]
    found += [f"corner.patch_length={patch(scene)!r}"]
    found += ["plate.first_frequency="] if plate.first_frequency is not None else []
    found += ["corner.friction=0"] if corner.reaction != "none" else []
    found += [
        f"corner.{key}=" for key in ("penalty_scale", "damping_ratio") if key in corner.model_fields_set
    ]
    return (*found, *(["damping="] if scene.damping else []))


def modulus(plan: Plan) -> float:
    """Young's modulus [Pa] that gives a fine mesh the first frequency."""
    plate = needed_plate(plan.scene)
    changes = {
        "first_frequency": frequency(plan.scene),
        "youngs_modulus": None,
        "element": "quad9",
        "elements": mesh(plan.scene, 4),
    }
    found = resolved_plate(plan, plate.model_copy(update=changes)).youngs_modulus
    assert found is not None
    return found


def frequency(scene: Scene) -> float:
    """First frequency of the soft plate [Hz]: the scene's own where it gives one."""
    own = needed_plate(scene).first_frequency
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
    meshes = [_mesh(scene, name, name, factor) for name, factors in REFINED.items() for factor in factors]
    spring = ("corner.constraint=penalty",)
    meshes += [_mesh(scene, SPRING, "quad4", factor, spring) for factor in REFINED["quad4"]]
    steps = [
        _choice(scene, STEP, f"safety factor {x:g}", 1 / x, f"time.safety_factor={x}") for x in SAFETY_FACTORS
    ]
    springs = [
        _choice(scene, PENALTY, f"scale {x:g}", x, *spring, f"corner.penalty_scale={x}") for x in SCALES
    ]
    damped = [_choice(scene, DAMPING, f"ratio {x:g}", 1 / x, f"damping.ratio={x}") for x in RATIOS]
    modal = [_choice(scene, MODES, f"{n} modes", float(n), modes=n) for n in COUNTS]
    return [*meshes, *steps, *springs, *damped, *modal]


def _mesh(scene: Scene, group: str, element: str, factor: int, changes: tuple[str, ...] = ()) -> Setting:
    along, across = mesh(scene, factor)
    given = (f"plate.element={element}", f"plate.elements=[{along}, {across}]", *changes)
    return Setting(FE, group, f"{along} x {across}", given, refinement=factor, soft=True)


def _choice(
    scene: Scene, group: str, label: str, refinement: float, *changes: str, modes: int | None = None
) -> Setting:
    on = _mesh(scene, group, "quad9", CHOICE_MESH, changes)
    kind = FE if modes is None else MODAL
    return Setting(
        kind, group, label, on.changes, modes=modes or 0, refinement=refinement, soft=True, choice=True
    )
