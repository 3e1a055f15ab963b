"""The methods and settings whose error and run time are measured."""

from __future__ import annotations

from dataclasses import dataclass, field

from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes

EXACT, ODE, MODAL, FE = "exact", "ode", "modal", "fe"
"""Kinds of method: the exact rigid solution, SciPy's integrators of the rigid equations, the plate by a few modes,
finite elements."""

INTEGRATORS = ("RK45", "DOP853", "Radau", "LSODA")
RTOLS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
SAFETY_FACTORS = (0.45, 0.225)
"""Halves of the default, each of the last."""

MESH, STEP, CONSTRAINT, ROWSUM, UNSTRESSED = (
    "mesh",
    "time step",
    "exact constraint",
    "row-sum masses",
    "unstressed start",
)
PENALTY, DAMPING, MODES, ELEMENTS = "penalty", "damping", "modal model", "other elements"
SINGLE, RIGID = "single precision", "rigid vehicle"
"""Groups of settings."""


@dataclass(frozen=True)
class Setting:
    """A method with its setting: the group it is drawn in, a label, and what it changes in the scene.

    rtol: of an integrator; modes: of the modal model; single: the time loop stores single precision; refinement:
    how fine it is within its group. soft: of the soft plate, not of the scene as it is; choice: on the soft plate,
    not a mesh but a choice made on one mesh.
    """

    kind: str
    group: str
    label: str
    changes: Changes = field(default_factory=dict)
    rtol: float = 0.0
    modes: int = 0
    single: bool = False
    refinement: float = 1.0
    soft: bool = False
    choice: bool = False

    @property
    def name(self) -> str:
        """Group and label."""
        return f"{self.group}: {self.label}"

    @property
    def key(self) -> str:
        """Name by which a journal knows the setting."""
        return f"soft plate, {self.name}" if self.soft else self.name


def settings(scene: Scene) -> list[Setting]:
    """All settings for the scene as it is, cheap methods first; some the scene may refuse."""
    rigid = [Setting(EXACT, "exact", "closed form")]
    rigid += [Setting(ODE, name, f"rtol {rtol:g}", rtol=rtol) for name in INTEGRATORS for rtol in RTOLS]
    rigid += [Setting(MODAL, MODES, f"{n} modes", modes=n) for n in (0, 1, 2, 4, 8)]
    return rigid + _meshes(scene) + _elements() + _choices()


def _meshes(scene: Scene) -> list[Setting]:
    exact, row_sum = {"corner.constraint": "exact"}, {"plate.lumping": "row-sum"}
    return [
        *(_mesh(scene, MESH, factor) for factor in (0.25, 0.5, 1.0, 2.0, 4.0)),
        *(_mesh(scene, CONSTRAINT, factor, exact) for factor in (0.5, 1.0, 2.0, 4.0)),
        *(_mesh(scene, ROWSUM, factor, row_sum) for factor in (0.5, 1.0, 2.0, 4.0)),
    ]


def _elements() -> list[Setting]:
    """Other elements on the scene's mesh; how they converge is seen on the soft plate."""
    kinds = [Setting(FE, ELEMENTS, name, {"plate.element": name}) for name in ("quad9", "tri3", "tri6")]
    reduced = {"plate.element": "quad4-reduced", "damping.ratio": 0.01}
    return [*kinds, Setting(FE, ELEMENTS, "quad4-reduced", reduced)]


def _choices() -> list[Setting]:
    unstressed = {"plate.start": "unstressed", "corner.constraint": "penalty"}
    return [
        *_values(STEP, "safety factor", "time.safety_factor", SAFETY_FACTORS),
        *_values(PENALTY, "scale", "corner.penalty_scale", (0.01, 0.1, 0.3, 3.0, 10.0)),
        *_values(DAMPING, "ratio", "damping.ratio", (0.01, 0.1, 0.5)),
        Setting(FE, UNSTRESSED, "undamped", unstressed),
        Setting(FE, UNSTRESSED, "damping 0.2", {**unstressed, "damping.ratio": 0.2}),
        Setting(FE, UNSTRESSED, "dashpot 0.5", {**unstressed, "corner.damping_ratio": 0.5}),
        Setting(FE, "history", "10 rows", {"time.rows": 10}),
        Setting(FE, SINGLE, "stored", single=True),
    ]


def _values(group: str, label: str, key: str, values: tuple[float, ...]) -> list[Setting]:
    return [Setting(FE, group, f"{label} {value:g}", {key: value}) for value in values]


def _mesh(scene: Scene, group: str, factor: float, more: Changes | None = None) -> Setting:
    """The scene's mesh with so many times the elements each way."""
    plate = scene.needed_plate
    along, across = (max(2, round(factor * count)) for count in plate.counts)
    changes = {"plate.element": plate.element, "plate.elements": (along, across), **(more or {})}
    return Setting(FE, group, f"{along} x {across}", changes, refinement=factor)
