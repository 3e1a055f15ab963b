"""Verification: texts that a person reads use the standard terms of the field: messages, help, pages, documents."""

import ast
import html
import re
from pathlib import Path

import click
import pytest
from wording import PACKAGES, PRIVATE, RETIRED, descriptions, docstrings, private_words, sources

from tailslap import cli

ROOT = Path(__file__).parents[2]
READ_IN_AN_EDITOR = (
    "tailslap/api.py", "tailslap/campaign/sweep_run.py",
    "tailslap/result/columns.py", "tailslap/result/result.py", "tailslap/result/load.py",
    "tailslap/exports/export.py",
)  # fmt: skip
DOCUMENTS = [
    *sorted((ROOT / "docs").rglob("*.md")),
    *(ROOT / f"{name}.md" for name in ("README", "CONTRIBUTING", "ARCHITECTURE", "benchmarks/README")),
    ROOT / "mkdocs.yml",
    *sorted((ROOT / "examples").glob("*.py")),
    *sorted((ROOT / "tailslap" / "scene" / "shipped").glob("*.toml")),
    *sorted((ROOT / "postprocess" / "templates").glob("*.j2")),
]


OPENINGS = re.compile(
    r"(?:What|Whether|Of|The same|Where|How (?:many|far|often|much|long|deep)|Which|Those|As|If|It|When|Not)\b"
    r"|\w+ alike\b"
)
"""Words that a docstring does not begin with: it begins with a verb or the thing itself, and can be read alone."""


def found_in(text):
    """List the private words of a text in their context, each with standard ones."""
    return private_words(text, PRIVATE)


def retired_in(text):
    """List the retired words of a text, code included, each with its standard one."""
    return private_words(text.replace("`", " "), RETIRED)


def texts(path):
    """Strings of a module that reach a person: of several words; descriptions where an editor shows them."""
    tree, name = ast.parse(path.read_text(encoding="utf-8")), str(path.relative_to(ROOT))
    described = set() if name in READ_IN_AN_EDITOR else {id(node) for node in docstrings(tree)}
    strings = [
        node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in described
    ]
    return [node.value for node in strings if isinstance(node.value, str) and " " in node.value]


@pytest.mark.parametrize("package", PACKAGES)
def test_messages_and_descriptions(package):
    """Descriptions have no retired words either, and begin with a verb or the thing itself."""
    found: dict[str, list[str]] = {}
    for path in sorted((ROOT / package).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        tree, comments = ast.parse(text), re.findall(r"#\s(.*)$", text, re.MULTILINE)
        strings = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)]
        said = [*(value for value in strings if isinstance(value, str) and " " in value), *comments]
        words = [word for part in texts(path) for word in found_in(part)]
        words += [word for part in said for word in retired_in(part)]
        openings = [
            str(node.value).splitlines()[0] for node in docstrings(tree) if OPENINGS.match(str(node.value))
        ]
        found |= {str(path.relative_to(ROOT)): words + openings} if words + openings else {}
    assert found == {}


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
    assert retired_in(text) == []
    if name != "ARCHITECTURE.md":
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


@pytest.mark.parametrize("text", [
    "The give of the plate is 1e-6", "by the hold of the corner", "a quiet start", "more damping calms it",
    "the run was spoilt", "the next rung", "foretold without a run",
])  # fmt: skip
def test_retired_words_are_noticed(text):
    assert len(retired_in(text)) == 1


def test_standard_words_pass():
    words = "Given values; a moving average; `left_out`; shared memory; a runaway; two-way coupling"
    assert found_in(words) == []
    plain = "Numbers hold to rounding; they give the flexibility of all modes; the start is unstressed"
    assert retired_in(plain) == []
