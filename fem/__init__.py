"""The finite-element plate: scikit-fem supplies elements, quadrature and matrices; the time loop is compiled.

The package stands alone: it knows neither the rigid-body solution that it is compared with nor scene files. A model
comes from a mesh and three records of properties (`build_model`); from a `RigidStart` it runs to the tail-slap
(`simulate`). What can be added from outside, each as one registered object: `FRICTION_LAWS` and `CONSTRAINTS` of the
corner, `MATERIALS`, `ELEMENT_KINDS`, `LUMPINGS` of the mass, `START_KINDS`, `COLUMNS` of the history. These registries,
and the packages themselves, load neither Numba nor SciPy: what does is loaded with the first name that needs it.
"""

from fem.lazy import lazily

__all__, __getattr__, __dir__ = lazily(
    __name__,
    {
        "laws.materials": "MATERIALS Material",
        "laws.constraints": "CONSTRAINTS Constraint",
        "laws.friction": "FRICTION_LAWS FrictionLaw",
        "model.plate_model": "PlateModel build_model",
        "plate.kinds": "ELEMENT_KINDS LUMPINGS ElementKind Lumping",
        "plate.properties": "CornerProperties ModelError PlateProperties RigidStart StepProperties",
        "explicit.columns": "COLUMNS HistoryColumn",
        "run.corner": "Run simulate",
        "start.start_kinds": "START_KINDS StartKind",
    },
)
