"""The study `cost`: error and run time of every method and setting, and the cheapest for each error.

A constrained corner is asked two questions. The rigid one: how far from the exact rigid motion is the scene as it is?
The flexible one: how far from its own limit is a soft plate, whose flexibility is far above the errors of its meshes?
Of a whole impact only the second is asked, of the scene's own plate.
"""

import math
import statistics
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fem.explicit.time_loop import State
from fem.model.plate_model import PlateModel
from fem.run.corner import Stepper, simulate
from fem.run.impact import compile_impact_loop
from fem.start.inertia_relief import RigidStart
from postprocess.comparison import quantities
from postprocess.comparison.grid_convergence import GridConvergence
from postprocess.comparison.quantities import KEYS
from solver import integrate_odes, plane_motion
from tailslap import errors, modal_model, studies
from tailslap.campaign import engine
from tailslap.campaign.convergence import NO_LIMIT, Limit, finite, grids_of, halved, limit_of
from tailslap.case import case_of, cost
from tailslap.case.case import failed_names
from tailslap.case.corner.run import compare
from tailslap.case.impact import checks, run
from tailslap.case.model import resolved_plate
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, Source, shown, vary
from tailslap.studies.flexibility.compute import NAMES, patch_length

# Kinds of method: the exact rigid solution, integrators of the rigid equations, the plate by a few modes,
# finite elements.
EXACT, ODE, MODAL, FE = "exact", "ode", "modal", "fe"

# Groups of settings, beside those named by an integrator or an element.
INTEGRATORS = ("RK45", "DOP853", "Radau", "LSODA")
MESH, STEP, CONSTRAINT, ROWSUM = "mesh", "time step", "exact constraint", "row-sum masses"
PENALTY, DAMPING, MODES, ELEMENTS = "penalty", "damping", "modal model", "other elements"
UNSTRESSED, SINGLE, RIGID = "unstressed start", "single precision", "rigid vehicle"

# Labels and keys of the groups that vary one number.
LABELS = {STEP: "safety factor", PENALTY: "scale", DAMPING: "ratio"}
VARIED = {STEP: "time.safety_factor", PENALTY: "corner.penalty_scale", DAMPING: "damping.ratio"}

# How many times finer than the soft plate's coarsest mesh, by element; all with the exact constraint.
REFINED = {"quad4": (1, 2, 4, 8), "quad9": (1, 2, 4, 8), "tri3": (1, 2, 4, 8), "tri6": (1, 2, 4)}
REFINED["quad4-reduced"] = REFINED["quad4"]

# Group of the soft plate's meshes whose corner is held by the program's own spring.
SPRING = "quad4, penalty"

# Bound that the exact solution is held to: its distance from DOP853, at most, over 1000 inputs
# (benchmarks/rigid.py).
ROUNDING = 2.2e-12

# Expected seconds of a time loop above which a setting is left out.
TOO_LONG = 30.0

LEVELS = tuple(10.0**-exponent for exponent in range(2, 12))

Row = dict[str, Any]


