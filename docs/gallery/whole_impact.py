"""Both strikes of a whole impact

Force of the rigid vehicle by its crush stiffness, raw and filtered, beside the design forces.
"""

from pathlib import Path

import tailslap

chart = tailslap.rigid("impact-mash-tl4-sut").charts["force"]
Path("whole_impact.svg").write_text(chart.svg)
