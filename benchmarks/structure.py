"""The structure of the sources in figures.

    .venv/bin/python benchmarks/structure.py [--files] [--trace]

Lines of code are those without docstrings, comments and blank lines. Modules that report are those of `postprocess`,
and those named report or like *_report, or in a folder of that name; signals and comparison compute and are counted
apart. An import circle counts lazy and type-only imports. With --files, each file. With --trace also the calls of a run
of paper-table-3 up to its time loop: the files that they enter, how often they climb back from `fem` into `tailslap`,
and how many meshes are made of one plate.
"""

from __future__ import annotations

import ast
import functools
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator
from io import StringIO
from itertools import pairwise
from pathlib import Path
from types import FrameType

import command_line
from command_line import ROOT

PACKAGES = ("solver", "meshes", "machine_code", "fem", "postprocess", "tailslap")
SKIPPED = {
    *(tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE),
    *(tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER),
}
UNIX_MODULES = {"fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty"}
UNIX_NAMES = {
    "os": {
        *(
            "O_ASYNC",
            "O_CLOEXEC",
            "O_DIRECTORY",
            "O_NOFOLLOW",
            "O_NONBLOCK",
            "WNOHANG",
            "chown",
            "fchmod",
            "fdatasync",
        ),
        *(
            "fork",
            "forkpty",
            "getegid",
            "geteuid",
            "getgid",
            "getloadavg",
            "getpgid",
            "getpgrp",
            "getuid",
            "killpg",
        ),
        *("mkfifo", "nice", "posix_fallocate", "pread", "pwrite", "register_at_fork", "sched_getaffinity"),
        *(
            "sched_setaffinity",
            "sendfile",
            "set_blocking",
            "setpgid",
            "setsid",
            "statvfs",
            "sync",
            "sysconf",
            "uname",
        ),
        *("wait", "wait3", "wait4", "waitid"),
    },
    "signal": {
        *(
            "SIGALRM",
            "SIGCHLD",
            "SIGHUP",
            "SIGIO",
            "SIGKILL",
            "SIGPIPE",
            "SIGQUIT",
            "SIGUSR1",
            "SIGUSR2",
            "SIGXFSZ",
        ),
        *(
            "SIG_BLOCK",
            "SIG_SETMASK",
            "SIG_UNBLOCK",
            "alarm",
            "pthread_kill",
            "pthread_sigmask",
            "setitimer",
            "sigwait",
        ),
    },
}
"""Modules, and names in modules, that are missing on Windows, and some of them on macOS."""

SMALL = 40
"""Lines of code below which a module is too small to be a subject."""
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def sources(root: Path = ROOT) -> list[Path]:
    """The modules of the six packages."""
    return [path for package in PACKAGES for path in sorted((root / package).rglob("*.py"))]


def code_lines(text: str) -> int:
    """Lines without docstrings, comments and blank lines."""
    described: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, DOCUMENTED) and node.body and ast.get_docstring(node, clean=False) is not None:
            described |= set(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    lines: set[int] = set()
    for token in tokenize.generate_tokens(StringIO(text).readline):
        if token.type not in SKIPPED:
            lines |= set(range(token.start[0], token.end[0] + 1))
    return len(lines - described)


def import_lines(text: str) -> int:
    """Lines of import statements, those within functions included."""
    statements = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import | ast.ImportFrom))
    return sum((node.end_lineno or node.lineno) - node.lineno + 1 for node in statements)


def classes(root: Path = ROOT) -> Counter[str]:
    """Names of classes at the head of modules, with their numbers."""
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in sources(root))
    return Counter(node.name for tree in trees for node in tree.body if isinstance(node, ast.ClassDef))


def reports(path: Path) -> bool:
    """Return True for modules that write text, tables or pictures."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    computes = parts[:2] in {("postprocess", "signals"), ("postprocess", "comparison")}
    return not computes and (parts[0] == "postprocess" or any("report" in part for part in parts))


def module_name(path: Path) -> str:
    """Dotted name of a module or package."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(path: Path, names: set[str]) -> Iterator[str]:
    """Modules of the packages that a module imports anywhere.

    At its head, within functions, for types, or by the name of a function, "module:function".
    """
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in names)
        elif isinstance(node, ast.ImportFrom) and node.module in names:
            below = {f"{node.module}.{alias.name}" for alias in node.names}
            yield from below & names or {node.module}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from {node.value.partition(":")[0]} & names if ":" in node.value else ()


@functools.cache
def import_graph(root: Path = ROOT) -> dict[str, set[str]]:
    """Modules that each module imports anywhere."""
    paths = {module_name(path): path for path in sources(root)}
    return {name: set(imports(path, set(paths))) for name, path in paths.items()}


def circles(root: Path = ROOT) -> list[list[str]]:
    """Groups of modules that import each other.

    Tarjan's components of more than one.
    """
    graph = {name: imported - {name} for name, imported in import_graph(root).items()}
    reach = {name: _reached(graph, name) for name in graph}
    groups = {frozenset(imported for imported in reach[name] if name in reach[imported]) for name in graph}
    return sorted(sorted(group) for group in groups if len(group) > 1)


