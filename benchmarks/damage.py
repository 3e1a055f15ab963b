"""Damage files of the program by a random sequence, and count the outcomes.

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
    """Return the outcome of a function in a process of its own, which may die or hang."""
    reading, writing = os.pipe()
    if not (child := os.fork()):
        signal.alarm(PATIENCE_S)
        try:
            said = judge()
        except BaseException as error:  # whatever it is, it is counted
            said = f"BAD {type(error).__name__}: {error}"
        os.write(writing, said.encode()[:4096])
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as file:
        said = file.read()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return said if status == 0 else f"BAD end with {status}"


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


def greatest(value: float, other: float) -> float:
    """A kernel of numbers alone."""
    return value if value > other else other


ARRAY = np.array([1.0, 2.0, 4.0])
CALLS: tuple[tuple[Callable[..., Any], tuple[Any, ...]], ...] = (
    (summed, (ARRAY, 0.5)), (summed, (ARRAY.astype(np.int64), 0.5)), (shifted, (ARRAY, 0.5)),
    (greatest, (1.5, -2.5)), (greatest, (3.0, 2)),
)  # fmt: skip
"""Kernels and arguments of their types; the answer is that of the plain function."""


def caches(count: int, seed: int) -> Judged:
    """Kept code of small kernels: flipped, cut, grown, swapped."""
    from machine_code.compiled import compiled

    os.environ["NUMBA_CACHE_DIR"] = tempfile.mkdtemp()
    files = [compiled(function).path(*given) for function, given in CALLS]
    for function, given in CALLS:
        compiled(function)(*given)
    whole = [path.read_bytes() for path in files]

    def call(which: int) -> str:
        function, given = CALLS[which]
        kernel = compiled(function)
        if kernel(*given) != function(*given):
            return "BAD number"
        return "compiled anew" if "dispatcher" in vars(kernel) else "loaded"

    chance = random.Random(seed)
    for _ in range(count):
        which, how = chance.randrange(len(CALLS)), chance.choice(("flipped", "cut", "grown", "swapped"))
        files[which].write_bytes(damaged(whole[which], how, chance.choice(whole), chance))
        yield how, in_child(lambda which=which: call(which))  # type: ignore[misc]
        files[which].write_bytes(whole[which])


def damaged(content: bytes, how: str, other: bytes, chance: random.Random) -> bytes:
    """The content with such a damage; other: that of another file."""
    found = bytearray(content)
    if how == "flipped":
        for _ in range(chance.randint(1, 8)):
            found[chance.randrange(len(found))] ^= 1 << chance.randrange(8)
    elif how == "cut":
        del found[chance.randrange(len(found)) :]
    elif how == "grown":
        found += b"\0\n"
    else:
        found = bytearray(other if how == "swapped" else chance.choice(WRONG).encode())
    return bytes(found)


def damage(path: Path, how: str, other: Path, chance: random.Random) -> None:
    """Damage a file."""
    content = path.read_bytes()
    path.unlink()
    if how != "missing":
        path.write_bytes(damaged(content, how, other.read_bytes(), chance))


def judged(status: int, told: str, is_right: Callable[[], bool], forced: bool = False) -> str:
    """What came of a command, from its status and messages; by force other numbers come with a remark."""
    if "fault" in told or status not in (0, 1, 2):
        return f"BAD status {status}: {told}"
    if status == 2:
        lines = [line for line in told.splitlines() if ": remark: " not in line]
        return "refused" if len(lines) == 1 else f"BAD message: {told}"
    if forced and ": remark: " in told:
        return "read with a remark"
    return "the same" if is_right() else f"BAD numbers with status {status}: {told}"


class Results:
    """Results whose files are damaged, in a folder each.

    whole: copies that stay as they are; at_work, expected: folders for commands that read a damaged or a whole result.
    """

    def __init__(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        for kind, words in MADE.items():
            assert run_command(*words, "--out", self.folder / kind)[0] in (0, 1), kind
        self.whole = shutil.copytree(self.folder, self.folder.with_name(f"{self.folder.name}-whole"))
        self.at_work, self.expected = self.folder / "out", self.folder / "expected"

    def files(self) -> list[Path]:
        """Files that are read again, beginning with the kind of result."""
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

        shown, status, refusal = "", 0, ""
        whole_numbers = np.printoptions(threshold=sys.maxsize, floatmode="unique")
        with whole_numbers, warnings.catch_warnings(record=True) as remarks:
            warnings.simplefilter("always")
            try:
                shown = numbers_of(self.folder / kind, forced)
            except InputError as error:
                status, refusal = 2, str(error).replace("\n", " ")
            told = refusal or "".join(f": remark: {each.message}\n" for each in remarks)
            return judged(status, told, lambda: shown == numbers_of(self.whole / kind, forced), forced)

    def command(self, words: tuple[str, ...], forced: bool) -> str:
        """Judge a command; @KIND among its words is a result."""

        def made(place: Path, out: Path) -> tuple[int, str, str]:
            given = [str(place / word.strip("@")) if "@" in word else word for word in words]
            return run_command(*given, "--out", out, *["--force"] * forced)

        def is_right() -> bool:
            _, expected, _ = made(self.whole, self.expected)
            same = shown.replace(str(self.at_work), "") == expected.replace(str(self.expected), "")
            return same and all(map(self._is_written, self.expected.iterdir()))

        status, shown, told = made(self.folder, self.at_work)
        if status == 2 and self.at_work.exists():
            return "BAD refused, and something written"
        return judged(status, told, is_right, forced)

    def _is_written(self, path: Path) -> bool:
        """Return True where a file of numbers has the same bytes, and for any other file."""
        if path.suffix not in (".csv", ".json") or path.name[0] == ".":
            return True
        return path.read_bytes() == (self.at_work / path.name).read_bytes()

    def go_on(self) -> str:
        """Judge the sweep, which computes lost rows again."""
        line = [*TAILSLAP, *SWEEP, "--out", str(self.folder / "sweep")]
        given = {**os.environ, "PYTHONPATH": str(ROOT)}
        done = subprocess.run(line, env=given, capture_output=True, text=True, check=False)
        found, whole = self.folder / "sweep", self.whole / "sweep"
        return judged(done.returncode, done.stderr, lambda: sweep_rows(found) == sweep_rows(whole))

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

    found = tailslap.load(place, force=forced)
    arrays = {label: {n: c.tolist() for n, c in h.items()} for label, h in found.histories.items()}
    fields = vars(found.fields) if found.make_fields else {}
    return repr((found.command, found.scene, found.passed, found.summary, arrays, fields))


def results(count: int, seed: int) -> Judged:
    """Files of results, then read by load, compare and export, also by force; and by the sweep, which goes on."""
    made, chance = Results(), random.Random(seed)
    read = made.files()
    for _ in range(count):
        name, how, forced = chance.choice(read), chance.choice(HOWS), chance.random() < 0.3
        kind, other = name.parts[0], made.whole / chance.choice([n for n in read if n != name])
        damage(made.folder / name, how, other, chance)
        readers = made.readers(kind, forced)
        reader = chance.choice([*readers, *["go on"] * (2 * (kind == "sweep"))])
        by_force = " by force" * (forced and reader in readers)
        yield f"{kind}, {reader}{by_force}, {how}", in_child(readers.get(reader, made.go_on))
        made.restore(kind)


def checkpoints(count: int, seed: int) -> Judged:
    """Checkpoints of interrupted runs, from which they go on: with the files of a run that was left alone."""
    from tailslap.storage import checkpoints as kept

    folder = Path(tempfile.mkdtemp())
    whole = folder / "whole"
    kept.SAVE_S, kept.MAX_SHARE = 0.0, math.inf
    save, left = kept.Checkpoints.save, math.inf

    def save_or_stop(self: Any, arrays: Any) -> None:
        nonlocal left
        save(self, arrays)
        left -= 1
        if left == 0:
            raise KeyboardInterrupt

    kept.Checkpoints.save = save_or_stop  # type: ignore[method-assign]
    made = {kind: MADE[kind] for kind in ("run", "other", "impact")}
    for kind, words in made.items():
        left = 10**9
        assert run_command(*words, "--out", whole / kind)[0] in (0, 1), kind
        left = {"run": 3, "other": 1, "impact": 2}[kind] * (10**9 - left) // 4
        assert run_command(*words, "--out", folder / kind)[0] == 130, kind
    left = math.inf
    files = {path: path.read_bytes() for path in sorted(folder.glob(".*checkpoint-*"))}
    print(f"{len(files)} checkpoints", file=sys.stderr)

    def resumed(kind: str) -> str:
        status, _, told = run_command(*made[kind], "--out", folder / kind, "--resume")
        if "fault" in told or status == 2:
            return f"BAD status {status}: {told}"
        names = ("history.csv", "rigid.csv", *["fields.npz"] * (kind == "run"))
        is_same = all((folder / kind / n).read_bytes() == (whole / kind / n).read_bytes() for n in names)
        end = "made anew" if "damaged" in told or "no checkpoint" in told else "gone on from"
        is_resumed = end == "gone on from"
        if how != "missing" and (how == "left whole") != is_resumed:  # others of the run may be there
            return f"BAD {end}: {told}"
        return end if is_same else f"BAD numbers, {end}: {told}"

    chance = random.Random(seed)
    for _ in range(count):
        path, how = chance.choice([*files]), chance.choice((*HOWS, "left whole"))
        other = chance.choice([each for each in files if each != path])
        if how != "left whole":
            damage(path, how, other, chance)
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
