"""Inspection of a page on screens and on paper."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from browser import charts, paper, screen
from browser.session import opened

WIDTHS, SCHEMES = (1280, 768, 390), ("light", "dark")
LARGEST_MB = 3.0


@dataclass(frozen=True)
class Looked:
    """Findings of a page by their subject, and its size [MB]."""

    name: str
    size: float
    found: dict[str, list[str]] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """How much was found."""
        return sum(map(len, self.found.values()))


def look(browser: Any, name: str, path: Path, widths: Sequence[int] = WIDTHS) -> Looked:
    """Inspect a page on screens of these widths [pixels] and on paper."""
    size = path.stat().st_size / 1e6
    found: dict[str, list[str]] = {
        "axe": [],
        "sideways": [],
        "broken": [],
        "words": [],
        "console": [],
        "requests": [],
    }
    for width in widths:
        for scheme in SCHEMES:
            _on_screen(browser, path, width, scheme, found)
    found["no scripts"] = _without_scripts(browser, path)
    found["paper"] = _on_paper(browser, path)
    found["MB"] = [f"{size:.1f} MB, over {LARGEST_MB:g}"] if size > LARGEST_MB else []
    return Looked(name, size, found)


def _on_screen(browser: Any, path: Path, width: int, scheme: str, found: dict[str, list[str]]) -> None:
    looks: dict[str, Callable[[Any], list[str]]] = {"axe": screen.violations}
    if scheme == "light":
        looks |= {"sideways": screen.outside, "broken": screen.broken, "words": charts.words}
    with opened(browser, path, width, scheme) as shown:
        for kind, seen in looks.items():
            found[kind] += [f"at {width} px, {scheme}: {text}" for text in seen(shown.page)]
        found["console"] += shown.errors
        found["requests"] += shown.requests


def _without_scripts(browser: Any, path: Path) -> list[str]:
    with opened(browser, path, scripts=False) as shown:
        return charts.empty(shown.page)


def _on_paper(browser: Any, path: Path) -> list[str]:
    with opened(browser, path) as shown:
        found = paper.missing(shown.page)
    with opened(browser, path, paper.PAPER_WIDTH, is_paper=True) as shown:
        return [*found, *screen.outside(shown.page), *screen.broken(shown.page), *charts.words(shown.page)]
