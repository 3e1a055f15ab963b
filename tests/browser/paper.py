"""Cells, headings and captions of a page printed on A4."""

from __future__ import annotations

import io
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

PAPER_WIDTH = round((210 - 2 * 12) / 25.4 * 96)
"""Pixels between the margins of A4."""
FAR = 4000
"""Letters after which the next cell of a table is not looked for: a page of other text."""
BEGINNING = 3
"""Cells by which the beginning of a table is recognised."""
TEXTS = """() => {
  const said = (part) => part.innerText;
  const all = (of, what) => [...of.querySelectorAll(what)].map(said);
  return {
    tables: [...document.querySelectorAll("table")].map((table) =>
      ({ name: said(table.querySelector("caption")), cells: all(table, "th, td") })),
    others: all(document, "h1, h2, h3, caption:not(.unseen), figcaption"),
  };
}"""


@dataclass(frozen=True)
class Printed:
    """Text of a PDF, its pages, and words outside of the paper."""

    text: str
    pages: int
    outside: tuple[str, ...]


def bare(text: str) -> str:
    """Letters without blanks, ligatures and superscripts."""
    return "".join(unicodedata.normalize("NFKC", text).split())


def read_pdf(content: bytes) -> Printed:
    """Return the text of a PDF."""
    from pypdf import PdfReader

    pages = PdfReader(io.BytesIO(content)).pages
    outside: list[str] = []
    texts = [page.extract_text(visitor_text=_collector(page, outside)) for page in pages]
    return Printed(bare("".join(texts)), len(pages), tuple(outside))


def _collector(page: Any, outside: list[str]) -> Any:
    """Notes text that begins outside of the paper."""

    def note(text: str, matrix: list[float], place: list[float], *_: Any) -> None:
        across = matrix[0] * place[4] + matrix[2] * place[5] + matrix[4]
        if text.strip() and not 0.0 <= across <= float(page.mediabox.width):
            outside.append(text.strip())

    return note


def missing(page: Any) -> list[str]:
    """Cells, headings and captions of a page missing in its PDF."""
    texts = page.evaluate(TEXTS)
    printed = read_pdf(page.pdf(prefer_css_page_size=True, print_background=True))
    lost = [text for text in texts["others"] if bare(text) not in printed.text]
    faults = [f"not on paper: {text.strip()[:60]}" for text in lost]
    faults += [f"outside of the paper: {text[:60]}" for text in printed.outside]
    return faults + list(_lost_cells(texts["tables"], printed.text))


def _lost_cells(tables: list[dict[str, Any]], text: str) -> Iterator[str]:
    """Cells are in order, each behind the one before."""
    at = 0
    for table in tables:
        cells = list(filter(None, map(bare, table["cells"])))
        at = max(at, text.find("".join(cells[:BEGINNING]), at))
        for cell in cells:
            place = text.find(cell, at, at + FAR)
            if place < 0:
                yield f'not on paper, of table "{table["name"].strip()[:40]}": {cell[:40]}'
            else:
                at = place + len(cell)
