"""Design forces of railings by test level."""

from collections.abc import Sequence
from dataclasses import dataclass

from postprocess.units import KIP

AASHTO = "AASHTO LRFD Bridge Design Specifications, Table A13.2-1; later editions not checked"

LRFD = {"TL-1": 13.5, "TL-2": 27.0, "TL-3": 54.0, "TL-4": 54.0, "TL-5": 124.0, "TL-6": 175.0}
"""AASHTO's transverse forces by test level [kip]."""

TTI = (
    "Sheikh, Bligh and Menges, Determination of minimum height and lateral design load for MASH test level 4 "
    "bridge rails, Texas Transportation Institute, Report 9-1002-5 (2011)"
)

UNCONFIRMED = "attributed to NCHRP Project 22-20(2); not verified against the project report"


TALLER = {
    "TL-4": (
        ("MASH, TTI", 80.0, TTI),  # for rails of 36 in. or higher
        ("MASH, 4.5 g", 22.05 * 4.5, "NCHRP Web-Only Document 326, Eq. 3-4: 22 050 lb times 4.5 g"),
    ),
    "TL-5": (
        ("42 in wall", 160.0, UNCONFIRMED),
        ("Manitoba, 1250 mm wall", 845e3 / KIP, "Design of the Manitoba tall wall, tac-atc.ca"),
        ("taller wall", 262.0, UNCONFIRMED),
    ),
    "TL-6": (("MwRSF, 62 in wall", 300.0, "MASH TL-6 evaluation, rosap.ntl.bts.gov/view/dot/77847"),),
}
"""Further forces by test level: name, force [kip] and source."""


@dataclass(frozen=True)
class DesignForce:
    """Transverse force on a railing and its source.

    kip: as published [kip].
    """

    name: str
    kip: float
    source: str

    @property
    def force(self) -> float:
        """Transverse force [N]."""
        return self.kip * KIP


def design_forces(test_level: str) -> Sequence[DesignForce]:
    """Return the design forces of a test level, AASHTO's first.

    test_level: "TL-1" to "TL-6", otherwise ValueError.
    """
    if test_level not in LRFD:
        raise ValueError(f"test level {test_level!r}: must be one of {', '.join(LRFD)}")
    rows = (("AASHTO LRFD", LRFD[test_level], AASHTO), *TALLER.get(test_level, ()))
    return [DesignForce(*row) for row in rows]
