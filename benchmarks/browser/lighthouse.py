"""Lighthouse's score of pages on a slow telephone, from 0 to 100.

    .venv/bin/python benchmarks/browser/lighthouse.py results/mash-tl4-sut/report.html [PAGE...]

Needs `npm install lighthouse` in the working directory, and Chromium. Exit status 1 below 90.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

LEAST = 90
CHROMIUM = "/usr/bin/chromium"


class Quiet(SimpleHTTPRequestHandler):
    """A server that says nothing of its requests."""

    def log_message(self, *_: object) -> None:
        """Nothing."""


def score(page: Path) -> float:
    """Performance of a page that is served from this machine."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(page.parent)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://127.0.0.1:{server.server_port}/{page.name}"
    options = [
        "--only-categories=performance",
        "--output=json",
        "--quiet",
        "--chrome-flags=--headless --no-sandbox",
    ]
    command = ["npx", "lighthouse", address, *options]
    found = subprocess.run(
        command, env={**os.environ, "CHROME_PATH": CHROMIUM}, stdout=subprocess.PIPE, check=True
    )
    server.shutdown()
    return 100.0 * json.loads(found.stdout)["categories"]["performance"]["score"]


def main() -> int:
    """Print the score of each page; 1 if one is too low."""
    scores = {path: score(Path(path).resolve()) for path in sys.argv[1:]}
    for path, found in scores.items():
        print(f"{found:3.0f}  {path}")
    return int(min(scores.values()) < LEAST)


if __name__ == "__main__":
    sys.exit(main())
