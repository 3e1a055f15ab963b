"""Chromium, and a page in it."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

CHROMIUM = Path("/usr/bin/chromium")
NEEDED = ("playwright", "axe_playwright_python", "pypdf")
MISSING = [name for name in NEEDED if importlib.util.find_spec(name) is None]
MISSING += [] if CHROMIUM.exists() else [str(CHROMIUM)]
"""Programs and packages that are not installed."""

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
    place: Path | str,
    width: int = 1280,
    scheme: str = "light",
    scripts: bool = True,
    is_paper: bool = False,
    **options: Any,
) -> Iterator[Opened]:
    """Open a page with all folded parts.

    place: of its file, or its address; width: in pixels; is_paper: in the layout of paper; options: of Playwright.
    """
    view = {"width": width, "height": 900}
    options |= {"viewport": view, "color_scheme": scheme, "java_script_enabled": scripts}
    context = browser.new_context(**options)
    try:
        session = Opened(context.new_page())
        address = place if isinstance(place, str) else place.resolve().as_uri()
        _listen(session, address)
        if is_paper:
            session.page.emulate_media(media="print")
        session.page.goto(address)
        session.page.evaluate(
            "() => document.querySelectorAll('details').forEach((part) => (part.open = true))"
        )
        if scripts:
            session.page.evaluate("typeof prepareAll === 'undefined' || prepareAll()")
        yield session
    finally:
        context.close()


def _listen(session: Opened, address: str) -> None:
    """Note errors, and requests to other addresses."""
    own = "/".join(address.split("/")[:3]) if address.startswith("http") else address.partition("#")[0]

    def message(entry: Any) -> None:
        if entry.type in ("error", "warning"):
            session.errors.append(entry.text)

    def request(sent: Any) -> None:
        if not sent.url.startswith((own, "data:")):
            session.requests.append(sent.url)

    session.page.on("console", message)
    session.page.on("pageerror", lambda error: session.errors.append(str(error)))
    session.page.on("request", request)
