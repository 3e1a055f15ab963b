"""Element updates per second of the time loop and of other codes.

    .venv/bin/python benchmarks/speed.py

The other codes want a virtual environment of their own:

    python -m venv others && others/bin/pip install -r benchmarks/requirements.txt
    .venv/bin/python benchmarks/speed.py --others others/bin/python

Beside them stand the machine's rates. All are measured in turns, so that other load affects all equally; the ratios
count. Whole processes and their errors are compared by peers.py. Exits 1 if the kernel is not packed.
"""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import command_line
from plates import DISTORTION, ONE_THREAD, interpreter_path, make_model, same_plate
from speed_tables import (
    MINE,
    TWO_THREADS,
    UNEVEN,
    Entry,
    check_packing,
    print_rates,
    print_ratios,
    print_shares,
)

SIZES = {120: (20, 6), 7680: (160, 48), 122880: (640, 192)}
SCRIPTS = {"Akantu": "akantu_plate", "Kratos": "kratos_plate", "Warp": "warp_plate"}
COMPARED = {120: tuple(SCRIPTS), 7680: (*SCRIPTS, "Warp" + UNEVEN), 122880: ("Warp" + UNEVEN,)}
"""Codes beside ours by number of elements."""

AGREEMENT = 1e-9
"""Largest distance of the codes' far corners [m] at which they count as running the same plate."""


def make_stepper(count: int, distortion: float = 0.0, threads: int = 1, bare: bool = False) -> Any:
    """The time loop on a plate of this many elements; bare: as in the other codes."""
    from fem.run.corner import Stepper

    return Stepper(make_model(SIZES[count], distortion, bare), threads)


def ours(name: str, count: int, **choices: Any) -> tuple[Entry, Any]:
    """An entry for this program's loop, and the loop."""
    from other_codes.jobs import update_rates

    from fem.start.inertia_relief import RigidStart

    stepper = make_stepper(count, **choices)
    state = stepper.start(RigidStart(0.26, 0.707, 25.053), "unstressed")
    stepper.advance(state, 1)
    measure = functools.partial(update_rates, functools.partial(stepper.advance, state), count)
    return Entry(name, count, measure), stepper


def far_corner(count: int, distortion: float, time_step: float) -> list[float]:
    """Where this program has the far corner [m] at the instant of comparison."""
    from other_codes.jobs import CHECKED_STEPS

    from fem.start.inertia_relief import RigidStart

    stepper = make_stepper(count, distortion, bare=True)
    stepper.parameters = stepper.parameters._replace(time_step=time_step)
    state = stepper.advance(stepper.start(RigidStart(0.0, 0.707, 25.053), "unstressed"), CHECKED_STEPS)
    far = (stepper.model.discretisation.positions * [[-1.0], [1.0]]).sum(axis=0).argmax()
    return [float(value) for value in state.positions[:, far]]


def other(name: str, count: int, interpreter: str, time_step: float, folder: Path) -> Entry:
    """An entry for another code, a process of its own each turn."""
    from other_codes.plate import to_text

    distortion = DISTORTION if name.endswith(UNEVEN) else 0.0
    plate = same_plate(SIZES[count], distortion, time_step, folder)
    script = f"other_codes.{SCRIPTS[name.removesuffix(UNEVEN)]}"
    expected = far_corner(count, distortion, time_step)
    entry = Entry(name, count, list)

    def measure() -> list[float]:
        command = [interpreter, "-m", script, to_text(plate), "rates"]
        done = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True)
        answers = [line for line in done.stdout.splitlines() if line.startswith('{"version"')]
        if not answers:
            entry.remark = f"not measured: {(done.stderr.strip() or 'no answer').splitlines()[-1]}"
            return []
        answer = json.loads(answers[0])
        distance = max(abs(a - b) for a, b in zip(answer["far_corner"], expected, strict=True))
        same = "same plate" if distance <= AGREEMENT else "NOT THE SAME PLATE"
        entry.remark = f"{answer['version']}, {same}: far corner {distance:.0e} m off"
        return list(answer["rates"])

    entry.measure = measure
    return entry


def entries(interpreter: str | None, folder: Path) -> tuple[list[Entry], dict[Any, Any]]:
    """All lines in the order of a turn, and our loops by name and elements."""
    lines, loops = [], {}
    ways: dict[str, dict[str, Any]] = {
        "": {},
        UNEVEN: {"distortion": DISTORTION},
        TWO_THREADS: {"threads": 2},
    }
    for count in SIZES:
        for way, choices in ways.items():
            if way == TWO_THREADS and count != max(SIZES):
                continue
            entry, stepper = ours(MINE + way, count, **choices)
            lines.append(entry)
            loops[entry.name, count] = stepper
            if interpreter and way != TWO_THREADS:
                step, uneven = stepper.parameters.time_step, way == UNEVEN
                codes = [code for code in COMPARED[count] if code.endswith(UNEVEN) == uneven]
                lines += [other(code, count, interpreter, step, folder) for code in codes]
    return lines, loops


def machine() -> list[Entry]:
    """The machine's own rates: bytes and operations a second."""
    from bound import copy_rate, multiply_add_rate

    return [
        Entry("copy bandwidth [B/s]", 0, lambda: [copy_rate() for _ in range(3)]),
        Entry("multiply-adds [flop/s]", 0, lambda: [multiply_add_rate() for _ in range(3)]),
        Entry("the same, 2 threads", 0, lambda: [multiply_add_rate(2) for _ in range(3)]),
    ]


def main() -> int:
    """Measure and print."""
    parser = command_line.parser(__doc__)
    parser.add_argument(
        "--others",
        metavar="PYTHON",
        type=interpreter_path,
        help="interpreter that has Akantu, Kratos and Warp",
    )
    parser.add_argument("--turns", type=int, default=5, help="times that everything is measured in turn")
    given = parser.parse_args()
    rates = machine()
    with tempfile.TemporaryDirectory() as folder:
        lines, loops = entries(given.others, Path(folder))
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
