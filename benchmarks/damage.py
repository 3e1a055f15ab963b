"""Damage files of the program at random, and count the outcomes.

    .venv/bin/python benchmarks/damage.py PART [COUNT [SEED]]

PART: `caches`, the compiled code; `results`, folders of a run, a whole impact, a sweep and a study; `checkpoints`, of
a run and of a whole impact. After each damage a process of its own reads the file; it must end with the correct numbers
or one message. A wrong number, a signal, a process that hangs or a "fault of the
program" is printed with the number of the damage, and the status is 1.
"""

from __future__ import annotations

import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import command_line
import numpy as np
from command_line import ROOT, TAILSLAP, run_command, sweep_rows

PATIENCE_S = 60
"""Seconds after which a process hangs."""
Judged = Iterator[tuple[str, str]]
"""Description and outcome of each damage; the outcome of a fault begins with "BAD"."""
WRONG = (
    *("", "{", "[]", "null", "3", '"a"', "{}", "[" * 100_000, "t,v_gy\n0,1\n2\n"),
    '{"files": 3, "program": "tailslap"}',
    '{"scene": 1, "passed": "x", "verdict": {}, "fe": {"t": "1"}, "rigid": [], "checks": {}}',
    '{"scene": "a", "passed": 1, "fe": {"strikes": [1]}, "rigid": {"strikes": "b"}, "checks": [3]}',
)
"""Texts of wrong types."""
HOWS = ("flipped", "cut", "grown", "swapped", "of wrong types", "missing")
SMALL = ("--set", "plate.elements=[6,2]")
SWEEP = ("sweep", "paper-table-3", *SMALL, "--vary", "corner.friction=0.1:0.4:3", "--workers", "1")
MADE = {
    "run": ("run", "paper-table-3", *SMALL, "--set", "output.fields=3", "--no-pictures"),
    "other": ("run", "paper-table-3", *SMALL, "--set", "corner.friction=0.2", "--no-pictures"),
    "impact": ("run", "impact-mash-tl4-sut", *SMALL, "--set", "time.end=0.1 s", "--no-pictures"),
    "sweep": SWEEP,
    "study": ("study", "uncertainty", "mash-tl4-sut", "--samples", "1000"),
}
"""Commands whose results are damaged."""


def in_child(judge: Callable[[], str]) -> str:
    """Return the outcome of a function in a process that may die."""
    reading, writing = os.pipe()
    if not (child := os.fork()):
        signal.alarm(PATIENCE_S)
        try:
            outcome = judge()
        except BaseException as error:  # whatever it is, it is counted
            outcome = f"BAD {type(error).__name__}: {error}"
        os.write(writing, outcome.encode()[:4096])
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as file:
        outcome = file.read()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return outcome if status == 0 else f"BAD end with {status}"


class Sums(NamedTuple):
    """What `summed` returns."""

    total: float
    size: int


def summed(values: Any, factor: float) -> Sums:
    """A kernel."""
    total = 0.0
    for i in range(values.size):
        total += factor * values[i]
    return Sums(total, values.size)


def shifted(values: Any, factor: float) -> Sums:
    """A kernel with the same arguments and another result."""
    total = 1.0
    for i in range(values.size):
        total -= factor * values[i]
    return Sums(total, -values.size)


def greatest(first: float, second: float) -> float:
    """A kernel of numbers alone."""
    return first if first > second else second


ARRAY = np.array([1.0, 2.0, 4.0])
CALLS: tuple[tuple[Callable[..., Any], tuple[Any, ...]], ...] = (
    (summed, (ARRAY, 0.5)), (summed, (ARRAY.astype(np.int64), 0.5)), (shifted, (ARRAY, 0.5)),
    (greatest, (1.5, -2.5)), (greatest, (3.0, 2)),
)  # fmt: skip
"""Kernels and arguments of their types; the answer is that of the plain function."""


def caches(count: int, seed: int) -> Judged:
    """Damage stored code of small kernels."""
    from machine_code.compiled import compiled

    os.environ["TAILSLAP_CACHE_DIR"] = tempfile.mkdtemp()
    files = [compiled(function).path(*arguments) for function, arguments in CALLS]
    for function, arguments in CALLS:
        compiled(function)(*arguments)
    contents = [path.read_bytes() for path in files]

    def call(which: int) -> str:
        function, arguments = CALLS[which]
        kernel = compiled(function)
        if kernel(*arguments) != function(*arguments):
            return "BAD number"
        return "compiled anew" if "dispatcher" in vars(kernel) else "loaded"

    chance = random.Random(seed)
    for _ in range(count):
        which, how = chance.randrange(len(CALLS)), chance.choice(("flipped", "cut", "grown", "swapped"))
        files[which].write_bytes(damaged(contents[which], how, chance.choice(contents), chance))
        yield how, in_child(lambda which=which: call(which))  # type: ignore[misc]
        files[which].write_bytes(contents[which])


