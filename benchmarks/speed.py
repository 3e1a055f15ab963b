"""Element updates per second of the time loop, beside the machine's own rates and beside other codes.

    .venv/bin/python benchmarks/speed.py

The other codes want a virtual environment of their own:

    python -m venv others && others/bin/pip install -r benchmarks/requirements.txt
    .venv/bin/python benchmarks/speed.py --others others/bin/python

Everything is measured in one run, in turns, so that the machine's moods fall on all alike: look at the ratios.
Exits 1 if the kernel is not packed.
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import platform
import statistics
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ONE_THREAD = {
    f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "NUMBA", "VECLIB_MAXIMUM")
}
MINE = "this program"
SIZES = {120: (20, 6), 7680: (160, 48), 122880: (640, 192)}
DISTORTION = 0.2
OTHERS = {"Akantu": "akantu_plate.py", "Kratos": "kratos_plate.py", "Warp": "warp_plate.py"}
COMPARED = (120, 7680)
AGREEMENT = 1e-9
"""Largest distance of the codes' far corners [m] at which they count as running the same plate."""

WANTED = {"Akantu": 20.0, "Warp": 3.0}
"""Times as fast as these the loop should be, at 7 680 elements."""


@dataclass
class Entry:
    """A line of the table: what is measured, and what each turn gave."""

    name: str
    elements: int
    measure: Callable[[], list[float]]
    rates: list[float] = field(default_factory=list)
    remark: str = ""

    def turn(self) -> None:
        """Measure once more, unless it has failed."""
        if not self.remark.startswith("not measured"):
            self.rates += self.measure()

    @property
    def best(self) -> float:
        """Largest rate of all turns."""
        return max(self.rates, default=float("nan"))

    @property
    def median(self) -> float:
        """Median rate of all turns."""
        return statistics.median(self.rates) if self.rates else float("nan")


def make_stepper(count: int, distortion: float = 0.0, threads: int = 1, bare: bool = False) -> Any:
    """The time loop on a plate of this many elements; bare: exact corner, no friction, row-sum masses."""
    from fem.contact.friction import Drag
    from fem.discretisation.model import build_model
    from fem.discretisation.properties import CornerProperties, PlateProperties, StepProperties
    from fem.explicit.simulate import Stepper
    from meshes import distorted, plate_mesh

    mesh = plate_mesh(10.0, 2.438, SIZES[count])
    if distortion:
        mesh = distorted(mesh, distortion, SIZES[count])
    plate = PlateProperties(0.053, 7800.0, 200e9, 0.3, lumping="row-sum" if bare else "exact")
    corner = CornerProperties(constraint="exact") if bare else CornerProperties(Drag(0.47))
    return Stepper(build_model(mesh, plate, corner, StepProperties()), threads)


def ours(name: str, count: int, **choices: Any) -> tuple[Entry, Any]:
    """An entry for this program's loop, and the loop."""
    from speed_others.plate import update_rates

    from fem.start.rigid_state import RigidStart

    stepper = make_stepper(count, **choices)
    state = stepper.start(RigidStart(0.26, 0.707, 25.053), "unstressed")
    stepper.advance(state, 1)
    return Entry(
        name, count, lambda: update_rates(lambda steps: stepper.advance(state, steps), count)
    ), stepper


@functools.cache
def far_corner(count: int, time_step: float) -> list[float]:
    """Where this program has the far corner [m] at the instant of comparison."""
    from speed_others.plate import CHECKED_STEPS

    from fem.start.rigid_state import RigidStart

    stepper = make_stepper(count, bare=True)
    stepper.loop = stepper.loop._replace(time_step=time_step)
    state = stepper.advance(stepper.start(RigidStart(0.0, 0.707, 25.053), "unstressed"), CHECKED_STEPS)
    far = (stepper.model.discretisation.positions * [[-1.0], [1.0]]).sum(axis=0).argmax()
    return [float(value) for value in state.positions[:, far]]


def other(name: str, count: int, interpreter: str, time_step: float) -> Entry:
    """An entry for another code, a process of its own each turn."""
    from speed_others.plate import Plate, to_text

    script = Path(__file__).parent / "speed_others" / OTHERS[name]
    command = [interpreter, str(script), to_text(Plate(SIZES[count], time_step))]
    expected = far_corner(count, time_step)
    entry = Entry(name, count, list)

    def measure() -> list[float]:
        done = subprocess.run(command, capture_output=True, text=True)
        answers = [line for line in done.stdout.splitlines() if line.startswith('{"version"')]
        if not answers:
            entry.remark = f"not measured: {(done.stderr.strip() or 'no answer').splitlines()[-1]}"
            return []
        answer = json.loads(answers[0])
        distance = max(abs(a - b) for a, b in zip(answer["far_corner"], expected, strict=True))
        same = "same plate" if distance <= AGREEMENT else "NOT THE SAME PLATE"
        entry.remark = f"{answer['version']}, {answer['model']}, {same}: far corner {distance:.0e} m off"
        return list(answer["rates"])

    entry.measure = measure
    return entry


