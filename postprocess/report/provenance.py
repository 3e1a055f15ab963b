"""Provenance of a result.

A digest of its files, and their description as an RO-Crate 1.1 for archives. The digest is the SHA-256 of the output
of `sha256sum` for the files in the order of their names, without the page, which shows it, and the crate. Source:
Soiland-Reyes et al., Packaging research artefacts with RO-Crate, Data Science 5 (2022).
"""

import datetime
import hashlib
import json
import mimetypes
from collections.abc import Mapping
from pathlib import Path

from postprocess.report.page import Headline
from postprocess.units import SI

CRATE = "ro-crate-metadata.json"
CONTEXT = "https://w3id.org/ro/crate/1.1"


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def files_digest(folder: Path, page: str) -> str:
    """Return the digest of a folder's files.

    Page and crate are excluded.
    """
    paths = [path for path in _files(folder) if path.name not in (page, CRATE)]
    listed = "".join(f"{file_digest(path)}  {path.name}\n" for path in paths)
    return hashlib.sha256(listed.encode()).hexdigest()


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))


def write_crate(folder: Path, page: str, digest: str, headline: Headline, origin: str, version: str) -> Path:
    """Describe the files of a folder in `ro-crate-metadata.json`.

    folder: with all files of the result; page: file name of the page, and headline: its title and answer; digest: of
    the other files; origin: description of how the result was computed; version: of the program. Returns the path of
    the file.
    """
    paths, headline = [path for path in _files(folder) if path.name != CRATE], headline.in_units(SI)
    about = {"@id": CRATE, "@type": "CreativeWork", "conformsTo": {"@id": CONTEXT}, "about": {"@id": "./"}}
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": headline.title,
        "description": " ".join(headline.lines),
        "datePublished": datetime.date.today().isoformat(),
        "identifier": f"sha256:{digest}",
        "mainEntity": {"@id": page},
        "hasPart": [{"@id": path.name} for path in paths],
    }
    program = {
        "@id": "#tailslap",
        "@type": "SoftwareApplication",
        "name": "tailslap",
        "softwareVersion": version,
    }
    action = {
        "@id": "#run",
        "@type": "CreateAction",
        "description": origin,
        "instrument": {"@id": "#tailslap"},
        "result": {"@id": "./"},
    }
    graph: list[Mapping[str, object]] = [about, root, action, program, *map(_described, paths)]
    crate = folder / CRATE
    content = {"@context": f"{CONTEXT}/context", "@graph": graph}
    crate.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return crate


def _described(path: Path) -> dict[str, str]:
    """Return the entity of a file."""
    return {
        "@id": path.name,
        "@type": "File",
        "contentSize": str(path.stat().st_size),
        "encodingFormat": mimetypes.guess_type(path.name)[0] or "application/octet-stream",
        "sha256": file_digest(path),
    }
