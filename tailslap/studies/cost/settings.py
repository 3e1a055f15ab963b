"""The methods and settings whose error and run time are measured."""

from __future__ import annotations

from dataclasses import dataclass

from tailslap.scene.schema import Scene

EXACT, ODE, MODAL, FE = "exact", "ode", "modal", "fe"
"""Kinds of method: the exact rigid solution, SciPy's integrators of the rigid equations, the plate by a few modes,
finite elements."""

INTEGRATORS = ("RK45", "DOP853", "Radau", "LSODA")
RTOLS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
SAFETY_FACTORS = (0.45, 0.225)
"""Halves of the default, each of the last."""

MESH, STEP, HOLD, ROWSUM, SUDDEN = (
    "mesh",
    "time step",
    "exact constraint",
    "row-sum masses",
    "unstressed start",
)
PENALTY, DAMPING, MODES, ELEMENTS = "penalty", "damping", "modal model", "other elements"
SINGLE = "single precision"
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
    changes: tuple[str, ...] = ()
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
    exact = ("corner.constraint=exact",)
    return [
        *(_mesh(scene, MESH, factor) for factor in (0.25, 0.5, 1.0, 2.0, 4.0)),
        *(_mesh(scene, HOLD, factor, exact) for factor in (0.5, 1.0, 2.0, 4.0)),
        *(_mesh(scene, ROWSUM, factor, ("plate.lumping=row-sum",)) for factor in (0.5, 1.0, 2.0, 4.0)),
    ]


def _elements() -> list[Setting]:
    """Other elements on the scene's mesh; how they converge is seen on the soft plate."""
    kinds = [_one(ELEMENTS, name, f"plate.element={name}") for name in ("quad9", "tri3", "tri6")]
    return [*kinds, _one(ELEMENTS, "quad4-reduced", "plate.element=quad4-reduced", "damping.ratio=0.01")]


def _choices() -> list[Setting]:
    steps = [_one(STEP, f"safety factor {x:g}", f"time.safety_factor={x}") for x in SAFETY_FACTORS]
    springs = [
        _one(PENALTY, f"scale {x:g}", f"corner.penalty_scale={x}") for x in (0.01, 0.1, 0.3, 3.0, 10.0)
    ]
    damped = [_one(DAMPING, f"ratio {x:g}", f"damping.ratio={x}") for x in (0.01, 0.1, 0.5)]
    sudden = [
        _one(SUDDEN, "undamped", "plate.start=unstressed", "corner.constraint=penalty"),
        _one(
            SUDDEN, "damping 0.2", "plate.start=unstressed", "corner.constraint=penalty", "damping.ratio=0.2"
        ),
        _one(
            SUDDEN,
            "dashpot 0.5",
            "plate.start=unstressed",
            "corner.constraint=penalty",
            "corner.damping_ratio=0.5",
        ),
    ]
    rows = [_one("history", "10 rows", "time.rows=10")]
    return [*steps, *springs, *damped, *sudden, *rows, Setting(FE, SINGLE, "stored", single=True)]


def _one(group: str, label: str, *changes: str) -> Setting:
    return Setting(FE, group, label, changes)


def _mesh(scene: Scene, group: str, factor: float, changes: tuple[str, ...] = ()) -> Setting:
    """The scene's mesh with so many times the elements each way."""
    assert scene.plate is not None
    along, across = (max(2, round(factor * count)) for count in scene.plate.counts)
    changes = (f"plate.element={scene.plate.element}", *changes, f"plate.elements=[{along}, {across}]")
    return Setting(FE, group, f"{along} x {across}", changes, refinement=factor)
