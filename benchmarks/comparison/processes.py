"""One process: our command, or a script of another code; its time, and the values at the tail-slap."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from command_line import ROOT, TAILSLAP
from other_codes.plate import QUANTITIES, Plate, to_text
from plates import ONE_THREAD

BENCHMARKS = ROOT / "benchmarks"
BYTECODE = Path(tempfile.gettempdir()) / f"tailslap-bytecode-{os.getuid()}"
SCENE = "paper-abaqus"
NAN = float("nan")


class NotMeasuredError(Exception):
    """Reason why a process has no answer."""


class Turn(NamedTuple):
    """Seconds of a whole process, of its set-up and its loop; values at the tail-slap; version of the code.

    There are no values where the loop was ended before and its time is estimated.
    """

    whole: float
    setup: float
    loop: float
    values: tuple[float, ...] | None
    remark: str

    @property
    def rest(self) -> float:
        """The interpreter's start, imports, results, and the end."""
        return self.whole - self.setup - self.loop


def run_command(plate: Plate, settings: Sequence[str], distortion: float, limit: float) -> Turn:
    """`tailslap run` of the plate with further settings of the scene."""
    sizes = f"plate.elements=[{plate.elements[0]},{plate.elements[1]}]"
    changes = [sizes, f"start.angle={plate.angle!r}", f"plate.distortion={distortion}", *settings]
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["run", SCENE, "--no-pictures", "--out", f"{folder}/out"]
        arguments += [word for change in changes for word in ("--set", change)]
        whole, done = _tailslap(arguments, limit)
        if "compiled in" in done.stderr:
            whole, done = _tailslap([*arguments, "--force"], limit)
        if done.returncode not in (0, 1):
            raise NotMeasuredError(_last_line(done))
        found = json.loads(Path(folder, "out", "summary.json").read_text(encoding="utf-8"))
    cost, values = found["cost"], tuple(found["fe"][name] for name in QUANTITIES)
    failed = ", ".join(check["name"] for check in found["checks"] if not check["passed"])
    remark = f"{cost['steps']} steps"
    if found.get("companions"):
        remark += " and a run on another mesh, for its numerical error"
    remark += f"; failed: {failed}" if failed else ""
    return Turn(whole, cost["setup_s"], cost["time_loop_s"], values, remark)


def run_rigid() -> Turn:
    """`tailslap rigid`."""
    whole, done = _tailslap(["rigid", SCENE, "--json"], 60.0)
    if done.returncode:
        raise NotMeasuredError(_last_line(done))
    found = json.loads(done.stdout)["stage2"]
    return Turn(whole, NAN, NAN, tuple(found[name] for name in QUANTITIES), "closed form")


def run_script(interpreter: str, script: str, plate: Plate, expected: float, limit: float) -> Turn:
    """A script of `other_codes` in its own environment, from the start to the tail-slap."""
    task = [to_text(plate), "event", repr(expected), repr(limit)]
    command = [interpreter, "-m", f"other_codes.{script}", *task]
    whole, done = _timed(command, _environment(), BENCHMARKS, 3.0 * limit)
    answers = [line for line in done.stdout.splitlines() if line.startswith('{"version"')]
    if not answers:
        raise NotMeasuredError(_last_line(done))
    found: dict[str, Any] = json.loads(answers[0])
    values, loop = found["values"], found["loop_s"]
    remark = found["version"] + ("" if values else f"; loop estimated from {found['ran_s']:.0f} s")
    whole += loop - found["ran_s"]
    return Turn(whole, found["setup_s"], loop, tuple(values) if values else None, remark)


def _tailslap(arguments: Sequence[str], limit: float) -> tuple[float, subprocess.CompletedProcess[str]]:
    command = [*TAILSLAP, *arguments]
    environment = _environment() | {"PYTHONPATH": str(ROOT)}
    with tempfile.TemporaryDirectory() as folder:
        return _timed(command, environment, Path(folder), 3.0 * limit + 300.0)


def _environment() -> dict[str, str]:
    """That of a user, with bytecode on disk, of this benchmark's own, and one thread."""
    left_out = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH")
    kept = {name: value for name, value in os.environ.items() if name not in left_out}
    return kept | ONE_THREAD | {"PYTHONPYCACHEPREFIX": str(BYTECODE)}


def _timed(
    command: Sequence[str], environment: dict[str, str], folder: Path, most: float
) -> tuple[float, subprocess.CompletedProcess[str]]:
    """Time on the clock of a process; none may take longer than `most` [s]."""
    began = time.perf_counter()
    try:
        settings: dict[str, Any] = {"cwd": folder, "env": environment, "timeout": most}
        done = subprocess.run(command, capture_output=True, text=True, **settings)
    except subprocess.TimeoutExpired:
        raise NotMeasuredError(f"took more than {most:.0f} s") from None
    return time.perf_counter() - began, done


def _last_line(done: subprocess.CompletedProcess[str]) -> str:
    said = (done.stderr.strip() or "no answer").splitlines()[-1]
    return "not installed" if said.startswith("ModuleNotFoundError") else said
