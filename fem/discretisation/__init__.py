"""Space: element tables from scikit-fem, masses, the plate as the time loop takes it, its largest stable step."""
