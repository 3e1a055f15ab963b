# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Run a scene and plot it
#
# A scene of `tailslap.scenes()` with another speed. `print` shows the comparison with the rigid vehicle.

# %%
import tailslap

result = tailslap.run("mash-tl4-sut", {"impact.speed": "60 mph"})
print(result)

# %% [markdown]
# Histories are data frames if pandas is installed, and NumPy arrays by column otherwise; both accept `["v_gy"]`.

# %%
history = result.history
print(f"v_GY: {max(history['v_gy']):.2f} to {min(history['v_gy']):.2f} m/s")
result.plot("v_gy", "reaction_normal").save("history.png")
result.plot_field("v_gy").save("field.png")
assert result.passed