@dataclass(frozen=True)
class Setting:
    """A method with its setting: the group it is drawn in, a label, and what it changes in the scene.

    refinement: how fine it is within its group. soft: of the soft plate, not of the scene as it is; choice: on the soft
    plate, not a mesh but a choice made on one mesh. number: relative tolerance of an integrator, number of modes.
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
        """Name by which records and rows know the setting."""
        return f"{'soft plate, ' * self.soft}{self.group}: {self.label}"


class CostResult(NamedTuple):
    """The finished study: a row a setting, and the limit that errors of the soft plate or the impact are from.

    mesh_limit: of the mesh that choices are made on; soft: what makes the plate soft; flexibility: distance of its
    limit from its rigid motion; patch: length that a corner's crush is spread over [m].
    """

    case: Any
    rows: list[Row]
    limit: Limit
    seconds: float = 0.0
    mesh_limit: Limit = NO_LIMIT
    convergence: Mapping[str, Mapping[str, GridConvergence]] = {}
    soft: tuple[str, ...] = ()
    flexibility: float = math.nan
    patch: float = math.nan

    def of(self, soft: bool) -> list[Row]:
        """Rows of the soft plate, or of the scene as it is."""
        return [row for row in self.rows if row["soft"] == soft]


def compute(case: Any, place: Path) -> CostResult:
    """Measure every setting; an interrupted study of the same scene goes on from its journal."""
    began, impact, patch = time.perf_counter(), case.scene.contact is not None, math.nan
    case = case if impact else studies.with_elements(case)
    if impact:
        todo, changes, patch = impact_settings(case)
    else:
        todo, changes = [*settings(case.scene), *soft_settings(case.scene)], soft_changes(case)
    varied = case.varied(changes)
    definition = {"study": "cost", "scene": case.scene.model_dump(), "settings": [s.key for s in todo]}
    parts = {s.key: ((varied if impact or s.soft else case).source, s) for s in todo}
    # One after the other: they are timed.
    (found,) = engine.run_study(place, definition, [(measure, parts, f"{len(todo)} settings")], workers=1)
    seconds = time.perf_counter() - began
    if not impact:
        return summed_up(case, todo, found, shown(changes), varied.tail_slap)._replace(seconds=seconds)
    limit = limit_of([found[s.key] for s in todo if s.group == "quad9"], NAMES)
    return CostResult(case, [row_of(s, found[s.key], limit) for s in todo], limit, seconds, patch=patch)


def summed_up(
    case: Any, todo: list[Setting], noted: Row, soft: tuple[str, ...], truth: Mapping[str, float]
) -> CostResult:
    """The study of a constrained corner by its records; truth: the rigid motion of the soft plate's scene."""
    meshes = [s for s in todo if s.group == MESH and s.refinement >= 0.5]
    # The scene's own step is that of its own mesh; the others are halves of it.
    steps = [s for s in todo if not s.soft and (s.group == STEP or (s in meshes and s.refinement == 1.0))]
    groups = {MESH: meshes, STEP: steps}
    for name in ("quad4", "quad9", STEP):
        groups[f"soft plate, {name}"] = [s for s in todo if s.soft and s.group == name]
    found = {group: [noted[s.key] for s in chosen] for group, chosen in groups.items()}
    limit, halves = limit_of(found["soft plate, quad9"]), found[f"soft plate, {STEP}"]
    mesh_limit, exact = limit_of(halves if halved(halves) else []), Limit(case.tail_slap, ROUNDING)
    rows = [row_of(s, noted[s.key], limit if s.soft else exact, mesh_limit) for s in todo]
    grids = {group: grids_of(its) for group, its in found.items() if STEP not in group or halved(finite(its))}
    convergence = {group: each for group, each in grids.items() if each}
    flexibility = quantities.largest_relative(limit.values, truth)
    return CostResult(case, rows, limit, 0.0, mesh_limit, convergence, soft, flexibility)


def row_of(setting: Setting, record: Row, limit: Limit, mesh_limit: Limit = NO_LIMIT) -> Row:
    """The row of a setting's record; mesh_limit: what a choice's own error is measured from.

    error: from the limit, never below what that is known to; added: what a choice adds to the error of its mesh, else
    NaN. Times [s] in a process that has all it needs compiled and loaded: the fastest of several, and the median.
    """
    columns = ("kind", "group", "label", "refinement", "soft", "choice")
    values, setups, loops = (record.get(name) for name in ("values", "setup", "loop"))
    error = limit.error_of(values) if values else math.nan
    added = mesh_limit.error_of(values) if values and setting.choice else math.nan
    setup, loop, median = min(setups or [0.0]), min(loops or [0.0]), statistics.median(loops or [0.0])
    times = {"seconds": setup + loop, "setup_s": setup, "loop_s": loop, "median_s": median}
    found = {"setting": setting.key, **{name: getattr(setting, name) for name in columns}}
    found |= {"error": error, "added": added, **times, "compile_s": record.get("compile", 0.0)}
    failed = ", ".join(record.get("failed", ()))
    return found | {"steps": record.get("steps", 0), "failed": failed, "refused": record.get("refused", "")}


def own_error(row: Row) -> float:
    """Error that a choice adds; else the error."""
    return float(row["added" if row["choice"] else "error"])


def is_valid(row: Row) -> bool:
    """True if it gave a result that passed the program's checks."""
    return not row["refused"] and not row["failed"] and math.isfinite(row["error"])


def front(rows: Iterable[Row]) -> list[Row]:
    """The rows that no other beats in both time and error. The exact solution is what errors are measured from, and
    choices are made on one mesh: neither is among them."""
    found: list[Row] = []
    for row in sorted(filter(is_valid, rows), key=lambda row: (row["seconds"], row["error"])):
        beats = not found or row["error"] < found[-1]["error"]
        if beats and row["kind"] != EXACT and not row["choice"]:
            found.append(row)
    return found


