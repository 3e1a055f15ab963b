"""Hold the numbers that the paper prints, in SI, with their places.

Table 3 is in `postprocess.comparison`; its v_GY has the sign of this program, negative towards the wall. The paper
contains neither mass nor speed nor length of the six vehicles of Tables 4 and 5.
"""

import math
from typing import NamedTuple

from postprocess.comparison.quantities import PAPER_TABLE_3
from postprocess.units import MPH

PAPER = "B. Chuong and R. B. Malla, Infrastructures 2025, 10(11), 307"
KM_PER_HOUR = 1.0 / 3.6  # m/s


class Input(NamedTuple):
    """Input of the analysis.

    name, symbol, title: of the quantity; given: as printed; value, unit: in SI; place: in the paper.
    """

    name: str
    symbol: str
    title: str
    given: str
    value: float
    unit: str
    place: str = "Table 1"


INPUTS = (
    Input("speed", "V_I", "Impact speed", "90 km/h", 90.0 * KM_PER_HOUR, "m/s"),
    Input("angle", "θ", "Impact angle", "15 deg", math.radians(15.0), "rad"),
    Input("mass", "W", "Vehicle weight", "9979 kg", 9979.0, "kg"),
    Input("width", "B", "Vehicle width", "2438 mm", 2.438, "m"),
    Input("length", "L", "Vehicle length", "10,000 mm", 10.0, "m"),
    Input("friction", "μ_k", "Coefficient of friction", "0.47", 0.47, "", "Section 3.1.1"),
    Input("restitution", "e", "Coefficient of restitution", "0.22", 0.22, "", "Section 3.1.1"),
)
SPEED, ANGLE, MASS, WIDTH, LENGTH, FRICTION, RESTITUTION = (item.value for item in INPUTS)
START = {"angle": 0.26, "omega": 0.707, "corner_speed": 25.053}  # theta_0, omega_0, v_P0, Section 3.1.1
FEA_SPEED = 25.0  # m/s, V_x in Table 2, where Section 3.1.2 has 25,053 mm/s
LATERAL_SPEED = 23.3 * KM_PER_HOUR  # m/s, v_0 sin(theta) in Section 3.1.1
ANALYTICAL, ABAQUS = PAPER_TABLE_3["analytical"], PAPER_TABLE_3["abaqus"]  # Table 3
CHART_TIME, CHART_V_GY = 0.38, -3.274  # s, Figure 10 at theta = 0; m/s, Figure 11 then (Section 3.1.1)
PULSE = 0.1  # s, "a reasonable estimate ... in most cases" (Section 3.2)


class ForceRow(NamedTuple):
    """Row of Table 4 or 5.

    Forces in N, pairs for e = 0.22 and e = 0. duration: of the second pulse [s]; measured: by crash test or finite
    elements; projected: 1.33 times the 50 ms average, by the authors; peak: analytical, F_lat,peak; factor: adjustment
    factor phi_a.
    """

    row: str
    source: str
    duration: float
    measured: float
    peak: tuple[float, float]
    factor: tuple[float, float]
    projected: bool = False


SOURCES = {
    "a": "MwRSF TRP-03-415-21, crash test",
    "b": "MwRSF TRP-03-403-21, crash test",
    "c": "NCHRP 22-20(02), tall vertical wall, FEA",
    "d": "NCHRP 22-20(02), 42 in. barrier, FEA",
    "e": "TTI 9-1002-5, FEA",
    "f": "Cao et al., FEA",
}


def _row(
    row: str, duration: float, forces: tuple[float, ...], factor: tuple[float, float], projected: bool = False
) -> ForceRow:
    """Return a row from forces in kN."""
    measured, elastic, plastic = (1e3 * force for force in forces)
    return ForceRow(row, SOURCES[row], duration, measured, (elastic, plastic), factor, projected)


TABLE_4 = (  # 50 ms average
    _row("a", 0.1, (680.0, 707.0, 898.5), (1.04, 1.32)),
    _row("b", 0.1, (595.0, 680.0, 872.0), (1.14, 1.46)),
    _row("c", 0.1, (415.0, 609.0, 783.0), (1.47, 1.89)),
    _row("d", 0.08, (351.0, 765.0, 978.0), (2.17, 2.78)),
    _row("e", 0.1, (360.0, 614.0, 796.0), (1.7, 2.21)),
    _row("f", 0.18, (375.0, 351.0, 440.0), (0.94, 1.17)),
)
TABLE_5 = (  # SAE-filtered
    _row("a", 0.1, (904.0, 707.0, 898.5), (0.78, 0.99), projected=True),
    _row("b", 0.1, (791.0, 680.0, 872.0), (0.86, 1.1), projected=True),
    _row("c", 0.1, (552.0, 609.0, 783.0), (1.1, 1.42), projected=True),
    _row("d", 0.08, (467.0, 765.0, 978.0), (1.64, 2.09), projected=True),
    _row("e", 0.1, (479.0, 614.0, 796.0), (1.28, 1.66), projected=True),
    _row("f", 0.16, (500.0, 396.0, 494.0), (0.79, 0.99)),
)
RESTITUTIONS = (RESTITUTION, 0.0)  # of the pairs in Tables 4 and 5

# Not in the paper: the test behind row b, MNCBR-1, by the abstract of its report.
ROW_B_SPEED, ROW_B_ANGLE, ROW_B_GIVEN = 57.4 * MPH, math.radians(15.4), "57.4 mph and 15.4 deg"
