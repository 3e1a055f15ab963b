# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Your own vehicle and friction law
#
# A delivery van as a dict of tables, and the friction law mu N / (1 + N/N0). A law is one object: its constants, the
# force, its derivative with respect to N, and a text for the report.

# %%
import math
from typing import NamedTuple

import tailslap
from fem import FrictionLaw

VAN = {
    "name": "van",
    "vehicle": {"length": "5.9 m", "width": "2.0 m", "mass": "3500 kg"},
    "impact": {"speed": "80 km/h", "angle": "20 deg", "friction": 0.4, "restitution": 0.2},
    "plate": {
        "thickness": "40 mm",
        "youngs_modulus": "200 GPa",
        "poissons_ratio": 0.3,
        "elements": [12, 4],
    },
}
plain = tailslap.run(VAN)
print(plain)


# %%
class Fading(NamedTuple):
    """Coefficient of friction, halved at the reaction `half` [N]."""

    coefficient: float
    half: float = 2e3


def limit(law: Fading, normal: float) -> float:
    size = abs(normal)
    return law.coefficient * size / (1.0 + size / law.half)


def force(law: Fading, normal: float, stopping: float) -> float:
    most = limit(law, normal)
    return min(max(stopping, -most), most)


def slope(law: Fading, normal: float, speed: float) -> float:
    factor = 1.0 / (1.0 + abs(normal) / law.half)
    return -law.coefficient * factor * factor * math.copysign(1.0, normal) * math.copysign(1.0, speed)


FADING = FrictionLaw(
    name="fading",
    constants=Fading,
    force=force,
    slope=slope,
    text="friction mu N / (1 + N/N0)",
    rigid="drag",
    impulse="normal_impulse_magnitude",
)

# %% [markdown]
# The object replaces the name of a law. The exact rigid motion uses Coulomb friction, so that some checks fail.

# %%
faded = tailslap.run(VAN, {"corner.reaction": FADING})
print(faded)

# %%
N, T = (abs(faded.history[f"reaction_{part}"][1:-1]) for part in ("normal", "tangential"))
print(f"friction over reaction: {min(T / N):.3f} to {max(T / N):.3f}, 0.4 for Coulomb friction")
assert max(abs(T - 0.4 * N / (1.0 + N / 2e3))) < 1e-6 * max(T)
assert faded.summary["fe"]["v_gx"] > plain.summary["fe"]["v_gx"]
