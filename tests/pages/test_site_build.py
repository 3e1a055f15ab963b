"""Verify the build of the site, and its pages in Chromium."""

import functools
import http.server
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from browser import screen
from browser.session import opened

import tailslap

ROOT = Path(__file__).parents[2]

PAGES = ("", "gallery/", "theory/rigid/", "modal/", "reference/scene/", "howto/python/", "accuracy/")
GROUNDS = {"light": "rgb(255, 255, 255)", "dark": "rgb(30, 33, 41)"}


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves a folder without a word."""

    def log_message(self, *_):
        """Log nothing."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of the site, built without network and without a warning."""
    place = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(place)]
    nowhere = dict.fromkeys(("http_proxy", "https_proxy"), "http://127.0.0.1:9")
    environment = {"PATH": "/usr/bin:/bin"} | nowhere
    process = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=environment)
    assert process.returncode == 0, process.stdout + process.stderr
    return place


@pytest.fixture(scope="module")
def site(folder):
    """Address of the site."""
    handler = functools.partial(Quiet, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def test_the_site_has_its_pages_pictures_and_no_foreign_link(folder):
    assert (folder / "reference" / "scene" / "index.html").is_file()
    assert not (folder / "generate.py").exists()
    texts = {page.parent.name: page.read_text(encoding="utf-8") for page in folder.rglob("*.html")}
    link = r'<(?:script|link|img)[^>]+(?:src|href)="(?:https?:)?//'
    assert [name for name, text in texts.items() if re.search(link, text)] == []
    assert not re.search(r"@import|url\((?:https?:)?//", (folder / "style.css").read_text(encoding="utf-8"))
    assert all(f"tailslap {tailslap.__version__}" in text for text in texts.values())
    demand_equations(texts)
    scripts = {path.stem for path in (ROOT / "docs" / "gallery").glob("*.py")}
    pictures = re.findall(r'<img alt="[^"]{10,}" src="(\w+)\.(?:png|svg)"', texts["gallery"])
    assert set(pictures) == {path.stem for path in (folder / "gallery").glob("*.[ps][nv]g")} == scripts
    assert len(pictures) == texts["gallery"].count('class="language-python highlight"') == 12


EQUATIONS = {"rigid", "plate", "inertia-relief", "flutter", "contact", "modal", "tipping", "parapet"}


def demand_equations(texts):
    """Equations are MathML without unknown or remaining TeX."""
    counts = {name: len(re.findall("<math ", text)) for name, text in texts.items() if "<math " in text}
    assert counts.keys() == EQUATIONS
    assert min(counts.values()) > 5
    for text in texts.values():
        assert not re.search(r"arithmatex|\$\$|<m[a-z]+>(?:\\|&(?!#x|[a-z]+;))", text)


def look(browser, address, width, scheme):
    with opened(browser, address, width, scheme) as session:
        page = session.page
        page.wait_for_timeout(300)
        assert screen.violations(page) == []
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == GROUNDS[scheme]
        assert (session.errors, session.requests) == ([], [])


def test_a_page_is_accessible(browser, site):
    look(browser, f"{site}theory/flutter/", 390, "dark")


@pytest.mark.long
@pytest.mark.parametrize("name", PAGES)
@pytest.mark.parametrize("width", [1280, 768, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_are_accessible(browser, site, name, width, scheme):
    look(browser, site + name, width, scheme)


def test_equations_are_drawn_without_a_script(browser, site):
    with opened(browser, f"{site}theory/rigid/", scripts=False) as session:
        boxes = [equation.bounding_box() for equation in session.page.locator("math").all()]
    assert len(boxes) > 20
    assert min(min(box["width"], box["height"]) for box in boxes) > 4


def test_the_search_finds_and_code_can_be_copied(browser, site):
    with opened(browser, f"{site}howto/python/") as session:
        page = session.page
        search = page.get_by_placeholder("Search")
        search.click()
        page.get_by_text("Type to start searching").wait_for(state="attached")  # the index is there
        search.press_sequentially("restitution")
        page.wait_for_selector(".md-search-result__item a")
        assert page.locator(".md-search-result__item").count() > 2
        assert page.locator("button.md-code__button, button.md-clipboard").count() >= 5
