"""Whether a part left out costs time: the program's loop without parts against a loop that never had them."""

from __future__ import annotations

from dataclasses import dataclass

from tailslap.studies.features.timing import Floats, Ratio, ratio

MEASURABLE = 1.05
"""Ratio above which the program's loop costs measurably more than the bare one, however quiet the machine."""

SAME = 1e-9
"""Difference of positions, over the plate's length, that rounding may make."""

FREE, COSTS, UNSETTLED = "free", "costs", "unsettled"


@dataclass(frozen=True)
class Proof:
    """The program's loop over the bare one; over itself, the noise; largest difference of positions, its steps."""

    program_over_bare: Ratio
    program_over_itself: Ratio
    difference: float
    steps: int

    @property
    def ratios(self) -> dict[str, Ratio]:
        """By name."""
        return {
            "plain, over itself": self.program_over_itself,
            "plain, over the bare loop": self.program_over_bare,
        }

    @property
    def limit(self) -> float:
        """Ratio that is not told from 1: what is measurable at all, and more on a noisy machine."""
        return max(MEASURABLE, self.program_over_itself.high)

    @property
    def verdict(self) -> str:
        """COSTS only where the whole interval is above the limit, FREE where it is wholly below what is measurable."""
        if not self.program_over_bare.low <= self.limit:
            return COSTS
        return FREE if self.program_over_bare.high <= MEASURABLE else UNSETTLED

    @property
    def same(self) -> bool:
        """Whether the two loops computed the same."""
        return self.difference <= SAME

    @property
    def passed(self) -> bool:
        """Fails for a real difference only; a machine too noisy to tell does not fail it."""
        return self.same and self.verdict != COSTS


def prove(plain: Floats, again: Floats, bare: Floats, difference: float, steps: int) -> Proof:
    """From times of shape (turns,) of the program's loop, of the same once more, and of the bare loop."""
    return Proof(ratio(plain, bare), ratio(again, plain), difference, steps)
