"""What the program decides where the scene leaves it open, each with its reason: a scene without open ends follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Decision:
    """A key of the scene, the value that the program gave it, and why. value None: it stays out."""

    key: str
    value: Any
    why: str

    @property
    def shown(self) -> str:
        """The decision as a line."""
        value = "none" if self.value is None else _shown(self.value)
        return f"{self.key} = {value}: {self.why}"


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return f"[{', '.join(map(str, value))}]" if isinstance(value, tuple) else str(value)
