"""Peak force over speed and angle

Rigid-body method for 96 combinations.
"""

import matplotlib.pyplot as plt
import numpy as np

import tailslap

speeds, angles = np.linspace(40.0, 110.0, 12), np.linspace(5.0, 25.0, 8)
forces = [
    [
        tailslap.rigid("mash-tl4-sut", {"impact.speed": f"{v} km/h", "impact.angle": f"{a} deg"}).summary[
            "stage3"
        ]["peak_force"]
        for v in speeds
    ]
    for a in angles
]
figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="tight")
lines = axes.contour(speeds, angles, np.array(forces) / 1e3, levels=np.arange(100.0, 2000.0, 100.0))
axes.clabel(lines, fmt="%.0f kN")
axes.set(xlabel="speed [km/h]", ylabel="angle [deg]")
figure.savefig("speed_and_angle.svg")
