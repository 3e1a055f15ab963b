"""The study `cost`: error against run time of every method and setting, and the cheapest for each error."""

from tailslap.case.case import CORNER, WHOLE_IMPACT
from tailslap.studies.study import Study, later

STUDY = Study(
    name="cost",
    summary="Error against run time, the cheapest setting for each error; goes on where it was stopped.",
    compute=later("tailslap.studies.cost.compute:compute"),
    report=later("tailslap.studies.cost.report:report"),
    analyses=(CORNER, WHOLE_IMPACT),
)
