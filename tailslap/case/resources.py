"""Expected cost of a run, and limits of this machine.

Estimates use the scene alone, without a mesh.
"""

import contextlib
import math
from dataclasses import dataclass
from pathlib import Path

from fem.laws import materials
from fem.plate import kinds
from machine_code.system.operating_system import (
    address_space,
    available_cores,
    free_memory,
    used_address_space,
)
from tailslap.errors import InputError, Verbatim
from tailslap.scene.model_tables import Plate
from tailslap.scene.schema import Scene
from tailslap.scene.vehicle_tables import Vehicle

ELEMENTS = 120
"""Number of elements of the first mesh where the scene does not specify it."""

ROW_S = 1e-5
"""Time per row of the history [s], on any mesh."""

_BEAM = 22.3733 / (2.0 * math.pi * math.sqrt(12.0))
"""First frequency of a free beam times its length squared, over wave speed and height [-]."""

BYTES_A_NODE, BASE_BYTES = 9e3, 0.25e9
"""Memory of model, factorisation and state, measured on 40 000 and 160 000 nodes of quad4 and quad9 meshes."""

BYTES_OF_FIELDS = 400.0
"""Memory per node and instant while fields are computed."""

MAX_SECONDS = 86_400.0
"""Longest time loop [s] that needs no explicit permission."""

MAX_THREADS = 8
"""Most threads on any machine; machines with more than four cores allow twice their cores."""

LARGE = "--allow-large runs the scene nevertheless"

CHECKED_UP_TO = 5_000
"""Largest number of elements for which `tailslap check` makes the model; above it, it prints estimates."""

CGROUP = Path("/sys/fs/cgroup")


@dataclass(frozen=True)
class Effort:
    """Expected number of time steps to the tail-slap and their time [s]."""

    steps: float
    seconds: float


def loop_seconds(scene: Scene, element: str, counts: tuple[int, int], steps: float, rows: int = 0) -> float:
    """Return the expected time of the loop [s].

    counts: elements along and across; rows: of the history.
    """
    stress = materials.MATERIALS[scene.material.law].nanoseconds if scene.material else 0.0
    kind = kinds.ELEMENT_KINDS[element]
    distorted = kind.distorted if scene.needed_plate.distortion else 1.0
    cell = distorted * kind.nanoseconds + kind.points * stress
    return 1e-9 * steps * math.prod(counts) * train_size(scene) * cell + rows * ROW_S


def train_size(scene: Scene) -> float:
    """Return the area of all units over that of the vehicle.

    Their numbers of elements have the same ratio.
    """
    vehicle = scene.vehicle
    return sum(unit.length * unit.width for unit in scene.units) / (vehicle.length * vehicle.width)


def costly_key(scene: Scene, duration: float) -> tuple[str, object]:
    """Return the key that makes a run long, and its value.

    duration: of the motion [s].
    """
    plate = scene.needed_plate
    if scene.time.safety_factor < 0.1:
        return "time.safety_factor", scene.time.safety_factor
    if duration > 60.0:
        start = scene.start
        if start and start.omega is not None:
            return "start.omega", start.omega
        assert scene.impact is not None
        return "impact.speed", scene.impact.speed
    if plate.elements and math.prod(plate.elements) > 10_000:
        return "plate.elements", Verbatim(list(plate.elements))
    if plate.density is not None and plate.density < 100.0:
        return "plate.density", plate.density
    key = "youngs_modulus" if plate.first_frequency is None else "first_frequency"
    return f"plate.{key}", getattr(plate, key)


def expected_effort(scene: Scene, duration: float) -> Effort:
    """Estimate a run's steps and their time.

    An open mesh counts as the first one that the program tries, with quadratic elements. duration: of the motion [s].
    """
    body, plate = scene.vehicle, scene.needed_plate
    element = plate.element if "element" in plate.model_fields_set else "quad9"
    across_all = ELEMENTS * body.width / body.length
    along, across = plate.elements or (math.sqrt(ELEMENTS * body.length / body.width), math.sqrt(across_all))
    short = min(body.length / along, body.width / max(across, 2.0)) * (1.0 - plate.distortion)
    crossings = duration * _wave_speed(body, plate) / short
    ratio = (scene.damping.ratio if scene.damping else None) or 0.0
    per_crossing = kinds.ELEMENT_KINDS[element].steps_per_crossing
    steps = max(1000.0, per_crossing * crossings / (math.hypot(1.0, ratio) - ratio))
    cells = (max(1, round(along)), max(1, round(across)))
    return Effort(steps, loop_seconds(scene, element, cells, steps))


