"""Faults of charts on a page, as cut or overlapping words."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

EMPTY = """() => [...document.querySelectorAll("figure")].filter((figure) => {
  const marks = [...figure.querySelectorAll("svg path, svg circle, svg rect:not(.paper), svg image, svg text")];
  const size = (mark) => mark.getBoundingClientRect().width + mark.getBoundingClientRect().height;
  const drawn = marks.filter((mark) => size(mark) > 0);
  const pictures = [...figure.querySelectorAll("img")].filter((image) => image.naturalWidth > 0);
  return drawn.length < 2 && !pictures.length;
}).map((figure) => figure.textContent.trim().slice(0, 60))"""
WORDS = """() => {
  const found = [];
  for (const svg of document.querySelectorAll("svg.chart")) {
    const frame = svg.getBoundingClientRect(), name = svg.getAttribute("aria-label").slice(0, 40);
    const words = [...svg.querySelectorAll("text")].filter((text) => text.textContent.trim())
      .map((text) => [text.textContent, text.getBoundingClientRect()]).filter(([, box]) => box.width);
    words.forEach(([text, box], i) => {
      if (box.left < frame.left - 1 || box.right > frame.right + 1) found.push(`cut in "${name}": ${text}`);
      words.slice(0, i).forEach(([other, its]) => {
        const across = Math.min(box.right, its.right) - Math.max(box.left, its.left);
        const down = Math.min(box.bottom, its.bottom) - Math.max(box.top, its.top);
        const overlap = across > 2 && down > 0.4 * Math.min(box.height, its.height);
        if (overlap) found.push(`overprinted in "${name}": ${other} by ${text}`);
      });
    });
  }
  return found;
}"""


def points_of(path: str) -> np.ndarray:
    """Return the places of a path of steps, shape (n, 2) [pixels]."""
    points = list[np.ndarray]()
    for kind, text in re.findall(r"([Ml])([^MlZHVv]*)", path):
        steps = np.array(re.findall(r"-?[\d.]+", text), float).reshape(-1, 2)
        points.append(steps if kind == "M" else points[-1][-1] + np.cumsum(steps, axis=0))
    return np.concatenate(points)


def empty(page: Any) -> list[str]:
    """Figures in which nothing is drawn."""
    return [f"nothing drawn: {caption}" for caption in page.evaluate(EMPTY)]


def words(page: Any) -> list[str]:
    """Words of charts that are cut or overprinted."""
    return list(page.evaluate(WORDS))
