"""Verify the page of `tailslap explore`."""

import contextlib
import gzip
import itertools
import json
import re
import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click
import numpy as np
import pytest
from browser import screen, session
from shared_cases import case

from machine_code import web_assembly
from postprocess.signals.filters import LABELS, LOW_PASSES
from postprocess.units import MPH, SYSTEMS
from tailslap import cli
from tailslap.browser import packaged, page
from tailslap.case.corner.corner_run import attempt
from tailslap.case.of_arguments import case_of_scene
from tailslap.errors import InputError
from tailslap.scene.read import scene_text
from tailslap.validation.calibration import calibrated_band

TRUCK, TRAIN, TIPPING = "impact-mash-tl4-sut", "impact-mash-tl5-tractor-van", "impact-tipping-tl4-sut"
PLATE, WALL = "paper-table-3", "elastic-wall"


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    """Scene with a deformable wall, which the page cannot do."""
    path = tmp_path_factory.mktemp("scene") / f"{WALL}.toml"
    sizes = 'length = "30 m"\ndepth = "0.5 m"\nheight = "1 m"\nelements = [60, 2]'
    table = f'[wall]\n{sizes}\nfoundation_stiffness = "2 MN/m^2"\n'
    path.write_text(scene_text(TRUCK).replace(f'"{TRUCK}"', f'"{WALL}"') + table, encoding="utf-8")
    return str(path)


@pytest.fixture(scope="module")
def text(wall):
    return page.page_of([TRUCK, TRAIN, TIPPING, "impact-en-tb11", wall, PLATE])


@pytest.fixture(scope="module")
def file(text, tmp_path_factory):
    path = tmp_path_factory.mktemp("explore") / "explore.html"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_command_writes_and_opens_one_file(tmp_path, monkeypatch, capsys, text):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(page, "page_of", lambda names: f"{text}{next(iter(names))}")
    monkeypatch.setattr(packaged, "PATH", tmp_path / "none.html")
    launched = list[str]()
    monkeypatch.setattr(click, "launch", launched.append)
    assert cli._status(["explore"]) == 0
    assert launched == [(tmp_path / "explore.html").as_uri()]
    assert cli._status(["explore", TRAIN, "--headless", "--json"]) == 0
    assert '"scene": "impact-mash-tl5-tractor-van"' in capsys.readouterr().out
    assert Path("explore.html").read_text(encoding="utf-8").endswith(TRAIN)
    assert len(launched) == 1
    Path("notes.html").write_text("mine")
    assert cli._status(["explore", "--headless", "--out", "notes.html"]) == 2
    assert "notes.html" in capsys.readouterr().err
    assert Path("notes.html").read_text() == "mine"