def damaged(content: bytes, how: str, replacement: bytes, chance: random.Random) -> bytes:
    """The content with a damage, or other content."""
    result = bytearray(content)
    if how == "flipped":
        for _ in range(chance.randint(1, 8)):
            result[chance.randrange(len(result))] ^= 1 << chance.randrange(8)
    elif how == "cut":
        del result[chance.randrange(len(result)) :]
    elif how == "grown":
        result += b"\0\n"
    else:
        result = bytearray(replacement if how == "swapped" else chance.choice(WRONG).encode())
    return bytes(result)


def damage(path: Path, how: str, replacement: Path, chance: random.Random) -> None:
    """Damage a file."""
    content = path.read_bytes()
    path.unlink()
    if how != "missing":
        path.write_bytes(damaged(content, how, replacement.read_bytes(), chance))


def judged(status: int, messages: str, is_right: Callable[[], bool], forced: bool = False) -> str:
    """Outcome of a command by its status and messages.

    By force other numbers come with a remark.
    """
    if "fault" in messages or status not in (0, 1, 2):
        return f"BAD status {status}: {messages}"
    if status == 2:
        lines = [line for line in messages.splitlines() if ": remark: " not in line]
        return "refused" if len(lines) == 1 else f"BAD message: {messages}"
    if forced and ": remark: " in messages:
        return "read with a remark"
    return "the same" if is_right() else f"BAD numbers with status {status}: {messages}"


