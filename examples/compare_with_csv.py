# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Compare with a CSV file
#
# `abaqus.csv` in this folder is the history of another program in its own units, with Y pointing into the wall.

# %%
import tailslap

result = tailslap.run("paper-table-3")
compared = tailslap.compare(
    result, "abaqus.csv", columns={"time": "TIME", "v_gx": "V1", "v_gy": "-V2", "omega": "VR3"}
)
print(compared)

# %% [markdown]
# Metrics by column, as in `summary.json`, and curves.

# %%
for name, metrics in compared.summary["compared"]["abaqus"].items():
    print(f"{name}: largest difference {metrics['largest']:.2%} of the peak")
compared.plot("v_gy", "omega").save("compared.png")
assert compared.passed
