"""Verification page of a release, with every figure of docs/accuracy.md.

    .venv/bin/python benchmarks/release.py [--out FOLDER] [--only WORDS]... [--others PYTHON] [--earlier CHECKOUT]

Each command runs once, one after the other; the page shows its output beside the statements of docs/accuracy.md, and
the outputs lie beside the page. Four to six hours on two free cores. --only: commands that contain these words.
--others: an environment with benchmarks/requirements.txt, and --earlier: another checkout, for the commands that
compare with them; without, the page states that they were not run. Exits 1 if a command failed.
"""

from __future__ import annotations

import datetime
import platform
import re
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import command_line
from command_line import ROOT

import tailslap
from postprocess.report.command_report import Report, write_report
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table
from tailslap.storage.folder import result_folder
from tailslap.storage.manifest import Origin

ACCURACY = ROOT / "docs" / "accuracy.md"

PEERS = "benchmarks/peers.py --others OTHERS"
SPEED = "benchmarks/speed.py --others OTHERS"
PROCESS = "benchmarks/process.py EARLIER --million"
FIGURES: Mapping[str, Sequence[str]] = {
    "benchmarks/rigid.py": ("agrees within 1e-10", "exact rigid solution and DOP853"),
    "benchmarks/main_job.py": ("108 cases:", "time loop of `paper-table-3`"),
    "benchmarks/core.py": (
        *("0.78 %", "proportional to 1/E", "agree within 3e-6", "largest of five differences"),
        *("E x 100", "distorted quads; triangles", "energy balance", "number of steps over"),
    ),
    "benchmarks/modal.py": ("within 5e-9", "difference of four modes", "time of the modal integration"),
    "benchmarks/sweep.py": ("sweep of 1 000 runs", "sweep after kill -9"),
    "benchmarks/vehicles.py": ("1 000 random realistic", "36 slender plates", "slow and stiff"),
    "benchmarks/rounding.py": ("ripple due to rounding",),
    "benchmarks/tolerance.py": ("the 200 scenes of the tolerance",),
    "benchmarks/size.py": ("a million elements: time per step",),
    "benchmarks/stated_error.py 600": ("Numerical error", "600 coarse, wide, soft"),
    "benchmarks/stated_error.py 150 9 --unstressed": ("150 of the same, two of three",),
    "-m tailslap confirm paper-table-3 --set corner.reaction=none": ("Another solver",),
    SPEED: ("element updates per second", "distorted mesh, 122 880", "speed-up by two threads"),
    PEERS: (
        *("agrees with them within 1.2e-12", "| `tailslap run` |", "with the model of the others"),
        *("Akantu 5.0.7 |", "Kratos 10.4.4 |", "Warp 1.19.0 |"),
        *("distorted elements: `tailslap run`", "Rigid bodies: `tailslap rigid`"),
    ),
    PROCESS: (
        *("process time relative to", "with three pictures", "`rigid paper-table-3`; row of a sweep"),
        "a million elements: initial state",
    ),
}
"""Words of docs/accuracy.md that name a figure, by the command that measures it, after the interpreter."""


NOT_MEASURED = ("| quantity |", "| code |", "|---", "On two cores", "All figures", "Scene `paper-abaqus` to")
"""Beginnings of statements of docs/accuracy.md without a figure of their own."""


@dataclass(frozen=True)
class Measured:
    """Output, status and time [s] of a command, None if not run."""

    command: str
    text: str
    status: int | None
    seconds: float

    @property
    def outcome(self) -> str:
        """Outcome in words."""
        if self.status is None:
            return "not run"
        return "ran" if self.status == 0 else f"exit status {self.status}"


def statements(text: str) -> list[str]:
    """Rows, list items and paragraphs of a page in Markdown."""
    blocks = re.split(r"\n(?=\||- |#|\n)", text)
    lines = (" ".join(block.split()) for block in blocks)
    return [line for line in lines if re.search(r"\d", line) and not line.startswith(("#", "!"))]


def stated(words: str, lines: Iterable[str]) -> str:
    """The statement that contains these words.

    Raises ValueError where that is not one.
    """
    matches = [line for line in lines if words in line]
    if len(matches) != 1:
        raise ValueError(f"docs/accuracy.md has {len(matches)} statements with {words!r}")
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", matches[0])
    return plain.strip("|- ").replace("**", "").replace(" | ", "; ")


