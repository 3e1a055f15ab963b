"""Verify the page of `tailslap explore` in Python and in a browser."""

import asyncio
import contextlib
import http.client
import importlib.util
import os
import re
import signal
import socket
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

import tailslap
from tailslap import cli, server

SOURCE = Path(tailslap.__file__).parent / "explore.py"
CHROMIUM = Path("/usr/bin/chromium")
BROWSER = importlib.util.find_spec("playwright") is not None and CHROMIUM.exists()
in_a_browser = pytest.mark.skipif(not BROWSER, reason="playwright or Chromium is missing")

CHANGED = (
    "(old) => { const part = document.querySelector('.found'); return part && part.textContent !== old; }"
)
TIMED = """(old) => new Promise((done) => {
  const start = performance.now(), drawn = () => document.querySelector('.force .wide')?.innerHTML;
  const look = () => drawn() && drawn() !== old ? done(performance.now() - start) : requestAnimationFrame(look);
  look();
})"""


def test_it_is_short_and_without_mechanics():
    text = SOURCE.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 250
    assert not re.search(r"\b(?:import|from) (?:solver|fem|meshes|numpy|scipy)\b", text)


def test_without_marimo_it_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "marimo", None)
    assert cli._status(["explore"]) == 2
    assert "needs marimo; install it with `pip install marimo`" in capsys.readouterr().err


def test_a_wrong_scene_and_a_port_in_use_are_refused(capsys):
    pytest.importorskip("marimo")
    assert cli._status(["explore", "none"]) == 2
    with socket.socket() as occupied:
        occupied.bind((server.HOST, 0))
        occupied.listen()
        assert cli._status(["explore", "--headless", "--port", str(occupied.getsockname()[1])]) == 2
    assert "--port: given" in (message := capsys.readouterr().err)
    assert message.count("tailslap:") == 2


OWN = "127.0.0.1:2718"


@pytest.mark.parametrize(("path", "host", "origin", "is_admitted"), [
    ("/secret/", OWN, None, True), ("/secret/ws", OWN, f"http://{OWN}", True),
    ("/secret/", "evil.example", None, False), ("/secret/", "localhost:2718", None, False),
    ("/secret/", "127.0.0.1", None, False), ("/secret/", None, None, False),
    ("/secret/", OWN, "http://evil.example", False), ("/secret/", OWN, "null", False),
    ("/secret/", OWN, f"http://{OWN}1", False), ("/secret/", OWN, f"https://{OWN}", False),
    ("/", OWN, None, False), ("//", OWN, None, False), ("/secre/", OWN, None, False), ("/secret1/", OWN, None, False),
    ("/sécret/", OWN, None, False), ("/assets/secret/", OWN, None, False),
])  # fmt: skip
@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_a_guard_admits_host_origin_and_secret_of_its_page(kind, path, host, origin, is_admitted):
    reached, sent = [], []

    async def page(scope, receive, send):
        reached.append(scope)

    async def receive():
        raise AssertionError("nothing is received")

    async def send(message):
        sent.append(message)

    header_values = {"host": host, "origin": origin}
    headers = [(name.encode(), value.encode()) for name, value in header_values.items() if value is not None]
    scope = {"type": kind, "path": path, "headers": headers}
    asyncio.run(server.Guard(page, 2718, "secret")(scope, receive, send))
    assert reached == [scope] * is_admitted
    refusal = {"http": ["http.response.start", "http.response.body"], "websocket": ["websocket.close"]}[kind]
    assert [message["type"] for message in sent] == ([] if is_admitted else refusal)
    assert is_admitted or kind == "websocket" or sent[0]["status"] == 403


def test_the_file_for_the_browser_is_private(tmp_path):
    path = server.redirecting_file(tmp_path, "http://127.0.0.1:2718/secret/?scene=a")
    assert path.stat().st_mode & 0o777 == 0o600
    assert 'content="0; url=http://127.0.0.1:2718/secret/?scene=a"' in path.read_text(encoding="utf-8")


KERNEL = """
import sys, tempfile, threading, uvicorn
from scipy.sparse import eye_array, linalg
from tailslap import server

factorised = threading.Event()

def kernel():
    with tempfile.TemporaryDirectory(dir=sys.argv[1]):
        factor = linalg.splu(eye_array(9).tocsc())
        factorised.set()
        threading.Event().wait()

def run(server, sockets):
    threading.Thread(target=kernel, daemon=True).start()
    factorised.wait()

uvicorn.Server.run = run
server.serve("mash-tl4-sut", 0, headless=True)
"""
"""Page that is interrupted while its kernel is within a run."""


