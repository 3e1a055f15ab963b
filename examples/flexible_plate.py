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
# The frame of a truck has bending modes of a few hertz, a steel plate of the same size 108 Hz. The first frequency
# replaces the modulus, and the corner is supported over one metre of the side, because the compliance of a single
# point does not converge with the mesh.

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
        f"{frequency:>3} Hz: difference of v_GY from the rigid vehicle {difference:+.1e}; passed: {result.passed}"
    )

# %% [markdown]
# The difference is proportional to the compliance, i.e. to 1/frequency^2.

# %%
off = {frequency: result.summary["difference"]["v_gy"] for frequency, result in results.items()}
print(f"ratio of the differences at 40 and 160 Hz: {off[40] / off[160]:.1f}; expected 16")
assert 14 < off[40] / off[160] < 18

# %% [markdown]
# Stress up to the tail-slap:

# %%
kept = tailslap.run("mash-tl4-sut", SOFT | {"plate.first_frequency": "40 Hz", "output.fields": 5})
stress = kept.fields.elemental["stress_von_mises"]
for t, peak in zip(kept.fields.t, stress.max(axis=1), strict=True):
    print(f"t = {t:.3f} s: von Mises stress up to {peak / 1e3:.1f} kPa")
assert abs(kept.fields.t[-1] - kept.summary["fe"]["t"]) < 1e-12

# %%
print(tailslap.compare(results[160], results[40]))
