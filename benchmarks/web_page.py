"""Measure the page of `tailslap explore` in Chromium.

    python benchmarks/web_page.py [--random 200]

Against kernels of this machine, of all scenes of the page and random changes of them: largest difference of a motion
over the maximum of its column, and of the percentiles of the band. Size of the page, time to the first answer, also
by a slower processor, and times of motion, band and plates on both sides.
"""

from __future__ import annotations

import argparse
import gzip
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from tailslap.browser import kernels, model, page, plate, space_model
from tailslap.case.of_arguments import case_of_scene
from tailslap.errors import InputError
from tailslap.scene.schema import value_at

CHROMIUM = "/usr/bin/chromium"
IN_SPACE = "impact-tipping-tl4-sut", "impact-97-kip-tractor-van"
THROTTLING = 4
"""Slower processor of a telephone, as of Lighthouse."""

STRIDE = 40
"""Rows of a motion that are compared: each of this number."""

ANSWER = """([name, changes, stride]) => {
  open(data.scenes.findIndex((one) => one.name === name));
  clearTimeout(timer);
  chosen.values = new Map(changes);
  for (const quantity of scene().quantities) machine.array("motion.values")[quantity.column] = value(quantity);
  drawBand("band.ranges.drawn");
  const answer = machine.solve(), width = scene().arrays["motion.motion.values"][2][1], rows = [];
  const values = machine.array("motion.motion.values");
  for (let k = 0; k < answer[3]; k += stride) rows.push([...values.subarray(k * width, (k + 1) * width)]);
  const band = machine.call("band");
  return [answer, rows, band, [...machine.array("band.percentiles")]];
}"""

TIMES = """([name, count]) => {
  open(data.scenes.findIndex((one) => one.name === name));
  clearTimeout(timer);
  if (!scene().rows.length) drawBand("band.ranges.drawn");
  const kernels = scene().rows.length ? ["space", "space_one"] : ["motion", "band"];
  return kernels.map((kernel) => Math.min(...Array.from({ length: count }, () => {
    const start = performance.now();
    machine.call(kernel);
    return performance.now() - start;
  })));
}"""


def native(built: Any, changes: dict[str, float]) -> tuple[Any, np.ndarray, Any, np.ndarray]:
    """Return answers and numbers of motion and band by this machine's code."""
    kernel, arguments = built.calls["motion"]
    for key, value in changes.items():
        arguments[0][built.quantities.index(key), 0] = value
    answer = kernel(*arguments)
    rows = arguments[-2].values[: answer[3] : STRIDE].copy()
    kernel, arguments = built.calls["band"]
    return answer, rows, kernel(*arguments), arguments[-1].ravel()


def random_changes(random: np.random.Generator, case: Any) -> dict[str, float]:
    """Return changed quantities of a scene."""
    changes = {
        "impact.speed": random.uniform(8.0, 35.0),
        "impact.angle": np.radians(random.uniform(5.0, 30.0)),
        "contact.friction": random.uniform(0.0, 0.6),
        "vehicle.mass": case.scene.vehicle.mass * random.uniform(0.7, 1.4),
        "contact.restitution": random.uniform(0.0, 0.4),
        "contact.stiffness": random.uniform(5e5, 4e6),
    }
    return {key: float(value) for key, value in changes.items() if value_at(case.scene, key) is not None}


def compare(tab: Any, names: list[str], count: int) -> None:
    """Print the largest differences of all scenes and of random ones."""
    random, cases = np.random.default_rng(64), {name: case_of_scene(name, None) for name in names}
    runs = [(name, dict[str, float]()) for name in names]
    chosen = [names[int(random.integers(len(names)))] for _ in range(count)]
    runs += [(name, random_changes(random, cases[name])) for name in chosen]
    motions, bands, differing = [], [], 0
    for name, changes in runs:
        case: Any = cases[name]
        answer, rows, band, percentiles = native(model.model_of(case), changes)
        there, rows_there, band_there, ends_there = tab.evaluate(ANSWER, [name, [*changes.items()], STRIDE])
        if answer[2] == kernels.MORE_ROWS:
            continue  # Chromium has made room for them
        if list(answer) != there[: len(answer)] or list(band) != band_there:
            differing += 1
            print(f"{name} {changes}: {answer} {band}, in Chromium {there} {band_there}")
        elif answer[3]:
            largest = np.maximum(np.abs(rows).max(axis=0), 1e-300)
            motions.append(float((np.abs(np.array(rows_there) - rows).max(axis=0) / largest).max()))
            if motions[-1] > 1e-9:
                print(f"{name} {changes}: {motions[-1]:.1e} of a maximum")
            if band[0] == band[2] == 0:
                bands.append(float(np.abs(np.array(ends_there) / percentiles - 1.0).max()))
    print(f"{len(runs)} scenes, {differing} with another outcome")
    print(
        f"motions: {np.max(motions):.1e} of each maximum; percentiles of {len(bands)} bands: {np.max(bands):.1e}"
    )


