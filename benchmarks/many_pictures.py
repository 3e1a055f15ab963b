"""A hundred pictures in one process: how much the memory grows, and the time of each, on the clock and of processors.

    .venv/bin/python benchmarks/many_pictures.py [--count N] [KIND]...

The pictures are of a plate of 20 x 6 elements. Each kind is drawn in a process of its own: `fields`, what
`tailslap export --to png` draws; `contours`, those of a run's page; `plots`, what `result.plot()` draws. The first
picture loads the libraries, the second brings what VTK keeps: growth is counted from the third on. Exit status 1 if
memory grows by more than 50 MB or a picture takes more than 0.3 s, of processors where the machine is busy.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

GROWTH_MB, EACH_S = 50.0, 0.3
ELEMENTS = (20, 6)
OF_A_RUN = 3
FIRST = 3
"""Pictures before memory is read."""


def plate() -> tuple[np.ndarray, np.ndarray]:
    """Nodes [m], shape (n, 2), and elements, shape (e, 4)."""
    across, up = ELEMENTS
    x, y = np.meshgrid(np.linspace(0.0, 10.0, across + 1), np.linspace(1.0, 3.4, up + 1))
    first = (np.arange(across) + (across + 1) * np.arange(up)[:, None]).ravel()
    quads = np.column_stack([first, first + 1, first + across + 2, first + across + 1])
    return np.column_stack([x.ravel(), y.ravel()]), quads


def draw_fields(folder: Path, count: int) -> None:
    """Instants of a field, one picture each."""
    from postprocess.fields.contours import draw_instants
    from postprocess.fields.series import ELEMENTS as OF_ELEMENTS
    from postprocess.fields.series import NODES, FieldSeries

    points, quads = plate()
    rng, t = np.random.default_rng(1), np.arange(5.0)
    nodal = {name: rng.random((t.size, len(points), 2)) for name in NODES}
    elemental = {name: rng.random((t.size, len(quads))) for name in OF_ELEMENTS}
    series = FieldSeries("quad", points, quads, t, nodal, elemental)
    for drawn in range(0, count, t.size):
        draw_instants(folder, series, "velocity_y", instants=range(min(t.size, count - drawn)))


def draw_contour_pictures(folder: Path, count: int) -> None:
    """Contours of three fields by a plotter, as each run draws them."""
    from postprocess.fields.contours import ContourField, Situation, draw_contours

    points, quads = plate()
    for drawn in range(0, count, OF_A_RUN):
        names = (f"v_{number}" for number in range(drawn, min(drawn + OF_A_RUN, count)))
        draw_contours(
            Situation((points, quads)),
            [ContourField(name, "V", "m/s", points[:, 0]) for name in names],
            folder,
        )


def draw_plots(folder: Path, count: int) -> None:
    """Curves of two histories in two panels."""
    from postprocess.figures.histories import Curve, plot_overlays

    t = np.linspace(0.0, 0.4, 400)
    curves = (Curve("FE", t, np.sin(20.0 * t)), Curve("rigid", t, np.cos(20.0 * t)))
    for _ in range(count):
        plot_overlays({"v_gx [m/s]": curves, "v_gy [m/s]": curves}).save(folder / "a.png")


KINDS: dict[str, Callable[[Path, int], None]] = {
    "fields": draw_fields,
    "contours": draw_contour_pictures,
    "plots": draw_plots,
}


def used_mb() -> float:
    """Memory that this process holds [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def measure(kind: str, count: int) -> None:
    """Print growth [MB] and the time of a picture [s], on the clock and of processors."""
    with tempfile.TemporaryDirectory() as folder:
        KINDS[kind](Path(folder), FIRST)
        before, began, worked = used_mb(), time.perf_counter(), time.process_time()
        KINDS[kind](Path(folder), count)
        print(
            used_mb() - before, (time.perf_counter() - began) / count, (time.process_time() - worked) / count
        )


def measured(kind: str, count: int) -> list[float]:
    """The same, in a new process."""
    command = [sys.executable, __file__, "--count", str(count), "--here", kind]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [float(number) for number in said.split()]


def main() -> int:
    """Print the table; 1 if a limit is passed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kinds", nargs="*", choices=[*KINDS, []], metavar="KIND")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.here:
        measure(given.kinds[0], given.count)
        return 0
    print(f"{'pictures':<10} {'number':>6} {'growth, MB':>11} {'clock, s':>9} {'CPU, s':>8}")
    beyond = False
    for kind in given.kinds or KINDS:
        growth, clock, worked = measured(kind, given.count)
        print(f"{kind:<10} {given.count:>6} {growth:>11.1f} {clock:>9.3f} {worked:>8.3f}", flush=True)
        beyond |= growth > GROWTH_MB or min(clock, worked) > EACH_S
    return int(beyond)


if __name__ == "__main__":
    raise SystemExit(main())
