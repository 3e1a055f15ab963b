"""Finite-element verification of the rigid-body method for vehicle impact on bridge parapets.

The functions do what the commands of the same names do, which call them; `docs/howto/python.md` shows them at work.
"""

from fem.lazy import lazily

__version__ = "0.1.0"

__all__, __getattr__ = lazily(
    __name__,
    {
        "api": "check compare modal modes rigid run study sweep",
        "errors": "InputError",
        "files.export": "export",
        "files.load": "load",
        "result": "Columns Result",
    },
)
