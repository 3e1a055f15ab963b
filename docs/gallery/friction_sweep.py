"""Peak force over friction

Sweep of six runs of the finite elements.
"""

import tailslap

result = tailslap.sweep("mash-tl4-sut", {"impact.friction": "0.1:0.6:6"})
result.plot("fe.peak_force", "fe.v_gy").save("friction_sweep.svg")
