"""Contact with the wall: the constrained corner, and in a whole impact the boundary of a plate that is only pushed.

`constraints` and `friction` register laws as plain functions; `corner` calls them in the compiled step, on the node or
the support patch of nodes that `support_patch` weights. `unilateral` registers the laws of an impact, `boundary` lists
the points that may touch and `wall_contact` reacts on them; `surface` is what these ask of the wall, which is rigid
unless it is an `elastic_wall`.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "constraints": "CONSTRAINTS Constraint ConstraintInput",
        "friction": "FRICTION_LAWS FrictionLaw",
    },
)
