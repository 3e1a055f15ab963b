"""The plate by a few modes: `model` in a frame that floats with it, its `motion`, the implicit `steps` to the
tail-slap, and what kinds its modes are (`mode_kinds`).
"""
