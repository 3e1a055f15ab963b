"""Vehicle in space of a scene with [body]."""
