"""Histories of the nodes of another program, and the motion of the centre of mass that follows from them.

CalculiX prints with `*NODE PRINT` a block of lines per quantity and instant to its file `.dat`. Positions and masses of
the nodes stand in `nodes.csv` beside it, with the columns node, x, y [m] and mass [kg]; Z is not considered.
"""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

Blocks = dict[float, dict[int, list[float]]]
"""Values along X and Y by instant and node."""

NODES = "nodes.csv"
HEAD = re.compile(r"\s*(displacements|velocities) \(vx,vy,vz\) for set (\S+) and time\s+(\S+)\s*")


@dataclass(frozen=True)
class NodalHistory:
    """Motion of nodes.

    Attributes
    ----------
    numbers : ndarray, shape (nodes,)
        Their numbers, rising.
    t : ndarray, shape (instants,)
        [s].
    displacements, velocities : ndarray, shape (instants, nodes, 2)
        [m], [m/s].
    """

    numbers: NDArray[np.int64]
    t: Floats
    displacements: Floats
    velocities: Floats


def read_calculix(path: Path) -> NodalHistory:
    """Read displacements and velocities of the nodes from a file `.dat` of CalculiX.

    Raises OSError, and ValueError for a file that is cut short, or without one of the two.
    """
    blocks: dict[str, Blocks] = {"displacements": {}, "velocities": {}}
    block: dict[int, list[float]] | None = None
    with open(path, encoding="ascii", errors="replace") as lines:
        for number, line in enumerate(lines, 1):
            if head := HEAD.fullmatch(line):
                block = blocks[head[1]].setdefault(float(head[3]), {})
            elif (cells := line.split()) and not cells[0].isdigit():
                block = None
            elif cells and block is not None:
                try:
                    x, y, _ = map(float, cells[1:])
                    block[int(cells[0])] = [x, y]
                except ValueError:
                    raise ValueError(f"line {number} is cut short: {line.strip()!r}") from None
    displacements, velocities = blocks["displacements"], blocks["velocities"]
    if not velocities or not displacements:
        raise ValueError(
            "it has no displacements or no velocities of nodes; print both by *NODE PRINT, U and V"
        )
    if displacements.keys() != velocities.keys():
        t = max(displacements.keys() ^ velocities.keys())
        raise ValueError(f"it is cut short: displacements or velocities are missing at {t:g} s")
    return _stacked(displacements, velocities)


def _stacked(displacements: Blocks, velocities: Blocks) -> NodalHistory:
    """Arrays of blocks by time and node. Raises ValueError where nodes are missing at an instant."""
    times, numbers = sorted(velocities), sorted(next(iter(displacements.values())))
    for blocks in (displacements, velocities):
        for t in times:
            if missing := set(numbers) ^ blocks[t].keys():
                raise ValueError(f"it is cut short: {len(missing)} nodes are missing at {t:g} s")
    stacked = (
        np.array([[blocks[t][n] for n in numbers] for t in times]) for blocks in (displacements, velocities)
    )
    return NodalHistory(np.array(numbers), np.array(times), *stacked)


def read_nodes(path: Path) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Read numbers, positions [m], shape (nodes, 2), and masses [kg] of the nodes, in rising order.

    Raises OSError, and ValueError for a file without the columns node, x, y and mass.
    """
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    try:
        numbers = np.array([int(row["node"]) for row in rows])
        values = np.array([[float(row[name]) for name in ("x", "y", "mass")] for row in rows]).reshape(-1, 3)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path.name} must have the columns node, x, y and mass: {error}") from None
    order = np.argsort(numbers)
    return numbers[order], values[order, :2], values[order, 2]


def centre_of_mass_history(
    nodes: Floats, masses: Floats, times: Floats, displacements: Floats, velocities: Floats
) -> dict[str, Floats]:
    """Compute the motion of the centre of mass of nodes in the plane.

    Parameters
    ----------
    nodes : ndarray, shape (nodes, 2 or more)
        Initial positions [m].
    masses : ndarray, shape (nodes,)
        [kg].
    times : ndarray, shape (instants,)
        [s].
    displacements, velocities : ndarray, shape (instants, nodes, 2 or more)
        [m], [m/s].

    Returns
    -------
    dict of ndarray, shape (instants,)
        "t" [s]; "x_g", "y_g" [m]; "v_gx", "v_gy" [m/s], momentum over mass; "omega" [rad/s], spin about the centre of
        mass over its moment of inertia; "rotation" [rad], of the rigid motion that fits best by mass, counter-clockwise
        from the initial positions.
    """
    fraction = masses / masses.sum()
    place = nodes[:, :2] + displacements[..., :2]
    centre, mean = fraction @ place, fraction @ velocities[..., :2]
    arm, rate = place - centre[:, None], velocities[..., :2] - mean[:, None]
    start = nodes[:, :2] - fraction @ nodes[:, :2]
    spin = (arm[..., 0] * rate[..., 1] - arm[..., 1] * rate[..., 0]) @ fraction
    turned = (start[:, 0] * arm[..., 1] - start[:, 1] * arm[..., 0]) @ fraction
    aligned = (start[:, 0] * arm[..., 0] + start[:, 1] * arm[..., 1]) @ fraction
    return {
        "t": times,
        "x_g": centre[:, 0],
        "y_g": centre[:, 1],
        "v_gx": mean[:, 0],
        "v_gy": mean[:, 1],
        "omega": spin / ((arm**2).sum(axis=-1) @ fraction),
        "rotation": np.unwrap(np.arctan2(turned, aligned)),
    }


def read_centre_of_mass(path: Path) -> dict[str, Floats]:
    """Read a file `.dat` of CalculiX, with `nodes.csv` beside it, as columns of `centre_of_mass_history`.

    Raises OSError, and ValueError for damaged files and for nodes that are missing in one of the two.
    """
    if not path.with_name(NODES).is_file():
        raise ValueError(f"positions and masses of its nodes, in {NODES} beside it, are missing")
    numbers, nodes, masses = read_nodes(path.with_name(NODES))
    found = read_calculix(path)
    if missing := sorted(set(numbers.tolist()) ^ set(found.numbers.tolist())):
        shown = ", ".join(map(str, missing[:5])) + (", ..." if missing[5:] else "")
        raise ValueError(f"nodes that are in one of {path.name} and {NODES} only: {shown}")
    return centre_of_mass_history(nodes, masses, found.t, found.displacements, found.velocities)
