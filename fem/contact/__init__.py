"""The constrained corner: its constraint, the friction law, and the side that supports it.

`constraints` and `friction` register laws as plain functions; `corner` calls them in the compiled step, on the node or
the support patch of nodes that `support_patch` weights.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "constraints": "CONSTRAINTS Constraint ConstraintInput",
        "friction": "FRICTION_LAWS FrictionLaw",
    },
)
