"""The plate in Akantu as an explicit lumped solid."""

from __future__ import annotations

import tempfile

import akantu as aka
import numpy as np
from other_codes.jobs import answer
from other_codes.plate import Plate

MATERIAL = """material elastic [
  name = steel
  rho = {density}
  E = {youngs_modulus}
  nu = {poissons_ratio}
  Plane_Stress = 1
  finite_deformation = 1
]
"""


class AkantuPlate:
    """The model at its start, with Akantu's thickness of one."""

    version = aka.__version__
    velocity_lag = 0.0

    def __init__(self, plate: Plate) -> None:
        self.mesh, self.nodes = make_mesh(plate), plate.nodes()
        with tempfile.NamedTemporaryFile("w", suffix=".dat") as file:
            file.write(MATERIAL.format(**vars(plate)))
            file.flush()
            aka.parseInput(file.name)
        self.model = aka.SolidMechanicsModel(self.mesh)
        self.model.initFull(_analysis_method=aka._explicit_lumped_mass)
        self.model.setTimeStep(plate.time_step)
        self.model.getBlockedDOFs()[plate.corner, 1] = True
        self.model.getVelocity()[:] = plate.velocities()

    def advance(self, steps: int) -> None:
        """Make steps."""
        for _ in range(steps):
            self.model.solveStep()

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities of the same instant."""
        return self.nodes + self.model.getDisplacement(), self.model.getVelocity().copy()


def make_mesh(plate: Plate) -> aka.Mesh:
    """The mesh, without a file between."""
    nodes, quads, mesh = plate.nodes(), plate.quads(), aka.Mesh(2)
    access = aka.MeshAccessor(mesh)
    access.resizeNodes(len(nodes))
    mesh.getNodes()[:] = nodes
    mesh.addConnectivityType(aka._quadrangle_4)
    access.resizeConnectivity(len(quads), aka._quadrangle_4)
    mesh.getConnectivity(aka._quadrangle_4)[:] = quads
    access.makeReady()
    return mesh


if __name__ == "__main__":
    answer(AkantuPlate)
