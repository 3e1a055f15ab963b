# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Three values of the friction
#
# Up to three runs use this process, more runs worker processes, which do not import this script: it needs no
# `if __name__ == "__main__":`.

# %%
import tailslap

result = tailslap.sweep("mash-tl4-sut", {"impact.friction": [0.2, 0.35, 0.5]})
print(result)

# %% [markdown]
# The table has one row per run. `result.save("results/friction")` writes table, page and charts.

# %%
table = result.history
for friction, force in zip(table["impact.friction"], table["fe.peak_force"], strict=True):
    print(f"friction {friction:.2f}: peak force {force / 1e3:.0f} kN")
result.plot("fe.peak_force").save("peak-force.png")
assert list(table["fe.peak_force"]) == sorted(table["fe.peak_force"], reverse=True)