def test_the_page_of_an_installation_is_taken_if_it_is_of_its_sources(tmp_path, monkeypatch, capsys):
    """One of other sources is made again, and said to be."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(packaged, "PATH", tmp_path / "packaged.html")
    numbers = itertools.count(1)
    monkeypatch.setattr(page, "page_of", lambda names: f"{page.MARK} page {next(numbers)}")
    page.make_packaged()
    page.make_packaged()
    assert cli._status(["explore", "--headless"]) == 0
    assert Path("explore.html").read_text().startswith(f"{page.MARK} page 1")
    (tmp_path / "packaged.html").write_text("<!-- sources 0 -->\n")
    assert cli._status(["explore", "--headless"]) == 0
    assert page.STALE in capsys.readouterr().err
    assert Path("explore.html").read_text() == f"{page.MARK} page 2"


@pytest.mark.parametrize("is_current", [True, False])
def test_a_wheel_has_the_page_of_its_sources(is_current, monkeypatch):
    """Without it the build says so, and an editable one has none."""
    interface = "hatchling.builders.hooks.plugin.interface"
    base = type(
        "BuildHookInterface", (), {"__class_getitem__": classmethod(lambda cls, item: cls), "root": "."}
    )
    monkeypatch.setitem(sys.modules, interface, SimpleNamespace(BuildHookInterface=base))
    hook = runpy.run_path(str(Path(__file__).parents[2] / "hatch_build.py"))["PageHook"]()
    warnings, data = list[str](), {"artifacts": list[str]()}
    hook.app = SimpleNamespace(display_warning=warnings.append)
    monkeypatch.setattr(runpy, "run_path", lambda path: {"is_current": lambda: is_current})
    monkeypatch.setattr(subprocess, "run", lambda command, **options: None)
    hook.initialize("editable", data)
    assert not data["artifacts"]
    hook.initialize("standard", data)
    assert (len(data["artifacts"]), len(warnings)) == ((1, 0) if is_current else (0, 1))


@pytest.mark.parametrize(("scene", "words"), [
    ("none", "none"), ("", f"`tailslap run {WALL}`"),
])  # fmt: skip
def test_scenes_beyond_the_page_are_refused(scene, words, wall, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli._status(["explore", scene or wall, "--headless"]) == 2
    assert words in " ".join(capsys.readouterr().err.split())
    assert not list(tmp_path.iterdir())


@pytest.mark.long
def test_all_scenes_are_within_the_size():
    """It is that of a mail."""
    whole = page.page_of(page.all_scenes(TRUCK)).encode()
    assert len(whole) < 600_000
    assert len(gzip.compress(whole)) < 200_000
    assert not re.findall(
        rb"(?:src|href)=|https?://(?!www.w3.org)", re.sub(rb"<script type.*?</script>", b"", whole)
    )


@pytest.fixture
def opened(browser, file):
    """Open the page until its band or refusal is there."""
    with contextlib.ExitStack() as stack:

        def open_page(address: str = "", path: Path = file, **options: Any) -> Any:
            opening = session.opened(browser, f"{path.as_uri()}{address}", **options)
            opened = stack.enter_context(opening)
            opened.page.errors, opened.page.requests = opened.errors, opened.requests
            settled(opened.page)
            return opened.page

        yield open_page


def settled(tab: Any) -> str:
    """Return the answer with its band, or the refusal."""
    tab.wait_for_function("() => /%|no |not /.test(document.getElementById('headline').innerText)")
    return str(tab.inner_text("#headline"))


def demand(tab: Any, expected: str) -> None:
    """Wait until the headline is this one."""
    tab.wait_for_function(f"() => document.getElementById('headline').innerText === {json.dumps(expected)}")


def texts(scene: str, changes: Any = None, units: str = "si") -> tuple[str, str]:
    """Return the answer of `tailslap rigid`, and the origin of its band."""
    case = case_of_scene(scene, changes)
    band = calibrated_band(case)
    return case.headline(band).in_units(SYSTEMS[units]).answer, SYSTEMS[units].rendered(band.sentence)


def answer(scene: str, changes: Any = None, units: str = "si") -> str:
    """Return the answer of `tailslap rigid`."""
    return texts(scene, changes, units)[0]


@pytest.mark.parametrize(("scene", "changes", "units"), [
    (TRUCK, {}, "si"), (TRAIN, {}, "us"),
    (TRUCK, {"impact.speed": 30.0, "contact.friction": 0.6, "impact.restitution": 0.4}, "us"),
])  # fmt: skip
def test_a_link_has_the_answer_of_the_command(opened, scene, changes, units):
    """No request is made but for the file."""
    of_page = {"impact.speed": f"{changes['impact.speed'] / MPH:.17g} mph"} if changes else {}
    address = "&".join(
        [f"#scene={scene}", *(f"{key}={value}" for key, value in changes.items()), f"units={units}"]
    )
    tab = opened(address)
    assert (settled(tab), tab.inner_text("#band")) == texts(scene, changes | of_page, units)
    assert tab.errors == []
    assert tab.requests == []


def test_one_choice_sets_vehicle_speed_angle_and_mass(opened):
    """Scenes stand in groups, with the test level."""
    tab = opened()
    assert [group.get_attribute("label") for group in tab.query_selector_all("#scene optgroup")] == [
        "MASH", "Other impacts", "EN 1317-2, not confirmed", "By the command"
    ]  # fmt: skip
    tab.select_option("#scene", label="TB11, N2: 900 kg vehicle at 100 km/h, 20 deg")
    shown = {
        key: tab.input_value(f'[data-key="{key}"] input[type=number]')
        for key in ("vehicle.mass", "impact.speed", "impact.angle")
    }
    assert shown == {"vehicle.mass": "900", "impact.speed": "100", "impact.angle": "20"}
    tab.select_option("#scene", label=WALL)
    assert f"`tailslap run {WALL}`" in tab.inner_text("#note")


def test_a_box_changes_answer_address_and_scene(opened, tmp_path):
    """The copied scene is that of the command."""
    tab = opened()
    tab.fill('[data-key="impact.angle"] input[type=number]', "20")
    tab.wait_for_function("() => location.hash.includes('impact.angle=0.349')")
    changed = answer(TRUCK, {"impact.angle": "20 deg"})
    demand(tab, changed)
    (tmp_path / "copied.toml").write_text(tab.evaluate("tomlOf()"), encoding="utf-8")
    assert 'angle = "20 deg"' in (tmp_path / "copied.toml").read_text()
    assert answer(str(tmp_path / "copied.toml")) == changed
    tab.click("#reset")
    demand(tab, answer(TRUCK))
    tab.focus('[data-key="impact.speed"] input[type=range]')
    tab.keyboard.press("ArrowRight")
    tab.wait_for_function("() => location.hash.includes('impact.speed=')")


def test_a_filter_is_chosen_and_stands_in_the_address(opened):
    """Peaks are those of `tailslap rigid`."""
    tab = opened()
    peaks = case(TRUCK).answer.peaks
    for (name, label), row in zip(LABELS.items(), tab.query_selector_all("#peaks tbody tr"), strict=True):
        assert row.inner_text().split("\t") == [label, f"{peaks[name] / 1e3:.0f}"]
    for name in LOW_PASSES:
        tab.select_option("#filter", label=LABELS[name])
        assert f"filter={name}" in tab.evaluate("location.hash")
        assert LABELS[name] in tab.inner_text("#keys")
    drawn = tab.inner_html("#force")
    assert opened(tab.evaluate("location.hash")).inner_html("#force") == drawn


REFUSED = {
    TRUCK: {"vehicle.length": "-3 m", "impact.angle": "95 deg", "contact.restitution": 0.8,
            "contact.plateau_force": 0.0, "axle.1.position": "11 m"},
    TIPPING: {"axle.0.mass": "9500 kg", "body.centre_height": "0.4 m", "body.roll_inertia": "100 kg m^2",
              "axle.1.position": "11 m", "contact.restitution": 0.8, "wall.height": "0.01 m"},
}  # fmt: skip


@pytest.mark.parametrize("scene", REFUSED)
def test_a_box_refuses_in_the_words_of_the_command(opened, scene):
    """The rest of the page stays, and the next value is taken."""
    tab = opened(f"#scene={scene}")
    before = tab.inner_text("#headline")
    for key, value in REFUSED[scene].items():
        number = f'[data-key="{key}"] input[type=number]'
        old = tab.input_value(number)
        tab.fill(number, str(value).split()[0])
        tab.wait_for_selector("#headline.refused", state="attached")
        with pytest.raises(InputError) as refused:
            answer(scene, {key: value})
        said = tab.text_content("#headline")
        assert refused.value.key in said
        assert said.partition("allowed: ")[2][: 38 if scene == TRUCK else 16] in str(refused.value)
        if refused.value.key == key:
            assert tab.inner_text(f'[data-key="{key}"] .error') in said
        tab.fill(number, old)
        tab.wait_for_selector("#headline:not(.refused)")
    if scene == TRUCK:  # in space the answer is refined later
        demand(tab, before)


def test_memory_grows_for_more_rows(opened):
    """A second opening begins with the memory of the scene."""
    tab = opened()
    expected = settled(tab)
    tab.evaluate("""() => {
      const rows = machine.scene.arrays["motion.outcome.rows"];
      rows[2][1] = 300;
      new BigInt64Array(machine.memory.buffer, rows[3] - 8, 3)[2] = 300n;
      compute();
    }""")
    assert tab.evaluate("machine.scene.arrays['motion.outcome.rows'][2][1]") > 1000
    demand(tab, expected)
    tab.evaluate("open(0)")
    demand(tab, expected)


def test_an_address_with_unknown_keys_is_named(opened):
    tab = opened(f"#scene={WALL}&impact.speed=x&wall.height=2")
    assert settled(tab) == answer(TRUCK)
    note = tab.inner_text("#note")
    assert f"`tailslap run {WALL}`" in note
    assert "impact.speed=x, wall.height=2" in note


def test_a_browser_without_its_parts_and_another_module_are_named(
    browser, file, opened, tmp_path, monkeypatch
):
    for part, words in ("WebAssembly", "no WebAssembly"), ("DecompressionStream", "cannot unpack"):
        context = browser.new_context()
        context.add_init_script(f"delete window.{part}")
        tab = context.new_page()
        tab.goto(file.as_uri())
        assert words in tab.inner_text(".refused")
    other, module = tmp_path / "other.html", web_assembly.module
    monkeypatch.setattr(web_assembly, "module", lambda calls: module(calls)[:-8] + b"00000000")
    other.write_text(page.page_of([TRUCK]), encoding="utf-8")
    assert "not that of its kernels" in settled(opened(path=other))


def test_a_plate_runs_by_its_button(opened):
    """Its speed is that of the command, beside the exact one."""
    tab = opened("#units=us")
    assert f"tailslap run {PLATE}" in tab.inner_text("#plate")
    tab.focus("#run-plate")
    tab.keyboard.press("Enter")
    tab.wait_for_selector("#plate[data-spent]")
    case: Any = case_of_scene(PLATE, None)
    fe = attempt(case).fe["v_gy"]
    factor, unit = SYSTEMS["us"].of("m/s")
    speeds = [f"−{-factor * speed:#.5g} {unit}" for speed in (fe, case.tail_slap["v_gy"])]
    answer = "v_GY at the tail-slap: {} by finite elements, {} exact".format(*speeds)
    assert tab.inner_text("#plate-answer").startswith(answer)
    assert f"{fe / case.tail_slap['v_gy'] - 1.0:+.1e}".replace("-", "−") in tab.inner_text("#plate-table")
    assert tab.query_selector_all("#plate-chart circle")
    assert tab.errors == []


@pytest.mark.parametrize(("width", "scheme"), [(390, "dark"), (1280, "light")])
def test_screens(opened, width, scheme):
    """No fault by axe, and nothing beyond the window."""
    tab = opened(f"#scene={TIPPING}", width=width, scheme=scheme)
    tab.wait_for_function("() => document.body.dataset.walls")
    tab.click("#run-plate")
    tab.wait_for_selector("#plate[data-spent]")
    assert " m/s by finite elements" in tab.inner_text("#plate-answer")
    for is_space in (True, False):
        assert tab.is_visible("#space") == is_space
        assert screen.violations(tab) == []
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        tab.evaluate("scrollTo(0, 0), open(0)")
        settled(tab)


def test_a_truck_in_space_has_outcome_band_walls_and_views(opened):
    """Answer and stated error are those of the command.

    The views begin at the largest roll; the keyboard moves them.
    """
    tab = opened(f"#scene={TIPPING}")
    tab.wait_for_function("() => document.body.dataset.walls")
    motion = case(TIPPING).space.motion
    one, said = motion.answers, tab.inner_text("#headline")
    assert (
        f"remains upright on a wall of 0.914 m with a roll of {np.degrees(one.largest_roll):.1f} deg" in said
    )
    assert f"This scene: {one.mean_50ms / 1e3:.0f} kN, at a height of {one.height:.3f} m" in said
    assert case(TIPPING).space.accuracy in tab.inner_text("#certainty")
    numbers = tab.evaluate("[...machine.array('space_one.motions.result')].slice(2, 5)")
    assert numbers == pytest.approx([motion.step_error, motion.strip_error, motion.other_error], rel=1e-6)
    assert "70 upright, 2 on its side" in tab.inner_text("#band")
    assert "0.638 m" in tab.inner_text("#lowest")
    assert tab.locator("#strikes tbody tr").count() == 11
    assert tab.get_attribute("#rear", "data-roll") == f"{np.degrees(one.largest_roll):.2f}"
    tab.focus("#time")
    tab.keyboard.press("Home")
    assert tab.get_attribute("#rear", "data-roll") == "0.00"
    tab.press("#play", "Enter")
    tab.wait_for_function("() => Number(document.getElementById('rear').dataset.roll) > 1")
    tab.press("#play", "Enter")
    assert tab.inner_text("#play").startswith("Play")
    assert tab.errors == []
    assert tab.requests == []


def test_without_motion_a_button_shows_the_next_picture(opened):
    tab = opened(f"#scene={TIPPING}", reduced_motion="reduce")
    tab.fill("#time", "0")
    tab.click("#play")
    assert tab.input_value("#time") == "125"
    tab.wait_for_timeout(300)
    assert tab.input_value("#time") == "125"