def unmeasured(lines: Iterable[str]) -> list[str]:
    """List the statements with figures that no command measures."""
    words = [word for every in FIGURES.values() for word in every]
    return [s for s in lines if not s.startswith(NOT_MEASURED) and not any(word in s for word in words)]


def measure(command: str, paths: Mapping[str, str | None]) -> Measured:
    """Run a command with its paths, or return it as not run."""
    for name, value in paths.items():
        if name in command and value is None:
            return Measured(command, f"requires --{name.lower()}", None, 0.0)
        command = command.replace(name, value or "")
    began = time.perf_counter()
    print(f"{command} ...", file=sys.stderr, flush=True)
    run = subprocess.run([sys.executable, *command.split()], cwd=ROOT, capture_output=True, text=True)
    text = run.stdout if run.returncode == 0 else run.stdout + run.stderr
    return Measured(command, text, run.returncode, time.perf_counter() - began)


def report(figures: Mapping[str, Sequence[str]], runs: Sequence[Measured], commit: str) -> Report:
    """Report of all figures with commands, outcomes and outputs."""
    lines = statements(ACCURACY.read_text(encoding="utf-8"))
    rows = [
        {"stated": stated(words, lines), "command": f"`python {run.command}`", "outcome": run.outcome}
        for run, every in zip(runs, figures.values(), strict=True)
        for words in every
    ]
    heads = (Column("stated", "docs/accuracy.md"), Column("command", "Command"), Column("outcome", "Outcome"))
    failed = [run.command for run in runs if run.status]
    omitted = sum(run.status is None for run in runs)
    answer = (
        f"{len(runs) - omitted} of {len(runs)} commands ran for {len(rows)} figures; {len(failed)} failed."
    )
    machine = f"{platform.machine()}, Python {platform.python_version()}, commit {commit}."
    sections = [Section("Figures", tables=[Table(heads, rows)]), *map(_printed, runs)]
    below = f"tailslap {tailslap.__version__}, {datetime.date.today().isoformat()}, `python benchmarks/release.py`."
    headline = Headline(f"Verification of tailslap {tailslap.__version__}", answer, machine)
    page = Page("Release", headline, sections, below, passed=not failed, checked="commands")
    texts = {f"{re.sub(r'[^a-z0-9]+', '-', run.command).strip('-')}.txt": run.text for run in runs}
    summary = {"version": tailslap.__version__, "commit": commit, "passed": not failed, "figures": rows}
    summary["seconds"] = {run.command: run.seconds for run in runs}
    return Report(page, summary, (), texts=texts)


def _printed(run: Measured) -> Section:
    """Return the output of a command in columns."""
    cells = [re.split(r"\s{2,}", line.strip(), maxsplit=3) for line in run.text.splitlines() if line.strip()]
    width = max(map(len, cells), default=1)
    rows = [{str(k): cell for k, cell in enumerate(line)} for line in cells]
    rows = [{**dict.fromkeys(map(str, range(width)), ""), **row} for row in rows]
    table = Table(tuple(Column(str(k), "") for k in range(width)), rows)
    lead = f"Exit status {run.status}, {run.seconds:.0f} s." if run.status is not None else "Not run."
    return Section(f"python {run.command}", lead, tables=[table], is_folded=True)


def main() -> int:
    """Run the commands and write the page, and return the status."""
    options = command_line.options(__doc__, out="results/release", only=[], others=str, earlier=str)
    chosen = {
        c: f for c, f in FIGURES.items() if not options.only or any(words in c for words in options.only)
    }
    omitted = unmeasured(statements(ACCURACY.read_text(encoding="utf-8")))
    if omitted:
        raise SystemExit("docs/accuracy.md has figures without a command:\n" + "\n".join(omitted))
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    with result_folder(Path(options.out), origin=Origin("release", "")) as folder:
        paths = {"OTHERS": options.others, "EARLIER": options.earlier}
        page_report = report(chosen, [measure(command, paths) for command in chosen], commit.stdout.strip())
        write_report(page_report, folder)
    print(f"{page_report.page.headline.answer}\nPage: {options.out}/report.html")
    return 0 if page_report.passed else 1


if __name__ == "__main__":
    sys.exit(main())
