"""Tables of speed.py: rates, their fractions of the machine's, ratios, packed kernels."""

from __future__ import annotations

import platform
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

MINE, UNEVEN, TWO_THREADS = "this program", ", distorted", ", 2 threads"
WANTED = {("Akantu", 7680): 20.0, ("Warp", 7680): 3.0, ("Warp" + UNEVEN, 122880): 2.0}
"""Times as fast as these the loop should be on the same plate."""


@dataclass
class Entry:
    """Line of the table, with the rate of each turn."""

    name: str
    elements: int
    measure: Callable[[], list[float]]
    rates: list[float] = field(default_factory=list)
    remark: str = ""

    def turn(self) -> None:
        """Measure once more, unless it has failed."""
        if not self.remark.startswith("not measured"):
            self.rates += self.measure()

    @property
    def best(self) -> float:
        """Largest rate of all turns."""
        return max(self.rates, default=float("nan"))

    @property
    def median(self) -> float:
        """Median rate of all turns."""
        return statistics.median(self.rates) if self.rates else float("nan")


def print_rates(lines: Sequence[Entry]) -> None:
    """Every entry with its best and median."""
    print(f"{'rate':<26}{'elements':>9}{'best':>11}{'median':>11}  remark")
    for entry in lines:
        size = str(entry.elements or "")
        print(f"{entry.name:<26}{size:>9}{entry.best:>11.3g}{entry.median:>11.3g}  {entry.remark}")


def print_shares(rates: Sequence[Entry], lines: Sequence[Entry], loops: dict[Any, Any]) -> None:
    """Print the rates of the loop on one core over those of the machine, best by best."""
    from bound import bytes_per_update, flops_per_update

    copying, arithmetic, _ = rates
    print(f"\n{'share of what the machine can do':<35}{'flop':>6}{'byte':>6}{'arithmetic':>12}", end="")
    print(f"{'bandwidth':>11}{'the lesser':>12}")
    for entry in lines:
        stepper = loops.get((entry.name, entry.elements))
        if stepper is None or TWO_THREADS in entry.name:
            continue
        flops, moved = flops_per_update(stepper), bytes_per_update(stepper)
        shares = entry.best * flops / arithmetic.best, entry.best * moved / copying.best
        print(f"{entry.name:<26}{entry.elements:>9}{flops:>6.0f}{moved:>6.0f}", end="")
        print(f"{shares[0]:>12.0%}{shares[1]:>11.0%}{max(shares):>12.0%}")
    print(
        "Bandwidth binds only where the arrays are far larger than the cache; within it, shares may pass 100 %."
    )


def print_ratios(rates: Sequence[Entry], lines: Sequence[Entry]) -> None:
    """This program against the others, and distorted and two threads against plain."""
    found = {(entry.name, entry.elements): entry for entry in lines}
    _, one, two = rates
    pairs: list[tuple[str, float | None, Entry, Entry]] = [("multiply-adds, 2 threads / 1", None, two, one)]
    for (name, count), entry in found.items():
        if not name.startswith(MINE):
            mine = MINE + UNEVEN * name.endswith(UNEVEN)
            what = f"{mine} / {name}, {count} elements"
            pairs.append((what, WANTED.get((name, count)), found[mine, count], entry))
        elif name != MINE:
            wanted = 1.7 if TWO_THREADS in name else None
            pairs.append((f"{name} / plain, {count} elements", wanted, entry, found[MINE, count]))
    print(f"\n{'ratio':<60}{'wanted':>8}{'of bests':>10}{'of medians':>12}")
    for what, wanted, above, below in pairs:
        asked = f"{wanted:g}" if wanted else ""
        best, median = above.best / below.best, above.median / below.median
        print(f"{what:<60}{asked:>8}{best:>10.2f}{median:>12.2f}")


def check_packing(stepper: Any) -> int:
    """Print whether the kernel is packed; the exit status."""
    from bound import multiply_adds

    if platform.machine() not in ("x86_64", "AMD64"):
        print(f"\nassembly: not looked at, this is {platform.machine()} and not x86-64")
        return 0
    packed, scalar = multiply_adds(stepper)
    fine = packed > 0 and packed >= scalar
    print(f"\nassembly: {packed} packed multiply-adds, {scalar} scalar: {'packed' if fine else 'NOT PACKED'}")
    return 0 if fine else 1
