"""The paper's constrained corner, rigid and by finite elements."""
