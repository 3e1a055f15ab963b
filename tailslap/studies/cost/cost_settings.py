"""Methods and settings whose cost is measured."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from tailslap.campaign.records import Record
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact.case import ImpactCase
from tailslap.case.impact.plan import chosen_lengths
from tailslap.case.plate_input import resolved_plate
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes
from tailslap.studies.flexibility.impact_flexibility import patch_length

EXACT, ODE, MODAL, FE = "exact", "ode", "modal", "fe"
"""Kinds of method: exact rigid solution, integrators of the rigid equations, modal model, finite elements."""
INTEGRATORS = ("RK45", "DOP853", "Radau", "LSODA")
"""Groups of settings that are named by an integrator."""
MESH, STEP, CONSTRAINT, ROWSUM = "mesh", "time step", "exact constraint", "row-sum masses"
"""Other groups of settings."""
PENALTY, DAMPING, MODES, ELEMENTS = "penalty", "damping", "modal model", "other elements"
UNSTRESSED, RIGID_VEHICLE = "unstressed start", "rigid vehicle"
LABELS = {STEP: "safety factor", PENALTY: "scale", DAMPING: "ratio"}
"""Labels and keys of groups that vary one number."""
VARIED = {STEP: "time.safety_factor", PENALTY: "corner.penalty_scale", DAMPING: "damping.ratio"}
REFINED = {
    **dict.fromkeys(("quad4", "quad9", "tri3"), (1, 2, 4, 8)),
    "tri6": (1, 2, 4),
    "quad4-reduced": (1, 2, 4, 8),
}
"""Refinements of the coarsest mesh of the soft plate by element, with the exact constraint."""
MODE_COUNTS = 0, 1, 2, 4, 8
"""Numbers of modes of the modal model."""
SPRING = "quad4, penalty"
"""Group of meshes of the soft plate with the penalty constraint of the program."""


@dataclass(frozen=True)
class Setting:
    """A method with its setting.

    Parameters
    ----------
    kind, group, label : str
        Kind of method, group in the diagram, and label.
    changes : dict
        Changes of the scene.
    refinement : float
        Refinement within the group.
    soft : bool
        True for the soft plate, False for the scene as it is.
    choice : bool
        True for a choice on one mesh of the soft plate.
    number : float
        Relative tolerance of an integrator, or number of modes.
    """

    kind: str
    group: str
    label: str
    changes: Changes = field(default_factory=dict)
    refinement: float = 1.0
    soft: bool = False
    choice: bool = False
    number: float = 0.0

    @property
    def key(self) -> str:
        """Return the name of the setting in records and rows."""
        return f"{'soft plate, ' * self.soft}{self.group}: {self.label}"


def settings(scene: Scene) -> list[Setting]:
    """Return all settings of the scene.

    Cheap methods come first, and some may be invalid for the scene.
    """
    plate, unstressed = scene.needed_plate, {"plate.start": "unstressed", "corner.constraint": "penalty"}
    rtols, halves = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11), (0.5, 1.0, 2.0, 4.0)
    meshes: list[tuple[str, float, Changes]] = [(MESH, factor, {}) for factor in (0.25, *halves)]
    meshes += [(CONSTRAINT, factor, {"corner.constraint": "exact"}) for factor in halves]
    meshes += [(ROWSUM, factor, {"plate.lumping": "row-sum"}) for factor in halves]
    elements = ("quad9", "tri3", "tri6", "quad4-reduced")
    element_changes: dict[str, Record] = {name: {"plate.element": name} for name in elements}
    element_changes["quad4-reduced"] |= {"damping.ratio": 0.01}
    return [
        Setting(EXACT, "exact", "closed form"),
        *(Setting(ODE, name, f"rtol {rtol:g}", number=rtol) for name in INTEGRATORS for rtol in rtols),
        *map(_modal, MODE_COUNTS),
        *(_mesh(group, factor, plate.element, plate.counts, more) for group, factor, more in meshes),
        # The soft plate shows their convergence.
        *(Setting(FE, ELEMENTS, *item) for item in element_changes.items()),
        *_values(STEP, (0.45, 0.225)),
        *_values(PENALTY, (0.01, 0.1, 0.3, 3.0, 10.0)),
        *_values(DAMPING, (0.01, 0.1, 0.5)),
        Setting(FE, UNSTRESSED, "undamped", unstressed),
        Setting(FE, UNSTRESSED, "damping 0.2", {**unstressed, "damping.ratio": 0.2}),
        Setting(FE, UNSTRESSED, "dashpot 0.5", {**unstressed, "corner.damping_ratio": 0.5}),
        Setting(FE, "history", "10 rows", {"time.rows": 10}),
    ]


def soft_settings(scene: Scene) -> list[Setting]:
    """Return all settings of the soft plate.

    They are meshes of every element, then choices on one mesh of quad9.
    """
    counts, spring = soft_plate(scene)[2], {"corner.constraint": "penalty"}
    meshes = [_mesh(name, n, name, counts) for name, factors in REFINED.items() for n in factors]
    meshes += [_mesh(SPRING, n, "quad4", counts, spring) for n in REFINED["quad4"]]
    mesh = _mesh("", 2, "quad9", counts).changes
    choices = [
        *_values(STEP, (0.9, 0.45, 0.225, 0.1125), mesh, power=-1),
        *_values(PENALTY, (0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0), {**mesh, **spring}, power=1),
        *_values(DAMPING, (1.0, 0.3, 0.1, 0.03, 0.01), mesh, power=-1),
        *(_modal(n, mesh, float(n)) for n in MODE_COUNTS),
    ]
    return [replace(s, soft=True, choice=s in choices) for s in (*meshes, *choices)]


def impact_settings(case: ImpactCase) -> tuple[list[Setting], Changes, float]:
    """Return all settings of a whole impact.

    Further values are the changes common to all, and the length of the crushed side [m], at least an element of the
    coarsest mesh. The limit is that of quad9.
    """
    plate, contact = case.plan().plate, case.scene.needed_contact
    mesh = {"plate.element": "quad4", "plate.elements": plate.counts}
    elements = ("tri3", "tri6", "quad4-reduced")
    # A length in the scene is at least half an element of the coarsest quad9.
    coarsest = 1.0 if (contact.patch_length or math.inf) < case.vehicle.length / plate.counts[0] else 0.5
    chosen = [
        Setting(ODE, RIGID_VEHICLE, "fixed step"),
        *(_mesh("quad4", coarsest * factor, "quad4", plate.counts) for factor in (1.0, 2.0, 4.0, 8.0)),
        *(_mesh("quad9", coarsest * factor, "quad9", plate.counts) for factor in (1.0, 2.0, 4.0)),
        *(Setting(FE, ELEMENTS, name, {**mesh, "plate.element": name}) for name in elements),
        *_values(STEP, (0.45, 0.225), mesh),
        *_values(DAMPING, (0.01, 0.1), mesh),
    ]
    along = min(s.changes["plate.elements"][0] for s in chosen if s.kind == FE)
    patch = contact.patch_length or max(patch_length(case), case.vehicle.length / along)
    changes = {"plate.youngs_modulus": plate.youngs_modulus, "plate.first_frequency": None}
    changes |= chosen_lengths(case.scene)
    return chosen, changes | ({"contact.patch_length": patch} if case.scene.crushes else {}), patch


def _modal(modes: int, mesh: Changes | None = None, refinement: float = 1.0) -> Setting:
    """Return the setting of the modal model with this number of modes."""
    label = "1 mode" if modes == 1 else f"{modes} modes"
    return Setting(MODAL, MODES, label, mesh or {}, refinement, number=modes)


def _mesh(
    group: str, factor: float, element: str, counts: tuple[int, int], added: Changes | None = None
) -> Setting:
    """Return a setting with multiples of the elements per direction."""
    along, across = (max(2, round(factor * count)) for count in counts)
    changes = {"plate.element": element, "plate.elements": (along, across), **(added or {})}
    return Setting(FE, group, f"{along} x {across}", changes, factor)


def _values(
    group: str, values: Sequence[float], mesh: Changes | None = None, power: int = 0
) -> list[Setting]:
    """Return settings with values of a key on one mesh.

    `power` relates the refinement to the value.
    """
    label, key = LABELS[group], VARIED[group]
    return [Setting(FE, group, f"{label} {x:g}", {**(mesh or {}), key: x}, x**power) for x in values]


def soft_changes(case: CornerCase) -> Record:
    """Return the changes that make the scene's plate soft.

    The modulus follows from the first frequency of a fine mesh, so that all meshes have the same plate. Friction is
    removed, since a soft plate flutters with it on fine meshes.
    """
    scene, corner, plate = case.scene, case.scene.corner, case.scene.needed_plate
    frequency, patch, (along, across) = soft_plate(scene)
    fine: Record = {"element": "quad9", "elements": (4 * along, 4 * across)}
    fine |= {"first_frequency": frequency, "youngs_modulus": None}
    modulus = resolved_plate(scene, plate.model_copy(update=fine)).modulus
    changes = {"plate.youngs_modulus": modulus, "plate.start": "inertia-relief"}
    changes |= {"corner.constraint": "exact", "corner.patch_length": patch}
    removed = ["plate.first_frequency"] if plate.first_frequency is not None else []
    friction = {"corner.friction": 0} if corner.reaction != "none" else {}
    spring = sorted(corner.model_fields_set & {"penalty_scale", "damping_ratio"}, reverse=True)
    removed += [f"corner.{key}" for key in spring] + (["damping"] if scene.damping else [])
    return changes | friction | dict.fromkeys(removed)


def soft_plate(scene: Scene) -> tuple[float, float, tuple[int, int]]:
    """Return frequency, patch and coarsest mesh of the soft plate.

    Frequency [Hz] and length [m] are those of the scene where it has them. The mesh has three elements across, about
    1.2 times as long as wide.
    """
    length, frequency = scene.vehicle.length, scene.needed_plate.first_frequency
    along = max(2, round(3 * length / (scene.vehicle.width * 1.2)))
    patch = scene.corner.patch_length or max(1, round(0.2 * along)) * length / along
    return 8.0 if frequency is None else frequency, patch, (along, 3)
