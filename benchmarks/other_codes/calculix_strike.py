"""Both strikes of a steel plate in CalculiX, beside this program's."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import command_line
import numpy as np

import tailslap
from meshes import plate_mesh
from postprocess.comparison.nodal import centre_of_mass_history, read_calculix

LENGTH, WIDTH, THICKNESS, MASS = 10.0, 2.438, 0.053, 9979.0
SPEED, ANGLE = 56.0 * 0.44704, np.radians(15.0)
FIRST, FLIGHT, SECOND = 0.012, 0.202, 0.026
"""Durations of the steps [s]."""
WALL = [(x, y, z) for z in (-0.3, 0.4) for x, y in ((-11.0, -0.5), (9.0, -0.5), (9.0, 0.0), (-11.0, 0.0))]
CHANGES = ("contact.stiffness=", "contact.restitution=", "contact.friction=0", "contact.enforcement=exact")


def deck(places: np.ndarray, cells: np.ndarray, side: np.ndarray, step: float, penalty: float) -> str:
    """Input file of nodes [m], shape (nodes, 2), and of contact nodes."""
    n = len(places)
    wall = range(2 * n + 1, 2 * n + 9)
    layers = [(k + 1 + z * n, x, y, z * THICKNESS) for z in (0, 1) for k, (x, y) in enumerate(places)]
    speed = SPEED * np.cos(ANGLE), -SPEED * np.sin(ANGLE)
    density = MASS / (LENGTH * WIDTH * THICKNESS)
    lines = ["*NODE, NSET=PLATE", *(f"{k}, {x:.12g}, {y:.12g}, {z}" for k, x, y, z in layers)]
    lines += ["*NODE, NSET=WALL", *(f"{k}, {x}, {y}, {z}" for k, (x, y, z) in zip(wall, WALL, strict=True))]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=VEHICLE"]
    lines += [", ".join(map(str, [k, *cell, *(cell + n)])) for k, cell in enumerate(cells + 1, 1)]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=BLOCK", ", ".join(map(str, [len(cells) + 1, *wall]))]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "2e11, 0.3", "*DENSITY", f"{density:.12g}"]
    lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=STEEL" for name in ("VEHICLE", "BLOCK")]
    lines += ["*INITIAL CONDITIONS, TYPE=VELOCITY"]
    lines += [f"PLATE, {axis}, {value:.12g}" for axis, value in enumerate(speed, 1)]
    lines += ["*SURFACE, NAME=SIDE, TYPE=NODE", *(f"{k + 1 + z * n}" for k in side for z in (0, 1))]
    lines += ["*SURFACE, NAME=FACE", "BLOCK, S5", "*SURFACE INTERACTION, NAME=HARD"]
    lines += ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{penalty:g}, 1."]
    lines += ["*CONTACT PAIR, INTERACTION=HARD, TYPE=NODE TO SURFACE", "SIDE, FACE"]
    lines += ["*BOUNDARY", "WALL, 1, 3", *(f"{k}, 3, 3" for k in range(1, n + 1))]
    for increment, duration in ((step, FIRST), (1e-3, FLIGHT), (step, SECOND)):
        lines += ["*STEP, NLGEOM, INC=1000000", "*DYNAMIC, DIRECT, ALPHA=-0.05", f"{increment}, {duration}"]
        lines += ["*NODE PRINT, NSET=PLATE, FREQUENCY=10", "U, V", "*END STEP"]
    return "\n".join(lines) + "\n"


def in_calculix(elements: tuple[int, int], step: float, penalty: float) -> dict[str, np.ndarray]:
    """Motion of the centre of mass."""
    mesh = plate_mesh(LENGTH, WIDTH, elements)
    cosine, sine = np.cos(ANGLE), np.sin(ANGLE)
    places = mesh.points[:, :2] @ np.array([[cosine, -sine], [sine, cosine]])
    cells = mesh.cells_dict["quad"]
    masses = np.bincount(cells.ravel(), minlength=len(places)) * MASS / cells.size / 2
    side = np.flatnonzero(np.abs(mesh.points[:, 1]) < 1e-9)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "strike.inp").write_text(deck(places, cells, side, step, penalty))
        subprocess.run(["ccx", "strike"], cwd=folder, check=True, capture_output=True)
        nodes = read_calculix(Path(folder) / "strike.dat")
    both = np.tile(places, (2, 1)), np.tile(masses, 2)
    return centre_of_mass_history(*both, nodes.t, nodes.displacements, nodes.velocities)


def main() -> None:
    """Print both."""
    options = command_line.options(__doc__, elements=(20, 6), step=2e-5, penalty=1e12)
    other = in_calculix(tuple(options.elements), options.step, options.penalty)
    mesh = f"plate.elements=[{options.elements[0]},{options.elements[1]}]"
    changes = (*CHANGES, mesh, "verify.companion=false", "time.end=0.25 s")
    vehicle = tailslap.run(Path(__file__).parents[2] / "examples" / "linear-truck.toml", changes).history
    for words, t in (("first strike", FIRST), ("both strikes", FIRST + FLIGHT + SECOND)):
        states = [[np.interp(t, h["t"], h[name]) for name in ("v_gy", "omega")] for h in (other, vehicle)]
        (impulse, spin), (ours, turn) = [(MASS * (v + SPEED * np.sin(ANGLE)), w) for v, w in states]
        print(f"{words}: {impulse:.0f} N s, {spin:.4f} rad/s; ratios {impulse / ours:.4f}, {spin / turn:.4f}")


if __name__ == "__main__":
    main()
