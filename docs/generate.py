"""The reference pages, from the program itself: scene keys, results, Python, commands.

    .venv/bin/python docs/generate.py          writes docs/reference
    .venv/bin/python docs/generate.py --check  says which pages are not as the program is; exit status 1

`pages()` returns them; tests/verification/test_site.py checks that they are up to date.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import click
from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

FOLDER = Path(__file__).parent / "reference"
NOTICE = "<!-- Made by docs/generate.py: change the program, not this page. -->\n"


def table(headings: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table in Markdown."""
    names = list(headings)
    lines = [names, ["---"] * len(names), *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def pages() -> dict[str, str]:
    """Text of each page, by the name of its file."""
    made = {
        "scene.md": scene_page(),
        "results.md": results_page(),
        "python.md": python_page(),
        "commands.md": commands_page(),
    }
    return {name: NOTICE + text.rstrip() + "\n" for name, text in made.items()}


# Scene


def scene_page() -> str:
    """Every table and key of a scene."""
    from tailslap.scene.schema import LISTED, TABLES, Scene

    parts = ["# Scene keys", "", SCENE_INTRODUCTION, ""]
    parts += [table(KEY_HEADINGS, [_key_row("name", Scene.model_fields["name"])])]
    for name, kind in TABLES.items():
        keys = [_key_row(f"{name}.{key}", field) for key, field in kind.model_fields.items()]
        said = inspect.cleandoc(kind.__doc__ or "")
        parts += [
            f"## [[{name}]]" if name in LISTED else f"## [{name}]",
            "",
            said,
            "",
            table(KEY_HEADINGS, keys),
        ]
    return "\n".join(parts)


SCENE_INTRODUCTION = """Every key that a scene may have, from the definition that reads it. A number without a unit
is SI; a text carries its unit. A table that is not there is a part that the run leaves out: [How is a scene
written](../scenes.md)."""
KEY_HEADINGS = ("key", "unit", "allowed", "default", "meaning")


def _key_row(key: str, field: FieldInfo) -> tuple[str, ...]:
    from tailslap.scene.write import unit_of

    return f"`{key}`", unit_of(field), allowed(field), _default(field), field.description or ""


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    from tailslap.scene.write import toml_value

    return "" if field.default is None else f"`{toml_value(field.default)}`"


def allowed(field: FieldInfo) -> str:
    """What a key takes, as its error message says it."""
    from tailslap.scene.units import Quantity

    kind: Any = next((k for k in get_args(field.annotation) if k is not type(None)), field.annotation)
    if get_origin(field.annotation) in (Literal, tuple):
        kind = field.annotation
    marks = [*field.metadata, *get_args(kind)[1:]]
    for mark in marks:
        if isinstance(mark, Quantity):
            said = mark.allowed.removeprefix("allowed is ")
            return re.sub(r", (a number in .*? or a string with its unit|a plain number)", "", said)
    bounds = {name: getattr(mark, name) for mark in marks for name in ("ge", "le") if hasattr(mark, name)}
    if bounds:
        return f"a whole number from {bounds['ge']} to {bounds['le']}"
    return _refusal(kind, field.metadata)


def _refusal(kind: Any, marks: Iterable[Any]) -> str:
    from typing import Annotated

    annotated: Any = kind
    for mark in marks:
        annotated = Annotated[annotated, mark]
    try:
        TypeAdapter(annotated).validate_python("?")
    except ValidationError as error:
        first = error.errors()[0]
        if first["type"] == "literal_error":
            return str(first["ctx"]["expected"]).replace("'", '"')
        return re.sub(r"^Value error, allowed (is|are) ", "", first["msg"])
    raise ValueError(f"{kind} takes anything")


# Results


def results_page() -> str:
    """Files and columns."""
    from postprocess.fields.series import ELEMENTS, NODES
    from tailslap.files.load import corner_columns, impact_columns

    columns = {
        "history.csv and rigid.csv of a constrained corner": corner_columns(),
        "history.csv and rigid.csv of a whole impact": impact_columns(),
    }
    parts = ["# Result files and columns", "", RESULTS_INTRODUCTION, "", table(("file", "what"), FILES)]
    for title, known in columns.items():
        rows = [(f"`{c.name}`", c.unit, c.meaning or c.caption) for c in known.values()]
        parts += [f"## {title}", "", table(("column", "unit", "meaning"), rows)]
    fields = [(f"`{n}`", "nodes", u) for n, u in NODES.items()]
    fields += [(f"`{n}`", "elements", u) for n, u in ELEMENTS.items()]
    parts += ["## fields.npz", "", FIELDS, "", table(("field", "of the", "unit"), fields), *_sweep_columns()]
    return "\n".join(parts)


RESULTS_INTRODUCTION = """All numbers are SI. What is no finite number is an empty entry in CSV and null in JSON
and Parquet. The rigid vehicle's columns have the same names, at the same instants; what it has not, like strain
energy, is 0 or not there.

`tailslap.load`, `compare` and `export` verify each file that they read by the manifest. One that is damaged, or was
changed since, is refused with its name; `--force` (in Python `force=True`) reads what can be read."""
FILES = (
    (
        "`summary.json`",
        "the numbers: `rigid`, `fe`, `difference`, `checks`, `cost`, `chosen`, `left_out` and more",
    ),
    ("`history.csv`", "the FE run, a row an instant"),
    ("`rigid.csv`", "the rigid vehicle at the same instants"),
    ("`report.html`", "what a person opens"),
    ("`theta.svg`, `omega.svg` and so on", "the page's curves"),
    ("`contour_v_gx.png`, `contour_v_gy.png`, `contour_omega.png`", "the plate at the tail-slap"),
    ("`impact.gif`", "of a whole impact: its animation"),
    ("`fields.npz`", "with `[output] fields = N`: fields of the plate at N instants"),
    (
        "`.tailslap-result.json`",
        "the manifest: command and scene, and the files that the program wrote, with size and digest",
    ),
    (
        "`.tailslap-lock`, `.tailslap-new`, `.tailslap-redo.json`",
        "while a command is at work, or after it was killed, until the next one: its lock, its new files, and the log "
        "of what they replace",
    ),
)
FIELDS = """NumPy arrays: `points` [m], shape (nodes, 2), the unstrained plate where the run starts; `cells`, the
nodes of each element, and `cell_type`, what meshio calls it; `t` [s]; and the fields, shape (instants, nodes, 2)
and (instants, elements). Stress is Kirchhoff's, F S F': Cauchy's times the change of volume, the mean over each
element. `elastic_displacement` is what is left of the displacement beside the rigid motion that fits best.
`tailslap export` writes them for other programs."""


def _sweep_columns() -> Iterator[str]:

    from tailslap.case import kind_of
    from tailslap.scene.read import read_scene

    yield "## sweep.parquet"
    yield ""
    yield "Each finished run is in `records.sqlite` already: in the table `record` with its values as JSON, in the view"
    yield "`result` with the columns below that it has. At the end, or interrupted, they become `sweep.parquet`."
    yield ""
    yield "A row a run: `run`, `status`, `reason`, the keys that vary, a column `check.NAME` for each check, and:"
    yield ""
    examples = {"constrained corner": "mash-tl4-sut", "whole impact": "impact-mash-tl4-sut"}
    scenes = {what: read_scene(name)[0] for what, name in examples.items()}
    kinds = {what: kind_of(scene).columns(scene) for what, scene in scenes.items()}
    rows = [(f"`{n}`", k.__name__, what) for what, known in kinds.items() for n, k in known.items()]
    yield table(("column", "type", "of a"), rows)


# Python


def python_page() -> str:
    """Functions and records of `import tailslap`, from their docstrings."""
    import tailslap

    functions = [n for n in tailslap.__all__ if inspect.isfunction(getattr(tailslap, n))]
    classes = [n for n in tailslap.__all__ if inspect.isclass(getattr(tailslap, n))]
    parts = ["# Python interface", "", "How to use it: [From Python](../howto/python.md).", ""]
    for name in (*functions, *classes):
        parts += list(_described(f"tailslap.{name}", getattr(tailslap, name)))
    return "\n".join(parts)


def _described(name: str, value: Any, level: str = "##") -> Iterator[str]:
    signature = str(inspect.signature(value)).replace("'", "")
    signature = re.sub(r"collections\.abc\.|os\.|typing\.|\bresult\.", "", signature)
    yield f"{level} {name}"
    yield ""
    if inspect.isfunction(value):
        yield f"```python\n{name}{signature}\n```"
        yield ""
    yield from _numpydoc(inspect.getdoc(value) or "")
    if inspect.isclass(value):
        for method, function in vars(value).items():
            if inspect.isfunction(function) and not method.startswith("_"):
                yield from _described(f"{name}.{method}", function, f"{level}#")


def _numpydoc(text: str) -> Iterator[str]:
    """A docstring with its sections as Markdown."""
    head, *rest = re.split(r"^(\w+)\n-{3,}$", text, flags=re.MULTILINE)
    yield head.strip()
    yield ""
    for title, body in zip(rest[::2], rest[1::2], strict=True):
        yield f"**{title}**"
        yield ""
        yield f"```python\n{body.strip()}\n```\n" if title == "Examples" else _entries(body)


def _entries(body: str) -> str:
    """Entries "name : type" with what is said of them, as a list."""
    lines: list[str] = []
    for line in body.strip().splitlines():
        if line.startswith(" "):
            lines[-1] += " " + line.strip()
        else:
            name, colon, kind = line.partition(" : ")
            lines.append(f"- `{name}`{f', {kind}' if colon else ''}:")
    return "\n".join(lines) + "\n"


# Commands


def commands_page() -> str:
    """What each command says of itself."""
    from tailslap.commands import commands, study_command
    from tailslap.studies import find_study, study_names

    every: Mapping[str, click.Command] = {
        **commands.commands,
        **{f"study {name}": study_command(find_study(name)) for name in study_names()},
    }
    parts = ["# Commands", "", "What `tailslap COMMAND --help` says.", ""]
    for name in sorted(every):
        context = click.Context(
            every[name], info_name=f"tailslap {name}", terminal_width=100, max_content_width=100
        )
        parts += [f"## {name}", "", f"```text\n{every[name].get_help(context)}\n```", ""]
    return "\n".join(parts)


def main() -> int:
    """Write the pages, or check them."""
    made = pages()
    if "--check" in sys.argv:
        old = [n for n, text in made.items() if (FOLDER / n).read_text(encoding="utf-8") != text]
        print("\n".join(f"docs/reference/{name} is not as the program is" for name in old), end="")
        return 1 if old else 0
    FOLDER.mkdir(exist_ok=True)
    for name, text in made.items():
        (FOLDER / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
