"""Free modes of the plate and its lowest elastic frequency.

    K phi = w^2 M phi        K the model's stiffness, M its lumped masses

The largest eigenvalues of the elastic inverse are computed, on motions that are mass-orthogonal to the rigid ones, by
shift and invert with the shift at zero. The three rigid modes, which are not in that space, are known exactly.
"""

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fem.cache import cached
from fem.plate.elastic import ElasticSolver, Inverse
from fem.plate.lanczos import fixed_vector
from fem.plate.multigrid import NotConvergedError


@dataclass(frozen=True)
class FreeModes:
    """Elastic modes by rising frequency, and rigid modes.

    Attributes
    ----------
    frequencies : ndarray, shape (modes,)
        Circular frequencies [rad/s].
    shapes : ndarray, shape (modes, 2, nodes)
        Shapes of unit modal mass, body frame [1/sqrt(kg)].
    rigid : ndarray, shape (3, 2, nodes)
        Two translations and the rotation, of unit modal mass [1/sqrt(kg)]; of a train a rotation more for each hinge.
    rigid_frequencies : ndarray, shape (3,)
        Frequencies of the rigid modes by the stiffness, which are rounding [rad/s].
    """

    frequencies: np.ndarray
    shapes: np.ndarray
    rigid: np.ndarray
    rigid_frequencies: np.ndarray


def most_modes(nodes: int) -> int:
    """Return the largest number of elastic modes on a mesh.

    Lanczos cannot compute all modes of the nodes.
    """
    return 2 * nodes - 4


def free_modes(model: Any, count: int) -> FreeModes:
    """Return the lowest elastic modes of the free plate.

    Parameters
    ----------
    model : PlateModel
        The plate.
    count : int
        Number of modes.

    Returns
    -------
    FreeModes
        Frequencies and shapes.

    Raises
    ------
    ValueError
        For a count that the mesh cannot have.
    """
    elastic = model.elastic
    unit, root = plate_modes(elastic.inverse, count), math.sqrt(elastic.modulus)
    return replace(unit, frequencies=root * unit.frequencies, rigid_frequencies=root * unit.rigid_frequencies)


def plate_modes(plate: Inverse, count: int) -> FreeModes:
    """Return the lowest elastic modes of the plate of this inverse."""
    stiffness, masses = plate.stiffness, plate.masses
    nodes = masses.size
    if not 0 <= count <= most_modes(nodes):
        raise ValueError(f"{count} modes are requested; {nodes} nodes allow 0 to {most_modes(nodes)}")
    root = np.sqrt(np.tile(masses, 2))
    rigid, _ = np.linalg.qr(root[:, None] * plate.rigid)
    shapes = (rigid / root[:, None]).T
    quotients = np.abs(((stiffness @ shapes.T).T * shapes).sum(axis=1))
    values, vectors = _lowest(plate, root, rigid, count)
    return FreeModes(
        frequencies=values,
        shapes=(vectors / root[:, None]).T.reshape(count, 2, nodes),
        rigid=shapes.reshape(-1, 2, nodes),
        rigid_frequencies=np.sqrt(quotients),
    )


def lowest_frequency(elastic: ElasticSolver) -> float:
    """Return the lowest elastic frequency [Hz] of the plate of a solver."""
    unit_frequency = (
        _lowest_unit_frequency.__wrapped__ if elastic.inverse.is_large else _lowest_unit_frequency
    )
    return math.sqrt(elastic.modulus) * unit_frequency(elastic.inverse) / (2.0 * math.pi)


@cached
def _lowest_unit_frequency(plate: Inverse) -> float:
    """Return the lowest elastic frequency for a modulus of 1 Pa [rad/s].

    It comes from multigrid for a large plate, else from `plate_modes`.
    """
    if plate.is_large:
        with suppress(NotConvergedError):
            return math.sqrt(plate.multigrid.lowest_square(plate.masses, _smooth(plate.positions)))
    return float(plate_modes(plate, 1).frequencies[0])


def _smooth(positions: np.ndarray) -> np.ndarray:
    """Return displacements near to the lowest modes, shape (2 nodes, 2).

    They bend the plate along its length and stretch it.
    """
    x, y = (positions - positions.mean(axis=1)[:, None]) / np.ptp(positions)
    return np.array([np.concatenate([-2.0 * x * y, x**2]), np.concatenate([x * (1.0 - x**2), 0.0 * y])]).T


def _lowest(plate: Inverse, root: np.ndarray, rigid: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest elastic frequencies and eigenvectors.

    Frequencies [rad/s]; vectors of M^-1/2 K M^-1/2 orthogonal to the rigid ones, shape (2 nodes, count).
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    if not count:
        return np.zeros(0), np.zeros((root.size, 0))
    solve = plate.factorised

    def elastic_part(vector: np.ndarray) -> np.ndarray:
        return np.asarray(vector - rigid @ (rigid.T @ vector))

    def inverse(vector: np.ndarray) -> np.ndarray:
        return root * solve(root * elastic_part(vector.ravel()))

    operator = LinearOperator((root.size, root.size), matvec=inverse, dtype=float)
    compliances, vectors = eigsh(operator, k=count, which="LA", v0=fixed_vector(root.size))
    return 1.0 / np.sqrt(compliances[::-1]), vectors[:, ::-1]
