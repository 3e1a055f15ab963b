"""Meshes, codes on each of them, and their measured turns."""

from __future__ import annotations

import functools
import math
import statistics
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from other_codes.plate import Plate
from plates import DISTORTION, make_model, same_plate

from comparison.processes import NAN, NotMeasuredError, Turn, run_command, run_rigid, run_script
from comparison.rigid_body import distance, of_rectangle, of_row_sums

COMMAND, EXACT, ALIKE = "tailslap run", "tailslap run, exact corner", "tailslap run, as the others"
RIGID, EXUDYN = "tailslap rigid", "Exudyn, rigid body"
SCRIPTS = {"Akantu": "akantu_plate", "Kratos": "kratos_plate", "Warp loop": "warp_plate"}
EXACT_CORNER = ("corner.constraint=exact",)
AS_THE_OTHERS = (*EXACT_CORNER, "plate.lumping=row-sum", "plate.start=unstressed", "damping.kind=none")
"""Settings that make our run the plate of the other codes."""
SAME_MODEL = (ALIKE, *SCRIPTS)
"""Codes that run one model, so that nothing but rounding should lie between them."""
ANGLE, SHORT_ANGLE = 0.26, 0.002
"""Angle of the start [rad]: of the paper, and of the largest plate, for which no code is quick enough else."""
SMALL, LARGE = 1000, 100_000
"""Elements up to which a process takes a second or so, and from which on minutes."""


@dataclass(frozen=True)
class Mesh:
    """A plate with exact motions, of row-sum masses too."""

    plate: Plate
    distortion: float
    exact: np.ndarray
    lumped: np.ndarray

    @property
    def title(self) -> str:
        """Title of the mesh."""
        along, across = self.plate.elements
        shape = "distorted elements" if self.distortion else "equal rectangles"
        return f"{self.plate.count} elements, {along} x {across}, {shape}, from {self.plate.angle:g} rad"


@dataclass
class Entry:
    """Code on a mesh, its measurement and the turns."""

    code: str
    mesh: Mesh | None
    exact: np.ndarray
    measure: Callable[[], Turn]
    turns: list[Turn] = field(default_factory=list)
    why_not: str = ""

    def turn(self) -> None:
        """Measure once more, unless it has failed."""
        if not self.why_not:
            try:
                self.turns.append(self.measure())
            except NotMeasuredError as why:
                self.why_not = f"not measured: {why}"

    @property
    def values(self) -> np.ndarray | None:
        """Quantities, equal in all turns."""
        values = self.turns[-1].values if self.turns else None
        return None if values is None else np.array(values)

    @property
    def error(self) -> float:
        """Largest relative difference from the exact rigid motion."""
        return NAN if self.values is None else distance(self.values, self.exact)

    @property
    def by_masses(self) -> float:
        """Error by the inertia of row-sum masses."""
        if self.mesh is None or self.code not in SAME_MODEL:
            return 0.0
        return distance(self.mesh.lumped, self.exact)

    @property
    def by_flexibility(self) -> float:
        """Error by flexibility of a plate, by integration of rigid bodies."""
        if self.values is None:
            return NAN
        lumped = self.mesh is not None and self.code in SAME_MODEL
        return distance(self.values, self.mesh.lumped if self.mesh and lumped else self.exact)

    def median(self, part: str) -> float:
        """Seconds of the turns, of the process or a part."""
        return statistics.median(getattr(turn, part) for turn in self.turns) if self.turns else NAN


def make_meshes(is_large: bool, folder: Path) -> list[Mesh]:
    """The plates in the order of a turn."""
    small = [(10, 3), (20, 6), (40, 12), (160, 48)]
    even = [make_mesh(elements, 0.0, ANGLE, folder) for elements in small]
    uneven = [make_mesh(elements, DISTORTION, ANGLE, folder) for elements in ((20, 6), (160, 48))]
    shares = (0.0, DISTORTION) if is_large else ()
    return even + uneven + [make_mesh((640, 192), share, SHORT_ANGLE, folder) for share in shares]


def make_mesh(elements: tuple[int, int], distortion: float, angle: float, folder: Path) -> Mesh:
    """A plate with our time step of the model that all run."""
    time_step = make_model(elements, distortion, bare=True).parameters.time_step
    plate = same_plate(elements, distortion, time_step, folder, angle)
    return Mesh(plate, distortion, of_rectangle(plate), of_row_sums(plate))


def rigid_entries(plate: Plate, interpreter: str | None, limit: float) -> list[Entry]:
    """Rows of rigid bodies."""
    exact = of_rectangle(plate)
    script = functools.partial(_script, interpreter, "exudyn_body", plate, float(exact[0]), limit)
    return [Entry(RIGID, None, exact, run_rigid), Entry(EXUDYN, None, exact, script)]


def plate_entries(mesh: Mesh, interpreter: str | None, limit: float) -> list[Entry]:
    """Rows of one mesh, with the command alone where requested."""
    plate, settings = mesh.plate, {COMMAND: (), EXACT: EXACT_CORNER, ALIKE: AS_THE_OTHERS}
    is_compared = plate.elements not in ((10, 3), (40, 12))
    entries = [
        Entry(code, mesh, mesh.exact, functools.partial(run_command, plate, changes, mesh.distortion, limit))
        for code, changes in settings.items()
        if is_compared or code == COMMAND
    ]
    expected = float(mesh.exact[0])
    return entries + [
        Entry(code, mesh, mesh.exact, functools.partial(_script, interpreter, script, plate, expected, limit))
        for code, script in SCRIPTS.items()
        if is_compared
    ]


def _script(interpreter: str | None, script: str, plate: Plate, expected: float, limit: float) -> Turn:
    if interpreter is None:
        raise NotMeasuredError("no --others PYTHON")
    return run_script(interpreter, script, plate, expected, limit)


def turns_of(entry: Entry, turns: int) -> int:
    """Rounds of an entry, fewer on large meshes."""
    count = entry.mesh.plate.count if entry.mesh else 0
    return turns if count <= SMALL else math.ceil(turns / (2 if count < LARGE else 4))


def run_rounds(entries: Iterable[Entry], turns: int) -> None:
    """Measure all in turn, after a round of the small ones."""
    listed = list(entries)
    print("a round of the small meshes for what is compiled and cached", file=sys.stderr, flush=True)
    for entry in listed:
        if entry.mesh is None or entry.mesh.plate.count <= SMALL:
            entry.turn()
            entry.turns.clear()
    for number in range(turns):
        print(f"round {number + 1} of {turns}", file=sys.stderr, flush=True)
        for entry in listed:
            if number < turns_of(entry, turns):
                entry.turn()


def apart(entry: Entry, entries: Iterable[Entry]) -> float:
    """Largest relative distance from codes of the same model."""
    peers = [other for other in entries if other is not entry and other.code in SAME_MODEL]
    values = [other.values for other in peers if other.mesh is entry.mesh and other.values is not None]
    if entry.values is None or entry.code not in SAME_MODEL or not values:
        return NAN
    return max(distance(entry.values, values) for values in values)
