"""The plate by a few modes: `model` in a frame that floats with it, what kinds its modes are, its `motion` and
the implicit steps to the tail-slap.
"""
