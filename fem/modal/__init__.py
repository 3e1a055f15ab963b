"""The plate by a few modes.

`modal_model` is the model in a floating frame and its run to the tail-slap, `motion` its accelerations, and
`collocation` its implicit steps. `mode_kinds` classifies modes, and `beams` has the frequencies of beams for
comparison.
"""