def test_an_interrupt_within_a_run_ends_it_without_messages(tmp_path):
    pytest.importorskip("marimo")
    command = [sys.executable, "-c", KERNEL, str(tmp_path)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert len(ended.stdout.splitlines()) == 1, "the address alone"
    assert not list(tmp_path.iterdir()), "temporary files are removed"


def answer(address, **headers):
    """Status of a request with these headers."""
    where = urlsplit(address)
    with contextlib.closing(http.client.HTTPConnection(where.netloc, timeout=30)) as connection:
        connection.request("GET", f"{where.path}?{where.query}", headers=headers)
        return connection.getresponse().status


def can_open(address, origin, host=None):
    """True if a websocket is accepted."""
    client, where = pytest.importorskip("websockets.sync.client"), urlsplit(address)
    place = where._replace(
        scheme="ws", netloc=host or where.netloc, path=f"{where.path}ws", query="session_id=s_abcdef"
    )
    with socket.create_connection((where.hostname, where.port)) as plain:
        try:
            with client.connect(place.geturl(), origin=origin, sock=plain) as opened:
                return bool(opened.recv(timeout=60))
        except client.InvalidStatus as refused:
            return refused.response.status_code != 403


@pytest.mark.long
def test_it_answers_its_own_page_alone():
    """Requests and websockets of other hosts and origins are refused."""
    with served("mash-tl4-sut") as address:
        where = urlsplit(address)
        page_origin, foreign = f"http://{where.netloc}", "http://evil.example"
        assert where.hostname == "127.0.0.1"
        assert answer(address) == answer(address, Origin=page_origin) == 200
        for host in ("evil.example", f"evil.example:{where.port}", f"localhost:{where.port}", "127.0.0.1"):
            assert answer(address, Host=host) == 403, host
        for origin in (foreign, "null", f"{page_origin}1", f"http://localhost:{where.port}"):
            assert answer(address, Origin=origin) == 403, origin
        other = where._replace(path="/" + "A" * len(where.path[1:-1]) + "/").geturl()
        for without in (
            where._replace(path="/").geturl(),
            other,
            f"{page_origin}/assets/",
            f"{page_origin}//",
        ):
            assert answer(without) == 403, without
            assert not can_open(without, page_origin)
        assert can_open(address, page_origin)
        assert not can_open(address, foreign)
        assert not can_open(address, page_origin, "evil.example")


@pytest.mark.long
def test_the_browser_is_opened_by_a_private_file(tmp_path):
    """No process has the address as an argument."""
    browser, seen = tmp_path / "browser", tmp_path / "seen"
    browser.write_text(BROWSER_SCRIPT.format(seen), encoding="utf-8")
    browser.chmod(0o700)
    with served("mash-tl4-sut", BROWSER=f"{browser} %s &", TMPDIR=str(tmp_path)) as address:
        while not seen.exists():
            time.sleep(0.05)
        mode, path = seen.read_text().splitlines()[0].split(" ", 1)
        assert (mode, Path(path).parent.stat().st_mode & 0o777) == ("600", 0o700)
        assert f"url={address}" in seen.read_text()
        lines = [read_or_empty(process / "cmdline") for process in Path("/proc").glob("[0-9]*")]
        assert any(str(browser).encode() in line and path.encode() in line for line in lines)
        assert not any(urlsplit(address).path.strip("/").encode() in line for line in lines)
    assert not Path(path).parent.exists()


def read_or_empty(path):
    try:
        return path.read_bytes()
    except OSError:  # the process has ended
        return b""


@pytest.fixture(scope="module")
def page():
    pytest.importorskip("marimo")
    from tailslap import explore

    return explore


def test_its_cells_show_the_rigid_answer(page, monkeypatch):
    monkeypatch.setattr(page.mo, "query_params", dict)
    outputs, cells = page.app.run()
    expected = tailslap.rigid("mash-tl4-sut", band=False)
    assert cells["rigid"].summary == expected.summary
    assert cells["banded"] == tailslap.rigid("mash-tl4-sut").headline
    assert tomllib.loads(cells["saved"].decode()) == cells["tables"]
    html = "".join(output.text for output in outputs if hasattr(output, "text"))
    assert expected.headline.answer in html
    assert expected.charts["force"].svg in html


@pytest.mark.parametrize(("scene", "keys"), [
    ("mash-tl4-sut", "impact.speed impact.angle impact.friction impact.restitution"),
    ("paper-table-3", "start.corner_speed start.angle impact.friction"),
    ("impact-mash-tl4-sut", "impact.speed impact.angle contact.friction contact.restitution contact.stiffness"),
])  # fmt: skip
def test_every_slider_changes_the_answer(page, monkeypatch, scene, keys):
    """Keys of the scene that have no effect beside others have none."""
    monkeypatch.setattr(page.mo, "query_params", lambda: {"scene": scene})
    _, cells = page.app.run()
    assert set(cells["elements"]) == {"vehicle.mass", *keys.split()}
    for key, (element, value, unit) in cells["elements"].items():
        other = next(step for step in element.steps if step > value)
        changed: Any = tailslap.rigid(scene, {key: f"{other} {unit}" if unit else other})
        assert changed.history.to_numpy().tolist() != cells["rigid"].history.to_numpy().tolist(), key


@pytest.mark.parametrize(("key", "text", "value", "unit"), [
    ("impact.speed", "56 mph", 56.0, "mph"), ("impact.speed", 25.0, 25.0, "m/s"),
    ("impact.angle", "15 deg", 15.0, "deg"), ("impact.angle", 0.3, 17.188733853924695, "deg"),
    ("vehicle.mass", "80 kg", 80.0, "kg"), ("contact.stiffness", "30 MN/m", 30.0, "MN/m"),
    ("contact.friction", 0.47, 0.47, ""),
])  # fmt: skip
def test_a_slider_has_the_value_and_unit_of_the_scene(page, key, text, value, unit):
    element, start, slider_unit = page.slider(key, text)
    assert (slider_unit, start, element.value) == (unit, pytest.approx(value), pytest.approx(value))
    assert element.start <= value <= element.stop
    assert len(element.steps) >= page.STEPS


BROWSER_SCRIPT = """#!/bin/sh
file="${{1#file://}}"
exec > {0}.new 2>&1
stat -c "%a %n" "$file"
cat "$file"
mv {0}.new {0}
while [ -e "$file" ]; do sleep 0.1; done
"""


@contextlib.contextmanager
def served(scene, **settings):
    """Address of the page, as printed by the command.

    settings: variables of the environment, with a browser.
    """
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [
        sys.executable, "-m", "tailslap", "explore", scene, "--port", str(port),
        *["--headless"] * (not settings),
    ]  # fmt: skip
    streams: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with subprocess.Popen(command, **streams, env=os.environ | settings) as process:
        try:
            assert process.stdout
            address = re.search(r"http://\S+", process.stdout.readline())
            assert address
            yield address[0]
        finally:
            process.send_signal(signal.SIGINT)
            assert process.communicate(timeout=60)[0].strip() == ""
    assert process.returncode == 0


@contextlib.contextmanager
def opened(address, width=1280, waits_for=".force svg"):
    """Open the page in Chromium, with its requests to other addresses."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=str(CHROMIUM), args=["--no-sandbox"])
        tab = browser.new_context(viewport={"width": width, "height": 900}).new_page()
        elsewhere = []
        local = ("http://127.0.0.1", "ws://127.0.0.1", "data:", "blob:")
        tab.on("request", lambda sent: None if sent.url.startswith(local) else elsewhere.append(sent.url))
        tab.goto(address)
        tab.wait_for_selector(waits_for, state="attached", timeout=120_000)
        yield tab
        browser.close()
    assert elsewhere == []


def moved(tab, name, key="ArrowRight"):
    """Change a slider, and wait for the curve."""
    tab.get_by_role("slider", name=name).focus()
    before = tab.locator(".force .wide").inner_html()
    tab.keyboard.press(key)
    tab.evaluate(TIMED, before)


@in_a_browser
def test_the_page_in_a_browser(tmp_path):
    """Sliders react at two widths, and a saved scene is opened."""
    with served("impact-mash-tl4-sut") as address:
        with opened(address) as tab:
            moved(tab, "Speed")
            moved(tab, "Crush", "ArrowLeft")
            tab.locator(".found", has_text="1.9 MN/m").wait_for()
            with tab.expect_download() as saving:
                tab.get_by_text("Save the scene").click()
            path = tmp_path / saving.value.suggested_filename
            saving.value.save_as(path)
            answer, _, set_up, *_ = tab.locator(".found p").all_text_contents()
            headline = tailslap.rigid(path, band=False).headline
            assert (answer, set_up) == (headline.answer, headline.set_up)
        with opened(address, 390) as tab:
            assert tab.evaluate("document.documentElement.scrollWidth") <= 390
            headline = tailslap.rigid("impact-mash-tl4-sut", band=False).headline
            assert tab.locator(".found p").first.text_content() == headline.answer
            before = tab.locator(".found").first.text_content()
            tab.locator("input[type=file]").set_input_files(path)
            tab.wait_for_function(CHANGED, arg=before)
            assert tab.locator(".found p").all_text_contents()[2] == set_up
            assert tab.locator(".force .narrow svg").is_visible()


@in_a_browser
@pytest.mark.long
def test_the_finite_elements_in_a_browser():
    """Progress, the answer of the run, and its report with a picture."""
    with served("mash-tl4-sut") as address, opened(address) as tab:
        moved(tab, "Friction")
        tab.get_by_role("button", name="Run the finite elements").click()
        report = tab.frame_locator("iframe")
        report.locator("h1").wait_for(timeout=240_000)
        assert report.locator("img").first.evaluate("image => image.naturalWidth") > 0
        texts = tab.locator(".found p").all_text_contents()
        assert tailslap.run("mash-tl4-sut", {"impact.friction": 0.48}).headline.answer in texts
