"""Print size, elements and mobile score of report pages.

    .venv/bin/python benchmarks/lighthouse.py [SCENE|RESULT ...] [--times N] [--lighthouse COMMAND]

Lighthouse audits pages that are served from this machine without compression, as on a telephone with a slow network.
Requires Chromium at /usr/bin/chromium and npx. Scores depend on the load of the machine, which is printed.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import command_line

CHROMIUM = Path("/usr/bin/chromium")
SCENES = ("mash-tl4-sut", "impact-mash-tl4-sut", "impact-tipping-tl4-sut", "impact-mash-tl5-tractor-van")
TIMES = ("first-contentful-paint", "largest-contentful-paint", "total-blocking-time")
"""Audits in the table [ms]."""
TITLES = ("kB", "elements", "FCP ms", "LCP ms", "TBT ms", "score", "access.", "load")


class Quiet(SimpleHTTPRequestHandler):
    """Server of files without a log."""

    def log_message(self, *_: Any) -> None:
        """Print nothing."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a folder at the address."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()


def audited(address: str, lighthouse: str) -> dict[str, Any]:
    """Return the report of Lighthouse for a page on a simulated telephone."""
    options = ["--quiet", "--output=json", "--only-categories=performance,accessibility"]
    flags = "--chrome-flags=--headless --no-sandbox --disable-gpu"
    command = [*shlex.split(lighthouse), address, *options, flags]
    environment = os.environ | {"CHROME_PATH": str(CHROMIUM)}
    output = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout
    return dict(json.loads(output))


def measured(scene: str, lighthouse: str, times: int) -> list[float]:
    """Return the numbers of the page of a scene or result folder.

    They are its size [kB], elements, times [ms] and scores.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scene) if Path(scene).is_dir() else Path(scratch) / "result"
        if not folder.exists():
            command_line.run_command("run", scene, "--quiet", "--out", folder)
        with served(folder) as address:
            reports = [audited(f"{address}/report.html", lighthouse) for _ in range(times)]
        size = (folder / "report.html").stat().st_size / 1e3
    best = max(reports, key=lambda report: report["categories"]["performance"]["score"])
    scores = [100 * best["categories"][name]["score"] for name in ("performance", "accessibility")]
    audits = [best["audits"][name]["numericValue"] for name in ("dom-size", *TIMES)]
    return [size, *audits, *scores]


def main() -> None:
    """Print a line for each page."""
    arguments = command_line.options(__doc__, ("scenes", []), lighthouse="npx --yes lighthouse@12", times=3)
    print(("{:30}" + "{:>9}" * len(TITLES)).format("page, best of its audits", *TITLES))
    for scene in arguments.scenes or SCENES:
        numbers = [*measured(scene, arguments.lighthouse, arguments.times), os.getloadavg()[0]]
        print(f"{scene:30}" + "".join(f"{number:9.0f}" for number in numbers), flush=True)


if __name__ == "__main__":
    main()
