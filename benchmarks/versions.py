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
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import command_line

ROOT = Path(__file__).parents[1]
SCENES = ("paper-table-3", "impact-mash-tl4-sut")
COMPARED = ("fe", "rigid")
"""Their differences have the rounding of both, and are up to a million times smaller."""
LIMIT = 1e-10
SMALL = 1e-12
"""Fraction of the largest number of a table below which only the size of a number matters."""


def requirements(oldest: bool) -> list[str]:
    """Dependencies with pytest and what tests need; the oldest that are allowed, or whatever is newest."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    return [name.replace(">=", "==") if oldest else name for name in wanted]


def environment(folder: Path, oldest: bool) -> Path:
    """A new virtual environment's python."""
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    python = folder / "bin" / "python"
    install = [
        str(python),
        "-m",
        "pip",
        "install",
        "-q",
        "--disable-pip-version-check",
        *requirements(oldest),
    ]
    subprocess.run(install, check=True)
    return python


def summaries(python: Path, folder: Path) -> dict[str, Any]:
    """Return the summaries of the scenes."""
    found = {}
    for scene in SCENES:
        line = [str(python), "-m", "tailslap", "run", scene, "--no-pictures", "--out", str(folder / scene)]
        done = subprocess.run(line, env={**os.environ, "PYTHONPATH": str(ROOT)}, cwd=folder, check=False)
        if done.returncode:
            sys.exit(f"{scene} ends with {done.returncode}")
        summary = json.loads((folder / scene / "summary.json").read_text())
        found[scene] = {name: summary[name] for name in COMPARED}
    return found


def numbers(value: Any, name: str = "") -> Iterator[tuple[str, float]]:
    """Every number in it, by its place."""
    if isinstance(value, dict | list):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for key, inner in pairs:
            yield from numbers(inner, f"{name}.{key}")
    elif isinstance(value, float):
        yield name, value


def largest_difference(first: Any, second: Any) -> tuple[float, str]:
    """Of two summaries: relative, and where."""
    ours, its = dict(numbers(first)), dict(numbers(second))
    if ours.keys() != its.keys():
        return math.inf, f"other entries: {sorted(ours.keys() ^ its.keys())[:3]}"
    floor = SMALL * max(map(abs, ours.values()))
    return max((abs(its[name] - value) / max(abs(value), floor), name) for name, value in ours.items())


def main() -> None:
    """Compare, and run the tests where they are asked for."""
    parser = command_line.parser(__doc__)
    parser.add_argument("--tests", action="append", default=[])
    chosen, found, failed = parser.parse_args(), [], False
    with tempfile.TemporaryDirectory() as name:
        for oldest in (True, False):
            folder = Path(name) / ("oldest" if oldest else "newest")
            python = environment(folder, oldest)
            subprocess.run([str(python), "-m", "pip", "freeze", "--disable-pip-version-check"], check=True)
            found.append(summaries(python, folder))
            if chosen.tests:
                failed |= bool(
                    subprocess.run([str(python), "-m", "pytest", "-q", *chosen.tests], cwd=ROOT).returncode
                )
        for scene in SCENES:
            difference, where = largest_difference(*(each[scene] for each in found))
            print(f"{scene}: {difference:.1e}, at {where}; {LIMIT:g} is promised")
            failed |= not difference <= LIMIT
    sys.exit(failed)


if __name__ == "__main__":
    main()
