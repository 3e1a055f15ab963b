"""Every page that the program writes, in Chromium: a row a page with what is wrong on screens and on paper.

    pip install --target LIBRARIES playwright axe-playwright-python pypdf
    PYTHONPATH=.:LIBRARIES .venv/bin/python benchmarks/pages.py [PAGE or FOLDER]... [--only NAME]... [--keep DIR]

Without arguments it makes all pages, in small (browser/made.py). Looked at: axe-core at 1280, 768 and 390 px, light and
dark; what sticks out at the side; numbers broken across lines; words of charts cut or overprinted; errors on the
console; requests that leave the page; charts with scripts blocked; and the page printed on A4, whose text must have
every cell, heading and caption. Exit status 1 if anything is found.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from browser.looked import Looked, look
from browser.made import COMMANDS, make_page, page_of
from browser.session import chromium

SAID = 12
"""Findings of a page that are told."""


def pages(given: argparse.Namespace, folder: Path) -> Iterator[tuple[str, Path | str]]:
    """Names and pages, those given or those that are made; of a page that cannot be made, why."""
    for place in given.places:
        yield place.name, page_of(place)
    for name in () if given.places else given.only or COMMANDS:
        try:
            yield name, make_page(name, folder)
        except RuntimeError as error:
            yield name, str(error)


def print_row(looked: Looked, is_first: bool) -> None:
    """A row, below the headings if it is the first, and what was found."""
    if is_first:
        print(f"{'page':<20} {'size, MB':>8} " + " ".join(f"{kind:>10}" for kind in looked.found))
    counts = " ".join(f"{len(found):>10}" for found in looked.found.values())
    print(f"{looked.name:<20} {looked.size:>8.2f} {counts}", flush=True)
    said = [f"  {text}" for found in looked.found.values() for text in dict.fromkeys(found)]
    print("\n".join(said[:SAID]), end="\n" if said else "", flush=True)


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Options."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("places", nargs="*", type=Path)
    parser.add_argument("--only", action="append", choices=list(COMMANDS), default=[])
    parser.add_argument(
        "--keep", type=Path, help="folder of the pages; those that are there are not made again"
    )
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; 1 if anything was found."""
    given = parsed(arguments)
    count = 0
    with tempfile.TemporaryDirectory() as temporary, chromium() as browser:
        for number, (name, path) in enumerate(pages(given, given.keep or Path(temporary))):
            looked = (
                Looked(name, 0.0, {"page": [path]}) if isinstance(path, str) else look(browser, name, path)
            )
            print_row(looked, number == 0)
            count += looked.count
    print("nothing is wrong" if not count else f"{count} findings")
    return 1 if count else 0


if __name__ == "__main__":
    raise SystemExit(main())