def _wave_speed(body: Vehicle, plate: Plate) -> float:
    """Return the speed of longitudinal waves in the plate [m/s]."""
    area = body.length * body.width * plate.thickness
    density = plate.density or body.mass / area
    if plate.youngs_modulus is not None:
        return math.sqrt(plate.youngs_modulus / density / (1.0 - plate.poissons_ratio**2))
    slenderness = body.width / body.length
    # A short plate also deforms in shear, so that a beam of its first frequency needs a higher modulus.
    shear = math.sqrt(1.0 + 8.0 * slenderness**2)
    return (plate.first_frequency or 0.0) * body.length / (_BEAM * slenderness) * shear


def beam_frequency(scene: Scene, length: float, width: float, modulus: float) -> float:
    """Return a slender plate's first frequency [Hz].

    It has mass and thickness of the scene, these sides [m] and this Young's modulus [Pa].
    """
    vehicle, plate = scene.vehicle, scene.needed_plate
    density = plate.density or vehicle.mass / (length * width * plate.thickness)
    return float(_BEAM * math.sqrt(modulus / density) * width / length**2)


def is_large(scene: Scene) -> bool:
    """Return whether the mesh is too large for `tailslap check`."""
    plate = scene.plate
    return bool(plate and plate.elements and math.prod(plate.elements) > CHECKED_UP_TO)


def expected_nodes(scene: Scene) -> int:
    """Estimate the number of nodes of the mesh.

    It is 0 where the program chooses the elements, which are few.
    """
    plate = scene.plate
    if plate is None or plate.elements is None:
        return 0
    return round(train_size(scene) * math.prod(plate.elements)) * (
        1 if kinds.ELEMENT_KINDS[plate.element].higher_order else 4
    )


def expected_memory(scene: Scene) -> float:
    """Estimate the memory of a run [bytes]."""
    a_node = BYTES_A_NODE + BYTES_OF_FIELDS * scene.kept_fields
    return BASE_BYTES + a_node * expected_nodes(scene)


def demand_run(scene: Scene, duration: float, allow_large: bool) -> None:
    """Raise InputError without a plate, or for a large run.

    allow_large: whether any size is allowed.
    """
    if scene.needed_plate and not allow_large:
        demand_affordable(scene, duration)


def affordable(scene: Scene, duration: float) -> bool:
    """Return whether this machine can run the scene over this duration [s]."""
    try:
        demand_affordable(scene, duration)
    except InputError:
        return False
    return True


def demand_affordable(scene: Scene, duration: float) -> None:
    """Raise InputError for more threads, memory or time than allowed.

    duration: of the motion [s].
    """
    plate, threads = scene.plate, scene.time.threads
    if plate is None:
        return
    most = max(MAX_THREADS, 2 * available_cores())
    if threads > most:
        why = f"this machine has {available_cores()} cores, and more threads than cores wait for each other"
        raise InputError("time.threads", threads, f"{why}; allowed are {most}; {LARGE}")
    memory, free = expected_memory(scene), available_memory()
    seconds = expected_effort(scene, duration).seconds
    if memory > free:
        why = f"the run would take about {memory / 1e9:.2g} GB of memory, and {free / 1e9:.2g} GB are free"
        elements = Verbatim(list(plate.elements) if plate.elements else "open")
        raise InputError("plate.elements", elements, f"{why}; allowed are fewer; {LARGE}")
    if seconds > MAX_SECONDS:
        key, value = costly_key(scene, duration)
        why = f"the time loop would take about {seconds / 3600.0:.2g} hours"
        raise InputError(key, value, f"{why}; allowed are {MAX_SECONDS / 3600.0:g}; {LARGE}")


def estimate_lines(scene: Scene, duration: float) -> dict[str, list[str]]:
    """Return estimates for a large mesh by label."""
    plate, effort = scene.needed_plate, expected_effort(scene, duration)
    along, across = plate.counts
    return {
        "plate": [f"{along} x {across} elements, about {expected_nodes(scene)} nodes, {plate.element}"],
        "memory": [f"about {expected_memory(scene) / 1e9:.2g} GB"],
        "steps": [f"about {effort.steps:.2g} time steps, about {effort.seconds:.2g} s in the time loop"],
        "model": ["not built for a mesh of this size; the numbers are estimates"],
    }


def worker_count(requested: int | None, parts: int) -> int:
    """Return the number of processes for a number of parts.

    It is the requested one, by default that of the cores, and at most that of parts and of cores.
    """
    return min(available_cores() if requested is None else requested, available_cores(), parts)


def available_memory() -> float:
    """Return the memory that this process may still use [bytes].

    The free memory of the machine, and of the limits of its container and of the process what remains. Limits that
    cannot be read are ignored.
    """
    limits = [float("inf")]
    for limit in (free_memory, _container, _own_limit):
        with contextlib.suppress(OSError, ValueError):
            limits.append(limit())
    return max(0.0, min(limits))


def _container() -> float:
    limit, used = (float((CGROUP / name).read_text()) for name in ("memory.max", "memory.current"))
    return limit - used


def _own_limit() -> float:
    return address_space() - used_address_space()
