"""Run many random command lines, as test_fuzz.py does.

    .venv/bin/python tests/faults/random_command_lines.py [COUNT [SEED]]

Stops at the first that ends badly, shortened to what matters. Without COUNT there are 200 000; each takes about 10 ms.
"""

from __future__ import annotations

import itertools
import sys

from hypothesis import given, seed, settings
from test_fuzz import command_lines, demand_good_end, fuzz

PROGRESS = 5_000
"""Command lines between two lines of progress."""


def main() -> None:
    """Run random command lines."""
    count, number = (*map(int, sys.argv[1:]), *(200_000, 1)[len(sys.argv) - 1 :])
    numbers = itertools.count(1)

    @seed(number)
    @settings(fuzz, max_examples=count, derandomize=False)
    @given(command_lines())
    def job(arguments: list[str]) -> None:
        demand_good_end(arguments)
        if (finished := next(numbers)) % PROGRESS == 0:
            print(f"{finished} of {count}", file=sys.stderr, flush=True)

    job()
    print(f"{count} command lines, seed {number}: each ended as it should")


if __name__ == "__main__":
    main()
