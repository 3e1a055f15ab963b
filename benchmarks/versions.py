"""Equal results with the oldest and the newest dependencies of pyproject.toml.

    .venv/bin/python benchmarks/versions.py [--tests PYTEST-ARGUMENT]...

Makes two environments in a temporary folder, dependencies at their lower bounds in the first, the newest in the second;
runs two scenes with both and prints the relative differences of their summaries; at most 1e-10 is allowed. With --tests
the tests run in both as well.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import command_line
from command_line import ROOT
from oracle import leaves

SCENES = ("paper-table-3", "impact-mash-tl4-sut")
COMPARED = ("fe", "rigid")
"""Their differences have the rounding of both, and are up to a million times smaller."""
LIMIT = 1e-10
SMALL = 1e-12
"""Fraction of the largest number of a table below which only the size of a number matters."""


def environment(folder: Path, oldest: bool) -> str:
    """Make an environment with oldest or newest dependencies."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    names = [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    names = [name.replace(">=", "==") if oldest else name for name in names]
    python = str(folder / "bin" / "python")
    pip = [python, "-m", "pip", "--disable-pip-version-check"]
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    subprocess.run([*pip, "install", "-q", *names], check=True)
    subprocess.run([*pip, "freeze"], check=True)
    return python


def summaries(python: str, folder: Path) -> dict[str, dict[str, float]]:
    """Return the numbers of each scene's summary by name."""
    numbers = {}
    for scene in SCENES:
        line = [python, "-m", "tailslap", "run", scene, "--no-pictures", "--out", str(folder / scene)]
        process = subprocess.run(line, env={**os.environ, "PYTHONPATH": str(ROOT)}, cwd=folder, check=False)
        if process.returncode:
            sys.exit(f"{scene} ends with {process.returncode}")
        summary = json.loads((folder / scene / "summary.json").read_text())
        values: Any = leaves({name: summary[name] for name in COMPARED})
        numbers[scene] = {name: value for name, value in values if isinstance(value, float)}
    return numbers


def largest_difference(ours: dict[str, float], theirs: dict[str, float]) -> tuple[float, str]:
    """Return the largest relative difference of two summaries, and its name."""
    if ours.keys() != theirs.keys():
        return math.inf, f"other entries: {sorted(ours.keys() ^ theirs.keys())[:3]}"
    floor = SMALL * max(map(abs, ours.values()))
    return max((abs(theirs[name] - value) / max(abs(value), floor), name) for name, value in ours.items())


def main() -> None:
    """Compare, and run the tests."""
    options, results, failed = command_line.options(__doc__, tests=[]), [], False
    with tempfile.TemporaryDirectory() as name:
        for oldest in (True, False):
            folder = Path(name) / ("oldest" if oldest else "newest")
            python = environment(folder, oldest)
            results.append(summaries(python, folder))
            if options.tests:
                tests = [python, "-m", "pytest", "-q", *options.tests]
                failed |= bool(subprocess.run(tests, cwd=ROOT).returncode)
    for scene in SCENES:
        difference, where = largest_difference(*(result[scene] for result in results))
        print(f"{scene}: {difference:.1e}, at {where}; at most {LIMIT:g} is allowed")
        failed |= not difference <= LIMIT
    sys.exit(failed)


if __name__ == "__main__":
    main()
