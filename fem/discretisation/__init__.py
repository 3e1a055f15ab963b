"""Space: the plate as the time loop takes it, from a mesh and its properties.

`properties` says what a model is made from and what is wrong where none can be made, `element_kinds` and `lumpings`
register the elements and the ways to lump the mass, `elements` draws tables from scikit-fem, `mass` has nodal masses of
the exact inertia, `stiffness` is assembled, `unit_plate` has them for a modulus of 1 Pa, `spectrum` finds the largest
stable step, `windows` one of large uniform plates, `model` puts them together, `impact_model` for a whole impact,
`wall_model` finds the modes of a wall that gives, and `fields` carries results to nodes for pictures.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "element_kinds": "ELEMENT_KINDS ElementKind",
        "lumpings": "LUMPINGS Lumping",
        "model": "PlateModel build_model",
        "properties": "CornerProperties ModelError PlateProperties StepProperties",
    },
)
