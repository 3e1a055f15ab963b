#!/usr/bin/env python3
"""Set up tailslap in `.venv`: its packages, and the system libraries that gmsh and VTK load.

    python3 bootstrap.py          all that `tailslap` needs
    python3 bootstrap.py --dev    and all that its tests need

A second call does only what has changed since the first. Uses the standard library only.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

# At module level, before any annotation is evaluated: an older Python must get as far as this line.
if sys.version_info < (3, 11):  # noqa: UP036
    sys.exit(f"bootstrap: tailslap requires Python 3.11 or newer; this is Python {sys.version.split()[0]}")

from machine_code.system.operating_system import is_root
from tailslap.errors import APT_INSTALL, APT_PACKAGES, DNF_PACKAGES

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
PYTHON = str(VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))


# Without a display, even where there is one: the program must also run over ssh and in a batch job.
PROBE = ["env", "-u", "DISPLAY", "-u", "WAYLAND_DISPLAY", PYTHON, "-c"]
GMSH_PROBE = "import gmsh"
VTK_PROBE = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=[64, 64])
plotter.add_mesh(pyvista.Sphere())
assert plotter.screenshot(return_img=True).std() > 0, "the picture is empty"
"""


def say(message: str) -> None:
    """Print one line of progress."""
    print(f"bootstrap: {message}", file=sys.stderr, flush=True)


def call(command: list[str]) -> tuple[bool, str]:
    """Return whether a command in the checkout succeeded, and all that it printed."""
    done = subprocess.run(
        command,
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
    )
    return done.returncode == 0, done.stdout.strip()


def sudo() -> list[str]:
    """Return the prefix that runs a command as root.

    It is empty for root, and without sudo.
    """
    return ["sudo"] if not is_root() and shutil.which("sudo") else []


def line_to_paste(apt_packages: str, dnf_packages: str) -> str:
    """Return the advice that installs these packages."""
    commands = ["apt-get update", f"{APT_INSTALL} {apt_packages}"]
    if shutil.which("dnf") and not shutil.which("apt-get"):
        commands = [f"dnf install -y {dnf_packages}"]
    line = " && ".join(" ".join([*sudo(), command]) for command in commands)
    return f"run this as root, then bootstrap.py again:\n{line}"


def apt_install(packages: str) -> bool:
    """Install Debian packages if no password is required.

    Returns whether they are installed.
    """
    may = is_root() or (bool(sudo()) and call(["sudo", "-n", "true"])[0])
    if not may or not shutil.which("apt-get"):
        return False
    say(f"installing system packages: {packages}")
    prefix = [*sudo(), "env", "DEBIAN_FRONTEND=noninteractive"]
    install = [*prefix, *APT_INSTALL.split(), "-o", "DPkg::Lock::Timeout=120", *packages.split()]
    # The lists are fetched only if need be: they may be missing (a new container) or out of date.
    return call(install)[0] or (call([*prefix, "apt-get", "update"])[0] and call(install)[0])


def venv_version() -> str:
    """Return the version of the Python in `.venv`.

    It is empty if none works, is new enough and has pip.
    """
    if not os.access(PYTHON, os.X_OK):
        return ""
    code = "import pip, sys; assert sys.version_info >= (3, 11); print(sys.version)"
    works, version = call([PYTHON, "-c", code])
    return version if works else ""


def make_venv(no_system: bool) -> None:
    """Create `.venv` anew."""
    package = f"python3.{sys.version_info.minor}-venv"
    has_venv = [sys.executable, "-c", "import ensurepip, venv"]
    if not call(has_venv)[0] and (no_system or not apt_install(package) or not call(has_venv)[0]):
        sys.exit(f"bootstrap: this Python has no venv or ensurepip; {line_to_paste(package, 'python3')}")
    say(f"creating {VENV}")
    is_created, output = call([sys.executable, "-m", "venv", "--clear", str(VENV)])
    if not is_created:
        sys.exit(f"{output}\nbootstrap: {VENV} cannot be created, see above")


def install_packages(target: str) -> None:
    """Install tailslap of this checkout and its requirements into `.venv`."""
    say("installing packages (a minute or more)")
    # No user install, even where pip's configuration asks for it: that fails in a virtual environment.
    options = ["-qq", "--no-user", "--no-input", "--disable-pip-version-check", "-c", "constraints.txt"]
    installed, output = call([PYTHON, "-m", "pip", "install", *options, "-e", target])
    if not installed:
        sys.exit(f"{output}\nbootstrap: pip failed, see above")


def missing_library() -> str:
    """Return why gmsh or VTK does not work.

    It is one line, empty if both work.
    """
    for name, code in (("gmsh", GMSH_PROBE), ("VTK", VTK_PROBE)):
        works, output = call([*PROBE, code])
        if not works:
            # VTK's lines carry a time, a thread and a place before the message.
            return f"{name} does not work: " + (output.split("\n")[-1].split("| ")[-1] or "it crashes")
    return ""


def check_libraries(no_system: bool) -> None:
    """Install missing system libraries of gmsh and VTK, or exit with advice."""
    say("testing gmsh and an off-screen picture")
    reason = missing_library()
    if reason and not no_system and apt_install(APT_PACKAGES):
        reason = missing_library()
    if reason:
        sys.exit(f"bootstrap: {reason}\nbootstrap: {line_to_paste(APT_PACKAGES, DNF_PACKAGES)}")


def calibrate() -> None:
    """Compute the calibration of the band, which is kept on this machine."""
    say("calibrating the band of the force (half a minute, once)")
    succeeded, output = call([PYTHON, "-c", "from tailslap.validation.calibration import classes; classes()"])
    if not succeeded:
        sys.exit(f"bootstrap: the band of the force was not calibrated:\n{output}")


def make_page() -> None:
    """Make the page of `tailslap explore`, unless it is of these sources."""
    say("making the page of `tailslap explore` (seconds)")
    succeeded, output = call([PYTHON, "-c", "from tailslap.browser import page; page.make_packaged()"])
    if not succeeded:
        sys.exit(f"bootstrap: the page of `tailslap explore` was not made:\n{output}")


def digest(version: str, target: str) -> str:
    """Return a hash of all that determines an installation of `target`."""
    # The path too: when the checkout is moved, the scripts in `.venv` point to where it was.
    files = [(ROOT / name).read_text() for name in ("pyproject.toml", "constraints.txt")]
    return hashlib.sha256("\0".join([version, target, str(VENV), *files]).encode()).hexdigest()


def update_venv(target: str, no_system: bool) -> None:
    """Complete `.venv`.

    A step that succeeded leaves a stamp of its input, and is not repeated for the same.
    """
    version = venv_version()
    required = digest(version, target)
    enough = (required, digest(version, ".[dev]"))
    packages, libraries = VENV / "tailslap-packages.stamp", VENV / "tailslap-libraries.stamp"
    if not packages.is_file() or packages.read_text() not in enough:
        install_packages(target)
        packages.write_text(required)
    if not libraries.is_file() or libraries.read_text() != packages.read_text():
        check_libraries(no_system)
        libraries.write_text(packages.read_text())


def main() -> None:
    """Bring `.venv` up to date."""
    parser = argparse.ArgumentParser(description="Set up tailslap in .venv.")
    parser.add_argument("--dev", action="store_true", help="also install what the tests need")
    parser.add_argument("--no-system", action="store_true", help="name system packages, never install them")
    options = parser.parse_args()
    if not venv_version():
        make_venv(options.no_system)
    update_venv(".[dev]" if options.dev else ".", options.no_system)
    calibrate()
    make_page()
    say("ready: .venv/bin/tailslap")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
