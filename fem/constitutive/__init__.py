"""Materials: stress and energy density from strain.

`materials` registers them, each with its constants and two plain functions; `stress` is what compiled loops call.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "materials": "MATERIALS Material",
    },
)
