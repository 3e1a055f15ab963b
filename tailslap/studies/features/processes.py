"""Whole commands, each in a fresh process: seconds, modules loaded, and where the time of imports goes."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tailslap.studies.features.timing import Spread, seconds, spread, take_turns

TURNS = 2
"""Times that each command is run to be timed; a third run, slower, reports its imports."""

COMMANDS = {
    "rigid": ("rigid",),
    "check": ("check",),
    "run --no-pictures": ("run", "--no-pictures"),
    "run": ("run",),
}

CODE = (
    "import sys\nfrom tailslap.command_line import _status\n"
    "status = _status(sys.argv[1:])\nprint()\nprint(len(sys.modules))\nsys.exit(status)\n"
)


@dataclass(frozen=True)
class Process:
    """A command: seconds of the whole process, modules at its end, seconds in imports, and the costliest packages."""

    name: str
    seconds: Spread
    modules: int
    import_s: float
    packages: tuple[tuple[str, float], ...]


def find_processes(
    scene: str, changes: tuple[str, ...], progress: Callable[[float], None] = lambda share: None
) -> tuple[Process, ...]:
    """All COMMANDS on this scene; results go to a folder that is removed."""
    with tempfile.TemporaryDirectory(prefix="tailslap-features-") as folder:
        arguments = {name: _arguments(command, scene, changes, folder) for name, command in COMMANDS.items()}
        runs = [partial(_timed, command) for command in arguments.values()]
        table = take_turns(runs, TURNS, lambda share: progress(0.6 * share))
        found = []
        for i, (name, command) in enumerate(arguments.items()):
            modules, imports = _imports(command)
            largest = sorted(imports.items(), key=lambda item: -item[1])[:5]
            total = sum(imports.values())
            found.append(Process(name, spread(table[:, i]), modules, total, tuple(largest)))
            progress(0.6 + 0.4 * (i + 1) / len(arguments))
    return tuple(found)


def parse_imports(report: str) -> dict[str, float]:
    """Seconds that importing took, by top-level package, from what `python -X importtime` says."""
    packages: dict[str, float] = {}
    for line in report.splitlines():
        head, _, rest = line.partition("import time:")
        own, _, named = rest.partition("|")
        if head or not own.strip().isdigit():
            continue
        package = named.partition("|")[2].strip().split(".")[0]
        packages[package] = packages.get(package, 0.0) + 1e-6 * int(own)
    return packages


def _arguments(command: tuple[str, ...], scene: str, changes: tuple[str, ...], folder: str) -> list[str]:
    verb, *options = command
    out = ["--out", str(Path(folder) / "out")] if verb == "run" else []
    return [verb, scene, *(part for change in changes for part in ("--set", change)), *options, *out]


def _timed(arguments: list[str]) -> float:
    return seconds(lambda: _process([sys.executable, "-m", "tailslap.command_line", *arguments]))


def _imports(arguments: list[str]) -> tuple[int, dict[str, float]]:
    done = _process([sys.executable, "-X", "importtime", "-c", CODE, *arguments])
    return int(done.stdout.splitlines()[-1]), parse_imports(done.stderr)


def _process(command: list[str]) -> subprocess.CompletedProcess[str]:
    """A run whose check fails ends with 1, and is timed like any other."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise OSError(f"{' '.join(command[-4:])} ended with {done.returncode}: {done.stderr[-300:]}")
    return done
