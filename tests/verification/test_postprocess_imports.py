"""Verification: postprocess stands alone, and importing it loads no picture, plot or template library."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import postprocess

pytestmark = pytest.mark.verification

FOLDER = Path(postprocess.__file__).parent
MODULES = sorted(path.stem for path in FOLDER.glob("*.py") if path.stem != "__init__")
HEAVY = {"pyvista", "vtk", "vtkmodules", "matplotlib", "jinja2", "meshio", "scipy", "numba"}
OTHERS = {"fem", "solver", "meshes", "tailslap"}


def imported(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add((node.module or "").split(".")[0])
    return names


@pytest.mark.parametrize("module", MODULES)
def test_no_other_package_of_the_program_is_imported(module: str) -> None:
    assert not imported(FOLDER / f"{module}.py") & OTHERS


def test_importing_every_module_loads_nothing_heavy() -> None:
    code = f"import sys, {', '.join(f'postprocess.{m}' for m in MODULES)}; print(*sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=FOLDER.parent
    )
    loaded = {name.split(".")[0] for name in run.stdout.split()}
    assert "numpy" in loaded
    assert not loaded & (HEAVY | OTHERS)
