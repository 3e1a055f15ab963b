# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Forces of your own truck with their bands
#
# A whole impact of a rigid truck with crush, as a dict of tables. The band is that of trucks, crush and impacts within
# MASH and assumed ranges.

# %%
import tailslap

TRUCK = {
    "vehicle": {"length": "28 ft", "width": "96 in", "mass": "20000 lb"},
    "impact": {"speed": "50 mph", "angle": "15 deg", "test_level": "TL-4"},
    "contact": {"friction": 0.35, "stiffness": "2 MN/m", "plateau_force": "350 kN", "restitution": 0.2},
}
impact = tailslap.rigid(TRUCK)
print(impact.headline.answer)

# %% [markdown]
# The history contains the force with its filters; another moving mean is one of pandas.

# %%
history = impact.history
rows = len(history[history["t"] < 0.05])
mean = history["force_normal"].rolling(rows).mean().max()
print(
    f"50 ms mean {mean / 1e3:.0f} kN, of the program {history['force_normal_mean_50ms'].max() / 1e3:.0f} kN"
)
impact.plot("force_normal", "force_normal_mean_50ms").save("force.png")

# %% [markdown]
# Over the speed, and beside the truck of the program.

# %%
for speed in ("40 mph", "50 mph", "60 mph"):
    band = tailslap.rigid(TRUCK, {"impact.speed": speed}).summary["force_band"]
    low, middle, high = (band[f"percentile_{part}"] / 1e3 for part in (5, 50, 95))
    print(f"{speed}: {middle:.0f} kN, 90 % from {low:.0f} to {high:.0f} kN")
print(tailslap.compare(tailslap.rigid("impact-mash-tl4-sut"), impact))
assert abs(mean - impact.summary["peaks"]["mean_50ms"]) < 0.03 * mean
