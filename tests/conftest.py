"""What the tests share: scenes run once a session, and models made from a few numbers."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from fem.corner import Drag, Signed
from fem.model import PlateModel, PlateProperties, StepProperties, build_model
from meshes import plate_mesh
from tailslap.plan import make_plan
from tailslap.run import Outcome, run_scene
from tailslap.scene_files import read_scene

LAWS = {"drag": Drag(0.47), "none": None, "signed": Signed(0.47)}


@functools.cache
def _outcome(name: str, changes: tuple[str, ...]) -> Outcome:
    return run_scene(make_plan(*read_scene(name, changes)))


@pytest.fixture(scope="session")
def outcome() -> Callable[..., Outcome]:
    """Run a scene with changes; each combination runs once a session."""
    return lambda name, *changes: _outcome(name, changes)


@pytest.fixture(scope="session")
def plate_model() -> Callable[..., PlateModel]:
    """Model of the paper's steel plate, or of one that differs in what is given."""

    def build(
        elements: tuple[int, int] = (20, 6),
        reaction: str = "none",
        youngs_modulus: float = 200e9,
        lumping: str = "exact",
        penalty_scale: float = 1.0,
        mesh: Any = None,
        **step: float,
    ) -> PlateModel:
        plate = PlateProperties(0.053, 7800.0, youngs_modulus, 0.3, lumping)
        mesh = mesh or plate_mesh(10.0, 2.438, elements)
        return build_model(mesh, plate, penalty_scale, LAWS[reaction], StepProperties(**step))

    return build


@pytest.fixture
def distorted_mesh() -> Any:
    """The plate with its inner nodes moved by up to a fifth of an element."""
    mesh = plate_mesh(10.0, 2.438, (8, 4))
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    inner = (x > -9.9) & (x < -0.1) & (y > 0.1) & (y < 2.3)
    move = np.random.default_rng(7).uniform(-0.2, 0.2, (inner.sum(), 2)) * [10.0 / 8, 2.438 / 4]
    mesh.points[inner, :2] += move
    return mesh
