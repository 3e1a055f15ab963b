"""Stress of a flexible vehicle at the tail-slap

Von Mises stress of a plate with a first frequency of 20 Hz, held over a metre of its side; deformation
enlarged 50 times.
"""

import tailslap

soft = {"plate.youngs_modulus": None, "plate.first_frequency": "20 Hz", "corner.patch_length": "1 m"}
result = tailslap.run("mash-tl4-sut", soft)
result.plot_field("stress_von_mises", magnify=50.0).save("stress_field.png")
