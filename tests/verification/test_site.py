"""Verification: the site builds without a warning, its references are the program's, its commands and code run."""

import importlib.util
import inspect
import re
import runpy
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

import tailslap
from tailslap.cli import commands, main
from tailslap.scene.schema import MEANINGS, Scene, SceneTable

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
GENERATED = ("scene.md", "results.md", "python.md", "commands.md")
BLOCK, INLINE = r"^```(?P<kind>\w*)\n(?P<body>.*?)^```$", r"`(?P<inline>tailslap [^`\n]+)`"
FENCE = re.compile(f"{BLOCK}|{INLINE}", re.MULTILINE | re.DOTALL)
FILE_NAME = re.compile(r"# (?P<name>[\w-]+\.(?:toml|py|csv))\n")
PLACEHOLDER = re.compile(r"\b(?:SCENE|RESULT|NAME|KEY|DIR|FORMAT|COMMAND|SHELL|N|X)\b")
BARE = ("tailslap scenes", "tailslap paper")
"""Commands that say something without an argument; others of one word are only mentioned."""

SHORTENED = {
    "tailslap study stability paper-table-3": " --random 2",
    "tailslap study stability impact-mash-tl4-sut": " --points 2",
    "tailslap study flexibility mash-tl4-sut": " --points 4",
    "tailslap study flexibility impact-mash-tl4-sut": " --points 4",
    "tailslap study uncertainty impact-mash-tl4-sut": " --samples 288",
}
"""What is added to commands that take an hour; `--random 100` becomes 2."""

LONG = re.compile(r"study (?!uncertainty)|--vary \S+ --vary")
LONG_PAGES = ("howto/own-law.md", "howto/own-vehicle.md", "howto/cluster.md")


