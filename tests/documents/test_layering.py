"""Verify that imports follow the layers, without circles."""

import importlib
import os
import re
import textwrap
from pathlib import Path

import pytest
import structure

from fem.lazy import defer

ROOT = Path(__file__).parents[2]
PACKAGES = {"solver", "meshes", "machine_code", "fem", "postprocess", "tailslap"}
MOST = 15
MAX_CLIMBS = 4
HEAVY = {"pyvista", "vtk", "vtkmodules", "matplotlib", "jinja2", "meshio", "scipy", "llvmlite"}


STEPS = ("accuracy", "contact", "counting", "instants", "step", "trajectories", "solve", "tyres")
IN_SPACE = (
    "accuracy", "columns", "dynamics", "forces", "motion", "points", "rows", "solve", "step", "stopping", "verdict",
    "wall",
)  # fmt: skip
COMPILED = {
    "postprocess.signals.compiled_filters",
    "solver.rotation",
    *(f"solver.space.{name}" for name in IN_SPACE),
    *(f"solver.impact.{name}" for name in STEPS),
}
"""Modules of compiled steps."""


@pytest.mark.parametrize("package", sorted(PACKAGES - {"tailslap"}))
def test_a_package_stands_alone(package):
    """None imports another, except the compiler and the contact laws.

    The law at one point of fem serves compiled steps of solver.
    """
    for name, imported in structure.import_graph().items():
        if name.split(".")[0] == package:
            foreign = {name for name in imported if name.split(".")[0] != package}
            if package == "fem" or name in COMPILED:
                allowed = ("machine_code", "fem.laws.contact_forces")
                foreign = {name for name in foreign if not name.startswith(allowed)}
            assert not foreign, f"{name} imports {foreign}"


def test_folders_of_fem_import_downward():
    order = ("limit", "laws", "plate", "explicit", "model", "start", "stability", "run")
    level = {folder: height for height, folder in enumerate(order)} | {"modal": order.index("stability")}
    for name, imported in structure.import_graph().items():
        if name.startswith("fem.") and (folder := name.split(".")[1]) in level:
            inner = (name for name in imported if name.startswith("fem.") and name.count(".") > 1)
            folders = {name.split(".")[1] for name in inner}
            assert all(level.get(name, 0) <= level[folder] for name in folders), f"{name}: {sorted(folders)}"


LOADED = {
    "import fem.run.corner": (
        r"fem\..*impact|fem\.laws\.wall_contact|numpy\.f2py\.f2py2e|numpy\.testing\._private\.utils",
        {"fem.explicit.time_loop", "scipy.sparse"},
    ),
    "import tailslap; dir(tailslap)": (r"numpy|pydantic|click|tailslap\.errors", {"tailslap"}),
    "import tailslap; tailslap.rigid('impact-mash-tl4-sut', band=False)": (r"solver\.space.*", {"solver"}),
}
"""Modules that a script does not load, and some that it does."""


@pytest.mark.parametrize("script", LOADED)
def test_a_script_loads_what_it_uses(script, python):
    absent, present = LOADED[script]
    loaded = python(f"import sys; {script}; print(*sys.modules)", check=True, cwd=ROOT).stdout.split()
    assert present <= {*loaded}
    assert [name for name in loaded if re.fullmatch(absent, name)] == []


def test_nothing_imports_the_command_line():
    importing = [name for name, imported in structure.import_graph().items() if "tailslap.cli" in imported]
    assert importing == ["tailslap.__main__"]


def test_no_import_circle():
    """Not within functions, and not for types either."""
    assert structure.circles() == []


def test_no_folder_lists_more_modules_than_one_reads():
    large = {folder: count for folder, count in structure.flat().items() if count > MOST}
    assert not large


def test_importing_postprocess_loads_nothing_heavy(python):
    modules = sorted(name for name in structure.import_graph() if name.split(".")[0] == "postprocess")
    code = f"import sys, {', '.join(modules)}; print(*sys.modules)"
    run = python(code, check=True, cwd=ROOT)
    loaded = {name.split(".")[0] for name in run.stdout.split()}
    assert "numpy" in loaded
    assert not loaded & HEAVY


def test_every_package_says_what_is_in_it():
    packages = [path for path in structure.sources() if path.name == "__init__.py"]
    assert not [path for path in packages if not path.read_text(encoding="utf-8").startswith('"""')]


def test_data_walks_one_way():
    """A run returns from `fem` to `tailslap` at its four decisions alone."""
    _, climbs, meshes = structure.trace()
    assert climbs <= MAX_CLIMBS
    assert meshes == 1


def test_deferred_modules_are_loaded_on_first_use(tmp_path, monkeypatch):
    folder = tmp_path / "idle_package"
    folder.mkdir()
    (folder / "__init__.py").write_text("runs = 0\n")
    (folder / "idle.py").write_text("import idle_package\nidle_package.runs += 1\nvalue = 3\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    defer("idle_package", "idle missing")
    package = importlib.import_module("idle_package")
    idle = package.idle
    assert package.runs == 0
    assert (idle.value, package.runs) == (3, 1)
    defer("idle_package", "idle")
    assert package.idle is idle


@pytest.mark.parametrize("is_stored", [True, False])
def test_templates_are_compiled_by_the_first_process_alone(python, tmp_path, is_stored):
    """Without a folder for bytecode each process compiles them."""
    code = """
        import jinja2
        names, compiled = [], jinja2.Environment.compile
        jinja2.Environment.compile = lambda self, *source: names.append(source[1]) or compiled(self, *source)
        from postprocess.report import page
        page.template("page.html.j2")
        print(*names)
    """
    folder = tmp_path / "bytecode"
    if not is_stored:
        folder.write_text("no folder")
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(folder)}
    first, second = (
        python(textwrap.dedent(code), env=environment, cwd=ROOT, check=True).stdout.split() for _ in range(2)
    )
    assert "page.html.j2" in first
    assert second == ([] if is_stored else first)