def time_both(tab: Any, name: str) -> None:
    """Print the shortest times of motion and band on both sides [ms]."""
    case: Any = case_of_scene(name, None)
    built: Any = (space_model if case.scene.body else model).model_of(case)
    here, names = [], ["space", "space_one"] if case.scene.body else ["motion", "band"]
    for kernel, arguments in (built.calls[one] for one in names):
        spent = []
        for _ in range(15):
            began = time.perf_counter()
            kernel(*arguments)
            spent.append(1e3 * (time.perf_counter() - began))
        here.append(min(spent))
    there = tab.evaluate(TIMES, [name, 15])
    for kernel, here_ms, there_ms in zip(names, here, there, strict=True):
        print(
            f"{name} {kernel}: native {here_ms:.1f} ms, Chromium {there_ms:.1f} ms, {there_ms / here_ms:.1f} times"
        )


def phone(browser: Any, path: Path) -> None:
    """Print times on a telephone, whose processor is slower [ms]."""
    context = browser.new_context(viewport={"width": 390, "height": 844}, device_scale_factor=3)
    tab = context.new_page()
    context.new_cdp_session(tab).send("Emulation.setCPUThrottlingRate", {"rate": THROTTLING})
    tab.goto(path.as_uri())
    tab.wait_for_function("() => document.body.dataset.band")
    first, band = (tab.get_attribute("body", f"data-{name}") for name in ("ready", "band"))
    print(
        f"telephone, 390 px, processor {THROTTLING} times slower: first answer after {first} ms, its band in {band} ms"
    )
    context.close()


def time_plates(tab: Any) -> None:
    """Print the shortest times of the plates on both sides [ms]."""
    for number, name in enumerate(plate.SCENES):
        case: Any = case_of_scene(name, None)
        kernel, arguments = plate.calls_of(case.plan())["plate"]
        run, here, there = kernel.bound(*arguments), [], []
        tab.select_option("#plate-scene", str(number))
        for _ in range(7):
            began = time.perf_counter()
            run()
            here.append(1e3 * (time.perf_counter() - began))
            there.append(1e3 * tab.evaluate("runPlate().then(() => Number(at('plate').dataset.spent))"))
        times = min(here), min(there)
        print(
            f"plate of {name}: native {times[0]:.0f} ms, Chromium {times[1]:.0f} ms, {times[1] / times[0]:.1f} times"
        )


def main() -> None:
    from playwright.sync_api import sync_playwright

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--random", type=int, default=200, help="number of random changes")
    count = parser.parse_args().random
    names = page.all_scenes("impact-mash-tl4-sut")
    text = page.page_of(names).encode()
    print(f"page: {len(text) / 1e3:.0f} kB, compressed {len(gzip.compress(text)) / 1e3:.0f} kB")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as started:
        path = Path(folder) / "explore.html"
        path.write_bytes(text)
        browser = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        phone(browser, path)
        tab = browser.new_page()
        tab.goto(path.as_uri())
        tab.wait_for_function("() => document.body.dataset.band")
        first, band = (tab.get_attribute("body", f"data-{name}") for name in ("ready", "band"))
        print(f"first answer after {first} ms, its band in {band} ms")
        for name in ("impact-mash-tl4-sut", "impact-mash-tl5-tractor-van", *IN_SPACE):
            time_both(tab, name)
        for name in IN_SPACE:
            tab.evaluate("delete document.body.dataset.band")
            tab.evaluate("(name) => open(data.scenes.findIndex((one) => one.name === name))", name)
            tab.wait_for_function("() => document.body.dataset.band")
            print(f"{name}: answer with its band after {tab.get_attribute('body', 'data-band')} ms")
        time_plates(tab)
        compare(tab, [name for name in names if is_computed(name)], count)


def is_computed(name: str) -> bool:
    """Return True for a scene that the page computes."""
    try:
        model.demand_planar(case_of_scene(name, None))
    except InputError:
        return False
    return True


if __name__ == "__main__":
    main()
