"""Element updates per second of the time loop and of other codes.

    .venv/bin/python benchmarks/speed.py [--turns 5]

The other codes require a virtual environment of their own:

    python -m venv others && others/bin/pip install -r benchmarks/requirements.txt
    .venv/bin/python benchmarks/speed.py --others others/bin/python

All are measured in turns, so that other load affects all equally; the ratios count. Times of the loop by element are
compared with the estimates of `tailslap check`. Whole processes and their errors are compared by peers.py. Exits 1 if
the kernel is not packed.
"""

from __future__ import annotations

import functools
import json
import platform
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import command_line
from plates import DISTORTION, interpreter_path, make_model, on_one_thread, same_plate

SIZES = {120: (20, 6), 7680: (160, 48), 122880: (640, 192)}
MINE, UNEVEN, TWO_THREADS = "this program", ", distorted", ", 2 threads"
VARIANTS: dict[str, dict[str, Any]] = {
    "": {}, UNEVEN: {"distortion": DISTORTION}, TWO_THREADS: {"threads": 2},
}  # fmt: skip
SCRIPTS = {"Akantu": "akantu_plate", "Kratos": "kratos_plate", "Warp": "warp_plate"}
COMPARED = {120: tuple(SCRIPTS), 7680: (*SCRIPTS, "Warp" + UNEVEN), 122880: ("Warp" + UNEVEN,)}
"""Other codes by number of elements."""
REQUIRED = {("Akantu", 7680): 20.0, ("Warp", 7680): 3.0, ("Warp" + UNEVEN, 122880): 2.0}
"""Required ratio of the loop's rate to theirs on the same plate."""
AGREEMENT = 1e-9
"""Largest distance of the codes' far corners [m] at which they count as running the same plate."""


ELEMENTS, UNEVEN_MESH, NEO_HOOKEAN = (60, 18), "plate.distortion=0.2", "material.law=neo-hookean"
ESTIMATED = {
    "quad4": ("", UNEVEN_MESH, NEO_HOOKEAN), "quad4-reduced": ("", UNEVEN_MESH), "tri3": ("",), "tri6": ("",),
    "quad9": ("", UNEVEN_MESH, NEO_HOOKEAN),
}  # fmt: skip
"""Further changes of the scene, by element, with which times are compared with their estimates."""


@dataclass
class Entry:
    """Line of the table, with the rate of each turn."""

    name: str
    elements: int
    measure: Callable[[], list[float]]
    rates: list[float] = field(default_factory=list)
    remark: str = ""

    def turn(self) -> None:
        """Measure once more, unless it has failed."""
        if not self.remark.startswith("not measured"):
            self.rates += self.measure()

    def rate(self, of: Callable[[list[float]], float]) -> float:
        """Return the largest or the median rate."""
        return of(self.rates) if self.rates else float("nan")


def make_stepper(count: int, distortion: float = 0.0, threads: int = 1, bare: bool = False) -> Any:
    """Return the time loop on a plate of this many elements.

    bare: as in the other codes.
    """
    from fem.run.corner import Stepper

    return Stepper(make_model(SIZES[count], distortion, bare), threads)


def ours(name: str, count: int, **choices: Any) -> tuple[Entry, Any]:
    """Return an entry for this program's loop, and the loop."""
    from other_codes.jobs import update_rates

    from fem.start.inertia_relief import RigidStart

    stepper = make_stepper(count, **choices)
    state = stepper.start(RigidStart(0.26, 0.707, 25.053), "unstressed")
    stepper.advance(state, 1)
    measure = functools.partial(update_rates, functools.partial(stepper.advance, state), count)
    return Entry(name, count, measure), stepper


def far_corner(count: int, distortion: float, time_step: float) -> list[float]:
    """Return the far corner [m] of this program's plate for comparison."""
    from other_codes.jobs import CHECKED_STEPS

    from fem.start.inertia_relief import RigidStart

    stepper = make_stepper(count, distortion, bare=True)
    stepper.parameters = stepper.parameters._replace(time_step=time_step)
    state = stepper.advance(stepper.start(RigidStart(0.0, 0.707, 25.053), "unstressed"), CHECKED_STEPS)
    far = (stepper.model.discretisation.positions * [[-1.0], [1.0]]).sum(axis=0).argmax()
    return [float(value) for value in state.positions[:, far]]


def other(name: str, count: int, interpreter: str, time_step: float, folder: Path) -> Entry:
    """Return an entry for another code, run as a process."""
    from other_codes.plate import to_text

    distortion = DISTORTION if name.endswith(UNEVEN) else 0.0
    plate = same_plate(SIZES[count], distortion, time_step, folder)
    script = f"other_codes.{SCRIPTS[name.removesuffix(UNEVEN)]}"
    expected = far_corner(count, distortion, time_step)
    entry = Entry(name, count, list)

    def measure() -> list[float]:
        command = [interpreter, "-m", script, to_text(plate), "rates"]
        process = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True)
        answers = [line for line in process.stdout.splitlines() if line.startswith('{"version"')]
        if not answers:
            entry.remark = f"not measured: {(process.stderr.strip() or 'no answer').splitlines()[-1]}"
            return []
        answer = json.loads(answers[0])
        distance = max(abs(a - b) for a, b in zip(answer["far_corner"], expected, strict=True))
        same = "same plate" if distance <= AGREEMENT else "NOT THE SAME PLATE"
        entry.remark = f"{answer['version']}, {same}: far corner {distance:.0e} m off"
        return list(answer["rates"])

    entry.measure = measure
    return entry


