"""Verify that texts use the standard terms of the field."""

import ast
import html
import re
from pathlib import Path

import click
import pytest
from wording import PACKAGES, PRIVATE, RETIRED, docstrings, occurrences, private_words, sources

from tailslap import cli

ROOT = Path(__file__).parents[2]
STRICT = ("private words", "long first lines", "vague names")
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


def retired_in(text):
    """List the retired words of a text, code included."""
    return private_words(text.replace("`", " "), RETIRED)


def package_faults(path):
    """List private words of messages, retired words, and openings of docstrings."""
    text = path.read_text(encoding="utf-8")
    nodes = [*ast.walk(ast.parse(text))]
    constants = [(id(node), node.value) for node in nodes if isinstance(node, ast.Constant)]
    sentences = [(key, value) for key, value in constants if isinstance(value, str) and " " in value]
    described = {id(node) for node in docstrings(nodes)}
    faults = [
        word for key, value in sentences if key not in described for word in private_words(value, PRIVATE)
    ]
    lines = [*(value for _, value in sentences), *re.findall(r"#\s(.*)$", text, re.MULTILINE)]
    faults += [word for line in lines for word in retired_in(line)]
    return faults + [str(node.value) for node in docstrings(nodes) if OPENINGS.match(str(node.value))]


@pytest.mark.parametrize("folder", [*PACKAGES, "tests", "benchmarks"])
def test_sources(folder):
    """Sources have plain words, short first lines and names with a meaning."""
    faults = []
    for path in sources([ROOT / folder]):
        places = occurrences(path)
        faults += [place for kind in STRICT for place in places[kind]]
        faults += package_faults(path) if folder in PACKAGES else []
    assert faults == []


@pytest.mark.parametrize("name", [str(path.relative_to(ROOT)) for path in DOCUMENTS])
def test_documents(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    assert retired_in(text) == []
    if name != "ARCHITECTURE.md":
        assert private_words(re.sub(r"`[^`]*::[^`]*`", "", text), PRIVATE) == []
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
    assert (
        private_words("\n".join(helps(cli.commands, click.Context(cli.commands, info_name="tailslap")))) == []
    )


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
    assert private_words("\n".join([*capsys.readouterr(), *map(html.unescape, bodies)])) == []


@pytest.mark.parametrize("text", [
    "What the motion loses, and what friction does", "so much of its way to the wall", "Of the samples, said twice",
    "19 are right, 2 left out", "The plate gives", "the share of the variance", "it leaves them out",
])  # fmt: skip
def test_private_words_are_noticed(text):
    assert private_words(text)


@pytest.mark.parametrize("text", [
    "The give of the plate is 1e-6", "by the hold of the corner", "a quiet start", "more damping calms it",
    "the run was spoilt", "the next rung", "foretold without a run",
])  # fmt: skip
def test_retired_words_are_noticed(text):
    assert len(retired_in(text)) == 1


def test_standard_words_pass():
    words = "Given values; a moving average; `left_out`; shared memory; a runaway; two-way coupling"
    assert private_words(words) == []
    plain = "Numbers hold to rounding; they give the flexibility of all modes; the start is unstressed"
    assert retired_in(plain) == []
