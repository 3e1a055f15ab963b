"""Verify that commands of pages run and references are current."""

import contextlib
import inspect
import re
import runpy
import shlex
import shutil
import socket
import sqlite3
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from unittest import mock

import generate
import numpy as np
import pytest

import tailslap
from fem.laws.friction import FRICTION_LAWS
from tailslap.campaign import engine
from tailslap.cli import commands, main
from tailslap.result import result
from tailslap.scene import read
from tailslap.scene.schema import MEANINGS, Scene
from tailslap.scene.types import SceneTable
from tailslap.studies.parapet import parapet_study
from tailslap.studies.tipping import tipping_study
from tailslap.validation import outcomes, predictions
from tailslap.wall_strength import report as wall_report

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
GENERATED = ("scene.md", "results.md", "python.md", "commands.md", "../theory/set-up.svg")
BLOCK = r"^```(?P<kind>\w*)\n(?P<body>.*?)^```$"
INLINE = r"`(?P<inline>(?:tailslap |--set |--to |import tailslap|result\.\w+[(.]|SELECT )[^`\n]+)`"
FENCE = re.compile(f"{BLOCK}|{INLINE}", re.MULTILINE | re.DOTALL)
FILE_NAME = re.compile(r"# (?P<name>[\w-]+\.(?:toml|py|csv))\n")
OPTIONAL = re.compile(r" \[.*?\](?:\.\.\.)?(?= |$)")
STAND_INS = {
    "SCENE": "paper-table-3", "RESULT": "results/paper-table-3", "FORMAT": "csv", "NAME": "my-scene",
    "N": "2", "KEY=VALUES...": "corner.friction=0.1,0.2 --out results/sweep",
    "RESULT...": "results/paper-table-3",
}  # fmt: skip
"""Values for the variable parts of a synopsis without its optional parts."""

OF_STUDIES = {
    **{"flexibility": "mash-tl4-sut", "tipping": "impact-tipping-tl4-sut"},
    "parapet": "impact-parapet-tl4-sut",
}
"""Scenes of studies, as on other pages."""

PLACEHOLDER = re.compile(r"\b(?:KEY|DIR|COMMAND|SHELL|X)\b")
MENTIONED = {"tailslap run", "tailslap rigid", "tailslap check", "tailslap explore"}
"""Commands without their argument."""

NOT_HERE = () if shutil.which("ccx") else ("tailslap confirm",)
"""Commands that need a solver which is not installed."""

FRAGMENTS = {"docs/impact.md": "impact-mash-tl4-sut"}
"""Scene of the --set options that a page shows alone; of others paper-table-3."""

FAILING = ("plate.lumping=row-sum", "plate.start=unstressed")
"""Changes with which, by the page, a check fails."""

SMALLER: tuple[tuple[object, dict[str, object]], ...] = (
    (predictions, {"SAMPLES": 8, "SAMPLES_IN_SPACE": 8}),
    (outcomes, {"SAMPLES": 8}),
    (parapet_study, {"HEIGHTS": (1.0,), "LENGTHS": (1.0,), "DISTANCES": (0.0, 3.0), "TOLERANCE": 0.2}),
    (wall_report, {"ALLOWED": dict.fromkeys(wall_report.ALLOWED, 0.2)}),
    (tipping_study, {"POINTS": 3, "LINE_CENTRES": 2, "LINE_SAMPLES": 4, "LINE_WALLS": 1, "WALLS": ()}),
)
"""Samples, points and accuracy of commands; their tests have them as a user has."""

SHORTENED = {
    "tailslap explore impact-mash-tl4-sut": " --headless",
    "tailslap confirm paper-table-3": " --set plate.elements=[2,1]",
    "tailslap modes paper-table-3": " --count 2 --set plate.elements=[8,2]",
    "tailslap modes impact-mash-tl5-tractor-van": " --count 2",
    "tailslap study stability paper-table-3": " --random 2",
    "tailslap study stability impact-mash-tl4-sut": " --points 2",
    "tailslap study flexibility mash-tl4-sut": " --points 4 --lowest 4 --highest 30",
    "tailslap study flexibility impact-mash-tl4-sut": " --points 4 --lowest 30 --highest 60",
    "tailslap study tipping impact-tipping-tl4-sut": " --samples 128",
    "tailslap study uncertainty impact-mash-tl4-sut": " --samples 288",
    "tailslap study uncertainty impact-mash-tl5-tractor-van": " --samples 288",
}
"""What is added to commands that take long; `--random 100` becomes 2."""

