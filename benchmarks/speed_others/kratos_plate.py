"""The plate in Kratos: total Lagrangian elements, its explicit strategy with central differences and lumped masses.

Started by benchmarks/speed.py.
"""

from __future__ import annotations

import KratosMultiphysics as Kratos
import KratosMultiphysics.StructuralMechanicsApplication as Structural
from plate import Plate, from_argument, report

VARIABLES = (
    Kratos.DISPLACEMENT,
    Kratos.VELOCITY,
    Kratos.ACCELERATION,
    Kratos.REACTION,
    Kratos.VOLUME_ACCELERATION,
    Kratos.NODAL_MASS,
    Kratos.FORCE_RESIDUAL,
    Kratos.RESIDUAL_VECTOR,
    Structural.MIDDLE_VELOCITY,
)


def fill(part: Kratos.ModelPart, plate: Plate) -> None:
    """Nodes, elements, material, the held corner and the velocities of the start."""
    part.ProcessInfo[Kratos.DOMAIN_SIZE] = 2
    part.ProcessInfo[Kratos.DELTA_TIME] = plate.time_step
    for variable in VARIABLES:
        part.AddNodalSolutionStepVariable(variable)
    part.SetBufferSize(2)
    for number, (x, y) in enumerate(plate.nodes().tolist(), start=1):
        part.CreateNewNode(number, x, y, 0.0)
    properties = part.CreateNewProperties(1)
    properties[Kratos.YOUNG_MODULUS] = plate.youngs_modulus
    properties[Kratos.POISSON_RATIO] = plate.poissons_ratio
    properties[Kratos.DENSITY] = plate.density
    properties[Kratos.THICKNESS] = plate.thickness
    properties[Kratos.COMPUTE_LUMPED_MASS_MATRIX] = True
    properties[Kratos.CONSTITUTIVE_LAW] = Structural.LinearElasticPlaneStress2DLaw()
    for number, nodes in enumerate((plate.quads() + 1).tolist(), start=1):
        part.CreateNewElement("TotalLagrangianElement2D4N", number, nodes, properties)
    for axis in ("X", "Y", "Z"):
        displacement, reaction = (f"{kind}_{axis}" for kind in ("DISPLACEMENT", "REACTION"))
        Kratos.VariableUtils().AddDof(getattr(Kratos, displacement), getattr(Kratos, reaction), part)
    Kratos.VariableUtils().ApplyFixity(Kratos.DISPLACEMENT_Z, True, part.Nodes)
    part.GetNode(plate.corner + 1).Fix(Kratos.DISPLACEMENT_Y)
    for node, (x, y) in zip(part.Nodes, plate.velocities().tolist(), strict=True):
        node.SetSolutionStepValue(Kratos.VELOCITY, 0, [x, y, 0.0])


def make_strategy(part: Kratos.ModelPart) -> Structural.MechanicalExplicitStrategy:
    """Central differences with the step as given; no reactions, no new degrees of freedom, nodes that move."""
    part.ProcessInfo[Structural.RAYLEIGH_ALPHA] = part.ProcessInfo[Structural.RAYLEIGH_BETA] = 0.0
    scheme = Structural.ExplicitCentralDifferencesScheme(1.0, 1.0, 0.0)
    strategy = Structural.MechanicalExplicitStrategy(part, scheme, False, False, True)
    strategy.SetRebuildLevel(0)
    strategy.SetEchoLevel(0)
    strategy.Initialize()
    strategy.Check()
    return strategy


def main() -> None:
    """Run and report."""
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    plate, model = from_argument(), Kratos.Model()
    part = model.CreateModelPart("plate")
    fill(part, plate)
    strategy = make_strategy(part)

    def advance(steps: int) -> None:
        for _ in range(steps):
            part.ProcessInfo[Kratos.STEP] += 1
            part.CloneTimeStep(part.ProcessInfo[Kratos.TIME] + plate.time_step)
            strategy.InitializeSolutionStep()
            strategy.Predict()
            strategy.SolveSolutionStep()
            strategy.FinalizeSolutionStep()

    def far_corner() -> tuple[float, float]:
        node = part.GetNode(plate.far + 1)
        return node.X, node.Y

    report(plate, Kratos.KratosGlobals.Kernel.Version(), "total Lagrangian", advance, far_corner)


if __name__ == "__main__":
    main()