def _reached(graph: dict[str, set[str]], start: str) -> set[str]:
    modules: set[str] = set()
    remaining = [start]
    while remaining:
        for name in graph[remaining.pop()] - modules:
            modules.add(name)
            remaining.append(name)
    return modules


def flat(root: Path = ROOT) -> Counter[str]:
    """Modules by folder."""
    return Counter(str(path.parent.relative_to(root)) for path in sources(root) if path.name != "__init__.py")


def trace(scene: str = "paper-table-3") -> tuple[int, int, int]:
    """Count files entered before the time loop, climbs and meshes.

    Climbs are from `fem` into `tailslap`, meshes those of the plate.
    """
    from fem import cache
    from tailslap.case.corner.corner_case import CornerCase
    from tailslap.scene.read import read_scene

    plan, calls = CornerCase(*read_scene(scene)), []

    def note(frame: FrameType, event: str, _: object) -> None:
        path = Path(frame.f_code.co_filename)
        if event == "call" and path.is_relative_to(ROOT) and path.parts[len(ROOT.parts)] in PACKAGES:
            calls.append((path.relative_to(ROOT), frame.f_code.co_name))
            if frame.f_code.co_name == "simulate":
                sys.setprofile(None)

    plan.run()  # imports and compiles
    cache.clear()
    sys.setprofile(note)
    try:
        plan.run()
    finally:
        sys.setprofile(None)
    packages = [path.parts[0] for path, _ in calls]
    climbs = sum(pair == ("fem", "tailslap") for pair in pairwise(packages))
    return len({path for path, _ in calls}), climbs, sum(name == "plate_mesh" for _, name in calls)


def assertions(root: Path = ROOT) -> int:
    """Count asserts, and blocks that expect an error or warning."""
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in (root / "tests").rglob("*.py"))
    nodes = [node for tree in trees for node in ast.walk(tree)]
    calls = [ast.unparse(node.func) for node in nodes if isinstance(node, ast.Call)]
    expected = calls.count("pytest.raises") + calls.count("pytest.warns")
    return sum(isinstance(node, ast.Assert) for node in nodes) + expected


def of_one_system(root: Path = ROOT) -> list[str]:
    """Names that are missing on Windows or macOS.

    The module of operating systems may have them.
    """
    uses = []
    for path in [*sources(root), root / "bootstrap.py"]:
        if path.stem == "operating_system":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += (
                [f"{node.module}.{a.name}" for a in node.names] if isinstance(node, ast.ImportFrom) else []
            )
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                names.append(f"{node.value.id}.{node.attr}")
            for name in names:
                head, _, tail = name.partition(".")
                if head in UNIX_MODULES or tail in UNIX_NAMES.get(head, ()):
                    uses.append(f"{path.relative_to(root)}: {name}")
    return uses


def main() -> None:
    """Print the figures."""
    options = command_line.options(__doc__, files=False, trace=False)
    texts = {path: path.read_text(encoding="utf-8") for path in sources()}
    lines = {path: code_lines(text) for path, text in texts.items()}
    total = sum(lines.values())
    if options.files:
        for path, count in lines.items():
            print(f"{count:5d}  {'report' if reports(path) else '      '}  {path.relative_to(ROOT)}")
    for package in PACKAGES:
        count = sum(n for path, n in lines.items() if path.is_relative_to(ROOT / package))
        print(f"{package:<12} {count:6d} lines")
    reporting = sum(n for path, n in lines.items() if reports(path))
    share = f"{reporting} of them report ({100.0 * reporting / total:.1f} %)"
    print(f"{'together':<12} {total:6d} lines, {share}")
    importing = sum(map(import_lines, texts.values()))
    print(f"{len(lines)} files; imports {importing} lines ({100.0 * importing / total:.1f} %)")
    small = [path for path, count in lines.items() if count < SMALL and not path.stem.startswith("__")]
    print(f"modules below {SMALL} lines: {len(small)}; longest {max(lines.values())} lines")
    twice = sorted(name for name, count in classes().items() if count > 1)
    print(f"class names that exist twice: {len(twice)} {' '.join(twice)}")
    for study in sorted(path for path in (ROOT / "tailslap" / "studies").iterdir() if path.is_dir()):
        count = sum(n for path, n in lines.items() if path.is_relative_to(study))
        print(f"study {study.name}: {count} lines" if count else "", end="\n" if count else "")
    tests = sum(code_lines(path.read_text(encoding="utf-8")) for path in (ROOT / "tests").rglob("*.py"))
    print(f"tests: {tests} lines, {assertions()} assertions")
    name, most = flat().most_common(1)[0]
    print(f"most modules in one folder: {most} in {name}")
    print(f"import circles: {len(circles())}")
    for circle in circles():
        print("   ", ", ".join(circle))
    print(f"names of one operating system outside its module: {len(of_one_system())}")
    if options.trace:
        files, climbs, meshes = trace()
        calls = f"{files} files, {climbs} climbs from fem into tailslap, {meshes} meshes of the plate"
        print(f"up to the time loop: {calls}")


if __name__ == "__main__":
    main()
