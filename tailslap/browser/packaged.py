"""Page within an installation, made when that is built.

It needs the standard library alone, so that an isolated build can take a page that is there.
"""

import hashlib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

SOURCES = (
    *(f"{package}/**/*.py" for package in ("machine_code", "fem", "meshes", "postprocess", "solver", "tailslap")),
    *("postprocess/templates/*", "tailslap/scene/shipped/*.toml", "tailslap/validation/*.toml"),
)  # fmt: skip
"""Files on which a page depends."""

PATH = Path(__file__).with_name("explore.html")
"""Place of the page, which is not in the repository."""


def mark() -> str:
    """Return the last line of a page of these sources."""
    digest = hashlib.sha256()
    for path in sorted(path for pattern in SOURCES for path in ROOT.glob(pattern)):
        digest.update(path.read_bytes())
    return f"<!-- sources {digest.hexdigest()} -->\n"


def is_current() -> bool:
    """Return True for a page of these sources."""
    return PATH.is_file() and PATH.read_text(encoding="utf-8").endswith(mark())
