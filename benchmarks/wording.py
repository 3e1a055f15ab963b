"""Print how the sources read.

    .venv/bin/python benchmarks/wording.py [--files] [--random N] [--seed N] [PATH ...]

Counted are words of no textbook, first lines of docstrings, local names, constants below definitions and Any. With
--files every occurrence is listed with its line, with --random N first lines are drawn at random. Paths restrict the
count to files and folders of the packages, tests and benchmarks.

The list of words is the only one of the project; test_words.py applies it.
"""

from __future__ import annotations

import ast
import io
import random
import re
import statistics
import tokenize
from collections.abc import Iterator, Mapping
from pathlib import Path

import command_line
from command_line import ROOT

PACKAGES = ("solver", "meshes", "machine_code", "fem", "postprocess", "tailslap")
PRIVATE = {
    r"tell(?:s|ing)?|told": "states, lists, reports",
    r"says?|saying|said": "states, describes",
    r"reckon\w*": "estimated, computed",
    r"giv(?:es?|ing)|gave": "yields, returns; elastic",
    r"(?<!two-)(?<!one-)ways?": "method, travel, path",
    r"mov(?:es?|ed)": "changes; displaced",
    r"lack(?:s|ing|ed)?": "does not have, requires",
    r"(?:left|leaves?|leaving) (?:\w+ )?out(?! of)": "omitted, excluded, removed",
    r"so (?:much|many|few)": "the number",
    r"of it": "of the thing, by its name",
    r"what (?:the|it|a|an)": "the quantity, by its name",
    r"shares?": "fraction",
    r"sw[iu]ngs?": "oscillates, rotates",
    r"nobody|somebody|whoever": "the user, another process",
    r"anew|alike|by itself": "again, equal, separately",
}
"""Words that are vague or private here, with standard ones."""
RETIRED = {
    r"(?:the|a|its|this|their|of|plate's|corner's|static) give(?! (?:way|and take))": "deflection or compliance",
    r"(?:the|a|its|this|by|exact|corner's|which|penalty) hold": "constraint",
    r"(?:quiet|sudden)(?:ly)? starts?|starts? (?:quiet|sudden)(?:ly)?": "inertia relief; unstressed start",
    r"spoil(?:s|t|ed|ing)?": "diverged, corrupted",
    r"calm(?:s|ed|er|ing)?": "damps, suppresses",
    r"cure[sd]?": "required damping, remedy",
    r"foret(?:ell|ells|elling|old)": "predicts",
    r"rungs?|ladders?": "refinement level",
    r"lanes?": "SIMD block",
    r"survey(?:s|ed)?": "campaign",
    r"left_out parts": "omitted parts",
}
"""Words in the meanings that they had here alone, with standard ones: in no text, description or comment."""
VAGUE_NAMES = {
    *("found", "given", "each", "own", "its", "whose", "kept", "left"),
    *("made", "asked", "told", "taken", "done", "known", "shown", "others"),
}
"""Names of variables that state the origin of a value instead of its meaning."""
LONGEST_SUMMARY = 12
"""Words in the summary line of a docstring."""


def private_words(text: str, words: Mapping[str, str] = PRIVATE | RETIRED) -> list[str]:
    """List the private words of a text with standard ones."""
    text = re.sub(r"`[^`\n]*`|\s+", " ", text)
    patterns = ((re.compile(rf"\b(?:{word})\b", re.IGNORECASE), standard) for word, standard in words.items())
    matches = ((match, standard) for pattern, standard in patterns for match in pattern.finditer(text))
    return [f"{text[max(0, m.start() - 30) : m.end() + 30]!r}: {standard}" for m, standard in matches]


def docstrings(nodes: list[ast.AST]) -> Iterator[ast.Constant]:
    """Yield docstrings of modules, classes and functions, and the strings below constants."""
    for node in nodes:
        value = node.value if isinstance(node, ast.Expr) else None
        if isinstance(value, ast.Constant) and isinstance(value.value, str):
            yield value


