"""Finite-element verification of the rigid-body method for vehicle impact on bridge parapets.

    import tailslap
    result = tailslap.run("mash-tl4-sut", {"impact.speed": "60 mph"})
    print(result)

Functions, each the same as the command of its name:

    run         rigid solution, finite elements, comparison and checks
    rigid       rigid-body method
    check       model, automatic choices and estimated cost of a run
    modal       run with the modal model of the plate
    modes       natural frequencies and mode shapes of the plate
    sweep       runs with varied keys
    study       studies: cost, flexibility, parapet, stability, tipping, uncertainty
    compare     comparison of histories with a reference, including other programs
    confirm     the same scene in another solver, compared
    export      fields and histories for ParaView, Gmsh, data frames; decks for CalculiX, ABAQUS
    parapet     strength of the parapet between bounds, beside the force
    load        loading of a result folder
    paper       tables and figures of the paper compared with computed values
    validate    predictions beside published forces, durations and speeds
    scenes      scenes of the program
    new         new scene file with every key

They return a `Result`; invalid input raises `InputError`. `help(tailslap.run)` describes a function.
"""

import os as _os
import sys as _sys
from importlib.machinery import PathFinder as _PathFinder


def _demand_packages(*names):
    """Raise ImportError where a file hides a package of tailslap.

    It is raised before any of them is imported. A command ends with status 2.
    """
    root = _os.path.dirname(_os.path.dirname(_os.path.realpath(__file__)))
    for name in names:
        loaded = _sys.modules.get(name)
        spec = _PathFinder.find_spec(name) if loaded is None else loaded.__spec__
        file = (spec and spec.origin) or getattr(loaded, "__file__", None)
        if file and _os.path.dirname(_os.path.dirname(_os.path.realpath(file))) != root:
            message = (
                f"{file} is in conflict with the package {name} of tailslap; rename it, or start elsewhere"
            )
            if _sys.argv and _os.path.basename(_sys.argv[0]) in ("-m", "tailslap"):
                print(f"tailslap: {message}", file=_sys.stderr)
                raise SystemExit(2)
            raise ImportError(message)


_demand_packages("fem", "machine_code", "meshes", "postprocess", "solver")

from fem.lazy import lazy_names  # noqa: E402

__version__ = "0.2.0"

__all__, __getattr__, __dir__ = lazy_names(
    __name__,
    {
        "api": "check rigid run study",
        "campaign.sweep_run": "sweep",
        "comparing.compare": "compare",
        "errors": "InputError",
        "exports.confirm": "confirm",
        "exports.export": "export",
        "modal_analysis": "modes",
        "modal_run": "modal",
        "result.columns": "Columns",
        "result.load": "load",
        "wall_strength.report": "parapet",
        "replication.paper_page": "paper",
        "result.result": "Result",
        "scene.read": "scenes",
        "scene.write": "new",
        "validation.validation_report": "validate",
    },
)
