"""The methods and settings whose error and run time are measured."""

from __future__ import annotations

from dataclasses import dataclass

from tailslap.scene import Scene

EXACT, ODE, MODAL, FE = "exact", "ode", "modal", "fe"
"""Kinds of method: the exact rigid solution, SciPy's integrators of the rigid equations, the plate by a few modes,
finite elements."""

INTEGRATORS = ("RK45", "DOP853", "Radau", "LSODA")
RTOLS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
SAFETY_FACTORS = (0.45, 0.225)
"""Halves of the default, each of the last."""

MESH, STEP, HOLD = "mesh", "time step", "exact constraint"
"""Groups of settings that the grid convergence is read off."""


@dataclass(frozen=True)
class Setting:
    """A method with its setting: the group it is drawn in, a label, and what it changes in the scene.

    rtol: of an integrator; modes: of the modal model; single: the time loop stores single precision; refinement:
    elements over the scene's.
    """

    kind: str
    group: str
    label: str
    changes: tuple[str, ...] = ()
    rtol: float = 0.0
    modes: int = 0
    single: bool = False
    refinement: float = 1.0

    @property
    def key(self) -> str:
        """Name by which a journal knows the setting."""
        return f"{self.group}: {self.label}"


def settings(scene: Scene) -> list[Setting]:
    """All settings for this scene, cheap methods first; some the scene may refuse."""
    rigid = [Setting(EXACT, "exact", "closed form")]
    rigid += [Setting(ODE, name, f"rtol {rtol:g}", rtol=rtol) for name in INTEGRATORS for rtol in RTOLS]
    rigid += [Setting(MODAL, "modal model", f"{n} modes", modes=n) for n in (0, 1, 2, 4, 8)]
    return rigid + _meshes(scene) + _elements(scene) + _choices(scene)


def _meshes(scene: Scene) -> list[Setting]:
    exact = ("corner.constraint=exact",)
    return [
        *(_mesh(scene, MESH, factor) for factor in (0.25, 0.5, 1.0, 2.0, 4.0)),
        *(_mesh(scene, HOLD, factor, exact) for factor in (0.5, 1.0, 2.0, 4.0)),
        *(
            _mesh(scene, "row-sum masses", factor, ("plate.lumping=row-sum",))
            for factor in (0.5, 1.0, 2.0, 4.0)
        ),
    ]


def _elements(scene: Scene) -> list[Setting]:
    kinds = {"quad9": (0.25, 0.5, 1.0), "tri3": (0.5, 1.0, 2.0), "tri6": (0.25, 0.5, 1.0)}
    found = [
        _mesh(scene, name, factor, (f"plate.element={name}",))
        for name, factors in kinds.items()
        for factor in factors
    ]
    calmed = ("plate.element=quad4-reduced", "damping.ratio=0.01")
    return found + [_mesh(scene, "quad4-reduced", factor, calmed) for factor in (0.5, 1.0, 2.0)]


def _choices(scene: Scene) -> list[Setting]:
    steps = [_one(STEP, f"safety factor {x:g}", f"time.safety_factor={x}") for x in SAFETY_FACTORS]
    springs = [
        _one("penalty", f"scale {x:g}", f"corner.penalty_scale={x}") for x in (0.01, 0.1, 0.3, 3.0, 10.0)
    ]
    damped = [_one("damping", f"ratio {x:g}", f"damping.ratio={x}") for x in (0.01, 0.1, 0.5)]
    sudden = [
        _one("sudden start", "undamped", "plate.start=sudden"),
        _one("sudden start", "damping 0.2", "plate.start=sudden", "damping.ratio=0.2"),
        _one("sudden start", "dashpot 0.5", "plate.start=sudden", "corner.damping_ratio=0.5"),
    ]
    rows = [_one("history", "10 rows", "time.rows=10")]
    return [*steps, *springs, *damped, *sudden, *rows, Setting(FE, "single precision", "stored", single=True)]


def _one(group: str, label: str, *changes: str) -> Setting:
    return Setting(FE, group, label, changes)


def _mesh(scene: Scene, group: str, factor: float, changes: tuple[str, ...] = ()) -> Setting:
    """The scene's mesh with so many times the elements each way."""
    assert scene.plate is not None
    along, across = (max(2, round(factor * count)) for count in scene.plate.elements)
    label = f"{along} x {across}"
    return Setting(FE, group, label, (*changes, f"plate.elements=[{along}, {across}]"), refinement=factor)
