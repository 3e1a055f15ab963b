"""Force of the tail-slap beside the design forces

Rigid-body method: reaction at the corner, and the triangular pulse of the tail-slap with its mean over 50 ms.
"""

from pathlib import Path

import tailslap

chart = tailslap.rigid("mash-tl4-sut").charts["force"]
Path("tail_slap_force.svg").write_text(chart.svg)
