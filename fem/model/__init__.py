"""Models with everything that does not change during a run.

`plate_model` is the plate with its corner constrained, at a node or a support patch. `impact_model` is the plate whose
boundary is in contact with a wall, `train_model` the plates of a train, `wall_model` a deformable wall.
"""
