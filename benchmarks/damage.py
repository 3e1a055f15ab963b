"""Damages what the program keeps, in many seeded ways, and counts what came of it.

    .venv/bin/python benchmarks/damage.py PART [COUNT [SEED]]

PART is what is damaged: `caches`, the compiled code. Each damage is followed by what reads it, in a process of its own;
it ends right, or with the one message that it should. A wrong number, a signal, a process that hangs or a "fault of the
program" is printed with the number of the damage, and the status is 1.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

PATIENCE_S = 60
"""Seconds after which a process hangs."""

Judged = Iterator[tuple[str, str]]
"""Of each damage its words, and what came of it; words that begin with "BAD" are the end that must not be."""


def in_child(judge: Callable[[], str]) -> str:
    """What a judgement says in a process of its own, which may die or hang over it."""
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
    count: int


def summed(values: Any, factor: float) -> Sums:
    """A kernel."""
    total = 0.0
    for i in range(values.size):
        total += factor * values[i]
    return Sums(total, values.size)


def shifted(values: Any, factor: float) -> Sums:
    """A kernel whose code takes the same arguments, and says something else."""
    total = 1.0
    for i in range(values.size):
        total -= factor * values[i]
    return Sums(total, -values.size)


def greatest(value: float, other: float) -> float:
    """A kernel of numbers alone."""
    return value if value > other else other


ARRAY = np.array([1.0, 2.0, 4.0])
CALLS: tuple[tuple[Callable[..., Any], tuple[Any, ...]], ...] = (
    (summed, (ARRAY, 0.5)),
    (summed, (ARRAY.astype(np.int64), 0.5)),
    (shifted, (ARRAY, 0.5)),
    (greatest, (1.5, -2.5)),
    (greatest, (3.0, 2)),
)
"""Kernels and arguments of their types; the answer is that of the plain function."""


def caches(count: int, seed: int) -> Judged:
    """Kept code of small kernels: flipped, cut, grown, swapped."""
    from fem.machine_code.compiled import compiled

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
        which = chance.randrange(len(CALLS))
        content, how = bytearray(whole[which]), chance.choice(("flipped", "cut", "grown", "swapped"))
        if how == "flipped":
            for _ in range(chance.randint(1, 8)):
                content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        elif how == "swapped":
            content = bytearray(whole[chance.randrange(len(CALLS))])
        else:
            content = content[: chance.randrange(len(content))] if how == "cut" else content + b"\0\n"
        files[which].write_bytes(content)
        yield how, in_child(lambda which=which: call(which))  # type: ignore[misc]
        files[which].write_bytes(whole[which])


PARTS: dict[str, Callable[[int, int], Judged]] = {"caches": caches}
"""What can be damaged, and what damages it so many times from a seed."""


def main() -> None:
    """Damage a part, and print what came of it."""
    parser = argparse.ArgumentParser(description="Damages what the program keeps.")
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("count", type=int, nargs="?", default=400)
    parser.add_argument("seed", type=int, nargs="?", default=1)
    options = parser.parse_args()
    counted: Counter[tuple[str, str]] = Counter()
    for number, (how, said) in enumerate(PARTS[options.part](options.count, options.seed)):
        counted[how, said.partition(":")[0]] += 1
        if said.startswith("BAD"):
            print(f"{number}: {how}: {said}", flush=True)
    for (how, said), times in sorted(counted.items()):
        print(f"{times:6d}  {how:<40}  {said}")
    print(f"{counted.total()} of {options.part} damaged, seed {options.seed}")
    sys.exit(any(said.startswith("BAD") for _, said in counted))


if __name__ == "__main__":
    main()