def cheapest(rows: Iterable[Row], level: float) -> Row | None:
    """The cheapest valid row with at most this error."""
    good = [row for row in rows if is_valid(row) and row["error"] <= level]
    return min(good, key=lambda row: row["seconds"], default=None)


def settings(scene: Scene) -> list[Setting]:
    """All settings for the scene as it is, cheap methods first; some the scene may refuse."""
    plate, unstressed = scene.needed_plate, {"plate.start": "unstressed", "corner.constraint": "penalty"}
    rtols, modes, halves = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11), (0, 1, 2, 4, 8), (0.5, 1.0, 2.0, 4.0)
    meshes: list[tuple[str, float, Changes]] = [(MESH, factor, {}) for factor in (0.25, *halves)]
    meshes += [(CONSTRAINT, factor, {"corner.constraint": "exact"}) for factor in halves]
    meshes += [(ROWSUM, factor, {"plate.lumping": "row-sum"}) for factor in halves]
    elements = ("quad9", "tri3", "tri6", "quad4-reduced")
    others: dict[str, Row] = {name: {"plate.element": name} for name in elements}
    others["quad4-reduced"] |= {"damping.ratio": 0.01}
    return [
        Setting(EXACT, "exact", "closed form"),
        *(Setting(ODE, name, f"rtol {rtol:g}", number=rtol) for name in INTEGRATORS for rtol in rtols),
        *(Setting(MODAL, MODES, f"{n} modes", number=n) for n in modes),
        *(_mesh(group, factor, plate.element, plate.counts, more) for group, factor, more in meshes),
        # How they converge is shown by the soft plate.
        *(Setting(FE, ELEMENTS, *other) for other in others.items()),
        *_values(STEP, (0.45, 0.225)),
        *_values(PENALTY, (0.01, 0.1, 0.3, 3.0, 10.0)),
        *_values(DAMPING, (0.01, 0.1, 0.5)),
        Setting(FE, UNSTRESSED, "undamped", unstressed),
        Setting(FE, UNSTRESSED, "damping 0.2", {**unstressed, "damping.ratio": 0.2}),
        Setting(FE, UNSTRESSED, "dashpot 0.5", {**unstressed, "corner.damping_ratio": 0.5}),
        Setting(FE, "history", "10 rows", {"time.rows": 10}),
        Setting(FE, SINGLE, "stored"),
    ]


def soft_settings(scene: Scene) -> list[Setting]:
    """Settings for the soft plate: meshes of every element, then choices on one mesh of quad9."""
    counts, spring = soft_plate(scene)[2], {"corner.constraint": "penalty"}
    meshes = [_mesh(name, n, name, counts) for name, factors in REFINED.items() for n in factors]
    meshes += [_mesh(SPRING, n, "quad4", counts, spring) for n in REFINED["quad4"]]
    own = _mesh("", 2, "quad9", counts).changes
    choices = [
        *_values(STEP, (0.9, 0.45, 0.225, 0.1125), own, power=-1),
        *_values(PENALTY, (0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0), {**own, **spring}, power=1),
        *_values(DAMPING, (1.0, 0.3, 0.1, 0.03, 0.01), own, power=-1),
        *(Setting(MODAL, MODES, f"{n} modes", own, float(n), number=n) for n in (0, 1, 2, 4, 8)),
    ]
    return [replace(s, soft=True, choice=s in choices) for s in (*meshes, *choices)]


def impact_settings(case: Any) -> tuple[list[Setting], Changes, float]:
    """All settings of a whole impact, cheap ones first, what is the same for all, and the length that a corner's crush
    is spread over [m]: no less than an element of the coarsest mesh. The limit is that of quad9."""
    plate, contact = case.plan().plate, case.scene.contact
    own = {"plate.element": "quad4", "plate.elements": plate.counts}
    others = ("tri3", "tri6", "quad4-reduced")
    todo = [
        Setting(ODE, RIGID, "fixed step"),
        *(_mesh("quad4", factor, "quad4", plate.counts) for factor in (0.5, 1.0, 2.0, 4.0)),
        *(_mesh("quad9", factor, "quad9", plate.counts) for factor in (0.5, 1.0, 2.0)),
        *(Setting(FE, ELEMENTS, name, {**own, "plate.element": name}) for name in others),
        *_values(STEP, (0.45, 0.225), own),
        *_values(DAMPING, (0.01, 0.1), own),
    ]
    along = min(s.changes["plate.elements"][0] for s in todo if s.kind == FE)
    patch = contact.patch_length or max(patch_length(case), case.vehicle.length / along)
    changes = {"plate.youngs_modulus": plate.youngs_modulus, "plate.first_frequency": None}
    return todo, changes | ({"contact.patch_length": patch} if contact.crushes else {}), patch


