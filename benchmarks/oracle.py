"""Bits of results before and after a change.

    .venv/bin/python benchmarks/oracle.py make FOLDER [--root CHECKOUT] [--only NAME]
    .venv/bin/python benchmarks/oracle.py compare OLD NEW [--tolerance X]

`make` runs each command in a checkout and leaves its terminal text, its CSV files and its summary in FOLDER/NAME.
`compare` sets two such folders side by side. Histories must have the same bytes; summaries and texts must be equal
without times. Where they are not, numbers are compared, and the largest relative difference is printed.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import command_line
from command_line import TAILSLAP

CAR_TESTS = [f"mash-tl{level}-{kind}" for level in (1, 2, 3) for kind in ("car", "pickup")]
CORNER = (*CAR_TESTS, "mash-tl4-sut", "paper-abaqus", "paper-table-3")
EXAMPLES = Path(__file__).parents[1] / "examples"
IMPACT = {f"impact-linear-{name}": str(EXAMPLES / f"linear-{name}.toml") for name in ("truck", "train")}
"""Scenes of this checkout, which the program of another one reads too."""
TRUCK = IMPACT["impact-linear-truck"]
VARIED = {
    "soft": ("paper-table-3", "plate.youngs_modulus=2 GPa"),
    "neo-hookean": ("paper-table-3", "material.law=neo-hookean", "plate.element=quad9"),
    "threads": ("paper-table-3", "time.threads=2"),
    "unstressed": ("paper-table-3", "plate.start=unstressed"),
    "fields": ("mash-tl4-sut", "output.fields=5"),
    "exact": ("mash-tl3-car", "corner.constraint=exact"),
    "failing": ("paper-table-3", "plate.youngs_modulus=0.01 GPa"),
    "impact-exact": (TRUCK, "contact.enforcement=exact", "contact.stiffness=3 MN/m"),
    "impact-fields": (TRUCK, "output.fields=5"),
}
TIMES = re.compile(r"(_s|\.rate|overhead|speed|seconds|run_s|reused|version|digest)$")
DURATION = re.compile(r"\b\d[\d.,]*(e-?\d+)? (s|ms|us|µs|min|h|MiB|GiB)\b")


def commands() -> dict[str, tuple[str, ...]]:
    """Arguments by name, with {out} for the result folder."""
    arguments: dict[str, tuple[str, ...]] = {}
    for name, scene in ({scene: scene for scene in CORNER} | IMPACT).items():
        arguments[f"run-{name}"] = ("run", scene, "--no-pictures", "--out", "{out}")
        arguments[f"check-{name}"] = ("check", scene)
        arguments[f"rigid-{name}"] = ("rigid", scene)
        arguments[f"rigid-json-{name}"] = ("rigid", scene, "--json")
    for name, (scene, *changes) in VARIED.items():
        options = tuple(part for change in changes for part in ("--set", change))
        arguments[f"run-{name}"] = ("run", scene, *options, "--no-pictures", "--out", "{out}")
        arguments[f"check-{name}"] = ("check", scene, *options)
    further = {
        "us-run": "run mash-tl4-sut --no-pictures --units us --out {out}",
        "us-rigid": "rigid mash-tl4-sut --units us",
        "us-impact": f"rigid {TRUCK} --units us",
        "modal": "modal mash-tl4-sut",
        "modes": "modes mash-tl4-sut --out {out}",
        "paper": "paper --out {out}",
        "scenes": "scenes",
        "sweep-impact": f"sweep {TRUCK} --vary contact.friction=0.2:0.6:3 --out {{out}}",
        "uncertainty": "study uncertainty mash-tl4-sut --samples 1000 --out {out}",
        "flexibility": "study flexibility mash-tl4-sut --points 5 --out {out}",
        "random": "study stability mash-tl4-sut --random 3 --out {out}",
    }
    arguments |= {name: tuple(words.split()) for name, words in further.items()}
    modulus = "plate.youngs_modulus=log:2 GPa:200 GPa:3"
    arguments["sweep"] = ("sweep", "paper-table-3", "--vary", modulus, "--out", "{out}")
    return arguments


def make(folder: Path, root: Path, only: str) -> None:
    """Run the commands in a checkout, and store their statuses."""
    environment = os.environ | {"PYTHONPATH": str(root), "COLUMNS": "110"}
    for name, arguments in commands().items():
        place = folder / name
        if not re.search(only, name) or (place / "status").exists():
            continue
        place.mkdir(parents=True, exist_ok=True)
        command = [*TAILSLAP, *(part.format(out=place / "result") for part in arguments)]
        process = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True)
        (place / "stdout").write_text(process.stdout.replace(str(place), "OUT"))
        (place / "status").write_text(f"{process.returncode}\n")
        print(f"{name}: {process.returncode}", flush=True)


def leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Numbers and texts of a summary by dotted name, without times."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, f"{name}.{key}")
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from leaves(item, f"{name}.{index}")
    elif not TIMES.search(name):
        yield name, value


def table(path: Path) -> Iterator[tuple[str, Any]]:
    """Cells of a table of a sweep, without times and versions."""
    import pyarrow.parquet as parquet

    for name, column in parquet.read_table(path).to_pydict().items():
        if not TIMES.search(name) and not name.startswith("version"):
            yield from ((f"{name}.{row}", value) for row, value in enumerate(column))


def values(path: Path) -> dict[str, Any]:
    """Numbers and texts of a file, by name."""
    if path.suffix == ".parquet":
        return dict(table(path))
    text = path.read_text()
    if path.suffix == ".json" or text.startswith("{"):
        return dict(leaves(json.loads(text)))
    if path.suffix == ".csv":
        return columns(text)
    lines = (line for line in text.splitlines() if not line.startswith("Cost"))
    return {f"line {n}": DURATION.sub("TIME", line) for n, line in enumerate(lines)}


def columns(text: str) -> dict[str, Any]:
    """Cells of a CSV file without times.

    Numbers are fractions of the largest of their column.
    """
    head, *rows = (line.split(",") for line in text.splitlines())
    cells_by_name: dict[str, Any] = {}
    for name, *cells in zip(head, *rows, strict=False):
        numbers = [number(cell) for cell in cells]
        most = max((abs(cell) for cell in numbers if isinstance(cell, float)), default=1.0) or 1.0
        if not TIMES.search(name):
            scaled = (cell / most if isinstance(cell, float) else cell for cell in numbers)
            cells_by_name |= {f"{name}.{row}": cell for row, cell in enumerate(scaled)}
            cells_by_name[f"{name}, largest"] = most
    return cells_by_name


def number(text: str) -> Any:
    """A number where the text is one."""
    try:
        return float(text)
    except ValueError:
        return text


def difference(old: Any, new: Any) -> float:
    """Difference of two numbers, relative above 1.

    0 where they are equal, infinite for what is no number.
    """
    if old == new or (old != old and new != new):
        return 0.0
    numbers = isinstance(old, int | float) and isinstance(new, int | float)
    return abs(new - old) / max(abs(old), abs(new), 1.0) if numbers else float("inf")


def compared(old: Path, new: Path, tolerance: float) -> bool:
    """Compare a file with its earlier state, and print differences."""
    if not new.exists():
        print(f"  {old.name}: is missing")
        return False
    if old.read_bytes() == new.read_bytes():
        return True
    before, after = values(old), values(new)
    differences = {name: difference(value, after.get(name)) for name, value in before.items()}
    differences |= dict.fromkeys(set(after) - set(before), float("inf"))
    worst = sorted(
        (name for name, by in differences.items() if by > tolerance), key=lambda name: -differences[name]
    )
    for name in worst[:4]:
        print(f"  {old.name}{name}: {before.get(name)!r} -> {after.get(name)!r}")
    if worst:
        print(
            f"  {old.name}: {len(worst)} of {len(differences)} differ, by {differences[worst[0]]:.2g} at most"
        )
    return not worst


def compare(old: Path, new: Path, tolerance: float) -> int:
    """Compare all common results, and return 1 for a difference."""
    failed = 0
    names = sorted(path.name for path in old.iterdir() if (path / "status").exists())
    for name in names:
        if not (new / name / "status").exists():
            continue
        files = [path for path in sorted((old / name).rglob("*")) if compares(path)]
        fine = [compared(path, new / path.relative_to(old), tolerance) for path in files]
        print(f"{name}: {len(files)} files, {'same' if all(fine) else 'DIFFERENT'}")
        failed += not all(fine)
    print(f"{failed} of {len(names)} differ")
    return bool(failed)


def compares(path: Path) -> bool:
    """Return True for files whose content is to stay."""
    wanted = path.suffix in {".csv", ".parquet", ".json"} or path.name in {"stdout", "status"}
    return wanted and not path.name.startswith(".") and path.name != "sweep.json"


def main() -> None:
    """Make or compare."""
    options = command_line.options(
        __doc__,
        ("what", ("make", "compare")),
        ("folders", []),
        root=str(command_line.ROOT),
        only="",
        tolerance=0.0,
    )
    folders = [Path(folder) for folder in options.folders]
    if options.what == "make":
        make(folders[0].resolve(), Path(options.root).resolve(), options.only)
    else:
        sys.exit(compare(folders[0], folders[1], options.tolerance))


if __name__ == "__main__":
    main()
