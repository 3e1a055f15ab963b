"""Models: everything a run needs that does not change during it.

`plate_model` makes the plate with its corner held, at a node or a support patch, `impact_model` the plate whose
boundary touches a wall, rigid or deformable.
"""
