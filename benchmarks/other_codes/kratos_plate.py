"""The plate in Kratos by total Lagrangian elements."""

from __future__ import annotations

from importlib import metadata
from typing import Any

import KratosMultiphysics as Kratos
import KratosMultiphysics.StructuralMechanicsApplication as Structural
import numpy as np
from other_codes.jobs import answer
from other_codes.plate import Plate

VARIABLES = (
    *(Kratos.DISPLACEMENT, Kratos.VELOCITY, Kratos.ACCELERATION, Kratos.REACTION, Kratos.VOLUME_ACCELERATION),
    *(Kratos.NODAL_MASS, Kratos.FORCE_RESIDUAL, Kratos.RESIDUAL_VECTOR, Structural.MIDDLE_VELOCITY),
)


class KratosPlate:
    """The model at its start, velocities at the begin of a step."""

    version = metadata.version("KratosMultiphysics")
    velocity_lag = 1.0

    def __init__(self, plate: Plate) -> None:
        Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
        self.plate, self.nodes, self.model = plate, plate.nodes(), Kratos.Model()
        self.part = self.model.CreateModelPart("plate")
        fill(self.part, plate)
        self.strategy = make_strategy(self.part)

    def advance(self, steps: int) -> None:
        """Make steps."""
        part, strategy = self.part, self.strategy
        for _ in range(steps):
            part.ProcessInfo[Kratos.STEP] += 1
            part.CloneTimeStep(part.ProcessInfo[Kratos.TIME] + self.plate.time_step)
            strategy.InitializeSolutionStep()
            strategy.Predict()
            strategy.SolveSolutionStep()
            strategy.FinalizeSolutionStep()

    def state(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions, and velocities of a step before."""
        positions = self.nodes + self._nodal(Kratos.DISPLACEMENT)
        return positions, self._nodal(Kratos.VELOCITY)

    def _nodal(self, variable: Any) -> np.ndarray:
        """Values of a variable, shape (nodes, 2)."""
        values = Kratos.VariableUtils().GetSolutionStepValuesVector(self.part.Nodes, variable, 0, 2)
        return np.array(values).reshape(-1, 2)


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
    """Return central differences with the given step, without reactions, on displaced nodes."""
    part.ProcessInfo[Structural.RAYLEIGH_ALPHA] = part.ProcessInfo[Structural.RAYLEIGH_BETA] = 0.0
    scheme = Structural.ExplicitCentralDifferencesScheme(1.0, 1.0, 0.0)
    strategy = Structural.MechanicalExplicitStrategy(part, scheme, False, False, True)
    strategy.SetRebuildLevel(0)
    strategy.SetEchoLevel(0)
    strategy.Initialize()
    strategy.Check()
    return strategy


if __name__ == "__main__":
    answer(KratosPlate)
