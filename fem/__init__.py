"""The finite-element plate, with elements by scikit-fem and a compiled time loop.

The package depends neither on the rigid-body solution with which it is compared, nor on scene files. A model is built
from a mesh and three records of properties (`build_model`), and runs from a `RigidStart` to the tail-slap
(`simulate`). Extensions are registered as one object each: `FRICTION_LAWS` and `CONSTRAINTS` of the corner,
`MATERIALS`, `ELEMENT_KINDS`, `LUMPINGS` of the mass, `START_KINDS`, `COLUMNS` of the history and `IMPACT_COLUMNS` of
that of a whole impact. Neither these registries nor the packages import SciPy before a name needs them.
"""

from fem.lazy import lazy_names

__all__, __getattr__, __dir__ = lazy_names(
    __name__,
    {
        "laws.materials": "MATERIALS Material",
        "laws.constraints": "CONSTRAINTS Constraint",
        "laws.friction": "FRICTION_LAWS FrictionLaw",
        "model.plate_model": "PlateModel build_model",
        "plate.kinds": "ELEMENT_KINDS LUMPINGS ElementKind Lumping",
        "plate.properties": "CornerProperties ModelError PlateProperties RigidStart StepProperties",
        "explicit.columns": "COLUMNS IMPACT_COLUMNS HistoryColumn",
        "run.corner": "Run simulate",
        "start.start_kinds": "START_KINDS StartKind",
    },
)