SHORT = re.compile("confirm|modes|uncertainty|flexibility|tipping")
FIELDS = "output.fields=20"
"""Option of a page whose pictures are of fewer instants here."""

OMITTED = re.compile("--random|study flexibility mash-tl4-sut")
"""Commands that are run by `test_a_long_command_runs` alone."""

LONG = re.compile(r"study (?!uncertainty)|--vary \S+ --vary")
ELSEWHERE = ("dask scheduler\n", "python3 bootstrap.py --dev && ")
"""Beginnings of blocks that other tests run, and of the installation."""


PAGES = generate.pages()


@pytest.mark.parametrize("name", GENERATED)
def test_a_reference_is_as_the_program_is(name):
    assert (DOCS / "reference" / name).read_text(encoding="utf-8") == PAGES[name], "run docs/generate.py"


def keys(model, prefix=""):
    names: list[str] = []
    for name, field in model.model_fields.items():
        kinds = (field.annotation, *getattr(field.annotation, "__args__", ()))
        table = next((k for k in kinds if inspect.isclass(k) and issubclass(k, SceneTable)), None)
        names += keys(table, f"{prefix}{name}.") if table else [f"{prefix}{name}"]
    return names


def test_every_key_of_a_scene_has_a_meaning_and_a_row():
    every = keys(Scene)
    assert list(MEANINGS) == every
    for key in every:
        (row,) = re.findall(rf"^\| `{re.escape(key)}` \|.*$", PAGES["scene.md"], re.MULTILINE)
        _, meaning, default, allowed = row.removeprefix("| ").removesuffix(" |").split(" | ")
        assert allowed.strip()
        assert MEANINGS[key] in (meaning, f"{meaning}; default: {default}")


def test_every_column_of_a_history_has_a_row():
    for scene in ("paper-table-3", "impact-mash-tl4-sut"):
        for name, unit in tailslap.rigid(scene).history.attrs["units"].items():
            row = rf"^\| `{name}` \| {re.escape(unit)} \| \S"
            assert re.search(row, PAGES["results.md"], re.MULTILINE), name


def leaves(value, key=""):
    """Keys of numbers and texts in a summary.

    [] stands for the entries of a list.
    """
    if isinstance(value, dict) and value:
        return {leaf for name, part in value.items() for leaf in leaves(part, f"{key}.{name}".strip("."))}
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return leaves(value[0], f"{key}[]")
    return {key}


def is_documented(key):
    """Return True if a row has the key, or one above it.

    `fe` is as `rigid`, an empty table as its entries.
    """
    row_key = re.sub("^fe\\b", "rigid", key)
    rows = [row for row, _, _ in generate.SUMMARY]
    return any(
        row_key == row
        or row_key.startswith(row.removesuffix("*"))
        or row_key in (row.rstrip(".*[]"), re.split(r"[.\[]", row)[0])
        for row in rows
    )


def test_keys_without_a_row_are_found():
    assert is_documented("fe.strikes[].peak_force")
    assert is_documented("wall")
    assert not is_documented("other")
    assert not is_documented("rigid.other")
    assert leaves({"a": {"b": 1, "c": [{"d": 2}]}}) == {"a.b", "a.c[].d"}


def test_every_column_of_a_run_has_a_row():
    from tailslap.result.columns import corner_columns, impact_columns

    axle = ["plate.elements=[8,2]", 'axle=[{position="2 m",friction=0.7},{position="8 m"}]']
    scenes = {"paper-table-3": ["plate.elements=[8,2]"], "impact-mash-tl4-sut": axle}
    for (scene, changes), columns in zip(scenes.items(), (corner_columns(), impact_columns()), strict=True):
        result = tailslap.run(scene, changes)
        history = result.history
        assert [key for key in leaves(result.summary) if not is_documented(key)] == []
        assert set(history) == set(columns)
        assert [column.name for column in columns.values() if not (column.meaning and column.unit)] == []


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


