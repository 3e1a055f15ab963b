"""Study `cost` of error and run time."""

from tailslap.studies.study import Study, later

STUDY = Study(
    name="cost",
    summary="Error and run time of all methods and settings.\n\nIt resumes after an interruption.",
    compute=later("tailslap.studies.cost.cost_study:compute"),
    report=later("tailslap.studies.cost.cost_report:report"),
)
