"""Design forces of railings by test level."""

from collections.abc import Sequence
from dataclasses import dataclass

from postprocess.units import FOOT, INCH, KIP

AASHTO = (
    "AASHTO LRFD Bridge Design Specifications, Table A13.2-1: vehicles of NCHRP Report 350, lighter than those of "
    "MASH; later editions not checked"
)
REPORT_350 = "AASHTO (Report 350)"
"""Name of AASHTO's loads, whose TL-4 truck has 18 000 lb."""

LRFD: dict[str, dict[str, float]] = {
    "TL-1": {"lateral": 13.5, "longitudinal": 4.5, "length": 4.0},
    "TL-2": {"lateral": 27.0, "longitudinal": 9.0, "length": 4.0},
    "TL-3": {"lateral": 54.0, "longitudinal": 18.0, "vertical": 4.5, "height": 24.0, "length": 4.0},
    "TL-4": {"lateral": 54.0, "longitudinal": 18.0, "vertical": 18.0, "height": 32.0, "length": 3.5},
    "TL-5": {"lateral": 124.0, "longitudinal": 41.0, "vertical": 80.0, "height": 42.0, "length": 8.0},
    "TL-6": {"lateral": 175.0, "longitudinal": 58.0, "vertical": 80.0, "height": 56.0, "length": 8.0},
}
"""AASHTO's design loads by test level [kip], their height above the road [in] and length [ft]."""

TTI = (
    "Sheikh, Bligh and Menges, Determination of minimum height and lateral design load for MASH test level 4 "
    "bridge rails, Texas Transportation Institute, Report 9-1002-5 (2011)"
)

UNCONFIRMED = "attributed to NCHRP Project 22-20(2); not verified against the project report"


BY_ACCELERATION = "MASH (4.5 g)"
"""Name of the load that is mass times acceleration, which compares with the inertial estimate."""

MASH = {
    "TL-3": (("MASH (not verified)", 71.0, UNCONFIRMED),),
    "TL-4": (
        ("MASH (TTI)", 80.0, TTI),  # for rails of 36 in. or higher
        (BY_ACCELERATION, 22.05 * 4.5, "NCHRP Web-Only Document 326, Eq. 3-4: 22 050 lb times 4.5 g"),
    ),
    "TL-5": (
        ("MASH, 42 in wall (not verified)", 160.0, UNCONFIRMED),
        ("Manitoba, 1250 mm wall", 845e3 / KIP, "Design of the Manitoba tall wall, tac-atc.ca"),
        ("MASH, taller wall (not verified)", 262.0, UNCONFIRMED),
    ),
    "TL-6": (("MwRSF, 62 in wall", 300.0, "MASH TL-6 evaluation, rosap.ntl.bts.gov/view/dot/77847"),),
}
"""Lateral design loads for the vehicles of MASH by test level: name, force [kip] and source."""


EN_LEVELS = ("T1", "T2", "T3", "N1", "N2", "H1", "H2", "H3", "H4a", "H4b")
"""Containment levels of EN 1317-2; their names are not confirmed here."""

EN_CLASSES = {"A": 100e3, "B": 200e3, "C": 400e3, "D": 600e3}
EN_HEIGHT, EN_BELOW_TOP, EN_LENGTH = 1.0, 0.1, 0.5
"""Horizontal forces of EN 1991-2 by class [N]; their height above the road, at most that below the top of the wall, and
their length [m]."""

EN_1991_2 = (
    "EN 1991-2, classes A to D, not confirmed here; no class follows from the containment level of EN 1317-2"
)


@dataclass(frozen=True)
class DesignForce:
    """Design load of a railing and its source.

    kip: lateral force as published [kip]. longitudinal, vertical: forces [N]. height: above the road [m]. length: [m].
    None where not published.
    """

    name: str
    kip: float
    source: str
    longitudinal: float | None = None
    vertical: float | None = None
    height: float | None = None
    length: float | None = None

    @property
    def force(self) -> float:
        """Lateral force [N]."""
        return self.kip * KIP

    @property
    def is_inertial(self) -> bool:
        """Whether it is mass times acceleration, no force on the wall."""
        return self.name == BY_ACCELERATION

    @property
    def moment(self) -> float | None:
        """Force times height [N m], None where no height is published."""
        return None if self.height is None else self.force * self.height


def design_forces(test_level: str, top: float | None = None) -> Sequence[DesignForce]:
    """Return the design loads of a test level, those of MASH first.

    test_level: "TL-1" to "TL-6", or one of `EN_LEVELS`, otherwise ValueError. top: height of the wall [m].
    """
    if test_level in EN_LEVELS:
        height = EN_HEIGHT if top is None else min(EN_HEIGHT, top - EN_BELOW_TOP)
        return [
            DesignForce(
                f"EN 1991-2 {name} (not verified)", newtons / KIP, EN_1991_2, height=height, length=EN_LENGTH
            )
            for name, newtons in EN_CLASSES.items()
        ]
    if test_level not in LRFD:
        raise ValueError(f"test level {test_level!r}: must be one of {', '.join((*LRFD, *EN_LEVELS))}")
    units = {"longitudinal": KIP, "vertical": KIP, "height": INCH, "length": FOOT}
    load = LRFD[test_level]
    components = {name: load[name] * unit for name, unit in units.items() if name in load}
    mash = [DesignForce(*row) for row in MASH.get(test_level, ())]
    return [*mash, DesignForce(REPORT_350, load["lateral"], AASHTO, **components)]
