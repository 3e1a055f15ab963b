"""Make the page of `tailslap explore` for a wheel."""

import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

MAKE = "from tailslap.browser import page; page.make_packaged()"


class PageHook(BuildHookInterface[Any]):
    """Put the page into a wheel.

    An isolated build has no llvmlite: it takes the page that `bootstrap.py` made of the same sources. Without one the
    first call of `tailslap explore` makes it.
    """

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the page to the files of a wheel."""
        if version == "editable":
            return
        packaged = runpy.run_path(str(Path(self.root) / "tailslap/browser/packaged.py"))
        subprocess.run([sys.executable, "-c", MAKE], cwd=self.root, capture_output=True)
        if packaged["is_current"]():
            build_data["artifacts"].append("tailslap/browser/explore.html")
        else:
            self.app.display_warning("without the page of `tailslap explore`, which its call makes")
