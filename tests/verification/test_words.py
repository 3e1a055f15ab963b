"""Verification: texts that a person reads use the standard terms of the field: messages, help, pages, documents."""

import ast
import html
import re
from pathlib import Path

import click
import pytest
from wording import PACKAGES, PRIVATE, descriptions, docstrings, private_words, sources

from tailslap import cli

ROOT = Path(__file__).parents[2]
READ_IN_AN_EDITOR = (
    "tailslap/api.py", "tailslap/campaign/sweep_run.py",
    "tailslap/result/columns.py", "tailslap/result/result.py", "tailslap/result/load.py",
    "tailslap/exports/export.py",
)  # fmt: skip
DOCUMENTS = [
    *sorted((ROOT / "docs").rglob("*.md")),
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "benchmarks/README.md", "mkdocs.yml")),
    *sorted((ROOT / "examples").glob("*.py")),
    *sorted((ROOT / "tailslap" / "scene" / "shipped").glob("*.toml")),
    *sorted((ROOT / "postprocess" / "templates").glob("*.j2")),
]


def found_in(text):
    """List the private words of a text in their context, each with standard ones."""
    return private_words(text, PRIVATE)


def texts(path):
    """Strings of a module that reach a person: of several words; descriptions where an editor shows them."""
    tree, name = ast.parse(path.read_text(encoding="utf-8")), str(path.relative_to(ROOT))
    described = set() if name in READ_IN_AN_EDITOR else {id(node) for node in docstrings(tree)}
    strings = [
        node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in described
    ]
    return [node.value for node in strings if isinstance(node.value, str) and " " in node.value]


@pytest.mark.parametrize("package", PACKAGES)
def test_messages_and_reports(package):
    modules = sorted((ROOT / package).rglob("*.py"))
    found = {str(p.relative_to(ROOT)): [w for text in texts(p) for w in found_in(text)] for p in modules}
    assert {name: words for name, words in found.items() if words} == {}


@pytest.mark.parametrize("folder", ["tests", "benchmarks"])
def test_descriptions(folder):
    """Docstrings and comments."""
    found = {
        f"{path.relative_to(ROOT)}:{line}": words
        for path in sources([ROOT / folder])
        for line, text in descriptions(path.read_text(encoding="utf-8"))
        if (words := private_words(text))
    }
    assert found == {}


@pytest.mark.parametrize("name", [str(path.relative_to(ROOT)) for path in DOCUMENTS])
def test_documents(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    assert found_in(re.sub(r"`[^`]*::[^`]*`", "", text)) == []
    assert re.findall(r"^#+ .*\?$", text, re.MULTILINE) == [], "a heading names its subject"


def helps(command, context):
    """Help texts of a command and those below it."""
    yield command.get_help(context)
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            assert below is not None
            yield from helps(below, click.Context(below, info_name=name, parent=context))


def test_help():
    assert found_in("\n".join(helps(cli.commands, click.Context(cli.commands, info_name="tailslap")))) == []


SHOWN = (
    ("rigid", "mash-tl4-sut"), ("rigid", "impact-mash-tl4-sut"), ("paper",), ("scenes",),
    ("modal", "paper-table-3"), ("modes", "paper-table-3", "--count", "3"),
    ("study", "uncertainty", "mash-tl4-sut", "--samples", "288"), ("rigid", "nosuch"), ("new", "van"),
)  # fmt: skip


@pytest.mark.parametrize("arguments", SHOWN, ids=" ".join)
def test_terminal_and_pages(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    cli._status(list(arguments))
    pages = [path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.html")]
    bodies = [re.sub(r"(?s)<(script|style)\b.*?</\1>|<[^>]+>", " ", page) for page in pages]
    assert found_in("\n".join([*capsys.readouterr(), *map(html.unescape, bodies)])) == []


@pytest.mark.parametrize("text", [
    "What the motion loses, and what friction does", "so much of its way to the wall", "Of the samples, said twice",
    "19 are right, 2 left out", "The plate gives", "the share of the variance", "it leaves them out",
])  # fmt: skip
def test_private_words_are_noticed(text):
    assert found_in(text)


def test_standard_words_pass():
    assert (
        found_in("Given values; a moving average; `left_out`; shared memory; a runaway; two-way coupling")
        == []
    )
