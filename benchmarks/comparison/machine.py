"""The machine and the versions of a comparison."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import time
from pathlib import Path

NOT_INSTALLED = {
    "CalculiX": ("ccx", "ccx_2.21"),
    "OpenRadioss": ("starter_linux64_gf", "starter_linux64_gf_sp"),
}
"""Codes that would be compared if there were any of these commands."""


def description() -> str:
    """Processor, versions, day."""
    import numpy

    import tailslap

    found = dict(
        line.split(":", 1)
        for line in Path("/proc/cpuinfo").read_text().split("\n\n")[0].replace("\t", "").splitlines()
        if ":" in line
    )
    family = ", ".join(f"{name} {found[name].strip()}" for name in ("cpu family", "model") if name in found)
    model = found.get("model name", platform.processor()).strip()
    root = Path(__file__).parents[2]
    done = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=root, capture_output=True, text=True
    )
    missing = ", ".join(
        f"{code}: {'found, but no input of it is here' if any(map(shutil.which, names)) else 'not installed'}"
        for code, names in NOT_INSTALLED.items()
    )
    return (
        f"{model} ({family}), {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, {time.strftime('%Y-%m-%d')}; "
        f"tailslap {tailslap.__version__} ({done.stdout.strip()}), Python {platform.python_version()}, "
        f"NumPy {numpy.__version__}; one thread each. {missing}."
    )
