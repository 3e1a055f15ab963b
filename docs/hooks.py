"""Hooks of `mkdocs build`: equations become MathML, which browsers draw without a script; the version, and the
repository that this checkout was cloned from, in the frame of each page.
"""

import html
import re
import subprocess
from typing import Any

import tailslap

EQUATION = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>([.,;:)]*)', re.DOTALL)
"""An equation as pymdownx.arithmatex leaves it, and the punctuation behind it, which stays on its line."""


FUNCTION, THIN = re.compile(r"((?<!<msup>)<mi>(?:arctan|cos|exp|ln|sin)</mi>)"), '<mspace width="0.17em"/>'
"""A function's name, and the space about it, which browsers leave out."""


def on_config(config: Any) -> Any:
    """Name version and licence in the footer, and link the repository."""
    config.copyright = f"tailslap {tailslap.__version__}, BSD-3-Clause"
    command = ["git", "config", "--get", "remote.origin.url"]
    origin = subprocess.run(command, capture_output=True, text=True).stdout.strip()
    config.repo_url = origin if origin.startswith("https://") else None
    return config


def on_page_content(content: str, **_: Any) -> str:
    """Replace TeX by MathML."""
    from latex2mathml.converter import convert

    def mathml(found: re.Match[str]) -> str:
        made = convert(html.unescape(found[2]), display="block" if found[1] == "div" else "inline")
        made = FUNCTION.sub(rf"{THIN}\1{THIN}", made)
        return f'<span class="whole">{made}{found[3]}</span>' if found[3] else made

    return EQUATION.sub(mathml, content)


def on_post_page(output: str, **_: Any) -> str:
    """Name the dialog of the search for screen readers."""
    return output.replace('class="md-search"', 'class="md-search" aria-label="Search"')
