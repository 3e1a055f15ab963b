"""The plate at the first instant.

`rigid_state` has the rigid body's motion, accelerations and loads, `elastic` the stiffness inverted beside rigid
motion, `inertia_relief` the elastic state that belongs to them, at finite strain by `finite_strain`. `start` offers
three kinds of start, and `statics` says what the elastic state tells without a run.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "rigid_state": "RigidStart",
        "start": "START_KINDS start_fields",
        "statics": "Statics statics",
    },
)
