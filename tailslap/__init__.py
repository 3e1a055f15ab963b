"""Finite-element verification of the rigid-body method for vehicle impact on bridge parapets.

The functions do what the commands of the same names do; `docs/python.md` shows them at work.
"""

from fem.lazy import lazily

__version__ = "0.1.0"

__all__, __getattr__ = lazily(
    __name__,
    {
        "api.columns": "Columns",
        "files.export": "export",
        "api.many_runs": "study sweep",
        "api.one_run": "check rigid run",
        "api.plate": "modal modes",
        "api.result": "Result",
        "files.load": "load",
        "api.side_by_side": "compare",
        "errors": "InputError",
    },
)
