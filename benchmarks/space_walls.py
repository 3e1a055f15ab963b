"""Roll and force of a scene with [body] on several walls.

    .venv/bin/python benchmarks/space_walls.py [SCENE] [--heights 27 32 36 42 54] [--set KEY=VALUE ...]

Printed are, for each height [in] and named profile, the largest roll [deg], or the outcome if the vehicle does not
remain upright, the largest 50 ms mean of the lateral force [kN] and the height of its resultant [m]; then the largest
stated error, and for each profile the lowest wall that keeps the vehicle upright with its error [m].
"""

from __future__ import annotations

import math
from dataclasses import replace

import command_line

from solver.space import PROFILES, SpaceMotion, lowest_wall, solve_space
from tailslap.case.impact.space.input import SpaceInput, space_input
from tailslap.scene.read import read_scene

INCH = 0.0254


def on_wall(inputs: SpaceInput, profile: str, height: float) -> SpaceMotion:
    """Solve the motion on a wall of this profile and height [in]."""
    wall = replace(inputs.wall, height=height * INCH, profile=profile)
    vehicle, _, speed, angle = inputs
    return solve_space(vehicle, wall, speed, angle)


def entry(motion: SpaceMotion) -> str:
    """Return roll or outcome, 50 ms mean and height of a motion."""
    answers = motion.answers
    roll = f"{math.degrees(answers.largest_roll):.0f}" if motion.outcome == "upright" else motion.outcome
    return f"{roll}; {1e-3 * answers.mean_50ms:.0f}; {' or '.join(f'{h:.2f}' for h in motion.heights)}"


def main() -> None:
    """Print the table."""
    options = command_line.options(
        __doc__, ("scene", "impact-tipping-tl4-sut"), heights=(27.0, 32.0, 36.0, 42.0, 54.0), set=[]
    )
    inputs = space_input(read_scene(options.scene, options.set)[0])
    columns = [f"{height:g} in" for height in options.heights]
    print(f"| profile | {' | '.join(columns)} | lowest wall [m] |\n|{'---|' * (len(columns) + 2)}")
    error = 0.0
    for profile in PROFILES:
        motions = [on_wall(inputs, profile, height) for height in options.heights]
        error = max(error, *(motion.error for motion in motions))
        wall = replace(inputs.wall, profile=profile)
        lowest, uncertain = lowest_wall(*inputs._replace(wall=wall))
        print(
            f"| {profile} | {' | '.join(map(entry, motions))} | {lowest:.3f} ± {uncertain:.3f} |", flush=True
        )
    print(f"largest stated error {error:.1e}")


if __name__ == "__main__":
    main()
