"""Machine and versions of a comparison."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import time
from pathlib import Path

NOT_COMPARED = {
    "CalculiX": ("ccx", "ccx_2.21"),
    "OpenRadioss": ("starter_linux64_gf", "starter_linux64_gf_sp"),
}
"""Codes without an input here, with their commands."""


def description() -> str:
    """Return processor, versions and day."""
    import numpy

    import tailslap

    lines = Path("/proc/cpuinfo").read_text().split("\n\n")[0].replace("\t", "").splitlines()
    processor = dict(line.split(":", 1) for line in lines if ":" in line)
    names = [name for name in ("cpu family", "model") if name in processor]
    family = ", ".join(f"{name} {processor[name].strip()}" for name in names)
    model = processor.get("model name", platform.processor()).strip()
    git = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty"]
    commit = subprocess.run(git, capture_output=True, text=True).stdout.strip()
    missing = ", ".join(
        f"{code}: {'installed, but without an input here' if any(map(shutil.which, names)) else 'not installed'}"
        for code, names in NOT_COMPARED.items()
    )
    return (
        f"{model} ({family}), {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, {time.strftime('%Y-%m-%d')}; "
        f"tailslap {tailslap.__version__} ({commit}), Python {platform.python_version()}, "
        f"NumPy {numpy.__version__}; one thread each. {missing}."
    )
