"""Measure bounds of the strength of parapets.

Exact answers, three walls, random walls, certificates, and the processor time of a page.

python benchmarks/parapet.py [--random N] [--tolerance DIFFERENCE] [--page RUNS]
"""

import math
import resource
import subprocess
import tempfile
import time
from collections.abc import Iterator

import command_line
import numpy as np
from skfem import MeshTri

from fem.limit.bounds import Bounds, collapse_load
from fem.limit.plate import PlasticPlate
from meshes.bands import banded_rectangle
from solver.parapet import Strengths
from tailslap.wall_strength.strength import Load, bounds_of

WALLS = {"A": (0.813, 0.0, 40.0, 58.0), "B": (0.914, 0.0, 50.0, 70.0), "C": (1.067, 20.0, 65.0, 80.0)}
"""H [m], M_b, M_w [kN m], M_c [kN m/m] of shared trials."""

TRIAL = {
    "A": ((328.1, 330.2), (187.6, 188.2)),
    "B": ((375.3, 378.2), (210.3, 212.2)),
    "C": ((470.9, 473.8), (249.3, 251.1)),
}
"""Bounds of another program, interior and end [kN]."""

EXACT = {
    "supported square, p L^2/m": 24.0,
    "orthotropic, affine to it": 24.0,
    "clamped square": 42.851,
    "cantilever strip, F H/(m L), m = 2": 2.0,
    "beam alone, 16 M_b/L, M_b = 1/4": 4.0,
    "point load, P/m": 4.0 * math.pi,
}
"""Exact collapse loads of plates with m = 1, of textbooks."""

LOAD_LENGTH, SEED, SCENE = 1.067, 20_261_128, "impact-parapet-tl4-sut"
SIDES = ("left", "right", "bottom", "top")
UNIT = np.array([0.0, 1.0])


def square(kind: str, x: float = 1.0, strengths: tuple[float, float] = (1.0, 1.0)) -> PlasticPlate:
    """Return a plate with one kind of sides under unit pressure.

    x: its length over its height 1 m; strengths: along x and y, of both signs.
    """
    rows = np.array([[strength] * 2 for strength in strengths for _ in range(2)])
    return PlasticPlate(x, 1.0, dict.fromkeys(SIDES, kind), UNIT, rows, pressure=1.0)


