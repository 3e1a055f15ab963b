"""Study `parapet` of the strength over the load."""

from tailslap.studies.study import Study, later

STUDY = Study(
    name="parapet",
    summary="Strength and force over height, length and place of the load.",
    compute=later("tailslap.studies.parapet.parapet_study:compute"),
    report=later("tailslap.studies.parapet.parapet_study:report"),
    needs_plate=False,
    folder=lambda options: "parapet-study",
)
