"""The plate as a minimal NVIDIA Warp program on the CPU, in double precision. Started by benchmarks/speed.py.

One thread an element with its four points unrolled, total Lagrangian, St. Venant-Kirchhoff, plane stress; one
table of gradients, since all elements are congruent; forces by atomic add, on the CPU a plain one. Launches are
recorded once in a graph and replayed, so that Python starts STEPS steps at a time; that is twice as fast at 120
elements. Variants with the matrices written out and with other compiler flags ran within 5 % of this.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from plate import Plate, from_argument, report

STEPS = 10
"""Steps in the recorded graph; the numbers of steps asked for are multiples of it."""

Gradients = wp.types.matrix(shape=(4, 2), dtype=wp.float64)

wp.config.quiet = True
wp.set_module_options({"enable_backward": False, "fast_math": True})


@wp.struct
class Material:
    """Quadrature weight times thickness [m^3] and plane-stress constants [Pa]."""

    weight: wp.float64
    c_11: wp.float64
    c_12: wp.float64
    c_33: wp.float64


@wp.kernel
def subtract_forces(
    positions: wp.array(dtype=wp.vec2d),
    quads: wp.array(dtype=wp.vec4i),
    gradients: wp.array(dtype=Gradients),
    material: Material,
    force: wp.array(dtype=wp.vec2d),
):
    """Subtract one element's internal forces [N]: P = F S, f = w P grad N."""
    q = quads[wp.tid()]
    x = wp.matrix_from_cols(positions[q[0]], positions[q[1]], positions[q[2]], positions[q[3]])
    total = wp.matrix(shape=(2, 4), dtype=wp.float64)
    for point in range(4):
        g = gradients[point]
        f = x @ g
        e = wp.float64(0.5) * (wp.transpose(f) @ f - wp.identity(n=2, dtype=wp.float64))
        s_12 = wp.float64(2.0) * material.c_33 * e[0, 1]
        s = wp.mat22d(
            material.c_11 * e[0, 0] + material.c_12 * e[1, 1],
            s_12,
            s_12,
            material.c_12 * e[0, 0] + material.c_11 * e[1, 1],
        )
        total += (material.weight * (f @ s)) @ wp.transpose(g)
    for a in range(4):
        wp.atomic_sub(force, q[a], wp.vec2d(total[0, a], total[1, a]))


@wp.kernel
def drift(
    positions: wp.array(dtype=wp.vec2d),
    velocities: wp.array(dtype=wp.vec2d),
    force: wp.array(dtype=wp.vec2d),
    mobility: wp.array(dtype=wp.float64),
    corner: int,
    time_step: wp.float64,
):
    """Velocities, then positions of one node; the corner stays on the wall; the force is cleared."""
    node = wp.tid()
    velocity = velocities[node] + time_step * mobility[node] * force[node]
    if node == corner:
        velocity = wp.vec2d(velocity[0], wp.float64(0.0))
    velocities[node] = velocity
    positions[node] = positions[node] + time_step * velocity
    force[node] = wp.vec2d(wp.float64(0.0), wp.float64(0.0))


def gradient_table(plate: Plate) -> np.ndarray:
    """Shape-function gradients [1/m] at the four Gauss points, shape (4 points, 4 nodes, 2)."""
    x, y = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    points = [(a, b) for a in (-(3**-0.5), 3**-0.5) for b in (-(3**-0.5), 3**-0.5)]
    local = np.array([np.stack([x * (1.0 + y * b), y * (1.0 + x * a)], axis=1) / 4.0 for a, b in points])
    return local * 2.0 * np.array(plate.elements) / (plate.length, plate.width)


def make_material(plate: Plate) -> Material:
    """Constants of one point."""
    material = Material()
    material.weight = 0.25 * plate.length * plate.width / plate.count * plate.thickness
    material.c_11 = plate.youngs_modulus / (1.0 - plate.poissons_ratio**2)
    material.c_12 = plate.poissons_ratio * material.c_11
    material.c_33 = 0.5 * plate.youngs_modulus / (1.0 + plate.poissons_ratio)
    return material


def record(plate: Plate, positions: Any) -> Any:
    """The graph of STEPS steps from the plate's start."""
    masses = np.zeros(len(plate.nodes()))
    np.add.at(masses, plate.quads(), make_material(plate).weight * plate.density)
    velocities, force = wp.array(plate.velocities(), dtype=wp.vec2d), wp.zeros_like(positions)
    quads = wp.array(plate.quads().astype(np.int32), dtype=wp.vec4i)
    gradients, mobility = wp.array(gradient_table(plate), dtype=Gradients), wp.array(1.0 / masses)
    wp.load_module(device="cpu")
    with wp.ScopedCapture() as capture:
        for _ in range(STEPS):
            inputs = [positions, quads, gradients, make_material(plate), force]
            wp.launch(subtract_forces, plate.count, inputs)
            inputs = [positions, velocities, force, mobility, plate.corner, plate.time_step]
            wp.launch(drift, len(masses), inputs)
    return capture.graph


def main() -> None:
    """Run and report."""
    plate = from_argument()
    with wp.ScopedDevice("cpu"):
        positions = wp.array(plate.nodes(), dtype=wp.vec2d)
        graph = record(plate, positions)

        def advance(steps: int) -> None:
            for _ in range(steps // STEPS):
                wp.capture_launch(graph)

        report(plate, wp.config.version, "total Lagrangian", advance, lambda: positions.numpy()[plate.far])


if __name__ == "__main__":
    main()
