"""The highest frequency of a large plate, bounded by windows of it. A plate of congruent elements is a sum of windows,
stiffness and masses alike, and no frequency of the whole is above the highest of its parts (Irons and Treharne, 3rd
Conf. Matrix Methods in Structural Mechanics, 1971, for parts of one element). Windows of some tens of elements have the
highest modes of the whole, which sit at corners and edges or are waves of two elements' length: the bound is close, and
takes milliseconds where Lanczos on the whole, whose highest frequencies crowd, takes minutes.
"""

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from fem.plate.discretisation import Discretisation, ElementTable, Hourglass
from fem.plate.spectrum import FREE, Hold, Spectrum

SIZE = 24
"""Elements along each side of a window, at least, and beside the nodes that are held."""

EVEN = 1e-3
"""Largest relative difference of masses of nodes alike, by the exact inertia, for windows to stand for each other."""

Window = tuple[tuple[int, int], ...]
"""First column and the one behind the last, and rows likewise."""


@dataclass(frozen=True)
class WindowBound:
    """In place of a spectrum: a circular frequency [rad/s] that the highest is not above; and the mode, as
    `Spectrum.mode`, where the window that holds the corner has it: beside that the plate is at rest."""

    frequency: float
    mode: np.ndarray | None

    def stable_time_step(self, damping: Any = None) -> float:
        """Largest stable step [s] of central differences; there is no damping matrix."""
        return 2.0 / self.frequency


class Windows:
    """Parts of a plate of congruent elements, its table of one column.

    masses [kg], shape (nodes,); moduli: plane-stress constants [Pa].
    """

    def __init__(
        self, discretisation: Discretisation, masses: np.ndarray, moduli: Any, hourglass: Hourglass | None
    ) -> None:
        self._nodes = discretisation.table.connectivity
        self._cells = _lattice(discretisation.positions[:, self._nodes])
        self._stiffness = element_stiffness(discretisation.table, moduli, hourglass)
        self._parts, self._surplus = _element_masses(self._nodes, masses)

    @property
    def even(self) -> bool:
        """True if windows stand for each other: elements fill a lattice, and nodes alike have about the same mass."""
        return math.prod(self._cells.max(axis=1) + 1) == self._cells.shape[1] and self._surplus <= 1.0 + EVEN

    def bound(self, hold: Hold = FREE) -> WindowBound:
        """The bound with the plate's corner held like that."""
        touched = self._cells[:, np.isin(self._nodes, hold.nodes).any(axis=0)]
        axes = (_parts(int(rows.max()) + 1, held) for rows, held in zip(self._cells, touched, strict=True))
        kinds: dict[tuple[Any, bool], Window] = {}  # one of each size, and the one that holds the corner
        for window in itertools.product(*axes):
            sizes, holds = tuple(high - low for low, high in window), bool(_inside(touched, window).any())
            kinds[sizes, holds] = window
        bounds = (self._highest(window, hold if holds else FREE) for (_, holds), window in kinds.items())
        return max(bounds, key=lambda bound: bound.frequency)

    def _highest(self, window: Window, hold: Hold) -> WindowBound:
        """The bound of a window, cut out: its elements with their parts of the nodes' masses."""
        elements = self._nodes[:, _inside(self._cells, window)]
        used, local = np.unique(elements, return_inverse=True)
        local = local.reshape(elements.shape)
        masses = np.bincount(local.ravel(), np.repeat(self._parts, elements.shape[1])) / self._surplus
        own = hold._replace(nodes=tuple(np.searchsorted(used, hold.nodes).tolist()))
        spectrum = Spectrum(_assembled(self._stiffness, local, used.size), masses, own)
        mode = np.zeros((2, int(self._nodes.max()) + 1))
        mode[:, used] = spectrum.mode
        return WindowBound(spectrum.bound, mode if hold.nodes else None)


def element_stiffness(table: ElementTable, moduli: Any, hourglass: Hourglass | None = None) -> np.ndarray:
    """Stiffness [N/m] of one of congruent elements: all x unknowns, then all y."""
    gradients = table.gradients.reshape(len(table.weights), -1, 2)
    xx, yy, xy = (
        np.einsum("p,pa,pb->ab", table.weights[:, 0], gradients[:, :, k], gradients[:, :, m])
        for k, m in ((0, 0), (1, 1), (0, 1))
    )
    k_11, k_12 = moduli.c_11 * xx + moduli.c_33 * yy, moduli.c_12 * xy + moduli.c_33 * xy.T
    blocks = np.array([[k_11, k_12], [k_12.T, moduli.c_11 * yy + moduli.c_33 * xx]])
    if hourglass is not None:
        vector, (h_11, h_22, h_12) = hourglass.vectors[:, 0], hourglass.stiffness[:, 0]
        blocks += np.einsum("ij,a,b->ijab", [[h_11, h_12], [h_12, h_22]], vector, vector)
    return blocks.transpose(0, 2, 1, 3).reshape(2 * len(k_11), -1)


def _assembled(stiffness: np.ndarray, nodes: np.ndarray, count: int) -> sp.csr_matrix:
    """Stiffness matrix of elements alike, shape (2 count, 2 count); nodes: shape (nodes per element, elements)."""
    unknowns = np.concatenate([nodes, nodes + count])
    rows, columns = (
        np.broadcast_to(each, (len(stiffness), *unknowns.shape)) for each in (unknowns[:, None], unknowns)
    )
    values = np.broadcast_to(stiffness[:, :, None], rows.shape)
    return sp.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=(2 * count, 2 * count))


def _element_masses(nodes: np.ndarray, masses: np.ndarray) -> tuple[np.ndarray, float]:
    """Masses [kg] of an element's nodes, as they are in the mean; and the factor by which they are at most too large.

    A node's mass is shared by its elements in proportion to these.
    """
    elements = np.bincount(nodes.ravel())
    parts = (masses / elements)[nodes].mean(axis=1)
    whole = np.bincount(nodes.ravel(), np.repeat(parts, nodes.shape[1]))
    return parts, float((whole / masses).max())


def _lattice(positions: np.ndarray) -> np.ndarray:
    """Column and row of each element, shape (2, elements); positions of their nodes [m], shape (2, nodes, elements)."""
    middles, sizes = positions.mean(axis=1), np.ptp(positions[:, :, 0], axis=1)
    return np.rint((middles - middles.min(axis=1)[:, None]) / sizes[:, None]).astype(int)


def _inside(cells: np.ndarray, window: Window) -> np.ndarray:
    """True where elements of these columns and rows, shape (2, elements), lie in the window."""
    return np.all([(low <= row) & (row < high) for row, (low, high) in zip(cells, window, strict=True)], 0)


def _parts(count: int, held: np.ndarray) -> list[tuple[int, int]]:
    """Ends of windows along one axis of so many elements: of at least SIZE, one of them around those that are held."""
    if not held.size:
        return _even(0, count)
    low, high = int(held.min()) - SIZE, int(held.max()) + 1 + SIZE
    low, high = (0 if low < SIZE else low), (count if count - high < SIZE else high)
    return [*_even(0, low), (low, high), *_even(high, count)]


def _even(start: int, end: int) -> list[tuple[int, int]]:
    number = max(1, (end - start) // SIZE)
    ends = [start + (end - start) * k // number for k in range(number + 1)]
    return [each for each in itertools.pairwise(ends) if each[0] < each[1]]
