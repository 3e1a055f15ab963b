"""Time of many motions in space, and changes by the step.

    .venv/bin/python benchmarks/space_many.py [--samples 400] [--seed 8] [--profiles vertical new-jersey]

The truck of the shipped scene, with heights, inertias, springs, tyres, crush and walls in the ranges of the study
`tipping`. The outcome, largest roll, 50 ms mean and height of the force are compared with those of a quarter of the
step, within whose error the changes are the errors of samples. Times are of the processor.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import command_line
import numpy as np
from command_line import row
from space_vehicles import ANGLE, MASS, SPEED, truck, truck_unit

from solver.space import SpaceVehicle, SpaceWall, lowest_wall, solve_space, solve_spaces
from tailslap.case import case_of
from tailslap.case.impact.space.input import space_input
from tailslap.scene.read import read_scene


def drawn(samples: int, seed: int, profile: str) -> tuple[SpaceVehicle, SpaceWall, float, float]:
    """Draw trucks and walls."""
    random = np.random.default_rng(seed)

    def between(low: float, high: float) -> np.ndarray:
        return random.uniform(low, high, samples)

    plateau, stiffness, restitution = between(0.57, 1.43), between(0.5, 1.5), between(0.1, 0.35)
    spring, friction = between(0.5, 2.0), between(0.5, 0.8)
    unit = truck_unit(centre_height=between(1.2, 1.5), roll_inertia=MASS * between(0.9, 1.4) ** 2)
    nominal = truck(unit)
    axles = tuple(replace(axle, spring=axle.spring * spring, friction=friction) for axle in nominal.axles)
    strips = tuple(
        replace(
            strip,
            stiffness=strip.stiffness * stiffness,
            plateau=strip.plateau * plateau,
            restitution=restitution,
        )
        for strip in nominal.strips
    )
    wall = SpaceWall(between(0.6, 1.1), profile, between(0.2, 0.5))
    return SpaceVehicle(nominal.units, axles, strips), wall, SPEED, ANGLE


def least_time(solve: Callable[[], object], repeats: int = 9) -> float:
    """Return the least processor time of a call [s]."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        solve()
        times.append(time.process_time() - start)
    return min(times)


def single(scene: str) -> None:
    """Print the time of one motion and of the lowest wall."""
    arguments = space_input(case_of(*read_scene(scene)).scene)
    for name, solve in (
        ("one motion, step of 0.25 ms", partial(solve_space, step=2.5e-4, points=1)),
        ("one motion with its error", solve_space),
        ("lowest wall with its error", lowest_wall),
    ):
        solve(*arguments)  # compiles
        row(f"{name}, {scene}", "30 ms", f"{1e3 * least_time(partial(solve, *arguments)):.1f} ms")


def height_map(scene: str, count: int) -> None:
    """Print the time of a map over heights of wall and centre."""
    walls, centres = (heights.ravel() for heights in np.meshgrid(*2 * [np.linspace(0.6, 1.4, count)]))
    heights = {"wall.height": walls, "body.centre_height": centres + 0.4}
    arguments = space_input(case_of(*read_scene(scene)).scene, heights)
    spent = least_time(partial(solve_spaces, *arguments), 1)
    row(f"map of {count} x {count} heights, {scene}", "8 s", f"{spent:.1f} s")


def main() -> None:
    """Print the times of motions and the changes."""
    options = command_line.options(__doc__, samples=400, seed=8, profiles=("vertical", "new-jersey"))
    single("impact-tipping-tl4-sut")
    height_map("impact-tipping-tl4-sut", 50)
    for profile in options.profiles:
        trucks = drawn(options.samples, options.seed, profile)
        solve_spaces(*drawn(2, 0, profile))  # compiles
        start = time.process_time()
        coarse = solve_spaces(*trucks)
        spent = (time.process_time() - start) / options.samples
        fine = solve_spaces(*trucks, refine=4)
        same = coarse.outcome == fine.outcome
        print(f"{profile}, {options.samples} trucks")
        row("time of a motion", "6 ms", f"{1e3 * spent:.2f} ms")
        row("other outcome", "0", str((~same).sum()))
        roll = np.degrees(np.abs(coarse.largest_roll - fine.largest_roll))[same]
        changes = {
            "largest roll [deg]": roll, "50 ms mean [%]": 100.0 * np.abs(coarse.mean_50ms / fine.mean_50ms - 1.0),
            "height [m]": np.abs(coarse.height - fine.height),
        }  # fmt: skip
        for name, values in changes.items():
            middle, most = np.percentile(values, (50, 95))
            row(f"change of {name}: median, 95 %", "", f"{middle:.2g}, {most:.2g}")


if __name__ == "__main__":
    main()