def entries(interpreter: str | None) -> tuple[list[Entry], dict[Any, Any]]:
    """All lines in the order of a turn, and our loops by name and elements."""
    lines, loops = [], {}
    for count in SIZES:
        for name, choices in (
            (MINE, {}),
            (f"{MINE}, distorted", {"distortion": DISTORTION}),
            (f"{MINE}, 2 threads", {"threads": 2}),
        ):
            if "threads" in choices and count != max(SIZES):
                continue
            entry, stepper = ours(name, count, **choices)
            lines.append(entry)
            loops[name, count] = stepper
            if interpreter and name == MINE and count in COMPARED:
                step = stepper.loop.time_step
                lines += [other(code, count, interpreter, step) for code in OTHERS]
    return lines, loops


def machine() -> list[Entry]:
    """The machine's own rates: bytes and operations a second."""
    from bound import copy_rate, multiply_add_rate

    return [
        Entry("copy bandwidth [B/s]", 0, lambda: [copy_rate() for _ in range(3)]),
        Entry("multiply-adds [flop/s]", 0, lambda: [multiply_add_rate() for _ in range(3)]),
        Entry("the same, 2 threads", 0, lambda: [multiply_add_rate(2) for _ in range(3)]),
    ]


def print_rates(lines: list[Entry]) -> None:
    """Every entry with its best and median."""
    print(f"{'rate':<26}{'elements':>9}{'best':>11}{'median':>11}  remark")
    for entry in lines:
        size = str(entry.elements or "")
        print(f"{entry.name:<26}{size:>9}{entry.best:>11.3g}{entry.median:>11.3g}  {entry.remark}")


def print_shares(rates: list[Entry], lines: list[Entry], loops: dict[Any, Any]) -> None:
    """What share of the machine's rates the loop on one core reaches, best against best."""
    from bound import bytes_per_update, flops_per_update

    copying, arithmetic, _ = rates
    print(f"\n{'share of what the machine can do':<35}{'flop':>6}{'byte':>6}{'arithmetic':>12}", end="")
    print(f"{'bandwidth':>11}{'the lesser':>12}")
    for entry in lines:
        stepper = loops.get((entry.name, entry.elements))
        if stepper is None or "threads" in entry.name:
            continue
        flops, moved = flops_per_update(stepper), bytes_per_update(stepper)
        shares = entry.best * flops / arithmetic.best, entry.best * moved / copying.best
        print(f"{entry.name:<26}{entry.elements:>9}{flops:>6.0f}{moved:>6.0f}", end="")
        print(f"{shares[0]:>12.0%}{shares[1]:>11.0%}{max(shares):>12.0%}")
    print(
        "Bandwidth binds only where the arrays are far larger than the cache; within it, shares may pass 100 %."
    )


def print_ratios(rates: list[Entry], lines: list[Entry]) -> None:
    """This program against the others, and distorted and two threads against plain."""
    found = {(entry.name, entry.elements): entry for entry in lines}
    _, one, two = rates
    pairs = [("multiply-adds, 2 threads / 1", None, two, one)]
    for (name, count), entry in found.items():
        mine = found[MINE, count]
        if name in OTHERS:
            wanted = WANTED.get(name) if count == 7680 else None
            pairs.append((f"{MINE} / {name}, {count} elements", wanted, mine, entry))
        elif name != MINE:
            wanted = 1.7 if "threads" in name else None
            pairs.append((f"{name} / plain, {count} elements", wanted, entry, mine))
    print(f"\n{'ratio':<50}{'wanted':>8}{'of bests':>10}{'of medians':>12}")
    for what, wanted, above, below in pairs:
        asked = f"{wanted:g}" if wanted else ""
        best, median = above.best / below.best, above.median / below.median
        print(f"{what:<50}{asked:>8}{best:>10.2f}{median:>12.2f}")


def check_packing(stepper: Any) -> int:
    """Print whether the kernel is packed; the exit status."""
    from bound import multiply_adds

    if platform.machine() not in ("x86_64", "AMD64"):
        print(f"\nassembly: not looked at, this is {platform.machine()} and not x86-64")
        return 0
    packed, scalar = multiply_adds(stepper)
    fine = packed > 0 and packed >= scalar
    print(f"\nassembly: {packed} packed multiply-adds, {scalar} scalar: {'packed' if fine else 'NOT PACKED'}")
    return 0 if fine else 1


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--others", metavar="PYTHON", help="interpreter that has Akantu, Kratos and Warp")
    parser.add_argument("--turns", type=int, default=5, help="times that everything is measured in turn")
    given = parser.parse_args()
    rates = machine()
    lines, loops = entries(given.others)
    for _ in range(given.turns):
        for entry in [*rates, *lines]:
            entry.turn()
    print_rates([*rates, *lines])
    print_shares(rates, lines, loops)
    print_ratios(rates, lines)
    if not given.others:
        print("\nAkantu, Kratos, Warp: not measured, for want of --others PYTHON")
    return check_packing(loops[MINE, 120])


if __name__ == "__main__":
    if any(os.environ.get(name) != value for name, value in ONE_THREAD.items()):
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | ONE_THREAD)
    sys.exit(main())
