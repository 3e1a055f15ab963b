"""Natural frequencies and shapes of the free plate in its plane.

    K phi = w^2 M phi        K the model's stiffness, M its lumped masses

The largest eigenvalues of the elastic inverse are found, on motions that are mass-orthogonal to the rigid ones:
shift-invert with the shift at zero. The three rigid modes are not in that space; they are known exactly.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fem.kept import kept
from fem.start.elastic import ElasticSolver, Inverse, rigid_motions


@dataclass(frozen=True)
class FreeModes:
    """Elastic modes by rising frequency, and the rigid ones.

    Attributes
    ----------
    frequencies : ndarray, shape (modes,)
        [rad/s].
    shapes : ndarray, shape (modes, 2, nodes)
        Of unit modal mass, body frame [1/sqrt(kg)].
    rigid : ndarray, shape (3, 2, nodes)
        Two translations and the turn, likewise [1/sqrt(kg)].
    rigid_frequencies : ndarray, shape (3,)
        What the stiffness gives for them, which is rounding [rad/s].
    """

    frequencies: np.ndarray
    shapes: np.ndarray
    rigid: np.ndarray
    rigid_frequencies: np.ndarray


def most_modes(nodes: int) -> int:
    """How many elastic modes can be asked for on a mesh of so many nodes: Lanczos cannot give all."""
    return 2 * nodes - 4


def free_modes(model: Any, count: int) -> FreeModes:
    """The lowest elastic modes of the free plate.

    Parameters
    ----------
    model : PlateModel
        The plate.
    count : int
        How many.

    Returns
    -------
    FreeModes
        Frequencies and shapes.

    Raises
    ------
    ValueError
        For a count that the mesh cannot give.
    """
    elastic = model.elastic
    unit, root = plate_modes(elastic.inverse, count), math.sqrt(elastic.modulus)
    return replace(unit, frequencies=root * unit.frequencies, rigid_frequencies=root * unit.rigid_frequencies)


def plate_modes(plate: Inverse, count: int) -> FreeModes:
    """The lowest `count` elastic modes of the plate with the stiffness that is inverted here."""
    stiffness, masses, positions = plate.stiffness, plate.masses, plate.positions
    nodes = masses.size
    if not 0 <= count <= most_modes(nodes):
        raise ValueError(f"{count} modes were asked for; {nodes} nodes give 0 to {most_modes(nodes)}")
    root = np.sqrt(np.tile(masses, 2))
    body = positions - (positions @ masses / masses.sum())[:, None]
    rigid, _ = np.linalg.qr(root[:, None] * rigid_motions(body))
    shapes = (rigid / root[:, None]).T
    quotients = np.abs(((stiffness @ shapes.T).T * shapes).sum(axis=1))
    values, vectors = _lowest(plate, root, rigid, count)
    return FreeModes(
        frequencies=values,
        shapes=(vectors / root[:, None]).T.reshape(count, 2, nodes),
        rigid=shapes.reshape(3, 2, nodes),
        rigid_frequencies=np.sqrt(quotients),
    )


def lowest_frequency(elastic: ElasticSolver) -> float:
    """Lowest elastic frequency [Hz] of the plate of this solver."""
    find = _lowest_unit_frequency.__wrapped__ if elastic.inverse.is_large else _lowest_unit_frequency
    return math.sqrt(elastic.modulus) * float(find(elastic.inverse)) / (2.0 * math.pi)


@kept("first frequency")
def _lowest_unit_frequency(plate: Inverse) -> float:
    """The same with a modulus of 1 Pa [rad/s]: of a large plate by multigrid, else as `plate_modes`."""
    if plate.is_large:
        from fem.start.multigrid import NotConvergedError

        with suppress(NotConvergedError):
            return math.sqrt(plate.multigrid.lowest_square(plate.masses, _smooth(plate.positions)))
    return float(plate_modes(plate, 1).frequencies[0])


def _smooth(positions: np.ndarray) -> np.ndarray:
    """Displacements that bend the plate along its length and stretch it, shape (2 nodes, 2)."""
    x, y = (positions - positions.mean(axis=1)[:, None]) / np.ptp(positions)
    return np.array([np.concatenate([-2.0 * x * y, x**2]), np.concatenate([x * (1.0 - x**2), 0.0 * y])]).T


def _lowest(plate: Inverse, root: np.ndarray, rigid: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [rad/s] and eigenvectors of M^-1/2 K M^-1/2 beside the rigid ones, shape (2 nodes, count)."""
    from scipy.sparse.linalg import LinearOperator, eigsh

    if not count:
        return np.zeros(0), np.zeros((root.size, 0))
    solve = plate.factorised

    def relieved(vector: np.ndarray) -> np.ndarray:
        return np.asarray(vector - rigid @ (rigid.T @ vector))

    def inverse(vector: np.ndarray) -> np.ndarray:
        return root * solve(root * relieved(vector.ravel()))

    operator = LinearOperator((root.size, root.size), matvec=inverse, dtype=float)
    first = np.cos(1.7 * np.arange(root.size)) + 0.1  # fixed, so that runs repeat to the bit
    compliances, vectors = eigsh(operator, k=count, which="LA", v0=first)
    return 1.0 / np.sqrt(compliances[::-1]), vectors[:, ::-1]
