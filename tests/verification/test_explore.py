"""Verification: the page of `tailslap explore`: its cells run in Python, and in a browser where there is playwright."""

import contextlib
import importlib.util
import os
import re
import socket
import statistics
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

import tailslap
from tailslap import cli

SOURCE = Path(tailslap.__file__).parent / "explore.py"
CHROMIUM = Path("/usr/bin/chromium")
BROWSER = importlib.util.find_spec("playwright") is not None and CHROMIUM.exists()
in_a_browser = pytest.mark.skipif(not BROWSER, reason="playwright or Chromium is missing")

CHANGED = "(old) => { const p = document.querySelector('.found p'); return p && p.textContent !== old; }"
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


def test_it_is_served_to_this_machine_under_a_token(monkeypatch, capsys):
    pytest.importorskip("marimo")
    calls = []
    monkeypatch.setattr(os, "execv", lambda *given: calls.append(given))
    assert cli._status(["explore", "none"]) == 2
    assert calls == []
    assert cli._status(["explore", "paper-table-3", "--port", "2000", "--headless"]) == 0
    ((program, words),) = calls
    assert (program, words[1:4]) == (sys.executable, ["-m", "marimo", "run"])
    assert words[words.index("--host") + 1] == "127.0.0.1"
    assert {"--token", "--headless"} <= set(words)
    assert words[-2:] == ["--scene", "paper-table-3"]


@pytest.fixture(scope="module")
def page():
    pytest.importorskip("marimo")
    from tailslap import explore

    return explore


def test_its_cells_show_the_rigid_answer(page, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["explore"])
    outputs, cells = page.app.run()
    expected = tailslap.rigid("mash-tl4-sut")
    assert cells["rigid"].summary == expected.summary
    assert tomllib.loads(cells["saved"].decode()) == cells["tables"]
    shown = "".join(output.text for output in outputs if hasattr(output, "text"))
    assert expected.headline.answer in shown
    assert expected.charts["force"].svg in shown


@pytest.mark.parametrize(("scene", "keys"), [
    ("mash-tl4-sut", "impact.speed impact.angle impact.friction impact.restitution"),
    ("paper-table-3", "start.corner_speed start.angle impact.friction"),
    ("impact-mash-tl4-sut", "impact.speed impact.angle contact.friction contact.restitution contact.stiffness"),
])  # fmt: skip
def test_every_slider_changes_the_answer(page, monkeypatch, scene, keys):
    """Keys of the scene that have no effect beside others have none."""
    monkeypatch.setattr(sys, "argv", ["explore", "--scene", scene])
    _, cells = page.app.run()
    assert set(cells["made"]) == {"vehicle.mass", *keys.split()}
    for key, (element, value, unit) in cells["made"].items():
        other = next(step for step in element.steps if step > value)
        changed: Any = tailslap.rigid(scene, {key: f"{other} {unit}" if unit else other})
        assert changed.history.to_numpy().tolist() != cells["rigid"].history.to_numpy().tolist(), key


@pytest.mark.parametrize(("key", "given", "value", "unit"), [
    ("impact.speed", "56 mph", 56.0, "mph"), ("impact.speed", 25.0, 25.0, "m/s"),
    ("impact.angle", "15 deg", 15.0, "deg"), ("impact.angle", 0.3, 17.188733853924695, "deg"),
    ("vehicle.mass", "80 kg", 80.0, "kg"), ("contact.stiffness", "30 MN/m", 30.0, "MN/m"),
    ("contact.friction", 0.47, 0.47, ""),
])  # fmt: skip
def test_a_slider_has_the_value_and_unit_of_the_scene(page, key, given, value, unit):
    element, start, shown = page.slider(key, given)
    assert (shown, start, element.value) == (unit, pytest.approx(value), pytest.approx(value))
    assert element.start <= value <= element.stop
    assert len(element.steps) >= page.STEPS


@contextlib.contextmanager
def served(scene):
    """Address of the page with its token, as the command prints it."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "tailslap", "explore", scene, "--port", str(port), "--headless"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            assert process.stdout
            lines = iter(process.stdout.readline, "")
            yield next(
                found[0] for line in lines if (found := re.search(r"http://\S+access_token=\S+", line))
            )
        finally:
            process.terminate()
            process.communicate(timeout=30)


@contextlib.contextmanager
def opened(address, width=1280, waits_for=".force svg"):
    """The page in Chromium, with what it asked for elsewhere."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=str(CHROMIUM), args=["--no-sandbox"])
        shown = browser.new_context(viewport={"width": width, "height": 900}).new_page()
        elsewhere = []
        own = ("http://localhost", "ws://localhost", "data:", "blob:")
        shown.on("request", lambda asked: None if asked.url.startswith(own) else elsewhere.append(asked.url))
        shown.goto(address)
        shown.wait_for_selector(waits_for, state="attached", timeout=120_000)
        yield shown
        browser.close()
    assert elsewhere == []


def moved(shown, name, key="ArrowRight"):
    """Move a slider by the keyboard; time to the new curve [ms]."""
    shown.get_by_role("slider", name=name).focus()
    before = shown.locator(".force .wide").inner_html()
    shown.keyboard.press(key)
    return shown.evaluate(TIMED, before)


@in_a_browser
def test_the_page_in_a_browser(tmp_path, capsys):
    """Sliders by the keyboard, at 1280 and 390 px; the scene is saved, and opened again."""
    with served("impact-mash-tl4-sut") as address:
        with opened(address) as shown:
            times = [moved(shown, "Speed") for _ in range(9)]
            with capsys.disabled():
                print(
                    f"\nslider to new curve: median {statistics.median(times):.0f} ms, {max(times):.0f} at most"
                )
            moved(shown, "Crush", "ArrowLeft")
            with shown.expect_download() as saving:
                shown.get_by_text("Save the scene").click()
            path = tmp_path / saving.value.suggested_filename
            saving.value.save_as(path)
            said = shown.locator(".found p").first.text_content()
            assert said == tailslap.rigid(path).headline.answer
        with opened(address, 390) as shown:
            assert shown.evaluate("document.documentElement.scrollWidth") <= 390
            first = shown.locator(".found p").first.text_content()
            assert first == tailslap.rigid("impact-mash-tl4-sut").headline.answer
            shown.locator("input[type=file]").set_input_files(path)
            shown.wait_for_function(CHANGED, arg=first)
            assert shown.locator(".found p").first.text_content() == said
            assert shown.locator(".force .narrow svg").is_visible()
        with opened(address.partition("?")[0], waits_for="input[type=password]") as shown:
            assert shown.locator(".found").count() == 0


@in_a_browser
@pytest.mark.long
def test_the_finite_elements_in_a_browser():
    """Progress, the answer of the run, and its report with a picture."""
    with served("mash-tl4-sut") as address, opened(address) as shown:
        moved(shown, "Friction")
        shown.get_by_role("button", name="Run the finite elements").click()
        report = shown.frame_locator("iframe")
        report.locator("h1").wait_for(timeout=240_000)
        assert report.locator("img").first.evaluate("image => image.naturalWidth") > 0
        said = shown.locator(".found p").all_text_contents()
        assert tailslap.run("mash-tl4-sut", {"impact.friction": 0.48}).headline.answer in said