def generator():
    spec = importlib.util.spec_from_file_location("generate", DOCS / "generate.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


PAGES = generator().pages()


def test_the_site_builds_without_network_and_without_a_warning(tmp_path):
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"]
    command += ["--site-dir", str(tmp_path / "site")]
    nowhere = dict.fromkeys(("http_proxy", "https_proxy"), "http://127.0.0.1:9")
    environment = {"PATH": "/usr/bin:/bin"} | nowhere
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    site = tmp_path / "site"
    assert (site / "reference" / "scene" / "index.html").is_file()
    assert not (site / "generate.py").exists()
    link = r'<(?:script|link|img)[^>]+(?:src|href)="(?:https?:)?//'
    fetched = [page for page in site.rglob("*.html") if re.search(link, page.read_text(encoding="utf-8"))]
    assert fetched == []


@pytest.mark.parametrize("name", GENERATED)
def test_a_reference_is_as_the_program_is(name):
    assert (DOCS / "reference" / name).read_text(encoding="utf-8") == PAGES[name], "run docs/generate.py"


def keys(model, prefix=""):
    found = []
    for name, field in model.model_fields.items():
        kinds = (field.annotation, *getattr(field.annotation, "__args__", ()))
        table = next((k for k in kinds if inspect.isclass(k) and issubclass(k, SceneTable)), None)
        found += keys(table, f"{prefix}{name}.") if table else [f"{prefix}{name}"]
    return found


def test_every_key_of_a_scene_has_a_meaning_and_a_row():
    every = keys(Scene)
    assert list(MEANINGS) == every
    for key in every:
        (row,) = re.findall(rf"^\| `{re.escape(key)}` \|.*$", PAGES["scene.md"], re.MULTILINE)
        *_, allowed, _default, meaning = row.removeprefix("| ").removesuffix(" |").split(" | ")
        assert allowed.strip()
        assert meaning == MEANINGS[key]


def test_every_column_of_a_history_has_a_row():
    for scene in ("paper-table-3", "impact-mash-tl4-sut"):
        for name, unit in tailslap.rigid(scene).history.units.items():
            row = rf"^\| `{name}` \| {re.escape(unit)} \| \S"
            assert re.search(row, PAGES["results.md"], re.MULTILINE), name


def test_every_column_of_a_run_has_a_row():
    from tailslap.files.load import corner_columns, impact_columns

    for scene, known in (("paper-table-3", corner_columns()), ("impact-mash-tl4-sut", impact_columns())):
        history = tailslap.run(scene, {"plate.elements": [8, 2]}).history
        assert set(history) == set(known)
        assert [column.name for column in known.values() if not (column.meaning and column.unit)] == []


def test_every_function_and_command_has_its_part():
    for name in tailslap.__all__:
        assert f"\n## tailslap.{name}\n" in PAGES["python.md"]
    for name in commands.commands:
        assert name == "study" or f"\n## {name}\n" in PAGES["commands.md"]


@dataclass(frozen=True)
class Step:
    """A command, a file or code that a page shows."""

    kind: str
    text: str
    name: str = ""


def steps(page):
    """What is run of a page, in order."""
    found = []
    for match in FENCE.finditer(page.read_text(encoding="utf-8")):
        kind, body, inline = match["kind"], match["body"], match["inline"]
        named = body and FILE_NAME.match(body)
        if inline is not None:
            found += commands_of(inline)
        elif named:
            text = body if named["name"].endswith(("toml", "py")) else body[named.end() :]
            found.append(Step("file", text, named["name"]))
        elif kind == "python":
            found += [Step("code", body)] if ">>>" not in body else []
        elif kind in ("", "sh"):
            found += commands_of(body)
    return found


def commands_of(text):
    parts = [part.strip() for line in text.splitlines() for part in line.split(" && ")]
    lines = [part.removeprefix(".venv/bin/") for part in parts]
    whole = [line for line in lines if line.count(" ") > 1 and line.startswith("tailslap ")]
    shown = {line for line in whole if not PLACEHOLDER.search(line)} | {*BARE}
    kept = [line for line in lines if line in shown and "--json" not in line.split()[2:3]]
    return [Step("command", line) for line in kept]


def shown():
    paths = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
    found = {str(path.relative_to(ROOT)): steps(path) for path in paths if path.parent.name != "reference"}
    return {name: each for name, each in found.items() if each}


SHOWN = shown()
COMMANDS = {step.text for each in SHOWN.values() for step in each if step.kind == "command"}
LONG_COMMANDS = sorted(filter(LONG.search, COMMANDS))


def do(step, namespace):
    if step.kind == "file":
        Path(step.name).write_text(step.text, encoding="utf-8")
        if step.name.endswith(".py"):
            runpy.run_path(step.name, run_name="__main__")
    elif step.kind == "code":
        exec(compile(step.text, "<page>", "exec"), namespace)
    else:
        line = step.text.replace("--random 100", "--random 2") + SHORTENED.get(step.text, "")
        with pytest.raises(SystemExit) as left:
            main(shlex.split(line)[1:])
        assert left.value.code == 0, line


@pytest.mark.parametrize(
    "page", [pytest.param(p, marks=[pytest.mark.long] if p.endswith(LONG_PAGES) else []) for p in SHOWN]
)
def test_a_page_runs(page, tmp_path, monkeypatch):
    """Commands end with 0, files are written where they are shown, code runs; one after the other."""
    monkeypatch.chdir(tmp_path)
    namespace = {"__name__": "__main__"}
    for step in SHOWN[page]:
        if not LONG.search(step.text if step.kind == "command" else ""):
            do(step, namespace)


@pytest.mark.long
@pytest.mark.parametrize("line", LONG_COMMANDS)
def test_a_long_command_runs(line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    do(Step("command", line), {})


def test_commands_and_code_are_found():
    shown = {"docs/first-steps.md", "docs/howto/python.md", "docs/theory/rigid.md", "README.md"}
    assert shown <= SHOWN.keys()
    kinds = [step.kind for step in SHOWN["docs/howto/own-vehicle.md"]]
    assert kinds == ["file", "command", "command", "command", "file", "command", "command"]
    assert "tailslap study cost paper-table-3" in LONG_COMMANDS


def test_what_does_not_run_is_noticed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "page.md"
    page.write_text("```sh\ntailslap rigid none.toml\n```\n```python\n1 / 0\n```\n")
    command, code = steps(page)
    with pytest.raises(AssertionError):
        do(command, {})
    with pytest.raises(ZeroDivisionError):
        do(code, {})
