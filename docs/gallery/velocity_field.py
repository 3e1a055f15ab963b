"""Velocity across the wall at the tail-slap

Contours of the plate of the paper's truck, as in Figure 16 of the paper.
"""

import tailslap

result = tailslap.run("mash-tl4-sut")
result.plot_field("v_gy").save("velocity_field.png")