def steps(text, scene="paper-table-3"):
    """Files, commands and code of a page, in order.

    Options without a command are those of the scene.
    """
    page_steps = []
    for match in FENCE.finditer(text):
        kind, body, inline = match["kind"], match["body"], match["inline"]
        named = body and FILE_NAME.match(body)
        if inline is not None:
            page_steps += inline_steps(inline, scene)
        elif named:
            is_complete = named["name"].endswith(("toml", "py"))
            page_steps.append(Step("file", body if is_complete else body[named.end() :], named["name"]))
        elif kind == "toml":
            page_steps.append(Step("tables", body))
        elif kind == "python":
            page_steps += [Step("code", body)] if ">>>" not in body else []
        elif kind in ("", "sh"):
            page_steps += commands_of(body)
    return page_steps


def inline_steps(text, scene):
    """A command, options, code or SQL between backticks."""
    if text.startswith("--set "):
        folder = "results/" + re.sub(r"\W+", "-", text).strip("-")
        return commands_of(f"tailslap run {scene} --no-pictures {text} --out {folder}")
    if text.startswith("--to "):
        return commands_of(f"tailslap export results/fields {text}")
    if text.startswith("SELECT "):
        return [Step("sql", text, "results/friction/records.sqlite")]
    return commands_of(text) if text.startswith("tailslap ") else [Step("code", text)]


def commands_of(text):
    parts = [part.strip() for line in text.splitlines() for part in line.split(" && ")]
    lines = [OPTIONAL.sub("", part.removeprefix(".venv/bin/")) for part in parts]
    runs = [line for line in lines if line.startswith("tailslap ") and line not in MENTIONED]
    for study, scene in OF_STUDIES.items():
        runs = [line.replace(f"{study} SCENE", f"{study} {scene}") for line in runs]
    filled = [" ".join(STAND_INS.get(word, word) for word in line.split(" ")) for line in runs]
    return [Step("command", line) for line in filled if not PLACEHOLDER.search(line)]


TEXTS = {
    str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
    for path in (ROOT / "README.md", *sorted(DOCS.rglob("*.md")))
    if path.parent.name != "reference"
}
SHOWN = {
    name: page_steps
    for name, text in TEXTS.items()
    if (page_steps := steps(text, FRAGMENTS.get(name, "paper-table-3")))
}
COMMANDS = {step.text for page_steps in SHOWN.values() for step in page_steps if step.kind == "command"}
LONG_COMMANDS = sorted(filter(LONG.search, COMMANDS))


@pytest.fixture(autouse=True)
def laws_of_the_program():
    """Remove laws that a page registers, for later tests."""
    with mock.patch.dict(FRICTION_LAWS):
        yield


def do(step, namespace):
    """Run a step to exit status 0 and passed checks."""
    if step.kind == "command":
        if step.text.startswith(NOT_HERE):
            return
        with pytest.raises(SystemExit) as ended:
            main(shlex.split(step.text)[1:])
        assert ended.value.code == any(change in step.text for change in FAILING), step.text
    elif step.kind == "sql":
        with contextlib.closing(sqlite3.connect(step.name)) as file:
            assert file.execute(step.text).fetchall()
    elif step.kind == "tables":
        scene = tomllib.loads(read.shipped_scenes()["impact-mash-tl4-sut"].read_text())
        demand_passed(lambda: tailslap.run(scene | tomllib.loads(step.text)))
    elif step.kind == "file":
        Path(step.name).write_text(step.text, encoding="utf-8")
        if step.name.endswith(".py"):
            demand_passed(lambda: runpy.run_path(step.name, run_name="__main__"))
    else:
        demand_passed(lambda: exec(compile(step.text, "<page>", "exec"), namespace))


def demand_passed(compute):
    """Every result of the computation passed its checks or has none."""
    results, plain = [], result.Result.__init__

    def noted(self, *arguments, **options):
        results.append(self)
        plain(self, *arguments, **options)

    with pytest.MonkeyPatch.context() as change:
        change.setattr(result.Result, "__init__", noted)
        try:
            compute()
        except ImportError as error:
            if "pandas is not installed" not in str(error):  # as stated on the page
                raise
    assert [item for item in results if item.passed is False] == []
    assert all("".join(item.headline.lines).isprintable() for item in results)


