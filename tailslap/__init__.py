"""Finite-element verification of the rigid-body method for vehicle impact on bridge parapets.

The functions do what the commands of the same names do, which call them; `docs/howto/python.md` shows them at work.
"""

import os as _os
import sys as _sys
from importlib.machinery import PathFinder as _PathFinder


def _demand_own(*names):
    """Raise ImportError where another file would be imported in place of a package beside this one, before any is; a
    command ends with status 2."""
    root = _os.path.dirname(_os.path.dirname(_os.path.realpath(__file__)))
    for name in names:
        loaded = _sys.modules.get(name)
        found = _PathFinder.find_spec(name) if loaded is None else loaded.__spec__
        file = (found and found.origin) or getattr(loaded, "__file__", None)
        if file and _os.path.dirname(_os.path.dirname(_os.path.realpath(file))) != root:
            said = f"{file} is in the way of tailslap's own package {name}; rename it, or start elsewhere"
            if _sys.argv and _os.path.basename(_sys.argv[0]) in ("-m", "tailslap"):
                print(f"tailslap: {said}", file=_sys.stderr)
                raise SystemExit(2)
            raise ImportError(said)


_demand_own("fem", "meshes", "postprocess", "solver")

from fem.lazy import lazily  # noqa: E402

__version__ = "0.1.0"

__all__, __getattr__, __dir__ = lazily(
    __name__,
    {
        "api": "check compare modal modes rigid run study sweep",
        "errors": "InputError",
        "files.export": "export",
        "files.load": "load",
        "result": "Columns Result",
    },
)
