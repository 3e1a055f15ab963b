# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # A flexible plate
#
# A truck's frame bends at a few hertz, a steel plate of the same size at 108. How far is the rigid-body
# method from a plate that bends? The first frequency takes the modulus' place, and the corner is held over a
# metre of side: the compliance of a single point has no limit of fine meshes.

# %%
import tailslap

SOFT = {"plate.youngs_modulus": None, "corner.patch_length": "1 m"}
results = {
    frequency: tailslap.run("mash-tl4-sut", SOFT | {"plate.first_frequency": f"{frequency} Hz"})
    for frequency in (160, 80, 40)
}
for frequency, result in results.items():
    difference = result.summary["difference"]["v_gy"]
    print(
        f"{frequency:>3} Hz: v_GY, and with it the force, is {difference:+.1e} off; passed: {result.passed}"
    )

# %% [markdown]
# The difference goes with the compliance, that is with one over the frequency squared.

# %%
off = {frequency: result.summary["difference"]["v_gy"] for frequency, result in results.items()}
print(f"from 160 to 40 Hz the difference grows {off[40] / off[160]:.1f} times; 16 are expected")
assert 14 < off[40] / off[160] < 18

# %% [markdown]
# The stress that goes with it, at the instant of the tail-slap:

# %%
kept = tailslap.run("mash-tl4-sut", SOFT | {"plate.first_frequency": "40 Hz", "output.fields": 5})
stress = kept.fields.elemental["stress_von_mises"]
for t, peak in zip(kept.fields.t, stress.max(axis=1), strict=True):
    print(f"t = {t:.3f} s: von Mises stress up to {peak / 1e3:.1f} kPa")
assert abs(kept.fields.t[-1] - kept.summary["fe"]["t"]) < 1e-12

# %%
print(tailslap.compare(results[160], results[40]))
