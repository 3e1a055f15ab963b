"""Verify links, commands and citation of the documents, and the examples."""

import functools
import importlib
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from unittest import mock

import click
import pytest

import tailslap
from fem import FRICTION_LAWS
from tailslap import cli, errors
from tailslap.scene.read import read_scene

ROOT = Path(__file__).parents[2]
SHOWN = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
DOCUMENTS = [*SHOWN, ROOT / "ARCHITECTURE.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
COMMAND = re.compile(r"(?:\.venv/bin/)?tailslap( [^`\n]+)?")
QUOTED = re.compile(r"`([^`\n]+)`")
FILE = re.compile(r"[\w./-]*\w\.(?:py|md|toml|txt|css|j2|cff)")
STAND_INS = {"SHELL": "bash", "X": "0.5", "FORMAT": "vtkhdf", "N": "20", "--samples N": "1000"}
"""Values for the placeholders of a synopsis; others are accepted as they stand."""


def below(paths):
    """Paths below the checkout, for the cases of a test."""
    return [str(path.relative_to(ROOT)) for path in paths]


def prose_and_blocks(text):
    """The text without blocks of code, and the lines of blocks."""
    lines: list[str] = []
    prose: list[str] = []
    fenced = False
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif fenced or line.startswith("    "):
            lines.append(line.strip())
        else:
            prose.append(line)
    return "\n".join(prose), lines


def command_lines(path):
    """Each `tailslap ...` of a document, in blocks or between backticks."""
    prose, lines = prose_and_blocks(path.read_text(encoding="utf-8"))
    parts = [part for line in lines for part in line.split(" && ")] + QUOTED.findall(prose)
    return {" ".join(text.split()) for text in parts if COMMAND.fullmatch(text.strip())}


def anchors(path):
    """Return the names behind "#" that GitHub derives from the headings."""
    headings = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading).strip().lower().replace(" ", "-") for heading in headings}


def broken_links(path):
    """Relative links of a document to absent files or headings."""
    broken = []
    for link in LINK.findall(path.read_text(encoding="utf-8")):
        name, _, anchor = link.partition("#")
        target = path.parent / name if name else path
        if "://" not in link and (not target.exists() or (anchor and anchor not in anchors(target))):
            broken.append(link)
    return broken


def accept(line):
    """Parse a command line, and read a scene with its changes."""
    words = shlex.split(line.replace("[", "").replace("]", "").replace("...", ""))[1:]
    words = [
        STAND_INS.get(f"{a} {b}", STAND_INS.get(b, b)) for a, b in zip(["", *words], words, strict=False)
    ]
    command: click.Command = cli.commands
    while words and isinstance(command, click.Group) and not words[0].startswith("-"):
        subcommand = command.get_command(click.Context(command), words[0])
        assert subcommand is not None, f"{line}: there is no command {words[0]}"
        command, words = subcommand, words[1:]
    if not words:
        return  # the command is only mentioned
    parameters = command.make_context(command.name, list(words)).params
    scene = parameters.get("name", "SCENE")
    if scene != "SCENE" and command.name != "new" and not scene.endswith(".toml"):  # those: test_site.py
        read_scene(scene, tuple(parameters.get("changes", ())))


@functools.cache
def files_of_the_checkout():
    """Paths of its files from its root, without hidden folders."""
    folders = (path for path in ROOT.iterdir() if path.is_dir() and not path.name.startswith("."))
    files = (path for folder in folders for path in folder.rglob("*.*"))
    return ["/" + str(path.relative_to(ROOT)) for path in (*files, *ROOT.glob("*.*"))]


def missing_files(text):
    """File names between backticks that are not in the checkout."""
    files = files_of_the_checkout()
    named = (name for name in QUOTED.findall(text) if FILE.fullmatch(name))
    return [name for name in named if not any(path.endswith("/" + name) for path in files)]


def test_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 120


@pytest.mark.parametrize("name", below(DOCUMENTS))
def test_links_lead_somewhere(name):
    assert broken_links(ROOT / name) == []


@pytest.mark.parametrize("name", [name for name in below(SHOWN) if "reference/" not in name])
def test_commands_are_accepted(name):
    for line in command_lines(ROOT / name):
        try:
            accept(line)
        except (click.ClickException, errors.InputError) as error:
            pytest.fail(f"{line}: {error}")


def test_every_command_is_in_the_readme():
    names = {word for line in command_lines(ROOT / "README.md") for word in line.split()[1:2]}
    assert {*cli.commands.commands} <= names


@pytest.mark.parametrize("name", below(DOCUMENTS[:-1]))
def test_files_named_exist(name):
    assert missing_files((ROOT / name).read_text(encoding="utf-8")) == []


def test_every_page_is_linked_from_the_readme():
    all_links = LINK.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    links = {link.partition("#")[0] for link in all_links}
    assert {str(page.relative_to(ROOT)) for page in (ROOT / "docs").glob("*.md")} <= links


def test_every_promise_has_its_test():
    lines = (ROOT / "docs" / "promises.md").read_text(encoding="utf-8").splitlines()
    rows = [line for line in lines if line.startswith("| ")][1:]  # without the heading
    assert len(rows) > 15
    for row in rows:
        path, _, name = row.rstrip("| ").rpartition("| ")[2].strip("`").partition("::")
        text = (ROOT / path).read_text(encoding="utf-8")
        assert not name or f"def {name}(" in text, row
        assert name == "" or ("(long)" in row) == is_long(text, name), row


