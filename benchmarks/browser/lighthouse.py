"""Lighthouse's performance score of pages on a slow telephone, from 0 to 100.

    .venv/bin/python benchmarks/browser/lighthouse.py results/mash-tl4-sut/report.html [PAGE...]

Needs `npm install lighthouse` in the working directory, and Chromium. Exit status 1 below 90.
"""

from __future__ import annotations

import gzip
import json
import os
import subprocess
import sys
import threading
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

LEAST = 90
CHROMIUM = "/usr/bin/chromium"


class Compressed(BaseHTTPRequestHandler):
    """A server of one page, compressed as by common web servers, without a log."""

    def __init__(self, page: Path, *rest: Any) -> None:
        self.body = gzip.compress(page.read_bytes())
        super().__init__(*rest)

    def do_GET(self) -> None:
        """Send the page."""
        self.send_response(200)
        for name, value in {
            "Content-Type": "text/html; charset=utf-8",
            "Content-Encoding": "gzip",
            "Content-Length": str(len(self.body)),
        }.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(self.body)

    def log_message(self, *_: object) -> None:
        """Write no log."""


def score(page: Path) -> float:
    """Performance of a page that this machine serves."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Compressed, page))
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