def entries(interpreter: str | None, folder: Path) -> tuple[list[Entry], Any]:
    """Return all lines in order, and the loop on the smallest plate."""
    lines, loops = [], []
    for count in SIZES:
        for variant, choices in VARIANTS.items():
            if variant == TWO_THREADS and count != max(SIZES):
                continue
            entry, stepper = ours(MINE + variant, count, **choices)
            lines.append(entry)
            loops.append(stepper)
            if interpreter and variant != TWO_THREADS:
                step, uneven = stepper.parameters.time_step, variant == UNEVEN
                codes = [code for code in COMPARED[count] if code.endswith(UNEVEN) == uneven]
                lines += [other(code, count, interpreter, step, folder) for code in codes]
    return lines, loops[0]


def machine() -> list[Entry]:
    """Return entries for the multiply-adds of the machine per second."""
    from bound import multiply_add_rate

    return [
        Entry(f"flop/s, {threads} threads", 0, lambda n=threads: [multiply_add_rate(n) for _ in range(3)])  # type: ignore[misc]
        for threads in (1, 2)
    ]


def print_ratios(rates: Sequence[Entry], lines: Sequence[Entry]) -> None:
    """Print the ratios to other codes and to the plain loop."""
    by_name = {(entry.name, entry.elements): entry for entry in lines}
    pairs: list[tuple[str, float | None, Entry, Entry]] = [
        ("flop/s, 2 threads / 1", None, rates[1], rates[0])
    ]
    for (name, count), entry in by_name.items():
        if not name.startswith(MINE):
            mine = MINE + UNEVEN * name.endswith(UNEVEN)
            what = f"{mine} / {name}, {count} elements"
            pairs.append((what, REQUIRED.get((name, count)), by_name[mine, count], entry))
        elif name != MINE:
            required = 1.7 if TWO_THREADS in name else None
            pairs.append((f"{name} / plain, {count} elements", required, entry, by_name[MINE, count]))
    for what, required, above, below in pairs:
        best, median = (above.rate(of) / below.rate(of) for of in (max, statistics.median))
        command_line.row(what, f"{required:g}" if required else "", f"{best:.2f}, of medians {median:.2f}")


def print_estimates() -> None:
    """Print the time of the loop beside the estimate of `tailslap check`."""
    from tailslap.case.corner.corner_case import CornerCase
    from tailslap.case.corner.corner_run import attempt
    from tailslap.case.resources import loop_seconds
    from tailslap.scene.read import read_scene

    for element, change in (
        (element, change) for element, changes in ESTIMATED.items() for change in changes
    ):
        mesh = f"plate.element={element}", f"plate.elements={list(ELEMENTS)}"
        case = CornerCase(*read_scene("paper-table-3", (*mesh, *filter(None, [change]))))
        run = attempt(case).run
        expected = loop_seconds(case.scene, element, ELEMENTS, run.steps, len(run.history["t"]))
        command_line.row(f"loop over estimate, {element} {change}", "", f"{run.time_loop_s / expected:.2f}")


def check_packing(stepper: Any) -> int:
    """Print whether the kernel is packed, and return the exit status."""
    from bound import multiply_adds

    if platform.machine() not in ("x86_64", "AMD64"):
        print(f"assembly: not examined, this is {platform.machine()} and not x86-64")
        return 0
    packed, scalar = multiply_adds(stepper)
    fine = packed > 0 and packed >= scalar
    print(f"assembly: {packed} packed multiply-adds, {scalar} scalar: {'packed' if fine else 'NOT PACKED'}")
    return 0 if fine else 1


def main() -> int:
    """Measure and print."""
    options = command_line.options(__doc__, others=str, turns=5)
    rates = machine()
    with tempfile.TemporaryDirectory() as folder:
        lines, loop = entries(interpreter_path(options.others), Path(folder))
        for _ in range(options.turns):
            for entry in [*rates, *lines]:
                entry.turn()
    for entry in [*rates, *lines]:
        best, median = entry.rate(max), entry.rate(statistics.median)
        size = f", {entry.elements} elements" if entry.elements else ""
        command_line.row(entry.name + size, "", f"{best:.3g}, median {median:.3g}  {entry.remark}")
    print_ratios(rates, lines)
    print_estimates()
    if not options.others:
        print("Akantu, Kratos, Warp: not measured, --others PYTHON is missing")
    return check_packing(loop)


if __name__ == "__main__":
    on_one_thread()
    sys.exit(main())
