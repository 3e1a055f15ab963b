"""The plate at the first instant.

`rigid_state` has the rigid body's motion, accelerations and loads, `elastic` the stiffness inverted beside rigid
motion, of large plates by `multigrid`, `inertia_relief` the elastic state that belongs to them, at finite strain by
`finite_strain`. `start_kinds` registers the kinds of start, `start` places the plate, and `statics` says what the
elastic state tells without a run.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "rigid_state": "RigidStart",
        "start": "start_fields",
        "start_kinds": "START_KINDS StartKind",
        "statics": "Statics statics",
    },
)
