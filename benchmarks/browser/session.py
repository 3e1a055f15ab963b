"""Chromium, and a page in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

CHROMIUM = Path("/usr/bin/chromium")
FLAGS = ("--no-sandbox", "--disable-gpu", "--hide-scrollbars")


@dataclass(frozen=True)
class Opened:
    """Opened page, errors on its console, and its requests to other addresses."""

    page: Any
    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=str(CHROMIUM), args=list(FLAGS))
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def opened(
    browser: Any,
    path: Path,
    width: int = 1280,
    scheme: str = "light",
    scripts: bool = True,
    is_paper: bool = False,
) -> Iterator[Opened]:
    """Open a page with all folded parts; width in pixels, is_paper: in the layout of paper."""
    view = {"width": width, "height": 900}
    context = browser.new_context(viewport=view, color_scheme=scheme, java_script_enabled=scripts)
    try:
        found = Opened(context.new_page())
        address = path.resolve().as_uri()
        _listen(found, address)
        if is_paper:
            found.page.emulate_media(media="print")
        found.page.goto(address)
        found.page.evaluate(
            "() => document.querySelectorAll('details').forEach((part) => (part.open = true))"
        )
        yield found
    finally:
        context.close()


def _listen(found: Opened, address: str) -> None:
    def message(said: Any) -> None:
        if said.type in ("error", "warning"):
            found.errors.append(said.text)

    def request(asked: Any) -> None:
        if asked.url != address and not asked.url.startswith("data:"):
            found.requests.append(asked.url)

    found.page.on("console", message)
    found.page.on("pageerror", lambda error: found.errors.append(str(error)))
    found.page.on("request", request)