def comments(text: str) -> Iterator[tuple[int, str]]:
    """Yield line numbers and texts of comments."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string.lstrip("#: ")


def summaries(nodes: list[ast.AST]) -> Iterator[tuple[int, str]]:
    """Yield line numbers and first paragraphs of docstrings."""
    for node in nodes:
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node)
            if text:
                yield getattr(node, "lineno", 1), " ".join(text.split("\n\n")[0].split())


def assigned_names(nodes: list[ast.AST]) -> Iterator[tuple[int, str]]:
    """Yield line numbers and names of arguments and assigned variables.

    Fields of records are not among them: files and the interface have their names.
    """
    bodies = [node.body for node in nodes if isinstance(node, ast.ClassDef)]
    fields = {id(item.target) for body in bodies for item in body if isinstance(item, ast.AnnAssign)}
    for node in nodes:
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and id(node) not in fields:
            yield node.lineno, node.id
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg


def late_constants(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield constants in capitals below a function or class."""
    defined = False
    for node in tree.body:
        defined |= isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        names = [
            name.id for target in targets if target for name in ast.walk(target) if isinstance(name, ast.Name)
        ]
        if defined and isinstance(node, ast.Assign | ast.AnnAssign):
            yield from ((node.lineno, name) for name in names if name.isupper() and not name.startswith("__"))


def sources(paths: list[Path]) -> list[Path]:
    """List the Python files below paths, by default all."""
    folders = paths or [ROOT / name for name in (*PACKAGES, "tests", "benchmarks")]
    return sorted(file for path in folders for file in (path.rglob("*.py") if path.is_dir() else [path]))


def is_long(summary: str) -> bool:
    """Return True for a line of many words or two parts."""
    return len(summary.split()) > LONGEST_SUMMARY or bool(re.search("[;:]", summary))


def occurrences(path: Path) -> dict[str, list[str]]:
    """List the places of a file by what is wrong with them."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    nodes = [*ast.walk(tree)]
    descriptions = [*((node.lineno, str(node.value)) for node in docstrings(nodes)), *comments(text)]
    lines = {
        "private words": [(n, word) for n, words in descriptions for word in private_words(words)],
        "long first lines": [(n, summary) for n, summary in summaries(nodes) if is_long(summary)],
        "vague names": [(n, name) for n, name in assigned_names(nodes) if name in VAGUE_NAMES],
        "late constants": list(late_constants(tree)),
        "Any": [(n.lineno, "") for n in nodes if isinstance(n, ast.Name) and n.id == "Any"],
    }
    place = path.relative_to(ROOT)
    return {kind: [f"{place}:{n}: {words}" for n, words in entries] for kind, entries in lines.items()}


def print_figures(name: str, paths: list[Path], is_listed: bool) -> None:
    """Print the figures of some files, and on request every occurrence."""
    trees = [[*ast.walk(ast.parse(path.read_text(encoding="utf-8")))] for path in paths]
    lines = [summary for nodes in trees for _, summary in summaries(nodes)]
    lengths = sorted(len(summary.split()) for summary in lines) or [0]
    names = sum(1 for nodes in trees for _ in assigned_names(nodes))
    places = [occurrences(path) for path in paths]
    counts = {kind: sum(len(entries[kind]) for entries in places) for kind in places[0]}
    late_files = sum(bool(entries["late constants"]) for entries in places)
    print(f"{name}: {len(paths)} files")
    print(f"  private words in docstrings and comments: {counts['private words']}")
    middle, most = statistics.median(lengths), lengths[int(0.9 * (len(lengths) - 1))]
    words = f"words: median {middle:.0f}, nine in ten {most}"
    print(f"  first lines: {len(lines)}; {words}; long or of two parts: {counts['long first lines']}")
    print(f"  vague names: {counts['vague names']} of {names} arguments and assigned variables")
    print(f"  files with constants below a definition: {late_files}; Any: {counts['Any']}")
    if is_listed:
        print("\n".join(entry for entries in places for kind in entries.values() for entry in kind))


def main() -> None:
    """Print the figures of packages, tests and benchmarks, or of paths."""
    options = command_line.options(__doc__, ("paths", []), files=False, random=0, seed=1)
    folders = {"packages": [ROOT / name for name in PACKAGES]}
    folders |= {name: [ROOT / name] for name in ("tests", "benchmarks")}
    if options.paths:
        folders = {"paths": [Path(path).resolve() for path in options.paths]}
    for name, paths in folders.items():
        print_figures(name, sources(paths), options.files)
    files = [path for paths in folders.values() for path in sources(paths)]
    lines = [
        (f"{path.relative_to(ROOT)}:{n}", summary)
        for path in files
        for n, summary in summaries([*ast.walk(ast.parse(path.read_text(encoding="utf-8")))])
    ]
    for source, summary in random.Random(options.seed).sample(lines, min(options.random, len(lines))):
        print(f"{source}: {summary}")


if __name__ == "__main__":
    main()
