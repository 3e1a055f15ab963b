"""Models: everything a run needs that does not change during it.

`plate_model` makes the plate with its corner held, `impact_model` the plate that touches a wall, `contact_points` lists
the nodes of either at which the wall reacts.
"""
