"""Upper bound of a large plate's highest frequency by windows.

A plate of congruent elements is a sum of windows, in stiffness and in masses, and no frequency of the whole is above
the highest of its parts (Irons and Treharne, 3rd Conf. Matrix Methods in Structural Mechanics, 1971, for parts of one
element). Windows of some tens of elements have the highest modes of the whole, which are localised at corners and
edges or are waves of two elements' length. The bound is therefore close. It takes milliseconds, where Lanczos on the
whole plate, whose highest frequencies are close together, takes minutes.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from fem.laws.materials import StVenantKirchhoff
from fem.plate.discretisation import Discretisation, Hourglass, hourglass_matrix, stiffness_matrix
from fem.plate.spectrum import FREE, Spectrum
from fem.plate.support import Support

SIZE = 24
"""Smallest number of elements along each side of a window, and beside supported nodes."""

MASS_SPREAD = 1e-3
"""Largest relative spread of the masses of nodes in equal positions, by the exact inertia.

Up to it one window represents all of its size.
"""

Window = tuple[tuple[int, int], ...]
"""First column and the one behind the last, and the same of the rows."""


@dataclass(frozen=True)
class WindowBound:
    """Upper bound of the highest circular frequency, in place of a spectrum.

    frequency: [rad/s]. mode: as `Spectrum.mode`, where the window at the corner has the highest frequency; zero
    outside that window.
    """

    frequency: float
    mode: np.ndarray | None

    def stable_time_step(self, damping: None = None) -> float:
        """Return the largest stable step [s] of central differences.

        There is no damping matrix.
        """
        return 2.0 / self.frequency


class Windows:
    """Windows of a plate of congruent elements, whose table has one column.

    masses [kg], shape (nodes,); moduli: plane-stress constants [Pa].
    """

    def __init__(
        self,
        discretisation: Discretisation,
        masses: np.ndarray,
        moduli: StVenantKirchhoff,
        hourglass: Hourglass | None,
    ) -> None:
        self._nodes = discretisation.table.connectivity
        self._cells = _lattice(discretisation.positions[:, self._nodes])
        self._table, self._moduli, self._hourglass = discretisation.table, moduli, hourglass
        self._parts, self._surplus = _element_masses(self._nodes, masses)

    @property
    def are_representative(self) -> bool:
        """True if one window represents all of its size.

        The elements fill a lattice, and nodes in equal positions have nearly equal masses.
        """
        return (
            math.prod(self._cells.max(axis=1) + 1) == self._cells.shape[1]
            and self._surplus <= 1.0 + MASS_SPREAD
        )

    def bound(self, support: Support = FREE) -> WindowBound:
        """Return the bound of the plate with this support."""
        supported = self._cells[:, np.isin(self._nodes, support.nodes).any(axis=0)]
        axes = (
            _window_ends(int(rows.max()) + 1, held) for rows, held in zip(self._cells, supported, strict=True)
        )
        kinds: dict[
            tuple[tuple[int, ...], bool], Window
        ] = {}  # one of each size, and the one with the corner
        for window in itertools.product(*axes):
            sizes, has_support = (
                tuple(high - low for low, high in window),
                bool(_inside(supported, window).any()),
            )
            kinds[sizes, has_support] = window
        bounds = (
            self._highest(window, support if has_support else FREE)
            for (_, has_support), window in kinds.items()
        )
        return max(bounds, key=lambda bound: bound.frequency)

    def _highest(self, window: Window, support: Support) -> WindowBound:
        """Return the bound of one window.

        Its elements have their parts of the masses of the nodes.
        """
        elements = self._nodes[:, _inside(self._cells, window)]
        used, local = np.unique(elements, return_inverse=True)
        local = local.reshape(elements.shape)
        masses = np.bincount(local.ravel(), np.repeat(self._parts, elements.shape[1])) / self._surplus
        local_support = support._replace(nodes=tuple(np.searchsorted(used, support.nodes).tolist()))
        table = self._table._replace(connectivity=local)
        stiffness = stiffness_matrix(table, self._moduli)
        if self._hourglass is not None:
            stiffness = stiffness + hourglass_matrix(table, self._hourglass, used.size)
        spectrum = Spectrum(stiffness, masses, local_support)
        mode = np.zeros((2, int(self._nodes.max()) + 1))
        mode[:, used] = spectrum.mode
        return WindowBound(spectrum.bound, mode if support.nodes else None)


def _element_masses(nodes: np.ndarray, masses: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the mean masses [kg] of the nodes of an element.

    Also returns the largest factor by which they are too large. A node's mass is distributed to its elements in
    proportion to them.
    """
    elements = np.bincount(nodes.ravel())
    parts = (masses / elements)[nodes].mean(axis=1)
    whole = np.bincount(nodes.ravel(), np.repeat(parts, nodes.shape[1]))
    return parts, float((whole / masses).max())


def _lattice(positions: np.ndarray) -> np.ndarray:
    """Return column and row of each element, shape (2, elements).

    positions: of the nodes of the elements [m], shape (2, nodes, elements).
    """
    middles, sizes = positions.mean(axis=1), np.ptp(positions[:, :, 0], axis=1)
    return np.rint((middles - middles.min(axis=1)[:, None]) / sizes[:, None]).astype(int)


def _inside(cells: np.ndarray, window: Window) -> np.ndarray:
    """Return True for elements in the window.

    cells: their columns and rows, shape (2, elements).
    """
    return np.all([(low <= row) & (row < high) for row, (low, high) in zip(cells, window, strict=True)], 0)


def _window_ends(count: int, supported: np.ndarray) -> list[tuple[int, int]]:
    """Return the ends of windows along an axis of `count` elements.

    Each has at least SIZE elements, and one of them surrounds the supported elements.
    """
    if not supported.size:
        return _even_ends(0, count)
    low, high = int(supported.min()) - SIZE, int(supported.max()) + 1 + SIZE
    low, high = (0 if low < SIZE else low), (count if count - high < SIZE else high)
    return [*_even_ends(0, low), (low, high), *_even_ends(high, count)]


def _even_ends(start: int, end: int) -> list[tuple[int, int]]:
    """Return the ends of windows of similar size."""
    number = max(1, (end - start) // SIZE)
    ends = [start + (end - start) * k // number for k in range(number + 1)]
    return [window for window in itertools.pairwise(ends) if window[0] < window[1]]
