"""Chromium, and a page in it."""

from __future__ import annotations

import functools
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
    address = place if isinstance(place, str) else place.resolve().as_uri()
    if not scripts:
        options["java_script_enabled"] = False
    with _tab(browser, options) as tab, _listening(session := Opened(tab), address):
        tab.set_viewport_size({"width": width, "height": 900})
        media = "print" if is_paper else "null"  # that of the window, or of a PDF
        motion = options.get("reduced_motion", "no-preference")
        tab.emulate_media(media=media, color_scheme=scheme, reduced_motion=motion)
        tab.goto(address)
        tab.evaluate("() => document.querySelectorAll('details').forEach((part) => (part.open = true))")
        if scripts:
            tab.evaluate("typeof prepareAll === 'undefined' || prepareAll()")
        yield session


@contextmanager
def _tab(browser: Any, options: dict[str, Any]) -> Iterator[Any]:
    """A tab without content.

    Without options it is one for all pages of the browser, since a new one takes longer than most pages.
    """
    if options:
        context = browser.new_context(**options)
        try:
            yield context.new_page()
        finally:
            context.close()
        return
    tab = _first_tab(browser)
    tab.goto("about:blank")
    tab.mouse.move(0, 0)
    yield tab
    tab.goto("about:blank")


@functools.lru_cache(maxsize=1)
def _first_tab(browser: Any) -> Any:
    return browser.new_context().new_page()


@contextmanager
def _listening(session: Opened, address: str) -> Iterator[None]:
    """Note errors of a page, and requests to other addresses."""
    own = "/".join(address.split("/")[:3]) if address.startswith("http") else address.partition("#")[0]

    def message(entry: Any) -> None:
        if entry.type in ("error", "warning"):
            session.errors.append(entry.text)

    def request(sent: Any) -> None:
        if not sent.url.startswith((own, "data:")):
            session.requests.append(sent.url)

    def failure(error: Any) -> None:
        session.errors.append(str(error))

    listeners = {"console": message, "pageerror": failure, "request": request}
    for event, listener in listeners.items():
        session.page.on(event, listener)
    yield
    for event, listener in listeners.items():
        session.page.remove_listener(event, listener)