def is_long(text, name):
    """Whether all of a test is marked long."""
    above = text.partition(f"def {name}(")[0].rpartition("\n\n\n")[2]
    return "@pytest.mark.long\n" in above


def test_the_citation_is_of_this_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert f"\nversion: {tailslap.__version__}\n" in citation
    assert f"\nlicense: {project['license']}\n" in citation
    assert "doi: 10.3390/infrastructures10110307" in citation


def test_every_package_is_typed():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    packages = project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    assert all((ROOT / package / "py.typed").is_file() for package in packages)


@pytest.mark.parametrize("line", [
    "tailslap walk SCENE", "tailslap run SCENE --quick", "tailslap run SCENE --tolerance SMALL",
    "tailslap run mash-tl9", "tailslap run mash-tl4-sut --set plate.colour=red",
    "tailslap study colour SCENE",
])  # fmt: skip
def test_wrong_commands_are_noticed(line):
    with pytest.raises((AssertionError, click.ClickException, errors.InputError)):
        accept(line)


def test_wrong_links_and_files_are_noticed(tmp_path):
    page = tmp_path / "page.md"
    links = "[a](page.md#one-thing) [b](page.md#two) [c](none.md) [d](https://example.org)"
    page.write_text(f"# One thing\n{links}")
    assert broken_links(page) == ["page.md#two", "none.md"]
    named = "`machine_code/compiled.py` `compiled.py` `fem/none.py` `text`"
    assert missing_files(named) == ["fem/none.py"]


FOLDER = Path(__file__).parents[2] / "examples"
EXAMPLES = sorted(path.name for path in FOLDER.glob("*.py"))
LONG = {"own_vehicle_and_law.py"}
"""A law from outside requires loops of its own."""

WRITTEN = {"compare_with_csv.py": {"compared.png"}, "run_and_plot.py": {"history.png", "field.png"}}
WRITTEN |= {"sweep_friction.py": {"peak-force.png"}, "forces_of_own_truck.py": {"force.png"}}
"""Files that an example saves; others none."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] if name in LONG else []) for name in EXAMPLES]
)
def test_it_runs(name, tmp_path, monkeypatch, capsys):
    """It asserts its claims, and writes the named files alone."""
    place = shutil.copytree(FOLDER, tmp_path / "examples", ignore=shutil.ignore_patterns("__pycache__"))
    before = {*place.iterdir()}
    monkeypatch.chdir(place)
    with mock.patch.dict(FRICTION_LAWS):
        runpy.run_path(name, run_name="__main__")
    assert len(capsys.readouterr().out.splitlines()) > 3
    written = {*place.iterdir()} - before
    assert {path.name for path in written} == WRITTEN.get(name, set())
    assert all(path.stat().st_size > 5000 for path in written)


@pytest.mark.parametrize("name", EXAMPLES)
def test_it_opens_as_a_notebook(name):
    """Cells of Jupytext's percent form compile separately."""
    head, *cells = (FOLDER / name).read_text(encoding="utf-8").split("\n# %%")
    assert "format_name: percent" in head
    kinds = {"text": 0, "code": 0}
    for cell in cells:
        title, _, body = cell.partition("\n")
        if title == " [markdown]":
            assert all(line.startswith("#") for line in body.splitlines() if line.strip())
            kinds["text"] += 1
        else:
            assert title == ""
            compile(body, name, "exec")
            kinds["code"] += 1
    assert min(kinds.values()) >= 2


@pytest.mark.long
@pytest.mark.parametrize("command", [(sys.executable, "-m", "mypy", "--strict"), ("pyright",)])
def test_type_checkers_accept_it(command, tmp_path):
    """They see the package as installed, without its settings of mypy."""
    if not shutil.which(command[0]):
        pytest.skip(f"{command[0]} is not installed")
    place = shutil.copytree(FOLDER, tmp_path / "examples", ignore=shutil.ignore_patterns("__pycache__"))
    python = ("--python-executable" if "mypy" in command else "--pythonpath", sys.executable)
    process = subprocess.run([*command, *python, *EXAMPLES], cwd=place, capture_output=True, text=True)
    assert process.returncode == 0, process.stdout + process.stderr


def test_there_are_seven():
    assert {*EXAMPLES} == {"flexible_plate.py", "own_vehicle_and_law.py", "table_3.py", *WRITTEN}


def test_every_benchmark_is_listed_and_has_help():
    folder = ROOT / "benchmarks"
    text = (folder / "README.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `([^`]+\.py)`", text, re.MULTILINE)
    assert listed
    assert [path.name for path in folder.glob("*.py") if f"`{path.name}`" not in text] == []
    sources = {name: (folder / name).read_text(encoding="utf-8") for name in listed}
    parsed = re.compile(r"[pP]arser\(|\.options\(")
    assert [name for name, source in sources.items() if not parsed.search(source)] == []


def test_random_impacts_of_the_benchmark_are_scenes(monkeypatch):
    """Vehicles and trains that it draws have keys of a scene."""
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    benchmark = importlib.import_module("impacts_random")
    for draws in (benchmark.both_changes, benchmark.train_changes):
        monkeypatch.setattr(benchmark, "drawn", draws)
        cases = [benchmark.case_of(61, number, "default") for number in range(8)]
        assert {len(case.scene.units) for case in cases} == (
            {1} if draws is benchmark.both_changes else {2, 3, 4}
        )
