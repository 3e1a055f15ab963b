"""Processes of the system, and modules that a command imports."""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

HEAVY = (
    *("gmsh", "skfem", "meshio", "vtk", "vtkmodules", "pyvista", "matplotlib", "jinja2"),
    *("scipy.integrate", "scipy.optimize", "scipy.sparse", "dask", "distributed", "pint", "pyarrow"),
    *("scipy.stats", "scipy.special", "rich", "postprocess.svg.chart"),
)


def started(*words, run=subprocess.Popen, env=None, **settings):
    """Start the command of this checkout in a process.

    run: of `subprocess`, with its settings; env: variables besides those of this process.
    """
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)} | (env or {})
    return run([sys.executable, "-m", "tailslap", *words], env=environment, **settings)


def completed(*words, **settings):
    """Run the command to its end, and return its texts."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "timeout": 300.0}
    return started(*words, run=subprocess.run, **pipes | settings)


def imported(*arguments, cwd):
    """Heavy modules that a command imports."""
    code = f"import sys; from tailslap.cli import _status; s = _status({list(arguments)!r})\n"
    code += f"print(s, *[m for m in {HEAVY!r} if m in sys.modules], sep=';')"
    process = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=cwd, check=True
    )
    status, *modules = process.stdout.splitlines()[-1].split(";")
    assert status == "0"
    return set(modules)


def children(pid):
    """Processes that this one has started, and those that they have."""
    processes = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            if int(path.read_text().rpartition(")")[2].split()[1]) == pid:
                processes.append(int(path.parent.name))
    return [*processes, *(below for child in processes for below in children(child))]


def alive(pid):
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    return False
