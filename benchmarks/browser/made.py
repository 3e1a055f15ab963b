"""Result folders with every page that the program writes, in small."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from postprocess.report.command_report import PAGE

RUN, IMPACT, MESH = "run mash-tl4-sut", "impact-mash-tl4-sut", "--set plate.elements=[8,4]"
FLUTTER = "--set impact.friction=0.8 --set corner.penalty_scale=3 --set damping.kind=none"
COMMANDS = {
    "run": RUN,
    "run-us": f"{RUN} --units us",
    "run-failed": f"{RUN} {FLUTTER}",
    "run-fields": f"{RUN} --set output.fields=3",
    "run-tolerance": "run paper-table-3 --tolerance 1e-3 --no-pictures",
    "impact": f"run {IMPACT}",
    "impact-us": f"run {IMPACT} --no-pictures --units us",
    "train": "run impact-mash-tl5-tractor-van",
    "tipping": "run impact-tipping-tl4-sut",
    "confirm": f"confirm paper-table-3 --set corner.reaction=none {MESH}",
    "modes": "modes paper-table-3",
    "modes-train": "modes impact-mash-tl5-tractor-van",
    "paper": "paper",
    "sweep": "sweep mash-tl4-sut --vary impact.friction=0.2:0.4:3 --vary impact.speed=80km/h,90km/h",
    "sweep-impact": f"sweep {IMPACT} --vary impact.friction=0.2,0.3 {MESH}",
    "compare": "compare {run} {run-us} {run-fields}",
    "uncertainty": "study uncertainty mash-tl4-sut --samples 1000",
    "uncertainty-impact": f"study uncertainty {IMPACT} --samples 300",
    "uncertainty-train": "study uncertainty impact-mash-tl5-tractor-van --samples 288",
    "tipping-study": "study tipping impact-tipping-tl4-sut --samples 288",
    "flexibility": "study flexibility mash-tl4-sut --points 4",
    "flexibility-impact": f"study flexibility {IMPACT} --points 4 --set plate.elements=[10,4]",
    "stability-random": f"study stability paper-table-3 --random 3 {MESH}",
    "stability-impact": f"study stability {IMPACT} --points 2 {MESH}",
    "cost": f"study cost paper-table-3 {MESH}",
    "cost-impact": f"study cost {IMPACT} {MESH}",
}
"""By name of the page; {run} is another page's folder, which stands before."""

FOUND_SOMETHING = 1
"""Exit status of a command that has a page nevertheless."""


def make_page(name: str, folder: Path) -> Path:
    """The page of a command in `folder`, made if it is not there. Raises RuntimeError where there is none."""
    place = folder / name
    if not list(place.glob("*.html")):
        folders = {other: str(folder / other) for other in COMMANDS}
        words = [word.format_map(folders) for word in COMMANDS[name].split()]
        _demand_done([*words, "--quiet", "--out", str(place)])
    return page_of(place)


def _demand_done(words: Sequence[str]) -> None:
    done = subprocess.run([sys.executable, "-m", "tailslap", *words], capture_output=True, text=True)
    if done.returncode not in (0, FOUND_SOMETHING):
        raise RuntimeError(f"tailslap {' '.join(words)}: {done.stderr.strip()}")


def page_of(place: Path) -> Path:
    """The page of a result folder, or the page itself."""
    if place.is_file():
        return place
    pages = sorted(place.glob("*.html"))
    if not pages:
        raise RuntimeError(f"{place} has no page")
    return next((page for page in pages if page.name == PAGE), pages[0])
