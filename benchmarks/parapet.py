"""Measure bounds of the strength of parapets.

Exact answers, three walls, random walls, certificates and time.

python benchmarks/parapet.py [--random N]
"""

import argparse
import math
import time
from collections.abc import Iterator

import numpy as np
from skfem import MeshTri

from fem.limit.bounds import Bounds, collapse_load
from fem.limit.plate import PlasticPlate
from meshes.bands import banded_rectangle
from solver.parapet import Strengths, yield_line_resistance
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

LOAD_LENGTH, SEED = 1.067, 20_261_128
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


def main() -> None:
    """Print every row."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=500, help="number of random walls")
    parser.add_argument(
        "--tolerance", type=float, default=0.006, help="difference of the bounds of the three walls"
    )
    options = parser.parse_args()
    printed: list[Bounds] = []
    for name, exact in EXACT.items():
        bounds = exact_case(name, 0.01)
        lower, upper = bounds.lower.value, bounds.upper.value
        contained = lower <= exact * (1 + 1e-9) and upper >= exact * (1 - 1e-9)
        print(
            f"{name:36s} {lower:9.3f} to {upper:9.3f}, exact {exact:.3f}: {100 * (lower / exact - 1):+.2f} % and "
            f"{100 * (upper / exact - 1):+.2f} %{'' if contained else ', NOT CONTAINED'}"
        )
        printed.append(bounds)
    for name, numbers in WALLS.items():
        for place, distance, trial in zip(("interior", "end"), (None, 0.0), TRIAL[name], strict=True):
            height, beam, wall, base = numbers
            formula = yield_line_resistance(height, beam, wall, base, LOAD_LENGTH, place).force
            for tolerance in (0.01, min(options.tolerance, trial[1] / trial[0] - 1.0)):
                began = time.process_time()
                bounds = bounds_of(
                    uniform_wall(*numbers), Load(LOAD_LENGTH, height, distance), tolerance=tolerance
                )[1]
                seconds, ends = (
                    time.process_time() - began,
                    (bounds.lower.value / 1e3, bounds.upper.value / 1e3),
                )
                overlap = ends[0] <= trial[1] and trial[0] <= ends[1]
                print(
                    f"wall {name}, {place:8s} {ends[0]:6.1f} to {ends[1]:6.1f} kN ({100 * bounds.width:.2f} %; trial "
                    f"{trial[0]} to {trial[1]}{'' if overlap else ', NO OVERLAP'}; A13.3.1 {formula:.0f}), "
                    f"{bounds.upper_mesh.t.shape[1]} triangles, {seconds:.1f} s of one core"
                )
                printed.append(bounds)
    widths, crossed = [], 0
    for strengths, load, length in random_walls(options.random):
        bounds = bounds_of(strengths, load, length, 0.1, 300)[1]
        crossed += bounds.lower.value > bounds.upper.value or not bounds.lower.value > 0.0
        widths.append(bounds.width)
        printed.append(bounds)
    if widths:
        print(
            f"{len(widths)} random walls: {crossed} with crossed or missing bounds; widths at most "
            f"{100 * max(widths):.1f} %"
        )
    residual, excess = max(b.lower.residual for b in printed), max(b.lower.excess for b in printed)
    print(
        f"{len(printed)} lower bounds: residual of equilibrium at most {residual:.1e}, "
        f"excess over the criterion {max(excess, 0.0):g}"
    )


if __name__ == "__main__":
    main()
