"""Error and process time of this program and of other codes.

    python -m venv others && others/bin/pip install -r benchmarks/requirements.txt
    .venv/bin/python benchmarks/peers.py --others others/bin/python [--table FILE] [--picture FILE]

The scene is `paper-abaqus`: no friction, from 0.26 rad to the tail-slap, where the five quantities are compared with
the exact rigid motion. The other codes run as bare scripts (other_codes) with our mesh, the same time step, the corner
held exactly, row-sum masses, and the unstressed plate in rigid motion, which are theirs to have without further work;
ours as the command, without pictures. Every turn is a process of its own, one after the other, with one thread.

On meshes of 120 elements there are --turns rounds, of 7 680 half as many. A loop that would take longer than --limit
seconds is ended after two, and its time estimated; it has no values. --small has up to 480 elements, --large adds
122 880, a quarter of the rounds, from 0.002 rad, because no code makes the whole event there in two minutes. Five
minutes without that. --table and --picture also write the table and its picture into a file.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import command_line
from plates import interpreter_path, on_one_thread

LARGE_LIMIT_S = 120.0
"""Longest loop of the largest plate [s]."""


def main() -> None:
    """Measure, print, and write the files."""
    from comparison import entries, machine, picture, table

    options = command_line.options(
        __doc__, others=str, turns=3, limit=45.0, large=False, small=False, table=Path, picture=Path
    )
    interpreter = interpreter_path(options.others)
    with tempfile.TemporaryDirectory() as folder:
        meshes = entries.make_meshes(options.large, Path(folder))
        if options.small:
            meshes = [mesh for mesh in meshes if mesh.plate.count <= entries.SMALL]
        rows = entries.rigid_entries(meshes[0].plate, interpreter, options.limit)
        for mesh in meshes:
            limit = LARGE_LIMIT_S if mesh.plate.count >= entries.LARGE else options.limit
            rows += entries.plate_entries(mesh, interpreter, limit)
        head = machine.description()
        entries.run_rounds(rows, options.turns)
    text = table.markdown(rows, head)
    print(text)
    if options.table:
        options.table.write_text(text, encoding="utf-8")
    if options.picture:
        picture.write(rows, options.picture)


if __name__ == "__main__":
    on_one_thread()
    main()
