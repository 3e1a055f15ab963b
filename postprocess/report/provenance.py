"""Provenance of a result: a digest of its files, and their description as an RO-Crate 1.1 for archives.

The digest is the SHA-256 of what `sha256sum` prints of the files in the order of their names, but for the page, which
shows it, and the crate. Source: Soiland-Reyes et al., Packaging research artefacts
with RO-Crate, Data Science 5 (2022).
"""

import datetime
import hashlib
import json
import mimetypes
from pathlib import Path
from typing import Any

from postprocess.report.page import Headline
from postprocess.units import SI

CRATE = "ro-crate-metadata.json"
CONTEXT = "https://w3id.org/ro/crate/1.1"


def file_digest(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def files_digest(folder: Path, page: str) -> str:
    """Digest of the files of a folder, page and crate excluded."""
    paths = [path for path in _files(folder) if path.name not in (page, CRATE)]
    listed = "".join(f"{file_digest(path)}  {path.name}\n" for path in paths)
    return hashlib.sha256(listed.encode()).hexdigest()


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))


def write_crate(folder: Path, page: str, headline: Headline, made: str, version: str) -> Path:
    """Describe the files of a folder in `ro-crate-metadata.json`.

    Parameters
    ----------
    folder : Path
        With all files of the result.
    page : str
        File name of its page.
    headline : Headline
        Title and answer of the page.
    made : str
        How the result was made, in words.
    version : str
        Of the program.

    Returns
    -------
    Path
        The file.
    """
    paths, headline = [path for path in _files(folder) if path.name != CRATE], headline.in_units(SI)
    about = {"@id": CRATE, "@type": "CreativeWork", "conformsTo": {"@id": CONTEXT}, "about": {"@id": "./"}}
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": headline.title,
        "description": " ".join(headline.lines),
        "datePublished": datetime.date.today().isoformat(),
        "identifier": f"sha256:{files_digest(folder, page)}",
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
        "description": made,
        "instrument": {"@id": "#tailslap"},
        "result": {"@id": "./"},
    }
    graph = [about, root, action, program, *map(_described, paths)]
    crate = folder / CRATE
    content = {"@context": f"{CONTEXT}/context", "@graph": graph}
    crate.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return crate


def _described(path: Path) -> dict[str, Any]:
    """Entity of a file."""
    return {
        "@id": path.name,
        "@type": "File",
        "contentSize": str(path.stat().st_size),
        "encodingFormat": mimetypes.guess_type(path.name)[0] or "application/octet-stream",
        "sha256": file_digest(path),
    }
