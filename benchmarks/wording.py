"""Print how the sources read: words of no textbook, summary lines, local names, constants below definitions, Any.

    .venv/bin/python benchmarks/wording.py [--files] [--random N] [--seed N] [PATH ...]

With --files every occurrence is listed with its line, with --random N summary lines are drawn at random. Paths
restrict the count to files and folders of the packages, tests and benchmarks.

The list of words is the only one of the project; test_words.py and test_style.py apply it.
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
    """List the private words of a text in their context, with standard ones."""
    text = re.sub(r"`[^`\n]*`|\s+", " ", text)
    patterns = ((re.compile(rf"\b(?:{each})\b", re.IGNORECASE), standard) for each, standard in words.items())
    matches = ((match, standard) for pattern, standard in patterns for match in pattern.finditer(text))
    return [f"{text[max(0, m.start() - 30) : m.end() + 30]!r}: {standard}" for m, standard in matches]


def docstrings(tree: ast.AST) -> Iterator[ast.Constant]:
    """Yield docstrings of modules, classes and functions, and the strings below constants."""
    for node in ast.walk(tree):
        for child in ast.iter_child_nodes(node):
            value = child.value if isinstance(child, ast.Expr) else None
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                yield value


def comments(text: str) -> Iterator[tuple[int, str]]:
    """Yield line numbers and texts of comments."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string.lstrip("#: ")


def descriptions(text: str) -> list[tuple[int, str]]:
    """List line numbers and texts of the docstrings and comments of a module."""
    return [*((node.lineno, str(node.value)) for node in docstrings(ast.parse(text))), *comments(text)]


def summaries(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield line numbers and summary lines, up to the first blank line, of modules, classes and functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node)
            if text:
                yield getattr(node, "lineno", 1), " ".join(text.split("\n\n")[0].split())


def assigned_names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield line numbers and names of variables that are assigned."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id


def late_constants(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield constants in capitals that a module declares below its first function or class."""
    defined = False
    for node in tree.body:
        defined |= isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        names = [
            name.id for target in targets if target for name in ast.walk(target) if isinstance(name, ast.Name)
        ]
        if defined and isinstance(node, ast.Assign | ast.AnnAssign):
            yield from ((node.lineno, name) for name in names if name.isupper() and not name.startswith("__"))


def any_annotations(tree: ast.AST) -> Iterator[int]:
    """Yield line numbers where `Any` is used."""
    yield from (node.lineno for node in ast.walk(tree) if isinstance(node, ast.Name) and node.id == "Any")


def sources(paths: list[Path]) -> list[Path]:
    """List the Python files below paths, by default those of packages, tests and benchmarks."""
    folders = paths or [ROOT / name for name in (*PACKAGES, "tests", "benchmarks")]
    return sorted(file for path in folders for file in (path.rglob("*.py") if path.is_dir() else [path]))


def main() -> None:
    """Print the counts, and on request every occurrence."""
    options = command_line.options(__doc__, ("paths", []), files=False, random=0, seed=1)
    listed: dict[str, list[str]] = {"private words": [], "vague names": [], "late constants": [], "Any": []}
    lines: list[tuple[str, str]] = []
    names, late_files = 0, set()
    for path in sources([Path(path).resolve() for path in options.paths]):
        text, place = path.read_text(encoding="utf-8"), path.relative_to(ROOT)
        tree = ast.parse(text)
        for line, words in descriptions(text):
            listed["private words"] += [f"{place}:{line}: {word}" for word in private_words(words)]
        packaged = place.parts[0] in PACKAGES
        for line, name in assigned_names(tree):
            names += packaged
            if name in VAGUE_NAMES and packaged:
                listed["vague names"].append(f"{place}:{line}: {name}")
        if packaged:
            late = [f"{place}:{line}: {name}" for line, name in late_constants(tree)]
            late_files |= {place} if late else set()
            listed["late constants"] += late
            listed["Any"] += [f"{place}:{line}" for line in any_annotations(tree)]
            lines += [(f"{place}:{line}", summary) for line, summary in summaries(tree)]
    lengths = sorted(len(summary.split()) for _, summary in lines) or [0]
    joined = sum(bool(re.search("[;:]", summary)) for _, summary in lines)
    print(f"private words in docstrings and comments: {len(listed['private words'])}")
    print(
        f"summary lines: {len(lines)}; words: median {statistics.median(lengths):.0f}, nine in ten "
        f"{lengths[int(0.9 * (len(lengths) - 1))]}; with ; or : {100 * joined / max(1, len(lines)):.1f} %"
    )
    vague = listed["vague names"]
    print(f"vague names: {len(vague)} of {names} assigned ({100 * len(vague) / max(1, names):.1f} %)")
    print(f"files with constants below a definition: {len(late_files)}")
    print(f"Any: {len(listed['Any'])}")
    if options.files:
        print("\n".join(entry for entries in listed.values() for entry in entries))
        for source, summary in lines:
            if len(summary.split()) > LONGEST_SUMMARY or re.search("[;:]", summary):
                print(f"{source}: {summary}")
    for source, summary in random.Random(options.seed).sample(lines, min(options.random, len(lines))):
        print(f"{source}: {summary}")


if __name__ == "__main__":
    main()