def one_for_all(function, parts, journal, *_):
    """Replacement of `engine.run_parts` that computes one of several equal parts.

    The record of one part is used for all parts with as many samples.
    """
    by_sizes: dict[tuple[int, ...], list[str]] = {}
    for key, part in parts.items():
        sizes = tuple(map(np.size, part[-1].values())) if isinstance(part[-1], dict) else ()
        by_sizes.setdefault(sizes, []).append(key)
    for keys in by_sizes.values():
        journal.records.add(dict.fromkeys(keys, function(*parts[keys[min(1, len(keys) - 1)]])))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of all pages, and the commands that were run there."""
    return tmp_path_factory.mktemp("pages"), set()


@pytest.mark.parametrize("page", SHOWN)
def test_a_page_runs(page, folder, monkeypatch):
    """Commands of a page run, without the large campaigns.

    Long studies compute one part, large sweeps the corners, others what `SMALLER` says. `test_command_line.py` has the
    pictures. Random cells compile loops of their own: `test_a_long_command_runs` has them, and the
    flexibility of a constrained corner.
    """
    place, commands_run = folder
    monkeypatch.chdir(place)
    monkeypatch.setattr(engine, "run_parts", one_for_all)
    for module, constants in SMALLER:
        for name, value in constants.items():
            monkeypatch.setattr(module, name, value)
    namespace = {"__name__": "__main__"}
    for step in SHOWN[page]:
        text = re.sub(r":\d+(?= |$)", ":2", step.text) if LONG.search(step.text) else step.text
        text = shortened(text) if SHORT.search(text) else text.replace(FIELDS, "output.fields=4")
        if text.startswith("tailslap run ") and "--no-pictures" not in text:
            text += " --no-pictures"
        if step.kind != "command" or (text not in commands_run and not OMITTED.search(text)):
            do(replace(step, text=text), namespace)
            commands_run.add(text)


def shortened(line):
    return line.replace("--random 100", "--random 2") + SHORTENED.get(line, "")


@pytest.mark.long
@pytest.mark.parametrize("line", LONG_COMMANDS)
def test_a_long_command_runs(line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    do(Step("command", shortened(line)), {})


def listens(port):
    with socket.socket() as tried:
        return tried.connect_ex(("127.0.0.1", port)) == 0


@pytest.mark.long
def test_the_cluster_s_commands_run(tmp_path, monkeypatch):
    """Scheduler, worker and sweep of the page run on this machine."""
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"^```text\n(dask scheduler\n.*?)^```", TEXTS["docs/howto/cluster.md"], re.M | re.S)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    here = block.replace("10.0.0.1:8786", f"127.0.0.1:{port}").replace("--nworkers 32", "--nworkers 1")
    scheduler, worker, sweep = here.splitlines()
    with contextlib.ExitStack() as stack:
        for line in (f"{scheduler} --host 127.0.0.1 --port {port}", f"{worker} --host 127.0.0.1"):
            command = [sys.executable, "-m", *line.split(), "--no-dashboard"]
            process = stack.enter_context(
                subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            )
            stack.callback(process.terminate)
            while not listens(port):
                time.sleep(0.1)
        do(Step("command", sweep.replace(":1000", ":2")), {})


def test_every_block_runs():
    """No block is passed over."""
    for text in TEXTS.values():
        for match in re.finditer(BLOCK, text, re.MULTILINE | re.DOTALL):
            assert steps(match[0]) or match["body"].startswith(ELSEWHERE), match[0]


def test_commands_and_code_are_found():
    pages = {"docs/first-steps.md", "docs/howto/python.md", "docs/theory/rigid.md", "README.md"}
    assert pages <= SHOWN.keys()
    kinds = [step.kind for step in SHOWN["docs/howto/own-vehicle.md"]]
    assert kinds == ["file", "command", "command", "command", "file", *3 * ["command"]]
    assert [step.kind for step in SHOWN["docs/howto/cluster.md"]] == ["command", "sql", "command"]
    assert {"tailslap new my-scene", "tailslap modal paper-table-3", "tailslap completion bash"} <= COMMANDS
    assert "tailslap export results/fields --to xdmf" in COMMANDS
    assert "tailslap study cost paper-table-3" in LONG_COMMANDS


def test_a_failed_check_in_code_is_noticed():
    failing = 'import tailslap\ntailslap.run("paper-table-3", {"plate.lumping": "row-sum"})\n'
    with pytest.raises(AssertionError, match="FAILED"):
        do(Step("code", failing), {})


def test_what_does_not_run_is_noticed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "page.md"
    page.write_text("```sh\ntailslap rigid none.toml\n```\n```python\n1 / 0\n```\n")
    command, code = steps(page.read_text())
    with pytest.raises(AssertionError):
        do(command, {})
    with pytest.raises(ZeroDivisionError):
        do(code, {})
