"""Histories of the finite elements over those of the rigid vehicle

Velocity of the centre of mass across the wall, angular velocity, and reaction at the corner.
"""

import tailslap

result = tailslap.run("paper-table-3")
result.plot("v_gy", "omega", "reaction_normal").save("histories.svg")
