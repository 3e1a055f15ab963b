"""Many whole impacts at once, for studies: leapfrog steps, strikes counted on the way, and `solve_impacts`."""

from solver.impact.many.solve import Impacts, solve_impacts

__all__ = ["Impacts", "solve_impacts"]
