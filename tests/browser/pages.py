"""Small pages of one section, and the elements of a page."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from postprocess.report.page import Headline, Page, Section, write_page


def page_of(*figures: Any, title: str = "Part", **parts: Any) -> Page:
    """Return a page of one section with these figures and other parts."""
    return Page("", Headline(title, ""), (Section(title, figures=figures, **parts),), "")


def written(folder: Path, *figures: Any, **parts: Any) -> Path:
    """Write a page of one section, and return its path."""
    return write_page(folder / "p.html", page_of(*figures, **parts))


VOID = {"meta", "img", "br", "link", "hr", "input", "path", "rect", "circle", "image", "use", "source"}
Element = tuple[str, dict[str, str], tuple[str, ...], list[str]]


class Parsed(HTMLParser):
    """Elements with attributes, ancestors and text, all closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[Element] = []
        self.open: list[int] = []
        self.pieces: list[str] = []
        self.feed(re.sub("<template>.*?</template>", "", text, flags=re.DOTALL))  # charts in other units
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        above = tuple(self.elements[i][0] for i in self.open)
        self.elements.append((tag, {name: value or "" for name, value in attrs}, above, []))
        if tag not in VOID:
            self.open.append(len(self.elements) - 1)

    def handle_endtag(self, tag: str) -> None:
        assert tag in VOID or self.elements[self.open.pop()][0] == tag

    def handle_data(self, data: str) -> None:
        self.pieces.append(data)
        for i in self.open:
            self.elements[i][3].append(data)

    def named(self, *tags: str) -> list[Any]:
        return [(t, a, above, "".join(text).strip()) for t, a, above, text in self.elements if t in tags]

    def inside(self, tag: str) -> str:
        return "".join("".join(text) for name, _, _, text in self.elements if name == tag)

    @property
    def attributes(self) -> list[tuple[str, str, str]]:
        return [(tag, *pair) for tag, attributes, *_ in self.elements for pair in attributes.items()]

    @property
    def tags(self) -> set[str]:
        return {tag for tag, *_ in self.elements}

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.pieces).split())
