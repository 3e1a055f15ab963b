"""Hooks of `mkdocs build`: equations become MathML, which browsers draw without a script; the pictures of the gallery
are made by their scripts; the version, and the repository of this checkout, stand in the frame of each page.
"""

import ast
import html
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import tailslap

EQUATION = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>([.,;:)]*)', re.DOTALL)
"""An equation as pymdownx.arithmatex leaves it, and the punctuation behind it, which stays on its line."""


FUNCTION, THIN = (
    re.compile(r"((?<!<msup>)<mi>(?:arctan|cos|exp|ln|max|min|sin|tanh)</mi>)"),
    '<mspace width="0.17em"/>',
)
"""A function's name, and the space about it, which browsers leave out."""


def on_config(config: Any) -> Any:
    """Name version and licence in the footer, and link the repository."""
    config.copyright = f"tailslap {tailslap.__version__}, BSD-3-Clause"
    command = ["git", "config", "--get", "remote.origin.url"]
    origin = subprocess.run(command, capture_output=True, text=True).stdout.strip()
    config.repo_url = origin if origin.startswith("https://") else None
    return config


GALLERY = Path(__file__).parent / "gallery"


def picture(script: Path) -> Path | None:
    """Picture of a script, PNG or SVG, unless the script was changed since."""
    pictures = (script.with_suffix(ending) for ending in (".png", ".svg"))
    return next(
        (path for path in pictures if path.exists() and path.stat().st_mtime >= script.stat().st_mtime), None
    )


def on_pre_build(**_: Any) -> None:
    """Make missing pictures of the gallery in one process."""
    missing = [script.name for script in sorted(GALLERY.glob("*.py")) if not picture(script)]
    code = "import runpy, sys; [runpy.run_path(name, run_name='__main__') for name in sys.argv[1:]]"
    if missing:
        subprocess.run([sys.executable, "-c", code, *missing], cwd=GALLERY, check=True)


def on_post_build(config: Any, **_: Any) -> None:
    """Write the page of `tailslap explore` beside the first page."""
    from tailslap.browser import page

    page.write(page.FIRST, Path(config.site_dir) / "try.html")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Show pictures and scripts of the gallery under their titles."""
    if page.file.src_uri != "gallery/index.md":
        return markdown
    parts, thumbnails = list[str](), list[str]()
    for script in sorted(GALLERY.glob("*.py")):
        text, image = script.read_text(encoding="utf-8"), picture(script)
        title, _blank, *rest = (ast.get_docstring(ast.parse(text)) or "").splitlines()
        code = text.split('"""')[2].strip()
        figure = f"![{title}]({image.name})" if image else ""
        parts.append(
            f"## {title} {{#{script.stem}}}\n\n{' '.join(rest)}\n\n{figure}\n\n```python\n{code}\n```"
        )
        thumbnails += [f"[![]({image.name}) {title}](#{script.stem})"] if image else []
    return "\n\n".join(
        [markdown, f'<div class="thumbnails" markdown>\n{" ".join(thumbnails)}\n</div>', *parts]
    )


def on_page_content(content: str, **_: Any) -> str:
    """Replace TeX by MathML."""
    from latex2mathml.converter import convert

    def mathml(found: re.Match[str]) -> str:
        formula = convert(html.unescape(found[2]), display="block" if found[1] == "div" else "inline")
        formula = FUNCTION.sub(rf"{THIN}\1{THIN}", formula)
        return f'<span class="whole">{formula}{found[3]}</span>' if found[3] else formula

    return EQUATION.sub(mathml, content)


def on_post_page(output: str, **_: Any) -> str:
    """Name the dialog of the search for screen readers."""
    return output.replace('class="md-search"', 'class="md-search" aria-label="Search"')
