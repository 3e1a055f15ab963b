"""Whether this machine can carry a run: memory and time by the scene alone, before any mesh is made."""

from __future__ import annotations

import math

from fem.discretisation.element_kinds import ELEMENT_KINDS
from tailslap.errors import InputError, Verbatim
from tailslap.machine import available_cores, available_memory
from tailslap.planning.cost import costly_key
from tailslap.planning.effort import expected_effort
from tailslap.scene.schema import Scene

BYTES_A_NODE, BASE_BYTES = 9e3, 0.25e9
"""Memory of model, factorisation and state; measured on 40 000 and 160 000 nodes, quad4 and quad9."""

BYTES_OF_FIELDS = 400.0
"""Memory of a node at an instant whose fields are kept, while they are worked out."""

MAX_SECONDS = 86_400.0
"""Time of the loop above which a run has to be asked for explicitly."""

MAX_THREADS = 8
"""Threads that any machine may be asked for; above it, twice its cores."""

LARGE = "--allow-large runs it all the same"


CHECKED_UP_TO = 5_000
"""Elements up to which `tailslap check` makes the model; above it tells the estimate alone."""


def is_large(scene: Scene) -> bool:
    """Whether the model of the scene's own elements is too large to be made for a look."""
    plate = scene.plate
    return bool(plate and plate.elements and math.prod(plate.elements) > CHECKED_UP_TO)


def expected_nodes(scene: Scene) -> int:
    """Nodes of the mesh, about; 0 where the program chooses the elements, which are few."""
    plate = scene.plate
    if plate is None or plate.elements is None:
        return 0
    return math.prod(plate.elements) * (1 if ELEMENT_KINDS[plate.element].richer else 4)


def expected_memory(scene: Scene) -> float:
    """Memory of a run [bytes]."""
    a_node = BYTES_A_NODE + BYTES_OF_FIELDS * scene.kept_fields
    return BASE_BYTES + a_node * expected_nodes(scene)


def demand_run(scene: Scene, duration: float, allow_large: bool) -> None:
    """Raise InputError where the scene has no plate, and unless that is allowed, as `demand_affordable`."""
    if scene.needed_plate and not allow_large:
        demand_affordable(scene, duration)


def demand_affordable(scene: Scene, duration: float) -> None:
    """Raise InputError, with the estimate, where a run over this time [s] would take more than there is."""
    plate, threads = scene.plate, scene.time.threads
    if plate is None:
        return
    most = max(MAX_THREADS, 2 * available_cores())
    if threads > most:
        why = f"{available_cores()} cores are here, and more threads than cores only wait for each other"
        raise InputError("time.threads", threads, f"{why}; allowed are {most}; {LARGE}")
    memory, free, seconds = (
        expected_memory(scene),
        available_memory(),
        expected_effort(scene, duration).seconds,
    )
    if memory > free:
        why = f"the run would take about {memory / 1e9:.2g} GB of memory, and {free / 1e9:.2g} GB are free"
        given = Verbatim(list(plate.elements) if plate.elements else "open")
        raise InputError("plate.elements", given, f"{why}; allowed are fewer; {LARGE}")
    if seconds > MAX_SECONDS:
        key, value = costly_key(scene, duration)
        why = f"the time loop would take about {seconds / 3600.0:.2g} hours"
        raise InputError(key, value, f"{why}; allowed are {MAX_SECONDS / 3600.0:g}; {LARGE}")
