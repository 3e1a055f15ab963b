"""Flexibility of the vehicle

Difference of v_GY from the rigid vehicle over the first frequency of the plate, and the inverse of its square.
"""

import matplotlib.pyplot as plt

import tailslap

frequencies = [160.0, 80.0, 40.0, 20.0]
soft = {"plate.youngs_modulus": None, "corner.patch_length": "1 m"}
runs = [tailslap.run("mash-tl4-sut", soft | {"plate.first_frequency": f"{f} Hz"}) for f in frequencies]
differences = [abs(run.summary["difference"]["v_gy"]) for run in runs]

figure, axes = plt.subplots(figsize=(6.4, 3.2), layout="tight")
axes.loglog(frequencies, differences, "o", label="finite elements")
axes.loglog(frequencies, [differences[0] * (160.0 / f) ** 2 for f in frequencies], "--", label="1/f²")
axes.set(xlabel="first frequency [Hz]", ylabel="difference of v_GY [-]")
axes.legend(frameon=False)
figure.savefig("first_frequency.svg")
