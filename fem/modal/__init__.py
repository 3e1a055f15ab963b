"""Free modes, beams to compare them with, and the modal model in a floating frame (docs/modal.md).

`modes` and `mode_kinds` find modes of the free plate and tell their kinds, `beam_theory` the frequencies of beams.
`modal_model` keeps a few modes and the flexibility of the rest, `modal_motion` has the equations of motion,
`modal_steps` Gauss steps, and `modal_run` the run.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "modal_model": "ModalPlate modal_plate",
        "modes": "FreeModes free_modes",
    },
)
