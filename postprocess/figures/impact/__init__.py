"""Figures of a whole impact: positions along the wall, forces, energies, crush, contact along the side, animation."""
