"""Accessibility of a page, its width, and broken numbers."""

from __future__ import annotations

from typing import Any

OUTSIDE = """() => {
  const scrolls = (part) => part && part !== document.body && (part.tagName === "svg"
    || ["auto", "scroll"].includes(getComputedStyle(part).overflowX) || scrolls(part.parentElement));
  const wide = document.documentElement.clientWidth + 1;
  const found = [...document.body.querySelectorAll("*")].filter((part) =>
    part.getBoundingClientRect().right > wide && !scrolls(part.parentElement));
  const said = found.map((part) => `<${part.tagName.toLowerCase()}> ${part.textContent.trim().slice(0, 40)}`);
  return document.documentElement.scrollWidth > wide ? ["the page scrolls sideways", ...said] : said;
}"""
"""What reaches beyond the window and is in no box that scrolls."""
BROKEN = """() => {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), found = [];
  while (walker.nextNode()) {
    const node = walker.currentNode;
    if (node.parentElement.closest("script, style, svg, pre, code, .unseen")) continue;
    for (const word of node.data.matchAll(/[^ \\n\\/,;\\[\\]()]*\\d[^ \\n\\/,;\\[\\]()]*/g)) {
      const range = document.createRange();
      range.setStart(node, word.index);
      range.setEnd(node, word.index + word[0].length);
      const boxes = [...range.getClientRects()].filter((box) => box.width);
      if (new Set(boxes.map((box) => Math.round(box.bottom))).size > 1) found.push(word[0]);
    }
  }
  return found;
}"""
"""Words with digits, like TL-4, that stand on two lines."""


def violations(page: Any) -> list[str]:
    """List the rules of axe-core that a page breaks, with elements."""
    from axe_playwright_python.sync_playwright import Axe

    violations = Axe().run(page).response["violations"]
    return [f"axe {rule['id']}: {rule['help']}, {rule['nodes'][0]['html'][:120]}" for rule in violations]


def outside(page: Any) -> list[str]:
    """What sticks out at the side."""
    return [f"sticks out: {said}" for said in page.evaluate(OUTSIDE)]


def broken(page: Any) -> list[str]:
    """Numbers and names with a number that are broken across lines."""
    return [f"broken across lines: {word}" for word in page.evaluate(BROKEN)]
