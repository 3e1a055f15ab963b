"""Forces that railings are designed for, by test level, and what else is said of the same load. Data."""

from collections.abc import Sequence
from dataclasses import dataclass

KIP, FOOT = 4448.2216152605, 0.3048
"""[N], [m]"""

LEVELS = tuple(f"TL-{number}" for number in range(1, 7))


@dataclass(frozen=True)
class DesignForce:
    """A transverse force for a test level [kip], as given, and its source.

    longitudinal: force along the rail [kip]; length: of rail over which both are spread [ft]; None: not given. where:
    the rails that it is meant for.
    """

    test_level: str
    name: str
    kip: float
    source: str
    longitudinal: float | None = None
    length: float | None = None
    where: str = ""

    @property
    def force(self) -> float:
        """Transverse force [N]."""
        return self.kip * KIP

    @property
    def longitudinal_force(self) -> float | None:
        """Force along the rail [N]."""
        return None if self.longitudinal is None else self.longitudinal * KIP

    @property
    def length_m(self) -> float | None:
        """Length over which the forces are spread [m]."""
        return None if self.length is None else self.length * FOOT


AASHTO = "AASHTO LRFD Bridge Design Specifications, Table A13.2-1; whether later editions changed it is not confirmed"
LRFD = tuple(
    DesignForce(level, "AASHTO LRFD", transverse, AASHTO, longitudinal, length)
    for level, transverse, longitudinal, length in zip(
        LEVELS,
        (13.5, 27.0, 54.0, 54.0, 124.0, 175.0),
        (4.5, 9.0, 18.0, 18.0, 41.0, 58.0),
        (4.0, 4.0, 4.0, 3.5, 8.0, 8.0),
        strict=True,
    )
)
MASH = (
    DesignForce(
        "TL-4",
        "MASH, TTI",
        80.0,
        "Sheikh, Bligh and Menges, Determination of minimum height and lateral design load for MASH test level 4 "
        "bridge rails, Texas Transportation Institute, Report 9-1002-5 (2011)",
        where="rails of 36 in. or higher",
    ),
    DesignForce(
        "TL-4",
        "MASH, 4.5 g",
        22.05 * 4.5,
        "NCHRP Web-Only Document 326, Eq. 3-4: 22 050 lb times 4.5 g",
    ),
)


def design_forces(test_level: str) -> Sequence[DesignForce]:
    """Forces for "TL-1" to "TL-6", AASHTO's first. ValueError for another level."""
    if test_level not in LEVELS:
        raise ValueError(f"test level {test_level!r}: must be one of {', '.join(LEVELS)}")
    return tuple(row for row in (*LRFD, *MASH) if row.test_level == test_level)
