"""Inspection of a page on screens and on paper."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from . import charts, paper, screen
from .session import opened

WIDTHS, SCHEMES = (1280, 768, 390), ("light", "dark")
LARGEST_MB = 3.0


def faults(browser: Any, path: Path, widths: Sequence[int] = WIDTHS) -> dict[str, list[str]]:
    """Return the faults of a page by kind.

    widths: of screens [pixels], besides paper.
    """
    size = path.stat().st_size / 1e6
    by_kind: dict[str, list[str]] = {
        "no scripts": _without_scripts(browser, path),
        "paper": _on_paper(browser, path),
        "MB": [f"{size:.1f} MB, over {LARGEST_MB:g}"] if size > LARGEST_MB else [],
    }
    for width in widths:
        for scheme in SCHEMES:
            for kind, texts in _on_screen(browser, path, width, scheme).items():
                by_kind.setdefault(kind, []).extend(f"at {width} px, {scheme}: {text}" for text in texts)
    return {kind: texts for kind, texts in by_kind.items() if texts}


def _on_screen(browser: Any, path: Path, width: int, scheme: str) -> dict[str, list[str]]:
    checks: dict[str, Callable[[Any], list[str]]] = {"axe": screen.violations}
    if scheme == "light":
        checks |= {"sideways": screen.outside, "broken": screen.broken, "words": charts.words}
    with opened(browser, path, width, scheme) as page:
        texts = {kind: check(page.page) for kind, check in checks.items()}
        return texts | {"console": page.errors, "requests": page.requests}


def _without_scripts(browser: Any, path: Path) -> list[str]:
    with opened(browser, path, scripts=False) as page:
        return charts.empty(page.page)


def _on_paper(browser: Any, path: Path) -> list[str]:
    with opened(browser, path) as page:
        missing = paper.missing(page.page)
    with opened(browser, path, paper.PAPER_WIDTH, is_paper=True) as page:
        return [*missing, *screen.outside(page.page), *screen.broken(page.page), *charts.words(page.page)]
