"""Small pages of one section."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from postprocess.report.page import Headline, Page, Section, write_page


def page_of(*figures: Any, title: str = "Part", **parts: Any) -> Page:
    """Return a page of one section with these figures and other parts."""
    return Page("", Headline(title, ""), (Section(title, figures=figures, **parts),), "")


def written(folder: Path, *figures: Any, **parts: Any) -> Path:
    """Write a page of one section, and return its path."""
    return write_page(folder / "p.html", page_of(*figures, **parts))
