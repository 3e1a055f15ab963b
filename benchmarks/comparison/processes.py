"""One process of this program or another code, with its time."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from command_line import ROOT, TAILSLAP, bytecode_folder
from other_codes.plate import QUANTITIES, Plate, to_text
from plates import ONE_THREAD

BENCHMARKS = ROOT / "benchmarks"
SCENE = "paper-abaqus"
NAN = float("nan")


class NotMeasuredError(Exception):
    """Reason why a process has no answer."""


class Turn(NamedTuple):
    """Times [s], values at the tail-slap and version of a process."""

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
        duration, process = _tailslap(arguments, limit)
        if "compiled in" in process.stderr:
            duration, process = _tailslap([*arguments, "--force"], limit)
        if process.returncode not in (0, 1):
            raise NotMeasuredError(_last_line(process))
        summary = json.loads(Path(folder, "out", "summary.json").read_text(encoding="utf-8"))
    cost, values = summary["cost"], tuple(summary["fe"][name] for name in QUANTITIES)
    failed = ", ".join(check["name"] for check in summary["checks"] if not check["passed"])
    remark = f"{cost['steps']} steps"
    if summary.get("companions"):
        remark += " and a run on another mesh, for its numerical error"
    remark += f"; failed: {failed}" if failed else ""
    return Turn(duration, cost["setup_s"], cost["time_loop_s"], values, remark)


def run_rigid() -> Turn:
    """`tailslap rigid`."""
    duration, process = _tailslap(["rigid", SCENE, "--json"], 60.0)
    if process.returncode:
        raise NotMeasuredError(_last_line(process))
    strike = json.loads(process.stdout)["stage2"]
    return Turn(duration, NAN, NAN, tuple(strike[name] for name in QUANTITIES), "closed form")


def run_script(interpreter: str, script: str, plate: Plate, expected: float, limit: float) -> Turn:
    """Run a script of `other_codes` in its environment."""
    task = [to_text(plate), "event", repr(expected), repr(limit)]
    command = [interpreter, "-m", f"other_codes.{script}", *task]
    duration, process = _timed(command, _environment(), BENCHMARKS, 3.0 * limit)
    answers = [line for line in process.stdout.splitlines() if line.startswith('{"version"')]
    if not answers:
        raise NotMeasuredError(_last_line(process))
    answer: dict[str, Any] = json.loads(answers[0])
    values, loop = answer["values"], answer["loop_s"]
    remark = answer["version"] + ("" if values else f"; loop estimated from {answer['ran_s']:.0f} s")
    duration += loop - answer["ran_s"]
    return Turn(duration, answer["setup_s"], loop, tuple(values) if values else None, remark)


def _tailslap(arguments: Sequence[str], limit: float) -> tuple[float, subprocess.CompletedProcess[str]]:
    command = [*TAILSLAP, *arguments]
    environment = _environment() | {"PYTHONPATH": str(ROOT)}
    with tempfile.TemporaryDirectory() as folder:
        return _timed(command, environment, Path(folder), 3.0 * limit + 300.0)


def _environment() -> dict[str, str]:
    """Environment of a user, with stored bytecode and one thread."""
    removed = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH")
    variables = {name: value for name, value in os.environ.items() if name not in removed}
    return variables | ONE_THREAD | {"PYTHONPYCACHEPREFIX": bytecode_folder().name}


def _timed(
    command: Sequence[str], environment: dict[str, str], folder: Path, most: float
) -> tuple[float, subprocess.CompletedProcess[str]]:
    """Time of a process [s], limited to `most`."""
    began = time.perf_counter()
    try:
        settings: dict[str, Any] = {"cwd": folder, "env": environment, "timeout": most}
        process = subprocess.run(command, capture_output=True, text=True, **settings)
    except subprocess.TimeoutExpired:
        raise NotMeasuredError(f"took more than {most:.0f} s") from None
    return time.perf_counter() - began, process


def _last_line(process: subprocess.CompletedProcess[str]) -> str:
    said = (process.stderr.strip() or "no answer").splitlines()[-1]
    return "not installed" if said.startswith("ModuleNotFoundError") else said