class Results:
    """Results whose files are damaged, in a folder each.

    whole: copies that stay intact; at_work, expected: folders for commands that read a damaged or an intact result.
    """

    def __init__(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        for kind, words in MADE.items():
            assert run_command(*words, "--out", self.folder / kind)[0] in (0, 1), kind
        self.whole = shutil.copytree(self.folder, self.folder.with_name(f"{self.folder.name}-whole"))
        self.at_work, self.expected = self.folder / "out", self.folder / "expected"

    def files(self) -> list[Path]:
        """Files that are read again, each below the kind of its result."""
        files = sorted(path.relative_to(self.whole) for path in self.whole.rglob("*") if path.is_file())
        return [name for name in files if name.suffix not in (".svg", ".html", ".png", ".gif")]

    def restore(self, kind: str) -> None:
        """Make a result whole again, and remove what was written."""
        for place in (self.folder / kind, self.at_work, self.expected):
            shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(self.whole / kind, self.folder / kind)

    def load(self, kind: str, forced: bool) -> str:
        """Judge `tailslap.load`."""
        from tailslap import InputError

        numbers, status, refusal = "", 0, ""
        whole_numbers = np.printoptions(threshold=sys.maxsize, floatmode="unique")
        with whole_numbers, warnings.catch_warnings(record=True) as remarks:
            warnings.simplefilter("always")
            try:
                numbers = numbers_of(self.folder / kind, forced)
            except InputError as error:
                status, refusal = 2, str(error).replace("\n", " ")
            messages = refusal or "".join(f": remark: {remark.message}\n" for remark in remarks)
            return judged(status, messages, lambda: numbers == numbers_of(self.whole / kind, forced), forced)

    def command(self, words: tuple[str, ...], forced: bool) -> str:
        """Judge a command whose words name results by @KIND."""

        def run(place: Path, out: Path) -> tuple[int, str, str]:
            arguments = [str(place / word.strip("@")) if "@" in word else word for word in words]
            return run_command(*arguments, "--out", out, *["--force"] * forced)

        def is_right() -> bool:
            _, expected, _ = run(self.whole, self.expected)
            same = output.replace(str(self.at_work), "") == expected.replace(str(self.expected), "")
            return same and all(map(self._is_written, self.expected.iterdir()))

        status, output, messages = run(self.folder, self.at_work)
        if status == 2 and self.at_work.exists():
            return "BAD refused, and something written"
        return judged(status, messages, is_right, forced)

    def _is_written(self, path: Path) -> bool:
        """Return True unless a file of numbers has other bytes."""
        if path.suffix not in (".csv", ".json") or path.name[0] == ".":
            return True
        return path.read_bytes() == (self.at_work / path.name).read_bytes()

    def go_on(self) -> str:
        """Judge the sweep, which computes lost rows again."""
        line = [*TAILSLAP, *SWEEP, "--out", str(self.folder / "sweep")]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        process = subprocess.run(line, env=environment, capture_output=True, text=True, check=False)
        damaged_sweep, intact_sweep = self.folder / "sweep", self.whole / "sweep"
        return judged(
            process.returncode, process.stderr, lambda: sweep_rows(damaged_sweep) == sweep_rows(intact_sweep)
        )

    def readers(self, kind: str, forced: bool) -> dict[str, Callable[[], str]]:
        """Judgements of what reads a result of this kind, by name."""
        return {
            "load": lambda: self.load(kind, forced),
            "compare": lambda: self.command(("compare", "@other", f"@{kind}", "--json"), forced),
            "export": lambda: self.command(("export", f"@{kind}", "--to", "csv"), forced),
        }


def numbers_of(place: Path, forced: bool) -> str:
    """All numbers of a result, to the bit."""
    import tailslap

    result = tailslap.load(place, force=forced)
    arrays = {label: {n: c.tolist() for n, c in h.items()} for label, h in result.histories.items()}
    fields = vars(result.fields) if result.make_fields else {}
    return repr((result.command, result.scene, result.passed, result.summary, arrays, fields))


def results(count: int, seed: int) -> Judged:
    """Damage results, read by load, compare and export, and by the sweep."""
    store, chance = Results(), random.Random(seed)
    read = store.files()
    for _ in range(count):
        name, how, forced = chance.choice(read), chance.choice(HOWS), chance.random() < 0.3
        kind, replacement = name.parts[0], store.whole / chance.choice([n for n in read if n != name])
        damage(store.folder / name, how, replacement, chance)
        readers = store.readers(kind, forced)
        reader = chance.choice([*readers, *["go on"] * (2 * (kind == "sweep"))])
        by_force = " by force" * (forced and reader in readers)
        yield f"{kind}, {reader}{by_force}, {how}", in_child(readers.get(reader, store.go_on))
        store.restore(kind)


def checkpoints(count: int, seed: int) -> Judged:
    """Damage checkpoints of interrupted runs, and resume from them."""
    from tailslap.storage import checkpoints as storage

    folder = Path(tempfile.mkdtemp())
    intact = folder / "whole"
    storage.SAVE_S, storage.MAX_SHARE = 0.0, math.inf
    save, remaining = storage.Checkpoints.save, math.inf

    def save_or_stop(self: Any, arrays: Any) -> None:
        nonlocal remaining
        save(self, arrays)
        remaining -= 1
        if remaining == 0:
            raise KeyboardInterrupt

    storage.Checkpoints.save = save_or_stop  # type: ignore[method-assign]
    commands = {kind: MADE[kind] for kind in ("run", "other", "impact")}
    for kind, words in commands.items():
        remaining = 10**9
        assert run_command(*words, "--out", intact / kind)[0] in (0, 1), kind
        remaining = {"run": 3, "other": 1, "impact": 2}[kind] * (10**9 - remaining) // 4
        assert run_command(*words, "--out", folder / kind)[0] == 130, kind
    remaining = math.inf
    files = {path: path.read_bytes() for path in sorted(folder.glob(".*checkpoint-*"))}
    print(f"{len(files)} checkpoints", file=sys.stderr)

    def resumed(kind: str) -> str:
        status, _, messages = run_command(*commands[kind], "--out", folder / kind, "--resume")
        if "fault" in messages or status == 2:
            return f"BAD status {status}: {messages}"
        names = ("history.csv", "rigid.csv", *["fields.npz"] * (kind == "run"))
        is_same = all((folder / kind / n).read_bytes() == (intact / kind / n).read_bytes() for n in names)
        end = "made anew" if "damaged" in messages or "no checkpoint" in messages else "gone on from"
        is_resumed = end == "gone on from"
        if how != "missing" and (how == "left whole") != is_resumed:  # others of the run may be there
            return f"BAD {end}: {messages}"
        return end if is_same else f"BAD numbers, {end}: {messages}"

    chance = random.Random(seed)
    for _ in range(count):
        path, how = chance.choice([*files]), chance.choice((*HOWS, "left whole"))
        replacement = chance.choice([entry for entry in files if entry != path])
        if how != "left whole":
            damage(path, how, replacement, chance)
        kind = path.name[1:].partition(".")[0]
        yield f"{kind}, {how}", in_child(lambda kind=kind: resumed(kind))  # type: ignore[misc]
        shutil.rmtree(folder / kind, ignore_errors=True)
        for path, content in files.items():
            path.write_bytes(content)


PARTS: dict[str, Callable[[int, int], Judged]] = {
    function.__name__: function for function in (caches, results, checkpoints)
}
"""Functions that damage each part, by count and seed."""


def main() -> None:
    """Damage a part, and print the outcomes."""
    options = command_line.options(__doc__, ("part", tuple(PARTS)), ("count", 400), ("seed", 1))
    outcomes = Counter[str]()
    for number, (how, said) in enumerate(PARTS[options.part](options.count, options.seed)):
        outcomes[f"{how:<40}  {said.partition(':')[0]}"] += 1
        if said.startswith("BAD"):
            print(f"{number}: {how}: {said}", flush=True)
    print(command_line.counts(outcomes))
    print(f"{outcomes.total()} of {options.part} damaged, seed {options.seed}")
    sys.exit(any("  BAD" in outcome for outcome in outcomes))


if __name__ == "__main__":
    main()
