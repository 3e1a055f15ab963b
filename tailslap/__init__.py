"""Finite-element verification of the rigid-body method for vehicle impact on bridge parapets.

    import tailslap
    result = tailslap.run("mash-tl4-sut", {"impact.speed": "60 mph"})
    print(result)

Functions, each of which does what the command of the same name does:

    run         rigid solution, finite elements, comparison and checks of a scene
    rigid       rigid-body method alone
    check       model, choices and cost of a run, without running it
    modal       run with a few modes of the plate
    modes       natural frequencies and shapes of the plate
    sweep       runs for many values of keys, a row a run
    study       prepared study: cost, flexibility, stability, uncertainty
    compare     histories beside a reference, also those of other programs
    export      fields and histories for ParaView, Gmsh, data frames
    load        result folder, read again
    paper       tables and figures of the paper beside the computed values
    scenes      scenes that come with the program
    new         new scene file with every key

They return a `Result`; wrong input raises `InputError`. `help(tailslap.run)` describes a function.
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
        "replication.page": "paper",
        "result": "Columns Result",
        "scene.read": "scenes",
        "scene.write": "new",
    },
)