def diagonal_mesh(x: float, levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a mesh of a rectangle whose diagonals are lines."""
    mesh = MeshTri.init_symmetric().refined(levels)
    return mesh.p * np.array([[x], [1.0]]), mesh.t


def exact_case(name: str, tolerance: float) -> Bounds:
    """Return the bounds of a plate of EXACT."""
    grid = banded_rectangle(1.0, (0.0, 1.0), {}, lambda x, y: 0.25)
    ends = dict.fromkeys(("left", "right"), "free")
    quarter = dict(zip(SIDES, ("symmetric", "clamped", "symmetric", "clamped"), strict=True))
    if name == "supported square, p L^2/m":
        return collapse_load(square("supported"), *diagonal_mesh(1.0, 3), tolerance, 1)
    if name == "orthotropic, affine to it":
        return collapse_load(square("supported", 2.0, (4.0, 1.0)), *diagonal_mesh(2.0, 3), tolerance, 1)
    if name == "clamped square":
        plate = PlasticPlate(0.5, 0.5, quarter, 0.5 * UNIT, np.ones((4, 2)), pressure=1.0)
        nodes, triangles = diagonal_mesh(1.0, 2)
        return collapse_load(plate, 0.5 * nodes, triangles, 0.8 * tolerance, 6000)
    if name == "cantilever strip, F H/(m L), m = 2":
        sides = ends | {"bottom": "clamped", "top": "free"}
        strip = PlasticPlate(1.0, 1.0, sides, UNIT, np.full((4, 2), 2.0), line=(1.0, 0.0, 1.0))
        return collapse_load(strip, *grid, tolerance, 1)
    if name == "beam alone, 16 M_b/L, M_b = 1/4":
        sides = dict.fromkeys(("left", "right"), "clamped") | {"bottom": "free", "top": "free"}
        beam = PlasticPlate(1.0, 1.0, sides, UNIT, np.full((4, 2), 1e-5), line=(1.0, 0.0, 1.0), beam=0.25)
        return collapse_load(beam, *grid, tolerance, 1)
    plate = PlasticPlate(1.0, 1.0, quarter, UNIT, np.full((4, 2), 4.0), point=(0.0, 0.0))
    mesh = banded_rectangle(1.0, (0.0, 1.0), {}, lambda x, y: 0.01 if x + y < 0.01 else 0.25)
    return collapse_load(plate, *mesh, tolerance, 150)


def uniform_wall(height: float, beam: float, wall: float, base: float) -> Strengths:
    """Return a wall of equal signs.

    From H [m], M_b, M_w [kN m] and M_c [kN m/m]."""
    rows = np.array([[wall / height] * 2] * 2 + [[base] * 2] * 2)
    return Strengths(np.array([0.0, height]), 1e3 * rows, 1e3 * beam)


def random_walls(count: int, seed: int = SEED) -> Iterator[tuple[Strengths, Load, float]]:
    """Yield walls with strengths of unequal signs that vary with the height."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        height = random.uniform(0.6, 1.4)
        levels = np.array([0.0, *np.sort(random.uniform(0.2, 0.8, random.integers(0, 3))), 1.0]) * height
        if levels.size > 3 and levels[2] - levels[1] < 0.1 * height:
            levels = np.delete(levels, 2)
        rows = 10.0 ** random.uniform(4.0, 5.2, (4, levels.size))
        strengths = Strengths(levels, rows, random.choice([0.0, 10.0 ** random.uniform(3.5, 4.7)]))
        place = random.choice([np.nan, 0.0, random.uniform(0.1, 2.0)])
        load = Load(
            random.uniform(0.5, 2.5),
            height * random.choice([1.0, random.uniform(0.4, 0.95)]),
            None if np.isnan(place) else float(place),
        )
        yield strengths, load, float(random.choice([math.inf, random.uniform(6.0, 20.0)]))


def print_exact() -> list[Bounds]:
    """Print and return the bounds of plates with exact answers."""
    cases = [exact_case(name, 0.01) for name in EXACT]
    for (name, exact), bounds in zip(EXACT.items(), cases, strict=True):
        lower, upper = bounds.lower.value, bounds.upper.value
        contained = lower <= exact * (1 + 1e-9) and upper >= exact * (1 - 1e-9)
        print(
            f"{name:36s} {lower:9.3f} to {upper:9.3f}, exact {exact:.3f}: {100 * (lower / exact - 1):+.2f} % and "
            f"{100 * (upper / exact - 1):+.2f} %{'' if contained else ', NOT CONTAINED'}"
        )
    return cases


def print_wall(name: str, place: str, trial: tuple[float, float], tolerance: float) -> Bounds:
    """Print the bounds of a wall beside those of another program."""
    height, *_ = WALLS[name]
    load = Load(LOAD_LENGTH, height, 0.0 if place == "end" else None)
    strengths, began = uniform_wall(*WALLS[name]), time.process_time()
    bounds = bounds_of(strengths, load, tolerance=tolerance)
    seconds = time.process_time() - began
    lower, upper = bounds.lower.value / 1e3, bounds.upper.value / 1e3
    overlap = lower <= trial[1] and trial[0] <= upper
    print(
        f"wall {name}, {place:8s} {lower:6.1f} to {upper:6.1f} kN ({100 * bounds.width:.2f} %; trial "
        f"{trial[0]} to {trial[1]}{'' if overlap else ', NO OVERLAP'}; "
        f"A13.3.1 {strengths.resistance(LOAD_LENGTH, place).force / 1e3:.0f}), "
        f"{bounds.upper_mesh.t.shape[1]} triangles, {seconds:.1f} s of one core"
    )
    return bounds


def print_random(count: int) -> list[Bounds]:
    """Print and return the bounds of random walls."""
    began = time.process_time()
    cases = [bounds_of(*wall, tolerance=0.1, most=300) for wall in random_walls(count)]
    crossed = sum(not 0.0 < bounds.lower.value <= bounds.upper.value for bounds in cases)
    widths = np.array([bounds.width for bounds in cases])
    print(
        f"{count} random walls: {crossed} with crossed or missing bounds; widths {100 * np.median(widths):.1f} % in "
        f"the median, at most {100 * widths.max():.1f} %; {time.process_time() - began:.0f} s of one core"
    )
    return cases


def print_page(repeats: int) -> None:
    """Print the processor time of `tailslap parapet` with its page and pictures."""
    command, times = [*command_line.TAILSLAP, "parapet", SCENE, "--quiet", "--force", "--out"], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(1 + repeats):  # the first one compiles
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                [*command, f"{folder}/wall"], cwd=command_line.ROOT, check=True, stdout=subprocess.DEVNULL
            )
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    print(
        f"tailslap parapet {SCENE}, page and pictures: {min(times[1:]):.1f} to {max(times[1:]):.1f} s of "
        f"processor time (user and system, {repeats} runs)"
    )


def main() -> None:
    """Print every row."""
    arguments = command_line.options(__doc__, random=500, tolerance=0.006, page=3)
    printed = print_exact()
    for name in WALLS:
        for place, trial in zip(("interior", "end"), TRIAL[name], strict=True):
            for tolerance in (0.01, min(arguments.tolerance, trial[1] / trial[0] - 1.0)):
                printed.append(print_wall(name, place, trial, tolerance))
    if arguments.random:
        printed += print_random(arguments.random)
    residual, excess = max(b.lower.residual for b in printed), max(b.lower.excess for b in printed)
    print(
        f"{len(printed)} lower bounds: residual of equilibrium at most {residual:.1e}, "
        f"excess over the criterion {max(excess, 0.0):g}"
    )
    if arguments.page:
        print_page(arguments.page)


if __name__ == "__main__":
    main()