def _mesh(group: str, factor: float, element: str, counts: Any, more: Changes | None = None) -> Setting:
    """So many times the elements each way."""
    along, across = (max(2, round(factor * count)) for count in counts)
    changes = {"plate.element": element, "plate.elements": (along, across), **(more or {})}
    return Setting(FE, group, f"{along} x {across}", changes, factor)


def _values(group: str, values: Sequence[float], own: Changes | None = None, power: int = 0) -> list[Setting]:
    """Values of the group's key, on a mesh of its own; power: of the refinement in the value."""
    label, key = LABELS[group], VARIED[group]
    return [Setting(FE, group, f"{label} {x:g}", {**(own or {}), key: x}, x**power) for x in values]


def soft_changes(case: Any) -> dict[str, Any]:
    """Changes that make the scene's plate soft.

    The modulus that gives a fine mesh the first frequency is found once, so that every mesh is of the same plate.
    Friction is left out: on refined meshes a soft plate flutters with it.
    """
    scene, corner, plate = case.scene, case.scene.corner, case.scene.needed_plate
    frequency, patch, (along, across) = soft_plate(scene)
    fine: Row = {"element": "quad9", "elements": (4 * along, 4 * across)}
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
    """First frequency of the soft plate [Hz] and length of its corner's patch [m], both the scene's own where it gives
    one, and elements of its coarsest mesh: three across, about 1.2 times as long as high."""
    length, frequency = scene.vehicle.length, scene.needed_plate.first_frequency
    along = max(2, round(3 * length / (scene.vehicle.width * 1.2)))
    patch = scene.corner.patch_length or max(1, round(0.2 * along)) * length / along
    return 8.0 if frequency is None else frequency, patch, (along, 3)


def measure(source: Source, setting: Setting) -> Row:
    """Record of a setting: values, times [s] of every repeat, steps, and failed checks; or what refused it."""
    try:
        case = case_of(*vary(source, setting.changes))
        how = {FE: _finite_elements, MODAL: _modal}.get(setting.kind, _rigid)
        return how(case, setting)
    except errors.InputError as error:
        return {"refused": str(error)}


def _clocked(function: Callable[..., Any], *arguments: Any) -> tuple[float, Any]:
    """Seconds that it takes, and what it returns."""
    began = time.perf_counter()
    found = function(*arguments)
    return time.perf_counter() - began, found


def _repeated(
    once: Callable[[], tuple[float, float, Any]], least: int = 2, most: float = 7, patience: float = 1.0
) -> tuple[Any, Row]:
    """The last result, and the times [s] of all repeats; once: returns time of the set-up, of the loop, result."""
    times: list[tuple[float, float]] = []
    found = None
    while len(times) < most and (len(times) < least or sum(map(sum, times)) < patience):
        *both, found = once()
        times.append((both[0], both[1]))
    return found, {"setup": [setup for setup, _ in times], "loop": [loop for _, loop in times]}


def _rigid(case: Any, setting: Setting) -> Row:
    """A millisecond is easily disturbed: many repeats."""
    scene, rtol = case.scene, setting.number
    if scene.contact:
        solve: Callable[[], Any] = partial(case.motion_until, None)
    else:
        motion = case.body, case.start.angle, case.start.omega, case.start.corner_speed
        inputs = *motion, scene.corner_friction, scene.corner.rigid_reaction
        solve = partial(plane_motion, *inputs)
        if setting.kind == ODE:
            solve = partial(integrate_odes, *inputs, method=setting.group, rtol=rtol, atol=0.01 * rtol)
    solve()
    found, times = _repeated(lambda: (0.0, *_clocked(solve)), least=21, most=math.inf, patience=0.3)
    values = {} if scene.contact else {name: float(getattr(found.strike, name)) for name in KEYS}
    return {"values": values or strike_values(found.strikes), **times, "steps": 0, "failed": []}


