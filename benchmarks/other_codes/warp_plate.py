"""The plate as a minimal NVIDIA Warp program on the CPU.

In double precision; see jobs.py. One thread an element with its four points unrolled, total Lagrangian, St.
Venant-Kirchhoff, plane stress; one table of gradients where all elements are congruent, else one an element; forces by
atomic add, on the CPU a plain one. Launches are recorded once in a graph and replayed, so that Python starts STEPS
steps at a time; that is twice as fast at 120 elements. Variants with the matrices written out and with other compiler
flags ran within 5 % of this.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from other_codes.jobs import answer
from other_codes.plate import Plate
from other_codes.quadrature import points_of

STEPS = 10
"""Steps in the recorded graph; what is left of the steps asked for is made singly."""

Gradients = wp.types.matrix(shape=(4, 2), dtype=wp.float64)

wp.config.quiet = True
wp.set_module_options({"enable_backward": False, "fast_math": True})


@wp.struct
class Material:
    """Plane-stress constants [Pa]."""

    c_11: wp.float64
    c_12: wp.float64
    c_33: wp.float64


def make_kernel(is_congruent: bool) -> Any:
    """Return the kernel that subtracts the internal forces of an element [N].

    P = F S, f = w P grad N; congruent elements have one common table.
    """

    @wp.kernel
    def subtract_forces(
        positions: wp.array(dtype=wp.vec2d),
        quads: wp.array(dtype=wp.vec4i),
        gradients: wp.array2d(dtype=Gradients),
        weights: wp.array2d(dtype=wp.float64),
        material: Material,
        force: wp.array(dtype=wp.vec2d),
    ):
        q = quads[wp.tid()]
        x = wp.matrix_from_cols(positions[q[0]], positions[q[1]], positions[q[2]], positions[q[3]])
        total = wp.matrix(shape=(2, 4), dtype=wp.float64)
        column = wp.where(wp.static(is_congruent), 0, wp.tid())
        for point in range(4):
            g = gradients[column, point]
            f = x @ g
            e = wp.float64(0.5) * (wp.transpose(f) @ f - wp.identity(n=2, dtype=wp.float64))
            s_12 = wp.float64(2.0) * material.c_33 * e[0, 1]
            s = wp.mat22d(
                material.c_11 * e[0, 0] + material.c_12 * e[1, 1],
                s_12,
                s_12,
                material.c_12 * e[0, 0] + material.c_11 * e[1, 1],
            )
            total += (weights[column, point] * (f @ s)) @ wp.transpose(g)
        for a in range(4):
            wp.atomic_sub(force, q[a], wp.vec2d(total[0, a], total[1, a]))

    return subtract_forces


@wp.kernel
def drift(
    positions: wp.array(dtype=wp.vec2d),
    velocities: wp.array(dtype=wp.vec2d),
    force: wp.array(dtype=wp.vec2d),
    mobility: wp.array(dtype=wp.float64),
    corner: int,
    time_step: wp.float64,
):
    """Advance one node, on the wall at the corner, without force."""
    node = wp.tid()
    velocity = velocities[node] + time_step * mobility[node] * force[node]
    if node == corner:
        velocity = wp.vec2d(velocity[0], wp.float64(0.0))
    velocities[node] = velocity
    positions[node] = positions[node] + time_step * velocity
    force[node] = wp.vec2d(wp.float64(0.0), wp.float64(0.0))


def make_material(plate: Plate) -> Material:
    """Constants of all points."""
    material = Material()
    material.c_11 = plate.youngs_modulus / (1.0 - plate.poissons_ratio**2)
    material.c_12 = plate.poissons_ratio * material.c_11
    material.c_33 = 0.5 * plate.youngs_modulus / (1.0 + plate.poissons_ratio)
    return material


class WarpPlate:
    """Arrays of the plate, and recorded graphs of steps.

    Velocities are half a step behind.
    """

    version = wp.config.version
    velocity_lag = 0.5

    def __init__(self, plate: Plate) -> None:
        nodes, quads, masses = plate.nodes(), plate.quads(), plate.masses()
        self.positions, self.velocities = (
            wp.array(values, dtype=wp.vec2d, device="cpu") for values in (nodes, plate.velocities())
        )
        with wp.ScopedDevice("cpu"):
            calls = self._calls(plate, quads, masses)
            wp.load_module()
            self.many, self.one = (record(calls, steps) for steps in (STEPS, 1))

    def _calls(self, plate: Plate, quads: np.ndarray, masses: np.ndarray) -> list[Any]:
        """Kernels of a step with threads and inputs."""
        distinct = quads if plate.mesh else quads[:1]
        _, gradients, areas = points_of(plate.body()[distinct])
        tables = wp.array(gradients, dtype=Gradients), wp.array(plate.thickness * areas, dtype=wp.float64)
        shared, force = wp.array(quads.astype(np.int32), dtype=wp.vec4i), wp.zeros_like(self.positions)
        pull = [self.positions, shared, *tables, make_material(plate), force]
        mobility = wp.array(1.0 / masses, dtype=wp.float64)
        move = [self.positions, self.velocities, force, mobility, plate.corner, plate.time_step]
        return [(make_kernel(not plate.mesh), plate.count, pull), (drift, len(masses), move)]

    def advance(self, steps: int) -> None:
        """Make steps."""
        for _ in range(steps // STEPS):
            wp.capture_launch(self.many)
        for _ in range(steps % STEPS):
            wp.capture_launch(self.one)

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions, and velocities of half a step before."""
        return self.positions.numpy().copy(), self.velocities.numpy().copy()


def record(calls: list[Any], steps: int) -> Any:
    """Return the graph of the steps."""
    with wp.ScopedCapture() as capture:
        for _ in range(steps):
            for kernel, threads, inputs in calls:
                wp.launch(kernel, threads, inputs)
    return capture.graph


if __name__ == "__main__":
    answer(WarpPlate)
