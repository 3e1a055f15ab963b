"""The plate in Akantu: solid mechanics, explicit, lumped masses. Started by benchmarks/speed.py.

With `finite_deformation` its elastic material is St. Venant-Kirchhoff, total Lagrangian.
"""

from __future__ import annotations

import tempfile

import akantu as aka
from plate import Plate, from_argument, report

MATERIAL = """material elastic [
  name = steel
  rho = {density}
  E = {youngs_modulus}
  nu = {poissons_ratio}
  Plane_Stress = 1
  finite_deformation = 1
]
"""


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


def make_model(plate: Plate, mesh: aka.Mesh) -> aka.SolidMechanicsModel:
    """The model at its start; the thickness cancels, Akantu's is one."""
    with tempfile.NamedTemporaryFile("w", suffix=".dat") as file:
        file.write(MATERIAL.format(**vars(plate)))
        file.flush()
        aka.parseInput(file.name)
    model = aka.SolidMechanicsModel(mesh)
    model.initFull(_analysis_method=aka._explicit_lumped_mass)
    model.setTimeStep(plate.time_step)
    model.getBlockedDOFs()[plate.corner, 1] = True
    model.getVelocity()[:] = plate.velocities()
    return model


def main() -> None:
    """Run and report."""
    plate = from_argument()
    mesh = make_mesh(plate)
    model = make_model(plate, mesh)

    def advance(steps: int) -> None:
        for _ in range(steps):
            model.solveStep()

    def far_corner() -> tuple[float, float]:
        return tuple(plate.nodes()[plate.far] + model.getDisplacement()[plate.far])

    report(plate, aka.__version__, "total Lagrangian", advance, far_corner)


if __name__ == "__main__":
    main()