def _modal(case: Any, setting: Setting) -> Row:
    """Integration and set-up, of which meshing and assembling are a part; not the runs of its own estimate."""

    def once() -> tuple[float, float, Any]:
        planned, fe_plan = _clocked(case.plan)
        found = modal_model.modal_run(fe_plan, int(setting.number), tolerance=1.0)
        return planned + found.setup_s, found.integration_s, found

    found, times = _repeated(once)
    values, failed = found.values or dict.fromkeys(KEYS, math.nan), list(failed_names(found.checks))
    return {"values": values, **times, "steps": found.steps, "failed": failed}


def _finite_elements(case: Any, setting: Setting) -> Row:
    """Compiled by a run apart, then repeated."""
    impact = case.scene.contact is not None
    integrate: Callable[[Any], Any] = run.simulated if impact else partial(_simulated, setting=setting)
    fe_plan = case.plan()
    if impact:
        compiled, _ = _clocked(compile_impact_loop, fe_plan.model)
    else:
        expected = cost.loop_seconds(case.scene, "quad9", fe_plan.plate.counts, fe_plan.expected_steps)
        if expected > TOO_LONG:
            return {"refused": f"omitted: estimated time of the time loop {expected:.0f} s"}
        compiled, _ = _clocked(_simulated, fe_plan, setting, 10, 1e-3)

    def once() -> tuple[float, float, Any]:
        planned, fe_plan = _clocked(case.plan)
        done = integrate(fe_plan)
        return planned, done.time_loop_s, (fe_plan, done)

    (fe_plan, done), times = _repeated(once)
    if impact:
        outcome: Any = run.compared(fe_plan, done)
        values, failed = strike_values(outcome.fe.strikes), checks.failed_but_mesh(outcome)
    else:
        outcome = compare(fe_plan, done, 0.0)
        values, failed = outcome.fe or dict.fromkeys(KEYS, math.nan), failed_names(outcome.checks)
    return {"values": values, **times, "compile": compiled, "steps": done.steps, "failed": list(failed)}


def strike_values(strikes: Sequence[Any]) -> dict[str, float]:
    """Impulse, peak and duration of the first two strikes by `NAMES`, NaN where there are fewer."""
    found = {f"strike_{k}": strike for k, strike in enumerate(strikes[:2], 1)}
    pairs = ((name, name.split(".")) for name in NAMES)
    return {name: getattr(found.get(strike), what, math.nan) for name, (strike, what) in pairs}


def _simulated(fe_plan: Any, setting: Setting, rows: int = 0, part: float = 1.0) -> Any:
    """The run over this part of the motion; rows: of its history, 0 for the scene's own."""
    case, kind = fe_plan.case, fe_plan.plate.start
    duration, threads = part * case.motion.strike.t, case.scene.time.threads
    stepper = SingleStepper if setting.group == SINGLE else Stepper
    rows = rows or case.scene.time.rows
    return simulate(fe_plan.model, fe_plan.start, duration, kind, rows, threads, make_stepper=stepper)


class SingleStepper(Stepper):
    """The loop with its arrays stored in single precision; sums of works stay double.

    The kernels are generic in the type of their arrays. Their constants are not, so that Numba computes in double
    between a load and a store: what is seen is the harm of storing alone, the least there can be.
    """

    def __init__(self, model: PlateModel, threads: int = 1) -> None:
        table, mesh = model.loop.table, model.discretisation
        singles = {name: _single(getattr(table, name)) for name in ("gradients", "weights")}
        table = table._replace(**singles, mapping=None)
        mesh = replace(mesh, positions=_single(mesh.positions), table=table)
        loop = model.loop._replace(table=table, mass=_single(model.loop.mass))
        super().__init__(replace(model, discretisation=mesh, loop=loop), threads)
        self._scratch = self._scratch._replace(rows=_single(self._scratch.rows))
        self._double = Stepper(model)

    def start(self, start: RigidStart, kind: str) -> State:
        """The start, computed in double and rounded."""
        positions, velocities, *rest = self._double.start(start, kind)
        return State(_single(positions), _single(velocities), *rest)


def _single(values: np.ndarray) -> np.ndarray:
    return values.astype(np.float32)
