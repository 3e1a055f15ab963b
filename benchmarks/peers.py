"""Error and process time of this program and of other codes on one plate.

    python -m venv others && others/bin/pip install -r benchmarks/requirements.txt
    .venv/bin/python benchmarks/peers.py --others others/bin/python [--table FILE] [--picture FILE]

The scene is `paper-abaqus`: no friction, from 0.26 rad to the tail-slap, where the five quantities are compared with
the exact rigid motion. The other codes run as bare scripts (other_codes) with our mesh, the same time step, the corner
held exactly, row-sum masses, and the unstressed plate in rigid motion, which are theirs to have without further work;
ours as the command, without pictures. Every turn is a process of its own, one after the other, with one thread.

On meshes of 120 elements there are --turns rounds, of 7 680 half as many. A loop that would take longer than --limit
seconds is ended after two, and its time estimated; it has no values. --large adds 122 880 elements, a quarter of
the rounds, from 0.002 rad, because no code makes the whole event there in two minutes. Five minutes without that.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

import command_line
from plates import ONE_THREAD, interpreter_path

LARGE_LIMIT_S = 120.0
"""Longest loop of the largest plate [s]."""


def main() -> None:
    """Measure, print, and write what is asked for."""
    parser = command_line.parser(__doc__)
    parser.add_argument(
        "--others",
        metavar="PYTHON",
        type=interpreter_path,
        help="interpreter that has Akantu, Kratos, Warp, Exudyn",
    )
    parser.add_argument("--turns", type=int, default=3, help="rounds in which everything is measured in turn")
    parser.add_argument("--limit", type=float, default=45.0, help="longest loop of 7 680 elements [s]")
    parser.add_argument(
        "--large", action="store_true", help="also 122 880 elements, at most two minutes each"
    )
    parser.add_argument("--small", action="store_true", help="no more than 480 elements")
    parser.add_argument("--table", type=Path, metavar="FILE", help="also write the table as Markdown")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="also draw it, as SVG")
    compare(parser.parse_args())


def compare(given: argparse.Namespace) -> None:
    """Measure all, print the table, write the files."""
    from comparison import entries, machine, picture, table

    with tempfile.TemporaryDirectory() as folder:
        meshes = entries.make_meshes(given.large, Path(folder))
        if given.small:
            meshes = [mesh for mesh in meshes if mesh.plate.count <= entries.SMALL]
        rows = entries.rigid_entries(meshes[0].plate, given.others, given.limit)
        for mesh in meshes:
            limit = LARGE_LIMIT_S if mesh.plate.count >= entries.LARGE else given.limit
            rows += entries.plate_entries(mesh, given.others, limit)
        head = machine.description()
        entries.run_rounds(rows, given.turns)
    print(f"{head}\n\n{table.terminal_text(rows)}")
    if given.table:
        given.table.write_text(table.markdown(rows, head), encoding="utf-8")
    if given.picture:
        picture.write(rows, given.picture)


if __name__ == "__main__":
    if any(os.environ.get(name) != value for name, value in ONE_THREAD.items()):
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | ONE_THREAD)
    main()
